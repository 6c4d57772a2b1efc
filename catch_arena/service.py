"""Rulebook chapter 8: the arena as the ROS 2 exercise knows it, by names and Twists in place of ranks and actions."""

from collections.abc import Mapping, Sequence
from typing import Any

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import parallel_env
from catch_arena.errors import ActionError, ConfigError, suggest
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Pose, TurtleArray, Twist
from catch_arena.scenarios import scenario as arena_config
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

AT_REST = Twist(0.0, 0.0)


class ArenaService:
    """One arena by names: `spawn`, `kill`, `alive_turtles`, `pose`, and `step`, which answers catch_turtle.

    The requests of one step are judged together, on the state before it (R5.1), whatever order they come in.

    Args:
        scenario: a name or a config, and `overrides` as for `parallel_env`; all hunters are under full control, and see
            every target, so that each alive name has a rank.
    """

    def __init__(self, scenario: str | ArenaConfig = "standard", **overrides: object) -> None:
        if "control" in overrides or "observed_targets" in overrides:
            raise ConfigError("control and observed_targets must be left to the service: full, and all of them")
        config = arena_config(scenario, **overrides)
        self._env = parallel_env(config, control="full", observed_targets=config.max_targets)
        self._appeared: set[str] = set()

    def reset(self, seed: int | None = None) -> None:
        """Begin an episode."""
        self._env.reset(seed=seed)
        self._appeared.clear()
        self._note_alive()

    @property
    def world(self) -> World:
        """The arena as it is."""
        return self._env.world()

    @property
    def over(self) -> bool:
        """Whether the episode has ended (R1.5)."""
        return not self._env.agents

    def alive_turtles(self) -> TurtleArray:
        """R8.2: the targets in spawning order."""
        return self.world.alive_turtles

    def pose(self, hunter: str) -> Pose:
        """A hunter as turtlesim publishes it."""
        return self.world.hunters[self._seat(hunter)].pose

    def spawn(self, x: float, y: float, theta: float = 0.0) -> str:
        """A target outside the timer: its name, or "" where the arena is full, as turtlesim answers."""
        name = self._env.spawn(x, y, theta)
        self._note_alive()
        return name

    def kill(self, name: str) -> bool:
        """A target leaves uncaught, and its name is unknown from then on; false where no such target is alive."""
        killed = self._env.kill(name)
        if killed:
            self._appeared.discard(name)
        return killed

    def step(
        self, cmd_vel: Mapping[str, Twist] | None = None, requests: Sequence[tuple[str, CatchTurtleRequest]] = ()
    ) -> list[Ruling]:
        """R1.4: one control period.

        Args:
            cmd_vel: Twists [m/s, rad/s] by hunter, limited as R2.5 says, at rest where none is given.
            requests: (hunter, request) in any order. After the end nothing moves, and every request is MATCH_OVER.

        Returns:
            one ruling for each request; `response` makes the service's answer of it.

        Raises:
            ActionError: for a hunter that does not exist, or a Twist that is not finite; nothing has moved then.
        """
        asked = [(self._seat(hunter), request.name) for hunter, request in requests]
        commands = {self._seat(hunter): twist for hunter, twist in (cmd_vel or {}).items()}
        rulings = self._judged_by_name(asked)
        if self.over:
            return rulings
        ranks = self._ranks(asked, rulings)
        catches = {asked[place][0]: rank for place, rank in ranks.items()}
        config = self._env.config
        actions: dict[str, Any] = {}
        for agent in self._env.agents:
            seat = self._seat(agent)
            twist = commands.get(seat, AT_REST)
            actions[agent] = {
                "cmd_vel": (
                    _part(agent, "linear_x", twist.linear_x, config.max_speed_mps),
                    _part(agent, "angular_z", twist.angular_z, config.max_turn_rate_radps),
                ),
                "catch": catches.get(seat, 0),
            }
        self._env.step(actions)
        self._note_alive()
        played = {ruling.hunter: ruling for ruling in self._env.world().rulings}
        return [played[ruling.hunter] if place in ranks else ruling for place, ruling in enumerate(rulings)]

    def _judged_by_name(self, asked: Sequence[tuple[int, object]]) -> list[Ruling]:
        """What the names alone decide; the arena decides on those that are alive, with its own faults and lots."""
        world = self._env.world()
        alive = {target.name: (target.x, target.y) for target in world.targets}
        return arbitrate(
            hunters=[(hunter.x, hunter.y) for hunter in world.hunters],
            targets=alive,
            requests=asked,
            reach_m=self._env.config.reach_m,
            policy=self._env.config.policy,
            step=world.step,
            caught=self._appeared - alive.keys(),
            inactive=[seat for seat, hunter in enumerate(world.hunters) if hunter.withdrawn],
            match_over=self.over,
        )

    def _ranks(self, asked: Sequence[tuple[int, object]], rulings: Sequence[Ruling]) -> dict[int, int]:
        """By place among the requests: the ranks of the hunters' first ones, where those name an alive target."""
        ranks: dict[int, int] = {}
        seen: set[int] = set()
        for place, ((seat, name), ruling) in enumerate(zip(asked, rulings, strict=True)):
            if seat not in seen and ruling.verdict > Verdict.ALREADY_CAUGHT:
                rank = self._env.rank_of(seat, str(name))
                if rank:
                    ranks[place] = rank
            seen.add(seat)
        return ranks

    def _note_alive(self) -> None:
        self._appeared.update(target.name for target in self._env.world().targets)

    def _seat(self, hunter: str) -> int:
        names = self._env.config.hunter_names
        if hunter not in names:
            raise ActionError(f"unknown hunter {hunter!r}: {suggest(hunter, names)}")
        return names.index(hunter)


def response(ruling: Ruling) -> CatchTurtleResponse:
    """R5.2: what catch_turtle answers."""
    return CatchTurtleResponse(ruling.success)


def _part(agent: str, field: str, velocity: float, limit: float) -> float:
    if not -1e300 < velocity < 1e300:
        raise ActionError(f"{agent}: {field} must be a finite number, got {velocity!r}")
    return max(-1.0, min(1.0, velocity / limit))

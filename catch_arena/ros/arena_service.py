"""Rulebook chapter 8: the arena with the interface of the ROS 2 exercise: names and Twists.

`nodes` plays on it; it needs no ROS.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.arbitration import requested_target, rulings_of
from catch_arena.config import MAX_HEADING_RAD, ArenaConfig, Control
from catch_arena.core.arbiter import REQUEST_COLUMNS, REQUEST_SEAT, REQUEST_TARGET, RequestTable
from catch_arena.engine import Engine
from catch_arena.engine.episode_seeds import episode_seed
from catch_arena.errors import ActionError, ConfigError, EpisodeError, suggest
from catch_arena.messages import CatchTurtleRequest, Pose, TurtleArray, Twist
from catch_arena.plain import real_number
from catch_arena.replay import Recorder, Replay
from catch_arena.replay.named_requests import RequestBudget
from catch_arena.scenarios import scenario as arena_config
from catch_arena.text import shortened
from catch_arena.verdicts import Ruling
from catch_arena.world import World


class ArenaService:
    """One arena with names: `spawn`, `kill`, `alive_turtles`, `pose`, and `step`, which answers catch_turtle.

    The requests of one step are judged together, on the state before it (R5.1), in whatever order they come. The
    arena's own arbiter judges them, with its faults and lots, and granted requests score. Prey stands still.

    Args:
        scenario: a scenario's name or a config; observations have every target within view.
        control: the control of all hunters, or by seat. Full control is for ROS nodes: Twists, and requests by name.
            Under target and velocity control the hosted controller makes a hunter's requests (R4.1, R4.4).
        overrides: fields of `ArenaConfig`, as for `parallel_env`.

    Raises:
        ConfigError: for an invalid setting, and for `observed_targets`, which the service sets.
    """

    def __init__(
        self,
        scenario: str | ArenaConfig = "standard",
        *,
        control: Control | tuple[Control, ...] = "full",
        **overrides: object,
    ) -> None:
        if "observed_targets" in overrides:
            raise ConfigError("observed_targets cannot be set: ArenaService sets it to max_targets; leave it out")
        config = arena_config(scenario, **overrides)
        self._engine = Engine(config.replace(control=control, observed_targets=config.max_targets))
        self.config: Final = self._engine.config
        """Settings of the arena, including those that the service sets."""
        self._seed: int | None = None
        self._appeared: set[str] = set()
        self._subscribers: list[Callable[[TurtleArray], object]] = []
        self._recorder = Recorder(self.config)
        self._budget = RequestBudget(self.config.hunters)

    def reset(self, seed: int | None = None) -> None:
        """Begin an episode, and publish its targets.

        Args:
            seed: a whole number in [0, 2^64). If it is None, the first episode's seed is from the operating system, and
                each further seed follows from the one before (A.5).
        """
        self._seed = episode_seed(seed, self._seed)
        self._engine.reset([self._seed])
        self._appeared = {target.name for target in self.world.targets}
        self._recorder.begin(self._seed, self._engine)
        self._budget = RequestBudget(self.config.hunters)
        self._publish(self.alive_turtles())

    def record(self, names: Sequence[str], title: str = "") -> None:
        """Record every episode from the next reset on; `names` are the players' names by seat.

        Raises:
            ConfigError: for a name or a title that is not at most 200 printable characters, and under the policy
                `capstone`, which may grant and score a name that has no rank.
        """
        if self.config.policy == "capstone":
            raise ConfigError(
                "a match under the policy capstone cannot be recorded, because its grants need no target; "
                "use the policy nearest or first_come"
            )
        self._recorder.record(names, title)

    @property
    def replay(self) -> Replay:
        """Replay of the episode so far, if `record` was called before its reset.

        Raises:
            EpisodeError: if the episode is not recorded.
        """
        if self._recorder.replay is None:
            raise EpisodeError("there is no replay: call record() and then reset()")
        return self._recorder.replay

    @property
    def is_recorded(self) -> bool:
        """True if this episode is recorded."""
        return self._recorder.replay is not None

    @property
    def requests_left_out(self) -> int:
        """Number of requests by name that the replay does not hold: each hunter has its share of 65,536 in a match."""
        return self._budget.left_out

    @property
    def seed(self) -> int:
        """Seed of the episode.

        Raises:
            EpisodeError: before the first reset.
        """
        if self._seed is None:
            raise EpisodeError("there is no seed: no episode has begun; call reset() first")
        return self._seed

    @property
    def world(self) -> World:
        """Current state of the arena.

        Raises:
            EpisodeError: before the first reset.
        """
        if self._seed is None:
            raise EpisodeError("no episode has begun; call reset() first")
        return self._engine.world()

    @property
    def over(self) -> bool:
        """R1.5: true if the episode has ended, or none has begun."""
        return self._seed is None or bool(self._engine.ends[0])

    def alive_turtles(self) -> TurtleArray:
        """R8.2: return the alive targets in spawning order."""
        return self.world.alive_turtles

    def subscribe(self, on_alive_turtles: Callable[[TurtleArray], object]) -> None:
        """Subscribe to the list of alive targets, like a subscriber of the exercise's topic.

        A step publishes the list once after its catches if a target left (R1.4), and once after its spawns if a target
        appeared. `reset` publishes it too, and so do `spawn` and `kill` if they change it.
        """
        self._subscribers.append(on_alive_turtles)

    def pose(self, hunter: str) -> Pose:
        """Return a hunter's pose as turtlesim publishes it."""
        return self.world.hunters[self._seat(hunter)].pose

    def observe(self, hunter: str) -> tuple[list[float], list[int]]:
        """R7.1, R7.2: return a hunter's observation, and the mask of its choices; it is [] under velocity control."""
        seat = self._seat(hunter)
        masked = self.config.controls[seat] != "velocity"
        return self._engine.observations[0, seat].tolist(), self._engine.masks[0, seat].tolist() if masked else []

    def targets_seen(self, hunter: str) -> list[str]:
        """R7.1: return the names of the targets that a hunter sees, by rank."""
        alive = {target.number: target.name for target in self.world.targets}
        return [alive[number] for number in self._engine.numbers_seen(self._seat(hunter))[0].tolist() if number]

    def withdraw(self, hunter: str) -> None:
        """R1.6: withdraw a hunter, which takes no further part."""
        seat = self._seat(hunter)
        if not self.world.hunters[seat].withdrawn:
            self._engine.withdraw(0, seat)
            self._recorder.withdraw(seat)

    def spawn(self, x: float, y: float, theta: float = 0.0) -> str:
        """Spawn a target outside the timer; return its name, or "" if the arena is full, as turtlesim answers.

        Raises:
            ActionError: for a place outside the arena, or a theta beyond 1000 rad.
            EpisodeError: if no episode is running, or if it is recorded.
        """
        self._require_play("spawn")
        place, turn = (0.0, self.config.side_m), (-MAX_HEADING_RAD, MAX_HEADING_RAD)
        for axis, value, (low, high) in (("x", x, place), ("y", y, place), ("theta", theta, turn)):
            number = real_number(value)
            if number is None or not low <= number <= high:
                raise ActionError(f"spawn: {axis} must lie in [{low:g}, {high:g}], got {value!r}")
        number = self._engine.spawn(0, x, y, theta)
        if not number:
            return ""
        name = self.config.target_name(number)
        self._appeared.add(name)
        self._publish(self.alive_turtles())
        return name

    def kill(self, name: str) -> bool:
        """Remove a target uncaught; its name is unknown from then on. Return false if no such target is alive, or
        if prey plays it.

        Raises:
            EpisodeError: if no episode is running, or if it is recorded.
        """
        self._require_play("kill")
        numbers = {target.name: target.number for target in self.world.targets}
        if not isinstance(name, str) or name not in numbers or not self._engine.kill(0, numbers[name]):
            return False
        self._appeared.discard(name)
        self._publish(self.alive_turtles())
        return True

    def step(
        self,
        cmd_vel: Mapping[str, Twist] | None = None,
        requests: Sequence[tuple[str, CatchTurtleRequest]] = (),
        active_targets: Mapping[str, str] | None = None,
    ) -> list[Ruling]:
        """R1.4: play one control period.

        Args:
            cmd_vel: Twists [m/s, rad/s] by hunter, limited by R2.5; a hunter without a Twist is at rest.
            requests: (hunter, request) in any order. After the end nothing moves, and every request is MATCH_OVER.
            active_targets: names of the targets that hunters under target control drive to, by hunter. A hunter without
                one holds, and so does one whose target is out of its sight (R7.5), or not in its observation.

        Returns:
            one ruling for each request; its `success` is the service's answer (R5.2). The rulings of other hunters are
            in `world.rulings`.

        Raises:
            ActionError: for an unknown hunter, a request by a hunter that is not under full control, or a Twist that is
                not finite; the arena has not changed then.
            EpisodeError: before the first reset.
        """
        before = self.world
        for field, given, values in (
            ("cmd_vel", cmd_vel, "Twists"),
            ("active_targets", active_targets, "names of targets"),
        ):
            if not isinstance(given, Mapping | None):
                raise ActionError(f"{field} must map hunters to {values}, got {shortened(given)}")
        if not isinstance(requests, Collection):
            raise ActionError(f"requests must be a sequence of (hunter, request), got {shortened(requests)}")
        calls = [(self._seat(hunter), request.name) for hunter, request in requests]
        for seat, _ in calls:
            if (control := self.config.controls[seat]) != "full":
                raise ActionError(
                    f"hunter_{seat}: a request must be of a hunter under full control, and it is under {control}"
                )
        choices, commands = self._choices(calls, active_targets or {}), self._commands(cmd_vel or {})
        # R8.4: a hunter's rank, unless it is 0, stands for its first request; the others are judged by name
        ranked = {seat: number for number, (seat, _) in reversed([*enumerate(calls)]) if choices[0, seat]}
        by_name = [call for number, call in enumerate(calls) if ranked.get(call[0]) != number]
        table = self._request_table(by_name, before)
        running = not self.over
        self._engine.step(choices, commands, requests=table)
        after = self.world
        if (replay := self._recorder.replay) is not None and running:
            kept = (self._budget.admit(replay.steps, seat, name) for seat, name in by_name)
            replay.named_requests += [request for request in kept if request is not None]
            replay.append(choices[0], commands[0], self._engine)
        self._publish_changes(before, after)
        by_seat = {ruling.hunter: ruling for ruling in after.rulings}  # of ranks, which always have one
        named = iter(rulings_of(table[self.config.hunters :], [name for _, name in by_name], before.step))
        return [by_seat[seat] if ranked.get(seat) == number else next(named) for number, (seat, _) in enumerate(calls)]

    def _choices(self, calls: Sequence[tuple[int, object]], active_targets: Mapping[str, str]) -> NDArray[np.int64]:
        """R4.1, R4.4: return the rank of each hunter's active target in this step, (1, H): the target that it drives
        to, or that it asks for first.
        """
        ranks = np.zeros((1, self.config.hunters), dtype=np.int64)
        driven_to = [(self._seat(hunter), name) for hunter, name in active_targets.items()]
        for seat, name in (*driven_to, *reversed(calls)):  # reversed, so that a hunter's first request is written last
            seen = [self.config.target_name(number) for number in self._engine.numbers_seen(seat)[0] if number]
            ranks[0, seat] = seen.index(name) + 1 if isinstance(name, str) and name in seen else 0
        return ranks

    def _request_table(self, by_name: Sequence[tuple[int, object]], before: World) -> RequestTable:
        """Return the engine's table of these requests."""
        slots = {target.name: slot for slot, target in enumerate(before.targets)}
        table = np.zeros((self.config.hunters + len(by_name), REQUEST_COLUMNS), dtype=np.int64)
        for row, (seat, name) in zip(table[self.config.hunters :], by_name, strict=True):
            row[REQUEST_SEAT], row[REQUEST_TARGET] = seat, requested_target(name, slots, self._appeared)
        return table

    def _commands(self, cmd_vel: Mapping[str, Twist]) -> NDArray[np.float32]:
        """Return Twists as fractions of the limits, (1, H + P, 2); those of prey, which has no Twists, are 0."""
        commands = np.zeros((1, self.config.hunters + self.config.prey, 2), dtype=np.float32)
        for hunter, twist in cmd_vel.items():
            seat = self._seat(hunter)
            limits = self.config.max_speeds[seat], self.config.max_turn_rates[seat]
            for place, (field, limit) in enumerate(zip(Twist._fields, limits, strict=True)):
                velocity = twist[place]
                if not -1e300 < velocity < 1e300:
                    raise ActionError(f"{hunter}: {field} must be a finite number, got {velocity!r}")
                commands[0, seat, place] = max(-1.0, min(1.0, velocity / limit))
        return commands

    def _publish_changes(self, before: World, after: World) -> None:
        """R1.4: publish the targets without those that left, and then with those that have appeared."""
        names = {target.name for target in after.targets}
        left = TurtleArray(tuple(turtle for turtle in before.alive_turtles.turtles if turtle.name in names))
        if len(left.turtles) < len(before.targets):
            self._publish(left)
        if len(after.targets) > len(left.turtles):
            self._appeared |= names
            self._publish(after.alive_turtles)

    def _publish(self, turtles: TurtleArray) -> None:
        for on_alive_turtles in self._subscribers:
            on_alive_turtles(turtles)

    def _require_play(self, call: str) -> None:
        if self.over:
            why = "no episode has begun" if self._seed is None else "the episode is over"
            raise EpisodeError(f"cannot {call}: {why}; call reset() first")
        if self.is_recorded:
            raise EpisodeError(f"cannot {call} while the episode is recorded: a replay cannot repeat this call")

    def _seat(self, hunter: str) -> int:
        names = self.config.hunter_names
        if hunter not in names:
            raise ActionError(f"unknown hunter {hunter!r}: {suggest(hunter, names)}")
        return names.index(hunter)

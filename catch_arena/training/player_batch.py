"""Batches of arenas in which every hunter and prey has a player: an agent that acts in batches, or a learner.

Here the caller seats all players, so that both sides can learn, and past selves and scripted agents can be opponents
and team-mates (examples/train_sides.py). `LearnerBatch` is built on it: it draws the opponents of its learners itself.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import ArenaConfig, Control
from catch_arena.envs.vector import VectorArena
from catch_arena.errors import ConfigError, EpisodeError
from catch_arena.policy import Limits, Side
from catch_arena.seeding import arena_seed
from catch_arena.training.players import LEARNER, Players, Rows


class PlayerBatch:
    """B arenas in lockstep with N agents each, the H hunters by seat and then the prey.

    Args:
        arena: the arenas; made with `any_control` if there are players of hunters.
        players: the players of each side, "prey" only in a scenario with prey.
    """

    def __init__(self, arena: VectorArena, players: Mapping[Side, Players]) -> None:
        self.arena: Final = arena
        self.players: Final = dict(players)
        """The players of each side, "hunter" and "prey"; `add` takes more of them, and `seat` their numbers."""
        config = arena.config
        self.control: Final[Control] = config.controls[0]
        """Control of the hunters that learn."""
        self.rng = np.random.default_rng(0)
        self.has_begun = False
        """True after the first reset; False again after a player has raised at the start of an episode."""
        self.observations = np.zeros((arena.num_envs, config.hunters + config.prey, 0), np.float32)
        """Observations of `VectorArena`, and `masks` its action masks; the next step overwrites them."""
        self.masks = np.ones((arena.num_envs, config.hunters, 0), np.int8)

    @classmethod
    def of(cls, config: ArenaConfig, num_envs: int, agents: Mapping[Side, Sequence[object]]) -> "PlayerBatch":
        """Return a batch in which learners have velocity control.

        Args:
            config: the arenas' settings; all hunters have equal limits.
            num_envs: B.
            agents: the agents of each side, see `Player.of`; their numbers are their places.

        Raises:
            ConfigError: for hunters with different limits.
            AgentError: for an agent that cannot play.
        """
        config = config.replace(control="velocity")
        if len({Limits.of(config, seat) for seat in range(config.hunters)}) > 1:
            raise ConfigError("hunters must have equal limits, and those of this scenario differ")
        sides: tuple[Side, ...] = ("hunter", "prey") if config.prey else ("hunter",)
        players = {side: Players(config, num_envs, side, "player", agents.get(side, ())) for side in sides}
        return cls(VectorArena(config, num_envs, any_control=True), players)

    @property
    def seated(self) -> NDArray[np.int64]:
        """Number of the player of each agent, or LEARNER: (B, N)."""
        return np.concatenate([players.seated for players in self.players.values()], axis=1)

    def require_begun(self, call: str) -> None:
        """Raise an EpisodeError that names the call if no episode has begun."""
        if not self.has_begun:
            raise EpisodeError(f"{call} was called before the first reset; call reset() first")

    def reset(self, seed: int | None = None, arenas: ArrayLike | None = None) -> None:
        """Begin episodes, see `VectorArena.reset`; the players stay seated.

        A seed for all arenas, and the first reset, also seed the players and `rng`.
        """
        if arenas is not None:
            self.require_begun("reset() of single arenas")
        elif seed is not None or not self.has_begun:
            seed = arena_seed(seed)
            self.rng = np.random.default_rng(seed)
            for players in self.players.values():
                players.begin(self.rng)
        self.take(*self.arena.reset(seed, arenas))

    def take(self, observations: NDArray[np.float32], infos: Mapping[str, Any]) -> None:
        """Continue from these observations and infos of the arena."""
        self.observations, self.masks = observations, infos.get("action_mask", self.masks)
        self.has_begun = True

    def seat(
        self, arenas: NDArray[np.int64], numbers: NDArray[np.int64], seats: NDArray[np.int64] | None = None
    ) -> None:
        """Give the agents of these arenas their players.

        Args:
            arenas: the arenas, (n,).
            numbers: numbers of the players, or LEARNER: (n, N), H hunters and then prey.
            seats: the hunters that the first H numbers are for, (n, H); by seat if omitted. Agents that have only `act`
                begin in this order.

        Raises:
            ConfigError: for a number that no player of that side has; all keep their players.
            AgentError: for a player that raises at its start. All arenas must then be reset and get players again.
        """
        for side, players in self.players.items():
            given, last = numbers[:, players.agents], len(players.pool) - 1
            wrong = given[(given < LEARNER) | (given > last)].tolist()
            if wrong:
                raise ConfigError(
                    f"players of {side} must be numbers from {LEARNER} (LEARNER) to {last}, got {wrong[0]}"
                )
        begun, self.has_begun = self.has_begun, False
        for side, players in self.players.items():
            players.seat(arenas, seats if side == "hunter" else None, numbers[:, players.agents], self.rng)
        if self.players["hunter"].pool:  # else all hunters learn
            self.arena.set_controls(self.players["hunter"].controls(arenas, self.control), arenas)
        self.has_begun = begun

    def rows(self, side: Side) -> Rows:
        """Return the agents of a side that the learner plays."""
        players = self.players[side]
        arenas, seats = np.nonzero(players.seated == LEARNER)
        return arenas, seats + players.agents.start

    def view(self, side: Side, rows: Rows) -> Any:
        """Return what these agents see: a `BatchView` of hunters or a `PreyBatchView`."""
        self.require_begun("view()")
        return self.players[side].view(self.observations, self.masks, rows, self.control)

    def step(
        self, commands: NDArray[np.float32], choices: NDArray[np.int64] | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Play a step.

        Args:
            commands: speed and turn rate of the learners, (B, N, 2) in [-1, 1]. Those of the players are written here,
                over legal ones, such as zeros.
            choices: choices of the learners, (B, H), for target and full control; those of the players are written
                here, over legal ones. Zeros if omitted.

        Returns:
            rewards (B, N), terminations (B,), truncations (B,) and infos, as from `VectorArena.step`.

        Raises:
            ActionError: for an action of a learner that is not legal; nothing has moved then.
            AgentError: for a player that raises, or whose action is not legal; nothing has moved then.
            EpisodeError: before the first reset.
        """
        self.require_begun("step()")
        if choices is None:
            choices = np.zeros((self.arena.num_envs, self.arena.num_hunters), np.int64)
        sides = [players for players in self.players.values() if players.pool]
        if sides:
            self.arena.check_actions(choices, commands)  # before the agents act: they cannot undo it
        for players in sides:
            players.act(self.observations, self.masks, choices, commands)
        observations, rewards, terminations, truncations, infos = self.arena.step(choices, commands)
        self.take(observations, infos)
        return rewards, terminations, truncations, infos


def play_matches(
    config: ArenaConfig, agents: Mapping[Side, Sequence[object]], seated: NDArray[np.int64], seed: int
) -> dict[str, NDArray[np.float64]]:
    """Play one match in each of M arenas.

    Args:
        config: the settings.
        agents: the agents of each side, see `PlayerBatch.of`.
        seated: number of the player of each agent: (M, N).
        seed: the seed from which the seeds of the matches follow.

    Returns:
        `score` and `team_score` (M, H), `rank` (M, N), and with prey `times_caught` (M, P), as in `VectorArena`.

    Raises:
        ConfigError, AgentError: see `PlayerBatch`.
    """
    batch = PlayerBatch.of(config, len(seated), agents)
    batch.reset(seed)
    batch.seat(np.arange(len(seated)), seated)
    over, found = np.zeros(len(seated), np.bool_), dict[str, NDArray[np.float64]]()
    while not over.all():  # an arena that ends begins another match, which does not count
        _, terminations, truncations, infos = batch.step(np.zeros((*seated.shape, 2), np.float32))
        ended = terminations | truncations
        for name in {"score", "team_score", "rank", "times_caught"} & infos["episode"].keys():
            table = infos["episode"][name]
            found.setdefault(name, np.zeros(table.shape))[ended & ~over] = table[ended & ~over]
        over |= ended
    return found

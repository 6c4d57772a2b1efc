"""Batches of arenas in which every hunter and prey has a player: an agent that acts in batches, or a learner.

`LearnerBatch` has learners of one kind and draws their opponents. Here the caller seats all players, so that both sides
can learn, and past selves and scripted agents can be opponents and team-mates (examples/train_sides.py).
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import ArenaConfig
from catch_arena.envs.vector import VectorArena
from catch_arena.errors import ConfigError, EpisodeError
from catch_arena.policy import Limits, Side
from catch_arena.training.players import LEARNER, Players, Rows


class MixedBatch:
    """B arenas in lockstep with N agents each, the H hunters by seat and then the prey.

    Args:
        config: the arenas' settings; all hunters have equal limits.
        num_envs: B.
        players: the agents of each side, see `Player.of`.

    Raises:
        ConfigError: for hunters with different limits.
        AgentError: for an agent that cannot play.
    """

    def __init__(self, config: ArenaConfig, num_envs: int, players: Mapping[Side, Sequence[object]]) -> None:
        if len({Limits.of(config, seat) for seat in range(config.hunters)}) > 1:
            raise ConfigError("hunters must have equal limits, and those of this scenario differ")
        self.config: Final = config
        self.arena: Final = VectorArena(config, num_envs, any_control=True)
        self.players: Final[dict[Side, Players]] = {}
        """The players of each side, "hunter" and "prey"; `add` takes more of them, and `seat` their numbers."""
        sides: tuple[Side, ...] = ("hunter", "prey") if config.prey else ("hunter",)
        for side in sides:
            self.players[side] = Players(config, num_envs, side, "player", players.get(side, ()))
        self._rng = np.random.default_rng()
        self.observations, self.infos = np.zeros((0, 0, 0), np.float32), dict[str, Any]()
        """Observations and infos of `VectorArena`; the next step overwrites them."""

    @property
    def seated(self) -> NDArray[np.int64]:
        """Number of the player of each agent, or LEARNER: (B, N)."""
        return np.concatenate([players.seated for players in self.players.values()], axis=1)

    def reset(self, seed: int | None = None, arenas: ArrayLike | None = None) -> None:
        """Begin episodes, see `VectorArena.reset`; the players stay seated."""
        is_first = not self.infos
        self.observations, self.infos = self.arena.reset(seed, arenas)
        if seed is not None or is_first:
            self._rng = np.random.default_rng(seed)
            for players in self.players.values():
                players.begin(self._rng)

    def seat(self, arenas: NDArray[np.int64], numbers: NDArray[np.int64]) -> None:
        """Give the agents of these arenas (n,) their players, by number or LEARNER: (n, N).

        Raises:
            ConfigError: for a number that no player of that side has; all keep their players.
        """
        for side, players in self.players.items():
            given, last = numbers[:, players.agents], len(players.pool) - 1
            wrong = given[(given < LEARNER) | (given > last)].tolist()
            if wrong:
                raise ConfigError(
                    f"players of {side} must be numbers from {LEARNER} (LEARNER) to {last}, got {wrong[0]}"
                )
        for players in self.players.values():
            players.seat(arenas, None, numbers[:, players.agents], self._rng)
        self.arena.set_controls(self.players["hunter"].controls(arenas, "velocity"), arenas)

    def rows(self, side: Side) -> Rows:
        """Return the agents of a side that the learner plays."""
        players = self.players[side]
        arenas, seats = np.nonzero(players.seated == LEARNER)
        return arenas, seats + players.agents.start

    def view(self, side: Side, rows: Rows) -> Any:
        """Return what these agents see if they drive themselves: a `BatchView` of hunters or a `PreyBatchView`."""
        return self.players[side].view(self.observations, self._masks, rows, "velocity")

    @property
    def _masks(self) -> NDArray[np.int8]:
        if not self.infos:
            raise EpisodeError("no episode has begun; call reset() first")
        masks: NDArray[np.int8] = self.infos["action_mask"]
        return masks

    def step(self, commands: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Play a step.

        Args:
            commands: speed and turn rate of the learners, (B, N, 2) in [-1, 1]; those of the players are written here.

        Returns:
            rewards (B, N), and whether an arena's episode ended (B,); `infos` has its figures, and the next one began.

        Raises:
            AgentError: for a player that raises, or whose action is not legal.
            EpisodeError: before the first reset.
        """
        choices = np.zeros((len(commands), self.config.hunters), np.int64)
        for players in self.players.values():
            players.act(self.observations, self._masks, choices, commands)
        self.observations, rewards, terminations, truncations, self.infos = self.arena.step(choices, commands)
        return rewards, terminations | truncations


def play_matches(
    config: ArenaConfig, players: Mapping[Side, Sequence[object]], seated: NDArray[np.int64], seed: int
) -> dict[str, NDArray[np.float64]]:
    """Play one match in each of M arenas.

    Args:
        config: the settings.
        players: see `MixedBatch`.
        seated: number of the player of each agent: (M, N).
        seed: the seed from which the seeds of the matches follow.

    Returns:
        `score` and `team_score` (M, H), `rank` (M, N), and with prey `times_caught` (M, P), as in `VectorArena`.

    Raises:
        ConfigError, AgentError: see `MixedBatch`.
    """
    batch = MixedBatch(config, len(seated), players)
    batch.reset(seed)
    batch.seat(np.arange(len(seated)), seated)
    over, found = np.zeros(len(seated), np.bool_), dict[str, NDArray[np.float64]]()
    while not over.all():  # an arena that ends begins another match, which does not count
        _, ended = batch.step(np.zeros((*seated.shape, 2), np.float32))
        for name in {"score", "team_score", "rank", "times_caught"} & batch.infos["episode"].keys():
            table = batch.infos["episode"][name]
            found.setdefault(name, np.zeros(table.shape))[ended & ~over] = table[ended & ~over]
        over |= ended
    return found

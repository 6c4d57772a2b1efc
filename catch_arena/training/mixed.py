"""Batches of arenas in which every hunter and prey has a player: an agent that acts in batches, or a learner.

`LearnerBatch` has learners of one kind and draws their opponents. Here the caller seats all players, so that both sides
can learn, and past selves and scripted agents can be opponents and team-mates (examples/train_sides.py).
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.batch_policy import BatchView, PreyBatchView
from catch_arena.config import ArenaConfig, Control
from catch_arena.core.controllers import CONTROLS
from catch_arena.envs.vector import VectorArena
from catch_arena.errors import ConfigError
from catch_arena.layout import observation_size, prey_observation_size
from catch_arena.policy import Limits, PreyLimits, Side, control_of
from catch_arena.training.players import Player, acts_in_batches, name_and_policy

LEARNER: Final = -1
"""Number, in place of a player's, of an agent whose commands the caller gives."""

Rows = tuple[NDArray[np.int64], NDArray[np.int64]]
"""Arenas and agents, (n,) each; agents are the hunters by seat, then the prey."""


class BatchPlayer(NamedTuple):
    """An agent that acts for many hunters, or for many prey, in one call."""

    player: Player
    control: Control

    @classmethod
    def of(cls, agent: object, side: Side) -> "BatchPlayer":
        """Return the player of an agent: a shipped name, a file, `package.module:Class`, a class or an object.

        Raises:
            AgentError: for an agent that cannot play.
            ConfigError: for one without `act_batch`.
        """
        name, policy = name_and_policy("player", agent, side)
        if not acts_in_batches(policy):
            raise ConfigError(f"player {name} must have act_batch, which acts for many in one call; it has only act")
        player = Player(f"player {name}", policy)
        player.call("reset", 0)
        return cls(player, "velocity" if side == "prey" else control_of(policy))


class MixedBatch:
    """B arenas in lockstep with N agents each, the H hunters by seat and then the prey.

    Args:
        config: the arenas' settings; all hunters have equal limits.
        num_envs: B.
        players: the agents of each side, see `BatchPlayer.of`. The lists in `self.players` may be changed.

    Raises:
        ConfigError: for hunters with different limits, and for an agent without `act_batch`.
        AgentError: for an agent that cannot play.
    """

    def __init__(self, config: ArenaConfig, num_envs: int, players: Mapping[Side, Sequence[object]]) -> None:
        limits, *others = {Limits.of(config, seat) for seat in range(config.hunters)}
        if others:
            raise ConfigError("hunters must have equal limits, and those of this scenario differ")
        self.config: Final = config
        self.arena: Final = VectorArena(config, num_envs, any_control=True)
        self.players: Final = {side: [BatchPlayer.of(one, side) for one in agents] for side, agents in players.items()}
        """The players of each side, "hunter" and "prey"; `seat` takes their numbers."""
        self.seated: Final = np.full((num_envs, config.hunters + config.prey), LEARNER)
        """Number of the player of each agent, or LEARNER: (B, N)."""
        self._limits = {word: dataclasses.replace(limits, control=word) for word in get_args(Control)}
        self._prey_limits = PreyLimits.of(config) if config.prey else None
        self._size, self._prey_size = observation_size(config), prey_observation_size(config)
        self._last_rank = config.targets_seen
        self.observations, self.infos = np.zeros((0, 0, 0), np.float32), dict[str, Any]()
        """Observations and infos of `VectorArena`; the next step overwrites them."""

    def agents(self, side: Side) -> slice:
        """Return the agents of a side, as a slice."""
        return slice(0, self.config.hunters) if side == "hunter" else slice(self.config.hunters, None)

    def reset(self, seed: int | None = None, arenas: ArrayLike | None = None) -> None:
        """Begin episodes, see `VectorArena.reset`; the players stay seated."""
        self.observations, self.infos = self.arena.reset(seed, arenas)

    def seat(self, arenas: NDArray[np.int64], numbers: NDArray[np.int64]) -> None:
        """Give the agents of these arenas (n,) their players, by number or LEARNER: (n, N)."""
        self.seated[arenas] = numbers
        controls = ["velocity", *(one.control for one in self.players["hunter"])]
        codes = np.array([CONTROLS[control] for control in controls], np.int8)
        self.arena.set_controls(codes[numbers[:, : self.config.hunters] + 1], arenas)

    def rows(self, side: Side, number: int = LEARNER) -> Rows:
        """Return the agents of a side that a player, or the learner, plays."""
        part = self.agents(side)
        arenas, agents = np.nonzero(self.seated[:, part] == number)
        return arenas, agents + part.start

    def view(self, side: Side, rows: Rows, control: Control = "velocity") -> Any:
        """Return what these agents see: a `BatchView` of hunters or a `PreyBatchView`."""
        seen = self.observations[rows]
        if self._prey_limits is not None and side == "prey":
            return PreyBatchView(seen[:, : self._prey_size], self._prey_limits)
        return BatchView(seen[:, : self._size], self.infos["action_mask"][rows], self._limits[control])

    def step(self, commands: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Play a step.

        Args:
            commands: speed and turn rate of the learners, (B, N, 2) in [-1, 1]; those of the players are written here.

        Returns:
            rewards (B, N), and whether an arena's episode ended (B,); `infos` has its figures, and the next one began.

        Raises:
            AgentError: for a player that raises, or whose action is not legal.
        """
        choices = np.zeros((len(commands), self.config.hunters), np.int64)
        for side, players in self.players.items():
            for number, (player, control) in enumerate(players):
                rows = self.rows(side, number)
                if len(rows[0]):
                    ranks, velocities = player.act_batch(
                        self.view(side, rows, control), control, self._last_rank, lambda _: ""
                    )
                    if ranks is not None:
                        choices[rows] = ranks
                    if velocities is not None:
                        commands[rows] = velocities
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

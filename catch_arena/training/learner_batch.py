"""Batches of arenas in which some seats learn: a row for each learner, and arrays that are copies.

The adapters for training libraries are built on this module, and this one on `PlayerBatch`.
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import ArenaConfig, require_flag, require_integer
from catch_arena.engine import SavedState
from catch_arena.envs.actions import clipped
from catch_arena.envs.vector import VectorArena
from catch_arena.equality import EqualByBits
from catch_arena.errors import ConfigError
from catch_arena.layout import Column, columns
from catch_arena.policy import Side
from catch_arena.scenarios import scenario as arena_config
from catch_arena.text import shortened
from catch_arena.tournament.entrants import SHIPPED_PREY
from catch_arena.training.opponents import Opponents, Pool
from catch_arena.training.player_batch import PlayerBatch
from catch_arena.training.players import LEARNER, Players, Rows, action_arrays


class LearnerStep(NamedTuple):
    """Results of one step for the N learners; every array is a copy."""

    observations: NDArray[np.float32]
    """Observations, (N, D); with auto_reset, rows whose episode ended have the first one of the next episode."""
    masks: NDArray[np.bool_]
    """Legal choices, (N, K + 1); (N, 0) under velocity control."""
    rewards: NDArray[np.float32]
    """Rewards, (N,)."""
    terminations: NDArray[np.bool_]
    """Rows whose episode was terminated, (N,)."""
    truncations: NDArray[np.bool_]
    """Rows whose episode was truncated, (N,): the value of their last observation still counts."""
    ended: NDArray[np.int64]
    """Numbers of the rows whose episode ended in this step, (E,)."""
    final_observations: NDArray[np.float32]
    """Last observations of the rows in `ended`, (E, D)."""
    final_masks: NDArray[np.bool_]
    """Last masks of the rows in `ended`, (E, K + 1); (E, 0) under velocity control."""
    figures: dict[str, NDArray[np.float32]]
    """Figures of the ended episodes, as in `VectorArena` (`length`, `return`, `score`, `rank`, ...): (E,) or (E, 12).

    With opponents also `opponents`, their indices in `opponents.names`, and `opponent_scores`, by seat: (E, S). Empty
    without auto_reset.
    """


@dataclass(frozen=True, slots=True, eq=False)
class SavedLearners(EqualByBits):
    """Saved state of a `LearnerBatch`, from its `save`; it can be pickled, and any number can be kept.

    Two are equal if every bit is equal. Agents are compared by their own `==`; without one they equal only themselves.
    """

    arena: SavedState
    players: tuple[Mapping[str, Any], ...]
    """States of the opponents, none if all learn, and of the prey if there is some."""
    seats: NDArray[np.int64]
    """Seats of the learners, (B, learners)."""
    rng: Mapping[str, Any]
    """State of the random generator."""


class LearnerBatch:
    """B arenas in lockstep, in each of which some seats learn and opponents play the others.

    A row is one learner: N = B * learners, arena by arena. In each episode the learners move on by a seat, and every
    other seat draws a new opponent. Learners are hunters; prey is played by an agent.

    Args:
        scenario: a name or a config.
        num_envs: B, the number of arenas.
        opponents: see `Opponents`: an agent, several, or names with weights. None: all seats learn.
        learners: number of seats of an arena that learn, if there are opponents.
        distinct: whether no opponent is drawn twice in an arena, as in a tournament, if there are enough of them.
        prey_agent: the agent that plays prey: a shipped name, a file, `package.module:Class`, a class, or an object
            with `act_batch` or `act`. None: `flee`.
        normalise: divide each column by its largest magnitude, so that it lies in [-1, 1]; absent values stay 0.
        num_threads: number of threads.
        auto_reset: whether an ended episode is followed by the next one in the same step.
        overrides: fields of ArenaConfig.

    Raises:
        ConfigError: for an argument that is not allowed.
        AgentError: for an opponent that cannot play, or one that cannot play prey.
    """

    def __init__(
        self,
        scenario: str | ArenaConfig = "standard",
        num_envs: int = 1,
        *,
        opponents: Pool | None = None,
        learners: int = 1,
        distinct: bool = False,
        prey_agent: object | None = None,
        normalise: bool = False,
        num_threads: int = 1,
        auto_reset: bool = True,
        **overrides: object,
    ) -> None:
        config = arena_config(scenario, **overrides)
        self.config: Final = config
        normalise, distinct = require_flag("normalise", normalise), require_flag("distinct", distinct)
        if len(set(config.controls)) > 1:
            raise ConfigError(f"control must be one word, for all learners, got {config.control!r}")
        if prey_agent is not None and not config.prey:
            raise ConfigError(f"prey_agent must be None in a scenario without prey, got {prey_agent}")
        max_learners = config.hunters - (opponents is not None)
        if not max_learners:
            raise ConfigError("hunters must be at least 2 if there are opponents, got 1")
        learning = require_integer("learners", learners, 1, max_learners)
        self.learners: Final = config.hunters if opponents is None else learning
        self.arena: Final = VectorArena(
            config, num_envs, num_threads, auto_reset=auto_reset, any_control=opponents is not None
        )
        self.num_envs: Final = self.arena.num_envs
        self.num_rows: Final = self.num_envs * self.learners
        self.opponents: Final = (
            None if opponents is None else Opponents(config, self.num_envs, opponents, distinct=distinct)
        )
        """The opponents, or None; `add` and `weigh` change the pool for the episodes that begin after the call."""
        hunters = self.opponents or Players(config, self.num_envs, "hunter", "opponent", ())
        players: dict[Side, Players] = {"hunter": hunters}
        if config.prey:
            agent = SHIPPED_PREY if prey_agent is None else prey_agent
            players["prey"] = Players(config, self.num_envs, "prey", "prey", [agent])
        self._batch: Final = PlayerBatch(self.arena, players)
        self._control: Final = config.controls[0]
        self.action_space: Final = self.arena.action_space()
        self.columns: Final[tuple[Column, ...]] = columns(config)
        self.scale: NDArray[np.float32] | None = None
        """Divisor of each column, (D,); None without `normalise`."""
        self.observation_space = self.arena.observation_space()
        if normalise:
            low, high = self.observation_space.low, self.observation_space.high
            largest = np.maximum(np.abs(low), np.abs(high))
            self.scale = np.where(largest > 0, largest, 1).astype(np.float32)
            self.observation_space = spaces.Box(low / self.scale, high / self.scale, dtype=np.float32)
        self._choices = np.zeros((self.num_envs, config.hunters), np.int64)
        self._commands = np.zeros((self.num_envs, config.hunters + config.prey, 2), np.float32)
        self._arenas: Final = np.repeat(np.arange(self.num_envs), self.learners)
        self._seats = np.tile(np.arange(self.learners), (self.num_envs, 1))

    @property
    def seats(self) -> NDArray[np.int64]:
        """Seats of the learners in the running episodes, (B, learners)."""
        return self._seats.copy()

    @property
    def masks(self) -> NDArray[np.bool_]:
        """Choices that are legal now, (N, K + 1); (N, 0) under velocity control."""
        return self._legal(self._batch.masks, self._rows)

    def close(self) -> None:
        """Do nothing: the batch holds nothing that must be released."""

    def reset(
        self, seed: int | None = None, arenas: ArrayLike | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Begin episodes.

        Args:
            seed: seed of the arenas, of the choice of opponents and of their random draws; None continues these.
            arenas: the arenas to reset, as numbers or as a (B,) mask; None resets all.

        Returns:
            the observations (N, D) and masks (N, K + 1) of all learners.
        """
        seats_restart = arenas is None and (seed is not None or not self._batch.has_begun)
        self._batch.reset(seed, arenas)
        rows = np.arange(self.num_envs)
        if seats_restart and self.opponents is not None:
            order = rows[:, None] + np.arange(self.learners)
            self._seats = (order - 1) % self.config.hunters  # they move on by a seat before they play
        self._begin(rows if arenas is None else rows[np.asarray(arenas) if np.size(arenas) else []])
        return self._normalised(self._batch.observations, self._rows), self.masks

    def step(self, actions: ArrayLike | Mapping[str, ArrayLike]) -> LearnerStep:
        """R1.4: play one step of every arena.

        Args:
            actions: actions of the N learners. Target control: (N,) whole numbers; velocity control: (N, 2) numbers in
                [-1, 1]; full control: {"cmd_vel": (N, 2), "catch": (N,)}.

        Raises:
            ActionError: for an action that is not legal; nothing has moved then.
            AgentError: for an opponent or prey that raised, or whose action is not legal; nothing has moved then. If
                it raised at the start of a new episode, all arenas must be reset.
            EpisodeError: before the first reset.
        """
        self._batch.require_begun("step()")
        self._place(actions)
        arenas, seats = self._rows
        rewards, terminations, truncations, infos = self._batch.step(self._commands, self._choices)
        over = terminations | truncations
        ended = np.flatnonzero(over[arenas])
        last = arenas[ended], seats[ended]
        final = self._normalised(infos.get("final_obs", self._batch.observations), last)
        final_masks = self._legal(infos.get("final_mask", self._batch.masks), last)
        figures: dict[str, NDArray[np.float32]] = {}
        if len(ended) and self.arena.auto_reset:
            episode = infos["episode"]
            figures = {name: table[last] for name, table in episode.items() if name != "times_caught"}
            if self.opponents is not None:
                seated = self.opponents.seated[last[0]]
                for name, table in (("opponents", seated), ("opponent_scores", episode["score"][last[0]])):
                    figures[name] = table[seated != LEARNER].reshape(len(ended), -1)
            self._begin(np.flatnonzero(over))
        return LearnerStep(
            self._normalised(self._batch.observations, self._rows),
            self.masks,
            rewards[arenas, seats],
            terminations[arenas],
            truncations[arenas],
            ended,
            final,
            final_masks,
            figures,
        )

    def save(self) -> SavedLearners:
        """R10.2: return a copy of all arenas, opponents, prey and random generators, for `restore`.

        `restore` accepts it in this batch, and in a batch with the same arguments. It has everything that agents store
        in themselves, and nothing that they store elsewhere.

        Raises:
            AgentError: if an agent cannot be copied; it names the agent.
            EpisodeError: before the first reset.
        """
        self._batch.require_begun("save()")
        return SavedLearners(
            arena=self.arena.save(),
            players=tuple(players.save() for players in self._batch.players.values()),
            seats=self.seats,
            rng=self._batch.rng.bit_generator.state,
        )

    def restore(self, saved: SavedLearners) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Continue from a saved state, bit for bit, with the pool of that time.

        Returns:
            observations and masks, as `reset` does.

        Raises:
            ConfigError: if `saved` is not from a batch with an equal config and as many arenas and learners.
        """
        if not isinstance(saved, SavedLearners):
            raise ConfigError(f"saved must be a SavedLearners from save(), got {shortened(saved)}")
        if saved.seats.shape[1] != self.learners:  # if equal, both or none have opponents
            raise ConfigError(f"saved must come from a batch with learners={self.learners}, got {saved.seats.shape[1]}")
        begun = self.arena.restore(saved.arena)
        for players, kept in zip(self._batch.players.values(), saved.players, strict=True):
            players.restore(kept)
        self._seats = saved.seats.copy()
        self._batch.rng.bit_generator.state = saved.rng
        self._batch.take(*begun)
        return self._normalised(self._batch.observations, self._rows), self.masks

    def clone(self) -> "LearnerBatch":
        """Return an independent copy of the batch in the same state; `copy.deepcopy` does the same.

        Raises:
            AgentError: if an agent cannot be copied; it names the agent.
        """
        return copy.deepcopy(self)

    @property
    def _rows(self) -> Rows:
        """Arena and seat of each learner."""
        return self._arenas, self._seats.reshape(-1)

    def _begin(self, arenas: NDArray[np.int64]) -> None:
        """Begin episodes of these arenas: move the learners on by a seat, draw opponents, and seat the prey."""
        hunters, others = self.config.hunters, self.config.hunters - self.learners
        numbers, seats = np.full((len(arenas), hunters + self.config.prey), LEARNER), None
        numbers[:, hunters:] = 0
        if self.opponents is not None:
            self._seats = self._seats.copy()
            self._seats[arenas] = own = (self._seats[arenas] + 1) % hunters
            seats = (own[:, -1:] + np.arange(1, 1 + hunters)) % hunters  # opponents, then learners
            numbers[:, :others] = self.opponents.draw(len(arenas), others, self._batch.rng)
        self._batch.seat(arenas, numbers, seats)

    def _place(self, actions: Any) -> None:
        """Write the learners' actions at their seats, and zeros at the other seats; the arena checks them."""
        choices, commands = action_arrays("actions", actions, self.num_rows, self._control)
        self._choices.fill(0)
        self._commands.fill(0)
        if choices is not None:
            self._choices[self._rows] = choices
        if commands is not None:
            self._commands[self._rows] = clipped(commands)

    def _normalised(self, observations: NDArray[np.float32], rows: Rows) -> NDArray[np.float32]:
        """Return copies of the observations of some hunters, (n, D), divided by `scale`."""
        own = observations[..., : len(self.columns)][rows]
        if self.scale is not None:
            own /= self.scale
        return own

    def _legal(self, masks: NDArray[np.int8], rows: Rows) -> NDArray[np.bool_]:
        """Return the legal choices of some hunters, (n, K + 1), or (n, 0) under velocity control."""
        if self._control == "velocity":
            return np.ones((len(rows[0]), 0), np.bool_)
        return masks[rows].astype(np.bool_)

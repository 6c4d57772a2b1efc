"""Opponents inside the batch: the agents in the seats that do not learn."""

import copy
import dataclasses
from collections.abc import Iterable, Mapping
from functools import partial
from typing import Final, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.config import ArenaConfig, Control
from catch_arena.core.controllers import CONTROLS
from catch_arena.errors import ConfigError
from catch_arena.policy import Limits, View, control_of
from catch_arena.text import shortened
from catch_arena.training.players import Player, acts_in_batches, name_and_policy

Pool = str | object | Iterable[object] | Mapping[str, float]
"""One agent, several, or a mapping from names to the weights with which they are drawn."""

Place = tuple[int, int]
"""An arena, and the seat of a hunter in it."""
_SEED_LIMIT: Final = 2**63


class _Opponent(NamedTuple):
    name: str
    player: Player
    """One instance for all hunters if it has `act_batch`; else the original that is copied for each hunter."""
    control: Control
    in_batches: bool


class SavedOpponents(NamedTuple):
    """Saved state of `Opponents`, from its `save`, with copies of the agents and of everything that they store."""

    pool: tuple[_Opponent, ...]
    instances: dict[Place, Player]
    weights: NDArray[np.float64] | None
    seated: NDArray[np.int64]
    """Agents in the seats, as `Opponents.seated`."""


class Opponents:
    """A pool of agents, from which each seat without a learner gets one in each episode.

    An agent with `act_batch` is called once a step for all hunters that it plays, and keeps nothing of a hunter; one
    that has only `act` is called for each of them, and each gets an instance of its own.

    Args:
        config: the arena's settings.
        num_envs: B.
        pool: an agent, several, or a mapping from agents' names to their weights. An agent is what a tournament takes
            (a shipped name, a file, `package.module:Class`), a class, or an object with `act_batch` or `act`.
        distinct: whether no agent is drawn twice in an arena, while as many have a weight above 0 as there are seats.

    Raises:
        ConfigError: for an empty pool, and for weights that are not allowed.
        AgentError: for an agent that cannot play.
    """

    def __init__(self, config: ArenaConfig, num_envs: int, pool: Pool, *, distinct: bool = False) -> None:
        agents, weights = _agents_and_weights(pool)
        self._pool = [_opponent(agent) for agent in agents]
        self._weights = weights
        self._distinct = distinct
        self._config = config
        limits = [Limits.of(config, seat) for seat in range(config.hunters)]
        self._limits = {word: [dataclasses.replace(its, control=word) for its in limits] for word in get_args(Control)}
        self._seats_differ = any(dataclasses.replace(its, control=limits[0].control) != limits[0] for its in limits)
        self._seated = np.full((num_envs, config.hunters), -1)
        self._instances: dict[Place, Player] = {}

    @property
    def controls(self) -> NDArray[np.int8]:
        """Control of each agent of the pool, as a number of `controllers.CONTROLS`: (P,)."""
        return np.array([CONTROLS[opponent.control] for opponent in self._pool], dtype=np.int8)

    @property
    def weights(self) -> NDArray[np.float64]:
        """Probability with which each agent of the pool is drawn: (P,), with the sum 1."""
        return np.full(len(self._pool), 1 / len(self._pool)) if self._weights is None else self._weights.copy()

    @property
    def seated(self) -> NDArray[np.int64]:
        """Agents in the seats of the running episodes, as indices in the pool, -1 for learners: (B, H)."""
        return self._seated.copy()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the agents of the pool; `draw` returns indices in this order."""
        return tuple(opponent.name for opponent in self._pool)

    def add(self, agent: object) -> int:
        """Take one more agent into the pool, with the weight 0 until `weigh` gives it another.

        Returns:
            its number, the index of its name in `names`.

        Raises:
            AgentError: for an agent that cannot play.
        """
        added = _opponent(agent)
        number = len(self._pool)
        weights = np.append(self.weights, 0.0)
        self._pool.append(added)
        self._weights = weights
        if added.in_batches:
            added.player.call("reset", number)
        return number

    def weigh(self, weights: ArrayLike) -> None:
        """Set the weights with which agents are drawn from now on: (P,), at least 0, and one above 0.

        Raises:
            ConfigError: for other weights.
        """
        given = np.asarray(weights, dtype=np.float64)
        if given.shape != (len(self._pool),):
            raise ConfigError(f"weights must be {len(self._pool)} numbers, one for each opponent, got {given.shape}")
        self._weights = _shares(given, shortened(given.tolist()))

    def begin(self, rng: np.random.Generator) -> None:
        """Seed the agents that have `act_batch`."""
        for opponent in self._pool:
            if opponent.in_batches:
                opponent.player.call("reset", int(rng.integers(_SEED_LIMIT)))

    def draw(self, arenas: NDArray[np.int64], seats: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw and begin the agents in the seats (n, S) of the arenas (n,); the other seats are the learners'.

        Returns:
            the numbers of the agents in the pool: (n, S).
        """
        if self._distinct and np.count_nonzero(self.weights) >= seats.shape[1]:
            # without replacement: the largest of log weights with Gumbel noise (Efraimidis and Spirakis, 2006)
            with np.errstate(divide="ignore"):
                keys = np.log(self.weights) + rng.gumbel(size=(len(seats), len(self._pool)))
            chosen = np.argsort(-keys, axis=1, kind="stable")[:, : seats.shape[1]]
        else:
            chosen = rng.choice(len(self._pool), p=self._weights, size=seats.shape)
        self._seated[arenas] = -1
        self._seated[arenas[:, None], seats] = chosen
        if not all(opponent.in_batches for opponent in self._pool):
            begun = set(arenas.tolist())
            self._instances = {place: one for place, one in self._instances.items() if place[0] not in begun}
        for number, opponent in enumerate(self._pool):
            if opponent.in_batches:
                continue
            for row, place in np.argwhere(chosen == number).tolist():
                arena, seat = int(arenas[row]), int(seats[row, place])
                player = copy.deepcopy(opponent.player)
                player.place = _place(arena, seat)
                self._instances[arena, seat] = player
                player.call("reset", int(rng.integers(_SEED_LIMIT)))
        return chosen

    def save(self) -> SavedOpponents:
        """R10.2: return a copy of the pool, the seats, and everything that the agents store, for `restore`.

        Raises:
            AgentError: if an agent cannot be copied; it names the agent.
        """
        return copy.deepcopy(SavedOpponents(tuple(self._pool), self._instances, self._weights, self._seated))

    def restore(self, saved: SavedOpponents) -> None:
        """Continue from a saved state of these opponents, or of others with an equal config and number of arenas."""
        pool, self._instances, self._weights, self._seated = copy.deepcopy(saved)
        self._pool = list(pool)

    def act(
        self,
        observations: NDArray[np.float32],
        masks: NDArray[np.int8],
        choices: NDArray[np.int64],
        commands: NDArray[np.float32],
    ) -> None:
        """Write the opponents' actions into `choices` (B, H) and `commands` (B, H, 2).

        Raises:
            AgentError: for an agent that fails; it names the agent, and the hunter if that is known.
        """
        for number, opponent in enumerate(self._pool):
            arenas, seats = np.nonzero(self._seated == number)
            if not len(arenas):
                continue
            limits = self._limits[opponent.control]
            if not opponent.in_batches:
                for place in zip(arenas.tolist(), seats.tolist(), strict=True):
                    view = View(observations[place].tolist(), masks[place].tolist(), limits[place[1]])
                    player = self._instances[place]
                    choices[place], commands[place] = player.act(view, opponent.control, self._config.targets_seen)
                continue
            for group in [seats == seat for seat in np.unique(seats)] if self._seats_differ else [slice(None)]:
                some, own_seats = arenas[group], seats[group]
                batch = BatchView(observations[some, own_seats], masks[some, own_seats], limits[int(own_seats[0])])
                ranks, velocities = opponent.player.act_batch(
                    batch, opponent.control, self._config.targets_seen, partial(_place_of_row, some, own_seats)
                )
                if ranks is not None:
                    choices[some, own_seats] = ranks
                if velocities is not None:
                    commands[some, own_seats] = velocities


def _agents_and_weights(pool: Pool) -> tuple[list[object], NDArray[np.float64] | None]:
    if isinstance(pool, str) or not isinstance(pool, Iterable):
        return [pool], None
    agents = list(pool)
    if not agents:
        raise ConfigError(f"opponents must name at least one agent, got {pool!r}")
    if not isinstance(pool, Mapping):
        return agents, None
    try:
        weights = np.array([float(weight) for weight in pool.values()])
    except (TypeError, ValueError):
        weights = np.array([np.nan])
    return agents, _shares(weights, shortened(dict(pool)))


def _shares(weights: NDArray[np.float64], given: str) -> NDArray[np.float64]:
    if not (np.isfinite(weights).all() and (weights >= 0).all() and weights.sum() > 0):
        raise ConfigError(f"weights of opponents must be at least 0, and at least one must be positive, got {given}")
    shares: NDArray[np.float64] = weights / weights.sum()
    return shares


def _opponent(agent: object) -> _Opponent:
    name, policy = name_and_policy("opponent", agent)
    return _Opponent(name, Player(f"opponent {name}", policy), control_of(policy), acts_in_batches(policy))


def _place(arena: int, seat: int) -> str:
    return f" for hunter_{seat} in arena {arena}"


def _place_of_row(arenas: NDArray[np.int64], seats: NDArray[np.int64], row: int) -> str:
    return _place(int(arenas[row]), int(seats[row]))

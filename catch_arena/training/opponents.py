"""Opponents inside the batch: the agents in the seats that do not learn."""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.text import shortened
from catch_arena.training.players import Players

Pool = str | object | Iterable[object] | Mapping[str, float]
"""One agent, several, or a mapping from names to the weights with which they are drawn."""


class Opponents(Players):
    """A pool of agents, from which each seat without a learner gets one in each episode.

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

    saved_attributes = (*Players.saved_attributes, "_weights")

    def __init__(self, config: ArenaConfig, num_envs: int, pool: Pool, *, distinct: bool = False) -> None:
        agents = list(pool) if isinstance(pool, Iterable) and not isinstance(pool, str) else [pool]
        if not agents:
            raise ConfigError(f"opponents must name at least one agent, got {pool!r}")
        self._weights = _shares(list(pool.values()), len(agents)) if isinstance(pool, Mapping) else None
        self._distinct = distinct
        super().__init__(config, num_envs, "hunter", "opponent", agents)

    @property
    def weights(self) -> NDArray[np.float64]:
        """Probability with which each agent of the pool is drawn: (P,), with the sum 1."""
        return np.full(len(self.pool), 1 / len(self.pool)) if self._weights is None else self._weights.copy()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the agents of the pool, by number."""
        return tuple(player.name for player in self.pool)

    def add(self, agent: object) -> int:
        """Take one more agent into the pool, with the weight 0 until `weigh` gives it another.

        Returns:
            its number, the index of its name in `names`.

        Raises:
            AgentError: for an agent that cannot play.
        """
        weights = np.append(self.weights, 0.0)
        number = super().add(agent)
        self._weights = weights
        return number

    def weigh(self, weights: ArrayLike) -> None:
        """Set the weights with which agents are drawn from now on: (P,), at least 0, and one above 0.

        Raises:
            ConfigError: for other weights.
        """
        self._weights = _shares(weights, len(self.pool))

    def draw(self, arenas: int, seats: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """Return the numbers of agents for some seats of each of some arenas: (arenas, seats)."""
        if not self._distinct or np.count_nonzero(self.weights) < seats:
            return rng.choice(len(self.pool), p=self._weights, size=(arenas, seats))
        # without replacement: the largest of log weights with Gumbel noise (Efraimidis and Spirakis, 2006)
        with np.errstate(divide="ignore"):
            keys = np.log(self.weights) + rng.gumbel(size=(arenas, len(self.pool)))
        return np.argsort(-keys, axis=1, kind="stable")[:, :seats]


def _shares(weights: ArrayLike, count: int) -> NDArray[np.float64]:
    """Return the weights of a number of opponents as probabilities: (count,)."""
    try:
        given = np.array(weights, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.zeros(0)
    if given.shape != (count,) or not (np.isfinite(given).all() and (given >= 0).all() and given.any()):
        must = f"{count} finite numbers of at least 0, of which at least one is positive"
        raise ConfigError(f"weights of opponents must be {must}, got {shortened(weights)}")
    shares: NDArray[np.float64] = given / given.sum()
    return shares

"""Players of prey inside the batch: an instance of an agent's class `Prey` for each prey of each arena."""

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.envs.actions import checked_action
from catch_arena.errors import ActionError, AgentError, ConfigError, reason
from catch_arena.policy import PreyLimits
from catch_arena.tournament.agent_spec import resolve_spec
from catch_arena.tournament.entrants import SHIPPED_PREY
from catch_arena.tournament.loading import agent_class, create_policy

Place = tuple[int, int]
"""An arena, and the number of a prey in it."""


def who_plays_prey(config: ArenaConfig, agent: str | None) -> str | None:
    """Return the agent that plays prey: the given one, or else the shipped one; None for arenas without prey.

    Args:
        config: the arenas' settings.
        agent: a shipped name, a file or `package.module:Class`.

    Raises:
        ConfigError: for an agent in arenas without prey.
        AgentError: for an agent that is not there, or has no class `Prey`.
    """
    if not config.prey:
        if agent is not None:
            raise ConfigError(f"prey must be at least 1 for an agent to play it, got 0 and the agent {agent}")
        return None
    agent = SHIPPED_PREY if agent is None else agent
    agent_class(resolve_spec(agent), "prey")
    return agent


class PreyPlayers:
    """The prey of a batch of arenas. Each has an instance of its own, which is called for it alone.

    Args:
        config: the arenas' settings.
        num_envs: B.
        agent: who plays, see `who_plays_prey`.
    """

    def __init__(self, config: ArenaConfig, num_envs: int, agent: str) -> None:
        spec = resolve_spec(agent)
        self._name, self._limits = agent, PreyLimits.of(config)
        self._players: dict[Place, Any] = {
            (arena, index): create_policy(spec, "prey") for arena in range(num_envs) for index in range(config.prey)
        }

    def begin(self, rng: np.random.Generator, arenas: NDArray[np.int64] | None = None) -> None:
        """Begin an episode for the prey of these arenas; None means all arenas."""
        begun = None if arenas is None else set(arenas.tolist())
        for place, player in self._players.items():
            if begun is None or place[0] in begun:
                self._call(player, "reset", int(rng.integers(2**63)), place)

    def act(self, observations: NDArray[np.float32], commands: NDArray[np.float32]) -> None:
        """R12.2: write the actions of prey for these observations, (B, P, E), into `commands`: (B, P, 2) in [-1, 1].

        Raises:
            AgentError: for one that fails.
        """
        for place, player in self._players.items():
            answer = self._call(player, "act", self._limits.view(observations[place].tolist(), ()), place)
            try:
                _, commands[place] = checked_action("velocity", f"prey {self._name}", answer, 0)
            except ActionError as error:
                raise AgentError(f"{error}{_where(place)}") from None

    def save(self) -> dict[Place, Any]:
        """R10.2: return copies of all players, with everything that they store, for `restore`.

        Raises:
            AgentError: for an agent that cannot be copied.
        """
        return self._copied(self._players)

    def restore(self, saved: dict[Place, Any]) -> None:
        """Continue from copies that `save` returned, in this batch or in one of equal config and size."""
        self._players = self._copied(saved)

    def __deepcopy__(self, _memo: dict[int, Any]) -> "PreyPlayers":
        twin = copy.copy(self)
        twin.restore(self._players)
        return twin

    def _copied(self, players: dict[Place, Any]) -> dict[Place, Any]:
        twins: dict[Place, Any] = copied(f"prey {self._name}", players, {})
        return twins

    def _call(self, player: Any, method: str, argument: object, place: Place) -> Any:
        return called(f"prey {self._name}", player, method, argument, _where(place))


def called(who: str, agent: Any, method: str, argument: object, where: str = "") -> Any:
    """Return what a method of an agent returns.

    Raises:
        AgentError: if the method raises anything; it names the agent and its seat or prey.
    """
    try:
        return getattr(agent, method)(argument)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{who}: {method} raised {reason(error)}{where}") from error


def copied(who: str, agents: Any, memo: dict[int, Any]) -> Any:
    """Return a copy of one agent or of several, with all that they remember.

    Raises:
        AgentError: if the agent cannot be copied; it names the agent.
    """
    try:
        return copy.deepcopy(agents, memo)
    except Exception as error:  # a stranger's code may raise anything
        raise AgentError(f"{who}: copying it raised {reason(error)}") from error


def _where(place: Place) -> str:
    return f" for prey_{place[1]} in arena {place[0]}"

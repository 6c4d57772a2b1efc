"""Players inside the batch: agents whose errors name them, the agents that play prey, and actions of many hunters."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig, Control
from catch_arena.envs.actions import action_array, checked_action
from catch_arena.errors import ActionError, AgentError, reason
from catch_arena.policy import PreyLimits
from catch_arena.text import shortened
from catch_arena.tournament.agent_spec import resolve_spec
from catch_arena.tournament.entrants import SHIPPED_PREY
from catch_arena.tournament.loading import create_policy

Place = tuple[int, int]
"""An arena, and the seat of a hunter or the number of a prey in it."""


@dataclass
class Player:
    """An instance of an agent. Its errors are AgentErrors that name the agent, and its hunter or prey if it has one."""

    name: str
    """Name of the agent in errors."""
    policy: Any
    place: str = ""
    """End of errors, which names the hunter or prey that the instance plays."""

    def call(self, method: str, argument: object) -> Any:
        """Return the result of a method of the agent.

        Raises:
            AgentError: if the method raises anything.
        """
        try:
            return getattr(self.policy, method)(argument)
        except (Exception, SystemExit) as error:  # a stranger's code may raise anything
            raise AgentError(f"{self.name}: {method} raised {reason(error)}{self.place}") from error

    def act(self, view: Any, control: Control, ranks: int) -> tuple[int, tuple[float, float]]:
        """Return the rank and the two velocities of the agent's action, checked as in an env of one arena.

        Raises:
            AgentError: if the agent raises anything, or for an action that is not legal.
        """
        action = self.call("act", view)
        try:
            return checked_action(control, self.name, action, ranks)
        except ActionError as error:
            raise AgentError(f"{error}{self.place}") from None

    def __deepcopy__(self, memo: dict[int, Any]) -> "Player":
        """Return a copy with everything that the agent stores.

        Raises:
            AgentError: if the agent cannot be copied.
        """
        try:
            return Player(self.name, copy.deepcopy(self.policy, memo), self.place)
        except Exception as error:  # a stranger's code may raise anything
            raise AgentError(f"{self.name}: copying the agent raised {reason(error)}") from error


class PreyPlayers:
    """The prey of a batch of arenas. Each has an instance of its own, which is called for it alone.

    Args:
        config: the arenas' settings.
        num_envs: B.
        agent: the agent that plays: a shipped name, a file or `package.module:Class`; None is the shipped one.

    Raises:
        AgentError: for an agent that is not there, or has no class `Prey`.
    """

    def __init__(self, config: ArenaConfig, num_envs: int, agent: str | None) -> None:
        agent = SHIPPED_PREY if agent is None else agent
        spec = resolve_spec(agent)
        self._limits = PreyLimits.of(config)
        self._players = {
            (arena, index): Player(
                f"prey {agent}", create_policy(spec, "prey"), f" for {config.prey_names[index]} in arena {arena}"
            )
            for arena in range(num_envs)
            for index in range(config.prey)
        }

    def begin(self, rng: np.random.Generator, arenas: NDArray[np.int64]) -> None:
        """Begin an episode for the prey of these arenas."""
        begun = set(arenas.tolist())
        for (arena, _), player in self._players.items():
            if arena in begun:
                player.call("reset", int(rng.integers(2**63)))

    def act(self, observations: NDArray[np.float32], commands: NDArray[np.float32]) -> None:
        """R12.2: write the actions of prey for these observations, (B, P, E), into `commands`: (B, P, 2) in [-1, 1].

        Raises:
            AgentError: for one that fails.
        """
        for place, player in self._players.items():
            _, commands[place] = player.act(self._limits.view(observations[place].tolist(), ()), "velocity", 0)

    def save(self) -> dict[Place, Player]:
        """R10.2: return copies of all players, with everything that they store, for `restore`.

        Raises:
            AgentError: for an agent that cannot be copied.
        """
        return copy.deepcopy(self._players)

    def restore(self, saved: Mapping[Place, Player]) -> None:
        """Continue from copies that `save` returned, in this batch or in one of equal config and size."""
        self._players = copy.deepcopy(dict(saved))


def action_arrays(
    name: str, actions: Any, count: int, control: Control
) -> tuple[NDArray[Any] | None, NDArray[Any] | None]:
    """Return the ranks, (N,), and the velocities, (N, 2), of N actions; None for a part that the control does not have.

    Args:
        name: name of the actions in errors.
        actions: an array, a tensor or lists; under full control {"cmd_vel": (N, 2), "catch": (N,)}.
        count: N.
        control: control of the hunters.

    Raises:
        ActionError: for another type or shape; the numbers' bounds are not checked.
    """
    ranks, velocities = actions, actions
    if control == "full":
        if not isinstance(actions, Mapping) or set(actions) != {"cmd_vel", "catch"}:
            raise ActionError(f"{name} must be a mapping with cmd_vel and catch, got {shortened(actions)}")
        ranks, velocities = actions["catch"], actions["cmd_vel"]
    return (
        None if control == "velocity" else action_array(name, ranks, (count,), whole=True),
        None if control == "target" else action_array(name, velocities, (count, 2)),
    )

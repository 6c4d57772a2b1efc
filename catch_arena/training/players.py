"""Players inside the batch: agents whose errors name them, the agents that play prey, and actions of many hunters."""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import PreyBatchView
from catch_arena.config import ArenaConfig, Control
from catch_arena.envs.actions import action_array, checked_action
from catch_arena.errors import ActionError, AgentError, reason
from catch_arena.policy import PreyLimits, Side
from catch_arena.text import shortened
from catch_arena.tournament.agent_spec import resolve
from catch_arena.tournament.entrants import SHIPPED_PREY
from catch_arena.tournament.loading import create_policy


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

    def act_batch(
        self, view: Any, control: Control, last_rank: int, place: Callable[[int], str]
    ) -> tuple[NDArray[Any] | None, NDArray[Any] | None]:
        """Return the checked ranks, (N,), and velocities, (N, 2), of N actions; None if the control does not have them.

        Args:
            view: a `BatchView` or `PreyBatchView` of N observations.
            control: control of those that the agent plays.
            last_rank: the greatest legal rank.
            place: a function that returns the end of an error about a row, which names the hunter or prey.

        Raises:
            AgentError: if the agent raises anything, or for actions that are not legal.
        """
        actions, name = self.call("act_batch", view), f"{self.name}: actions"
        try:
            ranks, velocities = action_arrays(name, actions, len(view.observations), control)
        except ActionError as error:
            raise AgentError(str(error)) from None
        if ranks is not None:
            legal = (ranks >= 0) & (ranks <= last_rank)
            _require(f"{name} must be whole numbers from 0 to {last_rank}", ranks, legal, place)
        if velocities is not None:
            within = np.all((velocities >= -1.0) & (velocities <= 1.0), axis=1)  # NaN fails both tests
            _require(f"{name} must be numbers in [-1, 1]", velocities, within, place)
        return ranks, velocities

    def __deepcopy__(self, memo: dict[int, Any]) -> "Player":
        """Return a copy with everything that the agent stores.

        Raises:
            AgentError: if the agent cannot be copied.
        """
        try:
            return Player(self.name, copy.deepcopy(self.policy, memo), self.place)
        except Exception as error:  # a stranger's code may raise anything
            raise AgentError(f"{self.name}: copying the agent raised {reason(error)}") from error


def _require(requirement: str, given: NDArray[Any], legal: NDArray[np.bool_], place: Callable[[int], str]) -> None:
    """Raise an AgentError for the first row whose action is not legal."""
    if not legal.all():
        row = int(np.argmin(legal))
        raise AgentError(f"{requirement}, got {given[row].tolist()}{place(row)}")


def name_and_policy(role: str, agent: object, side: Side = "hunter") -> tuple[str, Any]:
    """Return an agent's name and an instance of it.

    Args:
        role: word in front of its name in errors.
        agent: a shipped name, a file, `package.module:Class`, a class, or an object, which is returned itself.
        side: the side that it plays.

    Raises:
        AgentError: for an agent that cannot play.
    """
    if isinstance(agent, str):
        return agent, create_policy(resolve(agent).spec, side)
    name, policy = type(agent).__name__, agent
    if isinstance(agent, type):
        name = agent.__name__
        try:
            policy = agent()
        except (Exception, SystemExit) as error:  # a stranger's code may raise anything
            raise AgentError(f"{role} {name}: {name}() raised {reason(error)}") from error
    for method in ("reset", "act_batch" if acts_in_batches(policy) else "act"):
        if not callable(getattr(policy, method, None)):
            raise AgentError(
                f"{role} {name}: must have the methods reset and act_batch, or reset and act, but has no {method}"
            )
    return name, policy


def acts_in_batches(policy: object) -> bool:
    """Return whether an agent acts for many hunters or prey in one call."""
    return callable(getattr(policy, "act_batch", None))


class PreyPlayers:
    """The prey of a batch of arenas.

    An agent with `act_batch` is called once a step for the prey of all arenas, and keeps nothing of a single prey; one
    that has only `act` is called for each prey, and each has an instance of its own.

    Args:
        config: the arenas' settings.
        num_envs: B.
        agent: the agent that plays: a shipped name, a file, `package.module:Class`, a class, or an object with
            `act_batch` or `act`; None is the shipped one.

    Raises:
        AgentError: for an agent that is not there, has no class `Prey`, or cannot play.
    """

    def __init__(self, config: ArenaConfig, num_envs: int, agent: object | None) -> None:
        agent = SHIPPED_PREY if agent is None else agent
        self._limits = PreyLimits.of(config)
        self._names = config.prey_names
        name, policy = name_and_policy("prey", agent, "prey")
        original = Player(f"prey {name}", policy)
        self._in_batches = acts_in_batches(policy)
        self._players = [original]
        """One instance for all prey if it has `act_batch`; else that of each prey, arena by arena."""
        if not self._in_batches:
            self._players = [
                Player(
                    original.name,
                    copy.deepcopy(original).policy if policy is agent else name_and_policy("prey", agent, "prey")[1],
                    self._place(row),
                )
                for row in range(num_envs * config.prey)
            ]

    def _place(self, row: int) -> str:
        arena, index = divmod(row, len(self._names))
        return f" for {self._names[index]} in arena {arena}"

    def begin(self, rng: np.random.Generator) -> None:
        """Seed an agent that has `act_batch`."""
        if self._in_batches:
            self._players[0].call("reset", int(rng.integers(2**63)))

    def begin_episodes(self, rng: np.random.Generator, arenas: NDArray[np.int64]) -> None:
        """Begin an episode for each prey of these arenas, if each has an instance."""
        begun = set(arenas.tolist())
        for row, player in enumerate([] if self._in_batches else self._players):
            if row // len(self._names) in begun:
                player.call("reset", int(rng.integers(2**63)))

    def act(self, observations: NDArray[np.float32], commands: NDArray[np.float32]) -> None:
        """R12.2: write the actions of prey for these observations, (B, P, E), into `commands`: (B, P, 2) in [-1, 1].

        Raises:
            AgentError: for one that fails.
        """
        if self._in_batches:
            view = PreyBatchView(np.array(observations).reshape(-1, observations.shape[-1]), self._limits)
            _, velocities = self._players[0].act_batch(view, "velocity", 0, self._place)
            commands[:] = np.asarray(velocities).reshape(commands.shape)
            return
        for place, player in zip(np.ndindex(commands.shape[:2]), self._players, strict=True):
            _, commands[place] = player.act(self._limits.view(observations[place].tolist(), ()), "velocity", 0)

    def save(self) -> list[Player]:
        """R10.2: return copies of all players, with everything that they store, for `restore`.

        Raises:
            AgentError: for an agent that cannot be copied.
        """
        return copy.deepcopy(self._players)

    def restore(self, saved: Sequence[Player]) -> None:
        """Continue from copies that `save` returned, in this batch or in one of equal config and size."""
        self._players = copy.deepcopy(list(saved))


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

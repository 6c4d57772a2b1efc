"""Players inside the batch: agents whose errors name them, the agents of one side, and actions of many of them."""

import copy
import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final, get_args

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView, PreyBatchView
from catch_arena.config import ArenaConfig, Control
from catch_arena.core.controllers import CONTROLS
from catch_arena.envs.actions import action_array, checked_action
from catch_arena.errors import ActionError, AgentError, reason
from catch_arena.layout import observation_size, prey_observation_size
from catch_arena.policy import Side, control_of, player_limits
from catch_arena.text import shortened
from catch_arena.tournament.agent_spec import resolve
from catch_arena.tournament.loading import create_policy

LEARNER: Final = -1
"""Number, in place of a player's, of a hunter or prey that learns."""
_SEED_LIMIT: Final = 2**63

Rows = tuple[NDArray[np.int64], NDArray[np.int64]]
"""Some agents of a batch: their arenas, and their numbers in these, hunters by seat and then prey; (n,) each."""


@dataclass
class Player:
    """An instance of an agent. Its errors are AgentErrors that name the agent, and its hunter or prey if it has one.

    Whatever the agent raises is such an error, and so is an action that is not legal.
    """

    role: str
    """Word before the agent's name in errors."""
    name: str
    policy: Any
    control: Control
    place: str = ""
    """End of errors, which names the hunter or prey that the instance plays."""

    @classmethod
    def of(cls, role: str, agent: object, side: Side) -> "Player":
        """Return the player of a shipped name, a file, `package.module:Class`, a class, or an object that plays itself.

        Raise AgentError for an agent that cannot play.
        """
        name, policy = type(agent).__name__, agent
        if isinstance(agent, str):
            name, policy = agent, create_policy(resolve(agent).spec, side)
        elif isinstance(agent, type):
            name = agent.__name__
            try:
                policy = agent()
            except (Exception, SystemExit) as error:  # a stranger's code may raise anything
                raise AgentError(f"{role} {name}: {name}() raised {reason(error)}") from error
        made = cls(role, name, policy, "velocity" if side == "prey" else control_of(policy))
        for method in ("reset", "act_batch" if made.in_batches else "act"):
            if not callable(getattr(policy, method, None)):
                raise AgentError(
                    f"{made.label}: must have the methods reset and act_batch, or reset and act, but has no {method}"
                )
        return made

    @property
    def label(self) -> str:
        """Name of the agent in errors."""
        return f"{self.role} {self.name}"

    @property
    def in_batches(self) -> bool:
        """True if the agent acts for many hunters or prey in one call."""
        return callable(getattr(self.policy, "act_batch", None))

    def call(self, method: str, argument: object) -> Any:
        """Return the result of a method of the agent."""
        try:
            return getattr(self.policy, method)(argument)
        except (Exception, SystemExit) as error:  # a stranger's code may raise anything
            raise AgentError(f"{self.label}: {method} raised {reason(error)}{self.place}") from error

    def act(self, view: Any, ranks: int) -> tuple[int, tuple[float, float]]:
        """Return the rank and the two velocities of the agent's action, checked as in an env of one arena."""
        action = self.call("act", view)
        try:
            return checked_action(self.control, self.label, action, ranks)
        except ActionError as error:
            raise AgentError(f"{error}{self.place}") from None

    def act_batch(self, view: Any) -> tuple[NDArray[Any] | None, NDArray[Any] | None]:
        """Return the ranks, (N,), and velocities, (N, 2), of N actions, see `action_arrays`."""
        actions = self.call("act_batch", view)
        try:
            return action_arrays(f"{self.label}: actions", actions, len(view.observations), self.control)
        except ActionError as error:
            raise AgentError(str(error)) from None

    def __deepcopy__(self, memo: dict[int, Any]) -> "Player":
        """Return a copy with everything that the agent stores."""
        try:
            return dataclasses.replace(self, policy=copy.deepcopy(self.policy, memo))
        except Exception as error:  # a stranger's code may raise anything
            raise AgentError(f"{self.label}: copying the agent raised {reason(error)}") from error


class Players:
    """Agents of one side, and the seats that they play in B arenas: those of the hunters, or of the prey.

    An agent with `act_batch` is called once a step for all seats that it plays, and keeps nothing of a single one; one
    that has only `act` is called for each of them, and each has an instance of its own. In the shapes of arrays an
    arena has N agents, the hunters by seat and then the prey.
    """

    saved_attributes: ClassVar[tuple[str, ...]] = ("pool", "_seated", "_instances")
    """Names of the attributes that `save` copies."""

    def __init__(self, config: ArenaConfig, num_envs: int, side: Side, role: str, agents: Iterable[object]) -> None:
        self._side, self._role, self._ranks = side, role, config.targets_seen
        self.pool = [Player.of(role, agent, side) for agent in agents]
        """The players, by number."""
        self._names = (*config.hunter_names, *config.prey_names)
        self.agents: Final = slice(0, config.hunters) if side == "hunter" else slice(config.hunters, len(self._names))
        """The side's part of an arena's N agents."""
        self._size = observation_size(config) if side == "hunter" else prey_observation_size(config)
        self._limits: dict[Control, list[Any]] = {}
        """Limits of all N agents, by control of the hunters."""
        for word in get_args(Control):
            controlled = config.replace(control=word)
            self._limits[word] = [player_limits(controlled, agent) for agent in range(len(self._names))]
        self._seats_differ = len(set(self._limits["velocity"][self.agents])) > 1
        self._seated = np.full((num_envs, self.agents.stop - self.agents.start), LEARNER)
        self._instances: dict[tuple[int, int], Player] = {}
        """The instance in each seat, by arena and agent, of those that have only `act`."""

    @property
    def seated(self) -> NDArray[np.int64]:
        """Agents in the seats of the running episodes, by number, or LEARNER: (B, seats)."""
        return self._seated.copy()

    def add(self, agent: object) -> int:
        """Take one more agent into the pool, see `Player.of`, and return its number."""
        player, number = Player.of(self._role, agent, self._side), len(self.pool)
        self.pool.append(player)
        if player.in_batches:
            player.call("reset", number)
        return number

    def begin(self, rng: np.random.Generator) -> None:
        """Seed the agents that have `act_batch`."""
        for player in self.pool:
            if player.in_batches:
                player.call("reset", int(rng.integers(_SEED_LIMIT)))

    def seat(
        self,
        arenas: NDArray[np.int64],
        seats: NDArray[np.int64] | None,
        numbers: NDArray[np.int64],
        rng: np.random.Generator,
    ) -> None:
        """Give seats (n, S) of the arenas (n,), or all seats, to agents by number: (n, S). Other seats are LEARNER's.

        Agents that have only `act` begin an episode there.
        """
        seats = np.indices(numbers.shape)[1] if seats is None else seats
        self._seated[arenas] = LEARNER  # until all agents have begun, since one may raise
        begun = set(arenas.tolist())
        self._instances = {place: one for place, one in self._instances.items() if place[0] not in begun}
        for number, original in enumerate(self.pool):
            for row, column in [] if original.in_batches else np.argwhere(numbers == number).tolist():
                place = int(arenas[row]), self.agents.start + int(seats[row, column])
                self._instances[place] = player = copy.deepcopy(original)
                player.place = self._place(*place)
                player.call("reset", int(rng.integers(_SEED_LIMIT)))
        self._seated[arenas[:, None], seats] = numbers

    def controls(self, arenas: NDArray[np.int64], learners: Control) -> NDArray[np.int8]:
        """Return the controls of the seats of these arenas (n,), as `VectorArena.set_controls` takes them: (n, seats).

        `learners` is the control of the seats that no agent plays.
        """
        codes = [CONTROLS[control] for control in (*(player.control for player in self.pool), learners)]
        found: NDArray[np.int8] = np.array(codes, np.int8)[self._seated[arenas]]  # LEARNER, -1, is the last one
        return found

    def view(self, observations: NDArray[np.float32], masks: NDArray[np.int8], rows: Rows, control: Control) -> Any:
        """Return what some agents of the side see, all of the same limits: a `BatchView` or a `PreyBatchView`.

        The observations, (B, N, at least D), and masks, (B, H, K + 1), are those of the whole batch.
        """
        seen = observations[..., : self._size][rows]
        limits = self._limits[control][int(rows[1][0]) if self._seats_differ else self.agents.start]
        return PreyBatchView(seen, limits) if self._side == "prey" else BatchView(seen, masks[rows], limits)

    def act(
        self,
        observations: NDArray[np.float32],
        masks: NDArray[np.int8],
        choices: NDArray[np.int64],
        commands: NDArray[np.float32],
    ) -> None:
        """Write the agents' actions into `choices` (B, H), which prey does not have, and `commands` (B, N, 2)."""
        for number, player in enumerate(self.pool):
            arenas, seats = np.nonzero(self._seated == number)
            if not len(arenas):
                continue
            agents = seats + self.agents.start
            if not player.in_batches:
                for place in zip(arenas.tolist(), agents.tolist(), strict=True):
                    mask = () if self._side == "prey" else masks[place].tolist()
                    limits = self._limits[player.control][place[1]]
                    view = limits.view(observations[place][: self._size].tolist(), mask)
                    rank, commands[place] = self._instances[place].act(view, self._ranks)
                    if player.control != "velocity":
                        choices[place] = rank
                continue
            for group in [seats == seat for seat in np.unique(seats)] if self._seats_differ else [slice(None)]:
                rows = arenas[group], agents[group]
                ranks, velocities = player.act_batch(self.view(observations, masks, rows, player.control))
                for low, high, given, written in ((0, self._ranks, ranks, choices), (-1, 1, velocities, commands)):
                    if given is None:
                        continue
                    legal = ((given >= low) & (given <= high)).reshape(len(given), -1).all(axis=1)  # NaN fails both
                    if not legal.all():
                        wrong = int(np.argmin(legal))
                        where = self._place(int(rows[0][wrong]), int(rows[1][wrong]))
                        got = f"got {given[wrong].tolist()}{where}"
                        raise AgentError(f"{player.label}: actions must be numbers in [{low}, {high}], {got}")
                    written[rows] = given

    def save(self) -> dict[str, Any]:
        """R10.2: return a copy of the pool, the seats, and everything that the agents store, for `restore`."""
        return copy.deepcopy({name: getattr(self, name) for name in self.saved_attributes})

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Continue from a saved state of these players, or of others with an equal config and number of arenas."""
        vars(self).update(copy.deepcopy(saved))

    def _place(self, arena: int, agent: int) -> str:
        return f" for {self._names[agent]} in arena {arena}"


def action_arrays(
    name: str, actions: Any, count: int, control: Control
) -> tuple[NDArray[Any] | None, NDArray[Any] | None]:
    """Return the ranks, (N,), and the velocities, (N, 2), of N actions; None for a part that the control does not have.

    The actions are an array, a tensor or lists; under full control {"cmd_vel": (N, 2), "catch": (N,)}. Raise
    ActionError for another type or shape; the numbers' bounds are not checked.
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

"""Dictionaries by agent, which an env takes and returns: actions, observations, rewards and infos."""

from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal, TypeVar

import numpy as np

from catch_arena.config import Control
from catch_arena.engine import Engine
from catch_arena.envs.actions import checked_action, checked_command
from catch_arena.errors import ActionError, suggest
from catch_arena.layout import observation_size, prey_observation_size
from catch_arena.text import shortened
from catch_arena.verdicts import NO_REQUEST

T = TypeVar("T")

Infos = Literal["full", "mask", "none"]
"""R7.2: content of an env's infos."""

_USUAL: Final[dict[str, Any]] = {
    "verdict": NO_REQUEST,
    "target": -1,
    "distance_um": -1,
    "winner": -1,
    "reward_parts": None,
    "TimeLimit.truncated": False,
}
"""Info of a hunter that requests nothing; a copy takes less time than a new dict of these."""


class Dictionaries:
    """Translation between dictionaries of all agents and the arrays of an engine's first arena. Results are copies."""

    def __init__(self, engine: Engine, names: Sequence[str], content: Infos) -> None:
        self._engine, self._names, self._content = engine, names, content
        self._config = config = engine.config
        # views of the engine's memory: `tick.play` writes the rewards by `rewards.reward`
        self._observations, self._masks, self._rewards = engine.observations[0], engine.masks[0], engine.rewards[0]
        self._parts, self._prey_parts = engine.parts[0], engine.prey_parts[0]
        self._verdicts = engine.ruling_rows[:, 1]
        self.choices = np.zeros((1, config.hunters), dtype=np.int64)
        """Ranks, as `Engine.step` takes them: (1, H)."""
        self.commands = np.zeros((1, len(names), 2), dtype=np.float32)
        """Fractions of the limits of velocity, as `Engine.step` takes them: (1, N, 2)."""
        prey_drives: tuple[Control] = ("velocity",)
        controls = config.controls + prey_drives * config.prey
        self.seats = dict(zip(names, enumerate(controls), strict=True))
        """Row in the engine's arrays and control of each agent."""
        self._ranks = config.targets_seen
        self._hunters = [(agent, *self.seats[agent]) for agent in names[: config.hunters]]
        self._prey = list(names[config.hunters :])
        self._sizes = [observation_size(config)] * config.hunters + [prey_observation_size(config)] * config.prey
        self._team_by_seat = () if config.teams is None else config.team_by_seat
        self._hunters_stay = config.dropout_rate > 0.0 and config.dropouts == "fixed"

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and unpickle by building the object again, since its views belong to the engine."""
        return Dictionaries, (self._engine, self._names, self._content)

    def seat(self, agent: str) -> tuple[int, Control]:
        """Return that agent's row in the engine's arrays, and its control; raise ActionError for an unknown agent."""
        if not isinstance(agent, str) or agent not in self.seats:
            raise ActionError(f"unknown agent {shortened(agent)}: {suggest(shortened(agent), self.seats)}")
        return self.seats[agent]

    def read(self, agents: Sequence[str], actions: Mapping[str, Any]) -> None:
        """Write the actions of these agents into `choices` and `commands`; all others hold.

        ActionError is raised for an action that is missing or not legal, and an unknown agent.
        """
        if type(actions) is not dict and not isinstance(actions, Mapping):  # isinstance is slower
            raise ActionError(f"actions must map each agent to its action, got {shortened(actions)}")
        if len(actions) != len(agents):
            self._require_complete(agents, actions)
        choices, commands, seats, ranks = self.choices[0], self.commands, self.seats, self._ranks
        if len(agents) < len(seats):
            choices.fill(0)
            commands.fill(0.0)
        for agent in agents:
            row, control = seats[agent]
            try:
                action = actions[agent]
            except KeyError:
                self._require_complete(agents, actions)
                raise
            if control == "target" and type(action) is int and 0 <= action <= ranks:
                choices[row] = action  # the usual case without another call
            elif control == "velocity":
                commands[0, row, 0], commands[0, row, 1] = checked_command(agent, "an action", action, clip=True)
            else:
                choices[row], command = checked_action(control, agent, action, ranks, clip=True)
                commands[0, row, 0], commands[0, row, 1] = command

    def _require_complete(self, agents: Sequence[str], actions: Mapping[str, Any]) -> None:
        """Check that each of the agents has an action, and that others are only of agents that have left."""
        for agent in actions:
            self.seat(agent)
        missing = [agent for agent in agents if agent not in actions]
        if missing:
            raise ActionError(f"actions must have an action for each agent, got none for {', '.join(missing)}")

    def rewards(self) -> dict[str, float]:
        """R6.2, R12.5: return the rewards of the last step."""
        return dict(zip(self._names, self._rewards.tolist()))  # noqa: B905 - half as fast with a check

    def observations(self) -> dict[str, Any]:
        """R7.1, R12.4: return the observations after the last step or reset."""
        seen = self._observations.copy()
        if self._prey:
            observations = {agent: seen[row, : self._sizes[row]] for row, agent in enumerate(self._names)}
        else:
            observations = dict(zip(self._names, seen))  # noqa: B905
        if self._config.mask_in_observation:
            masks = self._masks.copy()
            for agent, seat, control in self._hunters:
                if control == "target":
                    observations[agent] = {"observation": observations[agent], "action_mask": masks[seat]}
        return observations

    def infos(self, truncated: Sequence[str]) -> dict[str, dict[str, Any]]:
        """R7.2: return the infos that `CatchArenaEnv` lists; for `truncated` agents, `TimeLimit.truncated` is True."""
        if self._content == "none":
            return {agent: {} for agent in self._names}
        masks = self._masks.copy()
        if self._content == "mask":
            return {
                agent: {} if control == "velocity" else {"action_mask": masks[row]}
                for agent, (row, control) in self.seats.items()
            }
        infos: dict[str, dict[str, Any]] = {}
        engine, parts, verdicts = self._engine, self._parts.copy(), self._verdicts.tolist()
        rulings = engine.ruling_rows.astype(np.int64).tolist() if any(verdicts) else ()
        active = engine.active.tolist() if engine.active.size else []
        team_scores = engine.team_scores.tolist() if self._team_by_seat else []
        for agent, seat, control in self._hunters:
            infos[agent] = info = _USUAL.copy()
            info["reward_parts"] = parts[seat]
            if control != "velocity":
                info["action_mask"] = masks[seat]
            if verdicts[seat]:
                number, info["verdict"], info["distance_um"], info["winner"] = rulings[seat]
                info["target"] = number or -1
            if self._hunters_stay:
                info["active"] = active[0][seat]
            if self._team_by_seat:
                info["team_score"] = int(team_scores[0][self._team_by_seat[seat]])
        if self._prey:
            caught_by, parts = engine.caught_by.tolist(), self._prey_parts.copy()
            for index, agent in enumerate(self._prey):
                infos[agent] = {
                    "active": active[0][len(self._hunters) + index],
                    "caught_by": int(caught_by[index]),
                    "reward_parts": parts[index],
                    "TimeLimit.truncated": False,
                }
        for agent in truncated:
            infos[agent]["TimeLimit.truncated"] = True
        return infos


def of_agents(agents: Sequence[str], by_agent: dict[str, T]) -> dict[str, T]:
    """Return the entries of these agents."""
    return {agent: by_agent[agent] for agent in agents}

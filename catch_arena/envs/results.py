"""Dictionaries that an env returns, by agent: observations, rewards and infos."""

from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.layout import observation_size, prey_observation_size
from catch_arena.verdicts import NO_REQUEST

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
"""Info of a hunter without a mask that requests nothing; a copy that has all keys takes less time than adding them."""
_USUAL_WITH_MASK: Final = {**_USUAL, "action_mask": None}


class Results:
    """Maker of dictionaries, by agent, from the engine's arrays of its first arena. Their arrays are copies.

    Args:
        config: the arena's settings.
        engine: the engine that plays the arena.
        rows: each agent's row in the engine's arrays, in ascending order.
        controls: control of each agent, by row.
        infos: content of the infos.
    """

    def __init__(
        self, config: ArenaConfig, engine: Engine, rows: Mapping[str, int], controls: Sequence[str], infos: Infos
    ) -> None:
        self._arguments = config, engine, rows, controls, infos
        self._config, self._engine, self._rows, self._controls, self._level = self._arguments
        # views of the engine's memory: `tick.play` writes the rewards by `rewards.reward`
        self._observations, self._masks, self._rewards = engine.observations[0], engine.masks[0], engine.rewards[0]
        self._parts, self._prey_parts = engine.parts[0], engine.prey_parts[0]
        self._rulings, self._verdicts = engine.ruling_rows, engine.ruling_rows[:, 1]  # its column of verdicts
        self._team_by_seat = () if config.teams is None else config.team_by_seat
        self._hunters_stay = config.dropout_rate > 0.0 and config.dropouts == "fixed"
        self._has_prey, self._shows_masks = config.prey > 0, config.mask_in_observation
        self.set_agents(())

    def __reduce__(self) -> tuple[Any, ...]:
        """Build the object again when unpickled, since its arrays belong to the engine."""
        return Results, self._arguments, self._agents

    def __setstate__(self, agents: Sequence[str]) -> None:
        self.set_agents(agents)

    def set_agents(self, agents: Sequence[str]) -> None:
        """Set the agents for which dictionaries are made."""
        self._agents = agents
        rows = [(agent, self._rows[agent]) for agent in agents]
        hunters = [(agent, row, self._controls[row]) for agent, row in rows if row < self._config.hunters]
        self._hunters, self._prey = hunters, rows[len(hunters) :]

    def rewards(self) -> dict[str, float]:
        """R6.2, R12.5: return the rewards of the last step."""
        rewards = dict(zip(self._rows, self._rewards.tolist()))  # noqa: B905 - a check of lengths takes half as long again
        return rewards if len(self._agents) == len(rewards) else {agent: rewards[agent] for agent in self._agents}

    def observations(self) -> dict[str, Any]:
        """R7.1, R12.4: return the observations after the last step or reset."""
        seen = self._observations.copy()
        observations: dict[str, Any] = {agent: seen[row] for agent, row, _ in self._hunters}
        if self._has_prey:  # hunters and prey may have observations of different sizes
            size, of_prey = observation_size(self._config), prey_observation_size(self._config)
            observations = {agent: own[:size] for agent, own in observations.items()}
            observations |= {agent: seen[row, :of_prey] for agent, row in self._prey}
        if self._shows_masks:
            masks = self._masks.copy()
            for agent, row, control in self._hunters:
                if control == "target":
                    observations[agent] = {"observation": observations[agent], "action_mask": masks[row]}
        return observations

    def infos(self, truncated: Sequence[str]) -> dict[str, dict[str, Any]]:
        """R7.2: return the infos that `CatchArenaEnv` lists.

        Args:
            truncated: the agents whose `TimeLimit.truncated` is True.
        """
        infos: dict[str, dict[str, Any]] = {}
        if self._level != "full":
            masks = self._masks.copy()
            for agent, row, control in self._hunters:
                has_mask = self._level == "mask" and control != "velocity"
                infos[agent] = {"action_mask": masks[row]} if has_mask else {}
            return infos | {agent: {} for agent, _ in self._prey}
        verdicts, parts, masks = self._verdicts.tolist(), self._parts.copy(), self._masks.copy()
        rulings = self._rulings.astype(np.int64).tolist() if any(verdicts) else ()
        for agent, row, control in self._hunters:
            if control == "velocity":
                info = _USUAL.copy()
            else:
                info = _USUAL_WITH_MASK.copy()
                info["action_mask"] = masks[row]
            info["reward_parts"] = parts[row]
            if verdicts[row]:
                number, info["verdict"], info["distance_um"], info["winner"] = rulings[row]
                info["target"] = number or -1
            infos[agent] = info
        if self._hunters_stay:
            active = self._engine.active[0].tolist()
            for agent, row, _ in self._hunters:
                infos[agent]["active"] = active[row]
        if self._team_by_seat:
            scores = self._engine.team_scores[0].tolist()
            for agent, row, _ in self._hunters:
                infos[agent]["team_score"] = int(scores[self._team_by_seat[row]])
        if self._prey:
            self._add_infos_of_prey(infos)
        for agent in truncated:
            if agent in infos:
                infos[agent]["TimeLimit.truncated"] = True
        return infos

    def _add_infos_of_prey(self, infos: dict[str, dict[str, Any]]) -> None:
        active, caught_by = self._engine.active[0].tolist(), self._engine.caught_by.tolist()
        parts = self._prey_parts.copy()
        for agent, row in self._prey:
            index = row - self._config.hunters
            infos[agent] = {
                "active": active[row],
                "caught_by": int(caught_by[index]),
                "reward_parts": parts[index],
                "TimeLimit.truncated": False,
            }

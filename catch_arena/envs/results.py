"""Dictionaries that an env returns, by agent: observations, rewards and infos."""

from collections.abc import Sequence
from typing import Any, Final, Literal, TypeVar

import numpy as np

from catch_arena.engine import Engine
from catch_arena.layout import observation_size, prey_observation_size
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
"""Info of a hunter without a mask that requests nothing; a copy that has all keys takes less time than adding them."""
_USUAL_WITH_MASK: Final = {**_USUAL, "action_mask": None}


class Results:
    """Maker of dictionaries of all agents, from the engine's arrays of its first arena. Their arrays are copies."""

    def __init__(self, engine: Engine, names: Sequence[str], content: Infos) -> None:
        self._engine, self._names, self._content = engine, names, content
        self._config = config = engine.config
        # views of the engine's memory: `tick.play` writes the rewards by `rewards.reward`
        self._observations, self._masks, self._rewards = engine.observations[0], engine.masks[0], engine.rewards[0]
        self._parts, self._prey_parts = engine.parts[0], engine.prey_parts[0]
        self._rulings, self._verdicts = engine.ruling_rows, engine.ruling_rows[:, 1]  # its column of verdicts
        self._hunters = list(zip(names, range(config.hunters), config.controls, strict=False))
        self._prey = list(names[config.hunters :])
        self._team_by_seat = () if config.teams is None else config.team_by_seat
        self._hunters_stay = config.dropout_rate > 0.0 and config.dropouts == "fixed"
        self._shows_masks = config.mask_in_observation

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and unpickle by building the object again, since its views belong to the engine."""
        return Results, (self._engine, self._names, self._content)

    def rewards(self) -> dict[str, float]:
        """R6.2, R12.5: return the rewards of the last step."""
        return dict(zip(self._names, self._rewards.tolist()))  # noqa: B905 - half as fast with a check

    def observations(self) -> dict[str, Any]:
        """R7.1, R12.4: return the observations after the last step or reset."""
        seen = self._observations.copy()
        if self._prey:  # hunters and prey may have observations of different sizes
            sizes = [observation_size(self._config)] * len(self._hunters)
            sizes += [prey_observation_size(self._config)] * len(self._prey)
            observations = {agent: seen[row, : sizes[row]] for row, agent in enumerate(self._names)}
        else:
            observations = dict(zip(self._names, seen))  # noqa: B905
        if self._shows_masks:
            masks = self._masks.copy()
            for agent, seat, control in self._hunters:
                if control == "target":
                    observations[agent] = {"observation": observations[agent], "action_mask": masks[seat]}
        return observations

    def infos(self, truncated: Sequence[str]) -> dict[str, dict[str, Any]]:
        """R7.2: return the infos that `CatchArenaEnv` lists; for `truncated` agents, `TimeLimit.truncated` is True."""
        infos: dict[str, dict[str, Any]] = {}
        masks = self._masks.copy()
        if self._content != "full":
            infos |= {agent: {} for agent in self._names}
            for agent, seat, control in self._hunters:
                if self._content == "mask" and control != "velocity":
                    infos[agent]["action_mask"] = masks[seat]
            return infos
        verdicts, parts = self._verdicts.tolist(), self._parts.copy()
        rulings = self._rulings.astype(np.int64).tolist() if any(verdicts) else ()
        for agent, seat, control in self._hunters:
            if control == "velocity":
                info = _USUAL.copy()
            else:
                info = _USUAL_WITH_MASK.copy()
                info["action_mask"] = masks[seat]
            info["reward_parts"] = parts[seat]
            if verdicts[seat]:
                number, info["verdict"], info["distance_um"], info["winner"] = rulings[seat]
                info["target"] = number or -1
            infos[agent] = info
        if self._hunters_stay:
            active = self._engine.active[0].tolist()
            for agent, seat, _ in self._hunters:
                infos[agent]["active"] = active[seat]
        if self._team_by_seat:
            scores = self._engine.team_scores[0].tolist()
            for agent, seat, _ in self._hunters:
                infos[agent]["team_score"] = int(scores[self._team_by_seat[seat]])
        if self._prey:
            active, caught_by = self._engine.active[0].tolist(), self._engine.caught_by.tolist()
            parts = self._prey_parts.copy()
            for index, agent in enumerate(self._prey):
                infos[agent] = {
                    "active": active[len(self._hunters) + index],
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

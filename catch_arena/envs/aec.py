"""The arena as a PettingZoo AEC environment: PettingZoo's own wrappers, in which the call that gives an illegal action
also raises its error.
"""

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from catch_arena.config import ArenaConfig
from catch_arena.envs.dictionaries import Infos
from catch_arena.envs.parallel import CatchArenaEnv, SavedEpisode
from catch_arena.errors import ActionError, ConfigError, EpisodeError
from catch_arena.text import shortened


class CatchArenaAecEnv(OrderEnforcingWrapper):  # type: ignore[misc]
    """PettingZoo AEC environment of the arena, in which agents act one after the other and move together.

    Arguments, actions, observations and infos are those of `CatchArenaEnv`, and so are the methods `world`, `digest`,
    `withdraw`, `record` and `replay`.
    """

    _has_reset: bool
    _has_updated: bool

    def __init__(
        self,
        scenario: str | ArenaConfig = "standard",
        render_mode: str | None = None,
        *,
        infos: Infos = "full",
        agent_names: str | Sequence[str] | None = None,
        **overrides: object,
    ) -> None:
        parallel = CatchArenaEnv(scenario, render_mode, infos=infos, agent_names=agent_names, **overrides)
        super().__init__(parallel_to_aec_wrapper(parallel))
        self.world = parallel.world
        self.digest = parallel.digest
        self.withdraw = parallel.withdraw
        self.record = parallel.record
        self.replay = parallel.replay
        self._parallel = parallel
        self._constants = dict(vars(self.env))
        """Attributes of PettingZoo's wrapper that no episode changes."""

    @property
    def unwrapped(self) -> "_Unwrapped":
        """Parallel env together with the attributes of PettingZoo's wrapper."""
        return _Unwrapped(self.env)

    def _repr_html_(self) -> str:
        """Return the HTML that a notebook shows for the parallel env."""
        return self._parallel._repr_html_()

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; arguments as for the parallel env.

        Raises:
            ConfigError: as the parallel env's; no episode has begun then.
        """
        self.env.reset(seed, options)
        self._has_reset = self._has_updated = True

    def step(self, action: Any) -> None:
        """Take the action of the agent whose turn it is; an illegal action changes nothing.

        Raises:
            ActionError: for an action that is not legal.
            EpisodeError: outside an episode.
        """
        self._require_turn("step")
        self._has_updated = True  # a loop over the turns may go on after an illegal action too
        aec = self.env
        agent = aec.agent_selection
        if not aec.terminations[agent] and not aec.truncations[agent]:
            self._parallel.check_action(agent, action)  # else the last turn would raise, for another agent
        elif action is not None:
            raise ActionError(f"{agent}: an action must be None after the agent's end, got {shortened(action)}")
        aec.step(action)

    def last(self, observe: bool = True) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Return observation, reward, termination, truncation and info of the agent whose turn it is.

        Raises:
            EpisodeError: outside an episode.
        """
        self._require_turn("last")
        result: tuple[Any, float, bool, bool, dict[str, Any]] = super().last(observe)
        return result

    def observe(self, agent: str) -> Any:
        """Return the current observation of an agent.

        Raises:
            ActionError: for an unknown agent.
        """
        self._parallel.action_space(agent)  # raises for an unknown agent
        return super().observe(agent)

    def save(self) -> SavedEpisode:
        """R10.2: return the state of the episode, also between two turns. `restore` takes it any number of times, in
        this env or in another one of an equal config.

        Raises:
            EpisodeError: before the first reset.
        """
        turns = {name: value for name, value in vars(self.env).items() if name not in self._constants}
        return replace(self._parallel.save(), turns=copy.deepcopy(turns))

    def restore(self, saved: SavedEpisode) -> None:
        """Continue from a saved episode, bit for bit; `last` returns the same as before `save`.

        Raises:
            ConfigError: for anything that `save` did not return, and for the state of another config.
        """
        turns = getattr(saved, "turns", None)  # an old pickle has none
        if not isinstance(saved, SavedEpisode) or turns is None:
            raise ConfigError(f"saved must be a state that an AEC env's save() returned, got {shortened(saved)}")
        self._parallel.restore(replace(saved, turns=None))
        self.env.__dict__ = self._constants | copy.deepcopy(turns)
        self._has_reset = self._has_updated = True

    def clone(self) -> "CatchArenaAecEnv":
        """Return an independent env in the same state, without a window; `copy.deepcopy` does the same."""
        return copy.deepcopy(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Let a loop over the turns begin with a copied or unpickled env too, as after a reset."""
        self.__dict__.update(state, _has_updated=True)

    def _require_turn(self, method: str) -> None:
        if not self._has_reset:
            raise EpisodeError(f"cannot call {method}(): no episode has begun; call reset() first")
        if not self.agents:
            raise EpisodeError(f"cannot call {method}(): the episode is over; call reset() first")


class _Unwrapped:
    """Object that wrappers find as `unwrapped`: attributes of PettingZoo's wrapper, else those of the parallel env.

    PettingZoo's TerminateIllegalWrapper reads and writes these attributes, and PettingZoo's test does not accept a
    wrapper as `unwrapped`.
    """

    def __init__(self, aec: Any) -> None:
        object.__setattr__(self, "_aec", aec)

    def __getattr__(self, name: str) -> Any:
        aec = object.__getattribute__(self, "_aec")
        return getattr(aec if hasattr(aec, name) else aec.env, name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self._aec, name, value)


env = CatchArenaAecEnv
"""PettingZoo's name for the maker of an AEC environment."""

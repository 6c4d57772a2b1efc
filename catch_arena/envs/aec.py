"""The arena as a PettingZoo AEC environment: PettingZoo's own wrapper, with a bad action refused by the call that
gives it.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import CatchArenaEnv, SavedEpisode, parallel_env
from catch_arena.envs.results import Infos
from catch_arena.equality import equal_fields
from catch_arena.errors import ActionError, ConfigError, EpisodeError, require_type
from catch_arena.text import in_short


@dataclass(frozen=True, slots=True, eq=False)
class SavedTurn:
    """The result of `CatchArenaAecEnv.save`, which may be pickled and restored any number of times."""

    __eq__ = equal_fields
    __hash__ = None  # type: ignore[assignment]

    episode: SavedEpisode
    turns: dict[str, Any]
    """The agent whose turn it is, actions that were given and are not played yet, and results of the last step."""


class CatchArenaAecEnv(OrderEnforcingWrapper):  # type: ignore[misc]
    """The arena, hunter by hunter; `world`, `digest`, `withdraw`, `record` and `replay` are the parallel env's."""

    _has_reset: bool
    _has_updated: bool

    def __init__(self, parallel: CatchArenaEnv) -> None:
        require_type("parallel", parallel, CatchArenaEnv, "parallel_env(name)")
        super().__init__(_CheckedAec(parallel))
        self.world = parallel.world
        self.digest = parallel.digest
        self.withdraw = parallel.withdraw
        self.record = parallel.record
        self.replay = parallel.replay
        self._parallel = parallel

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the same as of the parallel env."""
        return self._parallel._repr_html_()

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; arguments as for the parallel env.

        Raises:
            ConfigError: as the parallel env's; nothing has begun then.
        """
        begun = self._has_reset, self._has_updated
        try:
            super().reset(seed, options)
        except ConfigError:
            self._has_reset, self._has_updated = begun
            raise

    def step(self, action: Any) -> None:
        """Take the action of the agent whose turn it is; an action that is refused changes nothing.

        Raises:
            ActionError: for an action that is not legal.
            EpisodeError: outside an episode.
        """
        self._require_turn("step")
        super().step(action)

    def last(self, observe: bool = True) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Return observation, reward, termination, truncation and info of the agent whose turn it is.

        Raises:
            EpisodeError: outside an episode.
        """
        self._require_turn("last")
        result: tuple[Any, float, bool, bool, dict[str, Any]] = super().last(observe)
        return result

    def observe(self, agent: str) -> Any:
        """Return what that agent sees.

        Raises:
            ActionError: for an unknown agent.
        """
        try:
            return super().observe(agent)
        except (KeyError, TypeError):
            self._parallel.action_space(agent)  # raises
            raise

    def save(self) -> SavedTurn:
        """R10.2: return the state of the episode, also between two turns; `restore` takes it, here or in an env of an
        equal config, any number of times.

        Raises:
            EpisodeError: before the first reset.
        """
        return SavedTurn(self._parallel.save(), self.env.save_turns())

    def restore(self, saved: SavedTurn) -> None:
        """Go on from a saved episode, bit for bit; `last` gives what it gave then.

        Raises:
            ConfigError: for anything but a result of `save`, and one of another config.
        """
        if not isinstance(saved, SavedTurn):
            raise ConfigError(f"saved must be what save gives, got {in_short(saved)}")
        self._parallel.restore(saved.episode)
        self.env.restore_turns(saved.turns)
        self._has_reset = self._has_updated = True

    def clone(self) -> "CatchArenaAecEnv":
        """Return an independent env in the same state, without a window; `copy.deepcopy` does the same."""
        return copy.deepcopy(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Let a loop over the turns begin with a copied or unpickled env too, as after a reset."""
        self.__dict__.update(state, _has_updated=True)

    def _require_turn(self, what: str) -> None:
        if not self._has_reset:
            raise EpisodeError(f"{what} must follow a reset: no episode has begun")
        if not self.agents:
            raise EpisodeError(f"{what} must follow a reset: this episode is over")


class _CheckedAec(parallel_to_aec_wrapper):  # type: ignore[misc]
    """The wrapper keeps the actions until the last seat's turn; a bad one would be refused to somebody else."""

    env: CatchArenaEnv

    def __init__(self, parallel: CatchArenaEnv) -> None:
        super().__init__(parallel)
        self._unchanging = frozenset(vars(self)) | {"_unchanging"}

    def save_turns(self) -> dict[str, Any]:
        """Return a copy of everything that an episode changes here."""
        return copy.deepcopy({name: value for name, value in vars(self).items() if name not in self._unchanging})

    def restore_turns(self, saved: dict[str, Any]) -> None:
        """Restore what `save_turns` returned."""
        self.__dict__ = {name: vars(self)[name] for name in self._unchanging} | copy.deepcopy(saved)

    @property
    def unwrapped(self) -> "_Unwrapped":
        """The parallel env, with what this wrapper keeps."""
        return _Unwrapped(self)

    def step(self, action: Any) -> None:
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            if action is not None:
                raise ActionError(f"{agent}: an action must be None after the end, got {action!r}")
        else:
            self.env.check_action(agent, action)
        super().step(action)


class _Unwrapped:
    """The `unwrapped` that wrappers find: attributes of this AEC env, else those of the parallel env.

    PettingZoo's TerminateIllegalWrapper reads and writes them there, and PettingZoo's test lets no wrapper be
    `unwrapped`.
    """

    def __init__(self, aec: _CheckedAec) -> None:
        object.__setattr__(self, "_aec", aec)

    def __getattr__(self, name: str) -> Any:
        aec: _CheckedAec = object.__getattribute__(self, "_aec")
        return getattr(aec if hasattr(aec, name) else aec.env, name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self._aec, name, value)


def env(
    scenario: str | ArenaConfig = "standard",
    render_mode: str | None = None,
    *,
    infos: Infos = "full",
    agent_names: str | Sequence[str] | None = None,
    **overrides: object,
) -> CatchArenaAecEnv:
    """The arena as a PettingZoo AEC environment, in which the hunters are asked one after the other and move
    together; arguments as for `parallel_env`.
    """
    return CatchArenaAecEnv(parallel_env(scenario, render_mode, infos=infos, agent_names=agent_names, **overrides))

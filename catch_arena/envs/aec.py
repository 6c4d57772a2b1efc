"""The arena as a PettingZoo AEC environment: PettingZoo's own wrapper, with a bad action refused by the call that
gives it.
"""

from typing import Any

from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import CatchArenaEnv, Infos, parallel_env
from catch_arena.errors import ActionError, EpisodeError


class CatchArenaAecEnv(OrderEnforcingWrapper):  # type: ignore[misc]
    """The arena, hunter by hunter; `world`, `digest`, `withdraw`, `record` and `replay` are the parallel env's."""

    def __init__(self, parallel: CatchArenaEnv) -> None:
        super().__init__(_CheckedAec(parallel))
        self.world = parallel.world
        self.digest = parallel.digest
        self.withdraw = parallel.withdraw
        self.record = parallel.record
        self.replay = parallel.replay
        self._parallel = parallel

    def _repr_html_(self) -> str:
        """How a notebook shows it: like the parallel env."""
        return self._parallel._repr_html_()

    def step(self, action: Any) -> None:
        """The action of the hunter whose turn it is; one that is refused changes nothing.

        Raises:
            ActionError: for an action that is not legal.
            EpisodeError: outside an episode.
        """
        self._require_turn("step")
        super().step(action)

    def last(self, observe: bool = True) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """What the hunter whose turn it is sees.

        Raises:
            EpisodeError: outside an episode.
        """
        self._require_turn("last")
        result: tuple[Any, float, bool, bool, dict[str, Any]] = super().last(observe)
        return result

    def _require_turn(self, what: str) -> None:
        if not self._has_reset:
            raise EpisodeError(f"{what} must follow a reset: no episode has begun")
        if not self.agents:
            raise EpisodeError(f"{what} must follow a reset: this episode is over")


class _CheckedAec(parallel_to_aec_wrapper):  # type: ignore[misc]
    """The wrapper keeps the actions until the last seat's turn; a bad one would be refused to somebody else."""

    env: CatchArenaEnv

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
    """What wrappers find as `unwrapped`: the parallel env, and before it all that an AEC env keeps, to read and to
    write. PettingZoo's TerminateIllegalWrapper does both there, and PettingZoo's test lets no wrapper be `unwrapped`.
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
    **overrides: object,
) -> CatchArenaAecEnv:
    """The arena as a PettingZoo AEC environment, in which the hunters are asked one after the other and move
    together; arguments as for `parallel_env`.
    """
    return CatchArenaAecEnv(parallel_env(scenario, render_mode, infos=infos, **overrides))

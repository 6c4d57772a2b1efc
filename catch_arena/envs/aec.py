"""The arena as a PettingZoo AEC environment: PettingZoo's own wrapper, with a bad action refused by the call that
gives it.
"""

from typing import Any

from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import CatchArenaEnv, parallel_env
from catch_arena.errors import ActionError


class _CheckedAec(parallel_to_aec_wrapper):  # type: ignore[misc]
    """The wrapper keeps the actions until the last seat's turn; a bad one would be refused to somebody else."""

    env: CatchArenaEnv

    def step(self, action: Any) -> None:
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            if action is not None:
                raise ActionError(f"{agent}: an action must be None after the end, got {action!r}")
        else:
            self.env.check_action(agent, action)
        super().step(action)


def env(
    scenario: str | ArenaConfig = "standard", render_mode: str | None = None, **overrides: object
) -> OrderEnforcingWrapper[str, Any, Any]:
    """The arena as a PettingZoo AEC environment, in which the hunters are asked one after the other and move
    together; arguments as for `parallel_env`.
    """
    return OrderEnforcingWrapper(_CheckedAec(parallel_env(scenario, render_mode, **overrides)))

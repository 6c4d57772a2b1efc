"""PettingZoo's parallel and AEC environments, and VectorArena, the batch as arrays, over the engine.

- parallel: PettingZoo's parallel environment; aec: the same hunter by hunter. vector: VectorArena.
- spaces: the spaces, and the check of an action against them. infos: made when somebody asks for them.
  saved: the check of a saved state.
- global_state: R7.3's view of a whole arena.

Importing this package registers every scenario with PettingZoo: `pettingzoo.make("parallel",
"catch_arena/standard_v1")`.
"""

from pettingzoo.env_registry.registration import register

from catch_arena.config import RULESET
from catch_arena.scenarios import SCENARIOS

_package, _, _version = RULESET.rpartition("_")
for _name in SCENARIOS:
    for _api, _made_by in (("parallel", "parallel:parallel_env"), ("aec", "aec:env")):
        register(_api, f"{_package}/{_name}_{_version}", f"catch_arena.envs.{_made_by}", kwargs={"scenario": _name})

"""Registration of the scenarios with PettingZoo, by `import catch_arena.envs.registration`: then
`pettingzoo.make("parallel", "catch_arena/standard_v1")` makes an env, and `pettingzoo.make("aec", ...)` an AEC env.
"""

from pettingzoo.env_registry.registration import register

from catch_arena.config import RULESET
from catch_arena.scenarios import SCENARIOS

_PACKAGE, _, _VERSION = RULESET.rpartition("_")
for _name in SCENARIOS:
    for _api, _entry in (("parallel", "parallel:parallel_env"), ("aec", "aec:env")):
        register(_api, f"{_PACKAGE}/{_name}_{_VERSION}", f"catch_arena.envs.{_entry}", kwargs={"scenario": _name})

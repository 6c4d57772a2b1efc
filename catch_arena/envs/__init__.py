"""PettingZoo's parallel and AEC environments, and VectorArena, the batch as arrays, over the engine.

- parallel: PettingZoo's parallel environment; aec: the same hunter by hunter. vector: VectorArena.
- spaces: the spaces, and the check of an action against them. infos: made when somebody asks for them.
- global_state: R7.3's view of a whole arena.

Importing this package registers every scenario with PettingZoo: `pettingzoo.make("parallel",
"catch_arena/standard_v1")`.
"""

from pettingzoo.env_registry.registration import register

from catch_arena.scenarios import SCENARIOS

for _name in SCENARIOS:
    register(
        "parallel",
        f"catch_arena/{_name}_v1",
        "catch_arena.envs.parallel:parallel_env",
        kwargs={"scenario": _name},
    )
    register("aec", f"catch_arena/{_name}_v1", "catch_arena.envs.aec:env", kwargs={"scenario": _name})

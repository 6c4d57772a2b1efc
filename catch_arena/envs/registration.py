"""Registration of the scenarios with PettingZoo: `pettingzoo.make("parallel", "catch_arena/standard_v1")`."""

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec
    from types import ModuleType

_REGISTRY = "pettingzoo.env_registry"


def register_scenarios() -> None:
    """Register every scenario now if PettingZoo is loaded, and otherwise when it is loaded. PettingZoo's import takes a
    quarter of a second, which `import catch_arena` does not spend.
    """
    if _REGISTRY in sys.modules:
        _register()
    else:
        sys.meta_path.insert(0, _AfterPettingZoo)


class _AfterPettingZoo:
    """An import hook that registers the scenarios after PettingZoo's registry has been executed."""

    @classmethod
    def find_spec(cls, name: str, path: object = None, target: object = None) -> "ModuleSpec | None":
        """Wrap the loader of the registry, once; every other module is left to the usual finders."""
        del path, target
        if name != _REGISTRY:
            return None
        from importlib.util import find_spec

        sys.meta_path.remove(cls)
        spec = find_spec(name)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def execute_and_register(module: "ModuleType") -> None:
                execute(module)
                _register()

            spec.loader.exec_module = execute_and_register  # type: ignore[method-assign]
        return spec


def _register() -> None:
    from pettingzoo.env_registry.registration import register

    from catch_arena.config import RULESET
    from catch_arena.scenarios import SCENARIOS

    package, _, version = RULESET.rpartition("_")
    for name in SCENARIOS:
        for api, made_by in (("parallel", "parallel:parallel_env"), ("aec", "aec:env")):
            register(api, f"{package}/{name}_{version}", f"catch_arena.envs.{made_by}", kwargs={"scenario": name})

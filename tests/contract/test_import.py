"""Importing the package is cheap, and gives the names that type checkers see; one module registers the scenarios."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import catch_arena
from catch_arena.files import tomllib


def test_the_import_is_light():
    """The heavy libraries load on first use."""
    code = (
        "import sys, catch_arena; catch_arena.scenario('duel');"
        "heavy = {'numba', 'numpy', 'pygame', 'cv2', 'av', 'gymnasium', 'pettingzoo'} & set(sys.modules);"
        "sys.exit(f'loaded: {heavy}' if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    "order", ["catch_arena.envs.registration, pettingzoo", "pettingzoo, catch_arena.envs.registration"]
)
def test_an_import_registers_every_scenario_with_pettingzoo(order):
    """In either order, in both interfaces, and once."""
    code = (
        f"import sys, {order};"
        "from pettingzoo.env_registry.registration import aec_registry, parallel_registry;"
        "made = [pettingzoo.make(api, 'catch_arena/duel_v1') for api in ('parallel', 'aec')];"
        "found = aec_registry, parallel_registry;"
        "names = [{key for key in one if key.startswith('catch_arena')} for one in found];"
        "wanted = {f'catch_arena/{name}-v1' for name in catch_arena.SCENARIOS};"
        "sys.exit(names != [wanted, wanted] or str(made[0]) != 'catch_arena_v1')"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


def test_every_public_name_is_what_type_checkers_are_told():
    """Else an editor would show another thing than the one that is loaded."""
    tree = ast.parse(Path(catch_arena.__file__).read_text())
    (guard,) = (node for node in tree.body if isinstance(node, ast.If))
    home = {name.asname: node.module for node in guard.body for name in node.names if name.asname}
    assert sorted(home) == catch_arena.__all__
    for name, module in home.items():
        assert getattr(catch_arena, name) is getattr(import_module(module), name)
        assert name in dir(catch_arena)


def test_every_package_is_in_a_wheel():
    """pyproject.toml lists them, and folders of data alone; a checkout runs without its list."""
    root = Path(catch_arena.__file__).parent
    listed = tomllib.loads((root.parent / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    files = [path for path in root.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    here = {".".join(path.parent.relative_to(root.parent).parts) for path in files}
    top = [*(root.parent / "docs").rglob("*.md"), *(root.parent / "agents").rglob("*.py")]  # of the repository
    moved = {".".join(("catch_arena", *path.parent.relative_to(root.parent).parts)) for path in top}
    assert listed == sorted({*here, *moved})

"""Every script can be imported."""

import runpy
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "scripts"
LOADED = sorted(path.relative_to(SCRIPTS).as_posix() for path in SCRIPTS.rglob("*.py"))


@pytest.fixture
def forget_modules():
    """Forget the modules that a script imports from its own folder, since several have the same names."""
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if (getattr(sys.modules[name], "__file__", None) or "").startswith(str(SCRIPTS)):
            del sys.modules[name]


@pytest.mark.usefixtures("forget_modules")
@pytest.mark.parametrize("name", LOADED)
def test_it_can_be_loaded(name, monkeypatch):
    path = SCRIPTS / name
    monkeypatch.syspath_prepend(path.parent)
    runpy.run_path(str(path), run_name="loaded")

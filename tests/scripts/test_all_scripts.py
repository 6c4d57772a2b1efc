"""Every script can be loaded: what it takes from the package is there."""

import runpy
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "scripts"
LEFT_OUT = {
    "train_ppo.py": "needs torch: tests/scripts/test_training_scripts.py runs it",
}
LOADED = sorted(path.relative_to(SCRIPTS).as_posix() for path in SCRIPTS.rglob("*.py"))
LOADED = [name for name in LOADED if name not in LEFT_OUT]


@pytest.fixture
def forget_modules():
    """Those that a script imports from its own folder: several have modules of one name."""
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


def test_what_is_left_out_is_there():
    assert [name for name in LEFT_OUT if not (SCRIPTS / name).is_file()] == []

"""How the core is compiled and kept: by its sources, apart from code that tests its indices, and not for ever."""

import os
import subprocess
import sys
import time
from pathlib import Path

from catch_arena.core import jit

ROOT = Path(__file__).parents[2]
BEYOND = """
import numpy as np
from catch_arena.core.jit import CACHE_DIRECTORY, entry, phase

@phase
def write(block, place):
    block[place] = 1.0

@entry
def write_beyond(block, place):
    write(block[:place], place)

try:
    write_beyond(np.zeros(8), 4)
    print("nothing noticed", CACHE_DIRECTORY)
except IndexError:
    print("noticed", CACHE_DIRECTORY)
"""


def run_beyond(folder, *, checked, cache):
    """What BEYOND prints, compiled."""
    script = folder / "beyond.py"
    script.write_text(BEYOND, encoding="utf-8")
    settings = {"NUMBA_BOUNDSCHECK": str(int(checked)), "NUMBA_DISABLE_JIT": "0", "NUMBA_CACHE_DIR": str(cache)}
    finished = subprocess.run(
        [sys.executable, script],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **settings},
    )
    return finished.stdout.strip()


def test_indices_are_tested_where_that_was_asked_for(tmp_path):
    """NUMBA_BOUNDSCHECK=1, though the same function was compiled and kept without it before; and not after it."""
    careless, careful, again = (run_beyond(tmp_path, checked=asked, cache=tmp_path) for asked in (False, True, False))
    assert careless == again
    assert careless.startswith("nothing noticed /")
    assert careful.startswith("noticed /")
    assert careful.split()[-1] != careless.split()[-1]


def test_the_rules_are_compiled_where_nothing_can_be_kept(tmp_path):
    """The cache's place is a file."""
    (tmp_path / "a file").write_text("", encoding="utf-8")
    assert run_beyond(tmp_path, checked=False, cache=tmp_path / "a file") == "nothing noticed None"


def test_compiled_code_is_kept_in_a_folder_for_each_state_of_the_sources(tmp_path, monkeypatch):
    """The same folder every time; elsewhere than the last version's, which goes when it has not been used for long."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    old, recent, foreign = (tmp_path / name for name in ("core-0123456789abcdef", "core-fedcba9876543210", "mine"))
    for folder in (old, recent, foreign):
        folder.mkdir()
    two_months_ago = time.time() - 60 * 24 * 3600
    for folder in (old, foreign):
        os.utime(folder, (two_months_ago, two_months_ago))
    folder = jit._cache_directory()
    assert folder == jit._cache_directory()
    assert folder.parent == tmp_path
    assert sorted(tmp_path.iterdir()) == sorted([folder, recent, foreign])


def test_nothing_is_kept_in_a_folder_of_somebody_else(tmp_path, monkeypatch):
    """One that can be seen, but not written."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(os, "access", lambda _, mode: mode != os.W_OK)
    assert jit._cache_directory() is None

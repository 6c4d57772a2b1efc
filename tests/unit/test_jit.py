"""Compiled code is kept by the digest of its sources, compiled again when damaged, never loaded from strangers."""

import ast
import logging
import os
import pickle
import random
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

from catch_arena.core import cache, cache_folder
from catch_arena.core.jit import entry
from catch_arena.core.modes import INTERPRETED

ROOT = Path(__file__).parents[2]
BEYOND = """
import numpy as np
from catch_arena.core.addresses import by_address
from catch_arena.core.cache_folder import CACHE_DIRECTORY
from catch_arena.core.jit import entry, phase

@phase
def write(block, place):
    block[place] = 1.0

@entry
def write_beyond(block, place):
    write(by_address(block)[:place], place)

try:
    write_beyond(np.zeros(8), 4)
    print("nothing noticed", CACHE_DIRECTORY)
except IndexError:
    print("noticed", CACHE_DIRECTORY)
"""


def beyond(folder, *, checked, cache, code=BEYOND):
    """Run BEYOND, compiled."""
    script = folder / "beyond.py"
    script.write_text(code, encoding="utf-8")
    settings = {"NUMBA_BOUNDSCHECK": str(int(checked)), "NUMBA_DISABLE_JIT": "0", "NUMBA_CACHE_DIR": str(cache)}
    return subprocess.run(
        [sys.executable, script],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **settings},
    )


def run_beyond(folder, *, checked, cache):
    """Output of BEYOND, compiled."""
    return beyond(folder, checked=checked, cache=cache).stdout.strip()


def test_indices_are_tested_where_that_was_asked_for(tmp_path):
    """NUMBA_BOUNDSCHECK=1, though the same function was compiled and kept without it before; and not after it."""
    careless, careful, again = (run_beyond(tmp_path, checked=checks, cache=tmp_path) for checks in (False, True, False))
    assert careless == again
    assert careless.startswith("nothing noticed /")
    assert careful.startswith("noticed /")
    assert careful.split()[-1] != careless.split()[-1]


def test_the_rules_are_compiled_where_nothing_can_be_kept(tmp_path):
    """The cache's place is a file."""
    (tmp_path / "a file").write_text("", encoding="utf-8")
    assert run_beyond(tmp_path, checked=False, cache=tmp_path / "a file") == "nothing noticed None"


def test_compiled_code_is_kept_in_a_folder_for_each_state_of_the_sources(tmp_path, monkeypatch):
    """The folder is the same every time; the folders that were used last stay too, though the clock may jump."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    others = [tmp_path / f"core-{number:016x}" for number in range(cache_folder._MOST_KEPT + 4)]
    (tmp_path / "mine").mkdir()
    for used, folder in enumerate(others):
        folder.mkdir()
        os.utime(folder, (used, used))
    folder = cache_folder._cache_directory()
    assert folder == cache_folder._cache_directory()
    assert folder.parent == tmp_path
    assert sorted(tmp_path.iterdir()) == sorted([folder, *others[5:], tmp_path / "mine"])


def test_an_edit_in_any_file_that_the_core_reads_makes_another_folder(tmp_path, monkeypatch):
    """Each file of core/ in a copy of the package is edited, and each file that these import."""
    package = tmp_path / "catch_arena"
    shutil.copytree(ROOT / "catch_arena" / "core", package / "core", ignore=shutil.ignore_patterns("__pycache__"))
    for source in (ROOT / "catch_arena").glob("*.py"):
        shutil.copy(source, package)
    monkeypatch.setattr(cache_folder, "__file__", str(package / "core" / "cache_folder.py"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    core = sorted((package / "core").glob("*.py"))
    imports = {
        node.module
        for source in core
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module
    }
    outside = sorted(re.findall(r"catch_arena\.(?!core)(\w+)", " ".join(imports)))
    assert "layout" in outside
    read = [*core, *(package / f"{module}.py" for module in outside)]
    folders = {cache_folder._cache_directory()}
    for source in read:
        with source.open("a", encoding="utf-8") as edited:
            edited.write("# edited\n")
        folders.add(cache_folder._cache_directory())
    assert len(folders) == 1 + len(read)


def test_nothing_is_kept_in_a_folder_of_somebody_else(tmp_path, monkeypatch):
    """The folder can be read, but not written."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(os, "access", lambda _, mode: mode != os.W_OK)
    assert cache_folder._cache_directory() is None


def test_code_in_a_folder_that_can_only_be_read_is_used(tmp_path, monkeypatch):
    """As in the image of a container."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = cache_folder._cache_directory()
    (folder / "core").mkdir()
    (folder / "core" / "run.nbi").touch()
    monkeypatch.setattr(os, "access", lambda _, mode: mode != os.W_OK)
    assert cache_folder._cache_directory() == folder


@pytest.fixture
def without_a_home(tmp_path, monkeypatch):
    """Nothing can be written there; temporary files go to a folder that is returned."""
    (tmp_path / "a file").write_text("", encoding="utf-8")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda *_, **__: str(tmp_path / "a file" / "cache"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_without_a_home_that_can_be_written_it_is_kept_among_temporary_files(without_a_home):
    folder = cache_folder._cache_directory()
    assert folder == cache_folder._cache_directory()
    assert folder.parent == without_a_home / f"catch-arena-{os.getuid()}"
    assert folder.parent.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    "prepare",
    [lambda folder: folder.mkdir(mode=0o700) or folder.chmod(0o777), lambda folder: folder.symlink_to("/var")],
)
def test_it_is_not_kept_where_somebody_else_could_have_put_code(without_a_home, prepare):
    """Compiled code that is loaded runs as this user."""
    prepare(without_a_home / f"catch-arena-{os.getuid()}")
    assert cache_folder._cache_directory() is None


def test_a_disk_without_room_for_it_is_told_and_the_rules_run(tmp_path):
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, ({}, resource.RLIM_INFINITY))\n"
    there_again = limit.format("resource.RLIM_INFINITY")  # for what coverage writes at the end
    code = limit.format(10) + BEYOND + there_again
    finished = beyond(tmp_path, checked=False, cache=tmp_path / "cache", code=code)
    assert finished.stdout.startswith("nothing noticed /")
    (line,) = finished.stderr.splitlines()
    assert line.startswith(f"catch_arena: compiled rules cannot be kept in {tmp_path}/cache/core-")
    assert ": File too large; every start compiles them again" in line


def total_of(row):
    """Function that is compiled and kept."""
    total = 0
    for value in row:
        total += value
    return total


@pytest.fixture
def hits(tmp_path, monkeypatch):
    """Function that returns True if a new process finds it in the cache, which is empty at first."""
    monkeypatch.setattr(cache, "CACHE_DIRECTORY", tmp_path)

    def call(row):
        compiled = entry(total_of)
        assert compiled(np.array(row)) == sum(row)
        return bool(compiled.stats.cache_hits)

    return call


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_a_thread_other_than_the_main_one_can_compile_and_keep(hits):
    """Such as that of a server; only the main thread may handle signals."""
    with ThreadPoolExecutor(1) as pool:
        assert [pool.submit(hits, [1.5, 2.0]).result() for _ in range(2)] == [False, True]


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_kept_code_is_read_without_writing_anything(hits, monkeypatch):
    assert not hits([1.5, 2.0])

    def refuse(*_, **__):
        raise OSError

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)  # with which Numba tries whether a folder can be written
    assert hits([1.5, 2.0])


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda _: b"", id="empty"),
        pytest.param(lambda content: content[: len(content) // 2], id="truncated"),
        pytest.param(lambda content: random.Random(1).randbytes(len(content)), id="random"),
        pytest.param(
            lambda content: content[: len(content) // 2] + bytes(64) + content[len(content) // 2 + 64 :], id="a gap"
        ),
        pytest.param(lambda _: pickle.dumps({"of": "another kind"}), id="another pickle"),
    ],
)
def test_what_is_damaged_in_the_cache_is_compiled_again_and_replaced(tmp_path, hits, suffix, damage):
    """A crash of the machine can leave such files."""
    assert [hits([1.5, 2.0]), hits([1.5, 2.0])] == [False, True]
    (file,) = tmp_path.rglob(f"*.{suffix}")
    file.write_bytes(damage(file.read_bytes()))
    assert [hits([1.5, 2.0]), hits([1.5, 2.0])] == [False, True]


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_code_for_other_arguments_under_a_file_s_name_is_not_run(tmp_path, hits):
    """Two processes that save at the same time can leave such a file."""
    assert not hits([1.5, 2.0])
    assert not hits([1, 2])
    of_floats, of_integers = sorted(tmp_path.rglob("*.nbc"))
    of_floats.write_bytes(of_integers.read_bytes())
    assert [hits([1.5, 2.0]), hits([1.5, 2.0])] == [False, True]


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_a_damaged_cache_that_cannot_be_replaced_is_told_and_the_rules_run(tmp_path, hits, capsys):
    """The index is a folder."""
    assert not hits([1.5, 2.0])
    (index,) = tmp_path.rglob("*.nbi")
    index.unlink()
    index.mkdir()
    cache._warn_not_kept.cache_clear()
    assert [hits([1.5, 2.0]), hits([1.5, 2.0])] == [False, False]
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"catch_arena: compiled rules cannot be kept in {tmp_path}: Is a directory; every start")


def test_numba_writes_no_debug_lines_for_the_root_logger(caplog):
    """A program that sets the root logger to DEBUG got megabytes of byte code."""
    caplog.set_level(logging.DEBUG)

    assert numba.njit(lambda number: number + 1)(1) == 2
    assert [record.name for record in caplog.records] == []


def test_a_level_that_somebody_gave_numbas_logger_stays():
    """A program that sets the level itself gets these lines."""
    given = "import logging; log = logging.getLogger('numba'); log.setLevel(logging.DEBUG); "
    code = f"{given}import catch_arena.core.jit; print(log.level == logging.DEBUG)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert result.stdout == "True\n"

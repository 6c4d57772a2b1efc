"""The core compiled as one piece: the same results as in Numba's own way and in plain Python."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from llvmlite import binding as llvm

from catch_arena.config import ArenaConfig
from catch_arena.core import compiler
from catch_arena.core.addresses import by_address
from catch_arena.core.jit import WHOLE, phase
from catch_arena.core.memory import settings_in
from catch_arena.core.modes import COMPILER, INTERPRETED
from catch_arena.core.state import ALL_OPTIONS, NO_OPTIONS
from catch_arena.engine.core_settings import settings_of

ROOT = Path(__file__).parents[2]
SMALL = """
import sys
import numpy as np
from catch_arena.core.addresses import by_address
from catch_arena.core.jit import entry, phase, outlined, rule

@rule
def thrice(value):
    return 3.0 * value + 0.1

@phase
def part_of(block, which):
    return block[4 * which : 4 * which + 4]

@phase
def fill(block, which):
    part = part_of(block, which)
    for i in range(len(part)):
        part[i] = thrice(part[i] + which)

@outlined
def turn_round(block):
    for i in range(len(block) // 2):
        block[i], block[len(block) - 1 - i] = block[len(block) - 1 - i], block[i]

@entry
def sum_up(block):
    total = 0.0
    for value in block:
        total += value
    return total

@entry
def work(given):
    block = by_address(given)
    for which in range(len(block) // 4):
        fill(block, which)
    if block[0] < 100.0:
        turn_round(block)
    return sum_up(given)

block = np.linspace(0.3, 7.7, 16)
print(work(block), block.tobytes().hex())
"""


def run_small(folder, before="", **settings):
    """Output of SMALL after the statements `before`."""
    script = folder / "small.py"
    script.write_text(before + SMALL, encoding="utf-8")
    return subprocess.run(
        [sys.executable, script],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder), **settings},
    ).stdout


@pytest.mark.skipif("CATCH_ARENA_COMPILER" in os.environ, reason="another way is chosen")
def test_this_numba_has_what_is_needed():
    """Otherwise the first start takes four times as long, and nothing else would show it."""
    assert COMPILER is compiler


def test_the_bits_are_those_of_numbas_own_way_and_of_plain_python(tmp_path):
    """The second run reads them from the cache."""
    compiled, cached = run_small(tmp_path), run_small(tmp_path)
    assert compiled == cached
    assert compiled == run_small(tmp_path, CATCH_ARENA_COMPILER="numba")
    assert compiled == run_small(tmp_path, NUMBA_DISABLE_JIT="1")


@pytest.mark.parametrize(
    "missing",
    [
        "numba.core.untyped_passes.WithLifting",
        "numba.core.typed_passes.NativeLowering",
        "numba.core.codegen.JITCodeLibrary",
        "numba.core.compiler.DefaultPassBuilder",
        "numba.core.codegen.CPUCodegen._module_pass_manager",
        "numba.core.ir_utils.guard",
        "numba._dynfunc.make_function",
        "numba.core.caching.Cache._load_overload",
    ],
)
def test_a_numba_that_lacks_something_selects_its_own_way(missing, tmp_path):
    """A name that is only used at the end of a compilation counts too."""
    owner, _, name = missing.rpartition(".")
    before = f"import pkgutil, numba\ndelattr(pkgutil.resolve_name({owner!r}), {name!r})\n"
    before += "from catch_arena.core.modes import COMPILER\nprint(COMPILER)\n"
    assert run_small(tmp_path, before, NUMBA_DISABLE_JIT="1").startswith("None\n")


def test_a_numba_with_another_cache_keeps_code_in_its_own_way(tmp_path):
    before = "import numba.core.caching\ndel numba.core.caching.InTreeCacheLocator\n"
    before += "from catch_arena.core.jit import cache\nprint(cache)\n"
    assert run_small(tmp_path, before, NUMBA_DISABLE_JIT="1").startswith("None\n")


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
@pytest.mark.parametrize(
    "part",
    [
        lambda s: s.missing if s.prey > 0 else s.hunters,
        lambda s: s.hunters if s.dropout_rate == 0.0 else s.missing,
        lambda s: s.missing if s.has_teams else s.hunters,
        lambda s: s.missing if s.has_teams and s.hunters > 1 else s.hunters,
    ],
)
def test_a_branch_that_is_taken_for_numbers_above_zero_alone_is_not_compiled_where_they_are_zero(part):
    """`missing` cannot be compiled: nobody has such a field."""
    inner = phase(part)

    @numba.njit(**WHOLE)
    def whole(numbers, options):
        return inner(settings_in(by_address(numbers), options))

    numbers = np.array(settings_of(ArenaConfig(hunters=3)), dtype=np.float64)
    assert whole(numbers, NO_OPTIONS) == 3
    with pytest.raises(numba.TypingError, match="missing"):
        whole(numbers, ALL_OPTIONS)


def test_an_interrupt_while_llvm_takes_over_a_module_lets_nobody_free_it_again():
    """LLVM frees what is linked; llvmlite would do so too, if it were not told, and the process would crash."""
    linked = llvm.parse_assembly("")

    def link_in(_):
        raise KeyboardInterrupt

    library = SimpleNamespace(_final_module=SimpleNamespace(link_in=link_in))
    with pytest.raises(KeyboardInterrupt):
        compiler._Translated.add_llvm_module(library, linked)
    assert linked.closed


@pytest.mark.skipif(INTERPRETED or COMPILER is None, reason="LLVM makes nothing of ours")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_llvm_makes_machine_code_counts_behind_it(monkeypatch, number):
    """LLVM calls back into Python then, where what is raised is lost: the program played on, and was told that nothing
    can be kept.
    """

    class Ended(BaseException):
        pass

    def end(*_):
        raise Ended

    made = []

    def interrupted(self):
        signal.raise_signal(number)
        finish(self)
        made.append(self)

    finish = compiler.Whole._finalize_final_module
    monkeypatch.setattr(compiler.Whole, "_finalize_final_module", interrupted)
    before = signal.signal(number, end)
    try:
        with pytest.raises(Ended):
            numba.njit(**WHOLE)(lambda value: value + 1.0)(2.0)
        assert len(made) == 1
        assert signal.getsignal(number) is end
    finally:
        signal.signal(number, before)

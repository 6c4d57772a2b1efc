"""Each variant of the rules is compiled once, and a line says so."""

import pytest

from catch_arena.core import cache
from catch_arena.core.compiler import INTERPRETED
from catch_arena.core.jit import entry
from catch_arena.engine import compiling
from catch_arena.engine.compiling import Variant, compile_once

pytestmark = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")

ONE, BATCH, ALL_FOR_ONE = Variant(batch=False, options=False), Variant(batch=True, options=False), Variant(False, True)


@pytest.fixture(autouse=True)
def new_process(monkeypatch):
    """Nothing is compiled."""
    monkeypatch.setattr(compiling, "_compiled", set())


@pytest.mark.parametrize(
    ("variant", "line"),
    [(BATCH, "the common rules for a batch: about 5 s"), (ALL_FOR_ONE, "all rules for one arena: about 7 s")],
)
def test_a_line_says_how_long_it_takes_if_something_is_compiled(capsys, tmp_path, monkeypatch, variant, line):
    monkeypatch.setattr(cache, "CACHE_DIRECTORY", tmp_path)

    @entry
    def add_one(value):
        return value + 1

    @entry
    def add_two(value):
        return value + 2

    compile_once(variant, lambda: (add_one(1), add_two(1)))
    message = f"catch_arena: compiling {line}, and longer on a slow or busy machine; {compiling._KEPT}\n"
    assert capsys.readouterr().err == message
    compile_once(ONE, lambda: (add_one(2), add_two(2)))
    assert capsys.readouterr().err == ""


def test_the_line_is_printed_where_nothing_is_kept(capsys, monkeypatch):
    monkeypatch.setattr(compiling, "CACHE_DIRECTORY", None)
    compile_once(ONE, lambda: None)
    assert capsys.readouterr().err.startswith("catch_arena: compiling the common rules for one arena")


def test_what_was_interrupted_is_compiled_again_and_then_never():
    """Ctrl-C in a notebook, and the same call again."""
    plays = []

    def play():
        compile_once(ONE, play)  # as the engine that is played does
        plays.append(len(plays))
        if len(plays) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compile_once(ONE, play)
    for _ in range(2):
        compile_once(ONE, play)
    assert plays == [0, 1]

"""A line says that rules are compiled, once for each variant."""

import gc

import pytest

from catch_arena.core import cache, cache_folder
from catch_arena.core.jit import entry
from catch_arena.core.modes import INTERPRETED
from catch_arena.engine import compiling
from catch_arena.engine.compiling import announced

pytestmark = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")


@pytest.fixture(autouse=True)
def new_process():
    """No line has been printed."""
    compiling._announce.cache_clear()
    yield
    compiling._announce.cache_clear()


@pytest.mark.parametrize(
    ("batch", "all_rules", "line"),
    [
        (True, False, "the common rules for a batch: about 5 s"),
        (False, True, "all rules for one arena: about 7 s"),
    ],
)
def test_a_line_says_how_long_it_takes_if_something_is_compiled(capsys, tmp_path, monkeypatch, batch, all_rules, line):
    monkeypatch.setattr(cache, "CACHE_DIRECTORY", tmp_path)

    @entry
    def add_one(value):
        return value + 1

    @entry
    def add_two(value):
        return value + 2

    with announced(batch=batch, all_rules=all_rules):
        add_one(1)
        add_two(1)
    message = f"catch_arena: compiling {line}, and longer on a slow or busy machine; {compiling._KEPT}\n"
    assert capsys.readouterr().err == message
    with announced(batch=False, all_rules=False):
        add_one(2)
        add_two(2)
    assert capsys.readouterr().err == ""


def test_the_line_is_printed_once_where_nothing_is_kept(capsys, monkeypatch):
    monkeypatch.setattr(compiling, "CACHE_DIRECTORY", None)
    for _ in range(2):
        with announced(batch=False, all_rules=False):
            pass
    assert capsys.readouterr().err.count("catch_arena: compiling the common rules for one arena") == 1


def test_an_interrupted_compilation_leaves_no_trace():
    """Ctrl-C in a notebook, and the same call again."""
    with pytest.raises(KeyboardInterrupt), announced(batch=True, all_rules=True):
        raise KeyboardInterrupt
    assert gc.isenabled()
    assert not cache_folder.on_miss

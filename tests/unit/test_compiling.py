"""A line says that rules are compiled, once for each variant."""

import gc

import pytest

import catch_arena
from catch_arena.core import cache, cache_folder, compiling
from catch_arena.core.compiling import announced
from catch_arena.core.jit import entry
from catch_arena.core.modes import INTERPRETED

pytestmark = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")


@pytest.fixture(autouse=True)
def new_process():
    """No line has been printed."""
    compiling._announce.cache_clear()
    yield
    compiling._announce.cache_clear()


def test_a_line_says_how_long_it_takes_if_something_is_compiled(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "CACHE_DIRECTORY", tmp_path)

    @entry
    def add_one(value):
        return value + 1

    @entry
    def add_two(value):
        return value + 2

    with announced("some rules", 5):
        add_one(1)
        add_two(1)
    message = f"catch_arena: compiling some rules: about 5 s, and longer on a slow or busy machine; {compiling._KEPT}\n"
    assert capsys.readouterr().err == message
    with announced("some rules", 5):
        add_one(2)
        add_two(2)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (lambda: catch_arena.VectorArena("standard", 2), "the common rules for a batch: about 5 s"),
        (lambda: catch_arena.parallel_env("tag"), "all rules for one arena: about 7 s"),
        (lambda: catch_arena.arbitrate(hunters=[(5, 5)], targets={}, requests=[]), "the arbiter: about 1 s"),
    ],
)
def test_each_call_that_may_compile_rules_names_them(capsys, monkeypatch, call, line):
    monkeypatch.setattr(compiling, "CACHE_DIRECTORY", None)
    call()
    assert capsys.readouterr().err.startswith(f"catch_arena: compiling {line}, and longer")


def test_the_line_is_printed_once_where_nothing_is_kept(capsys, monkeypatch):
    monkeypatch.setattr(compiling, "CACHE_DIRECTORY", None)
    for _ in range(2):
        with announced("some rules", 5):
            pass
    assert capsys.readouterr().err.count("catch_arena: compiling some rules") == 1


def test_an_interrupted_compilation_leaves_no_trace():
    """Ctrl-C in a notebook, and the same call again."""
    with pytest.raises(KeyboardInterrupt), announced("some rules", 5):
        raise KeyboardInterrupt
    assert gc.isenabled()
    assert not cache_folder.on_miss

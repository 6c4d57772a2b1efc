"""Machine code from a wheel: when it is used, and when the compiler is. tests/scripts/test_wheel.py plays with the real
one.
"""

import hashlib
import json
import sysconfig
from functools import partial

import numpy as np
import pytest
from llvmlite import binding as llvm

from catch_arena.config import ArenaConfig
from catch_arena.core.arbiter import REQUEST_COLUMNS
from catch_arena.core.jit import sources_digest
from catch_arena.engine import engine, prebuilt
from catch_arena.engine.engine import Engine
from catch_arena.engine.prebuilt import PrebuiltRun, prebuilt_code

COPY = """
define i32 @catch_arena_run(i64* %words) {
  %memory = load i64, i64* %words
  %copy = inttoptr i64 %memory to [19 x i64]*
  %given = bitcast i64* %words to [19 x i64]*
  %all = load [19 x i64], [19 x i64]* %given
  store [19 x i64] %all, [19 x i64]* %copy
  ret i32 STATUS
}
"""
"""An entry that writes its arguments into the memory."""
ARRAYS = (
    np.zeros((3, 2), dtype=np.uint64),
    np.zeros((1, 4), dtype=np.int64),
    np.zeros((1, 4, 2), dtype=np.float32),
    np.zeros((0, REQUEST_COLUMNS), dtype=np.int64),
)


def object_file(status=0):
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(jit=True)
    return machine.emit_object(llvm.parse_assembly(COPY.replace("STATUS", str(status))))


@pytest.fixture
def carried(tmp_path, monkeypatch):
    """A wheel carries that entry, for any machine; what is returned writes its manifest, with changes."""
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path)
    monkeypatch.setattr(prebuilt, "INTERPRETED", False)
    monkeypatch.setattr(prebuilt, "CHECKED", False)
    monkeypatch.delenv("CATCH_ARENA_COMPILE", raising=False)
    content = object_file()
    (tmp_path / "one.o").write_bytes(content)

    def write(**changes):
        code = {
            "file": "one.o",
            "features": [],
            "lanes": 1,
            "options": False,
            "symbols": [],
            "blake2b": hashlib.blake2b(content).hexdigest(),
        }
        manifest = {"platform": sysconfig.get_platform(), "sources": sources_digest()}
        manifest = {name: changes.pop(name, value) for name, value in manifest.items()}
        (tmp_path / "manifest.json").write_text(json.dumps({**manifest, "code": [{**code, **changes}]}))
        prebuilt_code.cache_clear()

    write()
    prebuilt._tell_damaged.cache_clear()
    yield write
    prebuilt_code.cache_clear()


@pytest.mark.usefixtures("carried")
def test_what_the_wheel_carries_gets_all_arguments():
    """By a call, and bound: numbers as they are, of each array where it begins and its shape."""
    memory, other = np.zeros(64 * 8, dtype=np.uint8), np.zeros(64 * 8, dtype=np.uint8)
    code = prebuilt_code(1, options=False)
    resets, choices, commands, requests = ARRAYS
    PrebuiltRun(code, memory)(3, 5, 7, resets, True, choices, commands, requests)
    expected = [memory.ctypes.data, 512, 3, 5, 7, resets.ctypes.data, 3, 2, 1, choices.ctypes.data, 1, 4]
    expected += [commands.ctypes.data, 1, 4, 2, 0, 0, REQUEST_COLUMNS]
    assert memory.view(np.int64)[:19].tolist() == expected
    PrebuiltRun(code, other).bound(3, 5, 7, resets, True, choices, commands, requests)()
    assert other.view(np.int64)[1:19].tolist() == expected[1:]


@pytest.mark.usefixtures("carried")
@pytest.mark.parametrize("choices", [np.zeros((1, 4), dtype=np.int32), np.zeros((1, 8), dtype=np.int64)[:, ::2]])
def test_arrays_that_it_would_read_as_what_they_are_not_are_refused(choices):
    """The compiler makes code for them."""
    run = PrebuiltRun(prebuilt_code(1, options=False), np.zeros(64 * 8, dtype=np.uint8))
    with pytest.raises(TypeError, match="arrays must be C-contiguous and of int64, got int"):
        run(0, 0, 1, ARRAYS[0], True, choices, *ARRAYS[2:])


@pytest.mark.usefixtures("carried")
def test_an_engine_takes_it_and_compiles_nothing(monkeypatch):
    monkeypatch.setattr(engine, "compile_once", lambda *_: pytest.fail("compiled"))
    one = Engine(ArenaConfig())
    assert isinstance(one._run, PrebuiltRun)
    assert one.clone()._run._memory is not one._run._memory


@pytest.mark.parametrize(
    "other",
    [
        {"sources": "of an edit"},
        {"platform": "linux-other"},
        {"features": ["avx512-of-tomorrow"]},
        {"symbols": ["numba_has_no_such_thing"]},
        {"lanes": 4},
        {"options": True},
    ],
)
def test_what_is_for_other_sources_machines_or_variants_is_not_used(carried, other, capsys):
    carried(**other)
    assert prebuilt_code(1, options=False) is None
    assert not capsys.readouterr().err


@pytest.mark.usefixtures("carried")
@pytest.mark.parametrize("asked", ["INTERPRETED", "CHECKED", "CATCH_ARENA_COMPILE"])
def test_it_is_not_used_where_other_code_is_asked_for(asked, monkeypatch):
    if asked.startswith("CATCH"):
        monkeypatch.setenv(asked, "1")
    else:
        monkeypatch.setattr(prebuilt, asked, True)
    assert prebuilt_code(1, options=False) is None


def test_an_ordinary_installation_has_none(tmp_path, monkeypatch):
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path / "missing")
    prebuilt_code.cache_clear()
    assert prebuilt_code(1, options=False) is None


@pytest.mark.parametrize(
    ("file", "damage", "told"),
    [
        ("one.o", lambda content: content[:-1] + b"?", "one.o has another checksum"),
        ("one.o", None, "No such file"),
        ("manifest.json", lambda content: content[:40], "damaged: "),
        ("manifest.json", lambda _: b"[]", "damaged: "),
        ("manifest.json", lambda _: b"{}", "damaged: "),
    ],
)
@pytest.mark.usefixtures("carried")
def test_what_is_damaged_is_compiled_instead_and_told_once(tmp_path, capsys, file, damage, told):
    if damage:
        (tmp_path / file).write_bytes(damage((tmp_path / file).read_bytes()))
    else:
        (tmp_path / file).unlink()
    assert [prebuilt_code(1, options=False), prebuilt_code(1, options=False)] == [None, None]
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("catch_arena: the rules are compiled here: what the wheel carries is damaged: ")
    assert told in line


def test_code_that_fails_is_an_error(carried, tmp_path):
    content = object_file(status=1)
    (tmp_path / "one.o").write_bytes(content)
    carried(blake2b=hashlib.blake2b(content).hexdigest())
    run = PrebuiltRun(prebuilt_code(1, options=False), np.zeros(64 * 8, dtype=np.uint8))
    with pytest.raises(SystemError, match="must return 0, got 1"):
        partial(run, 0, 0, 1)(ARRAYS[0], True, *ARRAYS[1:])

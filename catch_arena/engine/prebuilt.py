"""Machine code of `tick.run` that a wheel carries, so that nobody who installs it waits for the compiler.

scripts/wheel makes it, as object files beside a manifest: whatever Python and Numba there are here, it plays the same.
It is used where it was made from the sources that lie beside it, and has only instructions that this processor knows.
Everything else is compiled here, as without it: also where CATCH_ARENA_COMPILE is set, and where Numba is asked for
other code (NUMBA_BOUNDSCHECK, NUMBA_DISABLE_JIT).
"""

import ctypes
import hashlib
import json
import os
import struct
import sys
import sysconfig
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from llvmlite import binding as llvm
from numpy.typing import NDArray

from catch_arena.core.arbiter import REQUEST_COLUMNS, RequestTable
from catch_arena.core.jit import CHECKED, INTERPRETED, sources_digest
from catch_arena.core.memory import Bytes

FOLDER: Final = Path(__file__).parent / "machine_code"
"""Only in a wheel that was made for one kind of machine."""
MANIFEST: Final = "manifest.json"
ENTRY: Final = "catch_arena_run"
"""The one function of each file: it takes the address of the arguments (`PrebuiltRun`), and returns 0."""

_pack: Final = struct.Struct("19q").pack
_word_at: Final = ctypes.c_int64.from_address
_HEAD: Final = object.__basicsize__
"""[bytes] Behind it, the first thing in a NumPy array's own part, stands where its numbers begin: NumPy's ABI, on which
all extensions rely. `array.ctypes` would take ten times as long to tell.
"""
_UINT8, _INT64, _UINT64, _FLOAT32 = map(np.dtype, (np.uint8, np.int64, np.uint64, np.float32))
_NO_RESETS: Final = 0, 0, 2
_NO_REQUESTS: Final = 0, 0, REQUEST_COLUMNS
_executables: Final[list[Any]] = []
"""What LLVM has loaded, and would free."""


class _KeptFrame(bytes):
    """Arguments of `tick.run`, with the arrays to which they point."""

    arrays: tuple[Any, ...]


class PrebuiltRun:
    """`tick.run` with the arguments up to `memory`: what of it was compiled, and an engine's memory. Other threads may
    run meanwhile.
    """

    def __init__(self, code: Callable[[bytes], None], memory: Bytes) -> None:
        self._code = code
        self._memory = memory
        self._memory_at = _place(memory, _UINT8)
        self._choices: tuple[Any, tuple[int, ...]] = None, ()
        """Those of the call before, and where they are: to ask anew takes a third of a call."""
        self._commands: tuple[Any, tuple[int, ...]] = None, ()

    def __call__(self, *arguments: Any) -> None:
        """See `tick.run`."""
        self._code(self._frame(*arguments))

    def bound(self, *arguments: Any) -> Callable[[], None]:
        """The call with these arguments, which are looked at now."""
        frame = _KeptFrame(self._frame(*arguments))
        frame.arrays = self._memory, *arguments
        return partial(self._code, frame)

    def _frame(
        self,
        thread: int,
        first_block: int,
        stop_block: int,
        resets: NDArray[np.uint64],
        playing: bool,
        choices: NDArray[np.int64],
        commands: NDArray[np.float32],
        given_requests: RequestTable,
    ) -> bytes:
        """The arguments from `memory` on, in their order and in 64 bits each: of an array its address and its shape."""
        known, choices_at = self._choices
        if choices is not known:
            choices_at = _place(choices, _INT64)
            self._choices = choices, choices_at
        known, commands_at = self._commands
        if commands is not known:
            commands_at = _place(commands, _FLOAT32)
            self._commands = commands, commands_at
        return _pack(
            *self._memory_at,
            thread,
            first_block,
            stop_block,
            *(_place(resets, _UINT64) if len(resets) else _NO_RESETS),
            playing,
            *choices_at,
            *commands_at,
            *(_place(given_requests, _INT64) if len(given_requests) else _NO_REQUESTS),
        )


def _place(array: NDArray[Any], dtype: np.dtype[Any]) -> tuple[int, ...]:
    """Where an array's numbers begin, and its shape. For other arrays Numba would compile `tick.run` once more; here
    they would be read as what they are not.

    Raises:
        TypeError: for an array of another type, or one whose numbers do not lie side by side.
    """
    if not array.flags.c_contiguous or (array.dtype is not dtype and array.dtype != dtype):
        raise TypeError(f"arrays must be C-contiguous and of {dtype}, got {array.dtype} and strides {array.strides}")
    return _word_at(id(array) + _HEAD).value, *array.shape


@cache
def prebuilt_code(lanes: int, *, options: bool) -> Callable[[bytes], None] | None:
    """What the wheel carries for this processor, the best first; None where there is nothing that can be used.

    Args:
        lanes: how many play at a time.
        options: whether with `state.ALL_OPTIONS`.
    """
    if INTERPRETED or CHECKED or os.environ.get("CATCH_ARENA_COMPILE") or not FOLDER.exists():
        return None
    array = np.zeros(1, dtype=np.uint8)
    if _place(array, _UINT8) != (array.ctypes.data, 1):
        return None
    try:
        manifest = json.loads((FOLDER / MANIFEST).read_text(encoding="utf-8"))
        if (manifest["platform"], manifest["sources"]) != (sysconfig.get_platform(), sources_digest()):
            return None
        for code in manifest["code"]:
            if code["lanes"] == lanes and code["options"] == options and runs_here(code):
                return load(code)
    except (OSError, ValueError, LookupError, TypeError) as error:
        _tell_damaged(str(error))
    return None


@cache
def _tell_damaged(reason: str) -> None:
    """Once for each reason."""
    sys.stderr.write(f"catch_arena: the rules are compiled here: what the wheel carries is damaged: {reason}\n")


def runs_here(code: dict[str, Any]) -> bool:
    """Whether this machine has what an entry of the manifest needs."""
    there = llvm.get_host_cpu_features()
    return all(there.get(feature) for feature in code["features"]) and all(
        llvm.address_of_symbol(symbol) for symbol in code["symbols"]
    )


def load(code: dict[str, Any]) -> Callable[[bytes], None]:
    """The function of an entry of the manifest.

    Raises:
        ValueError: for a file that is not what was built.
        OSError: for one that cannot be read.
    """
    content = (FOLDER / code["file"]).read_bytes()
    if hashlib.blake2b(content).hexdigest() != code["blake2b"]:
        raise ValueError(f"{code['file']} has another checksum")
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(jit=True)
    executable = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    executable.add_object_file(llvm.ObjectFileRef.from_data(content))
    executable.finalize_object()
    _executables.append(executable)
    function: Any = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_char_p)(executable.get_function_address(ENTRY))
    function.restype = _require_success
    return function  # type: ignore[no-any-return]


def _require_success(status: int) -> None:
    if status:
        raise SystemError(f"{ENTRY} must return 0, got {status}")

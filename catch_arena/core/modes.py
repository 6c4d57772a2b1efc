"""Mode in which this process runs the core: compiled as one piece (`compiler`), in Numba's own way, or interpreted."""

import os
from types import ModuleType
from typing import Any, Final

import numba

_settings: Any = numba.config  # it fills itself at run time, so that type checkers see none of its settings
INTERPRETED: Final = bool(_settings.DISABLE_JIT)
"""True with NUMBA_DISABLE_JIT=1: the core runs as plain Python, for debuggers, coverage and comparisons."""
CHECKED: Final = bool(_settings.BOUNDSCHECK)
"""True with NUMBA_BOUNDSCHECK=1: compiled code tests each index."""


def _compiler() -> ModuleType | None:
    if os.environ.get("CATCH_ARENA_COMPILER") == "numba":
        return None
    try:
        from catch_arena.core import compiler
    except (ImportError, AttributeError):  # this Numba lacks something that is not public
        return None
    return compiler


COMPILER: Final = _compiler()
"""The module `compiler`; None if CATCH_ARENA_COMPILER=numba, or this version of Numba, selects Numba's own way."""

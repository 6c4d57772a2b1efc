"""What plays, by version."""

import platform
from importlib.metadata import version


def versions() -> dict[str, str]:
    """Those here: of the package, Python, NumPy and Numba."""
    return {
        "catch_arena": version("catch-arena"),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
    }

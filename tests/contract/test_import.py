"""What an import costs, and what a user of the package can rely on."""

import subprocess
import sys

import catch_arena


def test_the_import_is_light():
    """The heavy libraries load on first use."""
    code = (
        "import sys, catch_arena; catch_arena.scenario('duel');"
        "heavy = {'numba', 'numpy', 'pygame', 'cv2', 'av', 'gymnasium', 'pettingzoo'} & set(sys.modules);"
        "sys.exit(f'loaded: {heavy}' if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_public_name_is_there():
    """`__all__` tells the truth, and `dir` shows it."""
    for name in catch_arena.__all__:
        assert getattr(catch_arena, name) is not None
        assert name in dir(catch_arena)

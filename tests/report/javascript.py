"""Function that runs the player's JavaScript in Deno, without a page and without permissions."""

import os
import subprocess
import sys
from pathlib import Path

DENO = Path(sys.executable).with_name("deno")


def deno(*arguments, given=""):
    """Run Deno with these arguments, and return its output."""
    environment = {**os.environ, "DENO_NO_UPDATE_CHECK": "1", "DENO_DIR": str(DENO.parent.parent / "deno")}
    done = subprocess.run(
        [DENO, *arguments], input=given, capture_output=True, text=True, timeout=60, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr
    return done.stdout

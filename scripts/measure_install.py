"""How large an installation is, by extra: makes an environment for each, and prints the README's table.

Sizes are of the whole environment, Python's own pip included, as `du` counts them, without modules that are compiled
when they are first imported.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

WAYS: Final = {
    "": "learning, tournaments, reports, replays, grading, conformance",
    "render": "and pictures: a window to play in, frames, notebooks",
    "video": "and H.264 videos",
    "video,parquet": "and tournaments as Parquet",
    "video,ray": "and tournaments on a cluster",
}


def size_mb(folder: Path) -> int:
    """All files below a folder, in MB of 10^6 bytes; links count as nothing."""
    return round(sum(path.stat().st_blocks * 512 for path in folder.rglob("*") if not path.is_symlink()) / 1e6)


def main() -> None:
    """Print the table."""
    print("| `pip install` | for | disk |")
    print("|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for number, (extras, purpose) in enumerate(WAYS.items()):
            environment = Path(folder) / str(number)
            subprocess.run([sys.executable, "-m", "venv", environment], check=True)
            package = f".[{extras}]" if extras else "."
            command = [environment / "bin/python", "-m", "pip", "install", "--quiet", "--no-compile", package]
            subprocess.run(command, check=True, env={**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1"})
            print(f"| `'{package}'` | {purpose} | {size_mb(environment)} MB |", flush=True)


if __name__ == "__main__":
    main()

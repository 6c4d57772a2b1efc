"""How large an installation is, by extra: installs one after the other into an environment, and prints the README's
table.

Sizes are of the whole environment, Python's own pip included, as `du` counts them, without modules that are compiled
when they are first imported. What brings torch, which is gigabytes, is not installed: pip names the files that it would
download, and their servers say how large they are.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final
from urllib.request import Request, urlopen

import tomllib

WAYS: Final = {
    "": "learning, tournaments, reports, replays, grading, conformance",
    "render": "and pictures: a window to play in, frames, notebooks",
    "video": "and H.264 videos: what `make demo` installs",
}
"""Each has what those before it have."""
MORE: Final = {
    "ros": "[a ROS 2 bus](docs/ros2.md)",
    "parquet": "tournaments as Parquet",
    "ray": "tournaments on a cluster",
}
"""Each for itself, beside the last of WAYS."""
WITH_TORCH: Final = {
    "sb3": "[training](docs/training.md) with stable-baselines3",
    "torchrl": "training with TorchRL",
    "train": "training with `scripts/train_ppo.py`",
}
TESTS: Final = ("test", "check")
"""The groups that `make test` installs."""


class Environment:
    """A virtual environment that grows."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        self.install("--upgrade", "pip")  # older ones download all that they only need to name

    def pip(self, *words: str) -> str:
        """What pip prints."""
        command = [self._folder / "bin/python", "-m", "pip", "--disable-pip-version-check", *words]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    def install(self, *what: str) -> int:
        """Install this too; the size of it all, in MB of 10^6 bytes. Links count as nothing."""
        self.pip("install", "--quiet", "--no-compile", *what)
        files = (path for path in self._folder.rglob("*") if not path.is_symlink())
        return round(sum(path.stat().st_blocks * 512 for path in files) / 1e6)

    def download_mb(self, what: str) -> int:
        """How much pip would download to install this too, where nothing is kept from before."""
        report = json.loads(self.pip("install", "--quiet", "--dry-run", "--report", "-", what))
        files = [one["download_info"] for one in report["install"]]
        return round(sum(length(file["url"]) for file in files if "archive_info" in file) / 1e6)


def package(extra: str) -> str:
    """The project of this folder, with this extra."""
    return f".[{extra}]" if extra else "."


def length(url: str) -> int:
    """Bytes of a file, without fetching it."""
    with urlopen(Request(url, method="HEAD")) as answer:  # noqa: S310 - where pip would fetch it
        return int(answer.headers["Content-Length"])


def main() -> None:
    """Print the table."""
    print("| `pip install` | for | disk |\n|---|---|---|")

    def row(extra: str, purpose: str, size: str) -> None:
        print(f"| `'{package(extra)}'` | {purpose} | {size} |", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        environment = Environment(Path(folder))
        whole_mb = 0
        for extra, purpose in WAYS.items():
            whole_mb = environment.install(package(extra))
            row(extra, purpose, f"{whole_mb} MB")
        for extra, purpose in WITH_TORCH.items():
            row(extra, purpose, f"downloads {environment.download_mb(package(extra))} MB more")
        before_mb = whole_mb
        for extra, purpose in MORE.items():
            after_mb = environment.install(package(extra))
            row(extra, purpose, f"{after_mb - before_mb} MB more")
            before_mb = after_mb
        groups = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["dependency-groups"]
        environment.pip("uninstall", "--yes", "--quiet", "ray")
        tests_mb = environment.install(*(need for group in TESTS for need in groups[group]))
        print(f"`make test` makes {tests_mb} MB of it")


if __name__ == "__main__":
    main()

"""Make a virtual environment and install the project of this folder into it, editable: `make` calls this.

Each step says what it does, and how far it is every few seconds, with or without a terminal. A step that fails leaves
nothing half made behind, says what is missing, and can be tried again: what was downloaded is kept. It needs nothing
but the standard library, as it runs before anything is installed.
"""

import os
import sys

sys.path.insert(1, os.path.abspath(f"{__file__}/../../.."))  # noqa: PTH100 - pathlib takes time to import
from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()

import argparse
import errno
import tempfile
import time
from pathlib import Path

from compilation import NEEDS, Compilation
from environment import Environment, alone_in
from packages import Installer, Project, quicken
from words import AGAIN, cause, fail, say


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="set_up", description=__doc__)
    parser.add_argument("environment", type=Path, help="the folder of the environment; made where it is missing")
    parser.add_argument("--extra", action="append", default=[], help="install the package with this extra")
    parser.add_argument("--group", action="append", default=[], help="install this dependency group of pyproject.toml")
    parser.add_argument("--compile", action="store_true", help="also compile the rules, while pip is still at work")
    parser.add_argument("--download", type=int, metavar="MB", help="about how much has to be downloaded")
    return parser.parse_args()


def set_up(environment: Environment, args: argparse.Namespace) -> None:
    """All steps."""
    began = time.monotonic()
    environment.make()
    if not args.extra and not args.group:
        tell_clock()
        return
    project = Project.here()
    installer = Installer(environment, args.download)
    compilation = None
    try:
        if args.compile:
            installer.install(project.needs_of(NEEDS), "the compiler")
            compilation = Compilation(environment)
        if args.extra:
            package = f".[{','.join(args.extra)}]"
            installer.install(["--editable", package], f"Catch Arena{package[1:]}")
            for command in project.commands:
                quicken(environment.python.with_name(command))
        for group in args.group:
            installer.install(project.groups[group], f"what `{group}` needs")
        if compilation is not None:
            compilation.finish()
    except BaseException:
        if compilation is not None:
            compilation.stop()
        raise
    say(f"set up in {time.monotonic() - began:.0f} s")


def tell_clock() -> None:
    """Say why `make` speaks of a clock, which it does as long as a file of ours is dated in the future."""
    for path in map(Path, ("Makefile", "pyproject.toml")):
        if path.exists() and path.stat().st_mtime > time.time() + 1:
            say(f"{path} is dated in the future. Is this machine's clock right? Nothing is installed anew for that.")
            return


def main() -> int:
    """The exit code: 0, or 1 with lines that say why not."""
    args = parse()
    interrupts.also_say(lambda: "the same command goes on from here")
    try:
        with alone_in(args.environment) as environment:
            set_up(environment, args)
    except OSError as error:
        reason = cause(str(error), Path.cwd(), Path(tempfile.gettempdir())) if error.errno == errno.ENOSPC else None
        fail(f"{error.filename or 'set-up'}: {reason or error.strerror or error}\n{AGAIN}")
    return 0


if __name__ == "__main__":
    interrupts.run(main)

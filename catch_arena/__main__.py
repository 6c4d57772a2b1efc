"""Entry point of the command `catch-arena` and of `python -m catch_arena`."""

import sys

from catch_arena import interrupts

TYPE_CHECKING = False  # see interrupts
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import NoReturn


def main(words: "Sequence[str] | None" = None, name: str = "catch-arena") -> "NoReturn":
    """Run the command line, and exit; without `words`, the arguments are those of the process."""
    interrupts.listen()  # before the slow imports
    from catch_arena.cli import main as command
    from catch_arena.streams import outlive_readers

    outlive_readers()
    interrupts.run(lambda: command(words, prog_name=name))


if __name__ == "__main__":
    if not sys.flags.isolated and not getattr(sys.flags, "safe_path", False):
        del sys.path[0]  # the starting folder: `python -m` searches it for modules, and agents must not
    main()

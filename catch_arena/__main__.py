"""The command `catch-arena`, and `python -m catch_arena`."""

from catch_arena import interrupts

TYPE_CHECKING = False  # see interrupts
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import NoReturn


def main(words: "Sequence[str] | None" = None, name: str = "catch-arena") -> "NoReturn":
    """Run the command line, and exit.

    Args:
        words: those that the process was started with if None.
        name: the one that usage messages show.
    """
    interrupts.listen()  # before anything that takes time is imported
    from catch_arena.cli import main as command
    from catch_arena.streams import outlive_readers

    outlive_readers()
    interrupts.run(lambda: command(words, prog_name=name))


if __name__ == "__main__":
    main()

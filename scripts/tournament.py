"""Play a tournament, as `catch-arena tournament` does: `python scripts/tournament.py AGENT... --rounds N --out DIR`."""

import sys

from catch_arena.cli import main

if __name__ == "__main__":
    main(["tournament", *sys.argv[1:]], prog_name="scripts/tournament.py")

"""Play a tournament, as `catch-arena tournament` does: `python scripts/tournament.py AGENT... --rounds N --out DIR`."""

import sys

from catch_arena.__main__ import main

if __name__ == "__main__":
    main(["tournament", *sys.argv[1:]], "scripts/tournament.py")

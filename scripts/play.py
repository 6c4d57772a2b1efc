"""Play against agents in a window, as `catch-arena play` does: `python scripts/play.py --against AGENT...`."""

import sys

from catch_arena.__main__ import main

if __name__ == "__main__":
    main(["play", *sys.argv[1:]], "scripts/play.py")

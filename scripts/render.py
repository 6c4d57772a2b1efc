"""Turn a recorded match into a video, as `catch-arena render` does: `python scripts/render.py REPLAY -o FILE.mp4`."""

import sys

from catch_arena.cli import main

if __name__ == "__main__":
    main(["render", *sys.argv[1:]], prog_name="scripts/render.py")

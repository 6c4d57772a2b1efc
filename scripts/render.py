"""Turn a recorded match into a video, as `catch-arena render` does: `python scripts/render.py REPLAY -o FILE.mp4`."""

import sys

from catch_arena.__main__ import main

if __name__ == "__main__":
    main(["render", *sys.argv[1:]], "scripts/render.py")

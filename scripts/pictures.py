"""Draw the picture that the README shows: a moment of a match between four of the shipped agents."""

import argparse
from pathlib import Path

import cv2

from catch_arena.render.raster import ArenaPainter
from catch_arena.scenarios import scenario
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.match import play

PICTURE = Path(__file__).parent.parent / "docs" / "picture.png"
AGENTS = ["patrol", "contested_by_time", "contested", "nearest"]
SEED, STEP = 3, 405


def main() -> None:
    """Play up to the moment, and paint it."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    config = scenario("standard")
    entrants = enter(AGENTS)
    names = [one.name for one in entrants]
    painter = ArenaPainter(config, names, size=(1280, 720), layout="broadcast")
    frames = []

    def watch(env) -> None:  # noqa: ANN001 - a PettingZoo env
        world = env.world()
        frame = painter.paint(world)
        if world.step == STEP:
            frames.append(frame)

    play(config, SEED, [one.create() for one in entrants], names, title="A match", watch=watch)
    picture = cv2.cvtColor(frames[0], cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(PICTURE), picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    print(PICTURE.relative_to(PICTURE.parent.parent))


if __name__ == "__main__":
    main()

"""The golden frames: moments of matches, a quarter as wide and high. `make golden` draws them anew."""

from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from render.matches import played

from catch_arena.render.timing import Clip
from catch_arena.render.video import rendered_frames, renderer_for

FOLDER = Path(__file__).parent.parent / "data" / "frames"

FAULTS = {"kill_down": 0.3, "kill_refused": 0.3, "spawn_down": 0.0, "spawn_refused": 0.0}


@dataclass(frozen=True)
class Moment:
    """One frame of one match."""

    name: str
    size: tuple[int, int]
    time_ms: int
    layout: str = "broadcast"
    scenario: str = "standard"
    settings: dict = field(default_factory=dict)


MOMENTS = [
    Moment("broadcast", (1280, 720), 8_050),
    Moment("arena", (720, 720), 8_050, layout="arena"),
    Moment("portrait", (540, 960), 8_050, scenario="duel"),
    Moment("square", (640, 640), 8_050, settings={"hunters": 6, "reach_m": 0.8, "faults": FAULTS}),
    Moment("crowd", (1281, 721), 5_030, scenario="crowd"),
]


def frame_of(moment: Moment, later_ms: int = 0) -> np.ndarray:
    """The moment as it is drawn now: (height / 4, width / 4, 3), red, green, blue."""
    replay = played(moment.scenario, time_limit_s=10.0, title="Round 1", **moment.settings)
    at_ms = moment.time_ms + later_ms
    (pixels,) = rendered_frames(replay, renderer_for(replay, moment.size, moment.layout), Clip(at_ms, at_ms, fps=60))
    small = cv2.resize(pixels[..., :3], None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(small)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for moment in MOMENTS:
        frame = cv2.cvtColor(frame_of(moment), cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(FOLDER / f"{moment.name}.png"), frame, [cv2.IMWRITE_PNG_COMPRESSION, 9])

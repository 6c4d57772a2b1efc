"""The golden frames: instants of matches, a quarter as wide and high. `make golden` draws them again."""

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
class GoldenFrame:
    """One frame of one match."""

    name: str
    size: tuple[int, int]
    time_ms: int
    layout: str = "broadcast"
    scenario: str = "standard"
    settings: dict = field(default_factory=dict)
    view_of: int | None = None


GOLDEN_FRAMES = [
    GoldenFrame("broadcast", (1280, 720), 8_050),
    GoldenFrame("arena", (720, 720), 8_050, layout="arena"),
    GoldenFrame("portrait", (540, 960), 8_050, scenario="duel"),
    GoldenFrame("square", (640, 640), 8_050, settings={"hunters": 6, "reach_m": 0.8, "faults": FAULTS}),
    GoldenFrame("crowd", (1281, 721), 5_030, scenario="crowd"),
    GoldenFrame("teams", (1280, 720), 8_050, scenario="pairs", settings={"names": ("a", "a", "b", "b")}),
    GoldenFrame("prey", (960, 540), 8_050, scenario="herd"),
    GoldenFrame("cone", (720, 720), 8_050, "arena", "evasive", {"view_radius_m": 4.0, "view_angle_deg": 120.0}, 0),
]


def frame_of(golden: GoldenFrame, later_ms: int = 0) -> np.ndarray:
    """The frame as it is drawn now: (height / 4, width / 4, 3), red, green, blue."""
    replay = played(golden.scenario, time_limit_s=10.0, title="Round 1", **golden.settings)
    at_ms = golden.time_ms + later_ms
    renderer = renderer_for(replay, golden.size, golden.layout)
    renderer.view_of = golden.view_of
    (pixels,) = rendered_frames(replay, renderer, Clip(at_ms, at_ms, fps=60))
    small = cv2.resize(pixels[..., :3], None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(small)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for golden in GOLDEN_FRAMES:
        frame = cv2.cvtColor(frame_of(golden), cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(FOLDER / f"{golden.name}.png"), frame, [cv2.IMWRITE_PNG_COMPRESSION, 9])

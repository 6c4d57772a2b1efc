"""Functions that decode a video, and that draw its frames for comparison."""

from pathlib import Path

import av
import cv2
import numpy as np

from catch_arena.render.encoders import FORMATS
from catch_arena.render.video import clip_of, rendered_frames, renderer_for

SMALL = {"size": (480, 320), "fps": 30}
ENDINGS = list(FORMATS)


def decoded(path: Path) -> list[np.ndarray]:
    if path.suffix == ".webp":  # FFmpeg writes animated WebP and does not read it
        ok, animation = cv2.imreadanimation(str(path))
        assert ok
        return [cv2.cvtColor(frame, cv2.COLOR_BGRA2RGB) for frame in animation.frames]
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def drawn(replay, size, fps, layout="broadcast", start_s=0.0, end_s=None, speed=1.0) -> list[np.ndarray]:
    clip = clip_of(replay, fps, start_s, end_s, speed)
    return [pixels[..., :3].copy() for pixels in rendered_frames(replay, renderer_for(replay, size, layout), clip)]


def psnr(one: np.ndarray, other: np.ndarray) -> float:
    return float(10 * np.log10(255.0**2 / np.mean((one.astype(float) - other.astype(float)) ** 2)))

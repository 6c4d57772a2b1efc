"""Video of a match."""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Final, NamedTuple

from catch_arena.config import require_choice
from catch_arena.errors import ConfigError, require_type
from catch_arena.explanation.highlights import AFTER_MS, BEFORE_MS
from catch_arena.explanation.seats import find_subjects
from catch_arena.explanation.what_if import WhatIf
from catch_arena.plain import whole_number
from catch_arena.render import cards, hud
from catch_arena.render.captions import Captions
from catch_arena.render.encoders import Progress, format_of, video_file
from catch_arena.render.ghost import with_ghost
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.raster import Pixels
from catch_arena.render.renderer import MatchRenderer, checked_size
from catch_arena.render.timing import Clip, frame_spans
from catch_arena.replay import Replay
from catch_arena.world import World

SLOWEST: Final = Fraction(1, 100)
FASTEST: Final = Fraction(100)


@dataclass(frozen=True, slots=True)
class RenderReport:
    """Facts about a video that was written."""

    path: Path
    frames: int
    """Number of frames."""
    seconds: float
    """Length of the video [s]."""
    size: tuple[int, int]
    """Width and height [pixels]; if the format needs even numbers, an odd one has become the next even one."""
    fps: int


class VideoOutput(NamedTuple):
    """Video file to write, with settings that its format allows."""

    path: Path
    size: tuple[int, int]
    """Width and height [pixels]."""
    fps: int

    @classmethod
    def of(
        cls,
        path: str | os.PathLike[str],
        size: tuple[int, int] | None = None,
        shape: hud.FrameShape | None = None,
        fps: int | None = None,
    ) -> "VideoOutput":
        """Return the output for some settings, None for the default of the format and shape.

        If the format needs even sizes, an odd one becomes the next even one. Raises ConfigError for settings that it
        does not allow.
        """
        kind = format_of(Path(path))
        shorter = kind.size[1] * 3 // 2
        usual = {"landscape": kind.size, "portrait": (shorter, shorter * 16 // 9), "square": (shorter, shorter)}
        if shape is not None:
            require_choice("shape", shape, tuple(usual))
        width, height = checked_size(usual[shape or "landscape"] if size is None else size)
        if shape is not None and hud.frame_shape((width, height)) != shape:
            raise ConfigError(
                f"size must be {shape}, got {width}x{height}, which is {hud.frame_shape((width, height))}; the longer "
                f"side of a landscape or portrait frame is at least {hud.WIDE:g} times the shorter one"
            )
        rate = kind.fps if fps is None else whole_number(fps)
        if rate is None or not 1 <= rate <= kind.most_fps:
            raise ConfigError(f"fps must be a whole number from 1 to {kind.most_fps} for {kind.name}, got {fps!r}")
        if kind.even:
            width, height = width + width % 2, height + height % 2
        return cls(Path(path), (width, height), rate)

    def write(self, pictures: Iterable[Pixels], frames: int, progress: Progress | None = None) -> RenderReport:
        """Write the `frames` pictures of the video as they come. Raises the errors of `render_replay`."""
        with video_file(self.path, self.size, self.fps) as video:
            for done, pixels in enumerate(pictures, start=1):
                video.write(pixels)
                if progress is not None:
                    progress(done, frames)
        return RenderReport(self.path, frames, frames / self.fps, self.size, self.fps)


def render_replay(
    replay: Replay,
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] | None = None,
    fps: int | None = None,
    shape: hud.FrameShape | None = None,
    layout: hud.Layout = "broadcast",
    captions: Captions = "plain",
    start_s: float | None = None,
    end_s: float | None = None,
    speed: float = 1.0,
    view_of: int | str | None = None,
    event: str = "",
    what_if: WhatIf | None = None,
    progress: Progress | None = None,
) -> RenderReport:
    """Write a match as a video between a title and a podium, or a part of it without them.

    Args:
        replay: the recorded match.
        path: the file to write, which ends in .mp4, .webm, .gif or .webp.
        size: (width, height) [pixels] from 320 x 320 to 3840 x 2160; None for the format's default
            (`encoders.FORMATS`).
        fps: frames a second, from 1 on.
        shape: "landscape", "portrait" or "square"; None for that of `size`, or landscape.
        layout: "broadcast" (arena, standings, event feed, timeline) or "arena".
        captions: events of the match in "plain" words, with the "clauses" of the rulebook too, or "none".
        start_s: start of a part of the match [s].
        end_s: end of a part of the match [s]; None for the match's end.
        speed: seconds of the match in a second of the video, 0.01 to 100.
        view_of: hunter whose view is shown, by its seat or its agent's name, if hunters do not see everything as it is.
        event: heading of the title, such as a tournament's name and date.
        what_if: answer to a lost contest; the part around the contest is shown, with the loser's alternative as a
            ghost and the answer as caption. Leave out `start_s` and `end_s` then.
        progress: called with (frames written, frames in all).

    Raises:
        ConfigError: for an invalid setting, and without PyAV or an encoder in its FFmpeg.
        OutputError: if the file cannot be written.
        ReplayError: if the replay does not play as recorded. Whatever is raised, Ctrl-C included, no half-written
            file is left, and an older file of that name is kept.
    """
    require_type("replay", replay, Replay, "Replay.load(path)")
    output = VideoOutput.of(path, size, shape, fps)
    words = captions != "none"
    if what_if is not None:
        if start_s is not None or end_s is not None:
            raise ConfigError("the start and the end must be left out with what_if, which shows the part around it")
        judged_ms, captions = what_if.contest.judged_ms, "none"
        start_s = max(0, judged_ms - BEFORE_MS) / 1000.0
        end_s = min(replay.duration_ms, judged_ms + AFTER_MS) / 1000.0
    clip = clip_of(replay, output.fps, start_s or 0.0, end_s, speed)
    renderer = MatchRenderer(MatchInfo.of_replay(replay, event=event), output.size, layout, replay.seed, captions)
    renderer.view_of = None if view_of is None else _viewed_seat(replay, view_of)
    if start_s is not None or end_s is not None:
        pictures = rendered_frames(replay, renderer, clip)
        if what_if is not None:
            pictures = with_ghost(pictures, renderer, clip.times_ms, what_if, words=words)
        return output.write(pictures, clip.frames, progress)
    pictures = frames_of(observed_worlds(replay, renderer), renderer, [*clip.times_ms, float(clip.end_ms)])
    frames = clip.frames + 1 + card_frames(cards.TITLE_MS, clip.fps) + card_frames(cards.PODIUM_MS, clip.fps)
    return output.write(with_cards(pictures, renderer, clip.fps), frames, progress)


def card_frames(time_ms: int, fps: int) -> int:
    """Return the number of frames in which a card is shown."""
    return max(1, round(time_ms * fps / 1000))


def with_cards(pictures: Iterator[Pixels], renderer: MatchRenderer, fps: int) -> Iterator[Pixels]:
    """Yield the frames of a whole match between its title and its podium, under which the match stands still."""
    fade, title = card_frames(cards.FADE_MS, fps), card_frames(cards.TITLE_MS, fps)
    pixels = next(pictures)
    still = pixels.copy()
    for frame in range(title):
        yield renderer.draw_title(min(1.0, (title - frame) / fade))
        pixels[:] = still
    yield pixels
    yield from pictures
    still = pixels.copy()
    for frame in range(1, card_frames(cards.PODIUM_MS, fps) + 1):
        pixels[:] = still
        yield renderer.draw_podium(min(1.0, frame / fade))


def renderer_for(replay: Replay, size: tuple[int, int], layout: hud.Layout) -> MatchRenderer:
    """Return the renderer of a recorded match."""
    return MatchRenderer(MatchInfo.of_replay(replay), size, layout, replay.seed)


def _viewed_seat(replay: Replay, hunter: int | str) -> int:
    """Return the seat whose view is shown; raise ConfigError unless it is one hunter's, and views are limited."""
    seats, _ = find_subjects(replay, hunter)
    if len(seats) != 1:
        meant = f"the seats {', '.join(map(str, seats))}" if seats else "prey"
        raise ConfigError(f"view_of must mean one hunter, got {hunter!r}, which means {meant}")
    if not replay.config.limits_views:
        raise ConfigError(
            "view_of needs a match that limits or blurs its hunters' views "
            f"(view_radius_m, view_angle_deg, view_noise_m), got {hunter!r}"
        )
    return seats[0]


def rendered_frames(replay: Replay, renderer: MatchRenderer, clip: Clip) -> Iterator[Pixels]:
    """Yield the frames of a recorded match; see `frames_of`."""
    return frames_of(observed_worlds(replay, renderer), renderer, clip.times_ms)


def observed_worlds(replay: Replay, renderer: MatchRenderer) -> Iterator[World]:
    """Yield the worlds of a replay, as `Replay.worlds`, and give the renderer the hunters' observations in each."""
    for engine in replay.checked_engines():
        world = engine.world()
        renderer.observe(world.step, engine.observations[0])
        yield world


def frames_of(worlds: Iterable[World], renderer: MatchRenderer, times_ms: Sequence[float]) -> Iterator[Pixels]:
    """Yield the frames at these instants, in the renderer's own buffer: the next one overwrites it.

    Steps before the first frame are played too, so that their trails and catches are shown.
    """
    for motion, step_times_ms, next_tick in frame_spans(worlds, times_ms):
        renderer.enter(motion)
        for time_ms in step_times_ms:
            yield renderer.draw(time_ms, motion.at(time_ms, next_tick))


def clip_of(replay: Replay, fps: int, start_s: float, end_s: float | None, speed: float) -> Clip:
    """Return a part of a match at a pace, or raise ConfigError for one that is not in the match."""
    pace = pace_of(speed)
    whole_s = replay.duration_ms / 1000.0
    until_s = whole_s if end_s is None else end_s
    if not 0.0 <= start_s <= whole_s:
        raise ConfigError(f"the start must be from 0 to {whole_s:g} s, the match's length, got {start_s!r}")
    if not start_s < until_s and whole_s > 0.0:
        raise ConfigError(f"the end must be after the start, {start_s:g} s, got {until_s!r}")
    end_ms = round(1000.0 * min(whole_s, until_s))
    return Clip(round(1000.0 * start_s), end_ms, fps, pace)


def pace_of(speed: float) -> Fraction:
    """Return a speed as a fraction, or raise ConfigError outside [SLOWEST, FASTEST]."""
    if not SLOWEST <= speed <= FASTEST:
        raise ConfigError(f"speed must be from {float(SLOWEST):g} to {float(FASTEST):g}, got {speed!r}")
    return Fraction(speed).limit_denominator(1000)

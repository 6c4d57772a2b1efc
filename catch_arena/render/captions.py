"""Captions: one line over the arena that says in words what has just happened.

The page's player shows the same captions and lenses (player/bundle.py).
"""

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

from catch_arena.explanation.facts import Contest
from catch_arena.explanation.formatting import millimetres
from catch_arena.explanation.highlights import lead
from catch_arena.render import hud
from catch_arena.render.annotations import Annotation
from catch_arena.render.lens import LEAST_ARENA, LENS_MS, Lens, lens_shapes
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Color, Label, Shape
from catch_arena.render.text import ELLIPSIS, text_width, wrapped
from catch_arena.render.viewport import Viewport

Captions = Literal["plain", "clauses", "none"]
"""Kind of captions: in plain words, with the clause of the rulebook, or none."""
LOW: Final = 0.25
"""Part of the arena's height below which an event's caption stands at the top."""
_LONGEST_NAME: Final = 16
"""Greatest number of characters of a name in a caption."""
_STEALS_UM: Final = 100_000
"""Margin of a contest below which its winner steals the target [micrometres]."""


class Caption(NamedTuple):
    """Text that is shown for a moment, the agent whose colour it has, and the lens that is shown with it."""

    time_ms: int
    agent: int
    text: str
    clause: str
    at_top: bool = False
    """True to show it at the top of the arena, since its event is at the bottom."""
    lens: Lens | None = None
    """Contest that it is about; None without a contest."""


def caption_of(annotation: Annotation, info: MatchInfo) -> Caption | None:
    """Return the caption of a contest or of a catch of prey; None for other annotations."""
    name, lens = _shortened(info.label(annotation.seat)), annotation.lens
    if lens is not None:
        text, clause = _contest_text(lens.contest, info), lens.contest.clause
    elif annotation.prey is not None:
        text, clause = f"{name} catches {_shortened(info.label(annotation.prey))}", "R12.3"
    else:
        return None
    low = annotation.y < LOW * info.config.side_m
    return Caption(annotation.time_ms, annotation.seat, text, clause, low, lens)


def _contest_text(contest: Contest, info: MatchInfo) -> str:
    name, other = (_shortened(info.label(claim.seat)) for claim in contest.claims[:2])
    behind_um = contest.behind_um(contest.claims[1])
    if contest.clause == "R5.9":
        return f"{name} is first in the queue, before {other}"
    if behind_um is None:
        return f"{name} and {other} are equally near: {name} wins the draw"
    wins = f"steals it from {other}" if behind_um < _STEALS_UM else f"beats {other} to it"
    return f"{name} {wins} by {millimetres(behind_um)}"


def _shortened(name: str) -> str:
    """Return a name short enough for two of them to fit into a caption."""
    return name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 1] + ELLIPSIS


class Commentary:
    """Latest caption of a match."""

    def __init__(self, info: MatchInfo) -> None:
        self._info = info
        self._leader: int | None = None
        self.caption: Caption | None = None
        """Latest caption: of a step's contest, else of a catch of prey, else of a new leader."""

    def record(self, time_ms: int, annotations: Sequence[Annotation], scores: Sequence[int]) -> None:
        """Add a step that began at `time_ms`: its annotations, and the scores by contender after it."""
        contests = [annotation for annotation in annotations if annotation.lens is not None]
        captions = [caption_of(annotation, self._info) for annotation in (*contests, *annotations)]
        leader, _ = lead(scores)
        if leader is not None and leader != self._leader:
            if self._leader is not None:  # the first leader of a match is no news
                name = _shortened(self._info.contenders[leader].name)
                captions.append(
                    Caption(time_ms, self._info.contenders[leader].seats[0], f"{name} takes the lead", "R6.1")
                )
            self._leader = leader
        self.caption = next((caption for caption in captions if caption is not None), self.caption)


def in_words(text: str, clause: str, kind: Captions) -> str:
    """Return the text of a caption, with its clause if captions have clauses."""
    return f"{text} ({clause})" if kind == "clauses" else text


def caption_shapes(
    viewport: Viewport, info: MatchInfo, caption: Caption, kind: Captions, time_ms: float
) -> list[Shape]:
    """Return the shapes of a caption and its lens; none after their time, and in an arena that is too small."""
    room, age_ms = min(viewport.width, viewport.height), time_ms - caption.time_ms
    if room < LEAST_ARENA or not 0.0 <= age_ms < LENS_MS:
        return []
    shapes = [] if caption.lens is None else lens_shapes(viewport, info, caption.lens, age_ms)
    if kind == "none":
        return shapes
    text = in_words(caption.text, caption.clause, kind)
    return [*shapes, *panel_shapes(viewport, info.colors[caption.agent], text, at_top=caption.at_top)]


def panel_shapes(viewport: Viewport, color: Color, text: str, *, at_top: bool, whole: bool = False) -> list[Shape]:
    """Return the shapes of a text in a panel at the bottom or top of the arena, after a dot in a colour.

    The text is one line, which is cut if it is too long. A `whole` text is smaller, and has as many lines as it needs.
    """
    height = 0.78 * hud.CAPTION * min(viewport.width, viewport.height)
    dot, around, weight = 0.5 * height, 2.2 * height, 600 if whole else 700
    size = hud.font_size((0.43 if whole else 0.5) * height, 11)
    most, lines = viewport.width - dot, [text]
    if whole:
        lines = wrapped(text, size, weight, most - around)
    width = min(most, max(text_width(line, size, weight) for line in lines) + around)
    left, gap, spacing = (viewport.width - width) / 2.0, 0.12 * height, 1.35 * size
    tall = height + spacing * (len(lines) - 1)
    top = gap if at_top else viewport.height - gap - tall
    middle, start = top + 0.5 * height, left + 1.15 * height
    return [
        Box(left, top, width, tall, hud.PANEL, 0.5 * height),
        Box(left + 0.4 * height, middle - 0.5 * dot, dot, dot, color, 0.5 * dot),
        *(
            Label(start, middle + spacing * row, line, size, hud.BRIGHT, weight, max_width=width - 1.7 * height)
            for row, line in enumerate(lines)
        ),
    ]

"""Annotations of the arena: the latest rulings (catches, contests, refusals), and the agents' numbers.

Pure functions. Every text is placed so that it covers no other text and no number.
"""

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from catch_arena.explanation.facts import Contest
from catch_arena.explanation.formatting import millimetres
from catch_arena.render.lens import Lens, lens_of
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import INK, WHITE, Label, Path, Ring, Shape, mix
from catch_arena.render.text import text_width, truncated
from catch_arena.render.viewport import GROUND, Viewport
from catch_arena.replay.motion import Pose2D
from catch_arena.verdicts import Verdict
from catch_arena.world import World

MOST_NAMES: Final = 8
"""Greatest number of agents that have their names next to them."""
LEAST_NAMED: Final = 440
"""Shorter side of the smallest arena with names [pixels]."""
LONGEST_NAME: Final = 9.0
"""Greatest width of a name next to a turtle, in sizes of its text."""
NEAR_UM: Final = 1_000_000
"""Distance [micrometres] within which a hunter is near a target that another catches."""
MOST_REASONS: Final = 6
"""Greatest number of refusals that show their reason; with more, each shows a ! instead."""

_VISIBLE_MS: Final = {"catch": 900.0, "lost": 1200.0, "refused": 700.0}


class Neighbour(NamedTuple):
    """Hunter near a target that another one catches, which did not ask for it."""

    seat: int
    behind_um: int | None
    """Distance to the target minus that of the catching hunter [micrometres]; None if that was not measured."""


@dataclass(frozen=True, slots=True)
class Annotation:
    """One ruling as it is shown for a moment: its kind, time, hunter and place."""

    kind: Literal["catch", "lost", "refused"]
    time_ms: int
    """Time of the judgement: the boundary at which the step began (R1.4) [ms]."""
    seat: int
    x: float
    """Place of the target [m], or of the hunter if there was no such target."""
    y: float
    text: str = "+1"
    contest: Contest | None = None
    """Contest that the catch won; None if no other hunter asked for the target."""
    neighbours: tuple[Neighbour, ...] = ()
    """Other hunters near a catch, the nearest first."""
    prey: int | None = None
    """Agent that was caught, numbered after the hunters; None for a target that no agent plays."""
    lens: Lens | None = None
    """Lens of the contest; None without a rival of another team."""

    @property
    def visible_ms(self) -> float:
        """Time for which the annotation is shown [ms]."""
        return _VISIBLE_MS[self.kind]


def annotations_of(before: World, after: World, contests: Iterable[Contest]) -> tuple[Annotation, ...]:
    """Return the annotations of a step's rulings and contests."""
    places = {target.name: (target.x, target.y) for target in before.targets}
    played = {prey.target: agent for agent, prey in enumerate(before.prey, start=len(before.hunters))}
    # under R9.1 each hunter is granted its request, and no one wins
    decided = {contest.target: contest for contest in contests if contest.clause != "R9.1"}
    annotations = []
    for ruling in after.rulings:
        hunter, target = before.hunters[ruling.hunter], str(ruling.target)
        if hunter.withdrawn:
            continue  # it is drawn as out, and may go on requesting in every step (R1.7)
        place, contest = places.get(target), decided.get(target)
        origin = (before.time_ms, ruling.hunter, *(place or (hunter.x, hunter.y)))
        if ruling.verdict is Verdict.GRANTED:
            asked = {ruling.hunter} if contest is None else {claim.seat for claim in contest.claims}
            neighbours = () if place is None else _neighbours(before, place, asked, ruling.distance_um)
            prey, lens = played.get(target), None
            if contest is not None and place is not None and contest.between_teams:
                lens = lens_of(before, contest)
            annotations.append(Annotation("catch", *origin, "+1", contest, neighbours, prey, lens))
        elif ruling.verdict is Verdict.LOST_CONTEST and contest is not None:
            claim = next(claim for claim in contest.claims if claim.seat == ruling.hunter)
            behind_um = contest.behind_um(claim)
            text = "by lot" if behind_um is None else f"−{millimetres(behind_um)}"
            annotations.append(Annotation("lost", *origin, text))
        else:
            annotations.append(Annotation("refused", *origin, ruling.verdict.name.lower().replace("_", " ")))
    return tuple(annotations)


def _neighbours(
    before: World, place: tuple[float, float], asked: Container[int], catching_um: int | None
) -> tuple[Neighbour, ...]:
    near = []
    for seat, hunter in enumerate(before.hunters):
        distance_um = round(1e6 * math.hypot(hunter.x - place[0], hunter.y - place[1]))
        if seat not in asked and distance_um < NEAR_UM and not hunter.withdrawn:
            near.append((distance_um, seat))
    return tuple(
        Neighbour(seat, None if catching_um is None else distance_um - catching_um)
        for distance_um, seat in sorted(near)
    )


def visible_annotations(annotations: Iterable[Annotation], time_ms: float) -> list[Annotation]:
    """Return the annotations that are still shown; of each hunter's refusals, which may repeat, only the latest."""
    seen = [annotation for annotation in annotations if time_ms - annotation.time_ms < annotation.visible_ms]
    latest = {annotation.seat: annotation for annotation in seen if annotation.kind == "refused"}
    return [annotation for annotation in seen if annotation.kind != "refused" or latest[annotation.seat] is annotation]


class _TextBox(NamedTuple):
    """Area of a text: its centre, and half its width and height."""

    x: float
    y: float
    half_width: float
    half_height: float


def annotation_shapes(
    viewport: Viewport, info: MatchInfo, poses: Mapping[int, Pose2D], annotations: Sequence[Annotation], time_ms: float
) -> list[Shape]:
    """Return the rings of catches, the lines of contests, all agents' numbers, and the texts; `poses` are by agent."""
    shapes: list[Shape] = []
    for annotation in annotations:
        part = (time_ms - annotation.time_ms) / annotation.visible_ms
        lines: list[tuple[int, float]] = []  # seat and relative width
        if annotation.kind == "lost":
            lines = [(annotation.seat, 0.8)]
        elif annotation.contest is not None or annotation.neighbours:
            losers = () if annotation.contest is None else annotation.contest.claims[1:]
            lines = [(annotation.seat, 1.0), *((claim.seat, 0.8) for claim in losers)]
            lines += [(one.seat, 0.35) for one in annotation.neighbours]
        x, y = viewport.to_pixels(annotation.x, annotation.y)
        for seat, thickness in lines:  # they become thinner, since paths are opaque
            width = max(0.8, 0.08 * viewport.hunter_length * thickness * (1.0 - part))
            color = mix(info.colors[seat], GROUND, 0.8 * part)
            shapes.append(Path((viewport.to_pixels(*poses[seat][:2]), (x, y)), width, color))
        if annotation.kind == "catch":
            shapes.append(_catch_ring(viewport, x, y, part))
    size = max(10, round(0.34 * viewport.hunter_length))
    positions = [viewport.to_pixels(x, y) for x, y, _ in poses.values()]
    apart = spread_apart(positions, (1.1 if len(poses) <= 10 else 1.55) * size)
    numbers = [_number(info, agent, position, size) for agent, position in zip(poses, apart, strict=True)]
    taken = [
        _TextBox(number.x, number.y, 0.32 * len(number.text) * number.size, 0.45 * number.size) for number in numbers
    ]
    texts = _text_shapes(viewport, info, poses, annotations, time_ms, taken)
    return [*shapes, *_names(viewport, info, poses, taken), *numbers, *texts]


def _names(viewport: Viewport, info: MatchInfo, poses: Mapping[int, Pose2D], taken: Sequence[_TextBox]) -> list[Label]:
    """Return the agents' names below their turtles, or else above: those that cover no other turtle and no text."""
    length = viewport.hunter_length
    if len(poses) > MOST_NAMES or min(viewport.width, viewport.height) < LEAST_NAMED:
        return []
    size = max(11, round(0.3 * length))
    turtles = {agent: viewport.to_pixels(*pose[:2]) for agent, pose in poses.items()}
    boxes, names = list(taken[len(poses) :]), []
    for agent, (x, y) in turtles.items():
        name = truncated(info.names[agent], size, 600, LONGEST_NAME * size)
        half_width = 0.5 * text_width(name, size, 600)
        down = max(info.config.reaches[agent] * viewport.scale if agent < info.config.hunters else 0.0, 0.5 * length)
        others = [_TextBox(*place, 0.45 * length, 0.45 * length) for other, place in turtles.items() if other != agent]
        for middle in (y + down + 0.85 * size, y - down - 0.85 * size):
            room = _TextBox(x, middle, half_width, 0.5 * size)
            inside = half_width < x < viewport.width - half_width and size < middle < viewport.height - size
            if inside and not any(_overlap(room, other) for other in (*others, *boxes)):
                boxes.append(room)
                color = mix(info.colors[agent], WHITE, 0.5)
                names.append(Label(x, middle, name, size, color, 600, "center", outline=INK))
                break
    return names


def _overlap(one: _TextBox, other: _TextBox) -> bool:
    return (
        abs(one.x - other.x) < one.half_width + other.half_width
        and abs(one.y - other.y) < one.half_height + other.half_height
    )


def _number(info: MatchInfo, agent: int, position: tuple[float, float], size: int) -> Label:
    """Return an agent's number: bright with a dark outline on a hunter, the reverse on prey."""
    color, outline = (WHITE, INK) if agent < info.config.hunters else (INK, WHITE)
    return Label(*position, info.number(agent), size, color, 800, "center", outline=outline)


def _catch_ring(viewport: Viewport, x: float, y: float, part: float) -> Ring:
    length = viewport.hunter_length
    radius = length * (0.3 + 0.75 * (1.0 - (1.0 - part) ** 3))
    return Ring(x, y, radius, max(1.2, 0.11 * length * (1.0 - part)), WHITE, (1.0 - part) ** 1.5, glow=True)


_ROUNDS: Final = 8
_FURTHEST: Final = 2.0
"""Greatest distance of a moved point from its own place [rooms]."""


def spread_apart(positions: Sequence[tuple[float, float]], room: float) -> list[tuple[float, float]]:
    """Return the points, with those closer than `room` moved apart; the results change smoothly with the points.

    There are few rounds, so in a dense crowd some stay a little too close. No point moves farther than two rooms.
    """
    around = 2.4 * np.arange(len(positions))  # separates points at the same place too
    moved = np.array(positions) + 1e-3 * np.stack([np.cos(around), np.sin(around)], axis=1)
    for _ in range(_ROUNDS):
        ways = moved[:, None] - moved[None]
        distances = np.hypot(ways[..., 0], ways[..., 1])
        np.fill_diagonal(distances, room)
        short = np.maximum(0.0, room - distances)
        if not short.any():
            break
        moved += (0.5 * (short / distances)[..., None] * ways).sum(axis=1)
    drift = moved - np.array(positions)
    far = np.hypot(drift[:, 0], drift[:, 1])[:, None]
    kept = np.array(positions) + drift * np.minimum(1.0, _FURTHEST * room / np.maximum(far, 1e-9))
    return [(x, y) for x, y in kept.tolist()]


def _text_shapes(
    viewport: Viewport,
    info: MatchInfo,
    poses: Mapping[int, Pose2D],
    annotations: Sequence[Annotation],
    time_ms: float,
    taken: list[_TextBox],
) -> list[Shape]:
    """Return the texts: +1 rising over a hunter, the margin of a lost contest sinking below it, reasons of refusals.

    Texts stay inside the picture. A text that would cover another one is moved on, farther for a larger overlap. Their
    places are added to `taken`.
    """
    length = viewport.hunter_length
    briefly = length < 26 or sum(annotation.kind == "refused" for annotation in annotations) > MOST_REASONS
    shapes: list[Shape] = []
    for annotation in annotations:
        part = (time_ms - annotation.time_ms) / annotation.visible_ms
        text = "!" if annotation.kind == "refused" and briefly else annotation.text
        size = max(11, round({"catch": 0.48, "lost": 0.36, "refused": 0.3}[annotation.kind] * length))
        half_width = 0.3 * len(text) * size
        x, y = viewport.to_pixels(*poses[annotation.seat][:2])
        rises = 0.0 if annotation.kind == "refused" else 0.3 * length * part  # a refusal may be repeated, step by step
        reach = info.config.reaches[annotation.seat] * viewport.scale
        away = max(reach, 0.5 * length) + 0.75 * size + rises
        side = -1.0 if annotation.kind == "catch" else 1.0
        if not 0.6 * size < y + side * away < viewport.height - 0.6 * size:
            side = -side
        x = min(max(x, half_width + 2.0), viewport.width - half_width - 2.0)
        room = _moved_clear(_TextBox(x, y + side * away, half_width, 0.5 * size), side, taken)
        room = room._replace(y=min(max(room.y, 0.6 * size), viewport.height - 0.6 * size))
        taken.append(room)
        color = mix(info.colors[annotation.seat], WHITE, 0.35)
        opacity = min(1.0, 3.0 * (1.0 - part))
        shapes.append(Label(x, room.y, text, size, color, 800, "center", outline=INK, opacity=opacity))
    return shapes


def _moved_clear(room: _TextBox, side: float, taken: Sequence[_TextBox]) -> _TextBox:
    """Return the box moved up or down by its whole overlap with others, or by less if they hardly touch."""
    for _ in range(3):
        for other in taken:
            beside = room.half_width + other.half_width - abs(room.x - other.x)
            above = room.half_height + other.half_height - abs(room.y - other.y)
            if beside > 0.0 and above > 0.0:
                whole = room.half_height + other.half_height - side * (room.y - other.y)
                room = room._replace(y=room.y + side * whole * min(1.0, beside / room.half_height))
    return room

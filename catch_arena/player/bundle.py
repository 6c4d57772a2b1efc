"""Replay bundles: a match as data for a web page, with every pose at every step and the arbiter's answers.

A bundle is gzip of one line of JSON and the tracks. A track has a body's x, then y, then theta, from its first state
to its last. The numbers are second differences, which are small for moving bodies too. They are stored in 16 bits with
the sign in the lowest bit: first all low bytes, then all high bytes. Playing a bundle needs no simulation.
"""

import base64
import gzip
import json
import math
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.errors import ConfigError
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.facts import Contest
from catch_arena.explanation.seats import labels, prey_labels
from catch_arena.explanation.sentences import contest_sentence
from catch_arena.explanation.what_if import WhatIf
from catch_arena.render.annotations import annotations_of
from catch_arena.render.captions import Caption, Commentary
from catch_arena.render.cards import result
from catch_arena.render.ghost import ghost_track, is_low
from catch_arena.render.lens import Lens, result_text
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Color
from catch_arena.replay import Replay
from catch_arena.replay.motion import Pose2D
from catch_arena.world import World

GRID: Final = 1 << 13
"""Number of parts of the arena's side: 1.4 mm each in the standard arena."""
TURN: Final = 1 << 10
"""Number of parts of a full turn."""

Track = list[Pose2D]
"""Poses of one body, one for each state."""


def bundle_text(replay: Replay, answers: Sequence[WhatIf] = ()) -> str:
    """Return a replay's bundle, in base64, with answers to contests that hunters lost, which the page shows on demand.

    Raises:
        ConfigError: for an answer about another match.
        ReplayError: if the match does not play as recorded.
    """
    return packed_text(encode_bundle(replay, answers))


def packed_text(content: bytes) -> str:
    """Return contents packed for a page: gzip, in base64. Equal contents give equal texts."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode()


def encode_bundle(
    replay: Replay, answers: Sequence[WhatIf] = (), notes: Sequence[Caption] = (), *, hides_seed: bool = False
) -> bytes:
    """Return a replay's bundle before it is packed, with notes as further captions.

    The other arguments and the errors are those of `bundle_text`.
    """
    config, info = replay.config, MatchInfo.of_replay(replay)
    names, prey_names = labels(replay.hunter_names), prey_labels(replay)
    hunters: list[Track] = [[] for _ in names]
    lives: list[list[int]] = [[] for _ in prey_names]
    targets: dict[int, tuple[int, Track]] = {}
    rulings: list[list[Any]] = []
    contests: list[Contest] = []
    lenses: dict[Contest, Lens] = {}
    numbers: dict[object, int] = {}
    played: dict[str, str] = {}
    commentary = Commentary(info)
    captions: list[Caption] = []
    last: World | None = None
    left = {agent: before for before, agent in replay.withdrawals}
    for state, world in enumerate(replay.worlds()):
        for seat, (hunter, poses) in enumerate(zip(world.hunters, hunters, strict=True)):
            poses.append((hunter.x, hunter.y, hunter.theta))
            if hunter.withdrawn:
                left.setdefault(seat, state - 1)  # R1.7: it dropped out before this step
        # requests are judged on the state before (R1.4), which has their targets
        rulings += [
            [state - 1, ruling.hunter, ruling.verdict.name, numbers.get(ruling.target)] for ruling in world.rulings
        ]
        if last is not None:
            found = contests_of(config, world, replay.seed)
            annotations = annotations_of(last, world, found)
            contests += found
            lenses |= {one.lens.contest: one.lens for one in annotations if one.lens is not None}
            shown = commentary.caption
            commentary.record(last.time_ms, annotations, world.team_scores)
            if commentary.caption is not None and commentary.caption is not shown:
                captions.append(commentary.caption)
        last = world
        for target in world.targets:
            numbers[target.name] = target.number
            _, poses = targets.setdefault(target.number, (state, []))
            poses.append((target.x, target.y, target.theta))
        for prey, name, numbers_of in zip(world.prey, prey_names, lives, strict=True):
            if prey.target is not None and prey.target not in played:
                played[prey.target] = name
                numbers_of.append(numbers[prey.target])
    if other := next((answer.contest for answer in answers if answer.contest not in contests), None):
        raise ConfigError(f"answers must be about contests of this match, got one about {other}")
    answers = sorted(answers, key=lambda answer: answer.contest.step)
    ghosts = [ghost_track(answer) for answer in answers]
    facts = {
        "title": replay.title,
        "seed": "hidden" if hides_seed else str(replay.seed),  # seeds may exceed JavaScript's exact integers
        "side": config.side_m,
        "period": config.control_period_ms,
        "steps": replay.steps,
        "grid": GRID,
        "turn": TURN,
        "view": {"radius": config.view_radius_m, "angle": config.view_angle_deg} if config.partial_view else None,
        "hunters": [
            {
                "name": info.names[seat],
                "label": info.label(seat),
                "color": css(info.colors[seat]),
                "reach": config.reaches[seat],
                "pieces": info.rings[seat],
            }
            for seat in range(config.hunters)
        ],
        "teams": [{"name": team.name, "color": css(team.color), "seats": team.seats} for team in info.contenders]
        if info.has_teams
        else None,
        "prey": [
            {"name": info.names[agent], "label": info.label(agent), "targets": numbers_of}
            for agent, numbers_of in enumerate(lives, start=config.hunters)
        ],
        "targets": [[number, first, len(poses)] for number, (first, poses) in targets.items()],
        "withdrawals": [[before, agent] for agent, before in left.items()],
        "rulings": rulings,
        "contests": [
            {
                "state": contest.step - 1,
                "target": contest.target,
                "clause": contest.clause,
                "claims": [[claim.seat, claim.verdict.name, claim.distance_um] for claim in contest.claims],
                "sentence": contest_sentence(contest, names, played.get(contest.target)),
                "lens": (lens := lenses.get(contest))
                and {
                    "corner": lens.corner,
                    "directions": [round(claimant.direction, 3) for claimant in lens.claimants],
                    "result": result_text(contest),
                },
            }
            for contest in contests
        ],
        "answers": [
            {
                "contest": contests.index(answer.contest),
                "agent": answer.seat,
                "text": answer.sentence,
                "atTop": is_low(ghost, config.side_m),
                "first": min(answer.actions, default=0),
                "states": len(ghost),
            }
            for answer, ghost in zip(answers, ghosts, strict=True)
        ],
        "moments": [
            {
                "time": caption.time_ms,
                "agent": caption.agent,
                "text": caption.text,
                "atTop": caption.at_top,
                "contest": caption.lens and contests.index(caption.lens.contest),
            }
            for caption in sorted([*captions, *notes], key=lambda one: one.time_ms)
        ],
        "result": result(info, last.team_scores) if last is not None else "",
    }
    bodies = [*hunters, *(poses for _, poses in targets.values())]
    bodies += [[pose for _, pose in ghost] for ghost in ghosts]
    head = json.dumps(facts, separators=(",", ":"), ensure_ascii=False).encode()
    return head + b"\n" + _tracks(bodies, config.side_m)


def css(color: Color) -> str:
    """Return a colour in the notation of style sheets."""
    return "#{:02x}{:02x}{:02x}".format(*color)


def _tracks(bodies: Iterable[Track], side_m: float) -> bytes:
    parts: list[NDArray[np.int16]] = []
    for poses in bodies:
        x, y, theta = np.array(poses).reshape(-1, 3).T
        ways = [np.diff(np.rint(metres * (GRID / side_m)), prepend=0.0) for metres in (x, y)]
        turns = np.diff(np.rint(theta * (TURN / (2.0 * math.pi))), prepend=0.0)
        ways.append((turns + TURN // 2) % TURN - TURN // 2)
        parts += [np.diff(way, prepend=0.0).astype(np.int16) for way in ways]
    steps = np.concatenate(parts)
    words = ((steps << 1) ^ (steps >> 15)).astype("<u2")
    return words.view(np.uint8).reshape(-1, 2).T.tobytes()

"""Facts of one step: contests, from the arbiter's evidence (R5.6), and targets that a hunter did not see (R7.5)."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.core.arbiter import measure_um
from catch_arena.core.math import sincos
from catch_arena.core.random import service_lot, tie_lot
from catch_arena.core.visibility import is_seen
from catch_arena.engine.core_settings import settings_of
from catch_arena.explanation.facts import Claim, Contest, Unseen
from catch_arena.replay import Replay
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_CONTESTED: Final = (Verdict.GRANTED, Verdict.KILL_FAILED, Verdict.LOST_CONTEST)


def contests_of(replay: Replay, world: World) -> list[Contest]:
    """Return the contests of the step that led to a world."""
    by_target: dict[object, list[Ruling]] = {}
    for ruling in world.rulings:
        if ruling.verdict in _CONTESTED:
            by_target.setdefault(ruling.target, []).append(ruling)
    return [_contest(replay, world, str(target), rulings) for target, rulings in by_target.items() if len(rulings) > 1]


def _contest(replay: Replay, world: World, target: str, rulings: Sequence[Ruling]) -> Contest:
    rulings = sorted(rulings, key=lambda ruling: (-ruling.verdict, ruling.distance_um or 0, ruling.hunter))
    nearest = rulings[0].distance_um
    tied = [ruling.hunter for ruling in rulings if ruling.distance_um == nearest]
    lots: dict[int, int] = {}
    seed, step = np.uint64(replay.seed), world.step - 1
    with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
        if replay.config.policy == "capstone":
            clause = "R9.1"
        elif replay.config.policy == "first_come":
            clause = "R5.9"
            lots = {ruling.hunter: int(service_lot(seed, step, ruling.hunter)) for ruling in rulings}
        elif len(tied) > 1:
            clause = "R5.5"
            number = int(target.removeprefix(replay.config.name_prefix))
            lots = {seat: int(tie_lot(seed, step, number, seat)) for seat in tied}
        else:
            clause = "R5.4"
    team = replay.config.team_by_seat
    claims = tuple(
        Claim(
            ruling.hunter,
            ruling.verdict,
            ruling.distance_um,
            lots.get(ruling.hunter),
            ruling.verdict is Verdict.LOST_CONTEST and team[ruling.hunter] == team[rulings[0].hunter],
        )
        for ruling in rulings
    )
    judged_ms = world.time_ms - replay.config.control_period_ms
    return Contest(world.step, judged_ms, target, clause, claims)


def unseen_targets(config: ArenaConfig, world: World, seat: int) -> list[Unseen]:
    """Return the targets that a seat does not see, the nearest first; a withdrawn hunter counts like an active one."""
    settings = settings_of(config, with_parts=False)
    me, found = world.hunters[seat], []
    sine, cosine = sincos(me.theta)
    for target in world.targets:
        dx, dy = target.x - me.x, target.y - me.y
        if is_seen(dx, dy, sine, cosine, config.reaches_um[seat], settings):
            continue
        off_deg = abs(math.degrees(math.remainder(math.atan2(dy, dx) - me.theta, 2.0 * math.pi)))
        found.append(Unseen(target.name, int(measure_um(dx, dy)), off_deg))
    return sorted(found, key=lambda target: target.distance_um)

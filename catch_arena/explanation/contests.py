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
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_CONTESTED: Final = (Verdict.GRANTED, Verdict.KILL_FAILED, Verdict.LOST_CONTEST)


def contests_of(config: ArenaConfig, world: World, seed: int | None = None) -> list[Contest]:
    """Return the contests of the step that led to a world; without the match's seed, their claims have no lots."""
    by_target: dict[object, list[Ruling]] = {}
    for ruling in world.rulings:
        if ruling.verdict in _CONTESTED:
            by_target.setdefault(ruling.target, []).append(ruling)
    return [
        _contest(config, world, str(target), rulings, seed) for target, rulings in by_target.items() if len(rulings) > 1
    ]


def _contest(config: ArenaConfig, world: World, target: str, rulings: Sequence[Ruling], seed: int | None) -> Contest:
    winner, team = max(rulings, key=lambda ruling: ruling.verdict), config.team_by_seat
    tied = [ruling.hunter for ruling in rulings if ruling.distance_um == winner.distance_um]
    if config.policy == "capstone":
        clause = "R9.1"
    elif config.policy == "first_come":
        clause = "R5.9"
    else:
        clause = "R5.5" if len(tied) > 1 else "R5.4"
    lots: dict[int, int] = {}
    if seed is not None:
        with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
            if clause == "R5.9":
                lots = {one.hunter: int(service_lot(np.uint64(seed), world.step - 1, one.hunter)) for one in rulings}
            elif clause == "R5.5":
                number = int(target.removeprefix(config.name_prefix))
                lots = {seat: int(tie_lot(np.uint64(seed), world.step - 1, number, seat)) for seat in tied}
    claims = [
        Claim(
            ruling.hunter,
            ruling.verdict,
            ruling.distance_um,
            lots.get(ruling.hunter),
            ruling.verdict is Verdict.LOST_CONTEST and team[ruling.hunter] == team[winner.hunter],
        )
        for ruling in rulings
    ]
    near = winner.distance_um
    claims.sort(
        key=lambda one: (-one.verdict, one.mate and one.distance_um != near, one.distance_um or 0, one.mate, one.seat)
    )
    return Contest(world.step, world.time_ms - config.control_period_ms, target, clause, tuple(claims))


def unseen_targets(config: ArenaConfig, world: World, seat: int) -> list[Unseen]:
    """Return the targets that a seat does not see, the nearest first; a withdrawn hunter counts like an active one."""
    settings = settings_of(config)
    me, found = world.hunters[seat], []
    sine, cosine = sincos(me.theta)
    for target in world.targets:
        dx, dy = target.x - me.x, target.y - me.y
        if is_seen(dx, dy, sine, cosine, config.reaches_um[seat], settings):
            continue
        off_deg = abs(math.degrees(math.remainder(math.atan2(dy, dx) - me.theta, 2.0 * math.pi)))
        found.append(Unseen(target.name, int(measure_um(dx, dy)), off_deg))
    return sorted(found, key=lambda target: target.distance_um)

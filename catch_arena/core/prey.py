"""Rulebook chapter 12: targets that agents play: their commands, their catches and returns, and their rewards.

The functions work lane by lane, since each prey plays a target in any slot. It moves there like any other
(`physics.move`).
"""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows, state
from catch_arena.core.jit import Rows, entry, outlined, rule
from catch_arena.core.math import clamp
from catch_arena.core.memory import Bytes, Sections, sections_of, settings_in
from catch_arena.core.random import seed_of
from catch_arena.core.spawner import spawn_next
from catch_arena.core.state import ALL_OPTIONS, Settings, prey_of, seat_of, targets_of
from catch_arena.core.targets import nearest_hunter
from catch_arena.core.vectors import LANES, sqrt


@outlined
def begin_prey(chunk: Rows, s: Settings, lane: int) -> None:
    """R12.1: give the first targets to prey, by index."""
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        me[rows.PREY_SLOT + lane] = index
        me[rows.CAUGHT_AT + lane] = rows.NOT_CAUGHT
        me[rows.CAUGHT_BY + lane] = rows.NO_SEAT


@rule
def measures_gain(s: Settings, sections: Sections) -> bool:
    """R12.5: return whether the gain on the nearest hunter has a weight, or the parts are kept."""
    return s.gained_weight != 0.0 or len(sections.prey_parts) > 0


@outlined
def command_prey(
    chunk: Rows, s: Settings, lanes: int, targets: Rows, commands: NDArray[np.float32], sections: Sections
) -> None:
    """R12.2, R12.5: set prey's velocities for this step, and note the distances from which the gain is counted."""
    for index in range(s.prey):
        me, agent = prey_of(chunk, s, index), s.hunters + index
        reference = sections.prey_references[index]
        for lane in range(lanes):
            slot = int(me[rows.PREY_SLOT + lane])
            me[rows.CAUGHT_BY + lane] = rows.NO_SEAT
            reference[state.IN_PLAY + lane] = 0.0 if slot == rows.NO_TARGET else 1.0
            reference[state.HUNTER_DISTANCE + lane] = rows.NOT_MEASURED
            if slot == rows.NO_TARGET:
                continue
            at = slot * s.slot_size + lane
            speed = clamp(
                np.float64(commands[lane, agent, 0]) * s.target_speed_mps, s.prey_min_speed_mps, s.target_speed_mps
            )
            turn_rate = clamp(
                np.float64(commands[lane, agent, 1]) * s.target_turn_rate_radps,
                -s.target_turn_rate_radps,
                s.target_turn_rate_radps,
            )
            driven = me[rows.PREY_WITHDRAWN + lane] == 0.0
            targets[rows.BODY + rows.SPEED + at] = speed if driven else 0.0
            targets[rows.BODY + rows.TURN_RATE + at] = turn_rate if driven else 0.0
            if measures_gain(s, sections):
                seat = nearest_hunter(chunk, s, lane, targets, at)
                if seat >= 0:
                    x, y = seat_of(chunk, seat)[rows.X + lane], seat_of(chunk, seat)[rows.Y + lane]
                    reference[state.HUNTER_X + lane] = x
                    reference[state.HUNTER_Y + lane] = y
                    reference[state.HUNTER_DISTANCE + lane] = distance(targets, at, x, y)


@rule
def distance(targets: Rows, at: int, x: float, y: float) -> float:
    """Return the distance between a target and a position [m]."""
    dx, dy = x - targets[rows.TARGET_X + at], y - targets[rows.TARGET_Y + at]
    return sqrt(dx * dx + dy * dy)


@outlined
def catch_prey(chunk: Rows, s: Settings, lane: int, seat: int, slot: int) -> None:
    """R12.3: mark the prey that plays the target in one slot as caught by a seat; called before the target leaves."""
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        if me[rows.PREY_SLOT + lane] == slot:
            me[rows.PREY_SLOT + lane] = rows.NO_TARGET
            me[rows.TIMES_CAUGHT + lane] += 1.0
            me[rows.CAUGHT_AT + lane] = chunk[rows.TIME + lane]
            me[rows.CAUGHT_BY + lane] = seat


@outlined
def return_prey(chunk: Rows, s: Settings, lanes: int, targets: Rows) -> None:
    """R12.3: give prey that was out long enough the next target, after all firings of a step, if there is room."""
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        for lane in range(lanes):
            now = chunk[rows.TIME + lane] + s.period_ms
            if (
                me[rows.PREY_SLOT + lane] == rows.NO_TARGET
                and now >= me[rows.CAUGHT_AT + lane] + s.prey_returns_ms
                and chunk[rows.ALIVE + lane] < s.max_targets
            ):
                me[rows.PREY_SLOT + lane] = chunk[rows.ALIVE + lane]
                me[rows.CAUGHT_AT + lane] = rows.NOT_CAUGHT
                spawn_next(chunk, s, lane, targets, seed_of(chunk, lane), now)


@rule
def prey_parts(me: Rows, s: Settings, lane: int, targets: Rows, reference: Rows) -> tuple[float, float, float]:
    """R12.5: return the reward parts of one prey that is not withdrawn, in the order of `state.PREY_PART_NAMES`."""
    if me[rows.CAUGHT_BY + lane] >= 0.0:
        return 1.0, 0.0, 0.0
    if reference[state.IN_PLAY + lane] == 0.0:
        return 0.0, 0.0, 0.0
    gained = 0.0
    if reference[state.HUNTER_DISTANCE + lane] >= 0.0:
        at = int(me[rows.PREY_SLOT + lane]) * s.slot_size + lane
        x, y = reference[state.HUNTER_X + lane], reference[state.HUNTER_Y + lane]
        gained = distance(targets, at, x, y) - reference[state.HUNTER_DISTANCE + lane]
    return 0.0, s.period_s, gained


@outlined
def reward_prey(
    chunk: Rows,
    s: Settings,
    lanes: int,
    targets: Rows,
    had_ended: bool,
    sections: Sections,
    rewards: NDArray[np.float64],
    parts: NDArray[np.float64],
) -> None:
    """R12.5: write the weighted sum of the parts, and the parts if they are kept. `had_ended`: some arenas had ended
    before this step; prey in those gets nothing.
    """
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        reference = sections.prey_references[index]
        for lane in range(lanes):
            total, caught, survived, gained = 0.0, 0.0, 0.0, 0.0
            if had_ended and sections.snapshot[rows.ENDED + lane] != rows.RUNNING:
                me[rows.CAUGHT_BY + lane] = rows.NO_SEAT
            elif me[rows.PREY_WITHDRAWN + lane] == 0.0:
                caught, survived, gained = prey_parts(me, s, lane, targets, reference)
                total = s.caught_weight * caught + s.survived_weight * survived + s.gained_weight * gained
                me[rows.PREY_REWARD_SUM + lane] += total
            rewards[lane, s.hunters + index] = total
            if len(parts) > 0:
                parts[lane, index, 0] = caught
                parts[lane, index, 1] = survived
                parts[lane, index, 2] = gained


@rule
def is_ahead(one: Rows, other: Rows, lane: int) -> bool:
    """R12.5: return whether one prey ranks before another: withdrawn prey is last, then fewer catches come first."""
    if one[rows.PREY_WITHDRAWN + lane] != other[rows.PREY_WITHDRAWN + lane]:
        return bool(one[rows.PREY_WITHDRAWN + lane] < other[rows.PREY_WITHDRAWN + lane])
    return bool(one[rows.TIMES_CAUGHT + lane] < other[rows.TIMES_CAUGHT + lane])


@outlined
def write_prey_records(chunk: Rows, s: Settings, lane: int, record: NDArray[np.float32]) -> None:
    """Write prey's records of one lane's episode as it is now; `record`, (N, figures), is the result."""
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        rank = 1.0
        for other in range(s.prey):
            rank += 1.0 if is_ahead(prey_of(chunk, s, other), me, lane) else 0.0
        record[s.hunters + index, rows.FINAL_SCORE] = me[rows.TIMES_CAUGHT + lane]
        record[s.hunters + index, rows.FINAL_RANK] = rank
        record[s.hunters + index, rows.FINAL_REWARD_SUM] = me[rows.PREY_REWARD_SUM + lane]


@entry
def withdraw_prey_at(memory: Bytes, arena: int, index: int) -> None:
    """R12.5: withdraw one prey: it stands still from now on."""
    sections = sections_of(memory, 0)
    s = settings_in(sections.settings, ALL_OPTIONS)
    chunk, lane = sections.chunks[arena // LANES], arena % LANES
    me, targets = prey_of(chunk, s, index), targets_of(chunk, s)
    me[rows.PREY_WITHDRAWN + lane] = 1.0
    slot = int(me[rows.PREY_SLOT + lane])
    if slot != rows.NO_TARGET:
        targets[slot * s.slot_size + rows.BODY + rows.SPEED + lane] = 0.0
        targets[slot * s.slot_size + rows.BODY + rows.TURN_RATE + lane] = 0.0

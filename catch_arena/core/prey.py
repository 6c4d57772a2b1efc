"""Rulebook chapter 12: targets that agents play: their commands, their catches and returns, and what they gained.

One lane at a time, since each plays a target in any slot; it moves there like any other (`physics.move`).
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, entry, outlined, rule
from catch_arena.core.math import clamp
from catch_arena.core.memory import Bytes, Sections, sections_of, settings_in
from catch_arena.core.random import seed_of
from catch_arena.core.spawner import spawn_next
from catch_arena.core.state import (
    ALIVE,
    ALL_OPTIONS,
    BODY,
    CAUGHT_AT,
    CAUGHT_BY,
    ENDED,
    FINAL_RANK,
    FINAL_REWARD_SUM,
    FINAL_SCORE,
    LANES,
    NO_TARGET,
    PREY_REWARD_SUM,
    PREY_SLOT,
    PREY_WITHDRAWN,
    RUNNING,
    SEED_HIGH,
    SEED_LOW,
    SPEED,
    TARGET_X,
    TARGET_Y,
    TIME,
    TIMES_CAUGHT,
    TURN_RATE,
    Settings,
    X,
    Y,
    prey_of,
    seat_of,
    targets_of,
)
from catch_arena.core.targets import nearest_hunter
from catch_arena.core.vectors import sqrt

# rows of a reference, of each prey from phase 2 to its reward
IN_PLAY: Final = 0 * LANES  # 1 where it was not out on S_t, else 0
HUNTER_DISTANCE: Final = 1 * LANES  # [m] to the nearest hunter of S_t, -1 where there is none or nobody asks
HUNTER_X: Final = 2 * LANES  # [m] where that was
HUNTER_Y: Final = 3 * LANES


@outlined
def begin_prey(block: Block, s: Settings, lane: int) -> None:
    """R12.1: the first targets are prey's, by index."""
    for index in range(s.prey):
        me = prey_of(block, index, s)
        me[PREY_SLOT + lane] = index
        me[CAUGHT_AT + lane] = -1.0
        me[CAUGHT_BY + lane] = -1.0


@outlined
def command_prey(
    block: Block, s: Settings, lanes: int, targets: Block, commands: NDArray[np.float32], sections: Sections
) -> None:
    """R12.2: prey's velocities for this step, and from where R12.5's gain is counted.

    Args:
        sections: see `memory.Sections`; the references are written.
    """
    for index in range(s.prey):
        me, agent = prey_of(block, index, s), s.hunters + index
        reference = sections.prey_references[index]
        for lane in range(lanes):
            slot = int(me[PREY_SLOT + lane])
            me[CAUGHT_BY + lane] = -1.0
            reference[IN_PLAY + lane] = 0.0 if slot == NO_TARGET else 1.0
            reference[HUNTER_DISTANCE + lane] = -1.0
            if slot == NO_TARGET:
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
            driven = me[PREY_WITHDRAWN + lane] == 0.0
            targets[BODY + SPEED + at] = speed if driven else 0.0
            targets[BODY + TURN_RATE + at] = turn_rate if driven else 0.0
            if s.needs_gain:
                seat = nearest_hunter(block, targets, lane, at, s)
                if seat >= 0:
                    x, y = seat_of(block, seat)[X + lane], seat_of(block, seat)[Y + lane]
                    reference[HUNTER_X + lane] = x
                    reference[HUNTER_Y + lane] = y
                    reference[HUNTER_DISTANCE + lane] = distance(targets, at, x, y)


@rule
def distance(targets: Block, at: int, x: float, y: float) -> float:
    """Between a target and a position [m].

    Args:
        at: where in `targets` the slot begins, its lane included.
        x: the position [m].
        y: the position [m].
    """
    dx, dy = x - targets[TARGET_X + at], y - targets[TARGET_Y + at]
    return sqrt(dx * dx + dy * dy)


@outlined
def catch_prey(block: Block, s: Settings, lane: int, slot: int, seat: int) -> None:
    """R12.3: whoever plays the target in one slot is out, caught by that seat; before the target leaves.

    Args:
        slot: of the target that was caught.
        seat: who caught it.
    """
    for index in range(s.prey):
        me = prey_of(block, index, s)
        if me[PREY_SLOT + lane] == slot:
            me[PREY_SLOT + lane] = NO_TARGET
            me[TIMES_CAUGHT + lane] += 1.0
            me[CAUGHT_AT + lane] = block[TIME + lane]
            me[CAUGHT_BY + lane] = seat


@outlined
def return_prey(block: Block, s: Settings, lanes: int, targets: Block) -> None:
    """R12.3: after all firings of a step, whoever was out long enough plays the next target, where there is room."""
    for index in range(s.prey):
        me = prey_of(block, index, s)
        for lane in range(lanes):
            now = block[TIME + lane] + s.period_ms
            if (
                me[PREY_SLOT + lane] == NO_TARGET
                and now >= me[CAUGHT_AT + lane] + s.prey_returns_ms
                and block[ALIVE + lane] < s.max_targets
            ):
                me[PREY_SLOT + lane] = block[ALIVE + lane]
                me[CAUGHT_AT + lane] = -1.0
                spawn_next(block, targets, lane, seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane]), s, now)


@rule
def prey_parts(me: Block, reference: Block, targets: Block, lane: int, s: Settings) -> tuple[float, float, float]:
    """R12.5: the parts of what one prey gets that is not withdrawn, in the order of `state.PREY_PART_NAMES`."""
    if me[CAUGHT_BY + lane] >= 0.0:
        return 1.0, 0.0, 0.0
    if reference[IN_PLAY + lane] == 0.0:
        return 0.0, 0.0, 0.0
    gained = 0.0
    if reference[HUNTER_DISTANCE + lane] >= 0.0:
        at = int(me[PREY_SLOT + lane]) * s.slot_size + lane
        x, y = reference[HUNTER_X + lane], reference[HUNTER_Y + lane]
        gained = distance(targets, at, x, y) - reference[HUNTER_DISTANCE + lane]
    return 0.0, s.period_s, gained


@outlined
def reward_prey(
    block: Block,
    s: Settings,
    lanes: int,
    had_ended: bool,
    targets: Block,
    sections: Sections,
    rewards: NDArray[np.float64],
    parts: NDArray[np.float64],
) -> None:
    """R12.5: the weighted sum of the parts, and the parts where there is room for them.

    Args:
        had_ended: whether some of them had ended before this step: those get nothing.
        rewards: (lanes, N), of which prey's are written.
        parts: (lanes, P, parts), in the order of `state.PREY_PART_NAMES`; or none.
    """
    for index in range(s.prey):
        me = prey_of(block, index, s)
        reference = sections.prey_references[index]
        for lane in range(lanes):
            total, caught, survived, gained = 0.0, 0.0, 0.0, 0.0
            if had_ended and sections.snapshot[ENDED + lane] != RUNNING:
                me[CAUGHT_BY + lane] = -1.0
            elif me[PREY_WITHDRAWN + lane] == 0.0:
                caught, survived, gained = prey_parts(me, reference, targets, lane, s)
                total = s.caught_weight * caught + s.survived_weight * survived + s.gained_weight * gained
                me[PREY_REWARD_SUM + lane] += total
            rewards[lane, s.hunters + index] = total
            if len(parts) > 0:
                parts[lane, index, 0] = caught
                parts[lane, index, 1] = survived
                parts[lane, index, 2] = gained


@rule
def is_ahead(one: Block, other: Block, lane: int) -> bool:
    """R12.5: whether one prey ranks before another: withdrawn prey is last, else the fewest catches come first.

    Args:
        one: the rows of one prey.
        other: the rows of the other.
    """
    if one[PREY_WITHDRAWN + lane] != other[PREY_WITHDRAWN + lane]:
        return bool(one[PREY_WITHDRAWN + lane] < other[PREY_WITHDRAWN + lane])
    return bool(one[TIMES_CAUGHT + lane] < other[TIMES_CAUGHT + lane])


@outlined
def write_prey_records(block: Block, s: Settings, lane: int, record: NDArray[np.float32]) -> None:
    """An episode in figures, as it stands in one lane.

    Args:
        record: the result, (N, figures); the rows of prey are written.
    """
    for index in range(s.prey):
        me = prey_of(block, index, s)
        rank = 1.0
        for other in range(s.prey):
            rank += 1.0 if is_ahead(prey_of(block, other, s), me, lane) else 0.0
        record[s.hunters + index, FINAL_SCORE] = me[TIMES_CAUGHT + lane]
        record[s.hunters + index, FINAL_RANK] = rank
        record[s.hunters + index, FINAL_REWARD_SUM] = me[PREY_REWARD_SUM + lane]


@entry
def withdraw_prey_at(memory: Bytes, arena: int, index: int) -> None:
    """R12.5: prey is withdrawn: it stands still from now on.

    Args:
        index: which prey.
    """
    sections = sections_of(memory, 0)
    s = settings_in(sections.settings, ALL_OPTIONS)
    block, lane = sections.blocks[arena // LANES], arena % LANES
    me, targets = prey_of(block, index, s), targets_of(block, s)
    me[PREY_WITHDRAWN + lane] = 1.0
    slot = int(me[PREY_SLOT + lane])
    if slot != NO_TARGET:
        targets[slot * s.slot_size + BODY + SPEED + lane] = 0.0
        targets[slot * s.slot_size + BODY + TURN_RATE + lane] = 0.0

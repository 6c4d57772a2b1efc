"""Rulebook R1.4: one step, phase by phase; and reset. This file is the table of contents of the core."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import (
    DISTANCE,
    INACTIVE,
    NO_SUCH_RANK,
    REFUSED,
    SEAT,
    TARGET,
    TARGET_NUMBER,
    Docket,
    distance_um,
    judge,
)
from catch_arena.core.arbiter import VERDICT as DOCKET_VERDICT
from catch_arena.core.arbiter import WINNER as DOCKET_WINNER
from catch_arena.core.controllers import (
    choose,
    drive_by_command,
    drive_to_target,
    mark_active,
    request_nearest,
)
from catch_arena.core.jit import Block, entry, phase
from catch_arena.core.math import PI, TAU, sincos, wrap
from catch_arena.core.observations import Columns, observe
from catch_arena.core.physics import move
from catch_arena.core.random import START, draw, fraction, kill_refused, kill_service_down, seed_of, stream
from catch_arena.core.rewards import aim_again, aim_at_nearest, reward
from catch_arena.core.spawner import remove_target, spawn_next, spawn_through
from catch_arena.core.state import (
    ALIVE,
    DISTANCE_UM,
    ENDED,
    LANES,
    NO_TARGET,
    PART_NAMES,
    PARTS,
    REQUEST,
    RUNNING,
    SCORE,
    SEED_HIGH,
    SEED_LOW,
    SPAWNED,
    SPEED,
    STEP,
    TERMINATED,
    THETA,
    TIME,
    TRUNCATED,
    TURN_RATE,
    VERDICT,
    WANTED,
    WINNER,
    WITHDRAWN,
    Settings,
    Targets,
    X,
    Y,
    read_settings,
    seat_of,
    targets_of,
    view_of,
)
from catch_arena.verdicts import Verdict

_GRANTED: Final = int(Verdict.GRANTED)
_MATCH_OVER: Final = int(Verdict.MATCH_OVER)
_PARTS: Final = len(PART_NAMES)

TARGET_CONTROL: Final = 0
VELOCITY_CONTROL: Final = 1
FULL_CONTROL: Final = 2


@phase
def take_in(
    block: Block,
    s: Settings,
    lanes: int,
    controls: NDArray[np.int64],
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
) -> None:
    """R1.4's phases 1 and 2: from actions to velocities and wishes, on S_t."""
    targets = targets_of(block, s)
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        view = view_of(block, seat, s)
        if controls[seat] == TARGET_CONTROL:
            choose(me, view, choices[:, seat], lanes)
            drive_to_target(me, targets, lanes, s)
        elif controls[seat] == VELOCITY_CONTROL:
            request_nearest(me, view, targets, lanes, s)
            drive_by_command(me, commands[:, seat], lanes, s)
        else:
            choose(me, view, choices[:, seat], lanes)
            mark_active(me, targets, lanes)
            drive_by_command(me, commands[:, seat], lanes, s)
        if s.progress_wanted:
            aim_at_nearest(me, view, targets, lanes)


@phase
def clear_evidence(block: Block, s: Settings, lanes: int, asked: Block) -> None:
    """No request yet; `asked` counts the wishes of each lane."""
    for lane in range(lanes):
        asked[lane] = 0.0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for lane in range(lanes):
            me[REQUEST + lane] = 0.0
            me[VERDICT + lane] = 0.0
            me[DISTANCE_UM + lane] = -1.0
            me[WINNER + lane] = -1.0
            asked[lane] += 0.0 if me[WANTED + lane] == NO_TARGET else 1.0


@phase
def arbitrate(block: Block, s: Settings, lane: int, targets: Targets, docket: Docket) -> None:
    """R1.4's phase 3 in one lane: the docket is filled from S_t, judged, and the evidence noted."""
    seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
    step = block[STEP + lane]
    requests = 0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        wanted = int(me[WANTED + lane])
        if wanted == NO_TARGET:
            continue
        docket[requests, SEAT] = seat
        docket[requests, TARGET] = wanted
        docket[requests, TARGET_NUMBER] = 0
        docket[requests, DISTANCE] = -1
        docket[requests, INACTIVE] = int(me[WITHDRAWN + lane])
        docket[requests, REFUSED] = 0
        if wanted != NO_SUCH_RANK:
            at = wanted * LANES + lane
            number = targets.number[at]
            me[REQUEST + lane] = number
            docket[requests, TARGET_NUMBER] = int(number)
            docket[requests, DISTANCE] = int(distance_um(targets.x[at] - me[X + lane], targets.y[at] - me[Y + lane]))
            docket[requests, REFUSED] = int(kill_refused(seed, step, number, s.kill_refused_rate))
        requests += 1
    service_up = not kill_service_down(seed, step, s.kill_down_rate)
    judge(docket[:requests], s.policy, seed, int(step), int(s.reach_um), block[ENDED + lane] != RUNNING, service_up)
    for i in range(requests):
        me = seat_of(block, docket[i, SEAT])
        me[VERDICT + lane] = docket[i, DOCKET_VERDICT]
        me[DISTANCE_UM + lane] = docket[i, DISTANCE]
        me[WINNER + lane] = docket[i, DOCKET_WINNER]


@phase
def commit(block: Block, s: Settings, lane: int, targets: Targets) -> None:
    """R1.4's phase 4 in one lane: grants are credited, and the targets whose kill is not refused leave (R5.7, R5.8)."""
    seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
    removed = 0
    for slot in range(int(block[ALIVE + lane]) - 1, -1, -1):  # backwards: those behind a removed slot move up
        number = targets.number[slot * LANES + lane]
        caught = False
        for seat in range(s.hunters):
            me = seat_of(block, seat)
            caught = caught or (me[VERDICT + lane] == _GRANTED and me[REQUEST + lane] == number)
        if caught and not kill_refused(seed, block[STEP + lane], number, s.kill_refused_rate):
            remove_target(block, targets, lane, slot)
            removed += 1
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        me[SCORE + lane] += 1.0 if me[VERDICT + lane] == _GRANTED else 0.0
    if removed > 0 and s.progress_wanted:
        for seat in range(s.hunters):
            aim_again(block, seat_of(block, seat), targets, lane)


@phase
def end_test(block: Block, s: Settings, lanes: int) -> None:
    """R1.1, R1.5, R1.4's phase 6: the clock goes on in whole milliseconds, and the episode may end."""
    for lane in range(lanes):
        time = block[TIME + lane] + s.period
        finished = (block[SPAWNED + lane] >= s.target_budget) & (block[ALIVE + lane] == 0.0)
        block[TIME + lane] = time
        block[STEP + lane] += 1.0
        block[ENDED + lane] = TERMINATED if finished else (TRUNCATED if time >= s.time_limit else RUNNING)


@phase
def keep_ended(block: Block, lanes: int, kept: Block) -> bool:
    """R5.2: arenas that have ended are played with the others of their block, and then put back; here they are
    copied.
    """
    some = False
    for lane in range(lanes):
        some = some or block[ENDED + lane] != RUNNING
    if some:
        for i in range(len(block)):
            kept[i] = block[i]
    return some


@phase
def put_back_ended(block: Block, s: Settings, lanes: int, kept: Block, rewards: NDArray[np.float64]) -> None:
    """R5.2: after the end nothing moves, and every request is MATCH_OVER."""
    for lane in range(lanes):
        if kept[ENDED + lane] == RUNNING:
            continue
        for seat in range(s.hunters):
            now, then = seat_of(block, seat), seat_of(kept, seat)
            then[WANTED + lane] = now[WANTED + lane]
            then[REQUEST + lane] = now[REQUEST + lane]
            then[VERDICT + lane] = 0.0 if now[WANTED + lane] == NO_TARGET else float(_MATCH_OVER)
            then[DISTANCE_UM + lane] = -1.0
            then[WINNER + lane] = -1.0
            for part in range(_PARTS):
                then[PARTS + part * LANES + lane] = 0.0
            rewards[lane, seat] = 0.0
        for row in range(len(block) // LANES):
            block[row * LANES + lane] = kept[row * LANES + lane]


@entry
def step(
    memory: NDArray[np.float64],
    settings: NDArray[np.float64],
    controls: NDArray[np.int64],
    target_network: NDArray[np.int64],
    rival_network: NDArray[np.int64],
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    numbers: NDArray[np.float64],
    columns: Columns,
    docket: Docket,
    observations: NDArray[np.float32],
    masks: NDArray[np.int8],
    rewards: NDArray[np.float64],
) -> None:
    """R1.4: one step of every arena of a batch.

    Args: `memory` (blocks, rows * LANES); `settings`, see `state.read_settings`; `controls` (H,); the networks (n, 2)
    of `selection_network`; the actions `choices` (B, H) and `commands` (B, H, 2); scratch, `numbers`, `columns` and
    `docket`; the outputs `observations` (B, H, D), `masks` (B, H, K + 1) and `rewards` (B, H).
    """
    s = read_settings(settings)
    rows = numbers[: 2 * LANES]
    kept = numbers[len(numbers) - memory.shape[1] :]
    for index in range(len(memory)):
        block = memory[index]
        first = index * LANES
        last = min(first + LANES, len(choices))
        lanes = last - first
        targets = targets_of(block, s)
        some_ended = keep_ended(block, lanes, kept)
        take_in(block, s, lanes, controls, choices[first:last], commands[first:last])
        clear_evidence(block, s, lanes, rows)
        for lane in range(lanes):
            if rows[lane] > 0.0:
                arbitrate(block, s, lane, targets, docket)
                commit(block, s, lane, targets)
        move(block, s, lanes, rows)
        spawn_through(block, targets, lanes, s)
        end_test(block, s, lanes)
        reward(block, s, lanes, rows, rewards[first:last])
        if some_ended:
            put_back_ended(block, s, lanes, kept, rewards[first:last])
        observe(
            block,
            s,
            lanes,
            target_network,
            rival_network,
            numbers,
            columns,
            observations[first:last],
            masks[first:last],
        )


@phase
def reset_lane(block: Block, s: Settings, lane: int, start_poses: NDArray[np.float64], seed: np.uint64) -> None:
    """R2.6, R3.1, A.6: one arena at the beginning of an episode."""
    rows = len(block) // LANES
    for row in range(rows):
        block[row * LANES + lane] = 0.0
    block[SEED_HIGH + lane] = float(seed >> np.uint64(32))
    block[SEED_LOW + lane] = float(seed & np.uint64(0xFFFFFFFF))
    turn = TAU * fraction(draw(stream(seed, START), np.uint64(0)))
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        if len(start_poses) > 0:
            me[X + lane] = start_poses[seat, 0]
            me[Y + lane] = start_poses[seat, 1]
            me[THETA + lane] = wrap(start_poses[seat, 2])
        elif s.hunters == 1:
            me[X + lane] = s.side / 2.0
            me[Y + lane] = s.side / 2.0
        else:
            angle = wrap(turn + TAU * seat / s.hunters)
            sine, cosine = sincos(angle)
            me[X + lane] = s.side / 2.0 + s.start_radius * cosine
            me[Y + lane] = s.side / 2.0 + s.start_radius * sine
            me[THETA + lane] = wrap(angle + PI)
        clear_hunter(me, lane)
    targets = targets_of(block, s)
    for _ in range(s.initial_targets):
        spawn_next(block, targets, lane, seed, s, 0.0)


@phase
def clear_hunter(me: Block, lane: int) -> None:
    """At rest, and with no verdict."""
    me[SPEED + lane] = 0.0
    me[TURN_RATE + lane] = 0.0
    me[WANTED + lane] = NO_TARGET
    me[DISTANCE_UM + lane] = -1.0
    me[WINNER + lane] = -1.0


@entry
def reset(
    memory: NDArray[np.float64],
    settings: NDArray[np.float64],
    target_network: NDArray[np.int64],
    rival_network: NDArray[np.int64],
    start_poses: NDArray[np.float64],
    chosen: NDArray[np.int64],
    seeds: NDArray[np.uint64],
    numbers: NDArray[np.float64],
    columns: Columns,
    observations: NDArray[np.float32],
    masks: NDArray[np.int8],
) -> None:
    """The chosen arenas at the beginning of an episode, and the observations of all, chosen or not.

    Args: `start_poses` (H, 3), or (0, 3) for the fair circle (R2.6); `chosen` (n,) rows of the batch; `seeds` (n,);
    the others as for `step`.
    """
    s = read_settings(settings)
    for i in range(len(chosen)):
        reset_lane(memory[chosen[i] // LANES], s, chosen[i] % LANES, start_poses, seeds[i])
    for index in range(len(memory)):
        first = index * LANES
        last = min(first + LANES, len(observations))
        observe(
            memory[index],
            s,
            last - first,
            target_network,
            rival_network,
            numbers,
            columns,
            observations[first:last],
            masks[first:last],
        )

"""Rulebook R1.4: one step, phase by phase. This file is the table of contents of the core."""

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
    drive_to_goal,
    mark_active,
    request_nearest,
)
from catch_arena.core.episodes import begin, begin_again
from catch_arena.core.jit import Block, entry, passage, phase
from catch_arena.core.observations import Masks, Observations, observe
from catch_arena.core.physics import move
from catch_arena.core.random import kill_refused, kill_service_down, seed_of
from catch_arena.core.rewards import Rewards, aim_again, aim_at_nearest, reward
from catch_arena.core.spawner import remove_target, spawn_through
from catch_arena.core.state import (
    ALIVE,
    CONTESTS_WON,
    DISTANCE_UM,
    ENDED,
    LANES,
    NO_TARGET,
    REQUEST,
    RUNNING,
    SCORE,
    SEED_HIGH,
    SEED_LOW,
    SETTINGS,
    SPAWNED,
    STEP,
    TALLIES,
    TERMINATED,
    TIME,
    TRUNCATED,
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
    span,
    targets_of,
    view_of,
)
from catch_arena.core.vectors import Width, any_of, group, select
from catch_arena.core.workspace import Scratch, Tables, aim_of, scratch_of, tables_of
from catch_arena.verdicts import Verdict

_GRANTED: Final = int(Verdict.GRANTED)
_MATCH_OVER: Final = int(Verdict.MATCH_OVER)
_LOST_CONTEST: Final = int(Verdict.LOST_CONTEST)

TARGET_CONTROL: Final = 0
VELOCITY_CONTROL: Final = 1
FULL_CONTROL: Final = 2


@passage
def take_in(
    block: Block,
    s: Settings,
    width: Width,
    lanes: int,
    controls: NDArray[np.int64],
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    scratch: Scratch,
) -> None:
    """R1.4's phases 1 and 2: from actions to velocities and wishes, on S_t."""
    targets = targets_of(block, s)
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        view = view_of(block, seat, s)
        if controls[seat] == TARGET_CONTROL:
            choose(block, me, view, targets, choices[:, seat], lanes, s, scratch.rows)
            drive_to_goal(me, scratch.rows, width, s)
        elif controls[seat] == VELOCITY_CONTROL:
            request_nearest(block, me, view, targets, lanes, s)
            drive_by_command(me, commands[:, seat], width, lanes, s)
        else:
            choose(block, me, view, targets, choices[:, seat], lanes, s, scratch.rows)
            mark_active(me, scratch.rows, width)
            drive_by_command(me, commands[:, seat], width, lanes, s)
        if s.progress_wanted:
            aim_at_nearest(block, me, view, targets, lanes, aim_of(scratch, seat))


@passage
def clear_evidence(block: Block, s: Settings, width: Width, asked: Block) -> None:
    """No verdict yet; `asked` counts the wishes of each lane."""
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        wishes = 0.0
        judged = False
        for seat in range(s.hunters):
            me = seat_of(block, seat)
            wishes = wishes + select(me[WANTED + lane] == float(NO_TARGET), 0.0, 1.0)
            judged = judged | (me[VERDICT + lane] > 0.0)
        asked[lane] = wishes
        if any_of(judged):  # most steps leave nothing to be cleared
            for seat in range(s.hunters):
                me = seat_of(block, seat)
                me[REQUEST + lane] = 0.0
                me[VERDICT + lane] = 0.0
                me[DISTANCE_UM + lane] = -1.0
                me[WINNER + lane] = -1.0


@passage
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
        me[TALLIES + (docket[i, DOCKET_VERDICT] - 1) * LANES + lane] += 1.0
        for j in range(requests):
            if docket[j, DOCKET_VERDICT] == _LOST_CONTEST and docket[j, DOCKET_WINNER] == docket[i, SEAT]:
                me[CONTESTS_WON + lane] += 1.0
                break


@passage
def commit(block: Block, s: Settings, lane: int, targets: Targets, scratch: Scratch) -> None:
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
            aim_again(block, seat_of(block, seat), targets, lane, aim_of(scratch, seat))


@passage
def end_test(block: Block, s: Settings, width: Width) -> None:
    """R1.1, R1.5, R1.4's phase 6: the clock goes on in whole milliseconds, and the episode may end."""
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        time = block[TIME + lane] + s.period
        finished = (block[SPAWNED + lane] >= s.target_budget) & (block[ALIVE + lane] == 0.0)
        block[TIME + lane] = time
        block[STEP + lane] = block[STEP + lane] + 1.0
        block[ENDED + lane] = select(finished, TERMINATED, select(time >= s.time_limit, TRUNCATED, RUNNING))


@phase
def some_ended(block: Block, lanes: int) -> bool:
    """Whether an episode is over in some lane."""
    most = RUNNING
    for lane in range(lanes):
        most = block[ENDED + lane] if block[ENDED + lane] > most else most
    return most != RUNNING


@passage
def put_back_ended(block: Block, s: Settings, lanes: int, kept: Block, rewards: Rewards) -> None:
    """R5.2: arenas that had ended are played with the others of their block, and then put back as they were kept:
    nothing moves after the end, and every request is MATCH_OVER.
    """
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
            for part in range(rewards.shape[2]):
                rewards[lane, seat, part] = 0.0
        for row in range(len(block) // LANES):
            block[row * LANES + lane] = kept[row * LANES + lane]


@passage
def play(
    block: Block,
    s: Settings,
    width: Width,
    lanes: int,
    tables: Tables,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    scratch: Scratch,
    docket: Docket,
    rewards: Rewards,
) -> None:
    """R1.4, but for the observations: one step of one block."""
    targets = targets_of(block, s)
    had_ended = some_ended(block, lanes)
    if had_ended:
        for i in range(len(block)):
            scratch.kept[i] = block[i]
    take_in(block, s, width, lanes, tables.controls, choices, commands, scratch)
    asked = scratch.rows[:LANES]
    clear_evidence(block, s, width, asked)
    for lane in range(lanes):
        if asked[lane] > 0.0:
            arbitrate(block, s, lane, targets, docket)
            commit(block, s, lane, targets, scratch)
    move(block, s, width, lanes, scratch.rows)
    spawn_through(block, targets, lanes, s)
    end_test(block, s, width)
    reward(block, s, width, lanes, scratch, rewards)
    if had_ended:
        put_back_ended(block, s, lanes, scratch.kept, rewards)


@entry
def run(
    width: Width,
    view_width: Width,
    memory: NDArray[np.float64],
    constants: NDArray[np.float64],
    numbers: NDArray[np.int64],
    workspace: NDArray[np.float64],
    narrow_workspace: NDArray[np.float32],
    keys: NDArray[np.int32],
    docket: Docket,
    resets: NDArray[np.uint64],
    playing: bool,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    observations: Observations,
    masks: Masks,
    rewards: Rewards,
    ends: NDArray[np.int8],
    last_observations: Observations,
    records: NDArray[np.float64],
) -> None:
    """Episodes begin where that is asked for, then one step of every arena (R1.4) where there is play, and then all
    observe.

    Args: `width` and `view_width`, how many lanes play and observe at a time; `memory` (blocks, rows * LANES);
    `constants`, the settings and 3 H start poses, or none for the fair circle (R2.6); `numbers`, see `tables_of`;
    scratch, `workspace`, `narrow_workspace` and `keys`, see `scratch_of`, and `docket`; `resets` (n, 2), rows of
    the batch and seeds; the actions `choices` (B, H) and `commands` (B, H, 2); the outputs `observations` (B, H, D),
    `masks` (B, H, K + 1), `rewards` (B, H, 1), or (B, H, 7) with R6.2's parts behind their sum, and `ends` (B,).
    Where `last_observations` (B, H, D) and `records` (B, H, RECORD_COLUMNS) have rows, an episode that ends fills
    its own, and the next one begins in its place (A.5).
    """
    s = read_settings(constants)
    tables = tables_of(numbers, s)
    scratch = scratch_of(workspace, narrow_workspace, keys, s)
    start_poses = constants[SETTINGS:]
    flat = observations.reshape(-1)
    for i in range(len(resets)):
        row = int(resets[i, 0])
        begin(memory[row // LANES], s, row % LANES, start_poses, resets[i, 1])
    for index in range(len(memory)):
        block = memory[index]
        first = index * LANES
        last = min(first + LANES, len(observations))
        lanes = last - first
        if playing:
            play(
                block,
                s,
                width,
                lanes,
                tables,
                choices[first:last],
                commands[first:last],
                scratch,
                docket,
                rewards[first:last],
            )
            for lane in range(lanes):
                ends[first + lane] = np.int8(block[ENDED + lane])
        renewing = playing and len(records) > 0 and some_ended(block, lanes)
        for last_view in range(1 if renewing else 0, -1, -1):  # one call of `observe` is compiled once
            observe(block, s, view_width, lanes, tables, scratch, flat, first, masks[first:last])
            if last_view > 0:
                begin_again(
                    block,
                    s,
                    lanes,
                    start_poses,
                    observations[first:last],
                    last_observations[first:last],
                    records[first:last],
                )

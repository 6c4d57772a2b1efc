"""Begin, end and records of episodes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.jit import Rows, outlined, phase
from catch_arena.core.math import PI, TAU, sincos, wrap
from catch_arena.core.memory import Sections
from catch_arena.core.prey import begin_prey, write_prey_records
from catch_arena.core.random import START, draw, fraction, next_seed, seed_of, stream
from catch_arena.core.rewards import Parts, Rewards
from catch_arena.core.spawner import spawn_next
from catch_arena.core.state import Settings, most_in, seat_of, targets_of
from catch_arena.core.vectors import LANES, Width, group, played_lanes, select


@outlined
def write_record(chunk: Rows, s: Settings, lane: int, teams: NDArray[np.int64], record: NDArray[np.float32]) -> None:
    """Write the hunters' records of one lane's episode as it is now; `record`, (N, figures), is the result."""
    score = rows.FINAL_TEAM_SCORE if s.has_teams else rows.FINAL_SCORE
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        record[seat, rows.FINAL_SCORE] = me[rows.SCORE + lane]
        record[seat, rows.FINAL_REWARD_SUM] = me[rows.REWARD_SUM + lane]
        record[seat, rows.FINAL_CONTESTS_WON] = me[rows.CONTESTS_WON + lane]
        for verdict in range(rows.FINAL_TEAM_SCORE - rows.FINAL_TALLIES):
            record[seat, rows.FINAL_TALLIES + verdict] = me[rows.TALLIES + (1 + verdict) * LANES + lane]
    if s.has_teams:
        for seat in range(s.hunters):
            first = teams[seat]  # first of its team, and the lowest: it comes before the others
            record[first, score] = record[seat, rows.FINAL_SCORE] + (record[first, score] if seat != first else 0.0)
        for seat in range(s.hunters):
            record[seat, score] = record[teams[seat], score]
    for seat in range(s.hunters):
        rank = 1.0
        for other in range(s.hunters):
            rank += 1.0 if teams[other] == other and record[other, score] > record[seat, score] else 0.0
        record[seat, rows.FINAL_RANK] = rank


@outlined
def begin(chunk: Rows, s: Settings, lane: int, start_poses: NDArray[np.float64], seed: np.uint64) -> None:
    """R2.6, R3.1, A.6: set one arena to the beginning of an episode."""
    for row in range(len(chunk) // LANES):
        chunk[row * LANES + lane] = 0.0
    chunk[rows.SEED_HIGH + lane] = float(seed >> np.uint64(32))
    chunk[rows.SEED_LOW + lane] = float(seed & np.uint64(0xFFFFFFFF))
    turn = TAU * fraction(draw(stream(seed, START), np.uint64(0)))
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        if len(start_poses) > 0:
            me[rows.X + lane] = start_poses[seat, 0]
            me[rows.Y + lane] = start_poses[seat, 1]
            me[rows.THETA + lane] = wrap(start_poses[seat, 2])
        elif s.hunters == 1:
            me[rows.X + lane] = s.side_m / 2.0
            me[rows.Y + lane] = s.side_m / 2.0
        else:
            angle = wrap(turn + TAU * seat / s.hunters)
            sine, cosine = sincos(angle)
            me[rows.X + lane] = s.side_m / 2.0 + s.start_radius_m * cosine
            me[rows.Y + lane] = s.side_m / 2.0 + s.start_radius_m * sine
            me[rows.THETA + lane] = wrap(angle + PI)
    targets = targets_of(chunk, s)
    for _ in range(s.initial_targets):
        spawn_next(chunk, s, lane, targets, seed, 0.0)
    if s.prey > 0:
        begin_prey(chunk, s, lane)


@phase
def end_test(chunk: Rows, s: Settings, width: Width) -> None:
    """R1.1, R1.5, R12.6, R1.4's phase 6: advance the clock by whole milliseconds, and end finished episodes."""
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        time = chunk[rows.TIME + lane] + s.period_ms
        finished = (chunk[rows.SPAWNED + lane] >= s.spawned_in_full) & (chunk[rows.ALIVE + lane] == 0.0)
        chunk[rows.TIME + lane] = time
        chunk[rows.STEP + lane] = chunk[rows.STEP + lane] + 1.0
        chunk[rows.ENDED + lane] = select(
            finished, rows.TERMINATED, select(time >= s.time_limit_ms, rows.TRUNCATED, rows.RUNNING)
        )


@phase
def any_ended(chunk: Rows, lanes: int) -> bool:
    """Return whether an episode is over in some lane."""
    return most_in(chunk[rows.ENDED :], lanes) != rows.RUNNING


@phase
def write_ends(chunk: Rows, lanes: int, ends: NDArray[np.int8]) -> None:
    """R1.5: write the state of each episode, RUNNING, TERMINATED or TRUNCATED, for callers outside the core."""
    for lane in range(lanes):
        ends[lane] = np.int8(chunk[rows.ENDED + lane])


@phase
def take_snapshot(chunk: Rows, snapshot: Rows) -> None:
    """Keep the chunk as it was before a step, for `restore_finished`."""
    for i in range(len(chunk)):
        snapshot[i] = chunk[i]


@phase
def restore_finished(chunk: Rows, s: Settings, lanes: int, sections: Sections, rewards: Rewards, parts: Parts) -> None:
    """R1.5: restore the arenas that had ended before this step, since nothing moves after the end. They were played
    with their chunk; only their answers stay, which are MATCH_OVER (R5.2).
    """
    for lane in range(lanes):
        if sections.snapshot[rows.ENDED + lane] == rows.RUNNING:
            continue
        for seat in range(s.hunters):
            now, then = seat_of(chunk, seat), seat_of(sections.snapshot, seat)
            for offset in rows.RULING:
                then[offset + lane] = now[offset + lane]
            rewards[lane, seat] = 0.0
            for column in range(parts.shape[2] if len(parts) > 0 else 0):
                parts[lane, seat, column] = 0.0
        for row in range(len(chunk) // LANES):
            chunk[row * LANES + lane] = sections.snapshot[row * LANES + lane]


@outlined
def keep_rows(seen: NDArray[Any], last_seen: NDArray[Any]) -> None:
    """Copy the observations or masks of one arena to those of its last ended episode."""
    for agent in range(seen.shape[0]):
        for column in range(seen.shape[1]):
            last_seen[agent, column] = seen[agent, column]


@phase
def begin_again(chunk: Rows, s: Settings, lanes: int, first_arena: int, sections: Sections) -> None:
    """A.5: keep the last observations and records of each episode that has just ended, and begin the next one."""
    for lane in range(lanes):
        if chunk[rows.ENDED + lane] == rows.RUNNING:
            continue
        arena = first_arena + lane
        keep_rows(sections.observations[arena], sections.final_observations[arena])
        keep_rows(sections.masks[arena], sections.final_masks[arena])
        sections.lengths[arena] = chunk[rows.STEP + lane]
        write_record(chunk, s, lane, sections.teams, sections.records[arena])
        if s.prey > 0:
            write_prey_records(chunk, s, lane, sections.records[arena])
        begin(chunk, s, lane, sections.start_poses, next_seed(seed_of(chunk, lane)))

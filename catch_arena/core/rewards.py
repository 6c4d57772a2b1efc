"""Rulebook chapter 6: the named parts of the reward, and their weighted sum."""

from collections import namedtuple
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows, state
from catch_arena.core.jit import Rows, outlined, phase, rule
from catch_arena.core.memory import Sections
from catch_arena.core.ranking import FAR, item_of, key_of
from catch_arena.core.state import ABSENT, PART_NAMES, Orders, Settings, item_at_rank, limits_of, seat_of
from catch_arena.core.vectors import LANES, Width, group, played_lanes, select, sqrt
from catch_arena.core.visibility import is_seen
from catch_arena.verdicts import Verdict

_LOST_CONTEST: Final = float(Verdict.LOST_CONTEST)
_GRANTED: Final = float(Verdict.GRANTED)

_named: Any = namedtuple  # for type checkers, which want to see the names  # noqa: PYI024
_PartRows: Final = _named("_PartRows", PART_NAMES)
_ROW_OF: Final = _PartRows(*range(LANES, (1 + len(PART_NAMES)) * LANES, LANES))
"""Offset of each part's row in the rows of amounts, which begin with that of the sum."""

Rewards = NDArray[np.float64]
"""Rewards of all agents, (lanes, N); this module writes those of the hunters."""
Parts = NDArray[np.float64]
"""R6.2: parts of the hunters' rewards, (lanes, H, parts), in the order of `state.PART_NAMES`; or empty."""


@rule
def measures_progress(s: Settings, sections: Sections) -> bool:
    """R6.2: return whether progress has a weight, or the parts are kept."""
    return s.progress_weight != 0.0 or len(sections.parts) > 0


@phase
def note_references(chunk: Rows, s: Settings, lanes: int, orders: Orders, targets: Rows, sections: Sections) -> None:
    """R6.2: note what parts of the reward compare with the next state, on S_t."""
    if measures_progress(s, sections):
        for seat in range(s.hunters):
            for lane in range(lanes):
                note_target(chunk, s, lane, seat, targets, item_at_rank(orders[seat], 0, lane), sections)


@outlined
def renew_references(chunk: Rows, s: Settings, lane: int, targets: Rows, sections: Sections) -> None:
    """R6.2: note again what parts compare, in one lane that targets have just left: of those that are still alive."""
    if measures_progress(s, sections):
        for seat in range(s.hunters):
            me, reach_um = seat_of(chunk, seat), limits_of(sections.limits, seat).reach_um
            nearest = FAR
            for slot in range(int(chunk[rows.ALIVE + lane])):
                at = slot * s.slot_size + lane
                dx = targets[rows.TARGET_X + at] - me[rows.X + lane]
                dy = targets[rows.TARGET_Y + at] - me[rows.Y + lane]
                key = key_of(dx, dy, slot)
                if key < nearest and is_seen(dx, dy, me[rows.SINE + lane], me[rows.COSINE + lane], reach_um, s):
                    nearest = key
            note_target(chunk, s, lane, seat, targets, item_of(nearest), sections)


@phase
def note_target(chunk: Rows, s: Settings, lane: int, seat: int, targets: Rows, slot: int, sections: Sections) -> None:
    """R6.2's progress: note the nearest target that a hunter sees, and its distance; the slot is ABSENT for none."""
    me, reference = seat_of(chunk, seat), sections.references[seat]
    there = slot != ABSENT
    at = select(there, slot, 0) * s.slot_size + lane
    x, y = targets[rows.TARGET_X + at], targets[rows.TARGET_Y + at]
    dx, dy = x - me[rows.X + lane], y - me[rows.Y + lane]
    reference[state.NEAREST_X + lane] = x
    reference[state.NEAREST_Y + lane] = y
    reference[state.NEAREST_DISTANCE + lane] = select(there, sqrt(dx * dx + dy * dy), float(rows.NOT_MEASURED))


@phase
def count_catches(chunk: Rows, s: Settings, width: Width, sections: Sections, catches: Rows) -> None:
    """R11.2: count the grants of this step, in total and for each team, under the seat that stands for the team."""
    teams, team_rows = sections.teams, sections.team_rows
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        total = 0.0
        for seat in range(s.hunters):
            granted = select(seat_of(chunk, seat)[rows.VERDICT + lane] == _GRANTED, 1.0, 0.0)
            total = total + granted
            if s.has_teams:
                at = teams[seat] * LANES
                if teams[seat] != seat:  # the first seat of its team comes first
                    granted = granted + team_rows[at + lane]
                team_rows[at + lane] = granted
        catches[lane] = total


@outlined
def share_rewards(chunk: Rows, s: Settings, width: Width, lanes: int, sections: Sections, rewards: Rewards) -> None:
    """R11.2: write each seat's mix of its own earnings, which are in the team rows, and the mean of its team."""
    teams, earned, row = sections.teams, sections.team_rows[s.hunters * LANES :], sections.scratch_rows
    for seat in range(s.hunters):
        me, leader = seat_of(chunk, seat), teams[seat]
        for first in range(0, played_lanes(width), len(width)):
            lane = group(first, width)
            total, members = earned[leader * LANES + lane], 1.0
            for mate in range(leader + 1, s.hunters):
                if teams[mate] == leader:
                    total = total + earned[mate * LANES + lane]
                    members += 1.0
            shared = (1.0 - s.team_share) * earned[seat * LANES + lane] + s.team_share * (total / members)
            row[lane] = select(me[rows.WITHDRAWN + lane] == 0.0, shared, 0.0)
            me[rows.REWARD_SUM + lane] = me[rows.REWARD_SUM + lane] + row[lane]
        for lane in range(lanes):
            rewards[lane, seat] = row[lane]


@phase
def reward(
    chunk: Rows,
    s: Settings,
    width: Width,
    lanes: int,
    sections: Sections,
    rewards: Rewards,
    parts: Parts,
) -> None:
    """R6.2: write the weighted sum of the parts, and the parts if they are kept."""
    catches = sections.scratch_rows[:LANES]
    amounts = sections.scratch_rows[LANES : (2 + len(PART_NAMES)) * LANES]  # the sum, and then the parts in their order
    parts_wanted, is_shared = len(parts) > 0, s.has_teams and s.team_share > 0.0
    count_catches(chunk, s, width, sections, catches)
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        reference = sections.references[seat]
        for first in range(0, played_lanes(width), len(width)):
            lane = group(first, width)
            counts = select(me[rows.WITHDRAWN + lane] == 0.0, 1.0, 0.0)
            verdict = me[rows.VERDICT + lane]
            granted = select(verdict == _GRANTED, 1.0, 0.0)
            of_team = granted
            if s.has_teams:
                of_team = sections.team_rows[sections.teams[seat] * LANES + lane]
            rival = counts * (catches[lane] - of_team)
            lost = select(verdict == _LOST_CONTEST, 1.0, 0.0)
            refused = (verdict > 0.0) & (verdict != _GRANTED) & (verdict != _LOST_CONTEST)
            rejected = select(refused, counts, 0.0)
            progress = 0.0
            if measures_progress(s, sections):
                dx = reference[state.NEAREST_X + lane] - me[rows.X + lane]
                dy = reference[state.NEAREST_Y + lane] - me[rows.Y + lane]
                before = reference[state.NEAREST_DISTANCE + lane]
                progress = select((before >= 0.0) & (counts > 0.0), before - sqrt(dx * dx + dy * dy), 0.0)
            elapsed = counts * s.period_s
            total = (
                s.catch_weight * granted
                + s.rival_catch_weight * rival
                + s.lost_contest_weight * lost
                + s.rejected_request_weight * rejected
                + s.progress_weight * progress
                + s.time_weight * elapsed
            )
            mate = 0.0
            if s.has_teams:
                mate = counts * (of_team - granted)
                total = total + s.mate_catch_weight * mate
                sections.team_rows[(s.hunters + seat) * LANES + lane] = total
            if not is_shared:
                me[rows.REWARD_SUM + lane] = me[rows.REWARD_SUM + lane] + total
            amounts[lane] = total
            if not parts_wanted:
                continue
            amounts[_ROW_OF.catch + lane] = granted
            amounts[_ROW_OF.rival_catch + lane] = rival
            amounts[_ROW_OF.lost_contest + lane] = lost
            amounts[_ROW_OF.rejected_request + lane] = rejected
            amounts[_ROW_OF.progress + lane] = progress
            amounts[_ROW_OF.time + lane] = elapsed
            amounts[_ROW_OF.mate_catch + lane] = mate
        for lane in range(lanes):
            rewards[lane, seat] = amounts[lane]
            for column in range(len(PART_NAMES) if parts_wanted else 0):
                parts[lane, seat, column] = amounts[(1 + column) * LANES + lane]
    if is_shared:
        share_rewards(chunk, s, width, lanes, sections, rewards)


@outlined
def write_team_scores(chunk: Rows, s: Settings, lanes: int, sections: Sections, scores: NDArray[np.float64]) -> None:
    """R11.1: write the sum of the scores of each team's hunters; `scores`, (lanes, teams), is the result."""
    for lane in range(lanes):
        for team in range(len(sections.team_seats)):
            scores[lane, team] = 0.0
            for seat in range(s.hunters):
                if sections.teams[seat] == sections.team_seats[team]:
                    scores[lane, team] += seat_of(chunk, seat)[rows.SCORE + lane]

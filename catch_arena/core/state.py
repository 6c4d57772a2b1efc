"""Settings of an arena as the core reads them, and views of a chunk's parts."""

from typing import Annotated, ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.jit import Rows, phase, rule
from catch_arena.core.vectors import LANES, long

STILL: Final = 0
WANDERING: Final = 1
FLEEING: Final = 2
MOTIONS: Final = {"still": STILL, "wander": WANDERING, "flee": FLEEING}
"""R3.8: numbers of the target motions."""

PART_NAMES: Final = ("catch", "rival_catch", "lost_contest", "rejected_request", "progress", "time", "mate_catch")
"""R6.2's parts of a hunter's reward, in the order in which they are written."""
PREY_PART_NAMES: Final = ("caught", "survived", "gained")
"""R12.5's parts of prey's reward, in the order in which they are written."""

# rows of a hunter's references, which its reward compares with the next state (R6.2)
NEAREST_X: Final = 0 * LANES  # position of the nearest target after the commit [m], 0 to the arena's side
NEAREST_Y: Final = 1 * LANES  # as NEAREST_X
NEAREST_DISTANCE: Final = 2 * LANES  # distance to it on S_t [m], from 0, or NOT_MEASURED
REFERENCE_ROWS: Final = 3

# rows of a prey's references (R12.5)
IN_PLAY: Final = 0 * LANES  # flag: it was not out on S_t; 0 or 1
HUNTER_DISTANCE: Final = 1 * LANES  # distance to the nearest hunter on S_t [m], from 0, or NOT_MEASURED
HUNTER_X: Final = 2 * LANES  # that hunter's position [m], 0 to the arena's side
HUNTER_Y: Final = 3 * LANES  # as HUNTER_X
PREY_REFERENCE_ROWS: Final = 4


class Settings(NamedTuple):
    """Config as the core reads it: scalars, each in the unit that its name ends in; flags are 0 or 1.

    Pass them as a parameter of their own, never within another tuple: the compiler leaves out branches by
    `PlainSettings.ZERO` only if a function reads a field of a parameter (`compiler._Substitute`).
    """

    hunters: int
    max_targets: int
    targets_seen: int
    hunters_seen: int
    policy: int
    partners_needed: int
    any_control: int
    target_budget: float
    spawned_in_full: float
    side_m: float
    kp_v: float
    ki_v: float
    kp_w: float
    ki_w: float
    period_ms: float
    period_s: float
    time_limit_ms: float
    spawn_period_ms: float
    spawn_low_m: float
    spawn_high_m: float
    spawn_last_m: float
    start_radius_m: float
    initial_targets: int
    slot_size: int
    targets_move: int
    target_motion: int
    target_speed_mps: float
    target_turn_rate_radps: float
    wander_period_ms: float
    alarm_um: float
    prey: int
    prey_min_speed_mps: float
    prey_returns_ms: float
    partial_view: int
    view_radius_um: float
    view_cosine: float
    view_noise_m: float
    dropout_rate: float
    kill_down_rate: float
    kill_refused_rate: float
    spawn_down_rate: float
    spawn_refused_rate: float
    catch_weight: float
    rival_catch_weight: float
    lost_contest_weight: float
    rejected_request_weight: float
    progress_weight: float
    time_weight: float
    has_teams: int
    team_share: float
    mate_catch_weight: float
    caught_weight: float
    survived_weight: float
    gained_weight: float


class PlainSettings(Settings):
    """Settings without options, for the compiler: see `Options`."""

    ZERO: ClassVar = (
        "any_control",
        "dropout_rate",
        "has_teams",
        "partners_needed",
        "partial_view",
        "prey",
        "target_motion",
        "targets_move",
        "view_noise_m",
    )
    """Fields that are 0; the compiler leaves out the branches for other values."""


Options = tuple[int, ...]
"""Type that decides for the compiler if code for rarely used settings is included: an empty tuple or not. The code for
all of them takes half as long again to compile.
"""
NO_OPTIONS: Final[Options] = ()
ALL_OPTIONS: Final[Options] = (0,)


def options_of(s: Settings) -> Options:
    """Return the options that the compiled code needs for these settings."""
    return ALL_OPTIONS if any(getattr(s, name) for name in PlainSettings.ZERO) else NO_OPTIONS


class SeatLimits(NamedTuple):
    """R2.5, R2.7, R5.3: limits of one hunter: speeds [m/s], a turn rate [rad/s], and a reach [micrometres].

    Each is annotated with the property of `ArenaConfig` that has the limits of all seats.
    """

    max_speed: Annotated[float, "max_speeds"]
    min_speed: Annotated[float, "min_speeds"]
    max_turn_rate: Annotated[float, "max_turn_rates"]
    reach_um: Annotated[float, "reaches_um"]


MOST: Final = 64
"""Greatest number of hunters, and of targets, in one arena: a key of `ranking` has room for no more."""
ABSENT: Final = MOST
"""Value in place of a slot or seat if nothing has the rank."""


class Regions(NamedTuple):
    """Offsets in a chunk at which the rows of each kind begin, one kind after the other, and at which the last ones
    end.
    """

    hunters: int
    targets: int
    prey: int
    end: int


@rule
def regions_of(s: Settings) -> Regions:
    """Return the offsets of a chunk's regions."""
    hunters = rows.ARENA_ROWS * LANES
    targets = hunters + s.hunters * rows.SEAT_SIZE
    prey = targets + s.max_targets * s.slot_size
    return Regions(hunters, targets, prey, prey + s.prey * rows.PREY_SIZE)


@phase
def limits_of(limits: NDArray[np.float64], seat: int) -> SeatLimits:
    """Return the limits of one hunter, from the section with those of all."""
    return SeatLimits(limits[seat, 0], limits[seat, 1], limits[seat, 2], limits[seat, 3])


@phase
def targets_of(chunk: Rows, s: Settings) -> Rows:
    """Return the target slots of a chunk: slot n begins at n * s.slot_size."""
    regions = regions_of(s)
    return chunk[regions.targets : regions.prey]


@phase
def most_in(row: Rows, lanes: int) -> float:
    """Return the greatest number in a row; none is negative."""
    most = 0.0
    for lane in range(lanes):
        most = row[lane] if row[lane] > most else most
    return most


@phase
def most_alive(chunk: Rows, lanes: int) -> int:
    """Return the greatest number of alive targets in a lane."""
    return int(most_in(chunk[rows.ALIVE :], lanes))


@phase
def body_of(targets: Rows, s: Settings, slot: int) -> Rows:
    """Return the body of the target in one slot; only for targets that move."""
    first = slot * s.slot_size + rows.BODY
    return targets[first : first + rows.BODY_ROWS * LANES]


@rule
def seat_at(seat: int) -> int:
    """Return the offset of the rows of one seat in a chunk."""
    return rows.ARENA_ROWS * LANES + seat * rows.SEAT_SIZE


@phase
def seat_of(chunk: Rows, seat: int) -> Rows:
    """Return one seat's rows of a chunk."""
    first = seat_at(seat)
    return chunk[first : first + rows.SEAT_SIZE]


@phase
def prey_of(chunk: Rows, s: Settings, index: int) -> Rows:
    """Return one prey's rows of a chunk."""
    first = regions_of(s).prey + index * rows.PREY_SIZE
    return chunk[first : first + rows.PREY_SIZE]


Order = NDArray[np.int8]
"""Slots or seats in the order in which one seat sees them: rows of LANES, one for each rank; ABSENT for none."""
Orders = NDArray[np.int8]
"""The order of each seat, (H, ranks * LANES)."""


@rule
def item_at_rank(order: Order, rank: int, lane: int) -> int:
    """Return the slot or seat at a rank; ABSENT for none. Ranks count from 0 here, and from 1 in actions, where 0 is
    hold (R4.1).
    """
    return long(order[rank * LANES + lane])


@phase
def targets_ranked(chunk: Rows, s: Settings, lane: int, order: Order) -> int:
    """R7.1, R7.5: return the number of targets that a seat sees; each of them has a rank."""
    count = min(int(chunk[rows.ALIVE + lane]), s.targets_seen)
    if s.partial_view:
        while count > 0 and item_at_rank(order, count - 1, lane) == ABSENT:
            count -= 1
    return count

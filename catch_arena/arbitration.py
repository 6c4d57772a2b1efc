"""The arbiter as a function: judge the requests of one step without an arena, by the same compiled rules that the
engine uses.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final, get_args

import numpy as np

from catch_arena.config import (
    ArbitrationPolicy,
    by_seat,
    checked_teams,
    micrometres,
    require_choice,
    require_flag,
    require_hunters_per_catch,
    require_integer,
    require_number,
)
from catch_arena.core import arbiter, rows
from catch_arena.core.compiling import ARBITER_S, announced
from catch_arena.errors import ActionError, ConfigError
from catch_arena.plain import plain_setting, whole_number
from catch_arena.seeding import checked_seed
from catch_arena.verdicts import Ruling

_LONGEST_NAME: Final = 255
_FARTHEST_M: Final = 1e6


def arbitrate(
    *,
    hunters: Sequence[tuple[float, float]],
    targets: Mapping[str, tuple[float, float]],
    requests: Sequence[tuple[int, object]],
    reach_m: float | Sequence[float] = 0.3,
    policy: ArbitrationPolicy = "nearest",
    seed: int = 0,
    step: int = 0,
    caught: Collection[str] = (),
    inactive: Collection[int] = (),
    kill_service_up: bool = True,
    kill_refused: Collection[str] = (),
    match_over: bool = False,
    teams: Sequence[Sequence[int]] | None = None,
    hunters_per_catch: int = 1,
) -> list[Ruling]:
    """Return the verdicts of chapter 5 on the requests of one step.

    Args:
        hunters: (x, y) [m] by seat.
        targets: (x, y) [m] of each alive target by name; their order numbers them from 1 for the lots of R5.5.
        requests: (seat, name) in any order; the name may be any object.
        reach_m: a target is within reach strictly below this distance (R5.3), for all or by seat (R2.7).
        policy: "nearest", "first_come" or "capstone" (R5.9).
        seed: a whole number in [0, 2^64), from which the lots are drawn.
        step: a whole number in [0, 2^53), from which the lots are drawn too.
        caught: names caught in earlier steps.
        inactive: seats that are withdrawn.
        kill_service_up: true if the simulator's kill service answers.
        kill_refused: names whose kill the simulator refuses.
        match_over: true if the episode has ended.
        teams: the seats of each team (R11.1), such as [(0, 1), (2, 3)]; None for no teams.
        hunters_per_catch: number of hunters of one team that a catch needs (R5.10); more than 1 requires teams.

    Returns:
        one Ruling for each request, in the order of the requests.

    Raises:
        ActionError: for a seat that does not exist or a position that is not two finite numbers.
        ConfigError: for any other invalid argument.
    """
    if not isinstance(targets, Mapping):
        raise ConfigError(f"targets must map names to places (x, y), got {targets!r}")
    given: dict[str, object] = {"hunters": hunters, "requests": requests, "inactive": inactive}
    named: dict[str, Collection[str]] = {"targets": targets, "caught": caught, "kill_refused": kill_refused}
    for field, values in (given | named).items():
        if isinstance(values, str) or not isinstance(values, Collection):
            raise ConfigError(f"{field} must be a collection, got {values!r}")
    for field, names in named.items():
        if wrong := [name for name in names if not isinstance(name, str)]:
            raise ConfigError(f"{field} must contain only strings, got {wrong[0]!r}")
    seats = len(hunters)
    places = [_checked_place(f"hunters[{seat}]", place) for seat, place in enumerate(hunters)]
    alive = {name: _checked_place(f"targets[{name!r}]", place) for name, place in targets.items()}
    gone, refused = set(caught), set(kill_refused)
    out = {_checked_seat("inactive", seat, seats) for seat in inactive}
    if both := sorted(gone & alive.keys()):
        raise ConfigError(
            f"caught must name targets that are no longer alive, got {both[0]!r}, which is in targets too"
        )
    reach = plain_setting(reach_m)
    for field, metres in by_seat("reach_m", reach, seats):
        require_number(field, metres, None, _FARTHEST_M)
    reaches_um = [max(1, micrometres(metres)) for metres in (reach if isinstance(reach, tuple) else (reach,) * seats)]
    require_choice("policy", policy, get_args(ArbitrationPolicy))
    groups = None if teams is None else checked_teams(plain_setting(teams), seats)
    require_hunters_per_catch(hunters_per_catch, groups, policy)
    team_of = {seat: team for team, members in enumerate(groups or ()) for seat in members}
    number_of_step = require_integer("step", step, 0, 2**53 - 1)
    numbers = {name: number for number, name in enumerate(alive, start=1)}
    table = np.zeros((len(requests), arbiter.REQUEST_COLUMNS), dtype=np.int64)
    for row, request in zip(table, requests, strict=True):
        try:
            seat, name = request
        except (TypeError, ValueError):
            raise ActionError(f"a request must be (seat, name), got {request!r}") from None
        seat = _checked_seat("the seat of a request", seat, seats)
        row[arbiter.REQUEST_SEAT] = seat
        row[arbiter.REQUEST_REACH] = reaches_um[seat]
        row[arbiter.REQUEST_INACTIVE] = seat in out
        row[arbiter.REQUEST_TEAM] = team_of.get(seat, 0)
        row[arbiter.REQUEST_DISTANCE] = rows.NOT_MEASURED
        row[arbiter.REQUEST_TARGET] = requested_target(name, numbers, gone)
        if isinstance(name, str) and row[arbiter.REQUEST_TARGET] > 0:
            (x, y), (target_x, target_y) = places[seat], alive[name]
            row[arbiter.REQUEST_NUMBER] = numbers[name]
            row[arbiter.REQUEST_DISTANCE] = arbiter.measure_um(target_x - x, target_y - y)
            row[arbiter.REQUEST_KILL_REFUSED] = name in refused
    with announced("the arbiter", ARBITER_S):
        arbiter.judge_alone(
            table,
            arbiter.POLICIES[policy],
            np.uint64(checked_seed(seed)),
            number_of_step,
            require_flag("match_over", match_over),
            require_flag("kill_service_up", kill_service_up),
            int(hunters_per_catch) - 1,
        )
    return rulings_of(table, [name for _, name in requests], number_of_step)


def requested_target(name: object, alive: Mapping[str, int], gone: Collection[str]) -> int:
    """Return a name's entry in a request table: the number or slot of the alive target, or a code for none (R5.2)."""
    if not isinstance(name, str) or len(name) > _LONGEST_NAME:
        return rows.MALFORMED_REQUEST
    if name in alive:
        return alive[name]
    return rows.ALREADY_GONE if name in gone else rows.NEVER_SPAWNED


def rulings_of(table: arbiter.RequestTable, names: Sequence[object], step: int) -> list[Ruling]:
    """Return a judged request table as rulings; `names` are the requested names, row by row."""
    return [
        Ruling.of_numbers(
            row[arbiter.REQUEST_VERDICT],
            row[arbiter.REQUEST_SEAT],
            name,
            row[arbiter.REQUEST_DISTANCE],
            row[arbiter.REQUEST_WINNER],
            step,
        )
        for row, name in zip(table.tolist(), names, strict=True)
    ]


def _checked_place(field: str, place: Any) -> tuple[float, float]:
    try:
        if isinstance(place, str | bytes):
            raise TypeError
        x, y = (float(number) for number in place)
    except (TypeError, ValueError):
        raise ActionError(f"{field} must be two numbers (x, y), got {place!r}") from None
    if not (math.isfinite(x) and math.isfinite(y) and max(abs(x), abs(y)) <= _FARTHEST_M):
        raise ActionError(f"{field} must be two finite numbers of at most {_FARTHEST_M:g} m, got {place!r}")
    return x, y


def _checked_seat(field: str, seat: object, seats: int) -> int:
    number = whole_number(seat)
    if number is None or not 0 <= number < seats:
        allowed = f"a seat from 0 to {seats - 1}" if seats else "a seat, but hunters is empty"
        raise ActionError(f"{field} must be {allowed}, got {seat!r}")
    return number

"""A decision for one hunter, compiled for many.

An arena's step takes 0.2 microseconds per hunter, and a decision in Python takes a hundred. So Numba compiles the
function that decides, with all functions that it calls.
"""

import hashlib
import math
from collections.abc import Callable
from functools import cache
from types import FunctionType, ModuleType
from typing import Any, Final, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.core.jit import entry, phase, rule
from catch_arena.core.math import atan2
from catch_arena.core.modes import INTERPRETED
from catch_arena.layout import MovingTargetFeatures, SelfFeatures, TeamRivalFeatures, groups
from catch_arena.policy import Limits, View

Decide = Callable[[Any], Any]
"""Function from a view of one hunter to its action."""


_NUMBERS: Final = [name for name, kind in get_type_hints(Limits).items() if kind in (int, float, bool)]
_make: Any = NamedTuple  # for type checkers, which want to see the fields
_Limits: Any = _make("_Limits", [(name, float) for name in _NUMBERS])
_FIELDS: Final = (
    *("x", "y", "heading_cos", "heading_sin", "linear_velocity", "angular_velocity", "time_left", "score"),
    *("distance_integral", "bearing_integral", "targets", "rivals", "limits"),
)
_Seen: Any = _make("_Seen", [(name, Any) for name in _FIELDS])
"""Replacement for a `View` in compiled code: the hunter's own numbers, arrays of records, and the limits."""
_OWN: Final = SelfFeatures(*range(len(SelfFeatures._fields)))
_PRESENT: Final = MovingTargetFeatures._fields.index("present")  # and of rivals
_TARGET, _RIVAL = (np.dtype([(name, float) for name in of._fields]) for of in (MovingTargetFeatures, TeamRivalFeatures))
_STANDING: Final = [float(name == "heading_cos") for name in MovingTargetFeatures._fields]


def ranks_for_each(choose: Decide, view: BatchView) -> NDArray[np.int64]:
    """Return the ranks that N hunters chase, (N,), as one function chooses for each; see `commands_for_each`."""
    return _actions(choose, _write_rank, view, np.empty(len(view.observations), np.int64))


def commands_for_each(decide: Decide, view: BatchView) -> NDArray[np.float64]:
    """Return the speeds and turn rates of N hunters, (N, 2), as one function decides for each.

    The function takes a `View` and returns an action. It reads the hunter's own numbers, the fields of `targets` and
    `rivals`, and the numbers of `limits`, but no properties and methods. It calls `math` and functions of this kind,
    and makes no lists.
    """
    return _actions(decide, _write_command, view, np.empty((len(view.observations), 2)))


def _actions(decide: Decide, write: Any, view: BatchView, actions: NDArray[Any]) -> NDArray[Any]:
    if INTERPRETED:
        for row, observation in enumerate(view.observations):
            actions[row] = decide(View(observation.tolist(), (), view.limits))
        return actions
    _, seen_targets, seen_rivals = groups(view.limits)
    limits = _Limits(*(getattr(view.limits, name) for name in _NUMBERS))
    shape = len(seen_targets.table._fields), seen_rivals.first, len(seen_rivals.table._fields), limits
    targets = np.array([_STANDING] * view.limits.targets_seen, np.float64)
    rivals = np.zeros((view.limits.hunters_seen, len(TeamRivalFeatures._fields)))
    records = targets.view(_TARGET)[:, 0], rivals.view(_RIVAL)[:, 0]
    seen = np.ascontiguousarray(view.observations, np.float32)
    _compiled(decide, write)(seen, shape, targets, rivals, *records, actions)
    return actions


@rule
def _look(seen: Any, row: int, first: int, columns: int, table: Any) -> int:
    """Copy the targets or rivals that one hunter sees into `table`, and return their number."""
    for place in range(len(table)):
        at = first + place * columns
        if seen[row, at + _PRESENT] == 0.0:
            return place
        for column in range(columns):
            table[place, column] = seen[row, at + column]
    return len(table)


_decide: Any = None
_write: Any = None
"""Placeholders in `_act_all`, which `_compiled` replaces by functions."""


def _act_all(
    seen: Any, shape: Any, targets: Any, rivals: Any, target_records: Any, rival_records: Any, actions: Any
) -> None:
    """Write the actions of all hunters. The arrays of records share the memory of `targets` and `rivals`.

    `shape`: a target's number of columns, the first column of rivals, a rival's number of columns, and the limits.
    """
    target_columns, first_rival, rival_columns, limits = shape
    for row in range(len(seen)):
        target_count = _look(seen, row, len(_OWN), target_columns, targets)
        rival_count = _look(seen, row, first_rival, rival_columns, rivals)
        view = _Seen(
            np.float64(seen[row, _OWN.x]),
            np.float64(seen[row, _OWN.y]),
            np.float64(seen[row, _OWN.heading_cos]),
            np.float64(seen[row, _OWN.heading_sin]),
            np.float64(seen[row, _OWN.linear_velocity]),
            np.float64(seen[row, _OWN.angular_velocity]),
            np.float64(seen[row, _OWN.time_left]),
            np.float64(seen[row, _OWN.score]),
            np.float64(seen[row, _OWN.distance_integral]),
            np.float64(seen[row, _OWN.bearing_integral]),
            target_records[:target_count],
            rival_records[:rival_count],
            limits,
        )
        _write(actions, row, _decide(view))


@phase
def _write_rank(actions: Any, row: int, rank: int) -> None:
    actions[row] = rank


@phase
def _write_command(actions: Any, row: int, command: tuple[float, float]) -> None:
    actions[row, 0], actions[row, 1] = command


@rule
def _hypot(x: float, y: float) -> float:
    return math.sqrt(x * x + y * y)


_MATH: Final = ModuleType("math")
_MATH.__dict__.update(vars(math), hypot=_hypot, atan2=atan2)  # the C library's functions take three times as long


@cache
def _compiled(decide: Decide, write: Any) -> Any:
    """Compile `_act_all` for one function. Its name has a digest of all that it is made of: the cache sees one file."""
    made_of = hashlib.blake2b(repr(_NUMBERS).encode(), digest_size=8)
    space = globals() | {"_decide": _part(decide, made_of), "_write": write}
    name = f"{decide.__module__}.{decide.__name__}-{made_of.hexdigest()}"
    entry_point = FunctionType(_act_all.__code__, space, name)
    entry_point.__qualname__ = name
    return entry(entry_point)


def _part(function: Any, made_of: Any) -> Any:
    """Copy a function for the compiler, with all that it calls, since the function itself stays plain Python."""
    code = function.__code__
    space: dict[str, Any] = {"__name__": __name__}
    made_of.update(repr((code.co_code, code.co_consts, code.co_names, function.__defaults__)).encode())
    for name in code.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, FunctionType):
            space[name] = _part(value, made_of)
        elif name in function.__globals__:
            space[name] = _MATH if value is math else value
            made_of.update(repr(value).encode())
    return rule(FunctionType(code, space, function.__name__, function.__defaults__))

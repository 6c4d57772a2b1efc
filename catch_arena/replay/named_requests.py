"""Rulebook R8.4: requests by name, in addition to the rank in an action.

A rank stands for one target in view. A ROS node may also ask for a target that was caught or never existed, or twice
in a step. Such requests do not change the arena, but each got an answer. A replay keeps them in their order, and the
arbiter judges them again.
"""

from bisect import bisect_left
from collections.abc import Collection, Sequence
from io import BytesIO
from typing import Annotated, Final, NamedTuple

import numpy as np
from msgspec import Meta

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.core.random import kill_service_down
from catch_arena.errors import ReplayError
from catch_arena.replay.codec import NUMBER, pack_columns, pack_json, read_columns, read_json, read_number
from catch_arena.replay.states import USED_UP, QuantisedState, parts_of
from catch_arena.text import printable
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

MOST_REQUESTS: Final = 1 << 16
"""Largest number of named requests in a match, shared equally by the hunters; a node can send thousands per second."""
MOST_CHARACTERS: Final = 1 << 20
"""Largest number of characters in the names of all named requests, shared equally by the hunters."""
_LONGEST_NAME: Final = 256
"""Number of characters kept of a name, one more than R5.2 allows: a longer name stays too long."""
_LONGEST_SHOWN: Final = 60
_LONGEST_TABLE: Final = 1 << 24
_FOR_A_RANK: Final = frozenset(
    {Verdict.GRANTED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED, Verdict.WAITING_FOR_PARTNER}
)
"""Verdicts on targets in reach. Those are always in view (R7.5), so they have a rank."""


class NamedRequest(NamedTuple):
    """One request without a rank in the action."""

    step: int
    """Number of steps played before the request."""
    seat: int
    name: str | None
    """Requested name, at most 256 characters; None if it was no string."""


class RequestBudget:
    """Limit on the named requests of a replay: each hunter has an equal share of a file's capacity.

    Args:
        hunters: the number of hunters that share it.
    """

    def __init__(self, hunters: int) -> None:
        self._requests = [MOST_REQUESTS // hunters] * hunters
        self._characters = [MOST_CHARACTERS // hunters] * hunters
        self.left_out = 0
        """Number of requests that were not kept, since the hunter's share was used up."""

    def admit(self, step: int, seat: int, name: object) -> NamedRequest | None:
        """Return the request to store, or None if the hunter's share is used up."""
        kept = name[:_LONGEST_NAME] if isinstance(name, str) else None
        self._requests[seat] -= 1
        self._characters[seat] -= len(kept or "")
        if min(self._requests[seat], self._characters[seat]) < 0:
            self.left_out += 1
            return None
        return NamedRequest(step, seat, kept)


def requests_of_step(requests: Sequence[NamedRequest], step: int) -> Sequence[NamedRequest]:
    """Return the requests of one step, in their order."""
    first, end = (bisect_left(requests, bound, key=lambda request: request.step) for bound in (step, step + 1))
    return requests[first:end]


def judge_again(
    config: ArenaConfig,
    seed: int,
    requests: Sequence[NamedRequest],
    caught: Collection[str],
    before: World,
    after: World,
) -> list[Ruling]:
    """Return the rulings on the requests of one step.

    Args:
        config: the arena's settings.
        seed: the match's seed.
        requests: the named requests of the step.
        caught: the requested names of targets that were caught earlier.
        before: the state on which the requests are judged (R5.1).
        after: the state after the step; its rulings are on the requests by rank, which came first.

    Raises:
        ReplayError: for a request that could have been granted: it would have a rank, and would have changed the
            state.
    """
    ranked = [(ruling.hunter, ruling.target) for ruling in after.rulings]
    with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
        kill_service_up = not kill_service_down(np.uint64(seed), before.step, config.faults.kill_down)
    rulings = arbitrate(
        hunters=[(hunter.x, hunter.y) for hunter in before.hunters],
        targets={target.name: (target.x, target.y) for target in before.targets},
        requests=[*ranked, *((request.seat, request.name) for request in requests)],
        reach_m=config.reaches,
        policy=config.policy,
        seed=seed,
        step=before.step,
        caught=caught,
        inactive=[seat for seat, hunter in enumerate(after.hunters) if hunter.withdrawn],
        kill_service_up=kill_service_up,
        teams=config.teams,
        hunters_per_catch=config.hunters_per_catch,
    )[len(ranked) :]
    for ruling in rulings:
        if ruling.verdict in _FOR_A_RANK:
            raise ReplayError(
                f"step {before.step + 1}: hunter_{ruling.hunter} cannot have asked for "
                f"{describe_name(str(ruling.target))} by name alone: it was in reach, so the arena would have answered"
            )
    return rulings


def describe_name(name: str | None) -> str:
    """Return a requested name in quotes, shortened and printable; a phrase for None."""
    if name is None:
        return "a name that is not a string"
    short = name if len(name) <= _LONGEST_SHOWN else f"{name[:_LONGEST_SHOWN]}..."
    return f'"{printable(short)}"'


def pack_requests(requests: Sequence[NamedRequest]) -> bytes:
    """Return a table of the names, each once, and three columns: the number of steps since the request before, the
    seat, and the name's index in the table.
    """
    names = list(dict.fromkeys(request.name for request in requests))
    places = {name: place for place, name in enumerate(names)}
    numbers = np.array([(request.step, request.seat, places[request.name]) for request in requests], dtype=np.int64)
    numbers[:, 0] = np.diff(numbers[:, 0], prepend=0)
    return pack_json(names) + NUMBER.pack(len(requests)) + pack_columns(numbers.T)


def read_requests(body: BytesIO, config: ArenaConfig) -> list[NamedRequest]:
    """Return the requests that `pack_requests` wrote.

    Raises:
        ReplayError: for too many requests, or those of hunters that cannot make any.
        LookupError: for a name that is not in the table.
        ValueError: for other bytes.
    """
    names = read_json(body, _LONGEST_TABLE, list[Annotated[str, Meta(max_length=_LONGEST_NAME)] | None])
    count = read_number(body)
    if count > MOST_REQUESTS:
        raise ReplayError(f"contains {count} requests by name, but must contain at most {MOST_REQUESTS}")
    later, seats, places = read_columns(body, 3, count).T
    if not np.isin(seats, [seat for seat, control in enumerate(config.controls) if control == "full"]).all():
        raise ReplayError("contains requests by name that no hunter could have made")
    steps = np.cumsum(later).tolist()
    return [
        NamedRequest(step, seat, names[place])
        for step, seat, place in zip(steps, seats.tolist(), places.tolist(), strict=True)
    ]


def has_appeared(name: str, states: Sequence[QuantisedState], config: ArenaConfig) -> bool:
    """R3.4: return whether a target of this name is in one of the states; refused spawns use up numbers, too."""
    digits = name.removeprefix(config.name_prefix)
    if not digits.isdecimal() or config.target_name(int(digits)) != name:
        return False
    first = bisect_left(states, int(digits), key=lambda state: int(state[USED_UP]))
    return first < len(states) and int(digits) in parts_of(states[first], config).targets[:, 0]

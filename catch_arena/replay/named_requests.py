"""Rulebook R8.4: requests by name, in addition to the rank in an action.

A rank stands for one target in view. A ROS node may also ask for a target that was caught or never existed, or twice
in a step. Such requests do not change the arena, but each got an answer. A replay keeps them in their order, and the
arbiter judges them again.
"""

from bisect import bisect_left
from collections.abc import Sequence
from io import BytesIO
from typing import Annotated, Final, NamedTuple

import numpy as np
from msgspec import Meta

from catch_arena.config import ArenaConfig
from catch_arena.errors import ReplayError
from catch_arena.replay.codec import NUMBER, pack_columns, pack_json, read_columns, read_json, read_number
from catch_arena.text import printable

MOST_REQUESTS: Final = 1 << 16
"""Largest number of named requests in a file."""
_MOST_CHARACTERS: Final = 1 << 20
"""Room for the named requests of a match, shared equally by the hunters; a node can send thousands per second."""
_CHARACTERS_PER_REQUEST: Final = _MOST_CHARACTERS // MOST_REQUESTS
"""Room that each request takes in addition to its name."""
_LONGEST_NAME: Final = 256
"""Number of characters kept of a name, one more than R5.2 allows: a longer name stays too long."""


class NamedRequest(NamedTuple):
    """One request without a rank in the action."""

    step: int
    """Number of steps played before the request."""
    seat: int
    name: str | None
    """Requested name, at most 256 characters; None if it was no string."""


class RequestBudget:
    """Limit on the named requests of a replay: each hunter has an equal share of a file's capacity."""

    def __init__(self, hunters: int) -> None:
        self._room = [_MOST_CHARACTERS // hunters] * hunters
        self.left_out = 0
        """Number of requests that were not kept, since the hunter's share was used up."""

    def admit(self, step: int, seat: int, name: object) -> NamedRequest | None:
        """Return the request to store, or None if the hunter's share is used up."""
        kept = name[:_LONGEST_NAME] if isinstance(name, str) else None
        self._room[seat] -= _CHARACTERS_PER_REQUEST + len(kept or "")
        if self._room[seat] < 0:
            self.left_out += 1
            return None
        return NamedRequest(step, seat, kept)


def requests_of_step(requests: Sequence[NamedRequest], step: int) -> Sequence[NamedRequest]:
    """Return the requests of one step, in their order."""
    first, end = (bisect_left(requests, bound, key=lambda request: request.step) for bound in (step, step + 1))
    return requests[first:end]


def describe_name(name: str | None) -> str:
    """Return a requested name in quotes, shortened and printable; a phrase for None."""
    if name is None:
        return "a name that is not a string"
    short = name if len(name) <= 60 else f"{name[:60]}..."
    return f'"{printable(short)}"'


def pack_requests(requests: Sequence[NamedRequest]) -> bytes:
    """Return a table of the names, each once, and three columns: the number of steps since the request before, the
    seat, and the name's index in the table.
    """
    names = list(dict.fromkeys(request.name for request in requests))
    places = {name: place for place, name in enumerate(names)}
    rows = [(request.step, request.seat, places[request.name]) for request in requests]
    numbers = np.array(rows, dtype=np.int64).reshape(-1, 3)
    numbers[:, 0] = np.diff(numbers[:, 0], prepend=0)
    return pack_json(names) + NUMBER.pack(len(requests)) + pack_columns(numbers.T)


def read_requests(body: BytesIO, config: ArenaConfig) -> list[NamedRequest]:
    """Return the requests that `pack_requests` wrote; raise ReplayError if no match of this config can have them."""
    names = read_json(body, 1 << 24, list[Annotated[str, Meta(max_length=_LONGEST_NAME)] | None])
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

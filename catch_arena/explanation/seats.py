"""What the hunters of a match are called, and who is meant."""

from collections.abc import Sequence

from catch_arena.errors import ConfigError, suggest
from catch_arena.replay import Replay


def labels(names: Sequence[str]) -> tuple[str, ...]:
    """The agents' names by seat; a name that occurs twice comes with its seat."""
    return tuple(f"{name} (hunter_{seat})" if names.count(name) > 1 else name for seat, name in enumerate(names))


def how_it_left(replay: Replay, seat: int) -> str:
    """Of a hunter that has left: it was "withdrawn" (R1.6), which a replay lists, or "dropped out" (R1.7)."""
    return "withdrawn" if any(gone == seat for _, gone in replay.withdrawals) else "dropped out"


def find_seat(replay: Replay, hunter: int | str) -> int:
    """The seat that is meant by a seat's number, by `hunter_{seat}` or by an agent's name.

    Raises:
        ConfigError: for an argument that cannot be.
    """
    seats = replay.config.hunter_names
    numbers = [str(seat) for seat in range(len(seats))]
    if str(hunter) in numbers:
        return numbers.index(str(hunter))
    if isinstance(hunter, int) or hunter.isdecimal():
        raise ConfigError(f"hunter must be a seat from 0 to {len(seats) - 1}, got {hunter}")
    named = [seat for seat, name in enumerate(replay.names) if name == hunter]
    if len(named) > 1:
        raise ConfigError(f"hunter must be one of the seats {', '.join(map(str, named))}: all are called {hunter!r}")
    if named:
        return named[0]
    if hunter in seats:
        return seats.index(hunter)
    raise ConfigError(f"unknown hunter {hunter!r}: {suggest(hunter, {*replay.names, *seats})}")

"""What the hunters of a match are called, and who is meant."""

from collections.abc import Sequence

from catch_arena.errors import ConfigError, suggest
from catch_arena.replay import Replay


def labels(names: Sequence[str], kind: str = "hunter") -> tuple[str, ...]:
    """The agents' names by seat; a name that occurs twice comes with its seat. Of prey likewise, by index."""
    return tuple(f"{name} ({kind}_{seat})" if names.count(name) > 1 else name for seat, name in enumerate(names))


def prey_labels(replay: Replay) -> tuple[str, ...]:
    """The prey's agents by index, each with what PettingZoo calls it."""
    agents = zip(replay.prey_names, replay.config.prey_names, strict=True)
    return tuple(name if name == agent else f"{name} ({agent})" for name, agent in agents)


def team_label(replay: Replay, seats: Sequence[int]) -> str:
    """A team: its only agent, with its seats if that plays in other teams too; or all its members."""
    names = [replay.hunter_names[seat] for seat in seats]
    if len(set(names)) > 1:
        return " + ".join(labels(replay.hunter_names)[seat] for seat in seats)
    alone = replay.hunter_names.count(names[0]) == len(seats)
    return names[0] if alone else f"{names[0]} ({', '.join(replay.config.hunter_names[seat] for seat in seats)})"


def with_seat(name: str, seat: int) -> str:
    """An agent's label with its seat: a copy called nearest#2 may sit anywhere."""
    own = f"hunter_{seat}"
    return name if name == own or name.endswith(f"({own})") else f"{name} ({own})"


def how_it_left(replay: Replay, seat: int) -> str:
    """Of a hunter that has left: it was "withdrawn" (R1.6), which a replay lists, or "dropped out" (R1.7)."""
    return "withdrawn" if any(gone == seat for _, gone in replay.withdrawals) else "dropped out"


def find_seat(replay: Replay, hunter: int | str) -> int:
    """The seat that is meant by a seat's number, by `hunter_{seat}` or by an agent's name.

    Raises:
        ConfigError: for a hunter that the match does not have, and a name that several have.
    """
    seats = replay.config.hunter_names
    numbers = [str(seat) for seat in range(len(seats))]
    if str(hunter) in numbers:
        return numbers.index(str(hunter))
    if isinstance(hunter, int) or hunter.isdecimal():
        raise ConfigError(f"hunter must be a seat from 0 to {len(seats) - 1}, got {hunter}")
    named = [seat for seat, name in enumerate(replay.hunter_names) if name == hunter]
    if len(named) > 1:
        raise ConfigError(f"hunter must be one of the seats {', '.join(map(str, named))}: all are called {hunter!r}")
    if named:
        return named[0]
    if hunter in seats:
        return seats.index(hunter)
    raise ConfigError(f"unknown hunter {hunter!r}: {suggest(hunter, {*replay.hunter_names, *seats})}")

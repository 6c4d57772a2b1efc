"""Labels of the hunters, prey and teams of a match, and their selection by name."""

from collections.abc import Sequence
from typing import NamedTuple

from catch_arena.errors import ConfigError, require_type, suggest
from catch_arena.replay import Replay


def labels(names: Sequence[str]) -> tuple[str, ...]:
    """Return unique labels of hunters, by seat; a name that occurs twice gets its seat."""
    return tuple(f"{name} (hunter_{seat})" if names.count(name) > 1 else name for seat, name in enumerate(names))


def prey_labels(replay: Replay) -> tuple[str, ...]:
    """Return the labels of the prey by index: the agent's name with its name in PettingZoo's interface."""
    agents = zip(replay.prey_names, replay.config.prey_names, strict=True)
    return tuple(name if name == agent else f"{name} ({agent})" for name, agent in agents)


def team_label(replay: Replay, seats: Sequence[int]) -> str:
    """Return a team's label: its only agent, with the seats if other teams have that agent too, or all members."""
    names = [replay.hunter_names[seat] for seat in seats]
    if len(set(names)) > 1:
        return " + ".join(labels(replay.hunter_names)[seat] for seat in seats)
    alone = replay.hunter_names.count(names[0]) == len(seats)
    return names[0] if alone else f"{names[0]} ({', '.join(replay.config.hunter_names[seat] for seat in seats)})"


def with_seat(name: str, seat: int) -> str:
    """Return an agent's label with its seat, since a name such as nearest#2 does not give the seat."""
    own = f"hunter_{seat}"
    return name if name == own or name.endswith(f"({own})") else f"{name} ({own})"


def exit_cause(replay: Replay, seat: int) -> str:
    """Return the reason why a hunter left: "withdrawn" (R1.6), which a replay lists, or "dropped out" (R1.7)."""
    return "withdrawn" if any(gone == seat for _, gone in replay.withdrawals) else "dropped out"


class Subjects(NamedTuple):
    """Hunters and prey that an explanation is about."""

    seats: tuple[int, ...]
    prey: tuple[int, ...]
    """Indices of the prey."""


def find_subjects(replay: Replay, name: int | str | None) -> Subjects:
    """Return the hunters and prey that a name means; all of them for None.

    Args:
        replay: the recorded match.
        name: a seat's number, `hunter_{seat}`, `prey_{index}`, or the name of an agent or a team; a name selects all
            that have it.

    Raises:
        ConfigError: for a seat or a name that the match does not have.
    """
    require_type("replay", replay, Replay, "Replay.load(path)")
    config = replay.config
    seats = tuple(range(config.hunters))
    if name is None:
        return Subjects(seats, tuple(range(config.prey)))
    if str(name) in map(str, seats):
        return Subjects((int(name),), ())
    if not isinstance(name, str) or name.isdecimal():
        raise ConfigError(f"hunter must be a seat from 0 to {seats[-1]}, got {name!r}")
    teams = {team_label(replay, members): members for members in config.teams or ()}
    if name in teams:
        return Subjects(teams[name], ())
    # agents' names come first, since an agent may be called hunter_1 in another seat
    for hunters, prey in (replay.hunter_names, replay.prey_names), (config.hunter_names, config.prey_names):
        found = Subjects(_seats_named(hunters, name), _seats_named(prey, name))
        if any(found):
            return found
    known = {*replay.hunter_names, *replay.prey_names, *config.hunter_names, *config.prey_names, *teams}
    raise ConfigError(f"unknown hunter {name!r}: {suggest(name, known)}")


def _seats_named(names: Sequence[str], wanted: str) -> tuple[int, ...]:
    return tuple(index for index, name in enumerate(names) if name == wanted)


def find_seat(replay: Replay, hunter: int | str) -> int:
    """Return the only seat that a name means; names are as in `find_subjects`.

    Raises:
        ConfigError: for a hunter that the match does not have, for prey, and for a name that several hunters have.
    """
    seats, _ = find_subjects(replay, hunter)
    if not seats:
        raise ConfigError(f"hunter must be a hunter, since prey has no view to draw, got {hunter!r}")
    if len(seats) > 1:
        raise ConfigError(
            f"hunter must be one of the seats {', '.join(map(str, seats))}: {hunter!r} is the name of all of them"
        )
    return seats[0]

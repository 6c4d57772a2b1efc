"""What the hunters of a match are called, and who is meant."""

from collections.abc import Sequence
from typing import NamedTuple

from catch_arena.errors import ConfigError, require_type, suggest
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


class Subjects(NamedTuple):
    """Whom an explanation is about."""

    seats: tuple[int, ...]
    prey: tuple[int, ...]
    """By index."""


def find_subjects(replay: Replay, who: int | str | None) -> Subjects:
    """Everybody who is meant by a name, or all where it is None.

    Args:
        replay: the recorded match.
        who: a seat's number, `hunter_{seat}`, `prey_{index}`, or the name of an agent or a team: all that are called
            so.

    Raises:
        ConfigError: for whom the match does not have.
    """
    require_type("replay", replay, Replay, "Replay.load(path)")
    config = replay.config
    seats = tuple(range(config.hunters))
    if who is None:
        return Subjects(seats, tuple(range(config.prey)))
    if str(who) in map(str, seats):
        return Subjects((int(who),), ())
    if not isinstance(who, str) or who.isdecimal():
        raise ConfigError(f"hunter must be a seat from 0 to {seats[-1]}, got {who!r}")
    teams = {team_label(replay, members): members for members in config.teams or ()}
    if who in teams:
        return Subjects(teams[who], ())
    # an agent may have been given a name such as hunter_1 in another seat
    for hunters, prey in (replay.hunter_names, replay.prey_names), (config.hunter_names, config.prey_names):
        found = Subjects(_called(hunters, who), _called(prey, who))
        if any(found):
            return found
    known = {*replay.hunter_names, *replay.prey_names, *config.hunter_names, *config.prey_names, *teams}
    raise ConfigError(f"unknown hunter {who!r}: {suggest(who, known)}")


def _called(names: Sequence[str], who: str) -> tuple[int, ...]:
    return tuple(index for index, name in enumerate(names) if name == who)


def find_seat(replay: Replay, hunter: int | str) -> int:
    """The only seat that is meant, as of `find_subjects`.

    Raises:
        ConfigError: for a hunter that the match does not have, prey, and a name that several have.
    """
    seats, _ = find_subjects(replay, hunter)
    if not seats:
        raise ConfigError(f"hunter must be no prey, which has no view to draw, got {hunter!r}")
    if len(seats) > 1:
        raise ConfigError(f"hunter must be one of the seats {', '.join(map(str, seats))}: {hunter!r} means all of them")
    return seats[0]

"""Labels of the hunters, prey and teams of a match, and their selection by name."""

from collections.abc import Sequence

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
    """Return the reason why a hunter left, with its clause: a replay lists withdrawals, but not dropouts."""
    return "withdrawn (R1.6)" if any(gone == seat for _, gone in replay.withdrawals) else "dropped out (R1.7)"


def find_subjects(replay: Replay, name: int | str | None) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the seats of the hunters and the indices of the prey that a name means; all of them for None.

    A name is a seat's number, `hunter_{seat}`, `prey_{index}`, or that of an agent or a team; it selects all that have
    it. For one that the match does not have, ConfigError is raised.
    """
    require_type("replay", replay, Replay, "Replay.load(path)")
    config = replay.config
    if name is None:
        return tuple(range(config.hunters)), tuple(range(config.prey))
    known: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {}
    # agents' names come second, and replace others, since an agent may be called hunter_1 in another seat
    for hunters, prey in (config.hunter_names, config.prey_names), (replay.hunter_names, replay.prey_names):
        for agent in (*hunters, *prey):
            seats, indices = ([index for index, one in enumerate(side) if one == agent] for side in (hunters, prey))
            known[agent] = tuple(seats), tuple(indices)
    known |= {team_label(replay, members): (members, ()) for members in config.teams or ()}
    if isinstance(name, str) and not name.isdecimal():
        if name not in known:
            raise ConfigError(f"unknown hunter {name!r}: {suggest(name, known)}")
        return known[name]
    if str(name) not in map(str, range(config.hunters)):
        raise ConfigError(f"hunter must be a seat from 0 to {config.hunters - 1}, got {name!r}")
    return (int(name),), ()

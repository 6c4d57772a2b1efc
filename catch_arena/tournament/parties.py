"""Who plays as one: a team of hunters (R11.1; a hunter where there are no teams), or one prey (R12.1).

A match seats one entrant in each party, with an instance of it in each of the party's seats. Seats count the hunters
first, and then the prey.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Final, TypeVar

from catch_arena.config import ArenaConfig
from catch_arena.policy import Side

SIDES: Final[tuple[Side, ...]] = ("hunter", "prey")

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Parties:
    """The parties of an arena: first those that hunt, then the prey."""

    seats: tuple[tuple[int, ...], ...]
    """By party."""
    hunting: int
    """How many of them hunt."""

    @classmethod
    def of(cls, config: ArenaConfig) -> "Parties":
        """Those of an arena."""
        prey = range(config.hunters, config.hunters + config.prey)
        return cls((*config.team_seats, *((seat,) for seat in prey)), len(config.team_seats))

    def __len__(self) -> int:
        return len(self.seats)

    @property
    def sides(self) -> tuple[Side, ...]:
        """Which sides there are."""
        return SIDES if self.hunting < len(self) else SIDES[:1]

    def on(self, side: Side) -> slice:
        """Which parties play on a side."""
        return slice(self.hunting) if side == "hunter" else slice(self.hunting, None)

    def side_of(self, party: int) -> Side:
        """What a party plays."""
        return "hunter" if party < self.hunting else "prey"

    @property
    def group(self) -> int:
        """How many entrants play a block (docs/tournaments.md): one for each party, and with prey two for a side that
        has but one party; three, where both have one.
        """
        return 3 if self._one_against_one else sum(self._players)

    @property
    def block_size(self) -> int:
        """How many matches a block has."""
        return sum(1 for _ in self.seatings(range(self.group)))

    def seatings(self, circle: Sequence[T]) -> Iterator[tuple[T, ...]]:
        """The matches of a block, by party: every rotation of its players, so that each plays each party.

        With prey, where a side has one party, the next in the circle plays it too, against the same others on the
        other side: else there would be nobody to compare it with.

        Args:
            circle: `group` players.
        """
        if self._one_against_one:
            yield from permutations(circle, 2)
            return
        hunters, others = self._players
        for turn in range(len(circle)):
            order = (*circle[turn:], *circle[:turn])
            for hunting in _lineups(order[:hunters], self.hunting):
                for hunted in _lineups(order[hunters : hunters + others], len(self) - self.hunting):
                    yield *hunting, *hunted

    @property
    def _one_against_one(self) -> bool:
        """Whether one party hunts one prey: all play all."""
        return self.hunting == 1 and len(self) == 2 and len(self.sides) == 2

    @property
    def _players(self) -> tuple[int, int]:
        """How many of a group hunt, and how many are prey, in each of its rotations."""
        prey = len(self) - self.hunting
        return (max(self.hunting, 2), max(prey, 2)) if prey else (self.hunting, 0)

    @property
    def task(self) -> str:
        """What entrants are there for, in words."""
        teams = any(len(seats) > 1 for seats in self.seats)
        hunters = f"{self.hunting} teams" if teams else f"{self.hunting} hunters"
        prey = len(self) - self.hunting
        return f"play the {hunters} and the {prey} prey" if prey else "be the teams" if teams else "fill the seats"

    @property
    def names(self) -> tuple[str, ...]:
        """What the parties are called in tables: their seats, prey by its index."""
        hunting = ["+".join(map(str, seats)) for seats in self.seats[: self.hunting]]
        return *hunting, *(f"prey {index}" for index in range(len(self) - self.hunting))

    def called(self, party: int) -> str:
        """A party in a sentence: `seat 1`, `seats 2+3`, `prey 0`."""
        many = "s" if len(self.seats[party]) > 1 else ""
        return f"seat{many} {self.names[party]}" if party < self.hunting else self.names[party]

    @property
    def places(self) -> tuple[tuple[int, int], ...]:
        """By seat: its party, and its number among the party's seats."""
        places = {seat: (party, number) for party, seats in enumerate(self.seats) for number, seat in enumerate(seats)}
        return tuple(places[seat] for seat in range(len(places)))

    @property
    def by_seat(self) -> tuple[int, ...]:
        """The party of each seat."""
        return tuple(party for party, _ in self.places)


def _lineups(players: tuple[T, ...], parties: int) -> Sequence[tuple[T, ...]]:
    """Who plays the parties of a side: all these players, or one of them after the other."""
    return [players] if len(players) == parties else [(one,) for one in players]

"""Parties of an arena: a party is a team of hunters (R11.1), a hunter if there are no teams, or one prey (R12.1).

In a match one entrant plays each party, with an instance in each of the party's seats. Seats count the hunters first,
and then the prey.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import TypeVar

from catch_arena.config import ArenaConfig
from catch_arena.policy import Side

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Parties:
    """Parties of an arena: first the hunting parties, then the prey."""

    seats: tuple[tuple[int, ...], ...]
    hunting: int
    """Number of hunting parties."""

    @classmethod
    def of(cls, config: ArenaConfig) -> "Parties":
        """Return the parties of an arena."""
        prey = range(config.hunters, config.hunters + config.prey)
        return cls((*config.team_seats, *((seat,) for seat in prey)), len(config.team_seats))

    def __len__(self) -> int:
        return len(self.seats)

    @property
    def sides(self) -> tuple[Side, ...]:
        """Sides of the arena."""
        return ("hunter", "prey") if self.hunting < len(self) else ("hunter",)

    def on(self, side: Side) -> slice:
        """Return the parties of a side, as a slice."""
        return slice(self.hunting) if side == "hunter" else slice(self.hunting, None)

    def side_of(self, party: int) -> Side:
        """Return the side of a party."""
        return "hunter" if party < self.hunting else "prey"

    @property
    def group(self) -> int:
        """Number of entrants in a block (docs/howto/tournaments.md): one for each party; with prey, two for a side with
        one party; three in all if both sides have one.
        """
        return 3 if self._one_against_one else sum(self._players)

    @property
    def block_size(self) -> int:
        """Number of matches in a block."""
        return sum(1 for _ in self.seatings(range(self.group)))

    def seatings(self, circle: Sequence[T]) -> Iterator[tuple[T, ...]]:
        """Yield the matches of a block, as players by party: every rotation, so that each player plays each party.

        With prey, if a side has one party, the next player in the circle plays it too, against the same players on the
        other side. Otherwise a match would have no other player on that side to compare with. The circle has `group`
        players.
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
        """True if one party hunts one prey: then each player of a block plays each other."""
        return self.hunting == 1 and len(self) == 2 and len(self.sides) == 2

    @property
    def _players(self) -> tuple[int, int]:
        """Numbers of hunters and of prey among a block's players, in each rotation."""
        prey = len(self) - self.hunting
        return (max(self.hunting, 2), max(prey, 2)) if prey else (self.hunting, 0)

    @property
    def task(self) -> str:
        """Task of the entrants, in words for an error."""
        teams = any(len(seats) > 1 for seats in self.seats)
        prey = len(self) - self.hunting
        return f"play the {self.hunting} {'teams' if teams else 'hunters'}{f' and the {prey} prey' if prey else ''}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parties in tables: their seats, or the index of a prey."""
        hunting = ["+".join(map(str, seats)) for seats in self.seats[: self.hunting]]
        return *hunting, *(f"prey {index}" for index in range(len(self) - self.hunting))

    def called(self, party: int) -> str:
        """Return the name of a party in a sentence: `seat 1`, `seats 2+3`, `prey 0`."""
        many = "s" if len(self.seats[party]) > 1 else ""
        return f"seat{many} {self.names[party]}" if party < self.hunting else self.names[party]

    @property
    def places(self) -> tuple[tuple[int, int], ...]:
        """Party of each seat, and the seat's number among the party's seats, from 0."""
        places = {seat: (party, number) for party, seats in enumerate(self.seats) for number, seat in enumerate(seats)}
        return tuple(places[seat] for seat in range(len(places)))

    @property
    def by_seat(self) -> tuple[int, ...]:
        """Party of each seat."""
        return tuple(party for party, _ in self.places)


def _lineups(players: tuple[T, ...], parties: int) -> Sequence[tuple[T, ...]]:
    """Return the line-ups of a side: all these players together, or one after the other if the side has one party."""
    return [players] if len(players) == parties else [(one,) for one in players]

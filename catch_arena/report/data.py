"""Contents of a tournament's folder, read once, from which the whole report is made."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from catch_arena.errors import ReplayError, StoreError
from catch_arena.replay import Replay
from catch_arena.tournament.execution.runner import REPLAYS
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.standings import Standing, standings
from catch_arena.tournament.store import Store, Tournament


class SideData(SideResults):
    """Results of one side, and the figures that follow from them."""

    @cached_property
    def names(self) -> list[str]:
        """The entrants' names, as matches number them."""
        return [entrant.name for entrant in self.entrants]

    @cached_property
    def standings(self) -> list[Standing]:
        """Standings on this side, the best first."""
        return standings(self)


@dataclass(frozen=True)
class ReportData:
    """Data of a tournament, ended or under way."""

    folder: Path
    tournament: Tournament
    planned: int
    played: Sequence[PlayedMatch]
    """Matches that were played, in the order of the plan."""
    versions: Sequence[dict[str, str]]
    """Every set of versions with which matches were played."""
    ended: bool
    """True if the plan has been played to its end."""

    @classmethod
    def of(cls, folder: Path) -> "ReportData":
        """Return the data in a folder; raise StoreError if it holds no tournament, or no match has been played."""
        played, versions = [], {}
        with Store.read(folder) as store:
            tournament, planned, ended = store.tournament, store.count_planned(), store.ended
            for played_match, version in store.records():
                played.append(played_match)
                versions[id(version)] = version
        if not played:
            raise StoreError(f"{folder}: no match has been played yet")
        return cls(folder, tournament, planned, played, list(versions.values()), ended)

    @cached_property
    def names(self) -> list[str]:
        """The entrants' names, as matches number them."""
        return [entrant.name for entrant in self.tournament.entrants]

    @cached_property
    def parties(self) -> Parties:
        """Parties of a match."""
        return Parties.of(self.tournament.config)

    @cached_property
    def sides(self) -> list[SideData]:
        """Results of each side, the hunters' first."""
        entrants, parties = self.tournament.entrants, self.parties
        return [SideData.of(entrants, self.played, parties, side) for side in parties.sides]

    @property
    def standings(self) -> list[Standing]:
        """Standings of the hunters, the best first."""
        return self.sides[0].standings

    @cached_property
    def recorded(self) -> frozenset[str]:
        """Ids of the matches whose replay was kept."""
        return frozenset(played_match.match.id for played_match in self.played if played_match.replay)

    def replay(self, match: str) -> Replay:
        """Return the replay of a match; raise ReplayError if it was not recorded, or its file is damaged."""
        if match not in self.recorded:
            raise ReplayError(f"match {match}: cannot be shown; it must be a match that was played and recorded")
        return Replay.load(self.folder / REPLAYS / f"{match}.replay")

"""Blocks that could not be played: each is played again with its isolated agents apart, and without those who turn out
to have done harm.
"""

from typing import Final

from catch_arena.errors import StoreError, WorkerLost
from catch_arena.tournament.crash_journal import CrashJournal
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.execution.worker import EntrantSabotage, Excluded, RecordedMatch
from catch_arena.tournament.match import Block
from catch_arena.tournament.players import Fault

_MOST_TRIES: Final = 3
"""How often a block is begun whose worker is lost before any agent ran."""


class Quarantine:
    """The quarantine of one tournament's blocks; nothing that agents run lives on meanwhile."""

    def __init__(self, executor: Executor, journal: CrashJournal) -> None:
        self._executor = executor
        self._journal = journal
        store = journal.store.path
        self._disks = {} if store is None else {"the disk of the results": store.parent.absolute()}

    def has_suspects(self, block: Block, excluded: Excluded) -> bool:
        """Whether agents run in a block that could do harm; else a quarantine finds nothing."""
        return bool(self._executor.worker.suspects(block, excluded))

    def is_due(self, block: Block, excluded: Excluded) -> bool:
        """Whether a block was being played when the tournament ended the last time, perhaps by its agents' doing."""
        return block[0].block in self._journal.begun and self.has_suspects(block, excluded)

    def note_begun(self, block: Block, excluded: Excluded) -> None:
        """That block is about to be played."""
        if self.has_suspects(block, excluded):
            self._journal.begin(block[0].block)

    def note_kept(self, block: Block) -> None:
        """That block has been kept."""
        self._journal.end(block[0].block)

    def play(self, block: Block, excluded: Excluded) -> list[RecordedMatch]:
        """The matches of a block, while nothing else is played. Whoever does harm forfeits all of them, unstarted.

        Raises:
            NoContest: for a match that could not be held, and no agent is to blame.
            StoreError: where what was found cannot be written.
        """
        number, lost = block[0].block, 0
        turn: int | None = None

        def begin_turn(index: int) -> None:
            nonlocal turn
            self._journal.begin_turn(number, index)
            turn = index

        while True:
            turn = None
            culprits = self._journal.culprits(number)
            forfeits = {index: Fault("FORFEIT_SABOTAGE", what) for index, what in culprits.items()}
            try:
                self._executor.stop_agents()
                with self._executor.process() as process:
                    played = process.play_apart(block, {**forfeits, **excluded}, begin_turn, self._disks)
            except EntrantSabotage as found:
                self._journal.record_culprit(number, found.entrant, found.what)
            except WorkerLost as error:
                lost += 1
                if turn is not None:
                    self._journal.record_culprit(number, turn, f"{error} while no other agent ran")
                elif lost == _MOST_TRIES:
                    raise
            except KeyboardInterrupt:
                self._journal.break_off()
                raise
            except StoreError:  # the disk may be full by the doing of whoever has its turn
                raise
            except Exception:
                self._journal.end_turns()
                raise
            else:
                self._journal.end_turns()
                return played

"""Who is under suspicion, in a tournament's store: written before an agent runs, so that it outlives whatever it does.

A block that had begun and was not kept, when the tournament ended, is played with its agents apart when it goes on. An
agent in whose turn the tournament was killed, when no other agent ran, has done that.
"""

from pathlib import Path
from typing import Final

from catch_arena.tournament.store import Store

_BROKEN_OFF: Final = "INSERT OR IGNORE INTO broken_off VALUES (?, ?)"
_BOOT: Final = Path("/proc/sys/kernel/random/boot_id")


class CrashJournal:
    """What is known of the agents of a tournament's blocks.

    Raises:
        StoreError: for whatever cannot be read or written.
    """

    def __init__(self, store: Store) -> None:
        """Go on from what stands in the store."""
        self.store = store
        self._boot = _BOOT.read_text() if _BOOT.exists() else ""
        with store.transaction() as db:
            self.begun = {block for (block,) in db.execute("SELECT block FROM begun")}
            """The blocks that were played when the tournament ended, and did not end themselves."""
            turn = db.execute("SELECT block, entrant, boot FROM turn").fetchone()
        if turn is not None and turn[2] == self._boot:
            self.record_culprit(turn[0], turn[1], "the tournament was killed while no other agent ran")
        elif turn is not None:  # the machine went down, perhaps by its doing
            self.break_off()

    def begin(self, block: int) -> None:
        """A block is about to be played."""
        with self.store.transaction() as db:
            db.execute("INSERT OR IGNORE INTO begun VALUES (?)", (block,))

    def begin_turn(self, block: int, entrant: int) -> None:
        """An entrant is about to run, and no other."""
        with self.store.transaction() as db:
            db.execute("DELETE FROM turn")
            db.execute("INSERT INTO turn VALUES (?, ?, ?)", (block, entrant, self._boot))

    def end_turns(self) -> None:
        """Nobody runs any more, and nothing has happened."""
        with self.store.transaction() as db:
            db.execute("DELETE FROM turn")

    def break_off(self) -> None:
        """The tournament ends in somebody's turn, but in order: that may be a person's wish once, and not twice."""
        with self.store.transaction() as db:
            turns = db.execute("SELECT block, entrant FROM turn").fetchall()
            db.execute("DELETE FROM turn")
            again = [turn for turn in turns if not db.execute(_BROKEN_OFF, turn).rowcount]
        for block, entrant in again:
            self.record_culprit(block, entrant, "the tournament ended while no other agent ran, twice")

    def record_culprit(self, block: int, entrant: int, what: str) -> None:
        """It did harm: it plays in no match of that block."""
        with self.store.transaction() as db:
            db.execute("INSERT OR IGNORE INTO culprit VALUES (?, ?, ?)", (block, entrant, what))
            db.execute("DELETE FROM turn")

    def culprits(self, block: int) -> dict[int, str]:
        """Who does not play in a block, and what they did."""
        with self.store.transaction() as db:
            return dict(db.execute("SELECT entrant, what FROM culprit WHERE block = ?", (block,)))

    def end(self, block: int) -> None:
        """The block has been kept."""
        with self.store.transaction() as db:
            db.execute("DELETE FROM begun WHERE block = ?", (block,))

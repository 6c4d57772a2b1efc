"""Entrants: agents that were inspected (`players.enter`), each under a name that is unique in its tournament."""

from dataclasses import dataclass, field, replace
from typing import Final

from catch_arena.config import Control
from catch_arena.policy import Side
from catch_arena.tournament.agent_spec import shipped_spec

SHIPPED_PREY: Final = "flee"
"""The agent that plays prey for agents that do not."""


@dataclass(frozen=True, slots=True)
class Entrant:
    """Agent in a tournament; it can be sent to another process, which makes its own instances."""

    name: str
    """Name, unique in its tournament: `nearest`, and `nearest#2` if it plays against itself; `ann/agent` for a file
    with a generic name, and `ann/mine` and `bob/mine` if two files have one name.
    """
    spec: str
    """Absolute path of a file or folder, `package.module:Class`, or `cmd:` and a command with absolute paths."""
    control: Control
    digest: str
    """Digest of the agent's files and of network weights next to them, in 16 hexadecimal digits; for a command, digest
    of its words and of the files that they name.
    """
    fault: str | None = None
    """Reason for which it cannot play and forfeits all matches, found by its inspection; None if it can play."""
    prey: bool = False
    """R12.7: True if it plays prey itself; else a shipped agent plays prey for it."""
    prey_digest: str = ""
    """Digest of the agent that plays prey for this entrant."""
    side: Side = "hunter"
    log: str = field(default="", compare=False)
    """Last lines of its output during its inspection, if it cannot play."""

    @property
    def needs_prey(self) -> bool:
        """True if the shipped prey plays for it: it has no prey class, and it can play."""
        return not self.prey and self.fault is None

    def on(self, side: Side) -> "Entrant":
        """Return the entrant that plays for it on a side; a shipped agent that plays prey for it is named as such."""
        if side == self.side:
            return self
        found = replace(self, control="velocity", side=side)
        if not self.needs_prey:
            return found
        name, spec = f"{self.name} (plays {SHIPPED_PREY})", shipped_spec(SHIPPED_PREY)
        return replace(found, name=name, spec=spec, digest=self.prey_digest)

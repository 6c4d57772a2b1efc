"""Recorder of the episodes of an env or a service as replays."""

from bisect import insort
from collections.abc import Sequence

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.replay.fileformat import checked_names, checked_text
from catch_arena.replay.recording import Replay


class Recorder:
    """Recorder of every episode from the reset after `record` on; before that it keeps nothing."""

    def __init__(self, config: ArenaConfig) -> None:
        self._config = config
        self._names_and_title: tuple[tuple[str, ...], str] | None = None
        self.replay: Replay | None = None
        """Replay of the episode so far; None if it is not recorded."""

    def record(self, names: Sequence[str], title: str) -> None:
        """Record the following episodes.

        Raises:
            ConfigError: for a name or a title that is not at most 200 printable characters.
        """
        called = checked_names(names, self._config)
        checked_text("name_prefix", self._config.name_prefix)
        self._names_and_title = called, checked_text("title", title)

    def begin(self, seed: int, engine: Engine) -> None:
        """Note that an episode has begun."""
        self.replay = None
        if self._names_and_title is not None:
            self.replay = Replay(self._config, seed, *self._names_and_title)
            self.replay.note(engine)

    def withdraw(self, row: int) -> None:
        """Note that an agent was withdrawn: `row` is a hunter's seat, or the number of hunters plus prey's index."""
        if self.replay is not None:
            insort(self.replay.withdrawals, (self.replay.steps, row))  # agents can be withdrawn in any order

    def __deepcopy__(self, memo: object) -> "Recorder":
        """Return an independent copy."""
        twin = Recorder(self._config)
        twin._names_and_title = self._names_and_title
        twin.replay = None if self.replay is None else self.replay.copy()
        return twin

"""Recorder of the episodes of an env or a service as replays."""

from bisect import insort
from collections.abc import Sequence

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.replay import Replay, checked_names, checked_text


class Recorder:
    """Recorder of every episode from the reset after `record` on; before that it keeps nothing."""

    def __init__(self, config: ArenaConfig) -> None:
        self._config = config
        self._names: tuple[str, ...] | None = None
        self._title = ""
        self.replay: Replay | None = None
        """Replay of the episode so far; None if it is not recorded."""

    def record(self, names: Sequence[str] | None, title: str) -> None:
        """Record the following episodes: see `CatchArenaEnv.record`."""
        import catch_arena.player  # noqa: F401 - notebooks show replays with it

        agents = self._config.hunter_names + self._config.prey_names
        called = checked_names(agents if names is None else names, self._config)
        checked_text("name_prefix", self._config.name_prefix)
        self._title = checked_text("title", title)
        self._names = called

    def begin(self, seed: int, engine: Engine) -> None:
        """Note that an episode has begun."""
        self.replay = None
        if self._names is not None:
            self.replay = Replay(self._config, seed, self._names, self._title)
            self.replay.note(engine)

    def withdraw(self, row: int) -> None:
        """Note that an agent was withdrawn: `row` is a hunter's seat, or the number of hunters plus prey's index."""
        if self.replay is not None:
            insort(self.replay.withdrawals, (self.replay.steps, row))  # agents can be withdrawn in any order

    def copy(self) -> "Recorder":
        """Return an independent copy."""
        twin = Recorder(self._config)
        twin._names, twin._title = self._names, self._title
        twin.replay = None if self.replay is None else self.replay.copy()
        return twin

"""Episodes of an env, kept as replays."""

from bisect import insort
from collections.abc import Sequence

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.replay import Replay, checked_names, checked_text


class Recorder:
    """Keeps every episode from the reset after `record` on; until then nothing."""

    def __init__(self, config: ArenaConfig) -> None:
        self._config = config
        self._names: tuple[str, ...] | None = None
        self._title = ""
        self.replay: Replay | None = None
        """The episode so far."""

    def record(self, names: Sequence[str] | None, title: str) -> None:
        """See `CatchArenaEnv.record`."""
        import catch_arena.player  # noqa: F401 - notebooks show the replay by it

        agents = self._config.hunter_names + self._config.prey_names
        called = checked_names(agents if names is None else names, self._config)
        checked_text("name_prefix", self._config.name_prefix)
        self._title = checked_text("title", title)
        self._names = called

    def begin(self, seed: int, engine: Engine) -> None:
        """An episode has begun."""
        self.replay = None
        if self._names is not None:
            self.replay = Replay(self._config, seed, self._names, self._title)
            self.replay.note(engine)

    def withdraw(self, row: int) -> None:
        """An agent was withdrawn: a hunter's seat, or behind the seats prey's index."""
        if self.replay is not None:
            insort(self.replay.withdrawals, (self.replay.steps, row))  # agents fail in any order

    def copy(self) -> "Recorder":
        """A recorder of its own in the same state."""
        twin = Recorder(self._config)
        twin._names, twin._title = self._names, self._title
        twin.replay = None if self.replay is None else self.replay.copy()
        return twin

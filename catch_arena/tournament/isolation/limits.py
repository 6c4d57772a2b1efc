"""What an agent in a process of its own may take: time, memory, files and output."""

from dataclasses import dataclass, fields
from typing import Any, Final

from catch_arena.errors import ConfigError, suggest

_MOST: Final = 10**6


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentLimits:
    """The limits of one agent in one match (docs/isolation.md); times are by the clock on the wall unless said."""

    init_s: float = 10.0
    """For all that comes before the first view: start, import, construction and `reset`."""
    step_ms: float = 100.0
    """For one action."""
    bank_s: float = 5.0
    """What a match allows over `step_ms`, in all its steps together."""
    memory_mib: int = 1024
    """Private memory of each process; its addresses may span four times as much, for libraries. All processes of an
    agent together may hold twice as much.
    """
    processes: int = 256
    """Processes and threads of an agent at a time, all together."""
    cpu_s: int = 300
    """CPU time of each process, in one match."""
    open_files: int = 64
    """At a time, in each process."""
    file_mib: int = 16
    """The largest file that it may write; all its files together, in each of two folders, where it has namespaces."""
    log_kib: int = 64
    """What is kept of all that it prints in a match: the first half and the last."""
    answer_kib: int = 64
    """The longest answer."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value, whole = getattr(self, field.name), field.type is int
            lowest: float = _LOWEST.get(field.name, 1)
            right = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
            if not right or not lowest <= value <= _MOST:
                kind = "whole number" if whole else "number"
                raise ConfigError(f"{field.name} must be a {kind} from {lowest:g} to {_MOST}, got {value!r}")

    @classmethod
    def of(cls, **values: Any) -> "AgentLimits":
        """The usual limits with these changes.

        Raises:
            ConfigError: that names the nearest right name.
        """
        known = [field.name for field in fields(cls)]
        for name in values:
            if name not in known:
                raise ConfigError(f"unknown limit {name!r}: {suggest(name, known)}")
        return cls(**values)


_LOWEST: Final = {"init_s": 0.1, "bank_s": 0.0, "memory_mib": 32, "open_files": 16}

"""Limits of an isolated agent, and the two levels of isolation."""

from dataclasses import dataclass, fields
from typing import Any, Final, Literal, get_args

from catch_arena.config import require_choice
from catch_arena.errors import ConfigError, suggest

Level = Literal["namespaces", "processes"]
"""Levels of isolation: an agent has its own namespaces, or only its own process."""
_MOST: Final = 10**6


@dataclass(frozen=True, slots=True, kw_only=True)
class Quotas:
    """Limits of one agent in one match (docs/howto/isolation.md). Times are wall-clock times, except `cpu_s`."""

    init_s: float = 10.0
    """Time before the first view [s]: for start, import, construction and `reset`."""
    step_ms: float = 100.0
    """Time for one action [ms]."""
    bank_s: float = 5.0
    """Time over `step_ms` that a match allows in all its steps together [s]."""
    memory_mib: int = 1024
    """Private memory of each process [MiB]. Its addresses may span four times as much, for libraries."""
    processes: int = 256
    """Number of processes and threads of an agent at the same time."""
    cpu_s: int = 300
    """CPU time of each process in one match [s]."""
    open_files: int = 64
    """Number of files that each process has open at the same time."""
    file_mib: int = 16
    """Size of its output, and of each file that it writes [MiB]; in namespaces also of all in each of two folders."""
    log_kib: int = 64
    """Size of the output in a match that is kept [KiB]: half of it from the beginning, half from the end."""
    answer_kib: int = 64
    """Size of the longest answer [KiB]."""
    isolation: Level | None = None
    """Level of isolation; None for namespaces if this machine has them, else processes."""

    def __post_init__(self) -> None:
        if self.isolation is not None:
            require_choice("isolation", self.isolation, get_args(Level))
        for name, kind in _NUMBERS.items():
            value, whole = getattr(self, name), kind is int
            lowest: float = _LOWEST.get(name, 1)
            right = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
            if not right or not lowest <= value <= _MOST:
                what = "whole number" if whole else "number"
                raise ConfigError(f"{name} must be a {what} from {lowest:g} to {_MOST}, got {value!r}")

    @classmethod
    def of(cls, **values: Any) -> "Quotas":
        """Return the default limits with these changes; raise ConfigError for an unknown name or a wrong value."""
        names = [*_NUMBERS, "isolation"]
        for name in values:
            if name not in names:
                raise ConfigError(f"unknown limit {name!r}: {suggest(name, names)}")
        return cls(**values)

    def numbers(self) -> dict[str, int | float]:
        """Return the limits that are numbers, by name."""
        return {name: getattr(self, name) for name in _NUMBERS}


_NUMBERS: Final = {field.name: field.type for field in fields(Quotas) if field.type in {int, float}}
_LOWEST: Final = {"init_s": 0.1, "bank_s": 0.0, "memory_mib": 32, "open_files": 16}

"""What an isolated agent may take, and what it may see."""

from dataclasses import dataclass, fields
from typing import Any, Final, Literal, get_args

from catch_arena.config import require_choice
from catch_arena.errors import ConfigError, suggest

Level = Literal["namespaces", "processes"]
"""How agents are held apart: by namespaces of their own, or only by being processes of their own."""
_MOST: Final = 10**6


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentLimits:
    """The limits of one agent in one match (docs/isolation.md); times are by the clock on the wall unless said.

    The last three are no numbers: how agents are held apart, and what they do not see.
    """

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
    level: Level | None = None
    """None for the best that a machine can hold."""
    entrants: tuple[str, ...] = ()
    """The specs of all who play: in namespaces, no agent sees the files of another."""
    hidden: tuple[str, ...] = ()
    """Whole paths of files and folders that no agent sees there."""

    def __post_init__(self) -> None:
        if self.level is not None:
            require_choice("isolation", self.level, get_args(Level))
        for name, kind in _NUMBERS.items():
            value, whole = getattr(self, name), kind is int
            lowest: float = _LOWEST.get(name, 1)
            right = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
            if not right or not lowest <= value <= _MOST:
                what = "whole number" if whole else "number"
                raise ConfigError(f"{name} must be a {what} from {lowest:g} to {_MOST}, got {value!r}")

    @classmethod
    def of(cls, **values: Any) -> "AgentLimits":
        """The usual limits with these changes of numbers.

        Raises:
            ConfigError: that names the nearest right name.
        """
        for name in values:
            if name not in _NUMBERS:
                raise ConfigError(f"unknown limit {name!r}: {suggest(name, _NUMBERS)}")
        return cls(**values)

    def numbers(self) -> dict[str, int | float]:
        """Those that are numbers, by name."""
        return {name: getattr(self, name) for name in _NUMBERS}


_NUMBERS: Final = {field.name: field.type for field in fields(AgentLimits) if field.type in {int, float}}
_LOWEST: Final = {"init_s": 0.1, "bank_s": 0.0, "memory_mib": 32, "open_files": 16}

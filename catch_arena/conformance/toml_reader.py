"""TOML tables read key by key, so that whatever is wrong in a file is an error that names its place.

The readers of values raise TypeError or ValueError, which a Table puts in words.
"""

import math
from collections.abc import Callable
from typing import Any

from catch_arena.errors import ConfigError, suggest


class Table:
    """One TOML table, read key by key: what is missing, of a wrong kind or left over is a ConfigError."""

    def __init__(self, where: str, content: object) -> None:
        if not isinstance(content, dict):
            raise ConfigError(f"{where}: must be a table, got {content!r}")
        self.where = where
        self._left = dict(content)
        self._known: list[str] = []

    def take(self, key: str, words: str, read: Callable[[Any], Any], *default: Any) -> Any:
        """The value under a key, as `read` makes it; `words` say in an error what it must be."""
        self._known.append(key)
        if key not in self._left:
            if default:
                return default[0]
            raise ConfigError(f"{self.where}: {key} must be given: {words}")
        value = self._left.pop(key)
        try:
            return read(value)
        except ConfigError:
            raise
        except (TypeError, ValueError):
            raise ConfigError(f"{self.where}: {key} must be {words}, got {value!r}") from None

    def finish(self) -> None:
        """Nothing may be left that was not asked for."""
        for key in self._left:
            raise ConfigError(f"{self.where}: unknown key {key!r}: {suggest(key, self._known)}")


def listed(value: object) -> list[Any]:
    """A list as it is."""
    if not isinstance(value, list):
        raise TypeError
    return value


def tabled(value: object) -> dict[str, Any]:
    """A table as it is."""
    if not isinstance(value, dict):
        raise TypeError
    return value


def text(value: object) -> str:
    """A string as it is."""
    if not isinstance(value, str):
        raise TypeError
    return value


def texts(value: object) -> tuple[str, ...]:
    """A list of strings."""
    return tuple(map(text, listed(value)))


def flag(value: object) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise TypeError
    return value


def whole(value: object) -> int:
    """A whole number from 0."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise TypeError
    return value


def wholes(value: object) -> list[int]:
    """A list of whole numbers from 0."""
    return list(map(whole, listed(value)))


def number(value: object) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise TypeError
    return float(value)


def point(value: object) -> tuple[float, float]:
    """A place (x, y) from a list of two numbers."""
    x, y = map(number, listed(value))
    return x, y


def word_or(word: str, read: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """What `read` makes of a value, or that word as it is."""
    return lambda value: word if value == word else read(value)

"""Infos that are made when somebody asks for them: most steps' are never looked at."""

from collections.abc import Callable
from functools import wraps
from typing import Any


class Infos(dict[str, Any]):
    """A dict of infos by agent that is filled when it is used for the first time, and then an ordinary dict.

    It is born with its keys: what is written in C looks at a dict's size before it asks for more.
    """

    __slots__ = ("make",)

    make: Callable[[], dict[str, dict[str, Any]]] | None
    """What it will hold; to be set before it is used. It must not read what later steps change."""

    def _fill(self) -> None:
        if self.make is not None:
            made, self.make = self.make(), None
            super().update(made)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copied and pickled as the dict that it stands for."""
        return dict, (dict(self),)


def _filling(name: str) -> Callable[..., Any]:
    method = getattr(dict, name)

    @wraps(method)
    def filled(self: Infos, *arguments: Any, **named: Any) -> Any:
        self._fill()
        return method(self, *arguments, **named)

    return filled


# every way into a dict; `__iter__` among them keeps dict(...) and {**...} from reading past these methods
for _name in (
    *("__contains__", "__delitem__", "__eq__", "__ge__", "__getitem__", "__gt__", "__ior__", "__iter__", "__le__"),
    *("__len__", "__lt__", "__ne__", "__or__", "__repr__", "__reversed__", "__ror__", "__setitem__"),
    *("clear", "copy", "get", "items", "keys", "pop", "popitem", "setdefault", "update", "values"),
):
    setattr(Infos, _name, _filling(_name))

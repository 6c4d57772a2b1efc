"""Infos that are made when somebody asks for them: most steps' are never looked at."""

from collections.abc import Callable
from functools import wraps
from typing import Any


class MaterializedInfos(dict[str, Any]):
    """Infos by agent, an ordinary dict; copied and pickled as one."""

    __slots__ = ("arguments", "make")

    make: Callable[..., dict[str, dict[str, Any]]]
    """Makes what it will hold, while it is not filled yet. It must not read what later steps change."""
    arguments: tuple[Any, ...]
    """Of `make`: to keep them takes half as long as a function that knows them."""

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (dict(self),)


class LazyInfos(MaterializedInfos):
    """A dict of infos by agent that is filled when it is used for the first time, and then a MaterializedInfos, read
    as fast as any dict.

    It is born with its keys, for what is written in C looks at a dict's size before it asks for more; `make` and
    `arguments` are to be set before it is used.
    """

    __slots__ = ()

    def _fill(self) -> None:
        super().update(self.make(*self.arguments))
        del self.make, self.arguments  # with the arrays that they hold
        self.__class__ = MaterializedInfos  # type: ignore[assignment]  # of the same layout


def _filling(name: str) -> Callable[..., Any]:
    method = getattr(dict, name)

    @wraps(method)
    def filled(self: LazyInfos, *arguments: Any, **named: Any) -> Any:
        self._fill()
        return method(self, *arguments, **named)

    return filled


# every way into a dict; `__iter__` among them keeps dict(...) and {**...} from reading past these methods
for _name in (
    *("__contains__", "__delitem__", "__eq__", "__ge__", "__getitem__", "__gt__", "__ior__", "__iter__", "__le__"),
    *("__len__", "__lt__", "__ne__", "__or__", "__repr__", "__reversed__", "__ror__", "__setitem__"),
    *("clear", "copy", "get", "items", "keys", "pop", "popitem", "setdefault", "update", "values"),
):
    setattr(LazyInfos, _name, _filling(_name))

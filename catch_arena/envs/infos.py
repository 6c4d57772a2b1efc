"""Infos that are made when somebody asks for them: most steps' are never looked at."""

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import Any, Final

_filling: Final = RLock()
"""One thread at a time fills infos."""


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


def _fill(infos: LazyInfos) -> None:
    with _filling:
        if type(infos) is LazyInfos:  # no other thread has filled it meanwhile
            dict.update(infos, infos.make(*infos.arguments))
            del infos.make, infos.arguments  # with the arrays that they hold
            infos.__class__ = MaterializedInfos  # type: ignore[assignment]  # of the same layout


def _filled_by(name: str) -> Callable[..., Any]:
    method = getattr(dict, name)

    @wraps(method)
    def filled(self: LazyInfos, *arguments: Any, **named: Any) -> Any:
        _fill(self)
        return method(self, *arguments, **named)

    return filled


# every way into a dict; `__iter__` among them keeps dict(...) and {**...} from reading past these methods
for _name in (
    *("__contains__", "__delitem__", "__eq__", "__ge__", "__getitem__", "__gt__", "__ior__", "__iter__", "__le__"),
    *("__len__", "__lt__", "__ne__", "__or__", "__repr__", "__reversed__", "__ror__", "__setitem__"),
    *("clear", "copy", "get", "items", "keys", "pop", "popitem", "setdefault", "update", "values"),
):
    setattr(LazyInfos, _name, _filled_by(_name))

"""One side of `--against`: a process that imports one version of the package, and answers requests, a line each.

It knows only what `ours` does: what both versions offer in public.
"""

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import ours
from measure import Subject, play_round
from wanted import BATCH, LARGE

_THREADED = f"{LARGE}, two threads"


@contextmanager
def _on_one_processor() -> Iterator[None]:
    """Both sides play on the same one: what a shared machine's processors give differs by a third at times, and for
    minutes.
    """
    if not hasattr(os, "sched_setaffinity"):  # elsewhere than on Linux
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class Side:
    """The subjects of one version, made when they are asked for."""

    def __init__(self, package: Path, *, quick: bool) -> None:
        self._package = package
        small, large, at_once = (2, 3, 128) if quick else (1024, 16384, 65536)
        self._large = large
        self._makers: dict[str, Callable[[], Subject]] = {
            BATCH: lambda: ours.batch(small),
            LARGE: lambda: ours.batch(large),
            _THREADED: lambda: ours.batch(large, threads=2),
            f"{LARGE}, velocity control": lambda: ours.batch(large, control="velocity"),
            f"{LARGE}, full control": lambda: ours.batch(large, control="full"),
            "4 hunters": lambda: ours.by_hunters(4, at_once // 4),
            "64 hunters": lambda: ours.by_hunters(64, at_once // 64),
            "one arena, target control": lambda: ours.one_arena("target"),
            "one arena, velocity control": lambda: ours.one_arena("velocity"),
            "one arena, full control": lambda: ours.one_arena("full"),
        }
        self._made: dict[str, Subject] = {}

    def make(self, what: str, seconds: float) -> None:
        """Get it ready, with an unmeasured turn.

        Raises:
            ImportError: where the package is another one than that of this side.
        """
        subject = self._made[what] = self._makers[what]()
        play_round(subject, seconds)
        for name, module in sys.modules.items():
            file = getattr(module, "__file__", None)
            if name.partition(".")[0] == "catch_arena" and file and not Path(file).is_relative_to(self._package):
                raise ImportError(f"{name} must come from {self._package}, not from {file}")

    def time(self, what: str, seconds: float) -> dict[str, float]:
        """Seconds of a step of one arena, or of one agent's step in a batch: of all threads, and on the wall."""
        subject = self._made[what]
        with nullcontext() if what == _THREADED else _on_one_processor():
            played = play_round(subject, seconds)
        steps = played.calls * (1 if subject.envs == 1 else subject.envs * subject.agents)
        return {"cpu_s": played.cpu_s / steps, "wall_s": played.wall_s / steps}

    def memory(self) -> float:
        """Bytes an arena of a large batch."""
        return ours.bytes_of_an_arena(self._large)


def answered(side: Side, request: Sequence[Any]) -> dict[str, Any]:
    """What the request gives, or the error in a line."""
    verb, *arguments = request
    try:
        return {"answer": getattr(side, verb)(*arguments)}
    except Exception as error:  # noqa: BLE001 - an older version may fail in any way; whoever asked says so
        return {"error": " ".join(f"{type(error).__name__}: {error}".split())}


def main() -> None:
    """Answer until nobody asks any more."""
    side = Side(Path(sys.argv[1]), quick=sys.argv[2] == "quick")
    for line in sys.stdin:
        print(json.dumps(answered(side, json.loads(line))), flush=True)


if __name__ == "__main__":
    main()

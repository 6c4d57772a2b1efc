"""Process that measures one version of the package, or the peers; it answers requests, one a line."""

import json
import os
import sys
from pathlib import Path
from typing import Any

from subject import Subject

_ALL = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
"""Processors of this machine on Linux; empty elsewhere."""


def _play_on(processors: set[int]) -> None:
    if processors:
        os.sched_setaffinity(0, processors)


class Side:
    """Subjects of one version or of the peers, made on request."""

    def __init__(self, package: str, *, quick: bool, pufferlib: str) -> None:
        self._package = package
        if package:
            import ours

            self._rows = ours.rows(quick=quick)
        else:
            import peers

            self._rows = peers.rows(quick=quick, pufferlib=Path(pufferlib) if pufferlib else None)
        self._made: dict[str, Subject] = {}

    def make(self, name: str, seconds: float) -> dict[str, int]:
        """Get a subject ready, with an unmeasured turn, and return its sizes.

        Raises:
            ImportError: Catch Arena was imported from a folder outside this side's package.
        """
        made = self._made[name] = self._rows[name].make()
        made.turn(seconds)
        for module in [one for key, one in sys.modules.items() if key.partition(".")[0] == "catch_arena"]:
            file = getattr(module, "__file__", None)
            if self._package and file and not Path(file).is_relative_to(self._package):
                raise ImportError(f"{module.__name__} must come from {self._package}, not from {file}")
        return {"agents": made.agents, "envs": made.envs, "floats": made.floats}

    def turn(self, name: str, seconds: float) -> list[float]:
        """Play one turn, and return its times of a step [s]: CPU time and wall time.

        A single-threaded subject gets one fixed processor, since those of a shared machine differ in speed for minutes.
        """
        subject = self._made[name]
        _play_on(_ALL if subject.threads > 1 else {*sorted(_ALL)[-1:]})
        played = subject.turn(seconds)
        _play_on(_ALL)
        return list(played)


def answer(side: Side, request: list[Any]) -> dict[str, Any]:
    """Return the result of the request, or the error in a line."""
    verb, *arguments = request
    try:
        return {"answer": getattr(side, verb)(*arguments)}
    except Exception as error:  # noqa: BLE001 - peers and older versions may raise any error
        return {"error": " ".join(f"{type(error).__name__}: {error}".split())}


def main() -> None:
    """Answer requests until the input ends."""
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # prints of a peer go to stderr, since stdout has the answers
    package, quick, pufferlib = sys.argv[1:]
    side = Side(package, quick=quick == "quick", pufferlib=pufferlib)
    for line in sys.stdin:
        print(json.dumps(answer(side, json.loads(line))), file=out, flush=True)


if __name__ == "__main__":
    main()

"""The current version beside an older commit, in turn: `python scripts/bench --against REF`.

Each version has a process of its own that keeps running and is asked for one timing at a time, so that both of a round
lie within a second: what else the machine does meets both. The older one is used only by what both offer in public.
"""

import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import startup
from checkout import ROOT, checked_out, commit_of, current
from tables import table, times
from wanted import (
    BATCH,
    BESIDE_START,
    BESIDE_TARGET_CONTROL,
    COLD,
    LARGE,
    MANY_HUNTERS,
    MEMORY,
    START,
    TWO_THREADS,
    WARM_START,
    Wanted,
)

WARM, BYTES = "first step, warm", "memory"

ROWS: dict[str, tuple[str, ...]] = {
    "batch": (BATCH, LARGE),
    "threads": (LARGE, f"{LARGE}, two threads"),
    "hunters": ("4 hunters", "64 hunters"),
    "controls": (LARGE, f"{LARGE}, velocity control", f"{LARGE}, full control"),
    "one-arena": tuple(f"one arena, {control} control" for control in ("target", "velocity", "full")),
    "warm": (WARM,),
    "memory": (BYTES,),
    "cold": (COLD,),
}
"""What can be chosen, and what is measured for it."""
_STARTS = (WARM, COLD)
_STEPS = tuple(dict.fromkeys(what for row in ROWS.values() for what in row if what not in {*_STARTS, BYTES}))
_ABSOLUTE = {WARM: WARM_START, BYTES: MEMORY}


class Within(NamedTuple):
    """Two figures of one version beside each other."""

    title: str
    above: str
    below: str
    wanted: Wanted


WITHIN = (
    Within("two threads beside one, on the wall", LARGE, f"{LARGE}, two threads", TWO_THREADS),
    Within("cost of an agent-step with 64 hunters, beside 4", "64 hunters", "4 hunters", MANY_HUNTERS),
    *(
        Within(f"{control} control beside target control", LARGE, f"{LARGE}, {control} control", wanted)
        for control, wanted in BESIDE_TARGET_CONTROL.items()
    ),
)


class UnmeasurableError(Exception):
    """Why a version cannot be measured, in a line."""


class Version:
    """One version, its process, and what was measured of it."""

    def __init__(self, title: str, root: Path, work: Path) -> None:
        self.cpu: dict[str, list[float]] = {}
        """By what was measured, a figure a round: CPU-seconds of a step or of a start; bytes."""
        self.wall: dict[str, list[float]] = {}
        """Seconds of a step on the wall."""
        self._title = title
        self._root = root
        self._words = work / "stderr"
        self._cache = work / "cache"
        self._cache.mkdir(parents=True)
        self._process: Any = None

    @contextmanager
    def running(self, *, quick: bool) -> Iterator[None]:
        """Have its process at hand, in a session of its own: Ctrl-C is for this one alone."""
        command = [sys.executable, str(Path(__file__).with_name("side.py")), self._root, "quick" if quick else "whole"]
        with (
            self._words.open("w") as words,
            subprocess.Popen(
                command,
                cwd=self._root,
                env=self._environment(self._cache),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=words,
                text=True,
                start_new_session=True,
            ) as self._process,
        ):
            try:
                yield
            finally:
                self._process.kill()

    def _environment(self, cache: Path) -> dict[str, str]:
        """With its own package first; bytecode is kept, as it is for users."""
        environment = {**os.environ, "PYTHONPATH": str(self._root), "NUMBA_CACHE_DIR": str(cache)}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        return environment

    def ask(self, *request: object) -> None:
        """Without waiting for the answer."""
        try:
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            self._fail(self._words.read_text())

    def answer(self) -> Any:
        """To what was asked last.

        Raises:
            UnmeasurableError: where a version cannot be measured.
        """
        line = self._process.stdout.readline()
        if not line:
            self._fail(self._words.read_text())
        found = json.loads(line)
        if "error" in found:
            self._fail(found["error"])
        return found["answer"]

    def _fail(self, words: str) -> NoReturn:
        reason = (words.strip().splitlines() or ["its process ended without a word"])[-1]
        raise UnmeasurableError(f"{self._title} cannot be measured: {reason}")

    def time(self, what: str, seconds: float) -> None:
        """One turn."""
        self.ask("time", what, seconds)
        found = self.answer()
        self.cpu.setdefault(what, []).append(found["cpu_s"])
        self.wall.setdefault(what, []).append(found["wall_s"])

    def start(self, what: str) -> None:
        """One process from its beginning to its first step; cold, with nothing compiled before."""
        with tempfile.TemporaryDirectory() as empty:
            spent = self._run(startup.ONE_ARENA, Path(empty) if what == COLD else self._cache)
        self.cpu.setdefault(what, []).append(spent)

    def compile(self, *, warm: bool) -> None:
        """Leave bytecode behind, and for warm starts machine code too."""
        self._run(startup.ONE_ARENA if warm else "import catch_arena as c; c.parallel_env", self._cache)

    def _run(self, code: str, cache: Path) -> float:
        code += f"; assert c.__file__.startswith({str(self._root)!r}), c.__file__"
        try:
            return startup.spent(code, self._environment(cache), self._root)["cpu_s"]
        except subprocess.CalledProcessError as error:
            self._fail(error.stderr.decode())


def measure(ref: str, rows: Sequence[str], rounds: int, seconds: float, *, quick: bool) -> dict[str, Any]:
    """All rounds of the chosen rows.

    Raises:
        UnmeasurableError: where a version cannot be measured.
        CheckoutError: where the commit cannot be checked out.
        KeyboardInterrupt: for SIGTERM too. Nothing is left behind in any case.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    commit, now = commit_of(ref), current()
    with ExitStack() as stack:
        try:
            work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="bench-against-")))
            stack.enter_context(checked_out(commit, work / "older"))
            older = Version(f"{ref} ({commit[:12]})", work / "older", work / "a")
            current_one = Version("the current version", ROOT, work / "b")
            for version in (older, current_one):
                stack.enter_context(version.running(quick=quick))
            _play((older, current_one), {what for row in rows for what in ROWS[row]}, rounds, seconds)
        finally:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)  # a second Ctrl-C would leave the checkout behind
    return {
        "commit": commit,
        "now": now,
        **{name: {"cpu": one.cpu, "wall": one.wall} for name, one in (("before", older), ("after", current_one))},
    }


def _play(versions: tuple[Version, Version], chosen: set[str], rounds: int, seconds: float) -> None:
    """Everything that was chosen; each round of it in the two versions, now one first and now the other."""
    from catch_arena.cli.progress import progress_bar

    steps = [what for what in _STEPS if what in chosen]
    starts = [what for what in _STARTS if what in chosen]
    total = len(steps) + rounds * (len(steps) + len(starts))
    print("compiling both versions", file=sys.stderr)
    with progress_bar("measuring", total) as show:
        turns = iter(range(1, total + 1))
        for what in steps:
            _both(versions, "make", what, seconds)
            show(next(turns), total)
        if BYTES in chosen:
            for version, held in zip(versions, _both(versions, "memory"), strict=True):
                version.cpu[BYTES] = [held]
        if starts:
            for version in versions:
                version.compile(warm=WARM in starts)
        for number in range(rounds):
            order = versions if number % 2 == 0 else versions[::-1]
            for what in (*steps, *starts):
                for version in order:
                    if what in steps:
                        version.time(what, seconds)
                    else:
                        version.start(what)
                show(next(turns), total)


def _both(versions: Sequence[Version], *request: object) -> list[Any]:
    """At once, for what is not timed."""
    for version in versions:
        version.ask(*request)
    return [version.answer() for version in versions]


def written(figures: Mapping[str, Any]) -> str:
    """As Markdown: each version's medians and least times, and how many times as fast the current one is."""
    before, after = figures["before"], figures["after"]
    rows = [
        _beside(what, before["cpu"][what], after["cpu"][what], figures["commit"])
        for what in (*_STEPS, *_STARTS, BYTES)
        if what in before["cpu"]
    ]
    head = ("median (least)", "before", "now", "times as fast", "by least times", "middle half of the rounds", "")
    tables = [table(head, rows)]
    within = [
        (one.title, f"{ratios[0]:.3g}", f"{ratios[1]:.3g}", one.wanted.said(ratios[1]))
        for one in WITHIN
        if {one.above, one.below} <= before["cpu"].keys()
        for ratios in [[_within(one, version) for version in (before, after)]]
    ]
    if within:
        tables.append(table(("within one version", "before", "now", ""), within))
    rounds = max(map(len, before["cpu"].values()))
    now = f"{figures['now']}, on {datetime.now(timezone.utc).date()}"
    text = [
        f"{figures['machine']}. Command: `{figures['command']}`.",
        f"Before: the commit {figures['commit'][:12]}. Now: {now}. Medians of {rounds} rounds, in turn.",
    ]
    return "\n\n".join([*text, *tables]) + "\n"


def _beside(what: str, before: Sequence[float], after: Sequence[float], commit: str) -> tuple[str, ...]:
    unit, factor = _unit(what)
    by_round = sorted(old / new for old, new in zip(before, after, strict=True))
    aside = len(by_round) // 4
    faster = statistics.median(before) / statistics.median(after)
    wanted = []
    if commit == START and what in BESIDE_START:
        wanted.append(BESIDE_START[what].said(faster))
    if what in _ABSOLUTE:
        wanted.append(_ABSOLUTE[what].said(statistics.median(after)))
    return (
        f"{what}, {unit}",
        *(f"{factor * statistics.median(one):,.4g} ({factor * min(one):,.4g})" for one in (before, after)),
        times(faster),
        times(min(before) / min(after)),
        f"{by_round[aside]:.3g} to {by_round[-1 - aside]:.3g}",
        "; ".join(wanted),
    )


def _unit(what: str) -> tuple[str, float]:
    """In which a figure is told, and how many of them a second or a byte is."""
    if what == BYTES:
        return "bytes an arena", 1.0
    if what in _STARTS:
        return "CPU-s", 1.0
    if what in ROWS["one-arena"]:
        return "us a step", 1e6
    return "ns an agent-step", 1e9


def _within(one: Within, version: Mapping[str, Mapping[str, Sequence[float]]]) -> float:
    by = version["wall" if one.wanted is TWO_THREADS else "cpu"]
    return statistics.median(by[one.above]) / statistics.median(by[one.below])

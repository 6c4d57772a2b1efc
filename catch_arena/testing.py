"""Checks that others can run on what they have made: `run_conformance` tries an arbiter, or a whole arena, with the
cases of the conformance suite. docs/conformance.md shows how.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from math import inf

from catch_arena.conformance.answers import DiffersError, Raised, patience
from catch_arena.conformance.arbiters import Arbiter, Court
from catch_arena.conformance.arenas import ArenaUnderTest, Stage, can_be_staged
from catch_arena.conformance.cases import ArbiterCase, WorldCase
from catch_arena.conformance.comparison import Strictness
from catch_arena.conformance.diagnosis import Diagnosis
from catch_arena.conformance.files import load_cases
from catch_arena.conformance.report import Report
from catch_arena.conformance.results import Failure, Result
from catch_arena.errors import ConfigError, suggest

__all__ = ["Arbiter", "ArenaUnderTest", "Diagnosis", "Failure", "Report", "Result", "chosen", "run_conformance"]


def run_conformance(
    adapter: Arbiter | None = None,
    *,
    arena: ArenaUnderTest | None = None,
    only: Sequence[str] = (),
    evidence: bool = True,
    exact_lots: bool = False,
    limit_s: float | None = None,
) -> Report:
    """Try an arbiter, an arena or both with the cases of the suite.

    Args:
        adapter: takes `arbitrate`'s keyword arguments and returns its rulings.
        arena: plays the cases that need one, and those of arbiters that can be staged.
        only: ids or beginnings of ids.
        evidence: false compares verdicts alone.
        exact_lots: requires of lots what the rulebook's appendix draws, where any one of the tied would do.
        limit_s: how long a case may take before it is given up: without a limit, code that loops for ever is waited
            for.

    Returns:
        a report with `passed`, `failures` and `diagnoses`, which are the failures by mistake. Whatever the adapter does
        wrong stands in it.

    Raises:
        ConfigError: where there is nothing to try, or no such case.
    """
    if adapter is None and arena is None:
        raise ConfigError("an arbiter or an arena must be given")
    if limit_s is not None and not 0 < limit_s < inf:
        raise ConfigError(f"limit_s must be a positive number of seconds, got {limit_s!r}")
    strictness = Strictness(evidence=evidence, exact_lots=exact_lots)
    return Report(tuple(_try(case, adapter, arena, strictness, limit_s) for case in chosen(only)), strictness)


def chosen(only: Sequence[str] = ()) -> tuple[ArbiterCase | WorldCase, ...]:
    """The cases with these ids; where a word is no id, those whose ids begin with it; all without words.

    Raises:
        ConfigError: for a word without a case.
    """
    cases = load_cases()
    ids = {case.id for case in cases}
    wanted: set[str] = set()
    for word in only:
        found = {word} & ids or {name for name in ids if name.startswith(word)}
        if not found:
            raise ConfigError(f"no case begins with {word!r}: {suggest(word, ids | {case.group for case in cases})}")
        wanted |= found
    return tuple(case for case in cases if not only or case.id in wanted)


def _try(
    case: ArbiterCase | WorldCase,
    adapter: Arbiter | None,
    arena: ArenaUnderTest | None,
    strictness: Strictness,
    limit_s: float | None,
) -> Result:
    start = time.perf_counter()
    trials: list[tuple[Court | Stage, Callable[[], None]]] = []
    if adapter is not None and isinstance(case, ArbiterCase):
        court = Court(adapter, strictness)
        trials.append((court, partial(court.try_case, case)))
    if arena is not None and (isinstance(case, WorldCase) or can_be_staged(case)):
        stage = Stage(arena, strictness)
        trials.append((stage, partial(stage.play, case)))
    failure: Failure | None = None
    for trial, play in trials:
        try:
            with patience(limit_s):
                play()
        except DiffersError as error:
            failure = Failure(case, trial.how, error.differences)
            break
        except TimeoutError as error:  # between two calls
            failure = Failure(case, trial.how, (Raised("the case", "an answer", str(error), "TimeoutError", ""),))
            break
    calls = [] if not trials else trial.calls if failure else trials[0][0].calls[:1]
    return Result(case, failure, time.perf_counter() - start, played=bool(trials), calls=tuple(calls))

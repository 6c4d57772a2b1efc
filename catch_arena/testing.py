"""Checks that others can run on what they have made: `run_conformance` tries an arbiter, or a whole arena, with the
cases of the conformance suite. docs/conformance.md shows how.
"""

import time
from collections.abc import Callable, Sequence
from math import inf

from catch_arena.conformance.answers import DiffersError, RaisedError, time_limit
from catch_arena.conformance.arbiter_runner import Arbiter, ArbiterRunner
from catch_arena.conformance.arena_runner import ArenaRunner, ArenaUnderTest, fits_into_an_arena
from catch_arena.conformance.case_files import load_cases
from catch_arena.conformance.cases import ArbiterCase, ArenaCase
from catch_arena.conformance.comparison import Strictness
from catch_arena.conformance.diagnosis import Diagnosis
from catch_arena.conformance.report import Report
from catch_arena.conformance.results import Failure, Result, needs
from catch_arena.errors import ConfigError, suggest

__all__ = ["Arbiter", "ArenaUnderTest", "Diagnosis", "Failure", "Report", "Result", "run_conformance", "select_cases"]


def run_conformance(
    adapter: Arbiter | None = None,
    *,
    arena: ArenaUnderTest | None = None,
    only: Sequence[str] = (),
    evidence: bool = True,
    exact_lots: bool = False,
    limit_s: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Report:
    """Try an arbiter, an arena or both with the cases of the suite.

    Args:
        adapter: takes `arbitrate`'s keyword arguments and returns its rulings.
        arena: plays the cases that need one, and those for arbiters that fit into one.
        only: ids or beginnings of ids.
        evidence: false compares verdicts alone.
        exact_lots: requires of lots what the rulebook's appendix draws, where any one of the tied would do.
        limit_s: how long a case may take before it is given up: without a limit, code that loops for ever is waited
            for.
        progress: called with (done, total) after each case.

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
    cases, results = select_cases(only), []
    for case in cases:
        results.append(_run_case(case, adapter, arena, strictness, limit_s))
        if progress is not None:
            progress(len(results), len(cases))
    return Report(tuple(results), strictness)


def select_cases(only: Sequence[str] = ()) -> tuple[ArbiterCase | ArenaCase, ...]:
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


def _run_case(
    case: ArbiterCase | ArenaCase,
    adapter: Arbiter | None,
    arena: ArenaUnderTest | None,
    strictness: Strictness,
    limit_s: float | None,
) -> Result:
    start = time.perf_counter()
    runners: list[ArbiterRunner | ArenaRunner] = []
    if adapter is not None and isinstance(case, ArbiterCase):
        runners.append(ArbiterRunner(adapter, case, strictness))
    if arena is not None and (isinstance(case, ArenaCase) or fits_into_an_arena(case)):
        runners.append(ArenaRunner(arena, case, strictness))
    failure: Failure | None = None
    for runner in runners:
        try:
            with time_limit(limit_s):
                runner.run()
        except DiffersError as error:
            failure = Failure(case, runner.how, error.differences)
            break
        except TimeoutError as error:  # between two calls
            failure = Failure(case, runner.how, (RaisedError("the case", "an answer", str(error), "TimeoutError", ""),))
            break
    return Result(case, failure, time.perf_counter() - start, None if runners else needs(case))

"""Conformance checks for other implementations: `run_conformance` tests an arbiter, or a whole arena, with the cases
of the conformance suite. docs/howto/conformance.md has examples.
"""

import time
from collections.abc import Callable, Sequence
from math import inf
from typing import Final

from catch_arena.conformance.adjudicator_calls import DiffersError, NoRuling, time_limit
from catch_arena.conformance.arbiter_runner import Arbiter, ArbiterRunner, with_any_lots
from catch_arena.conformance.arena_runner import ArenaRunner, ArenaUnderTest, fits_into_an_arena
from catch_arena.conformance.cases import ArbiterCase, ArenaCase, load_cases
from catch_arena.conformance.comparison import Compared
from catch_arena.conformance.report import Report
from catch_arena.conformance.results import Diagnosis, Failure, Result
from catch_arena.errors import ConfigError, suggest

__all__ = ["Arbiter", "ArenaUnderTest", "Diagnosis", "Failure", "Report", "Result", "run_conformance", "select_cases"]

_MOST_LATE: Final = 3
"""Number of late cases after which no other case is played."""


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
    """Test an arbiter, an arena or both with the cases of the conformance suite.

    Args:
        adapter: the arbiter; it takes `arbitrate`'s keyword arguments and returns rulings.
        arena: the arena; it plays the cases for arenas, and the cases for arbiters that fit into an arena.
        only: ids of cases, or beginnings of ids; () means all cases.
        evidence: false to compare verdicts alone.
        exact_lots: true to require the lots of the rulebook's appendix; else any of the tied hunters may win.
        limit_s: time limit of a case [s]; after three late cases the others are not played. With None, an endless loop
            is never ended.
        progress: called with (done, total) after each case.

    Returns:
        a report with `passed`, `failures` and `diagnoses`, which group the failures by mistake. Errors that the adapter
        raises are in it, too.

    Raises:
        ConfigError: without an arbiter and an arena, for an invalid limit, or for a word that matches no case.
    """
    if adapter is None and arena is None:
        raise ConfigError("an arbiter or an arena must be given; in a command as module:function or path.py:function")
    if limit_s is not None and not 0 < limit_s < inf:
        raise ConfigError(f"limit_s must be a positive number of seconds, got {limit_s!r}")
    compared: Compared = "evidence" if evidence else "verdicts"
    cases, results, late = select_cases(only), [], 0
    for case in cases:
        if late == _MOST_LATE:
            why = f"not played after {late} cases without an answer within {limit_s:g} s"
            results.append(Result(case, None, 0.0, why))
            continue
        runners: list[ArbiterRunner | ArenaRunner] = []
        if adapter is not None and isinstance(case, ArbiterCase):
            runners.append(ArbiterRunner(adapter, case if exact_lots else with_any_lots(case), compared))
        if arena is not None and (isinstance(case, ArenaCase) or fits_into_an_arena(case)):
            runners.append(ArenaRunner(arena, case, compared))
        results.append(result := _run_case(case, runners, limit_s))
        late += result.failure is not None and limit_s is not None and result.seconds >= limit_s
        if progress is not None:
            progress(len(results), len(cases))
    return Report(tuple(results), compared)


def select_cases(only: Sequence[str] = ()) -> tuple[ArbiterCase | ArenaCase, ...]:
    """Return the cases with these ids, or whose ids begin with a word that is no id; all cases without words."""
    cases = load_cases()
    ids = {case.id for case in cases}
    wanted: set[str] = set()
    for word in only:
        found = {word} & ids or {name for name in ids if name.startswith(word)}
        if not found:
            raise ConfigError(f"no case begins with {word!r}: {suggest(word, {case.group for case in cases})}")
        wanted |= found
    return tuple(case for case in cases if not only or case.id in wanted)


def _run_case(
    case: ArbiterCase | ArenaCase, runners: Sequence[ArbiterRunner | ArenaRunner], limit_s: float | None
) -> Result:
    start = time.perf_counter()
    failure: Failure | None = None
    for runner in runners:
        try:
            with time_limit(limit_s):
                runner.run()
        except DiffersError as error:
            failure = Failure(case, runner.variation, error.differences)
            break
        except TimeoutError as error:  # the limit can also pass between two calls
            late = NoRuling("the case", "an answer", str(error), "TimeoutError is raised")
            failure = Failure(case, runner.variation, (late,))
            break
    left_out = f"not played without an {'arbiter' if isinstance(case, ArbiterCase) else 'arena'}"
    return Result(case, failure, time.perf_counter() - start, "" if runners else left_out)

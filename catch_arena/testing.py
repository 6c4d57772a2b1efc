"""Checks that others can run on what they have made: `run_conformance` tries an arbiter, or a whole arena, with the
cases of the conformance suite. docs/conformance.md shows how.
"""

import time
from collections.abc import Sequence

from catch_arena.conformance.answers import DiffersError
from catch_arena.conformance.arbiters import Arbiter, Court
from catch_arena.conformance.arenas import ArenaUnderTest, Stage, can_be_staged
from catch_arena.conformance.cases import ArbiterCase, WorldCase
from catch_arena.conformance.comparison import Strictness
from catch_arena.conformance.files import load_cases
from catch_arena.conformance.report import Failure, Report, Result
from catch_arena.errors import ConfigError, suggest

__all__ = ["Arbiter", "ArenaUnderTest", "Failure", "Report", "Result", "chosen", "run_conformance"]


def run_conformance(
    adapter: Arbiter | None = None,
    *,
    arena: ArenaUnderTest | None = None,
    only: Sequence[str] = (),
    evidence: bool = True,
    exact_lots: bool = False,
) -> Report:
    """Try an arbiter, an arena or both with the cases of the suite.

    Args: `adapter` takes `arbitrate`'s keyword arguments and returns its rulings; `arena` plays the cases that need
    one, and those of arbiters that can be staged; `only`, ids or beginnings of ids; `evidence` false compares verdicts
    alone; `exact_lots` requires of lots what the rulebook's appendix draws, where any one of the tied would do.
    Returns: a report with `passed` and `failures`. Whatever the adapter does wrong stands in it.
    Raises: ConfigError where there is nothing to try, or no such case.
    """
    if adapter is None and arena is None:
        raise ConfigError("an arbiter or an arena must be given")
    strictness = Strictness(evidence=evidence, exact_lots=exact_lots)
    return Report(tuple(_try(case, adapter, arena, strictness) for case in chosen(only)))


def chosen(only: Sequence[str] = ()) -> tuple[ArbiterCase | WorldCase, ...]:
    """The cases with these ids; where a word is no id, those whose ids begin with it; all without words.

    Raises: ConfigError for a word without a case.
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
    case: ArbiterCase | WorldCase, adapter: Arbiter | None, arena: ArenaUnderTest | None, strictness: Strictness
) -> Result:
    start = time.perf_counter()
    played, failure = False, None
    if adapter is not None and isinstance(case, ArbiterCase):
        court = Court(adapter, strictness)
        played = True
        try:
            court.try_case(case)
        except DiffersError as error:
            failure = Failure(case, court.how, error.differences)
    if arena is not None and failure is None and (isinstance(case, WorldCase) or can_be_staged(case)):
        stage = Stage(arena, strictness)
        played = True
        try:
            stage.play(case)
        except DiffersError as error:
            failure = Failure(case, stage.how, error.differences)
    return Result(case, failure, time.perf_counter() - start, played)

"""Grading of all submissions of a class, each kept in a file as soon as it is graded: the same command continues."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Final

import msgspec

from catch_arena.classroom.moments import merit, worst_moment
from catch_arena.classroom.submissions import Submission
from catch_arena.config import RULESET
from catch_arena.errors import AgentError, MatchFailedError
from catch_arena.files import prepare_folder, write_whole
from catch_arena.player.moments import Moment
from catch_arena.replay.fileformat import decode_replay
from catch_arena.text import last_lines
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.block_queue import do_in_order
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.grading import GradedMatch, TestGrade, grade_agent, unplayed_grade
from catch_arena.tournament.grading_spec import GradingSpec
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import enter

KEPT: Final = "json"
"""Folder of the kept grades, in the folder of results."""


class Graded(msgspec.Struct, frozen=True, kw_only=True):
    """Grades of one submission."""

    name: str
    digest: str
    key: str = ""
    """Digest of the submission and of all by which it is graded."""
    grades: tuple[TestGrade, ...]
    fault: str | None = None
    """Reason for which it was not graded, which is not the student's fault; None if it was."""
    log: str = ""
    """End of the agent's output: in its worst match, or from its start if it cannot begin."""
    moment: Moment | None = None

    @property
    def points(self) -> float:
        """Points of all tests."""
        return sum((grade.points for grade in self.grades), 0.0)

    @property
    def possible(self) -> float:
        """Largest possible number of points."""
        return sum((grade.possible for grade in self.grades), 0.0)


def grade_submission(
    worker: Worker, spec: GradingSpec, opponents: Sequence[Sequence[Entrant]], submission: Submission
) -> Graded:
    """Play all tests of a spec with a submission, in this process, each against its own `opponents`.

    Raises:
        MatchFailedError: if a match could not be held.
    """
    try:
        (student,) = enter([submission.agent], worker.sandbox)
    except (AgentError, OSError) as error:  # no agent, such as a notebook, or a file that cannot be read
        why = str(error).replace(f"{submission.path.parent}/", "")
        grades = tuple(unplayed_grade(test, why, hinted=False) for test in spec.tests)
        return Graded(name=submission.name, digest=submission.digest(), grades=grades)
    if student.fault is not None:
        grades = tuple(unplayed_grade(test, student.fault) for test in spec.tests)
        return Graded(name=submission.name, digest=student.digest, grades=grades, log=student.log)
    student = replace(student, name=submission.name)
    found: list[tuple[TestGrade, GradedMatch]] = []
    try:
        for test, others in zip(spec.tests, opponents, strict=True):
            grade, played = grade_agent(spec, test, student, others, worker.sandbox)
            found.append((grade, worst_match(played, Parties.of(test.config).hunting)))
    finally:
        worker.close()  # no process of a student waits for the next one
    _, (party, result, replay) = max(found, key=lambda one: (bool(one[0].failures), one[0].possible))
    return Graded(
        name=submission.name,
        digest=student.digest,
        grades=tuple(grade for grade, _ in found),
        log=last_lines(result.logs[party]),
        moment=worst_moment(decode_replay(replay), party, result),
    )


def worst_match(played: Sequence[GradedMatch], hunting: int) -> GradedMatch:
    """Return the first match in which an agent failed, or else the one in which it did worst."""
    return min(played, key=lambda one: merit(one.result, one.party, hunting))


def spec_key(spec: GradingSpec, quotas: Quotas, opponents: Sequence[Sequence[Entrant]]) -> str:
    """Return a digest of everything besides the submission that a grade depends on."""
    parts = (spec.title, spec.tests, spec.secret.digits, spec.launch, RULESET, version("catch-arena"), quotas.numbers())
    rivals = [[opponent.digest for opponent in others] for others in opponents]
    return hashlib.blake2b(msgspec.json.encode((parts, rivals)), digest_size=16).hexdigest()


def grade_class(
    submissions: Sequence[Submission],
    grade: Callable[[Submission], Graded],
    executor: Executor,
    folder: Path,
    spec_key: str,
) -> Iterator[tuple[Graded, bool]]:
    """Yield the grades of all submissions, and whether they were kept by an earlier run; such grades come first.

    Each is kept in a file as soon as it is made, with `spec_key`, the digest of everything else that it depends on.
    `do_in_order` grades a submission again that fails on our side.
    """
    kept = prepare_folder(folder / KEPT)
    keys = {one.name: f"{spec_key}-{one.digest()}" for one in submissions}
    waiting: list[Submission] = []
    for submission in submissions:
        before: Graded | None = None
        with suppress(OSError, ValueError):  # there is none, or one of another version
            before = msgspec.json.decode((kept / f"{submission.name}.json").read_bytes(), type=Graded)
        if before is not None and before.key == keys[submission.name]:
            yield before, True
        else:
            waiting.append(submission)

    def begin(submission: Submission) -> Future[Graded]:
        return executor.run(_grade_and_keep, grade, submission, kept, keys[submission.name])

    for submission, graded in do_in_order(waiting, executor, begin):
        if isinstance(graded, MatchFailedError):
            yield Graded(name=submission.name, digest=submission.digest(), grades=(), fault=str(graded)), False
        else:
            yield graded, False


def _grade_and_keep(grade: Callable[[Submission], Graded], submission: Submission, kept: Path, key: str) -> Graded:
    """Grade a submission, write its grades to a file, and return them: an interrupt loses no grade."""
    graded = msgspec.structs.replace(grade(submission), key=key)
    write_whole(kept / f"{submission.name}.json", msgspec.json.encode(graded))
    return graded

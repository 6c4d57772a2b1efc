"""Grading of a class by `catch-arena grade FOLDER`: progress, lines, and the files of results."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from catch_arena.classroom.grading import KEPT, Graded, grade_class, grade_submission, spec_key
from catch_arena.classroom.marks import MARKS, write_marks
from catch_arena.classroom.nodes import grade_node_of
from catch_arena.classroom.similarity import similar_pairs
from catch_arena.classroom.student_page import student_page
from catch_arena.classroom.submissions import Submission, find_submissions
from catch_arena.cli.bus import SERVICE, NodeUnderTestOptions
from catch_arena.cli.hand_ins import ClassOptions
from catch_arena.cli.options import Trust, print_level, require_isolation
from catch_arena.cli.outputs import require_free
from catch_arena.cli.terminal import echo, noting_kept_results, progress_bar
from catch_arena.errors import ConfigError
from catch_arena.files import prepare_folder, write_whole
from catch_arena.ros.node_tests.cases import cases_of
from catch_arena.tournament.execution.block_queue import do_here
from catch_arena.tournament.execution.executors import Executor, Worker, local_executor
from catch_arena.tournament.grading import enter_opponents
from catch_arena.tournament.grading_spec import GradingSpec
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.store import only_one_plays_in

_Grading = tuple[Callable[[Submission], Graded], str, Executor]
"""Function that grades a submission, digest of all else that a grade depends on, and executor of the function."""


def grade_folder(
    exercise: GradingSpec,
    folder: Path,
    students: ClassOptions,
    trust: Trust,
    service: NodeUnderTestOptions,
    *,
    force: bool,
) -> bool:
    """Grade all submissions in a folder, write the results, and return whether all could be graded."""
    submissions, others = find_submissions(folder)
    out = students.out or Path(f"{folder.absolute().name}_{exercise.path.stem}_grades")
    if out.resolve().is_relative_to(folder.resolve()):
        raise ConfigError(f"--out must be outside of the submissions' folder, got {out}")
    if not (out / KEPT).is_dir():
        require_free(out / MARKS, force=force)
    if students.ros:
        grade_one, key, opened = _node_grading(exercise, students, service)
    else:
        service.refuse()
        grade_one, key, opened = _agent_grading(exercise, students, trust, len(submissions))
    for other in others:
        echo(f"warning: {folder / other} is no submission, and is not graded", err=True)
    deadline = None if students.deadline is None else students.deadline.astimezone()
    by_name = {one.name: one for one in submissions}
    pages = prepare_folder(out / "pages")
    graded: dict[str, Graded] = {}
    before = 0
    with (
        only_one_plays_in(out),
        noting_kept_results("what was graded is kept; the same command continues"),
        opened as executor,
        progress_bar("grading", len(submissions)) as show,
    ):
        for one, known in grade_class(submissions, grade_one, executor, out, key):
            graded[one.name] = one
            page = student_page(exercise.title, one, by_name[one.name].changed, deadline)
            write_whole(pages / f"{one.name}.html", page.encode())
            points = f"not graded: {one.fault}" if one.fault else f"{one.points:g} of {one.possible:g} points"
            echo(f"{one.name}: {points}{', as graded before' if known else ''}")
            before += known
            show(len(graded) - before, len(submissions) - before)
    pairs = similar_pairs(submissions)
    for pair in pairs:
        echo(f"look at these two: {pair.first} and {pair.second}: {pair}")
    write_marks(out, graded, submissions, [test.name for test in exercise.tests], pairs, deadline)
    echo(f"marks: {out / MARKS}")
    echo(f"pages: {pages}")
    return not any(one.fault for one in graded.values())


def _agent_grading(exercise: GradingSpec, students: ClassOptions, trust: Trust, submissions: int) -> _Grading:
    """Return the function that grades an agent, the digest of what it depends on, and the executor for it."""
    quotas = trust.quotas()
    if quotas is None:
        raise ConfigError("--trusted must be left out with a class: one submission that hangs would stop all others")
    require_isolation("grading of a class")
    if not exercise.has_seed:
        raise ConfigError(
            f"{exercise.path}: a class needs seed or seed_file, so that all students play the same matches"
        )
    jobs = min(students.workers, submissions)
    with sandbox_for(quotas) as sandbox:
        rivals = do_here(enter_opponents, exercise, sandbox)
    print_level(quotas, ["a submission"])
    worker = Worker(exercise.tests[0].config, (), quotas=quotas)
    grade_one = partial(grade_submission, worker, exercise, rivals)
    return grade_one, spec_key(exercise, quotas, rivals), local_executor(worker, jobs)


def _node_grading(exercise: GradingSpec, students: ClassOptions, service: NodeUnderTestOptions) -> _Grading:
    """Return these three for ROS 2 nodes, which are graded one after the other."""
    if students.jobs is not None:
        raise ConfigError("--jobs must be left out with --ros: nodes are graded one after the other")
    if not exercise.launch:
        raise ConfigError(f'{exercise.path}: launch must be given for --ros, as in launch = "python3 node.py"')
    try:
        for test in exercise.tests:
            cases_of(test)
    except ConfigError as error:
        raise ConfigError(f"{exercise.path}: {error}") from None
    worker = Worker(exercise.tests[0].config, ())
    grade_one = partial(grade_node_of, worker, exercise, partial(service.node, f"{SERVICE}/catch_turtle"))
    return grade_one, spec_key(exercise, Quotas(), ()), Executor()

"""`catch-arena new-agent`, `check-agent`, `grade`, `new-class`: an agent to begin with, its check, and grades."""

from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from catch_arena.classroom.starters import write_agent_kit, write_sample_class
from catch_arena.classroom.submissions import is_class
from catch_arena.cli.app import EXIT_NO, main
from catch_arena.cli.bus import SERVICE, NodeUnderTestOptions
from catch_arena.cli.options import (
    Agent,
    Arena,
    Processes,
    SettingOption,
    Trust,
    print_level,
    refuse,
    scenario_option,
)
from catch_arena.cli.outputs import Force, Json, Junit, reserve_file
from catch_arena.cli.terminal import echo, progress_bar
from catch_arena.errors import ConfigError
from catch_arena.files import write_whole
from catch_arena.scenarios import SCENARIOS
from catch_arena.tournament.grading_spec import GradingSpec, read_spec
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.players import enter

if TYPE_CHECKING:
    from catch_arena.tournament.grading import TestGrade


@main.command(name="check-agent")
def check_agent(
    agent: Agent,
    *,
    scenarios: Annotated[list[str] | None, scenario_option("; may be repeated", "all")] = None,
    trust: Trust,
    settings: SettingOption = None,
) -> None:
    """Check an agent: it plays against itself, and its faults are shown.

    The exit code is 1 if it would forfeit, else 0.
    """
    from catch_arena.tournament.agent_check import check_fitness
    from catch_arena.tournament.execution.block_queue import do_here
    from catch_arena.tournament.match_loop import play_entrants

    arenas = {name: Arena(name, settings).config() for name in scenarios or SCENARIOS}
    quotas = trust.quotas()
    errors = 0
    with sandbox_for(quotas) as sandbox, progress_bar("playing") as show:
        (entrant,) = do_here(enter, [agent], sandbox)
        print_level(quotas, [entrant.spec])
        for finding in check_fitness(entrant, arenas, sandbox, show, partial(do_here, play_entrants)):
            errors += finding.level == "error"
            echo(f"{finding.level + ':':9}" + finding.text.replace("\n", "\n" + " " * 9))
    if errors:
        raise typer.Exit(EXIT_NO)
    echo(f"{entrant.name} is fit to play")


@dataclass(frozen=True)
class ClassOptions(Processes):
    """Options for a folder of submissions."""

    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for marks.csv and the pages; submissions that it has the grades of are not graded again.",
            show_default="FOLDER_SPEC_grades",
        ),
    ] = None
    deadline: Annotated[
        datetime | None,
        typer.Option(
            metavar="TIME",
            formats=["%Y-%m-%d", "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M", "%Y-%m-%dT%H:%M:%S"],
            help="Deadline in local time, such as 2026-11-30T18:00: marks.csv has how late each submission is.",
        ),
    ] = None
    ros: Annotated[
        bool,
        typer.Option(
            "--ros",
            help="The submissions are ROS 2 nodes: the spec's line launch starts each, in its sub-folder.",
        ),
    ] = False


@main.command()
def grade(
    agent: Annotated[
        str,
        typer.Argument(
            metavar="AGENT",
            help="An agent (see `catch-arena docs agents`), or a folder with a file or sub-folder for each student.",
        ),
    ],
    *,
    spec: Annotated[Path, typer.Option(metavar="FILE", help="Spec of the tests (see `catch-arena docs grading`).")],
    junit: Junit = None,
    json: Json = None,
    seeds: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the seeds of all matches as JSON: for teachers, not for students."),
    ] = None,
    force: Force = False,
    students: ClassOptions,
    trust: Trust,
    service: NodeUnderTestOptions,
) -> None:
    """Grade an agent or a class by a spec: thresholds, hidden seeds, points, and hints by rule.

    The exit code is 0 if every test passed, else 1. For a class it is 0 if all could be graded, whatever their marks;
    the same command continues after Ctrl-C. To grade a ROS 2 node instead of an agent, give its service as
    ros:/catch_turtle: the cases of the spec are sent to it (see `catch-arena docs grade_ros_node`). --interfaces
    and --bus are for nodes only.
    """
    from catch_arena.tournament.grading import json_text, junit_text, seeds_text

    exercise = read_spec(spec)
    for path, ending in ((junit, ".xml"), (json, ".json"), (seeds, ".json")):
        reserve_file(path, ending, force=force)
    if is_class(agent):
        if junit is not None or json is not None:
            raise ConfigError("--junit and --json must be left out with a class: DIR/json has the grades")
        from catch_arena.cli.class_grading import grade_folder

        passed = grade_folder(exercise, Path(agent), students, trust, service, force=force)
    else:
        refuse(students, "a folder of submissions, a file or sub-folder each")
        name, digest, grades = (
            _grade_service(exercise, agent, service, seeds)
            if agent.startswith(SERVICE)
            else _grade_agent(exercise, agent, trust, service)
        )
        points, possible = sum(grade.points for grade in grades), sum(grade.possible for grade in grades)
        echo(f"{exercise.title}: {name} has {points:g} of {possible:g} points")
        if junit is not None:
            write_whole(junit, junit_text(exercise, name, grades).encode())
        if json is not None:
            write_whole(json, json_text(exercise, name, digest, grades).encode())
        passed = not any(grade.failures for grade in grades)
    if seeds is not None:
        write_whole(seeds, seeds_text(exercise).encode(), private=True)
    if not passed:
        raise typer.Exit(EXIT_NO)


def _grade_service(
    exercise: GradingSpec, agent: str, service: NodeUnderTestOptions, seeds: Path | None
) -> "tuple[str, None, list[TestGrade]]":
    """Ask the tests' cases of a node, print each grade, and return the node's name, no digest, and the grades."""
    from catch_arena.ros.node_tests.cases import grade_node

    if seeds is not None:
        raise ConfigError("--seeds must be left out with a service: conformance cases have no seeds")
    grades: list[TestGrade] = []
    with service.node(agent) as node:
        for grade in grade_node(exercise, node):
            grades.append(grade)
            echo(str(grade))
    return agent, None, grades


def _grade_agent(
    exercise: GradingSpec, agent: str, trust: Trust, service: NodeUnderTestOptions
) -> "tuple[str, str, list[TestGrade]]":
    """Play the tests, print each grade, and return the agent's name and digest, and the grades."""
    from catch_arena.tournament.execution.block_queue import do_here
    from catch_arena.tournament.grading import enter_opponents, grade_agent
    from catch_arena.tournament.match_loop import play_entrants

    service.refuse()
    quotas = trust.quotas()
    grades: list[TestGrade] = []
    play = partial(do_here, play_entrants)
    with sandbox_for(quotas) as sandbox:
        rivals = do_here(enter_opponents, exercise, sandbox)
        (student,) = do_here(enter, [agent], sandbox)
        print_level(quotas, [student.spec])
        for test, opponents in zip(exercise.tests, rivals, strict=True):
            with progress_bar(test.name, test.matches) as show:
                grade, _ = grade_agent(exercise, test, student, opponents, sandbox, show, play)
            grades.append(grade)
            echo(str(grade))
    return student.name, student.digest, grades


@main.command(name="new-agent")
def new_agent(
    folder: Annotated[Path, typer.Argument(metavar="NAME", help="Folder to make; its name is the agent's name.")],
) -> None:
    """Write an agent that plays, with a test, a README, a spec, and a workflow file that grades it."""
    for path in write_agent_kit(folder):
        echo(str(path))


@main.command(name="new-class")
def new_class(folder: Annotated[Path, typer.Argument(metavar="NAME", help="Folder to make.")]) -> None:
    """Write a sample class: a spec, and five submissions to grade."""
    for path in write_sample_class(folder):
        echo(str(path))

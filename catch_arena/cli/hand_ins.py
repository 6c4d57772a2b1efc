"""`catch-arena check-agent` and `grade`: check and grade of one submitted agent."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from catch_arena.cli.app import EXIT_NO, main
from catch_arena.cli.bus import SERVICE, NodeUnderTestOptions
from catch_arena.cli.options import MAX_FORFEITS, Agent, SettingOption, Trust, arena, print_level
from catch_arena.cli.outputs import Force, output_file
from catch_arena.cli.terminal import echo
from catch_arena.errors import ConfigError
from catch_arena.scenarios import SCENARIOS

if TYPE_CHECKING:
    from catch_arena.tournament.grading import TestGrade
    from catch_arena.tournament.grading_spec import GradingSpec
    from catch_arena.tournament.isolation.quotas import Quotas


@main.command(name="check-agent")
def check_agent(
    agent: Agent,
    *,
    scenarios: Annotated[
        list[str] | None,
        typer.Option("--scenario", "-s", metavar="NAME", help="Scenario to play; may be repeated.", show_default="all"),
    ] = None,
    trust: Trust,
    settings: SettingOption = None,
) -> None:
    """Check an agent: it plays against itself, and its faults are shown.

    The exit code is 1 if it would forfeit, else 0.
    """
    from catch_arena.cli.progress import progress_bar
    from catch_arena.tournament.agent_check import check_fitness
    from catch_arena.tournament.agent_spec import resolve_spec
    from catch_arena.tournament.isolation.playing import sandbox_for

    arenas = {name: arena(name, settings) for name in scenarios or SCENARIOS}
    quotas = trust.quotas()
    errors = 0
    with sandbox_for(quotas) as sandbox, progress_bar("playing", late=True) as show:
        for number, finding in enumerate(check_fitness(agent, arenas, 0, sandbox, show)):
            if number == 0:  # the agent could be entered, so its spec is valid
                print_level(quotas, [resolve_spec(agent)])
            errors += finding.level == "error"
            echo(f"{finding.level + ':':9}" + finding.text.replace("\n", "\n" + " " * 9))
    if errors:
        raise typer.Exit(EXIT_NO)
    echo(f"{agent} is fit to play")


@main.command()
def grade(
    agent: Agent,
    *,
    spec: Annotated[Path, typer.Option(metavar="FILE", help="Spec of the tests (see `catch-arena docs grading`).")],
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the grades as JUnit XML.")] = None,
    json: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the grades as JSON.")] = None,
    seeds: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the seeds of all matches as JSON: for teachers, not for students."),
    ] = None,
    force: Force = False,
    trust: Trust,
    service: NodeUnderTestOptions,
) -> None:
    """Grade an agent by a spec: thresholds, hidden seeds, points, and hints by rule.

    The exit code is 0 if every test passed, else 1. To grade a ROS 2 node instead of an agent, give its service as
    ros:/catch_turtle: the cases of the spec are sent to it (see `catch-arena docs grade_ros_node`). --interfaces,
    --bus and --url are for nodes only.
    """
    from catch_arena.files import write_whole
    from catch_arena.tournament.grading import json_text, junit_text, seeds_text
    from catch_arena.tournament.grading_spec import read_spec

    exercise = read_spec(spec)
    for path, ending in ((junit, ".xml"), (json, ".json"), (seeds, ".json")):
        if path is not None:
            output_file(path, ending, force=force)
    grades: list[TestGrade] = []
    if agent.startswith(SERVICE):
        from catch_arena.ros.node_tests.grading import grade_node

        if seeds is not None:
            raise ConfigError("--seeds must be left out with a service: conformance cases have no seeds")
        name, digest = agent, None
        with service.node(agent) as node:
            for test_grade in grade_node(exercise, node):
                grades.append(test_grade)
                echo(str(test_grade))
    else:
        service.refuse()
        for test in exercise.tests:
            if test.cases:
                raise ConfigError(
                    f"{spec}: {test.name}: only a node can play cases; give its service, such as ros:/catch_turtle"
                )
        name, digest = _grade_agent(exercise, agent, trust.quotas(), spec, grades)
    points, possible = sum(grade.points for grade in grades), sum(grade.possible for grade in grades)
    echo(f"{exercise.title}: {name} has {points:g} of {possible:g} points")
    if junit is not None:
        write_whole(junit, junit_text(exercise, name, grades).encode())
    if json is not None:
        write_whole(json, json_text(exercise, name, digest, grades).encode())
    if seeds is not None:
        write_whole(seeds, seeds_text(exercise).encode(), private=True)
    if any(grade.failures for grade in grades):
        raise typer.Exit(EXIT_NO)


def _grade_agent(
    exercise: "GradingSpec",
    agent: str,
    quotas: "Quotas | None",
    spec: Path,
    grades: "list[TestGrade]",
) -> tuple[str, str | None]:
    """Play the tests, print each grade and add it to `grades`, and return the agent's name and digest."""
    from catch_arena.cli.progress import progress_bar
    from catch_arena.tournament.entrants import enter
    from catch_arena.tournament.grading import grade_agent
    from catch_arena.tournament.isolation.playing import inspector, sandbox_for

    with sandbox_for(quotas) as sandbox:
        inspect = inspector(sandbox)
        (student,) = enter([agent], inspect)
        print_level(quotas, [student.spec])
        for test in exercise.tests:
            opponents = enter(test.opponents, inspect)
            for opponent_spec, opponent in zip(test.opponents, opponents, strict=True):
                if opponent.fault is not None:
                    raise ConfigError(f"{spec}: {test.name}: opponent {opponent_spec} cannot play: {opponent.fault}")
            with progress_bar(test.name, test.matches) as show:
                grades.append(grade_agent(exercise, test, student, opponents, sandbox, MAX_FORFEITS, show))
            echo(str(grades[-1]))
    return student.name, student.digest

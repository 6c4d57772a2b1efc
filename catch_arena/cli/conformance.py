"""`catch-arena conformance`: test of an arbiter with the cases of the conformance suite."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from catch_arena.cli.app import EXIT_NO, main
from catch_arena.cli.bus import SERVICE, NodeUnderTestOptions
from catch_arena.cli.options import listing_option
from catch_arena.cli.outputs import Force, Junit, reserve_file
from catch_arena.cli.terminal import echo, progress_bar
from catch_arena.errors import AgentError, ConfigError, reason, suggest
from catch_arena.files import write_whole
from catch_arena.tournament.loading import load_file, load_module

_LIMIT_S = 60.0
"""Time limit of a case [s]; a case that takes longer fails, and after three of them no other is played."""


@main.command()
def conformance(
    arbiter: Annotated[
        str | None,
        typer.Argument(
            metavar="ARBITER",
            help="module:function, path.py:function, or ros:/catch_turtle, a service on a ROS 2 bus.",
            show_default=False,
        ),
    ] = None,
    *,
    arena: Annotated[
        str | None, typer.Option(metavar="module:Class", help="Arena for the cases that need one.")
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="ID", help="Play only this case, or all cases whose ids begin with it; may be repeated."),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="Show every failure in full, instead of one for each kind of mistake.")
    ] = False,
    junit: Junit = None,
    force: Force = False,
    verdicts_only: Annotated[
        bool, typer.Option("--verdicts-only", help="Do not compare distances and winners.")
    ] = False,
    listing: Annotated[bool, listing_option("the cases")] = False,
    service: NodeUnderTestOptions,
) -> None:
    """Test an arbiter with the conformance suite: exit code 0 if it answers every case as the rulebook does, else 1.

    An arbiter is a function with the arguments and the result of catch_arena.arbitrate; `catch-arena docs conformance`
    has an example. A ROS 2 node plays only the cases that fit its service (see `catch-arena docs grade_ros_node`).
    --interfaces and --bus are for nodes only.
    """
    from catch_arena.conformance.results import wrapped
    from catch_arena.testing import run_conformance, select_cases

    if listing:
        for case in select_cases(only or ()):
            echo(f"{case.id} ({', '.join(case.clauses)}): {case.situation}")
        return
    reserve_file(junit, ".xml", force=force)
    if arbiter is not None and arbiter.startswith(SERVICE):
        from catch_arena.ros.node_tests.cases import run_on_node

        if arena is not None:
            raise ConfigError("--arena must be left out with a service, which answers yes or no")
        with service.node(arbiter) as node:
            node.wait_for_node()
            report = run_on_node(node, select_cases(only or ()))
    else:
        service.refuse()
        tried = None if arbiter is None else _callable(arbiter)
        if isinstance(tried, type):
            raise AgentError(f"{arbiter}: is a class, but an arbiter is a function; check agents with check-agent")
        made = None if arena is None else _make(arena)
        with progress_bar("cases") as show:
            report = run_conformance(
                tried,
                arena=made,
                only=only or (),
                evidence=not verdicts_only,
                limit_s=_LIMIT_S,
                progress=show,
            )
    echo(report.in_full() if everything else str(report))
    if report.failures and not everything:
        first = report.diagnoses[0].failures[0].case.id
        echo(wrapped(f"--all shows every failure in full, --only {first} plays one case."))
    if junit is not None:
        write_whole(junit, report.junit().encode())
        echo(f"JUnit XML: {junit}")
    if not report.passed:
        raise typer.Exit(EXIT_NO)


def _make(spec: str) -> Any:
    """Return the arena that a class or a function without arguments makes."""
    make = _callable(spec)
    try:
        return make()
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{spec}: creating the arena raised {reason(error)}") from error


def _callable(spec: str) -> Any:
    """Return the function or class that «module:function» or «path.py:function» names."""
    module_name, colon, name = spec.rpartition(":")
    if not (module_name and colon and name):
        raise AgentError(f"{spec}: must be module:function or path.py:function")
    if module_name.endswith(".py"):
        if not Path(module_name).is_file():
            raise AgentError(f"{spec}: no such file")
        module = load_file(Path(module_name))
    else:
        sys.path.append(str(Path.cwd()))  # an arbiter is the user's own, unlike an agent
        module = load_module(module_name)
    found = getattr(module, name, None)
    if not callable(found):
        known = [other for other, value in vars(module).items() if callable(value) and not other.startswith("_")]
        raise AgentError(f"{spec}: has no function {name}; {suggest(name, known)}")
    return found

"""The command line's frame: the application, its errors, and the options that commands share.

What is heavy (the engine, the renderer) is imported by the commands that need it: --help must be quick.
"""

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import wraps
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, NoReturn, TypeVar, cast

import typer
from typer.core import TyperGroup

from catch_arena import interrupts
from catch_arena.cli.arguments import blank_argument
from catch_arena.cli.outputs import reservations
from catch_arena.cli.terminal import HELP_OPTIONS, fit_help, folded, let_all_be_written, own_streams, say
from catch_arena.cli.usage_errors import usage_error
from catch_arena.config import ArenaConfig
from catch_arena.errors import CatchArenaError, ConfigError
from catch_arena.scenarios import scenario
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.secret import Secret

if TYPE_CHECKING:
    from catch_arena.tournament.entrants import Entrant, Inspection

_EXIT_ERROR = 2
_FILES: Final = ("output", "json", "junit", "seeds", "record")
"""The options that name a file to write. An empty name has become the path of this folder when a command has it."""
_Function = TypeVar("_Function", bound=Callable[..., Any])
_UsageError = cast(type[Exception], typer.BadParameter.__bases__[0])
"""Click's, which newer versions of typer carry inside."""


GROUPS: Final = {
    "Play": ("match", "play", "watch", "agents", "scenarios", "docs"),
    "Look": ("explain", "verify", "diff", "render", "highlights", "mosaic"),
    "Tournaments": ("tournament", "report", "export", "compare", "suite"),
    "Teach": ("check-agent", "grade", "conformance"),
    "ROS 2": ("ros",),
}
"""Every command, as the help of the program lists them."""


def _in_words(error: OSError) -> str:
    if error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, FileNotFoundError):  # os.getcwd
        return "the working folder was deleted: go to another one"
    return f"the output cannot be written: {error.strerror or error}"


class _Commands(TyperGroup):
    """Prints each error as one line, with a hint if there is one, and exits as docs/command_line.md says."""

    def list_commands(self, ctx: Any) -> list[str]:
        """In the order of GROUPS, each in the box of its own."""
        del ctx
        for group, names in GROUPS.items():
            for name in names:
                self.commands[name].rich_help_panel = group  # type: ignore[attr-defined]
        return [name for names in GROUPS.values() for name in names]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """By group where there are no boxes too."""
        del ctx
        for group, names in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(name, self.commands[name].get_short_help_str()) for name in names])

    def main(self, *args: Any, **kwargs: Any) -> NoReturn:
        """Read the command line, run the command, and exit."""
        let_all_be_written()
        fit_help(self)
        with own_streams():
            try:
                sys.exit(super().main(*args, **{**kwargs, "standalone_mode": False}))
            except _UsageError as error:
                if type(error).__name__ == "NoArgsIsHelpError":  # the help, which Rich has printed already
                    say(str(error))
                else:
                    text, command = usage_error(error)
                    say(f"error: {text}", err=True)
                    if command is not None:
                        say(f"hint: {command} --help", err=True)
            except OSError as error:
                with suppress(OSError):  # stderr may be full too
                    say(f"error: {_in_words(error)}", err=True)
            sys.exit(_EXIT_ERROR)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was named."""
        try:
            with reservations():
                return super().invoke(ctx)
        except CatchArenaError as error:
            if not interrupts.received():  # else it is no news that something fails
                say(f"error: {error}", err=True)
                if error.hint:
                    say(f"hint: {error.hint}", err=True)
            raise typer.Exit(_EXIT_ERROR) from None


class Program(typer.Typer):
    """Commands whose paths are absolute from the start: a trusted agent may leave our working folder."""

    def command(self, *args: Any, **kwargs: Any) -> Callable[[_Function], _Function]:
        """Register a command, as of `typer.Typer`."""
        register = super().command(*args, **kwargs)

        def decorate(command: _Function) -> _Function:
            @wraps(command)
            def run(**given: Any) -> Any:
                for name in _FILES:
                    if given.get(name) == Path():
                        raise ConfigError(f"--{name} must name a file, got '' or '.'")
                return command(**{name: _absolute(value) for name, value in given.items()})

            register(run)
            return command

        return decorate


def _absolute(value: Any) -> Any:
    """A path, or a list of them, from the root on; any other value as it is."""
    if isinstance(value, list):
        return [_absolute(one) for one in value]
    return Path(os.path.expanduser(value)).absolute() if isinstance(value, Path) else value  # noqa: PTH111 - a user without a home is no error


main = Program(
    name="catch-arena",
    help="Hunters chase turtles, and an arbiter decides who caught what.",
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": list(HELP_OPTIONS)},
)

Agents = Annotated[
    list[str],
    typer.Argument(
        metavar="AGENT...",
        help="A shipped name (see `catch-arena agents`), package.module:Class, a .py file with a class Agent, a "
        "folder with such an agent.py, or cmd:COMMAND (`catch-arena docs isolation`).",
    ),
]
Recorded = Annotated[Path, typer.Argument(metavar="REPLAY", help="A recorded match.")]
Scenario = Annotated[str, typer.Option("--scenario", "-s", help="The arena to play in (see `catch-arena scenarios`).")]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", help="Processes that play.", show_default="all cores")]
SettingOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a setting (`catch-arena docs settings`), for example time_limit_s=30 or faults.kill_down=0.2; may "
        "be repeated.",
    ),
]
LimitOption = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="KEY=VALUE",
        help="Change a limit of isolated agents, for example step_ms=200, or how they are isolated: "
        "isolation=namespaces or isolation=processes (`catch-arena docs isolation`); may be repeated.",
    ),
]
Trusted = Annotated[
    bool,
    typer.Option(
        "--trusted",
        help="Run all agents inside our own processes: faster, but without limits. Without this option, agents that "
        "do not come with Catch Arena are isolated (`catch-arena docs isolation`).",
    ),
]
MaxForfeits = Annotated[
    int,
    typer.Option(
        metavar="N",
        min=0,
        help="An agent that forfeits N matches in a row is excluded: it forfeits the rest without being started. 0: "
        "never exclude.",
    ),
]
MAX_FORFEITS = 10
Seed = Annotated[
    str | None,
    typer.Option(
        metavar="SEED",
        help="All random draws follow from it: 32 hexadecimal digits, as printed in the results, or a number, which "
        "agents can guess.",
        show_default="drawn",
    ),
]
ArenaSeed = Annotated[
    int | None,
    typer.Option(
        metavar="NUMBER", help="Seed of all random draws; agents can guess a small one.", show_default="drawn"
    ),
]


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        say(f"catch-arena {version('catch-arena')}")
        raise typer.Exit


@main.callback()
def _common(
    *,
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and exit.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    del version


def arena(name: str, settings: list[str] | None) -> ArenaConfig:
    """The scenario with the changes of --set.

    Raises:
        ConfigError: for an unknown scenario or setting, and a value that it cannot have.
    """
    overrides: dict[str, Any] = {}
    for key, value in _pairs("--set", settings):
        if key == "control":
            raise ConfigError("--set control=... must be left to the agents: each states its own control")
        group, dot, part = key.partition(".")
        if not dot:
            overrides[key] = value
        elif isinstance(parts := overrides.setdefault(group, {}), dict):
            parts[part] = value
        else:
            raise ConfigError(f"--set {group}=... and --set {key}=... must not both be given")
    return scenario(name, **overrides)


def jobs_or_all(jobs: int | None) -> int:
    """--jobs, or a process for each core."""
    from catch_arena.tournament.execution.executors import usable_cores

    return usable_cores() if jobs is None else jobs


def secret_of(seed: str | None) -> Secret:
    """That of --seed, or a fresh one. The digits of one that was given no longer stand in our command line, which any
    process may read.

    Raises:
        ConfigError: for digits or a number that are no seed.
    """
    if seed is None:
        return Secret.of(None)
    given = Secret.parse(seed)
    if given.number is None:
        blank_argument(seed)
    return given


def seed_told(secret: Secret) -> str:
    """How others can repeat what was drawn, in a line."""
    guessed = "" if secret.number is None else f" ({secret.number}, a number, which agents can guess)"
    return f"seed: {secret.digits}{guessed}"


def limits_or_trust(changes: list[str] | None, *, trusted: bool) -> AgentLimits | None:
    """Limits of isolated agents; None with --trusted.

    Args:
        changes: of --limit.
        trusted: of --trusted.

    Raises:
        ConfigError: for an unknown limit, a level that this machine cannot hold, and --limit with --trusted.
    """
    from catch_arena.tournament.isolation.namespaces import level_here

    if trusted:
        if changes:
            raise ConfigError(f"--limit must be left out with --trusted, which limits nothing: got {changes[0]}")
        return None
    limits = AgentLimits.of(**dict(_pairs("--limit", changes)))
    level_here(limits.isolation)
    return limits


def say_level(limits: AgentLimits | None, specs: Iterable[str]) -> None:
    """Say in one line how the entrants with these specs are isolated, if any of them is."""
    from catch_arena.tournament.entrants import is_shipped
    from catch_arena.tournament.isolation.namespaces import level_here, level_line

    if limits is not None and not all(map(is_shipped, specs)):
        say(folded(level_line(level_here(limits.isolation)), then="           "), err=True)


def enter_agents(specs: Sequence[str], limits: AgentLimits | None) -> "tuple[Entrant, ...]":
    """The agents that these specs stand for, inspected where they will play. Warns on stderr of those that cannot play.

    Args:
        specs: as on the command line.
        limits: limits of isolated agents, None if all are trusted.

    Raises:
        AgentError: for a spec that names no agent, and an agent of our own process that cannot be loaded.
        NoContest: if an isolated agent cannot be started, for a reason on our side.
    """
    from catch_arena.cli.progress import progress_bar
    from catch_arena.tournament.entrants import enter
    from catch_arena.tournament.isolation.playing import inspector, sandbox_for

    with sandbox_for(limits) as sandbox, progress_bar("looking at agents", late=True) as show:
        inspect, seen = inspector(sandbox), count(1)

        def look(spec: str) -> "Inspection":
            show(next(seen), len(specs))
            return inspect(spec)

        entrants = enter(specs, look)
    say_level(limits, [entrant.spec for entrant in entrants])
    for entrant in entrants:
        if entrant.fault is not None:
            say(f"warning: {entrant.name} cannot begin, and forfeits its matches: {entrant.fault}", err=True)
    return entrants


def say_who_needs_prey(entrants: "Sequence[Entrant]") -> None:
    """Who has no prey of its own, and what plays for it."""
    from catch_arena.tournament.entrants import SHIPPED_PREY

    if without := [entrant.name for entrant in entrants if entrant.needs_prey]:
        say(f"no Prey of their own, so that {SHIPPED_PREY} plays for them: {', '.join(without)}")


def _pairs(option: str, changes: list[str] | None) -> Iterator[tuple[str, Any]]:
    for change in changes or ():
        key, equals, text = change.partition("=")
        if not equals or not key:
            raise ConfigError(f"{option} must be KEY=VALUE, got {change!r}")
        try:
            yield key, json.loads(text)
        except ValueError:
            if text.startswith(("[", "(", "{")) or text in {"None", "True", "False"}:
                wanted = "a number, a word, true, false, null, or a list as [[0, 1], [2, 3]]"
                raise ConfigError(f"{option} {key} must be {wanted}, got {text!r}") from None
            yield key, text  # a bare word

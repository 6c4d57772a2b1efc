"""Frame of the command line: the application, its errors, and its exit codes.

`Commands.main` prints each CatchArenaError and OSError in one line; docstrings of this package do not list them.
Heavy modules (the engine, the renderer) are imported only by the commands that need them: --help must be fast.
"""

import os
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib.metadata import version as version_of
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, Final, NoReturn, TypeVar, cast

import typer
from typer.core import TyperGroup

from catch_arena import interrupts
from catch_arena.cli.outputs import RESERVATIONS
from catch_arena.cli.terminal import WIDE, echo, own_console
from catch_arena.errors import CatchArenaError

EXIT_NO: Final = 1
"""Exit code if the answer of a command is no (docs/reference/command_line.md)."""
EXIT_ERROR: Final = 2
"""Exit code for any error."""
_Function = TypeVar("_Function", bound=Callable[..., Any])
_UsageError = cast(type[Exception], typer.BadParameter.__bases__[0])
"""Click's class of usage errors; newer versions of typer contain Click."""

GROUPS: Final = {
    "Play": ("match", "play", "watch", "agents", "scenarios", "docs"),
    "Look": ("explain", "verify", "diff", "render", "clip", "highlights", "mosaic"),
    "Tournaments": ("tournament", "league", "report", "export", "compare", "suite"),
    "Teach": ("new-agent", "check-agent", "grade", "new-class", "conformance"),
    "ROS 2": ("ros",),
}
"""Every command by group, in the order of the program's help."""


class Commands(TyperGroup):
    """Group of commands: errors are one line with a hint (docs/reference/command_line.md), help has whole sentences."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands in their groups, or those of `catch-arena ros` in one."""
        groups: Mapping[str, Iterable[str]] = {"Commands": self.commands} if ctx.parent else GROUPS
        for group, names in groups.items():
            with formatter.section(group):
                formatter.write_dl([(name, self.commands[name].get_short_help_str(200)) for name in names])

    def main(self, *args: Any, **kwargs: Any) -> NoReturn:
        """Read the command line, run the command, and exit."""
        width = min(WIDE, own_console().width)
        try:
            with RESERVATIONS:
                sys.exit(super().main(*args, **{**kwargs, "standalone_mode": False, "terminal_width": width}))
        except CatchArenaError as error:
            if not interrupts.was_interrupted():  # an error after Ctrl-C is expected
                print_error(str(error))
        except _UsageError as error:
            context: Any = getattr(error, "ctx", None)
            if type(error).__name__ == "NoArgsIsHelpError":
                echo(str(error))
            else:
                text = " ".join(cast(Any, error).format_message().replace("Value error, ", "").split())  # typer 0.29
                print_error(text[:1].lower() + text[1:].rstrip("."), context and f"{context.command_path} --help")
        except OSError as error:
            with suppress(OSError):  # stderr may be full too
                print_error(describe(error))
        sys.exit(EXIT_ERROR)


def print_error(text: str, hint: str | None = None) -> None:
    """Print an error, and what to do about it, to stderr."""
    echo(f"error: {text}", err=True)
    if hint:
        echo(f"hint: {hint}", err=True)


def describe(error: OSError) -> str:
    """Return an error of the operating system in words, without its number."""
    if error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, FileNotFoundError):  # os.getcwd
        return "the working folder was deleted; change to another folder"
    return f"the output cannot be written: {error.strerror or error}"


class Program(typer.Typer):
    """Program whose commands take single options, or dataclasses of options that several commands share."""

    def command(self, *args: Any, **kwargs: Any) -> Callable[[_Function], _Function]:
        """Register a command, as `typer.Typer.command` does."""
        register = super().command(*args, **kwargs)

        def decorate(command: _Function) -> _Function:
            register(_with_single_options(command))
            return command

        return decorate


def _with_single_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function for typer that has a parameter for each field of the command's dataclasses.

    A parameter's default, an instance of its dataclass, has the defaults of the fields.
    """
    shared: dict[str, Any] = {}
    single = []
    for name, parameter in signature(command).parameters.items():
        if is_dataclass(parameter.annotation):
            shared[name] = parameter.annotation
            usual = shared[name]() if parameter.default is Parameter.empty else parameter.default
            single += [
                Parameter(field.name, Parameter.KEYWORD_ONLY, default=getattr(usual, field.name), annotation=field.type)
                for field in fields(usual)
            ]
        else:
            single.append(parameter.replace(kind=Parameter.KEYWORD_ONLY))

    def run(**given: Any) -> Any:
        # bash does not expand the tilde of --out=~/x
        given = {
            name: Path(os.path.expanduser(value)) if isinstance(value, Path) else value for name, value in given.items()
        }
        for name, kind in shared.items():
            given[name] = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
        return command(**given)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__signature__ = Signature(single)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in single}
    return run


main = Program(
    name="catch-arena",
    help="Hunters chase turtles, and an arbiter decides who caught what.",
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # its boxes cut words off on a narrow terminal
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _show_version(wanted: bool) -> None:
    if wanted:
        echo(f"catch-arena {version_of('catch-arena')}")
        raise typer.Exit


@main.callback()
def _common(
    *,
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and exit.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    del version

"""Options that several commands share, and their values."""

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from catch_arena.cli.terminal import echo, progress_bar
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.scenarios import SCENARIOS
from catch_arena.scenarios import scenario as scenario_of
from catch_arena.tournament.agent_spec import is_shipped
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.namespaces import available_level, level_line
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import enter

if TYPE_CHECKING:
    from catch_arena.tournament.execution.executors import Executor, Worker

_AGENT: Final = (
    "Name of a shipped agent (see `catch-arena agents`), package.module:Class, a .py file with a class Agent, a folder "
    "that contains agent.py, or cmd:COMMAND (see `catch-arena docs isolation`)."
)
Agents = Annotated[list[str], typer.Argument(metavar="AGENT", help=_AGENT)]
Agent = Annotated[str, typer.Argument(metavar="AGENT", help=_AGENT)]
Recorded = Annotated[Path, typer.Argument(metavar="REPLAY", help="A recorded match.")]


def scenario_option(more: str = "", usual: str | bool = True) -> Any:
    """Return the option --scenario, with more words in its help, and with words for its default."""
    help_ = f"Scenario to play (see `catch-arena scenarios`){more}."
    return typer.Option("--scenario", "-s", metavar="NAME", help=help_, show_default=usual)


def listing_option(what: str) -> Any:
    """Return the option --list, which lists these things and does nothing else."""
    return typer.Option("--list", help=f"Only list {what}.")


SettingOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a setting (see `catch-arena docs settings`), for example time_limit_s=30 or faults.kill_down=0.2; "
        "may be repeated.",
    ),
]
Resume = Annotated[bool, typer.Option("--resume", help="Continue an interrupted run in DIR, if there is one.")]
Seed = Annotated[
    str | None,
    typer.Option(
        metavar="SEED",
        help="Random seed: 32 hexadecimal digits, as printed with the results, or a number. Agents can guess a number.",
        show_default="random",
    ),
]
Limit = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=VALUE",
        help="Change a limit of isolated agents, for example step_ms=200, or the level of isolation: "
        "isolation=namespaces or isolation=processes (see `catch-arena docs isolation`); may be repeated.",
    ),
]
ArenaSeed = Annotated[
    int | None,
    typer.Option(
        metavar="NUMBER",
        help="Random seed. Use a large number if agents must not be able to guess it.",
        show_default="random",
    ),
]


@dataclass(frozen=True)
class Arena:
    """Options for the arena of a match."""

    scenario: Annotated[str, scenario_option()] = "standard"
    settings: SettingOption = None

    def config(self) -> ArenaConfig:
        """Return the scenario with the changes of --set."""
        overrides: dict[str, Any] = {}
        for key, value in _pairs("--set", self.settings):
            if key == "control":
                raise ConfigError("--set control=... must be left out: each agent declares its own control")
            group, dot, part = key.partition(".")
            if not dot:
                overrides[key] = value
            elif isinstance(parts := overrides.setdefault(group, {}), dict):
                parts[part] = value
            else:
                raise ConfigError(f"--set {group}=... and --set {key}=... must not be given together")
        return scenario_of(self.scenario, **overrides)


@dataclass(frozen=True)
class Trust:
    """Options for running agents that do not come with the package."""

    trusted: Annotated[
        bool,
        typer.Option(
            "--trusted",
            help="Run all agents inside Catch Arena's own processes, which is faster but sets no limits. By default, "
            "agents that do not come with Catch Arena are isolated (see `catch-arena docs isolation`).",
        ),
    ] = False
    limit: Limit = None

    def quotas(self) -> Quotas | None:
        """Return the quotas of isolated agents, or None with --trusted."""
        if self.trusted:
            if self.limit:
                raise ConfigError(f"--limit must be left out with --trusted, which sets no limits, got {self.limit[0]}")
            return None
        return quotas_of(self.limit)


@dataclass(frozen=True)
class Processes:
    """Option for the processes that play on this machine."""

    jobs: Annotated[
        int | None,
        typer.Option(
            "--jobs", "-j", metavar="N", min=1, help="Number of processes that play.", show_default="number of cores"
        ),
    ] = None

    @property
    def workers(self) -> int:
        """Number of these processes: by default one for each core that this process may use."""
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return self.jobs or cores


@dataclass(frozen=True)
class Cores(Processes):
    """Options for the cores that play, on this machine or on a cluster."""

    executor: Annotated[
        Literal["local", "ray"], typer.Option(help="Play on this machine (local) or with Ray (ray).")
    ] = "local"
    address: Annotated[
        str | None,
        typer.Option(help="Address of a running Ray cluster; all its cores play.", show_default="a new one here"),
    ] = None

    def __post_init__(self) -> None:
        if self.address is not None and self.executor != "ray":
            raise ConfigError(f"--address must come with --executor ray, got --executor {self.executor}")
        if self.address is not None and self.jobs is not None:
            raise ConfigError(f"--jobs must be left out with --address: all the cluster's cores play, got {self.jobs}")

    def of(self, worker: "Worker") -> "Executor":
        """Return the executor of these options."""
        from catch_arena.tournament.execution.executors import local_executor
        from catch_arena.tournament.execution.ray_executor import RayExecutor

        if self.executor == "ray":
            return RayExecutor(worker, self.workers, self.address)
        return local_executor(worker, self.workers)


def refuse(options: Any, needs: str) -> None:
    """Check that none of these options, a dataclass, was given, because they need another argument of the command."""
    for field in fields(options):
        if getattr(options, field.name) != field.default:
            raise ConfigError(f"--{field.name} must come with {needs}")


def quotas_of(limits: list[str] | None) -> Quotas:
    """Return the quotas of isolated agents with the changes of --limit, after a check of their level."""
    quotas = Quotas.of(**dict(_pairs("--limit", limits)))
    available_level(quotas.isolation)
    return quotas


def require_enough(entrants: int, parties: Parties, scenario: str, *, tournament: bool = False) -> None:
    """Check that there are enough entrants for a match, or for a tournament's block, which may need more with prey."""

    def needed(parties: Parties) -> int:
        return parties.group if tournament else len(parties)

    least = needed(parties)
    if entrants >= least:
        return
    task = f"{parties.task} of {scenario}"
    if least > len(parties):
        task += " in a tournament (a side with one place needs one agent more, to compare with)"
    fitting = [name for name, other in SCENARIOS.items() if 1 < needed(Parties.of(other)) <= entrants]
    advice = f"; or try --scenario {fitting[0]}" if fitting else ""
    raise ConfigError(
        f"number of agents must be at least {least} to {task}, got {entrants}: "
        f"name more of them (the same one may be named twice){advice}"
    )


def require_isolation(subject: str) -> None:
    """Raise a ConfigError on Windows, for a command whose agents cannot be trusted."""
    if not hasattr(os, "fork"):
        raise ConfigError(f"{subject} isolates its agents, which works on Linux and macOS only: use WSL")


def print_level(quotas: Quotas | None, specs: Iterable[str]) -> None:
    """Print in one line the level of isolation of the entrants with these specs, if any of them is isolated."""
    if quotas is not None and not all(map(is_shipped, specs)):
        echo(level_line(available_level(quotas.isolation)), err=True)


def enter_agents(specs: Sequence[str], quotas: Quotas | None) -> tuple[Entrant, ...]:
    """Return the entrants of these specs. Each agent is loaded in the process in which it will play.

    A warning is printed for each agent that cannot play. Without quotas all are trusted.
    """
    from catch_arena.tournament.execution.block_queue import do_here

    with sandbox_for(quotas) as sandbox, progress_bar("loading agents") as show:
        entrants = do_here(enter, specs, sandbox, show)
    print_level(quotas, [entrant.spec for entrant in entrants])
    for entrant in entrants:
        if entrant.fault is not None:
            echo(f"warning: {entrant.name} cannot begin, and forfeits its matches: {entrant.fault}", err=True)
    return entrants


def _pairs(option: str, changes: list[str] | None) -> Iterator[tuple[str, Any]]:
    for change in changes or ():
        key, equals, text = change.partition("=")
        if not equals or not key:
            raise ConfigError(f"{option} must be KEY=VALUE, got {change!r}")
        try:
            yield key, json.loads(text)
        except ValueError:
            if text.startswith(("[", "(", "{")) or text in {"None", "True", "False"}:
                wanted = "a number, a word, true, false, null, or a list such as [[0, 1], [2, 3]]"
                raise ConfigError(f"{option} {key} must be {wanted}, got {text!r}") from None
            yield key, text  # a bare word

"""`catch-arena ros`: the arena, and our own nodes, on a ROS 2 bus."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from catch_arena.cli.app import (
    ArenaSeed,
    Isolation,
    LimitOption,
    SettingOption,
    Trusted,
    arena,
    enter_agents,
    limits_or_trust,
    main,
)
from catch_arena.cli.outputs import Force, output_file
from catch_arena.cli.terminal import say
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.text import name_fault

if TYPE_CHECKING:
    from catch_arena.ros.bus import Bus
    from catch_arena.ros.interfaces import Interfaces

ros = typer.Typer(
    name="ros",
    help="On a ROS 2 bus: the arena for your nodes, and our nodes for turtlesim.",
    no_args_is_help=True,
)
main.add_typer(ros)

BusName = Literal["cyclonedds", "rosbridge", "rclpy"]
BusOption = Annotated[
    BusName | None,
    typer.Option(
        "--bus",
        help="cyclonedds: no ROS is needed here. rosbridge: a rosbridge server runs where ROS is. rclpy: ROS is here.",
        show_default="the first of them that is installed",
    ),
]
Domain = Annotated[int | None, typer.Option(help="DDS's, from 0 to 232.", show_default="ROS_DOMAIN_ID, or 0")]
Url = Annotated[str, typer.Option(metavar="URL", help="Where rosbridge's server listens.")]
Package = Annotated[
    str,
    typer.Option(
        "--interfaces", metavar="PACKAGE", help="Your package with Turtle, TurtleArray and CatchTurtle (docs/ros2.md)."
    ),
]
Turtlesim = Annotated[
    str, typer.Option(metavar="PACKAGE", help="turtlesim, or turtlesim_msgs from Kilted on: where Pose is.")
]
BRIDGE_URL = "ws://127.0.0.1:9090"
_TURTLE = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
NODE, HUMAN = "ros", "human"
"""The words for seats that nodes drive: one that asks for its targets, and one that only drives."""


@ros.command()
def serve(
    *,
    seat: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SEAT=WHO",
            help="Who drives a hunter: ros, a node; human, a node that only drives, as turtle_teleop_key; ros:NAME and "
            "human:NAME give a name; or an agent, as in 1=patrol or 2=mine.py. May be repeated.",
            show_default="ros",
        ),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            "--scenario",
            "-s",
            help="The arena to play in (see `catch-arena scenarios`).",
            show_default="standard, with a hunter for each --seat",
        ),
    ] = None,
    seed: ArenaSeed = None,
    speed: Annotated[float, typer.Option(help="Of the arena's clock, to the wall's; /clock tells it then.")] = 1.0,
    wait: Annotated[bool, typer.Option("--wait/--no-wait", help="Begin when all seats have their node.")] = True,
    bus: BusOption = None,
    domain: Domain = None,
    url: Url = BRIDGE_URL,
    interfaces: Package = "my_robot_interfaces",
    turtlesim: Turtlesim = "turtlesim",
    trusted: Trusted = False,
    limits: LimitOption = None,
    isolation: Isolation = None,
    record: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Keep the replay here; nobody may /spawn, /kill or /reset then.")
    ] = None,
    force: Force = False,
    settings: SettingOption = None,
) -> None:
    """Play a match with ROS 2 nodes: they drive hunters, the arbiter answers /catch_turtle (docs/ros2.md)."""
    from catch_arena.cli.matches import print_ranking
    from catch_arena.explanation.seats import with_seat
    from catch_arena.ros.serving import serve_match
    from catch_arena.seeding import arena_seed

    seats = _seats(seat or [])
    config = _arena(scenario, settings, max(seats, default=0) + 1)
    if seats and max(seats) >= config.hunters:
        raise ConfigError(
            f"--seat must be from 0 to {config.hunters - 1} in {scenario or 'standard'}, got {max(seats)}"
        )
    nodes = {number: who.partition(":")[::2] for number, who in seats.items() if who.partition(":")[0] in {NODE, HUMAN}}
    specs = {number: who for number, who in sorted(seats.items()) if number not in nodes}
    allowed = limits_or_trust(limits, isolation, list(specs.values()), trusted=trusted)
    if record is not None:
        output_file(record, force=force)
    types = interfaces_of(interfaces, turtlesim)
    entrants = dict(zip(specs, enter_agents(list(specs.values()), allowed), strict=True)) if specs else {}
    names = [
        entrants[number].name if number in entrants else nodes.get(number, (NODE, ""))[1] or f"node_{number}"
        for number in range(config.hunters)
    ]
    with joined_bus(bus, "catch_arena", domain, url) as joined:
        served = serve_match(
            joined,
            config,
            arena_seed(seed),
            entrants,
            allowed,
            names=names,
            people=[number for number, (word, _) in nodes.items() if word == HUMAN],
            interfaces=types,
            speed=speed,
            wait=wait,
            record=record,
            title=scenario or "standard",
            say=say,
        )
    shown = [with_seat(name, number) for number, name in enumerate(served.names)]
    print_ranking(served.ranks, served.scores, shown, (None,) * len(names))
    late = served.pace
    say(f"{late.late} of {late.ticks} ticks were late by more than 5 ms, the worst by {late.latest_s * 1e3:.0f} ms")
    if record is not None:
        say(f"replay: {record}")


@ros.command()
def controller(
    agent: Annotated[
        str, typer.Argument(help="Who drives: a shipped name or a .py file, as in `catch-arena match`.")
    ] = "nearest",
    *,
    turtle: Annotated[str, typer.Option(metavar="NAME", help="Which turtle it drives.")] = "turtle1",
    bus: BusOption = None,
    domain: Domain = None,
    url: Url = BRIDGE_URL,
    interfaces: Package = "my_robot_interfaces",
    turtlesim: Turtlesim = "turtlesim",
    trusted: Trusted = False,
    limits: LimitOption = None,
    isolation: Isolation = None,
    settings: SettingOption = None,
) -> None:
    """Drive a turtle by an agent, in turtlesim or in `ros serve`, until Ctrl-C.

    nearest is the exercise's catch_closest_turtle_first, first is the oldest first.
    """
    from catch_arena.ros.controller import PERIOD_S, Controller
    from catch_arena.ros.pace import Pace
    from catch_arena.tournament.isolation.starting import sandbox_for, start_players

    allowed = limits_or_trust(limits, isolation, [agent], trusted=trusted)
    config = arena("capstone", settings)
    types = interfaces_of(interfaces, turtlesim)
    (entrant,) = enter_agents([agent], allowed)
    with (
        sandbox_for(allowed) as sandbox,
        start_players([entrant], sandbox) as players,
        joined_bus(bus, "turtle_controller", domain, url) as joined,
    ):
        node = Controller(joined, players, config, checked_turtle(turtle), types, say=say)
        pace = Pace(PERIOD_S)
        try:
            while True:
                pace.wait()
                joined.spin()
                node.tick()
        finally:
            node.stop()


@ros.command()
def spawner(
    *,
    turtle: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A turtle that hunts; may be repeated.", show_default="turtle1"),
    ] = None,
    spawn_frequency: Annotated[float, typer.Option(help="Targets a second.")] = 0.5,
    name_prefix: Annotated[str, typer.Option(metavar="TEXT", help="Of their names.")] = "target_turtle_",
    reach: Annotated[float, typer.Option(metavar="METRES", help="Who is nearer than this catches.")] = 0.5,
    seed: ArenaSeed = None,
    bus: BusOption = None,
    domain: Domain = None,
    url: Url = BRIDGE_URL,
    interfaces: Package = "my_robot_interfaces",
    turtlesim: Turtlesim = "turtlesim",
) -> None:
    """Spawn targets in turtlesim and referee who catches them, until Ctrl-C.

    With several turtles each asks its own service, as in /turtle2/catch_turtle.
    """
    from catch_arena.ros.pace import Pace
    from catch_arena.ros.spawner import TICK_S, Spawner
    from catch_arena.seeding import arena_seed

    turtles = tuple(checked_turtle(name) for name in turtle or ("turtle1",))
    config = arena(
        "capstone",
        [f"spawn_frequency_hz={spawn_frequency}", f"name_prefix={json.dumps(name_prefix)}", f"reach_m={reach}"],
    )
    types = interfaces_of(interfaces, turtlesim)
    with joined_bus(bus, "turtle_spawner", domain, url) as joined:
        node = Spawner(joined, turtles, types, config, seed=arena_seed(seed), say=say)
        pace = Pace(TICK_S)
        if not node.ready:
            say("waiting for turtlesim: /spawn and /kill")
        while not node.ready:
            pace.wait()
            joined.spin()
        node.begin()
        while True:
            pace.wait()
            joined.spin()
            node.tick()


def checked_turtle(name: str) -> str:
    """The name of a turtle, which stands in names of topics.

    Raises:
        ConfigError: for anything else.
    """
    if not _TURTLE.fullmatch(name):
        raise ConfigError(f"--turtle must be letters, digits and underscores, as turtle1, got {name!r}")
    return name


def _seats(options: list[str]) -> dict[int, str]:
    """Who drives which hunter."""
    seats: dict[int, str] = {}
    for option in options:
        number, equals, who = option.partition("=")
        if not equals or not who or not (number.isascii() and number.isdecimal()):
            raise ConfigError(f"--seat must be SEAT=WHO, as 0=ros or 1=patrol, got {option!r}")
        if int(number) in seats:
            raise ConfigError(f"--seat {number} must be given once, got {seats[int(number)]} and {who}")
        fault = name_fault(who)
        if fault is not None:
            raise ConfigError(f"--seat {number}: {fault}")
        seats[int(number)] = who
    return seats


def _arena(scenario: str | None, settings: list[str] | None, hunters: int) -> ArenaConfig:
    if scenario is not None:
        return arena(scenario, settings)
    return arena("standard", [f"hunters={hunters}", *(settings or ())])


def interfaces_of(package: str, turtlesim: str) -> "Interfaces":
    """The types of --interfaces and --turtlesim.

    Raises:
        ConfigError: for a name that no package can have.
    """
    from catch_arena.ros.bus import checked_package
    from catch_arena.ros.interfaces import Interfaces

    return Interfaces(checked_package("--interfaces", package), checked_package("--turtlesim", turtlesim))


@contextmanager
def joined_bus(backend: BusName | None, node: str, domain: int | None, url: str) -> "Iterator[Bus]":
    """The bus of --bus, --domain and --url, which is left in the end.

    Raises:
        BusError: where it cannot be reached.
    """
    from catch_arena.ros.bus import open_bus

    joined = open_bus(backend, node=node, domain=domain, url=url, say=lambda line: say(line, err=True))
    try:
        yield joined
    finally:
        joined.close()

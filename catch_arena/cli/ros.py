"""`catch-arena ros`: the arena and our own nodes on a ROS 2 bus, matches as bags of rosbag2, and bags as videos."""

import os
from collections.abc import Collection
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer
from typer.core import TyperCommand

from catch_arena.cli.app import EXIT_NO, Commands, Program, main
from catch_arena.cli.bus import Bus, Packages
from catch_arena.cli.matches import print_ranking
from catch_arena.cli.options import (
    Arena,
    ArenaSeed,
    Recorded,
    SettingOption,
    Trust,
    enter_agents,
    listing_option,
    scenario_option,
)
from catch_arena.cli.outputs import REPLAY, VIDEO, VIDEO_HELP, Force, output_option, reserve_file
from catch_arena.cli.replays import Picture, load_replay, write_video
from catch_arena.cli.terminal import echo, progress_bar
from catch_arena.config import ArenaConfig
from catch_arena.errors import AgentError, BusError, ConfigError, install_hint
from catch_arena.ros.doctor import examine
from catch_arena.ros.middleware.graph_names import TURTLE, checked_name, checked_service
from catch_arena.ros.nodes.parameters import parameters_from
from catch_arena.ros.nodes.rate import tick_until_signal
from catch_arena.scenarios import SCENARIOS
from catch_arena.seeding import arena_seed
from catch_arena.text import name_fault
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Players

if TYPE_CHECKING:
    from catch_arena.ros.nodes.serving import Served

ros = Program(
    name="ros",
    cls=Commands,
    help="Run the arena for ROS 2 nodes, run our nodes for turtlesim, and convert bags.",
    no_args_is_help=True,
)
main.add_typer(ros)

_CLOSEST, _OLDEST = "nearest", "first"
"""Agents that the exercise's parameter catch_closest_turtle_first selects: with true, and with false."""
_OWN_SETTINGS = {
    "control_period_ms": "on a bus each step is one tick, 16 ms",
    "observed_targets": "agents see every target on a bus",
}
"""Settings that --set cannot change in `serve`, each with the reason."""
Reach = Annotated[float, typer.Option(metavar="METRES", help="Catch distance [m].")]
NODE, HUMAN = "ros", "human"
"""Words for seats that nodes drive: a node that requests its targets, and a node that only drives."""
EXERCISE = "exercise"
"""Default scenario of `serve`."""
_ROS_ARGS: Final = "--ros-args"
_SPAWN_FREQUENCY: Final = "spawn_frequency"
_NAME_PREFIX: Final = "turtle_name_prefix"
_CLOSEST_FIRST: Final = "catch_closest_turtle_first"
_RosArgs = Annotated[
    list[str] | None,
    typer.Option(
        _ROS_ARGS,
        metavar="ARGS",
        help="Parameters of the node, -p NAME:=VALUE, after all other options (see `catch-arena docs ros_names`).",
    ),
]
"""Option for a node's parameters; only a _NodeCommand may have it."""


class _NodeCommand(TyperCommand):
    """Command that can be started as a node: all words after --ros-args, up to a --, are values of that option."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the name of --ros-args before each of its words, and parse all arguments."""
        in_ros_args, words = False, []
        for word in args:
            if word == _ROS_ARGS or (in_ros_args and word == "--"):
                in_ros_args = word == _ROS_ARGS
            else:
                words.append(f"{_ROS_ARGS}={word}" if in_ros_args else word)
        return super().parse_args(ctx, words)


@ros.command(cls=_NodeCommand)
def serve(
    *,
    seat: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SEAT=DRIVER",
            help="Driver of a hunter: ros (a node), human (a node that only drives, such as turtle_teleop_key), "
            "ros:NAME or human:NAME (the same with a name), or an agent, for example 1=patrol or 2=mine.py. May "
            "be repeated.",
            show_default="ros",
        ),
    ] = None,
    scenario: Annotated[str | None, scenario_option(usual="exercise, with hunters up to the last --seat")] = None,
    seed: ArenaSeed = None,
    speed: Annotated[
        float, typer.Option(help="Simulation speed: 1 is real time; at other speeds /clock has the simulated time.")
    ] = 1.0,
    bus: Bus,
    trust: Trust,
    record: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Save the replay to this file; /spawn and /reset then do nothing."),
    ] = None,
    force: Force = False,
    settings: SettingOption = None,
    ros_args: _RosArgs = None,
) -> None:
    """Play a match with ROS 2 nodes: they drive hunters, the arbiter answers /catch_turtle.

    `catch-arena docs ros2` has an example.
    """
    from catch_arena.ros.nodes.serving import serve_match

    seats = _seats(seat or [])
    config = _with_parameters(_arena(scenario, settings, seats), ros_args)
    drivers = sorted(seats.items())
    agents = {number: driver for number, driver in drivers if driver.partition(":")[0] not in {NODE, HUMAN}}
    quotas = trust.quotas()
    reserve_file(record, REPLAY, force=force)
    try:
        entrants = dict(zip(agents, enter_agents(list(agents.values()), quotas), strict=True)) if agents else {}
    except AgentError as error:
        raise AgentError(f"--seat: {error}; `ros` stands for a node, and `human` for a person") from None
    if scenario is None:
        echo(f"scenario: {EXERCISE}: a target is caught from less than {config.reaches[0]:g} m away (-s: another one)")
    names = [
        entrants[number].name if number in entrants else seats.get(number, NODE).partition(":")[2] or f"node_{number}"
        for number in range(config.hunters)
    ]
    served = serve_match(
        bus.joined("catch_arena"),
        config,
        arena_seed(seed),
        entrants,
        quotas,
        names=names,
        people=[number for number, driver in seats.items() if driver.partition(":")[0] == HUMAN],
        interfaces=bus.types,
        speed=speed,
        record=record,
        title=scenario or EXERCISE,
        log=echo,
    )
    _print_ranking(served, config)
    for line in served.remarks:
        echo(line)
    rate = served.rate
    echo(f"{rate.late} of {rate.ticks} ticks were late by more than 5 ms, the worst by {rate.latest_s * 1e3:.0f} ms")
    if record is not None:
        echo(f"replay: {record}")


@ros.command(cls=_NodeCommand)
def controller(
    agent: Annotated[
        str, typer.Argument(help="Agent that drives: a shipped agent's name or a .py file, as in `catch-arena match`.")
    ] = "nearest",
    *,
    turtle: Annotated[str, typer.Option(metavar="NAME", help="Name of the turtle that it drives.")] = TURTLE,
    service: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Service that answers catch requests.",
            show_default="/NAME/catch_turtle if a node serves it, else /catch_turtle",
        ),
    ] = None,
    bus: Bus,
    trust: Trust,
    ros_args: _RosArgs = None,
) -> None:
    """Drive a turtle with an agent, in turtlesim or in `ros serve`, until Ctrl-C.

    With the agents nearest and first the node has the exercise's parameter catch_closest_turtle_first: true selects
    nearest, and false selects first.
    """
    from catch_arena.ros.nodes.controller import PERIOD_S, Controller

    quotas = trust.quotas()
    values = parameters_from(ros_args, {_CLOSEST_FIRST: agent == _CLOSEST} if agent in {_CLOSEST, _OLDEST} else {})
    if values:
        agent = _CLOSEST if values[_CLOSEST_FIRST] else _OLDEST
    config = SCENARIOS["capstone"]
    turtle = checked_name("--turtle", turtle, TURTLE)
    if service is not None:
        checked_service("--service", service)
    entrants = enter_agents([agent], quotas)
    with (
        sandbox_for(quotas) as sandbox,
        Players(entrants, sandbox) as players,
        bus.joined("turtle_controller") as joined,
    ):
        node = Controller(joined, players, config, turtle, joined.interfaces(bus.types), service=service, log=echo)
        try:
            tick_until_signal(joined, node.tick, PERIOD_S)
        finally:
            node.stop()


@ros.command(cls=_NodeCommand)
def spawner(
    *,
    turtle: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Turtle that hunts; may be repeated.", show_default=TURTLE),
    ] = None,
    reach: Reach = 0.5,
    bus: Bus,
    ros_args: _RosArgs = None,
) -> None:
    """Spawn targets in turtlesim and judge who catches them, until Ctrl-C.

    With several turtles, each calls its own service, for example /turtle2/catch_turtle.
    """
    from catch_arena.core.physics import DT
    from catch_arena.ros.nodes.spawner import Spawner

    turtles = tuple(dict.fromkeys(checked_name("--turtle", name, TURTLE) for name in turtle or (TURTLE,)))
    config = _with_parameters(SCENARIOS["capstone"].replace(reach_m=reach), ros_args)
    checked_name(_NAME_PREFIX, config.name_prefix, "target_turtle_")
    with bus.joined("turtle_spawner") as joined:
        node = Spawner(joined, turtles, joined.interfaces(bus.types), config, seed=arena_seed(None), log=echo)
        echo("waiting for turtlesim: /spawn and /kill")
        tick_until_signal(joined, node.tick, DT)


@ros.command()
def doctor(*, bus: Bus) -> None:
    """Check packages, nodes and topics, and print a command for each problem that keeps your node from playing.

    The exit code is 1 if there is a problem, else 0. Start your node first, but not `ros serve`. Nodes are listed
    over rclpy only; over cyclonedds those that drive a hunter are counted.
    """
    with closing(bus.opened("catch_arena_doctor")) as joined:
        facts, problems = examine(joined, bus.types)
    for line in (*facts, *(f"problem: {one}" for one in problems)):
        echo(line)
    if problems:
        raise typer.Exit(EXIT_NO)
    echo("no problem found")


@ros.command()
def bag(
    replay: Recorded,
    *,
    output: Annotated[
        Path | None, output_option("Folder of the new bag.", "next to the replay, with its name", metavar="DIR")
    ] = None,
    storage: Annotated[Literal["mcap", "sqlite3"], typer.Option(help="File format in the bag.")] = "mcap",
    packages: Packages,
    force: Force = False,
) -> None:
    """Write a recorded match as a bag, for ros2 bag play and Foxglove (see `catch-arena docs ros2_bags`)."""
    _require_rosbags()
    from catch_arena.ros.bags.export import export_bag

    recorded = load_replay(replay)
    folder = output or replay.with_suffix("")
    if folder.suffix.lower() in {".mcap", ".db3", ".replay"}:
        raise ConfigError(f"{folder}: --output must be a folder, without the ending {folder.suffix}")
    with progress_bar("writing") as show:
        messages = export_bag(recorded, folder, storage, packages.types, force=force, progress=show)
    echo(f"bag: {folder} ({messages} messages)")


@ros.command(name="import")
def import_(
    bag: Annotated[Path, typer.Argument(metavar="BAG", help="Folder made by ros2 bag record, or the file in it.")],
    *,
    output: Annotated[Path | None, output_option(VIDEO_HELP, "an MP4 file next to the bag")] = None,
    force: Force = False,
    listing: Annotated[bool, listing_option("the rulings")] = False,
    reach: Reach = 0.3,
    picture: Picture,
) -> None:
    """Make a video of a recording of turtlesim, and show how the arbiter would have judged each catch."""
    _require_rosbags()
    from catch_arena.ros.bags.reading import read_bag
    from catch_arena.ros.bags.rulings import judge_bag, summary

    whole = Path(os.path.realpath(bag))
    target = output or whole.with_suffix(".mp4")
    drawn = picture.arguments()
    if not listing:
        reserve_file(target, *VIDEO, force=force)
    with progress_bar("reading") as show:
        contents = read_bag(bag, show)
    judged = judge_bag(contents, reach)
    for one in judged:
        echo(str(one))
    echo(summary(judged))
    if contents.left_out:
        echo(f"left out: {contents.left_out} messages that are damaged or have impossible values", err=True)
    if listing:
        return
    from catch_arena.ros.bags.video import render_bag

    write_video(render_bag, contents, judged, target, reach_m=reach, title=whole.stem, **drawn)


def _with_parameters(config: ArenaConfig, ros_args: list[str] | None) -> ArenaConfig:
    """Return the settings with the parameters of the exercise's spawner that --ros-args has."""
    values = parameters_from(
        ros_args, {_SPAWN_FREQUENCY: float(config.spawn_frequency_hz), _NAME_PREFIX: config.name_prefix}
    )
    return config.replace(spawn_frequency_hz=values[_SPAWN_FREQUENCY], name_prefix=values[_NAME_PREFIX])


def _print_ranking(served: "Served", config: ArenaConfig) -> None:
    """R6.1, R11.1: Print the ranking by hunter, or by team with the catches of each of its hunters."""
    from catch_arena.explanation.seats import with_seat

    rows = []
    for seats in Parties.of(config).seats:
        shown = [with_seat(served.names[seat], seat) for seat in seats]
        scores = [served.scores[seat] for seat in seats]
        team = " + ".join(f"{name} {score}" for name, score in zip(shown, scores, strict=True))
        rows.append((served.ranks[seats[0]], sum(scores), team if len(seats) > 1 else shown[0]))
    print_ranking(rows)


def _seats(options: list[str]) -> dict[int, str]:
    """Return the driver of each hunter, by seat, from the --seat options."""
    seats: dict[int, str] = {}
    for option in options:
        number, equals, driver = option.partition("=")
        if not equals or not driver or not (number.isascii() and number.isdecimal()):
            raise ConfigError(f"--seat must be SEAT=DRIVER, such as 0=ros or 1=patrol, got {option!r}")
        if int(number) in seats:
            raise ConfigError(f"--seat {number} must be given once, got {seats[int(number)]} and {driver}")
        if fault := name_fault(driver):
            raise ConfigError(f"--seat {number}: {fault}")
        seats[int(number)] = driver
    return seats


def _arena(scenario: str | None, settings: list[str] | None, seats: Collection[int]) -> ArenaConfig:
    keys = [setting.partition("=")[0] for setting in settings or ()]
    for key in keys:
        if key in _OWN_SETTINGS:
            raise ConfigError(f"--set {key}=... must be left out: {_OWN_SETTINGS[key]}")
    last = max(seats, default=0)
    by_seats = [] if scenario or "hunters" in keys else [f"hunters={last + 1}"]
    config = Arena(scenario or EXERCISE, [*by_seats, *(settings or ())]).config()
    if last >= config.hunters:
        raise ConfigError(f"--seat must be from 0 to {config.hunters - 1} in {scenario or EXERCISE}, got {last}")
    return config


def _require_rosbags() -> None:
    if find_spec("rosbags") is None:
        raise BusError(f"bags need rosbags, which is not installed: {install_hint('ros')}")

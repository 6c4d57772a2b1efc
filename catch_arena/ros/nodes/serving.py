"""One match on a ROS 2 bus, from the wait for the first node to the last answer."""

import gc
from collections.abc import Collection, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from catch_arena import interrupts
from catch_arena.config import ArenaConfig, Control
from catch_arena.core.physics import TICK_MS
from catch_arena.errors import ConfigError
from catch_arena.ros.arena_service import ArenaService
from catch_arena.ros.middleware.bus import Bus, Log
from catch_arena.ros.middleware.interfaces import Interfaces
from catch_arena.ros.nodes.agents import AgentSeats
from catch_arena.ros.nodes.arena_node import ArenaNode
from catch_arena.ros.nodes.rate import Rate
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.players import Players

FASTEST: Final = 100.0
"""The highest --speed."""
_LOG_AGAIN: Final = 20_000 // TICK_MS
"""Period in which the missing seats are logged again [ticks]."""
_SETTLE: Final = 1000 // TICK_MS
"""Time between the last node and the beginning of the match [ticks]."""
_LAST_TICKS: Final = 30
"""Number of ticks after the end, in which late requests get MATCH_OVER and the last standings are sent."""


@dataclass(frozen=True, slots=True)
class Served:
    """Result of a match; tuples are by seat."""

    names: tuple[str, ...]
    ranks: tuple[int, ...]
    scores: tuple[int, ...]
    rate: Rate
    remarks: tuple[str, ...]
    """Lines for the authors of nodes, to print after the ranking."""


def serve_match(
    bus: AbstractContextManager[Bus],
    config: ArenaConfig,
    seed: int,
    agents: Mapping[int, Entrant],
    quotas: Quotas | None,
    *,
    names: Sequence[str],
    people: Collection[int] = (),
    interfaces: Interfaces,
    speed: float = 1.0,
    record: Path | None = None,
    title: str = "",
    log: Log = print,
) -> Served:
    """Play one match with agents in some seats, and with nodes on a bus in the others.

    The bus is joined after everything else is checked, and left at the end. The control period is set to TICK_MS.

    If `quotas` is None, all agents are trusted. The nodes of seats in `people` only drive, as a keyboard's does: the
    arena requests catches for them (R4.4). At a speed other than 1, the arena's time is published on /clock.
    """
    if not 0.0 < speed <= FASTEST:
        raise ConfigError(f"--speed must be above 0 and at most {FASTEST:g}, got {speed:g}")
    if config.prey:
        raise ConfigError(f"prey must be 0 on a bus, got {config.prey}: no node can play it; use --set prey=0")
    control: tuple[Control, ...] = tuple(
        agents[seat].control if seat in agents else "velocity" if seat in people else "full"
        for seat in range(config.hunters)
    )
    service = ArenaService(config.replace(control_period_ms=TICK_MS, observed_targets=None), control=control)
    if record is not None:
        service.record(names, title)
    with ExitStack() as stack:
        sandbox = stack.enter_context(sandbox_for(quotas if agents else None))
        players = AgentSeats(service, stack.enter_context(Players(agents, sandbox)), log)
        stack.callback(players.close)
        driven = [seat for seat in range(config.hunters) if seat not in agents]
        joined = stack.enter_context(bus)
        interfaces = joined.interfaces(interfaces)
        node = ArenaNode(joined, service, driven, names, players, interfaces, clock=speed != 1.0, log=log)
        node.begin(seed)
        gc.freeze()  # a garbage collection of all loaded modules takes as long as several ticks
        stack.callback(gc.unfreeze)
        period_s = TICK_MS / 1000.0 / speed
        if node.seats:
            _wait_for_nodes(node, Rate(period_s))
            log("all seats are taken: the match begins")
        rate = Rate(period_s)

        def play() -> None:
            while not service.over:
                rate.sleep()
                node.tick()

        interrupts.run_until_signal(play)
        early = not service.over
        if early:
            log(f"the match was stopped after {service.world.time_ms / 1000:.0f} s; this is the ranking until then")
        ranks, scores = node.standings()

        def end() -> None:
            last = Rate(period_s)
            for _ in range(0 if early else _LAST_TICKS):
                last.sleep()
                node.tick()

        try:
            interrupts.run_until_signal(end)
        finally:
            if record is not None:  # last, since saving takes as long as many ticks
                if left_out := service.requests_left_out:
                    log(f"the replay is without {left_out} refused requests: there were too many to keep")
                service.replay.save(record)
    return Served(tuple(names), ranks, scores, rate, node.remarks())


def _wait_for_nodes(node: ArenaNode, rate: Rate) -> None:
    """Wait until each seat has its node, and then for a second, in which names and types of the nodes are checked."""
    ticks = 0
    while node.missing:
        if ticks % _LOG_AGAIN == 0:
            node.log_missing(again=ticks > 0)
        ticks += 1
        rate.sleep()
        node.wait()
    for _ in range(_SETTLE):
        rate.sleep()
        node.wait()

"""Agents in the seats that no node drives, asked every 100 ms of the arena's time in a thread of their own."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any, Final

from catch_arena.envs.actions import checked_action
from catch_arena.errors import ActionError
from catch_arena.messages import CatchTurtleRequest, Twist
from catch_arena.policy import Limits
from catch_arena.ros.arena_service import ArenaService
from catch_arena.ros.middleware.bus import Log
from catch_arena.text import one_line
from catch_arena.tournament.match import Move
from catch_arena.tournament.players import Players
from catch_arena.tournament.secret import agent_seed

ACT_EVERY_MS: Final = 100
"""R1.3: the usual control period [ms], so that agents play as in any other match."""


class AgentSeats:
    """Hunters that agents drive. The arena does not wait: an action holds until the next one comes."""

    def __init__(self, service: ArenaService, players: Players, log: Log) -> None:
        self._service, self._players, self._log = service, players, log
        self._hunters = {seat: service.config.hunter_names[seat] for seat in sorted(players.controls)}
        self._thread = ThreadPoolExecutor(1, "agents")
        self._moves: Future[dict[int, Move]] | None = None
        self._seen: Mapping[int, Sequence[str]] = {}
        """Names of the targets by rank, as they were when the agents were asked."""
        self._next_ms = 0
        self.cmd_vel: dict[str, Twist] = {}
        self.active_targets: dict[str, str] = {}
        """Target that the arena's controller drives to, by hunter (R4.1)."""
        self.forfeits: dict[int, int] = {}
        """The step in which an agent failed, by seat: it is ranked last."""

    def begin(self, seed: int) -> None:
        """Begin a match."""
        if self._moves is not None:
            self._moves.exception()  # wait for the answers about the previous match, and drop them
            self._moves = None
        self._next_ms = 0
        for hunters in (self.cmd_vel, self.active_targets, self.forfeits):
            hunters.clear()
        config = self._service.config
        seats = range(config.hunters)
        limits = [replace(Limits.of(config, seat), control_period_ms=ACT_EVERY_MS) for seat in seats]
        for seat, fault in self._players.reset([agent_seed(seed, seat) for seat in seats], limits).items():
            self._forfeit(seat, f"{fault.code}: {fault.reason}")

    def act(self, now_ms: int) -> list[tuple[str, CatchTurtleRequest]]:
        """Take the actions that have come, ask for the next ones, and return the requests; none after the end."""
        if self._service.over:
            self.active_targets.clear()
            return []
        requests: list[tuple[str, CatchTurtleRequest]] = []
        if self._moves is not None and self._moves.done():
            moves, self._moves = self._moves.result(), None
            for seat, (action, _, fault) in moves.items():
                try:
                    if fault is not None:
                        raise ActionError(f"{fault.code}: {fault.reason}")
                    self._take(seat, action, requests)
                except ActionError as error:
                    self._forfeit(seat, str(error))
        playing = {seat: hunter for seat, hunter in self._hunters.items() if seat not in self.forfeits}
        if now_ms >= self._next_ms and self._moves is None and playing:
            self._next_ms = now_ms - now_ms % ACT_EVERY_MS + ACT_EVERY_MS
            views = {seat: self._service.observe(hunter) for seat, hunter in playing.items()}
            self._seen = {seat: self._service.targets_seen(hunter) for seat, hunter in playing.items()}
            self._moves = self._thread.submit(self._players.act, views)
        return requests

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown()

    def _take(self, seat: int, action: Any, requests: list[tuple[str, CatchTurtleRequest]]) -> None:
        config, hunter, seen = self._service.config, self._hunters[seat], self._seen[seat]
        control = config.controls[seat]
        self.active_targets.pop(hunter, None)
        rank, command = checked_action(control, hunter, action, config.targets_seen)
        if 0 < rank <= len(seen):
            if control == "target":
                self.active_targets[hunter] = seen[rank - 1]
            else:
                requests.append((hunter, CatchTurtleRequest(seen[rank - 1])))
        self.cmd_vel[hunter] = Twist(command[0] * config.max_speeds[seat], command[1] * config.max_turn_rates[seat])

    def _forfeit(self, seat: int, fault: str) -> None:
        hunter = self._hunters[seat]
        self.forfeits[seat] = self._service.world.step
        self._players.drop(seat)
        self.cmd_vel.pop(hunter, None)
        self.active_targets.pop(hunter, None)
        self._service.withdraw(hunter)
        self._log(f"{hunter} forfeits and is withdrawn: {one_line(fault)}")

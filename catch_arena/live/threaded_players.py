"""Players for agents that may take long: a separate thread waits for them while the window answers its user."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from threading import Thread
from typing import Final

from catch_arena.policy import AnyLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.players import Fault, Move, Observation, Players

_FIRST_WAIT_S: Final = 0.05
"""Time within which most agents have answered, so that the window need not be drawn [s]."""


class ThreadedPlayers(Players):
    """Isolated players whose thinking does not hold up this thread.

    Args:
        players: the players in the sandbox.
        sandbox: sandbox of the players; it is killed if `wait` raises.
        wait: called repeatedly while they think; an exception that it raises ends the match.
    """

    def __init__(self, players: Players, sandbox: Sandbox, wait: Callable[[], None]) -> None:
        self.controls = players.controls
        self._players = players
        self._sandbox = sandbox
        self._wait = wait

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match."""
        return self._players.reset(seeds, limits)

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Move]:
        """Return the answers of seats to their observations; call `wait` while they think."""
        moves: Future[dict[int, Move]] = Future()
        thread = Thread(target=self._act, args=(observations, moves))
        thread.start()
        thread.join(_FIRST_WAIT_S)
        try:
            while thread.is_alive():
                self._wait()
        except BaseException:
            self._sandbox.kill()  # the thread stops waiting when the agents' processes end
            thread.join()
            raise
        return moves.result()

    def drop(self, seat: int) -> None:
        """Drop a seat that has forfeited."""
        self._players.drop(seat)

    def logs(self) -> dict[int, str]:
        """Return the texts that agents have printed, by seat."""
        return self._players.logs()

    def _act(self, observations: Mapping[int, Observation], moves: "Future[dict[int, Move]]") -> None:
        try:
            moves.set_result(self._players.act(observations))
        except BaseException as error:  # noqa: BLE001 - reading the answers raises it
            moves.set_exception(error)

"""The oracle's arbiter: chapter 5, written from docs/reference/rulebook.md alone."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from oracle.arithmetic import SERVICE_LOT, TIE_LOT, draw, key
from oracle.turtles import by_seat, distance, micrometres, reach_in_micrometres

MATCH_OVER: Final = 1
MALFORMED: Final = 2
HUNTER_INACTIVE: Final = 3
DUPLICATE: Final = 4
UNKNOWN_TARGET: Final = 5
ALREADY_CAUGHT: Final = 6
SERVICE_DOWN: Final = 7
OUT_OF_REACH: Final = 8
LOST_CONTEST: Final = 9
KILL_FAILED: Final = 10
GRANTED: Final = 11
WAITING_FOR_PARTNER: Final = 12


class Request:
    """One catch request on its way through the arbiter's tests."""

    def __init__(self, seat: int, number: int | None) -> None:
        self.seat = seat
        self.number = number
        """The target's number; None where no target can be meant."""
        self.verdict = 0
        self.distance_um: int | None = None
        self.winner: int | None = None


def contest_winner(eligible: Sequence[Request], number: int, policy: str, seed: int, step: int) -> int:
    """R5.4, R5.5, R5.9: the seat that wins one target."""
    seats = [request.seat for request in eligible]
    if policy == "first_come":
        lots = draw(key(seed, SERVICE_LOT), step)
        return min(seats, key=lambda seat: (draw(lots, seat), seat))
    nearest = min(request.distance_um for request in eligible if request.distance_um is not None)
    tied = [request.seat for request in eligible if request.distance_um == nearest]
    lots = draw(draw(key(seed, TIE_LOT), step), number)
    return min(tied, key=lambda seat: (draw(lots, seat), seat))


def refuse_without_partners(requests: Sequence[Request], teams: Sequence[Sequence[int]] | None, needed: int) -> None:
    """R5.10: refuse requests in which too few hunters of one team ask for the same target."""
    so_far = [request for request in requests if request.verdict == 0 and request.number is not None]
    for team in teams or ():
        for number in {request.number for request in so_far}:
            together = [request for request in so_far if request.number == number and request.seat in team]
            if len(together) < needed:
                for request in together:
                    request.verdict = WAITING_FOR_PARTNER


def decide_contests(requests: Sequence[Request], refused: Iterable[int], policy: str, seed: int, step: int) -> None:
    """R5.4 to R5.7: verdicts for all requests that no earlier test has refused."""
    contests: dict[int, list[Request]] = {}
    for request in requests:
        if request.verdict == 0 and request.number is not None:
            contests.setdefault(request.number, []).append(request)
    unkillable = set(refused)
    for number, eligible in contests.items():
        winner = contest_winner(eligible, number, policy, seed, step)
        for request in eligible:
            if request.seat != winner:
                request.verdict = LOST_CONTEST
                request.winner = winner
            elif number in unkillable:
                request.verdict = KILL_FAILED
                request.winner = winner if len(eligible) > 1 else None
            else:
                request.verdict = GRANTED
                request.winner = winner


def judge(
    *,
    hunters: Sequence[tuple[float, float]],
    targets: Mapping[str, tuple[float, float]],
    requests: Sequence[tuple[int, object]],
    reach_m: float | Sequence[float] = 0.3,
    policy: str = "nearest",
    seed: int = 0,
    step: int = 0,
    caught: Iterable[str] = (),
    inactive: Iterable[int] = (),
    kill_service_up: bool = True,
    kill_refused: Iterable[str] = (),
    match_over: bool = False,
    teams: Sequence[Sequence[int]] | None = None,
    hunters_per_catch: int = 1,
) -> list[tuple[int, int, object, int | None, int | None]]:
    """Chapter 5 for requests by name: (verdict, seat, name, distance_um, winner) in the order of the requests."""
    names = list(targets)
    number_of = {name: place for place, name in enumerate(names, start=1)}
    caught, inactive = set(caught), set(inactive)
    reaches_um = [reach_in_micrometres(reach) for reach in by_seat(reach_m, len(hunters))]
    judged: list[Request] = []
    seen: set[int] = set()
    for seat, name in requests:
        if not 0 <= seat < len(hunters):
            raise ValueError(f"no hunter has seat {seat}")
        request = Request(seat, None)
        judged.append(request)
        is_first = seat not in seen
        seen.add(seat)
        if match_over:
            request.verdict = MATCH_OVER
        elif not isinstance(name, str) or len(name) > 255:
            request.verdict = MALFORMED
        elif seat in inactive:
            request.verdict = HUNTER_INACTIVE
        elif policy == "capstone":
            request.verdict = GRANTED if kill_service_up else SERVICE_DOWN
            request.winner = seat if kill_service_up else None
        elif not is_first:
            request.verdict = DUPLICATE
        elif name not in number_of and name not in caught:
            request.verdict = UNKNOWN_TARGET
        elif name in caught:
            request.verdict = ALREADY_CAUGHT
        elif not kill_service_up:
            request.verdict = SERVICE_DOWN
        else:
            request.number = number_of[name]
            request.distance_um = micrometres(distance(*hunters[seat], *targets[name]))
            if not request.distance_um < reaches_um[seat]:
                request.verdict = OUT_OF_REACH
    refuse_without_partners(judged, teams, hunters_per_catch)
    refused = [number_of[name] for name in kill_refused if name in number_of]
    decide_contests(judged, refused, policy, seed, step)
    return [
        (request.verdict, request.seat, name, request.distance_um, request.winner)
        for request, (_, name) in zip(judged, requests, strict=True)
    ]

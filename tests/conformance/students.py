"""Arbiters as students hand them in: each with several mistakes, written before any diagnosis was."""

import math
import random
from typing import Any


def minimal(*, hunters: Any, targets: Any, requests: Any, reach_m: float, **_: Any) -> list[Any]:
    """Who wins, and nothing else."""
    away = {seat: math.dist(hunters[seat], targets[name]) for seat, name in requests if name in targets}
    best: dict[str, int] = {}
    for seat, name in requests:
        if name in targets and away[seat] <= reach_m and (name not in best or away[seat] < away[best[name]]):
            best[name] = seat
    rulings: list[Any] = []
    for seat, name in requests:
        if name not in targets:
            rulings.append(("UNKNOWN_TARGET", seat, name))
            continue
        distance = round(1e6 * math.dist(hunters[seat], targets[name]))
        if distance > 1e6 * reach_m:
            rulings.append(("OUT_OF_REACH", seat, name, distance))
        else:
            verdict = "GRANTED" if seat == best.get(name) else "LOST_CONTEST"
            rulings.append((verdict, seat, name, distance, best.get(name)))
    return rulings


def one_loop(
    hunters: Any,
    targets: Any,
    requests: Any,
    reach_m: float = 0.3,
    caught: Any = (),
    inactive: Any = (),
    kill_service_up: bool = True,
    kill_refused: Any = (),
    match_over: bool = False,
    **_: Any,
) -> list[Any]:
    """Knows the rules from one reading."""
    rulings: list[Any] = [None] * len(requests)
    best: dict[str, tuple[int, int]] = {}
    seen = set()
    asked_for: dict[str, list[tuple[int, int]]] = {}
    for place, (hunter, name) in enumerate(requests):
        if match_over:
            rulings[place] = ("MATCH_OVER", hunter, name)
            continue
        if hunter in inactive:
            rulings[place] = ("HUNTER_INACTIVE", hunter, name)
            continue
        if not kill_service_up:
            rulings[place] = ("SERVICE_DOWN", hunter, name)
            continue
        if hunter in seen:
            rulings[place] = ("DUPLICATE", hunter, name)
            continue
        seen.add(hunter)
        if name in caught:
            rulings[place] = ("ALREADY_CAUGHT", hunter, name)
            continue
        if name not in targets:
            rulings[place] = ("UNKNOWN_TARGET", hunter, name)
            continue
        distance = round(math.dist(hunters[hunter], targets[name]) * 1_000_000)
        if distance > reach_m * 1_000_000:
            rulings[place] = ("OUT_OF_REACH", hunter, name, distance)
            continue
        asked_for.setdefault(name, []).append((place, distance))
        if name not in best or distance < best[name][1]:
            best[name] = (place, distance)
    for name, places in asked_for.items():
        winner = best[name][0]
        for place, distance in places:
            hunter = requests[place][0]
            if place != winner:
                rulings[place] = ("LOST_CONTEST", hunter, name, distance, requests[winner][0])
            elif name in kill_refused:
                rulings[place] = ("KILL_FAILED", hunter, name, distance, hunter)
            else:
                rulings[place] = ("GRANTED", hunter, name, distance, hunter)
    return rulings


class Referee:
    """Goes target by target, with dictionaries, and without evidence of the winner."""

    def __init__(self) -> None:
        self.random = random.Random(0)

    def __call__(self, *, hunters: Any, targets: Any, requests: Any, **rest: Any) -> list[dict[str, Any]]:
        first: dict[int, int] = {}
        rulings = []
        for place, (hunter, name) in enumerate(requests):
            ruling: dict[str, Any] = {"hunter": hunter, "target": name, "verdict": None}
            rulings.append(ruling)
            if rest["match_over"]:
                ruling["verdict"] = "MATCH_OVER"
            elif not isinstance(name, str) or not 0 < len(name) <= 255:
                ruling["verdict"] = "MALFORMED"
            elif hunter in rest["inactive"]:
                ruling["verdict"] = "HUNTER_INACTIVE"
            elif first.setdefault(hunter, place) != place:
                ruling["verdict"] = "DUPLICATE"
            elif name.strip() not in targets:
                ruling["verdict"] = "ALREADY_CAUGHT" if name in rest["caught"] else "UNKNOWN_TARGET"
            elif not rest["kill_service_up"]:
                ruling["verdict"] = "SERVICE_DOWN"
        for name, (x, y) in targets.items():
            near = []
            for ruling in rulings:
                if ruling["verdict"] is None and ruling["target"].strip() == name:
                    hx, hy = hunters[ruling["hunter"]]
                    metres = math.sqrt((hx - x) ** 2 + (hy - y) ** 2)
                    ruling["distance_um"] = int(metres * 1e6)
                    if metres < rest["reach_m"]:
                        near.append((metres, self.random.random(), ruling))
                    else:
                        ruling["verdict"] = "OUT_OF_REACH"
            near.sort(key=lambda one: one[:2])
            for rank, (_, _, ruling) in enumerate(near):
                if name in rest["kill_refused"]:
                    ruling["verdict"] = "KILL_FAILED"
                else:
                    ruling["verdict"] = "LOST_CONTEST" if rank else "GRANTED"
        return rulings


def service(*, hunters: Any, targets: Any, requests: Any, reach_m: float, **_: Any) -> list[Any]:
    """The original's service, with the least that makes it a referee."""
    left = dict(targets)
    answers = []
    for hunter, name in requests:
        if name not in left:
            answers.append(("UNKNOWN_TARGET", hunter, name, None, None))
            continue
        x, y = left[name]
        dx, dy = hunters[hunter][0] - x, hunters[hunter][1] - y
        if dx * dx + dy * dy <= reach_m:
            del left[name]
            answers.append(("GRANTED", hunter, name, None, None))
        else:
            answers.append(("OUT_OF_REACH", hunter, name, None, None))
    return answers

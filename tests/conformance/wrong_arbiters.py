"""A right arbiter, and the known mistakes of mistakes.toml, each of which differs from it in one thing."""

import hashlib
import math
import unicodedata
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

Ruling = dict[str, Any]
Eligible = list[Ruling]
"""Requests for one target, with `place` among the requests, `hunter` and `distance_um`."""

ORDER: Final = ("over", "malformed", "inactive", "duplicate", "unknown", "caught", "down", "far")
"""R5.2's tests."""


class PlainArbiter:
    """A right arbiter, but for lots of its own; a mistake is another order of the tests, or a method in place of one.

    `given` changes the case before it is judged, and `returned` the rulings after it.
    """

    def __init__(self, order: Sequence[str] = ORDER, **methods: Any) -> None:
        self.order = order
        for name, method in methods.items():
            setattr(self, name, partial(method, self))

    def __call__(self, **case: Any) -> list[Ruling]:
        self.case = case = self.given(case)
        self.requesters: set[int] = set()
        rulings: list[Ruling] = []
        contests: dict[Any, Eligible] = {}
        for place, (hunter, name) in enumerate(case["requests"]):
            ruling = {"verdict": None, "hunter": hunter, "target": name, "distance_um": None, "winner": None}
            rulings.append(ruling)
            self.reach_m = self.own_reach(hunter)
            self.refuse(ruling)
            self.note(ruling)
            if ruling["verdict"] is None and case["policy"] == "capstone":
                ruling |= {"verdict": "GRANTED", "winner": hunter}
            elif ruling["verdict"] is None:
                contests.setdefault(self.target_named(name), []).append(ruling | {"place": place})
        for name, asked in contests.items():
            eligible = [one for one in asked if self.has_partners(one, asked)]
            for one in asked:
                if one not in eligible:
                    rulings[one["place"]] |= self.waiting(one, eligible)
            for one, verdict, winner in self.decide(name, eligible) if eligible else ():
                rulings[one["place"]] |= {"verdict": verdict, "winner": winner}
        return self.returned(rulings)

    def given(self, case: dict[str, Any]) -> dict[str, Any]:
        return case

    def returned(self, rulings: list[Ruling]) -> list[Ruling]:
        return rulings

    def refuse(self, ruling: Ruling) -> None:
        """R5.2's tests, in their order."""
        case = self.case
        tests: dict[str, tuple[str, Callable[[Ruling], bool]]] = {
            "over": ("MATCH_OVER", lambda _: case["match_over"]),
            "malformed": ("MALFORMED", lambda one: not self.is_name(one["target"])),
            "inactive": ("HUNTER_INACTIVE", lambda one: one["hunter"] in case["inactive"]),
            "duplicate": ("DUPLICATE", lambda one: one["hunter"] in self.requesters),
            "unknown": (
                "UNKNOWN_TARGET",
                lambda one: self.target_named(one["target"]) is None and one["target"] not in case["caught"],
            ),
            "caught": ("ALREADY_CAUGHT", lambda one: one["target"] in case["caught"]),
            "down": ("SERVICE_DOWN", lambda _: not case["kill_service_up"]),
            "far": ("OUT_OF_REACH", self.far),
        }
        order = ("over", "malformed", "inactive", "down") if case["policy"] == "capstone" else self.order
        ruling["verdict"] = next((tests[test][0] for test in order if tests[test][1](ruling)), None)

    def is_name(self, name: object) -> bool:
        return isinstance(name, str) and len(name) <= 255

    def target_named(self, name: Any) -> str | None:
        """The target that a name stands for."""
        return name if name in self.case["targets"] else None

    def far(self, ruling: Ruling) -> bool:
        x, y = self.case["hunters"][ruling["hunter"]]
        target_x, target_y = self.case["targets"][self.target_named(ruling["target"])]
        metres = self.measure(target_x - x, target_y - y)
        ruling["distance_um"] = self.whole(metres)
        return not self.within(ruling["distance_um"], metres)

    def own_reach(self, seat: int) -> float:
        reach_m = self.case["reach_m"]
        return reach_m if isinstance(reach_m, float) else self.one_of(reach_m, seat)

    def one_of(self, reaches: Sequence[float], seat: int) -> float:
        return reaches[seat]

    def measure(self, dx: float, dy: float) -> float:
        return math.sqrt(dx * dx + dy * dy)

    def whole(self, metres: float) -> int:
        return math.floor(1e6 * metres + 0.5)

    def within(self, distance_um: int, _metres: float) -> bool:
        return distance_um < max(1, self.whole(self.reach_m))

    def note(self, ruling: Ruling) -> None:
        """Make a later request of the hunter a duplicate."""
        self.requesters.add(ruling["hunter"])

    def has_partners(self, one: Ruling, asked: Eligible) -> bool:
        """R5.10: whether enough hunters of its team ask."""
        teams, needed = self.case.get("teams"), self.case.get("hunters_per_catch", 1)
        team = next((team for team in teams or () if one["hunter"] in team), ())
        return needed == 1 or sum(self.is_partner(other, team) for other in asked) >= needed

    def is_partner(self, other: Ruling, team: Sequence[int]) -> bool:
        return other["hunter"] in team

    def waiting(self, _one: Ruling, _eligible: Eligible) -> Ruling:
        return {"verdict": "WAITING_FOR_PARTNER", "winner": None}

    def decide(self, name: str, eligible: Eligible) -> list[tuple[Ruling, str, int | None]]:
        """Each request for a target, its verdict and the winner."""
        winner = self.winner(eligible)
        unnamed = name in self.case["kill_refused"] and len(eligible) == 1
        return [
            (one, self.won(name) if one is winner else "LOST_CONTEST", None if unnamed else winner["hunter"])
            for one in eligible
        ]

    def won(self, name: str) -> str:
        return "KILL_FAILED" if name in self.case["kill_refused"] else "GRANTED"

    def winner(self, eligible: Eligible) -> Ruling:
        if self.case["policy"] == "first_come":
            return min(eligible, key=self.lot)
        least = min(one["distance_um"] for one in eligible)
        return self.of_tied([one for one in eligible if one["distance_um"] == least])

    def of_tied(self, tied: Eligible) -> Ruling:
        return min(tied, key=self.lot)

    def lot(self, one: Ruling) -> bytes:
        """Any hash will do; this is not the appendix's."""
        words = f"{self.case['seed']} {self.case['step']} {one['target']} {one['hunter']}"
        return hashlib.blake2b(words.encode(errors="replace")).digest()


right = PlainArbiter


def seat(one: Ruling) -> int:
    return int(one["hunter"])


def granted(one: Ruling) -> Ruling:
    return one | {"verdict": "GRANTED", "winner": one["hunter"]}


def known_alike(alike: Callable[[str], str]) -> PlainArbiter:
    """Names stand for the target whose name is the same after a change."""
    return PlainArbiter(
        target_named=lambda self, name: next((one for one in self.case["targets"] if alike(one) == alike(name)), None)
    )


def tested(*order: str) -> PlainArbiter:
    """R5.2's tests in another order."""
    return PlainArbiter((*order, *(test for test in ORDER if test not in order)))


def with_case(**changes: Any) -> PlainArbiter:
    """Judged as if the case said something else."""
    return PlainArbiter(given=lambda _, case: case | changes)


def only_the_first_grant(_: Any, rulings: list[Ruling]) -> list[Ruling]:
    for ruling in [one for one in rulings if one["verdict"] == "GRANTED"][1:]:
        ruling["verdict"] = "LOST_CONTEST"
    return rulings


def consoled(self: PlainArbiter, rulings: list[Ruling]) -> list[Ruling]:
    """A loser gets a free target in reach."""
    case = self.case
    free = set(case["targets"]) - {name for _, name in case["requests"] if isinstance(name, str)}
    for ruling in rulings:
        for name in sorted(free) if ruling["verdict"] == "LOST_CONTEST" else []:
            if math.dist(case["hunters"][seat(ruling)], case["targets"][name]) < self.own_reach(seat(ruling)):
                ruling.update(granted(ruling))
    return rulings


def far_from_all(self: PlainArbiter, ruling: Ruling) -> bool:
    """Reach is measured to the nearest target, whichever was named."""
    metres = min(math.dist(self.case["hunters"][seat(ruling)], target) for target in self.case["targets"].values())
    ruling["distance_um"] = self.whole(metres)
    return not self.within(ruling["distance_um"], metres)


def guarded(self: PlainArbiter, name: str, eligible: Eligible) -> list[Any]:
    """A withdrawn hunter that is nearer guards its target."""
    away = [math.dist(hunter, self.case["targets"][name]) for hunter in self.case["hunters"]]
    nearest = away.index(min(away))
    if nearest in self.case["inactive"]:
        return [(one, "LOST_CONTEST", nearest) for one in eligible]
    return right.decide(self, name, eligible)


def refused_compete(self: PlainArbiter, name: str, eligible: Eligible) -> list[Any]:
    """A duplicate is refused in the end, but has won the contest before."""
    rivals = {hunter for hunter, target in self.case["requests"] if target == name}
    nearest = min(rivals, key=lambda hunter: math.dist(self.case["hunters"][hunter], self.case["targets"][name]))
    if nearest not in map(seat, eligible):
        return [(one, "LOST_CONTEST", nearest) for one in eligible]
    return right.decide(self, name, eligible)


def one_after_the_other(self: PlainArbiter, name: str, eligible: Eligible) -> list[Any]:
    first, *others = eligible
    return [(first, self.won(name), seat(first))] + [(one, "ALREADY_CAUGHT", None) for one in others]


def all_tied_win(self: PlainArbiter, name: str, eligible: Eligible) -> list[Any]:
    least = min(one["distance_um"] for one in eligible)
    return [
        (one, "GRANTED", seat(one)) if one["distance_um"] == least else (one, verdict, winner)
        for one, verdict, winner in right.decide(self, name, eligible)
    ]


def nearest_in_floats(self: PlainArbiter, eligible: Eligible) -> Ruling:
    def metres(one: Ruling) -> float:
        return math.dist(self.case["hunters"][seat(one)], self.case["targets"][one["target"]])

    return min(eligible, key=metres) if self.case["policy"] == "nearest" else right.winner(self, eligible)


def drawn_by_a_count(self: PlainArbiter, tied: Eligible) -> Ruling:
    """A fair draw, but a loser that drops out moves it on."""
    number = hashlib.blake2b(f"{self.case['seed']} {self.case['step']}".encode()).digest()[0]
    return sorted(tied, key=seat)[number % len(tied)]


def longest_reach(self: PlainArbiter, eligible: Eligible) -> Ruling:
    longest = max(self.own_reach(seat(one)) for one in eligible)
    return right.winner(self, [one for one in eligible if self.own_reach(seat(one)) == longest])


def partner_nearby(self: PlainArbiter, one: Ruling, asked: Eligible) -> bool:
    """A team-mate within reach is enough, whether or not it asks."""
    team = next((team for team in self.case.get("teams") or () if one["hunter"] in team), ())
    place = self.case["targets"][one["target"]]
    near = [other for other in team if math.dist(self.case["hunters"][other], place) < self.own_reach(other)]
    return right.has_partners(self, one, asked) or len(near) >= self.case["hunters_per_catch"]


def note_the_unrefused(self: PlainArbiter, ruling: Ruling) -> None:
    if ruling["verdict"] is None:
        self.requesters.add(seat(ruling))


def note_the_well_formed(self: PlainArbiter, ruling: Ruling) -> None:
    if ruling["verdict"] != "MALFORMED":
        self.requesters.add(seat(ruling))


def measured_for_all(self: PlainArbiter, ruling: Ruling) -> None:
    right.refuse(self, ruling)
    if isinstance(ruling["target"], str) and ruling["target"] in self.case["targets"]:
        self.far(ruling)


def without(*evidence: str) -> PlainArbiter:
    return PlainArbiter(returned=lambda _, rulings: [ruling | dict.fromkeys(evidence) for ruling in rulings])


KNOWN: dict[str, PlainArbiter] = {
    "first come, first served": PlainArbiter(winner=lambda _, eligible: eligible[0]),
    "last come, first served": PlainArbiter(winner=lambda _, eligible: eligible[-1]),
    "every request is granted": PlainArbiter(returned=lambda _, rulings: list(map(granted, rulings))),
    "every request for an alive target is granted": PlainArbiter(
        returned=lambda self, rulings: [
            granted(one) if one["target"] in list(self.case["targets"]) else one for one in rulings
        ]
    ),
    "every hunter within reach wins": PlainArbiter(
        decide=lambda self, name, eligible: [(one, self.won(name), seat(one)) for one in eligible]
    ),
    "no hunter wins a contest": PlainArbiter(
        decide=lambda self, name, eligible: (
            [(one, "LOST_CONTEST", None) for one in eligible] if eligible[1:] else right.decide(self, name, eligible)
        )
    ),
    "the farthest wins": PlainArbiter(winner=lambda _, eligible: max(eligible, key=lambda one: one["distance_um"])),
    "the lowest seat wins": PlainArbiter(winner=lambda _, eligible: min(eligible, key=seat)),
    "the highest seat wins": PlainArbiter(winner=lambda _, eligible: max(eligible, key=seat)),
    "only one catch per step": PlainArbiter(returned=only_the_first_grant),
    "requests are judged one by one: after a catch the target is gone": PlainArbiter(decide=one_after_the_other),
    "ALREADY_CAUGHT instead of LOST_CONTEST": PlainArbiter(
        returned=lambda _, rulings: [
            one | {"verdict": "ALREADY_CAUGHT"} if one["verdict"] == "LOST_CONTEST" else one for one in rulings
        ]
    ),
    "a loser gets another target": PlainArbiter(returned=consoled),
    "the nearest target is caught, not the requested one": PlainArbiter(far=far_from_all),
    "a withdrawn hunter nearby wins without a request": PlainArbiter(decide=guarded),
    "refused requests win contests": PlainArbiter(decide=refused_compete),
    "reach is tested with <=": PlainArbiter(within=lambda self, um, _: um <= self.whole(self.reach_m)),
    "reach is tested in floats": PlainArbiter(within=lambda self, _, metres: metres < self.reach_m),
    "reach is tested in floats, with <=": PlainArbiter(within=lambda self, _, metres: metres <= self.reach_m),
    "reach is not tested": PlainArbiter(within=lambda *_: True),
    "reach is always 0.3 m, and reach_m is ignored": PlainArbiter(within=lambda _self, um, _: um < 300_000),
    "a reach below one micrometre catches nothing": PlainArbiter(
        within=lambda self, um, _: um < self.whole(self.reach_m)
    ),
    "every hunter has the longest reach": PlainArbiter(one_of=lambda _self, reaches, _: max(reaches)),
    "every hunter has the shortest reach": PlainArbiter(one_of=lambda _self, reaches, _: min(reaches)),
    "every hunter has the reach of hunter 0": PlainArbiter(one_of=lambda _self, reaches, _: reaches[0]),
    "the hunter with the longer reach wins": PlainArbiter(winner=longest_reach),
    "distances are truncated, not rounded": PlainArbiter(whole=lambda _, metres: int(1e6 * metres)),
    "distances are rounded to millimetres": PlainArbiter(whole=lambda _, metres: 1000 * round(1e3 * metres)),
    "the distance is dx + dy": PlainArbiter(measure=lambda _, dx, dy: abs(dx) + abs(dy)),
    "the distance is the larger of dx and dy": PlainArbiter(measure=lambda _, dx, dy: max(abs(dx), abs(dy))),
    "the distance is dx alone": PlainArbiter(measure=lambda _self, dx, _: abs(dx)),
    "the distance is squared: the square root is missing": PlainArbiter(measure=lambda _, dx, dy: dx * dx + dy * dy),
    "ties go to the lowest seat": PlainArbiter(of_tied=lambda _, tied: min(tied, key=seat)),
    "ties go to the first request": PlainArbiter(of_tied=lambda _, tied: tied[0]),
    "every tied hunter wins": PlainArbiter(decide=all_tied_win),
    "a lot is drawn wrongly": PlainArbiter(of_tied=drawn_by_a_count),
    "the nearest is found in floats, not in whole micrometres": PlainArbiter(winner=nearest_in_floats),
    "DUPLICATE is never given": PlainArbiter(note=lambda *_: None),
    "a hunter's last request stands, not its first": PlainArbiter(
        given=lambda _, case: case | {"requests": case["requests"][::-1]}, returned=lambda _, rulings: rulings[::-1]
    ),
    "a refused request does not count as the first": PlainArbiter(note=note_the_unrefused),
    "a malformed request does not count as the first": PlainArbiter(note=note_the_well_formed),
    "DUPLICATE is tested before MALFORMED": tested("over", "duplicate"),
    "DUPLICATE is tested only after ALREADY_CAUGHT": tested("over", "malformed", "inactive", "unknown", "caught"),
    "HUNTER_INACTIVE is tested before MALFORMED": tested("over", "inactive"),
    "HUNTER_INACTIVE is tested only after ALREADY_CAUGHT": tested(
        "over", "malformed", "duplicate", "unknown", "caught"
    ),
    "OUT_OF_REACH is tested before SERVICE_DOWN": tested(*ORDER[:6], "far"),
    "SERVICE_DOWN is tested before MALFORMED": tested("over", "down"),
    "MALFORMED is tested before MATCH_OVER": tested("malformed"),
    "HUNTER_INACTIVE is never given": with_case(inactive=()),
    "SERVICE_DOWN is never given": with_case(kill_service_up=True),
    "MATCH_OVER is never given": with_case(match_over=False),
    "UNKNOWN_TARGET instead of ALREADY_CAUGHT": with_case(caught=()),
    "a refused kill is GRANTED": PlainArbiter(won=lambda *_: "GRANTED"),
    "one refused kill refuses all of its step": PlainArbiter(
        won=lambda self, _: "KILL_FAILED" if self.case["kill_refused"] else "GRANTED"
    ),
    "after a refused kill the losers get KILL_FAILED too": PlainArbiter(
        decide=lambda self, name, eligible: [
            (one, "KILL_FAILED" if name in self.case["kill_refused"] else verdict, winner)
            for one, verdict, winner in right.decide(self, name, eligible)
        ]
    ),
    "hunters_per_catch is ignored": with_case(hunters_per_catch=1),
    "hunters of different teams are partners": PlainArbiter(is_partner=lambda *_: True),
    "a team-mate within reach is a partner, and need not ask": PlainArbiter(has_partners=partner_nearby),
    "LOST_CONTEST instead of WAITING_FOR_PARTNER if another team has enough": PlainArbiter(
        waiting=lambda self, one, eligible: (
            {"verdict": "LOST_CONTEST", "winner": seat(right.winner(self, eligible))}
            if eligible
            else right.waiting(self, one, eligible)
        )
    ),
    "the partners are granted the target too": PlainArbiter(
        decide=lambda self, name, eligible: [
            (one, self.won(name) if self.case.get("hunters_per_catch", 1) > 1 else verdict, winner)
            for one, verdict, winner in right.decide(self, name, eligible)
        ]
    ),
    "the policy is always nearest": with_case(policy="nearest"),
    "the policy is always capstone": with_case(policy="capstone"),
    "no evidence is given": without("distance_um", "winner"),
    "no distance is given": without("distance_um"),
    "no winner is given": without("winner"),
    "only a granted request has the winner": PlainArbiter(
        returned=lambda _, rulings: [one if one["verdict"] == "GRANTED" else one | {"winner": None} for one in rulings]
    ),
    "every ruling has a distance": PlainArbiter(refuse=measured_for_all),
    "distances are in millimetres": PlainArbiter(
        returned=lambda _, rulings: [
            one | {"distance_um": None if one["distance_um"] is None else round(one["distance_um"] / 1000)}
            for one in rulings
        ]
    ),
    "the rulings are not in the order of the requests": PlainArbiter(
        returned=lambda _, rulings: sorted(rulings, key=lambda ruling: str(ruling["target"]))
    ),
    "names are compared without regard to case": known_alike(str.casefold),
    "names are normalised (NFC) before they are compared": known_alike(partial(unicodedata.normalize, "NFC")),
    "names are normalised (NFKC) before they are compared": known_alike(partial(unicodedata.normalize, "NFKC")),
    "spaces around names are ignored": PlainArbiter(
        target_named=lambda self, name: right.target_named(self, name.strip())
    ),
    "a name ends at its first NUL": PlainArbiter(
        target_named=lambda self, name: right.target_named(self, name.partition("\0")[0])
    ),
    "a prefix of a name is accepted": PlainArbiter(
        target_named=lambda self, name: next((one for one in self.case["targets"] if one.startswith(name)), None)
    ),
    "the length of a name is counted in bytes": PlainArbiter(
        is_name=lambda _, name: isinstance(name, str) and len(name.encode()) <= 255
    ),
    "names of 256 characters are allowed": PlainArbiter(
        is_name=lambda _, name: isinstance(name, str) and len(name) <= 256
    ),
    "an empty name is MALFORMED": PlainArbiter(is_name=lambda self, name: bool(name) and right.is_name(self, name)),
    "anything is a name": PlainArbiter(
        given=lambda _, case: case | {"requests": [(hunter, str(name)) for hunter, name in case["requests"]]}
    ),
}
"""An arbiter for each mistake, by its name in catch_arena/conformance/mistakes.toml and in that order."""

"""A right arbiter, plain enough to be bent, and wrong ones that differ from it in one thing each.

They prove the suite: each must be caught by the group of cases that is about its mistake.
"""

# ruff: noqa: ARG002 - many mistakes consist in not looking at something

import hashlib
import math
import unicodedata
from collections.abc import Sequence
from typing import Any

Eligible = list[dict[str, Any]]
"""Requests for one target, with `place` among the requests, `hunter`, `inactive` and `distance_um`."""


class PlainArbiter:
    """Right in every case, but for lots of its own."""

    order = ("over", "malformed", "inactive", "duplicate", "unknown", "caught", "down", "far")

    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        self.case = case
        self.asked: set[int] = set()
        rulings, contests = [], {}
        for place, (hunter, name) in enumerate(case["requests"]):
            ruling = {"verdict": None, "hunter": hunter, "target": name, "distance_um": None, "winner": None}
            rulings.append(ruling)
            self.reach_m = self.own_reach(hunter)
            self.refuse(ruling)
            self.note(ruling)
            if ruling["verdict"] is None and case["policy"] == "capstone":
                ruling |= {"verdict": "GRANTED", "winner": hunter}
            elif ruling["verdict"] is None:
                contests.setdefault(self.known_as(name), []).append(ruling | {"place": place})
        for name, eligible in contests.items():
            for one, verdict, winner in self.decide(name, eligible):
                rulings[one["place"]] |= {"verdict": verdict, "winner": winner}
        return rulings

    def refuse(self, ruling: dict[str, Any]) -> None:
        """R5.2's tests, in their order."""
        tests = {
            "over": ("MATCH_OVER", self.over),
            "malformed": ("MALFORMED", lambda one: not self.is_name(one["target"])),
            "inactive": ("HUNTER_INACTIVE", self.withdrawn),
            "duplicate": ("DUPLICATE", lambda one: one["hunter"] in self.asked),
            "unknown": ("UNKNOWN_TARGET", self.unknown),
            "caught": ("ALREADY_CAUGHT", lambda one: one["target"] in self.case["caught"]),
            "down": ("SERVICE_DOWN", lambda _: not self.case["kill_service_up"]),
            "far": ("OUT_OF_REACH", self.far),
        }
        order = self.order
        if self.case["policy"] == "capstone":
            order = ("over", "malformed", "inactive", "down")
        for test in order:
            verdict, fails = tests[test]
            if fails(ruling):
                ruling["verdict"] = verdict
                return

    def over(self, _: dict[str, Any]) -> bool:
        return bool(self.case["match_over"])

    def is_name(self, name: object) -> bool:
        return isinstance(name, str) and len(name) <= 255

    def withdrawn(self, ruling: dict[str, Any]) -> bool:
        return ruling["hunter"] in self.case["inactive"]

    def known_as(self, name: Any) -> str | None:
        """The target that a name stands for."""
        return name if name in self.case["targets"] else None

    def unknown(self, ruling: dict[str, Any]) -> bool:
        return self.known_as(ruling["target"]) is None and ruling["target"] not in self.case["caught"]

    def far(self, ruling: dict[str, Any]) -> bool:
        x, y = self.case["hunters"][ruling["hunter"]]
        target_x, target_y = self.case["targets"][self.known_as(ruling["target"])]
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

    def within(self, distance_um: int, metres: float) -> bool:
        del metres
        return distance_um < max(1, self.whole(self.reach_m))

    def note(self, ruling: dict[str, Any]) -> None:
        """What makes a later request of the hunter a duplicate."""
        self.asked.add(ruling["hunter"])

    def decide(self, name: str, eligible: Eligible) -> list[tuple[dict[str, Any], str, int | None]]:
        winner = self.winner(eligible)
        refused = name in self.case["kill_refused"]
        return [
            (
                one,
                self.won(refused=refused) if one is winner else "LOST_CONTEST",
                None if refused and len(eligible) == 1 else winner["hunter"],
            )
            for one in eligible
        ]

    def won(self, *, refused: bool) -> str:
        return "KILL_FAILED" if refused else "GRANTED"

    def winner(self, eligible: Eligible) -> dict[str, Any]:
        if self.case["policy"] == "first_come":
            return min(eligible, key=self.lot)
        least = min(one["distance_um"] for one in eligible)
        return self.of_tied([one for one in eligible if one["distance_um"] == least])

    def of_tied(self, tied: Eligible) -> dict[str, Any]:
        return min(tied, key=self.lot)

    def lot(self, one: dict[str, Any]) -> bytes:
        """Any hash will do; this is not the appendix's."""
        words = f"{self.case['seed']} {self.case['step']} {one['target']} {one['hunter']}"
        return hashlib.blake2b(words.encode(errors="replace")).digest()


class FirstCome(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        return eligible[0]


class Farthest(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        return max(eligible, key=lambda one: one["distance_um"])


class LowSeatWins(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        return min(eligible, key=lambda one: one["hunter"])


class SuccessForEverybody(PlainArbiter):
    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        return [(one, self.won(refused=name in self.case["kill_refused"]), one["hunter"]) for one in eligible]


class NobodyWinsAContest(PlainArbiter):
    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        decided = super().decide(name, eligible)
        return decided if len(eligible) == 1 else [(one, "LOST_CONTEST", None) for one in eligible]


class NoReachCheck(PlainArbiter):
    def within(self, distance_um: int, metres: float) -> bool:
        return True


class ReachInclusive(PlainArbiter):
    def within(self, distance_um: int, metres: float) -> bool:
        return distance_um <= max(1, self.whole(self.reach_m))


class ReachInFloats(PlainArbiter):
    def within(self, distance_um: int, metres: float) -> bool:
        return metres < self.reach_m


class ReachAlwaysTheDefault(PlainArbiter):
    def within(self, distance_um: int, metres: float) -> bool:
        return distance_um < 300_000


class ReachOfNothing(PlainArbiter):
    def within(self, distance_um: int, metres: float) -> bool:
        return distance_um < self.whole(self.reach_m)


class CutOff(PlainArbiter):
    def whole(self, metres: float) -> int:
        return int(1e6 * metres)


class MeasuresBySum(PlainArbiter):
    def measure(self, dx: float, dy: float) -> float:
        return abs(dx) + abs(dy)


class MeasuresByLargest(PlainArbiter):
    def measure(self, dx: float, dy: float) -> float:
        return max(abs(dx), abs(dy))


class MeasuresAlongX(PlainArbiter):
    def measure(self, dx: float, dy: float) -> float:
        return abs(dx)


class TiesToTheLowSeat(PlainArbiter):
    def of_tied(self, tied: Eligible) -> dict[str, Any]:
        return min(tied, key=lambda one: one["hunter"])


class TiesToTheFirst(PlainArbiter):
    def of_tied(self, tied: Eligible) -> dict[str, Any]:
        return tied[0]


class TiesToAll(PlainArbiter):
    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        least = min(one["distance_um"] for one in eligible)
        tied = [one["distance_um"] == least for one in eligible]
        decided = super().decide(name, eligible)
        return [
            (one, self.won(refused=False), one["hunter"]) if is_tied else ruling
            for one, is_tied, ruling in zip(eligible, tied, decided, strict=True)
        ]


class TiesByACount(PlainArbiter):
    """Draws fairly, but a loser that drops out moves the draw on."""

    def of_tied(self, tied: Eligible) -> dict[str, Any]:
        number = hashlib.blake2b(f"{self.case['seed']} {self.case['step']}".encode()).digest()[0]
        return sorted(tied, key=lambda one: one["hunter"])[number % len(tied)]


class TiesInFloats(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        def metres(one: dict[str, Any]) -> float:
            (x, y), (tx, ty) = self.case["hunters"][one["hunter"]], self.case["targets"][one["target"]]
            return math.hypot(tx - x, ty - y)

        return min(eligible, key=metres) if self.case["policy"] == "nearest" else super().winner(eligible)


class TheNearestBlocks(PlainArbiter):
    """A withdrawn hunter that is nearer guards its target."""

    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        decided = super().decide(name, eligible)
        x, y = self.case["targets"][name]
        nearest = min(range(len(self.case["hunters"])), key=lambda h: math.dist(self.case["hunters"][h], (x, y)))
        if nearest in self.case["inactive"]:
            return [(one, "LOST_CONTEST", nearest) for one in eligible]
        return decided


class DuplicatesCompete(PlainArbiter):
    """A duplicate is refused in the end, but has won the contest before."""

    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        rivals = {hunter for hunter, asked in self.case["requests"] if asked == name}
        away = {hunter: math.dist(self.case["hunters"][hunter], self.case["targets"][name]) for hunter in rivals}
        nearest = min(away, key=lambda hunter: away[hunter])
        if nearest not in {one["hunter"] for one in eligible}:
            return [(one, "LOST_CONTEST", nearest) for one in eligible]
        return super().decide(name, eligible)


class OneCatchAStep(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        rulings = super().__call__(**case)
        for ruling in [one for one in rulings if one["verdict"] == "GRANTED"][1:]:
            ruling["verdict"] = "LOST_CONTEST"
        return rulings


class Consoles(PlainArbiter):
    """A loser gets a free target in reach instead."""

    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        rulings = super().__call__(**case)
        free = set(case["targets"]) - {name for _, name in case["requests"] if isinstance(name, str)}
        for ruling in rulings:
            for name in sorted(free) if ruling["verdict"] == "LOST_CONTEST" else []:
                if math.dist(case["hunters"][ruling["hunter"]], case["targets"][name]) < self.own_reach(
                    ruling["hunter"]
                ):
                    ruling |= {"verdict": "GRANTED", "winner": ruling["hunter"]}
        return rulings


class GivesTheNearestTarget(PlainArbiter):
    """Reach is measured to whichever target is nearest."""

    def far(self, ruling: dict[str, Any]) -> bool:
        place = self.case["hunters"][ruling["hunter"]]
        metres = min(math.dist(place, target) for target in self.case["targets"].values())
        ruling["distance_um"] = self.whole(metres)
        return not self.within(ruling["distance_um"], metres)


class FoldsCase(PlainArbiter):
    def known_as(self, name: Any) -> str | None:
        return next((known for known in self.case["targets"] if known.casefold() == name.casefold()), None)


class Normalises(PlainArbiter):
    form = "NFC"

    def known_as(self, name: Any) -> str | None:
        def same(word: str) -> str:
            return unicodedata.normalize(self.form, word)

        return next((known for known in self.case["targets"] if same(known) == same(name)), None)


class NormalisesDigits(Normalises):
    form = "NFKC"


class Trims(PlainArbiter):
    def known_as(self, name: Any) -> str | None:
        return super().known_as(name.strip())


class EndsNamesAtZero(PlainArbiter):
    def known_as(self, name: Any) -> str | None:
        return super().known_as(name.partition("\0")[0])


class KnowsPrefixes(PlainArbiter):
    def known_as(self, name: Any) -> str | None:
        return next((known for known in self.case["targets"] if known.startswith(name)), None)


class CountsBytes(PlainArbiter):
    def is_name(self, name: object) -> bool:
        return isinstance(name, str) and len(name.encode()) <= 255


class CountsTo256(PlainArbiter):
    def is_name(self, name: object) -> bool:
        return isinstance(name, str) and len(name) <= 256


class EmptyIsMalformed(PlainArbiter):
    def is_name(self, name: object) -> bool:
        return bool(name) and super().is_name(name)


class AnythingIsAName(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return super().__call__(**{**case, "requests": [(hunter, str(name)) for hunter, name in case["requests"]]})


class LooksUpFirst(PlainArbiter):
    """Crashes where the name cannot be hashed."""

    def is_name(self, name: object) -> bool:
        return name in self.case["targets"] or super().is_name(name)


class NoDuplicates(PlainArbiter):
    def note(self, ruling: dict[str, Any]) -> None:
        """Everything is judged, however often."""


class LastRequestStands(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return super().__call__(**{**case, "requests": case["requests"][::-1]})[::-1]


class RefusalsAreNotSpent(PlainArbiter):
    def note(self, ruling: dict[str, Any]) -> None:
        if ruling["verdict"] is None:
            self.asked.add(ruling["hunter"])


class MalformedIsNotSpent(PlainArbiter):
    def note(self, ruling: dict[str, Any]) -> None:
        if ruling["verdict"] != "MALFORMED":
            self.asked.add(ruling["hunter"])


class DuplicateBeforeMalformed(PlainArbiter):
    order = ("over", "duplicate", "malformed", "inactive", "unknown", "caught", "down", "far")


class NameBeforeDuplicate(PlainArbiter):
    order = ("over", "malformed", "inactive", "unknown", "caught", "duplicate", "down", "far")


class InactiveBeforeMalformed(PlainArbiter):
    order = ("over", "inactive", "malformed", "duplicate", "unknown", "caught", "down", "far")


class InactiveAfterNames(PlainArbiter):
    order = ("over", "malformed", "duplicate", "unknown", "caught", "inactive", "down", "far")


class IgnoresWithdrawals(PlainArbiter):
    def withdrawn(self, ruling: dict[str, Any]) -> bool:
        return False


class ReachBeforeService(PlainArbiter):
    order = ("over", "malformed", "inactive", "duplicate", "unknown", "caught", "far", "down")


class ServiceFirst(PlainArbiter):
    order = ("over", "down", "malformed", "inactive", "duplicate", "unknown", "caught", "far")


class CreditsRefusedKills(PlainArbiter):
    def won(self, *, refused: bool) -> str:
        return "GRANTED"


class FaultsSpread(PlainArbiter):
    def won(self, *, refused: bool) -> str:
        return "KILL_FAILED" if self.case["kill_refused"] else "GRANTED"


class TriesTheNext(PlainArbiter):
    """After a refused kill the next nearest is told that it failed, too."""

    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        decided = super().decide(name, eligible)
        refused = name in self.case["kill_refused"]
        return [(one, "KILL_FAILED", winner) if refused else (one, verdict, winner) for one, verdict, winner in decided]


class PlaysOn(PlainArbiter):
    def over(self, _: dict[str, Any]) -> bool:
        return False


class EndsAfterTheForm(PlainArbiter):
    order = ("malformed", "over", "inactive", "duplicate", "unknown", "caught", "down", "far")


class ForgetsTheCaught(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return super().__call__(**{**case, "caught": []})


class OneAfterTheOther(PlainArbiter):
    """Losers are told that the target was caught before."""

    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        return [
            (one, "ALREADY_CAUGHT" if verdict == "LOST_CONTEST" else verdict, winner)
            for one, verdict, winner in super().decide(name, eligible)
        ]


class AlwaysNearest(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return super().__call__(**{**case, "policy": "nearest"})


class AlwaysCapstone(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return super().__call__(**{**case, "policy": "capstone"})


class LongestReachForAll(PlainArbiter):
    def one_of(self, reaches: Sequence[float], seat: int) -> float:
        del seat
        return max(reaches)


class ShortestReachForAll(PlainArbiter):
    def one_of(self, reaches: Sequence[float], seat: int) -> float:
        del seat
        return min(reaches)


class ReachOfHunter0ForAll(PlainArbiter):
    def one_of(self, reaches: Sequence[float], seat: int) -> float:
        del seat
        return reaches[0]


class LongestReachWins(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        longest = max(self.own_reach(one["hunter"]) for one in eligible)
        return super().winner([one for one in eligible if self.own_reach(one["hunter"]) == longest])


class LosersDoNotLearnTheWinner(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        rulings = super().__call__(**case)
        for ruling in rulings:
            ruling["winner"] = ruling["winner"] if ruling["verdict"] == "GRANTED" else None
        return rulings


class DistanceForEverybody(PlainArbiter):
    def refuse(self, ruling: dict[str, Any]) -> None:
        super().refuse(ruling)
        if isinstance(ruling["target"], str) and ruling["target"] in self.case["targets"]:
            self.far(ruling)


class LastCome(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        return eligible[-1]


class HighSeatWins(PlainArbiter):
    def winner(self, eligible: Eligible) -> dict[str, Any]:
        return max(eligible, key=lambda one: one["hunter"])


class YesToEverybody(PlainArbiter):
    """The service of the exercise."""

    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return [ruling | {"verdict": "GRANTED", "winner": ruling["hunter"]} for ruling in super().__call__(**case)]


class YesToEverybodyWhoNamesATarget(PlainArbiter):
    """The same, if it looks at its list."""

    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return [
            ruling | {"verdict": "GRANTED", "winner": ruling["hunter"]}
            if ruling["target"] in list(case["targets"])
            else ruling
            for ruling in super().__call__(**case)
        ]


class ReachInFloatsInclusive(PlainArbiter):
    def within(self, distance_um: int, metres: float) -> bool:
        return metres <= self.reach_m


class SquaredDistance(PlainArbiter):
    def measure(self, dx: float, dy: float) -> float:
        return dx * dx + dy * dy


class RoundsToMillimetres(PlainArbiter):
    def whole(self, metres: float) -> int:
        return 1000 * round(1e3 * metres)


class SortsByTarget(PlainArbiter):
    """Goes target by target, and answers so."""

    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return sorted(super().__call__(**case), key=lambda ruling: str(ruling["target"]))


class IgnoresTheService(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return super().__call__(**{**case, "kill_service_up": True})


class CatchesAtOnce(PlainArbiter):
    """One request after the other: who comes after a catch asks for a target that is gone."""

    def decide(self, name: str, eligible: Eligible) -> list[Any]:
        first, *others = eligible
        refused = name in self.case["kill_refused"]
        return [(first, self.won(refused=refused), first["hunter"])] + [(one, "ALREADY_CAUGHT", None) for one in others]


class GivesNoEvidence(PlainArbiter):
    evidence: Sequence[str] = ("distance_um", "winner")

    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return [ruling | dict.fromkeys(self.evidence) for ruling in super().__call__(**case)]


class GivesNoDistance(GivesNoEvidence):
    evidence = ("distance_um",)


class GivesNoWinner(GivesNoEvidence):
    evidence = ("winner",)


class GivesMillimetres(PlainArbiter):
    def __call__(self, **case: Any) -> list[dict[str, Any]]:
        return [
            ruling | {"distance_um": None if (um := ruling["distance_um"]) is None else round(um / 1000)}
            for ruling in super().__call__(**case)
        ]


NEAREST = "The nearest hunter within reach wins; the order of requests and the seat do not matter (R5.4)."
LOT = "A lot decides a tie; it depends on the seed, the step, the target and the tied seats (R5.5)."
REACH = "A target is within reach if distance_um < reach_um: 299999 is, 300000 is not (R5.3)."
OWN_REACH = "Each hunter has its own reach. It limits catches and does not decide contests (R2.7, R5.3, R5.4)."
DISTANCE = "The distance is floor(1e6 * sqrt(dx * dx + dy * dy) + 0.5) micrometres (R5.3)."
ORDER = "The tests have a fixed order: MATCH_OVER, MALFORMED, HUNTER_INACTIVE, DUPLICATE, and so on (R5.2)."
FIRST_STANDS = "A hunter's first request in a step counts, whatever its verdict; later ones are DUPLICATE (R5.2)."
NAME = "A name is any string of at most 255 characters; anything else is MALFORMED (R5.2)."
SAME_NAME = "A name matches only the target with exactly that name (R5.2)."
REFUSED = "If a kill is refused, the winner gets KILL_FAILED, the others get LOST_CONTEST, and no hunter scores (R5.7)."
EVIDENCE = "The distance is given if reach was tested, the winner if there was a contest or a grant (R5.6)."
APART = "All requests of a step are judged on the state at its beginning (R5.1)."
ELIGIBLE = "Only requests that pass every test of R5.2 take part in a contest (R5.1, R5.5)."
POLICY = "The policy decides contests: nearest, first_come (by lot, not by order) or capstone (R5.9, R9.1)."

KNOWN: dict[type[PlainArbiter], tuple[str, str]] = {
    FirstCome: ("first come, first served", NEAREST),
    LastCome: ("last come, first served", NEAREST),
    YesToEverybody: (
        "every request is granted",
        "A request must pass every test of R5.2, and only one hunter wins a target (R5.4).",
    ),
    YesToEverybodyWhoNamesATarget: ("every request for an alive target is granted", REACH),
    SuccessForEverybody: ("every hunter within reach wins", NEAREST),
    NobodyWinsAContest: ("no hunter wins a contest", NEAREST),
    Farthest: ("the farthest wins", NEAREST),
    LowSeatWins: ("the lowest seat wins", NEAREST),
    HighSeatWins: ("the highest seat wins", NEAREST),
    OneCatchAStep: ("only one catch per step", APART),
    CatchesAtOnce: ("requests are judged one by one: after a catch the target is gone", APART),
    OneAfterTheOther: (
        "ALREADY_CAUGHT instead of LOST_CONTEST",
        "LOST_CONTEST means: another hunter was preferred (R5.6).",
    ),
    Consoles: ("a loser gets another target", "A request is for the target that it names (R5.1)."),
    GivesTheNearestTarget: ("the nearest target is caught, not the requested one", ELIGIBLE),
    TheNearestBlocks: ("a withdrawn hunter nearby wins without a request", ELIGIBLE),
    DuplicatesCompete: ("refused requests win contests", ELIGIBLE),
    ReachInclusive: ("reach is tested with <=", REACH),
    ReachInFloats: ("reach is tested in floats", REACH),
    ReachInFloatsInclusive: ("reach is tested in floats, with <=", REACH),
    NoReachCheck: ("reach is not tested", REACH),
    ReachAlwaysTheDefault: ("reach is always 0.3 m, and reach_m is ignored", REACH),
    ReachOfNothing: ("a reach below one micrometre catches nothing", "reach_um is at least 1 (R5.3)."),
    LongestReachForAll: ("every hunter has the longest reach", OWN_REACH),
    ShortestReachForAll: ("every hunter has the shortest reach", OWN_REACH),
    ReachOfHunter0ForAll: ("every hunter has the reach of hunter 0", OWN_REACH),
    LongestReachWins: ("the hunter with the longer reach wins", OWN_REACH),
    CutOff: ("distances are truncated, not rounded", DISTANCE),
    RoundsToMillimetres: ("distances are rounded to millimetres", DISTANCE),
    MeasuresBySum: ("the distance is dx + dy", DISTANCE),
    MeasuresByLargest: ("the distance is the larger of dx and dy", DISTANCE),
    MeasuresAlongX: ("the distance is dx alone", DISTANCE),
    SquaredDistance: ("the distance is squared: the square root is missing", DISTANCE),
    TiesToTheLowSeat: ("ties go to the lowest seat", LOT),
    TiesToTheFirst: ("ties go to the first request", LOT),
    TiesToAll: ("every tied hunter wins", LOT),
    TiesByACount: ("a lot is drawn wrongly", LOT),
    TiesInFloats: ("the nearest is found in floats, not in whole micrometres", NEAREST),
    FoldsCase: ("names are compared without regard to case", SAME_NAME),
    Normalises: ("names are normalised (NFC) before they are compared", SAME_NAME),
    NormalisesDigits: ("names are normalised (NFKC) before they are compared", SAME_NAME),
    Trims: ("spaces around names are ignored", SAME_NAME),
    EndsNamesAtZero: ("a name ends at its first NUL", SAME_NAME),
    KnowsPrefixes: ("a prefix of a name is accepted", SAME_NAME),
    CountsBytes: ("the length of a name is counted in bytes", NAME),
    CountsTo256: ("names of 256 characters are allowed", NAME),
    EmptyIsMalformed: ("an empty name is MALFORMED", NAME),
    AnythingIsAName: ("anything is a name", NAME),
    NoDuplicates: ("DUPLICATE is never given", FIRST_STANDS),
    LastRequestStands: ("a hunter's last request stands, not its first", FIRST_STANDS),
    RefusalsAreNotSpent: ("a refused request does not count as the first", FIRST_STANDS),
    MalformedIsNotSpent: ("a malformed request does not count as the first", FIRST_STANDS),
    DuplicateBeforeMalformed: ("DUPLICATE is tested before MALFORMED", ORDER),
    NameBeforeDuplicate: ("DUPLICATE is tested only after ALREADY_CAUGHT", ORDER),
    InactiveBeforeMalformed: ("HUNTER_INACTIVE is tested before MALFORMED", ORDER),
    InactiveAfterNames: ("HUNTER_INACTIVE is tested only after ALREADY_CAUGHT", ORDER),
    ReachBeforeService: ("OUT_OF_REACH is tested before SERVICE_DOWN", ORDER),
    ServiceFirst: ("SERVICE_DOWN is tested before MALFORMED", ORDER),
    EndsAfterTheForm: ("MALFORMED is tested before MATCH_OVER", ORDER),
    IgnoresWithdrawals: ("HUNTER_INACTIVE is never given", "A withdrawn hunter's requests are refused (R1.6, R5.2)."),
    IgnoresTheService: ("SERVICE_DOWN is never given", "While the kill service is down, no target is caught (R5.7)."),
    PlaysOn: ("MATCH_OVER is never given", "After the end every request is refused (R5.2)."),
    ForgetsTheCaught: (
        "UNKNOWN_TARGET instead of ALREADY_CAUGHT",
        "The names of caught targets stay known (R3.4, R5.2).",
    ),
    CreditsRefusedKills: ("a refused kill is GRANTED", REFUSED),
    FaultsSpread: ("one refused kill refuses all of its step", REFUSED),
    TriesTheNext: ("after a refused kill the losers get KILL_FAILED too", REFUSED),
    AlwaysNearest: ("the policy is always nearest", POLICY),
    AlwaysCapstone: ("the policy is always capstone", POLICY),
    GivesNoEvidence: ("no evidence is given", "Rulings need evidence; until they have it, use --verdicts-only (R5.6)."),
    GivesNoDistance: ("no distance is given", EVIDENCE),
    GivesNoWinner: ("no winner is given", EVIDENCE),
    LosersDoNotLearnTheWinner: ("only a granted request has the winner", EVIDENCE),
    DistanceForEverybody: ("every ruling has a distance", EVIDENCE),
    GivesMillimetres: ("distances are in millimetres", DISTANCE),
    SortsByTarget: (
        "the rulings are not in the order of the requests",
        "There is one ruling for each request, in their order (`catch-arena docs conformance`).",
    ),
}
"""What each is called in catch_arena/conformance/mistakes.toml, and what the rulebook says."""


WRONG: Sequence[tuple[type[PlainArbiter], str]] = (
    (OneCatchAStep, "basics"),
    (Consoles, "basics"),
    (GivesTheNearestTarget, "basics"),
    (NoReachCheck, "reach"),
    (ReachInclusive, "reach"),
    (ReachInFloats, "reach"),
    (ReachAlwaysTheDefault, "reach"),
    (LongestReachForAll, "handicaps"),
    (ShortestReachForAll, "handicaps"),
    (ReachOfHunter0ForAll, "handicaps"),
    (LongestReachWins, "handicaps"),
    (ReachOfNothing, "reach"),
    (CutOff, "reach"),
    (MeasuresBySum, "reach"),
    (MeasuresByLargest, "reach"),
    (MeasuresAlongX, "reach"),
    (FoldsCase, "names"),
    (Normalises, "names"),
    (NormalisesDigits, "names"),
    (Trims, "names"),
    (EndsNamesAtZero, "names"),
    (KnowsPrefixes, "names"),
    (CountsBytes, "names"),
    (CountsTo256, "names"),
    (EmptyIsMalformed, "names"),
    (AnythingIsAName, "names"),
    (LooksUpFirst, "names"),
    (FirstCome, "claimants"),
    (Farthest, "claimants"),
    (LowSeatWins, "claimants"),
    (SuccessForEverybody, "claimants"),
    (NobodyWinsAContest, "claimants"),
    (LosersDoNotLearnTheWinner, "claimants"),
    (MeasuresBySum, "claimants"),
    (MeasuresByLargest, "claimants"),
    (TiesToTheLowSeat, "ties"),
    (TiesToTheFirst, "ties"),
    (TiesToAll, "ties"),
    (TiesByACount, "ties"),
    (TiesInFloats, "ties"),
    (TheNearestBlocks, "eligibility"),
    (DuplicatesCompete, "eligibility"),
    (NoDuplicates, "duplicates"),
    (LastRequestStands, "duplicates"),
    (RefusalsAreNotSpent, "duplicates"),
    (MalformedIsNotSpent, "duplicates"),
    (DuplicateBeforeMalformed, "duplicates"),
    (NameBeforeDuplicate, "duplicates"),
    (DistanceForEverybody, "duplicates"),
    (ReachBeforeService, "outages"),
    (ServiceFirst, "outages"),
    (CreditsRefusedKills, "outages"),
    (FaultsSpread, "outages"),
    (TriesTheNext, "outages"),
    (PlaysOn, "time"),
    (EndsAfterTheForm, "time"),
    (IgnoresWithdrawals, "inactive"),
    (InactiveBeforeMalformed, "inactive"),
    (InactiveAfterNames, "inactive"),
    (ForgetsTheCaught, "identity"),
    (OneAfterTheOther, "identity"),
    (AlwaysNearest, "policies"),
    (AlwaysNearest, "capstone"),
    (AlwaysCapstone, "capstone"),
)
"""Each wrong arbiter, and the group of cases that must catch it."""

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


WRONG: Sequence[tuple[type[PlainArbiter], str, str]] = (
    (OneCatchAStep, "basics", "only one catch in a step"),
    (Consoles, "basics", "GRANTED where LOST_CONTEST is right (R5.1)"),
    (GivesTheNearestTarget, "basics", "the nearest target is given, whichever was named"),
    (NoReachCheck, "reach", "reach is not tested"),
    (ReachInclusive, "reach", "within reach is tested with <="),
    (ReachInFloats, "reach", "reach is tested in floats"),
    (ReachAlwaysTheDefault, "reach", "reach is 0.3 m whatever reach_m says"),
    (LongestReachForAll, "handicaps", "all have the longest reach"),
    (ShortestReachForAll, "handicaps", "all have the shortest reach"),
    (ReachOfHunter0ForAll, "handicaps", "all have the reach of hunter 0"),
    (LongestReachWins, "handicaps", "who reaches farther wins"),
    (ReachOfNothing, "reach", "a reach of less than a micrometre lets nobody in"),
    (CutOff, "reach", "distances are cut off, not rounded"),
    (MeasuresBySum, "reach", "the distance is dx + dy"),
    (MeasuresByLargest, "reach", "the distance is the larger one of dx and dy"),
    (MeasuresAlongX, "reach", "the distance is dx alone"),
    (FoldsCase, "names", "capital letters do not matter in names"),
    (Normalises, "names", "letters that look the same are the same (NFC)"),
    (NormalisesDigits, "names", "letters that mean the same are the same (NFKC)"),
    (Trims, "names", "spaces around names do not matter"),
    (EndsNamesAtZero, "names", "a name ends at its first NUL"),
    (KnowsPrefixes, "names", "the beginning of a name is enough"),
    (CountsBytes, "names", "the length of a name is counted in bytes"),
    (CountsTo256, "names", "names of 256 characters are allowed"),
    (EmptyIsMalformed, "names", "an empty name is MALFORMED"),
    (AnythingIsAName, "names", "anything is a name"),
    (LooksUpFirst, "names", "TypeError is raised (wrong_arbiters.py, line *)"),
    (FirstCome, "claimants", "first come, first served"),
    (Farthest, "claimants", "the farthest wins"),
    (LowSeatWins, "claimants", "the lowest seat wins"),
    (SuccessForEverybody, "claimants", "everybody within reach wins"),
    (NobodyWinsAContest, "claimants", "nobody wins where several ask"),
    (LosersDoNotLearnTheWinner, "claimants", "only who is granted learns the winner"),
    (MeasuresBySum, "claimants", "the distance is dx + dy"),
    (MeasuresByLargest, "claimants", "the distance is the larger one of dx and dy"),
    (TiesToTheLowSeat, "ties", "ties go to the lowest seat"),
    (TiesToTheFirst, "ties", "ties go to the first request"),
    (TiesToAll, "ties", "everybody in a tie wins"),
    (TiesByACount, "ties", "a lot is drawn wrongly"),
    (TiesInFloats, "ties", "ties go to the first request"),
    (TheNearestBlocks, "eligibility", "a withdrawn hunter nearby wins without asking"),
    (DuplicatesCompete, "eligibility", "refused requests win contests"),
    (NoDuplicates, "duplicates", "DUPLICATE is never said"),
    (LastRequestStands, "duplicates", "a hunter's last request stands, not its first"),
    (RefusalsAreNotSpent, "duplicates", "a refused request does not count as the first"),
    (MalformedIsNotSpent, "duplicates", "a malformed request does not count as the first"),
    (DuplicateBeforeMalformed, "duplicates", "DUPLICATE is tested before MALFORMED"),
    (NameBeforeDuplicate, "duplicates", "DUPLICATE is tested only after ALREADY_CAUGHT"),
    (DistanceForEverybody, "duplicates", "a distance is given to everybody"),
    (ReachBeforeService, "outages", "OUT_OF_REACH is tested before SERVICE_DOWN"),
    (ServiceFirst, "outages", "SERVICE_DOWN is tested before MALFORMED"),
    (CreditsRefusedKills, "outages", "a refused kill is GRANTED"),
    (FaultsSpread, "outages", "KILL_FAILED where GRANTED is right"),
    (TriesTheNext, "outages", "after a refused kill the others are told KILL_FAILED too"),
    (PlaysOn, "time", "MATCH_OVER is never said"),
    (EndsAfterTheForm, "time", "MALFORMED is tested before MATCH_OVER"),
    (IgnoresWithdrawals, "inactive", "HUNTER_INACTIVE is never said"),
    (InactiveBeforeMalformed, "inactive", "HUNTER_INACTIVE is tested before MALFORMED"),
    (InactiveAfterNames, "inactive", "HUNTER_INACTIVE is tested only after ALREADY_CAUGHT"),
    (ForgetsTheCaught, "identity", "UNKNOWN_TARGET where ALREADY_CAUGHT is right"),
    (OneAfterTheOther, "identity", "ALREADY_CAUGHT where LOST_CONTEST is right"),
    (AlwaysNearest, "policies", "the policy is always nearest"),
    (AlwaysNearest, "capstone", "the policy is always nearest"),
    (AlwaysCapstone, "capstone", "the policy is always capstone"),
)
"""Each wrong arbiter, the group of cases that must catch it, and what it must be told."""

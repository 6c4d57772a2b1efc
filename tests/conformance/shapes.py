"""What makes a case different from another: a form in which order, labels and numbers do not show.

Two cases of one shape differ only in the order of requests or hunters, in seats, in what targets are called, in how
many hunters or targets do the same, or in how far away they are, but for what the rules look at.
"""

import math
import unicodedata
from collections.abc import Hashable
from typing import Any

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.conformance.cases import LOT, ArbiterCase, ArenaCase, CaseStep, ExpectedRuling
from catch_arena.verdicts import Verdict

Shape = Hashable
CONTESTED = {Verdict.GRANTED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED, LOT}


def shape(case: ArbiterCase | ArenaCase) -> Shape:
    return of_arbiter(case) if isinstance(case, ArbiterCase) else of_arena(case)


# ---- cases for arbiters ----


def of_arbiter(case: ArbiterCase) -> Shape:
    """Which kinds of requests meet over a target, and which kinds a hunter makes one after the other."""
    own = case.circumstances
    over_targets: dict[str, set[Shape]] = {}
    of_hunters: dict[int, list[Shape]] = {}
    for ruling in case.expected:
        kind = request(case, ruling)
        over_targets.setdefault(repr(ruling.target), set()).add(kind)
        kinds = of_hunters.setdefault(ruling.hunter, [])
        if kind not in kinds[-1:]:
            kinds.append(kind)
    return (
        (
            own["policy"],
            own["match_over"],
            own["kill_service_up"],
            bool(case.fair_over_steps),
            bool(case.under_nearest),
        ),
        reaches(own["reach_m"]),
        bool(set(own["kill_refused"]) - {ruling.target for ruling in case.expected if isinstance(ruling.target, str)}),
        (bool(case.hunters), bool(case.targets), has_nearer_bystander(case)),
        frozenset(frozenset(kinds) for kinds in over_targets.values()),
        frozenset(tuple(kinds) for kinds in of_hunters.values()),
    )


def reach_of(case: ArbiterCase, ruling: ExpectedRuling) -> float:
    metres = case.circumstances["reach_m"]
    return metres[ruling.hunter] if isinstance(metres, tuple) else metres


def reaches(metres: float | tuple[float, ...]) -> Shape:
    return frozenset(map(reach, metres)) if isinstance(metres, tuple) else reach(metres)


def reach(metres: float) -> str:
    if metres == 0.3:
        return "standard"
    if metres < 1e-6:
        return "below a micrometre"
    if abs(1e6 * metres - round(1e6 * metres)) > 0.01:
        return "between micrometres"
    return "longer" if metres > 0.3 else "shorter"


def has_nearer_bystander(case: ArbiterCase) -> bool:
    """Whether a hunter who asks for nothing is nearer to a target than the one it is granted to."""
    silent = [at for seat, at in enumerate(case.hunters) if seat not in {ruling.hunter for ruling in case.expected}]
    granted = [
        (case.hunters[ruling.hunter], case.targets[ruling.target])
        for ruling in case.expected
        if ruling.verdict is Verdict.GRANTED and isinstance(ruling.target, str) and ruling.target in case.targets
    ]
    return any(math.dist(at, target) < math.dist(hunter, target) for at in silent for hunter, target in granted)


def request(case: ArbiterCase, ruling: ExpectedRuling) -> Shape:
    own = case.circumstances
    rivals = [
        one.distance_um
        for one in case.expected
        if one.target == ruling.target and one.verdict in CONTESTED and one.distance_um
    ]
    behind = 0
    if ruling.verdict is Verdict.LOST_CONTEST and rivals and isinstance(ruling.distance_um, int):
        behind = min(2, ruling.distance_um - min(rivals))
    return (
        str(ruling.verdict),
        ruling.winner is not None,
        ruling.hunter in own["inactive"],
        isinstance(ruling.target, str) and ruling.target in own["kill_refused"],
        name(case, ruling),
        place(case, ruling),
        behind,
    )


def name(case: ArbiterCase, ruling: ExpectedRuling) -> Shape:
    """What kind of a name it is, and how it is related to the names there are."""
    word = ruling.target
    if not isinstance(word, str):
        return type(word).__name__
    length = (
        min(len(word), 1) + (len(word) >= 255) + (len(word) > 255),
        len(word.encode()) > 255,
        len(word.encode("utf-16-le")) > 510,
    )
    if word in case.targets:
        others = [other for other in case.targets if other != word]
        return ("alive", length, frozenset(filter(None, (likeness(word, other) for other in others))))
    if word in case.circumstances["caught"]:
        return ("caught", length, bool(case.targets))
    if word in {f"hunter_{seat}" for seat in range(len(case.hunters))}:
        return ("own" if word == f"hunter_{ruling.hunter}" else "another hunter's", length)
    known = [("alive", other) for other in case.targets] + [("caught", other) for other in case.circumstances["caught"]]
    near = frozenset((status, likeness(word, other)) for status, other in known if likeness(word, other))
    return ("unknown", length, near, bool(case.targets))


def likeness(one: str, other: str) -> str:
    """By what two different names could be taken for each other."""
    tests = {
        "capitals": str.lower,
        "folding": str.casefold,
        "normal form": lambda word: unicodedata.normalize("NFC", word),
        "compatibility": lambda word: unicodedata.normalize("NFKC", word),
        "spaces": str.strip,
        "zeros": lambda word: word.partition("\0")[0],
        "invisible": lambda word: "".join(letter for letter in word if unicodedata.category(letter) != "Cf"),
        "look": lambda word: word.replace("\u0430", "a"),
        "number": lambda word: word.lstrip("0"),
    }
    for word, test in tests.items():
        if test(one) == test(other):
            return word
    if len(one) > 1 and len(other) > 1 and (other.startswith(one) or one.startswith(other)):
        return "beginning"
    return "end" if one and other.endswith(one) else ""


def place(case: ArbiterCase, ruling: ExpectedRuling) -> Shape:
    """Where the request was made from, as far as the rules look at it."""
    if ruling.distance_um is None or not isinstance(ruling.target, str):
        return ()
    (x, y), (target_x, target_y) = case.hunters[ruling.hunter], case.targets[ruling.target]
    metres = math.hypot(target_x - x, target_y - y)
    reach_m = reach_of(case, ruling)
    edge = round(1e6 * reach_m)
    beyond = max(-2, min(2, round(1e6 * metres) - edge))
    rounded = 1e6 * metres - round(1e6 * metres)
    on_walls = tuple(sum(at in {0.0, TURTLESIM_SIDE_M} for at in pair) for pair in ((x, y), (target_x, target_y)))
    return (
        beyond,
        metres < reach_m,
        (rounded > 0.01) - (rounded < -0.01),
        "here" if metres == 0 else "aslant" if abs(target_x - x) > 1e-9 < abs(target_y - y) else "straight",
        on_walls,
    )


# ---- cases for arenas ----


def of_arena(case: ArenaCase) -> Shape:
    steps: list[Shape] = []
    for one in case.play:
        kind = step(one)
        if kind not in steps[-1:]:
            steps.append(kind)
    return (frozenset((key, setting(key, value)) for key, value in case.settings.items()), tuple(steps))


def setting(key: str, value: Any) -> Shape:
    """Which kind of a setting: of a frequency, how its period is rounded."""
    if key == "spawn_frequency_hz":
        if value <= 0:
            return "zero" if value == 0 else "negative"
        period = 1000 / value
        rest = period - math.floor(period)
        return ("exact" if rest == 0 else "half" if rest == 0.5 else "up" if rest > 0.5 else "down", period < 1)
    if key == "time_limit_s":
        return round(1000 * value) % 100 == 0
    return value if isinstance(value, str) else isinstance(value, list) and tuple(map(str, value)) != ()


def step(one: CaseStep) -> Shape:
    alive = one.read.get("alive", [])
    return (
        (one.reset, one.hunters is not None, one.withdraw is not None, one.steps > 0, bool(one.drive)),
        frozenset(
            (str(ruling.verdict), ruling.target == 0, ruling.winner is not None) for ruling in one.expected or ()
        ),
        one.expected is not None,
        frozenset(one.read),
        (alive == list(range(1, len(alive) + 1)), one.read.get("ended", "")),
    )

"""The suite's .toml files, read and checked."""

import re
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from typing import Any, Final, get_args

from catch_arena.config import ArbitrationPolicy, TargetMotion
from catch_arena.conformance.cases import (
    ANY,
    DEFAULTS,
    LOT,
    NEVER,
    READINGS,
    ArbiterCase,
    ArenaCase,
    CaseStep,
    ExpectedRuling,
    Lot,
)
from catch_arena.conformance.toml_reader import (
    Table,
    flag,
    listed,
    number,
    point,
    tabled,
    text,
    texts,
    whole,
    wholes,
    word_or,
)
from catch_arena.errors import ConfigError, suggest
from catch_arena.files import tomllib
from catch_arena.verdicts import Verdict


@cache
def load_cases() -> tuple[ArbiterCase | ArenaCase, ...]:
    """Every case of the suite, by file and in the files' order."""
    folder = files("catch_arena.conformance") / "cases"
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".toml"))
    return tuple(case for name in names for case in read_cases(name, (folder / name).read_text(encoding="utf-8")))


def read_cases(name: str, written: str) -> list[ArbiterCase | ArenaCase]:
    """The cases of one file.

    Args:
        name: the file's, and what is `written` in it; its stem begins the id of each of its cases.
        written: a file of cases as TOML gives it.

    Raises:
        ConfigError: that names the file, the case and the field.
    """
    try:
        content = tomllib.loads(written)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: is no TOML: {error}") from None
    top = Table(name, content)
    found: list[ArbiterCase | ArenaCase] = []
    for kind, read in (("case", _arbiter_case), ("arena_case", _arena_case)):
        for table in top.take(kind, "a list of tables", listed, []):
            place = table.get("id") if isinstance(table, dict) else None
            found.append(read(Table(f"{name}: {place or f'{kind} without an id'}", table), name.removesuffix(".toml")))
    top.finish()
    seen: set[str] = set()
    for case in found:
        if case.id in seen:
            raise ConfigError(f"{name}: {case.id}: id must be unique")
        seen.add(case.id)
    return found


def _arbiter_case(table: Table, group: str) -> ArbiterCase:
    own = _about(table, group)
    hunters = table.take("hunters", "a list of places [x, y]", lambda value: tuple(map(point, listed(value))))
    targets = table.take(
        "targets", "a table of places [x, y]", lambda value: {name: point(at) for name, at in tabled(value).items()}
    )
    seat = _seat_of(len(hunters))
    case = ArbiterCase(
        **own,
        hunters=hunters,
        targets=targets,
        expected=table.take("requests", "a list of tables", lambda value: _rulings(table.where, value, seat, "name")),
        circumstances=_circumstances(table, len(hunters)),
        lots=table.take("lots", "a list of tables", lambda value: _lots(table.where, value, seat), ()),
        fair_over_steps=table.take("fair_over_steps", "a whole number", whole, 0),
        under_nearest=table.take(
            "under_nearest", "a list of tables", lambda value: _rulings(table.where, value, seat, "name"), ()
        ),
    )
    table.finish()
    _require_sense(table.where, case)
    return case


def _require_sense(where: str, case: ArbiterCase) -> None:
    """What is said at two places must agree."""
    for lot in case.lots:
        if lot.target not in case.targets:
            raise ConfigError(f"{where}: lots must be drawn for targets that are alive, got {lot.target!r}")
        if lot.drawn not in lot.seats:
            raise ConfigError(f"{where}: drawn must be one of the seats {list(lot.seats)}, got {lot.drawn}")
    drawn_for = {lot.target: lot.seats for lot in case.lots}
    for one in case.expected:
        seats = drawn_for.get(one.target) if isinstance(one.target, str) else None
        if one.winner == LOT and seats is None:
            raise ConfigError(f"{where}: a ruling by lot must have its target among the lots, got {one.target!r}")
        if one.verdict == LOT and (seats is None or one.hunter not in seats):
            raise ConfigError(f"{where}: verdict LOT must be for the lot's own seats, got hunter {one.hunter}")
    if case.under_nearest and [(one.hunter, one.target) for one in case.under_nearest] != [
        (one.hunter, one.target) for one in case.expected
    ]:
        raise ConfigError(f"{where}: under_nearest must answer the requests of the case itself, in their order")
    if case.fair_over_steps and not case.lots:
        raise ConfigError(f"{where}: fair_over_steps must come with lots")


def _arena_case(table: Table, group: str) -> ArenaCase:
    own = _about(table, group)
    settings = _settings(Table(f"{table.where}: settings", table.take("settings", "a table", tabled)))
    seat, prey = _seat_of(settings["hunters"]), _seat_of(settings.get("prey", 0))
    play = table.take(
        "play",
        "a list of tables",
        lambda value: tuple(_case_step(table.where, step, seat, prey) for step in listed(value)),
    )
    table.finish()
    return ArenaCase(**own, settings=settings, play=play)


def _about(table: Table, group: str) -> dict[str, Any]:
    def own_id(value: object) -> str:
        if not isinstance(value, str) or not re.fullmatch(rf"{re.escape(group)}(\.[a-z0-9]+(-[a-z0-9]+)*)+", value):
            raise ValueError
        return value

    def clauses(value: object) -> tuple[str, ...]:
        found = texts(value)
        if not found or not all(re.fullmatch(r"R\d+\.\d+", clause) for clause in found):
            raise ValueError
        return found

    return {
        "id": table.take("id", f"{group}. and words in lower case with hyphens", own_id),
        "clauses": table.take("clauses", "a list of clauses like R5.4", clauses),
        "situation": table.take("situation", "a text", text),
        "why": table.take("why", "a text", text),
        "options": table.take("options", "a list of texts", texts, ()),
    }


def _circumstances(table: Table, hunters: int) -> dict[str, Any]:
    seat = _seat_of(hunters)
    readers: dict[str, tuple[str, Callable[[Any], Any]]] = {
        "reach_m": _reach(hunters),
        "policy": _POLICY,
        "seed": ("a whole number", whole),
        "step": ("a whole number", whole),
        "caught": ("a list of names", texts),
        "inactive": ("a list of seats", lambda value: tuple(map(seat, listed(value)))),
        "kill_service_up": ("true or false", flag),
        "kill_refused": ("a list of names", texts),
        "match_over": ("true or false", flag),
    }
    return {key: table.take(key, words, read, DEFAULTS[key]) for key, (words, read) in readers.items()}


def _settings(table: Table) -> dict[str, Any]:
    """What a case says of its arena, and the number of hunters, 1, and of prey, 0, where it does not."""
    hunters = table.take("hunters", "a whole number", whole, 1)
    seat = _seat_of(hunters)
    readers: dict[str, tuple[str, Callable[[Any], Any]]] = {
        "reach_m": _reach(hunters),
        "policy": _POLICY,
        "side_m": ("a positive number", number),
        "spawn_frequency_hz": ("a number", number),
        "initial_targets": ("a whole number", whole),
        "max_targets": ("a whole number", whole),
        "target_budget": ("a whole number", whole),
        "target_motion": _one_of(TargetMotion),
        "target_speed_mps": ("a positive number", number),
        "target_turn_rate_radps": ("a positive number", number),
        "wander_period_ms": ("a whole number", whole),
        "alarm_m": ("a number", number),
        "view_radius_m": ("a positive number", number),
        "view_angle_deg": ("a positive number", number),
        "control_period_ms": ("a whole number", whole),
        "time_limit_s": ("a positive number", number),
        "drop_outs": (
            "a list of [step, seat]",
            lambda value: [[step, seat(who)] for step, who in map(_pair, listed(value))],
        ),
        "kill_down": ("a list of steps", wholes),
        "kill_refused": ("a list of [step, number]", lambda value: list(map(_pair, listed(value)))),
        "spawn_down": ("a list of firings", wholes),
        "spawn_refused": ("a list of numbers", wholes),
        "spawning": ("true or false", flag),
        "teams": (
            "a list of teams, each a list of seats",
            lambda value: [list(map(seat, listed(team))) for team in listed(value)],
        ),
        "prey": ("a whole number", whole),
        "prey_returns_s": (f"a number or {NEVER}", word_or(NEVER, number)),
    }
    found = {"hunters": hunters} | {key: table.take(key, words, read, None) for key, (words, read) in readers.items()}
    table.finish()
    return {key: None if value == NEVER else value for key, value in found.items() if value is not None}


def _rulings(where: str, value: object, seat: Callable[[object], int], target_key: str) -> tuple[ExpectedRuling, ...]:
    """Requests with their rulings; `target_key` is the key that says what was asked for."""
    found = []
    for place, entry in enumerate(listed(value), start=1):
        table = Table(f"{where}: request {place}", entry)
        found.append(
            ExpectedRuling(
                hunter=table.take("hunter", "a seat", seat),
                target=table.take(target_key, "given", lambda given: given),
                verdict=table.take(
                    "verdict", f"LOT or one of {', '.join(Verdict.__members__)}", word_or(LOT, _verdict)
                ),
                distance_um=table.take(
                    "distance_um", "a whole number of micrometres or ANY", word_or(ANY, whole), None
                ),
                winner=table.take("winner", "a seat or LOT", word_or(LOT, seat), None),
            )
        )
        table.finish()
    return tuple(found)


def _lots(where: str, value: object, seat: Callable[[object], int]) -> tuple[Lot, ...]:
    found = []
    for entry in listed(value):
        table = Table(f"{where}: lots", entry)
        found.append(
            Lot(
                target=table.take("target", "a name", text),
                seats=table.take("seats", "a list of seats", lambda given: tuple(map(seat, listed(given)))),
                drawn=table.take("drawn", "a seat", seat),
            )
        )
        table.finish()
    return tuple(found)


def _case_step(where: str, value: object, seat: Callable[[object], int], prey: Callable[[object], int]) -> CaseStep:
    table = Table(f"{where}: play", value)

    def poses(given: object) -> tuple[tuple[float, float, float], ...]:
        found = [tuple(map(number, listed(pose))) for pose in listed(given)]
        if any(len(pose) != 3 for pose in found):
            raise ValueError
        return tuple((x, y, theta) for x, y, theta in found)

    def velocities(which: Callable[[object], int]) -> Callable[[object], dict[int, tuple[float, float]]]:
        return lambda given: {which(who): (number(v), number(w)) for who, v, w in listed(given)}

    def numbered(given: object) -> tuple[ExpectedRuling, ...]:
        return _rulings(table.where, given, seat, "number")

    step = CaseStep(
        reset=table.take("reset", "true or false", flag, False),
        hunters=table.take("hunters", "a list of poses [x, y, theta]", poses, None),
        targets=table.take("targets", "a list of places [x, y]", lambda given: tuple(map(point, listed(given))), ()),
        withdraw=table.take("withdraw", "a seat", seat, None),
        withdraw_prey=table.take("withdraw_prey", "the index of a prey", prey, None),
        steps=table.take("steps", "a whole number", whole, 0),
        drive=table.take("drive", "a list of [hunter, v, w]", velocities(seat), {}),
        drive_prey=table.take("drive_prey", "a list of [prey, v, w]", velocities(prey), {}),
        expected=table.take("requests", "a list of tables", numbered, None),
        read=table.take("read", "a table", tabled, {}),
    )
    table.finish()
    for word in step.read:
        if word not in READINGS:
            raise ConfigError(f"{table.where}: nothing called {word!r} can be read: {suggest(word, READINGS)}")
    return step


def _pair(value: object) -> list[int]:
    step, what = wholes(value)
    return [step, what]


def _verdict(value: object) -> Verdict:
    if value not in Verdict.__members__:
        raise ValueError
    return Verdict[text(value)]


def _one_of(words: object) -> tuple[str, Callable[[object], object]]:
    """How one of the words of a Literal is asked for, and read."""

    def read(value: object) -> object:
        if value not in get_args(words):
            raise ValueError
        return value

    return f"one of {', '.join(get_args(words))}", read


_POLICY: Final = _one_of(ArbitrationPolicy)


def _reach(hunters: int) -> tuple[str, Callable[[object], float | tuple[float, ...]]]:
    """How a reach is asked for, and read: R2.7."""

    def read(value: object) -> float | tuple[float, ...]:
        if not isinstance(value, list):
            return number(value)
        if len(value) != hunters:
            raise ValueError
        return tuple(map(number, value))

    return "a positive number, or one for each hunter", read


def _seat_of(hunters: int) -> Callable[[object], int]:
    def seat(value: object) -> int:
        if whole(value) >= hunters:
            raise ValueError
        return whole(value)

    return seat

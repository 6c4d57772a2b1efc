"""Reading and checking of the suite's .toml files."""

import re
from collections.abc import Iterable
from functools import cache
from importlib.resources import files

import msgspec

from catch_arena.conformance.cases import ANSWERS, LOT, ArbiterCase, ArenaCase, ExpectedRuling
from catch_arena.errors import ConfigError
from catch_arena.files import tomllib


@cache
def load_cases() -> tuple[ArbiterCase | ArenaCase, ...]:
    """Return all cases of the suite, file by file, in the order of each file."""
    folder = files("catch_arena.conformance") / "cases"
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".toml"))
    return tuple(case for name in names for case in read_cases(name, (folder / name).read_text(encoding="utf-8")))


def read_cases(name: str, written: str) -> list[ArbiterCase | ArenaCase]:
    """Return the cases of one file.

    Args:
        name: name of the file; the id of each case begins with its stem.
        written: text of the file, in TOML.

    Raises:
        ConfigError: for a case that is not valid; it names the file, the case and the field.
    """
    try:
        content = tomllib.loads(written)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: is not valid TOML: {error}") from None
    kinds: dict[str, type[ArbiterCase | ArenaCase]] = {"case": ArbiterCase, "arena_case": ArenaCase}
    found: list[ArbiterCase | ArenaCase] = []
    for kind, tables in content.items():
        if kind not in kinds or not isinstance(tables, list):
            raise ConfigError(f"{name}: {kind!r} is not a [[case]] or [[arena_case]] table, with double brackets")
        for table in tables:
            place = table.get("id") if isinstance(table, dict) else None
            try:
                case = msgspec.convert(table, kinds[kind])
                _require_sense(case, name.removesuffix(".toml"))
            except ValueError as error:  # msgspec's errors are ValueErrors
                raise ConfigError(f"{name}: {place or f'{kind} without an id'}: {error}") from None
            if case.id in {earlier.id for earlier in found}:
                raise ConfigError(f"{name}: {case.id}: id must be unique")
            found.append(case)
    return found


def _require_sense(case: ArbiterCase | ArenaCase, group: str) -> None:
    """Check a case for faults that its types do not show.

    Raises:
        ValueError: if two of its fields contradict each other.
    """
    if not re.fullmatch(rf"{re.escape(group)}(\.[a-z0-9]+(-[a-z0-9]+)*)+", case.id):
        raise ValueError(f"id must look like '{group}.lower-case-words', got {case.id!r}")
    if isinstance(case, ArbiterCase):
        _require_sense_of_arbiter(case)
    else:
        _require_sense_of_arena(case)


def _require_sense_of_arbiter(case: ArbiterCase) -> None:
    hunters = len(case.hunters)
    _require_reaches(case.reach_m, hunters)
    _require_seats(case.inactive, hunters)
    _require_seats((seat for team in case.teams or () for seat in team), hunters)
    _require_rulings((*case.expected, *case.under_nearest), hunters)
    for lot in case.lots:
        if lot.target not in case.targets:
            raise ValueError(f"lots must be for alive targets, got {lot.target!r}")
        if lot.drawn not in lot.seats:
            raise ValueError(f"drawn must be one of the seats {list(lot.seats)}, got {lot.drawn}")
        _require_seats(lot.seats, hunters)
    drawn_for = {lot.target: lot.seats for lot in case.lots}
    for ruling in case.expected:
        seats = drawn_for.get(ruling.target) if isinstance(ruling.target, str) else None
        if ruling.winner == LOT and seats is None:
            raise ValueError(f"lots must contain the target of every ruling by lot, got none for {ruling.target!r}")
        if ruling.verdict == LOT and (seats is None or ruling.hunter not in seats):
            raise ValueError(f"verdict LOT must be for one of the lot's seats, got hunter {ruling.hunter}")
    requests = [(ruling.hunter, ruling.target) for ruling in case.expected]
    if case.under_nearest and [(ruling.hunter, ruling.target) for ruling in case.under_nearest] != requests:
        raise ValueError("under_nearest must have one ruling for each request of the case, in their order")
    if case.fair_over_steps and not case.lots:
        raise ValueError("fair_over_steps needs lots: add them, or remove it")


def _require_sense_of_arena(case: ArenaCase) -> None:
    hunters, prey = case.arena.hunters, case.arena.prey or 0
    _require_reaches(case.arena.reach_m, hunters)
    _require_seats((seat for team in case.arena.teams or () for seat in team), hunters)
    _require_seats((seat for _, seat in case.arena.drop_outs or ()), hunters)
    for step in case.play:
        _require_rulings(step.expected or (), hunters)
        _require_seats([*step.drive, *([] if step.withdraw is None else [step.withdraw])], hunters)
        _require_seats([*step.drive_prey, *([] if step.withdraw_prey is None else [step.withdraw_prey])], prey, "prey")


def _require_rulings(rulings: Iterable[ExpectedRuling], hunters: int) -> None:
    for ruling in rulings:
        if ruling.answer not in ANSWERS:
            raise ValueError(f"verdict must be one of {', '.join(ANSWERS)}, got {ruling.answer!r}")
        _require_seats([ruling.hunter, *([ruling.winner] if isinstance(ruling.winner, int) else [])], hunters)


def _require_seats(seats: Iterable[int], count: int, kind: str = "hunter") -> None:
    for seat in seats:
        if seat >= count:
            raise ValueError(f"{kind} must be below {count}, their number in the case, got {seat}")


def _require_reaches(reach_m: object, hunters: int) -> None:
    if isinstance(reach_m, tuple) and len(reach_m) != hunters:
        raise ValueError(
            f"reach_m must be one number, or one for each of the {hunters} hunters, got {len(reach_m)} numbers"
        )

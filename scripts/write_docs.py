"""Write the tables in docs/ that are made from code; each is between two marks, and the first mark names it.

A test checks that they are up to date.
"""

import argparse
import ast
import inspect
import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from catch_arena.config import ArenaConfig
from catch_arena.layout import Column, columns, prey_columns, state_columns
from catch_arena.policy import Limits, PreyLimits
from catch_arena.scenarios import scenario

DOCS = Path(__file__).parent.parent / "docs"
PAGES = ("reference/agents.md", "reference/observation.md", "reference/settings.md")
TABLE = re.compile(r"(<!-- made by `make docs`: (.+?) -->\n\n).*?(?=\n\n<!-- end -->)", re.DOTALL)
UNITS = {"m": "m", "mps": "m/s", "radps": "rad/s", "hz": "1/s", "ms": "ms", "s": "s", "deg": "degrees"}
"""Unit by the last part of a setting's name."""


def with_tables(page: str) -> str:
    """Return a page with all its tables written again."""
    return TABLE.sub(lambda found: found[1] + TABLES[found[2]](), page)


def column_table(columns: Sequence[Column], begins: str = "", repeats: str = "") -> str:
    """Return the columns whose names start with `begins` as a Markdown table, without matches of `repeats`."""
    lines = ["| index | name | unit | low | high | meaning |", "|---:|---|---|---:|---:|---|"]
    for index, row in enumerate(columns):
        if row.name.startswith(begins) and not (repeats and re.match(repeats, row.name)):
            lines.append(f"| {index} | {row.name} | {row.unit} | {row.low:.5g} | {row.high:.5g} | {row.meaning} |")
    return "\n".join(lines)


def words_below(owner: type) -> dict[str, str]:
    """Return the docstring below each field of a class and its bases, by the field's name."""
    found = {}
    for kind in reversed(owner.__mro__[:-1]):  # in the order of the fields
        (definition,) = ast.parse(inspect.getsource(kind)).body
        for pair in pairwise(definition.body):
            match pair:
                case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(words))):
                    found[name] = words
    return found


def split_unit(words: str) -> tuple[str, str]:
    """Return the words without their [unit], and the unit, which is empty without one."""
    unit = re.search(r" \[(.+?)\]", words)
    return (words, "") if unit is None else (words.replace(unit[0], "", 1), unit[1])


def limits_table(kind: type[Limits | PreyLimits]) -> str:
    """Return the fields of `view.limits` as a Markdown table, from their docstrings."""
    lines = ["| field | unit | meaning |", "|---|---|---|"]
    for name, words in words_below(kind).items():
        meaning, unit = split_unit(words)
        lines.append(f"| `{name}` | {unit or unit_of(name)} | {meaning} |")
    return "\n".join(lines)


def unit_of(setting: str) -> str:
    """Return the unit in which the name of a setting ends; empty without one."""
    return UNITS.get(setting.rpartition("_")[2], "")


def settings() -> Iterator[tuple[list[int], str]]:
    """Yield every setting, with its clause of the rulebook and its row of docs/reference/settings.md."""
    kinds, words = get_type_hints(ArenaConfig), words_below(ArenaConfig)
    for field in fields(ArenaConfig):
        kind: Any = kinds[field.name]
        if is_dataclass(kind):
            clause, parts = (kind.__doc__ or "").partition(":")[0], words_below(kind)
            for part in fields(kind):
                meaning, unit = split_unit(parts[part.name])
                row = (f"`{field.name}.{part.name}`", unit, shown(getattr(kind(), part.name)))
                yield clause_of(clause), f"| {' | '.join(row)} | {clause}: {meaning[0].lower()}{meaning[1:]} |"
            continue
        meaning = words[field.name]
        if choices := words_of(kind):
            meaning += f" One of {', '.join(f'`{word}`' for word in choices)}."
        row = (f"`{field.name}`", unit_of(field.name), shown(field.default))
        yield clause_of(meaning), f"| {' | '.join(row)} | {meaning} |"


def clause_of(words: str) -> list[int]:
    """Return chapter and number of the clause at the beginning of the words, which must have one."""
    return [int(number) for number in re.match(r"R(\d+)\.(\d+)", words).groups()]  # type: ignore[union-attr]


def words_of(kind: Any) -> tuple[str, ...]:
    """Return the allowed words of a `Literal` type, also within a union; empty for other types."""
    if get_origin(kind) is Literal:
        return get_args(kind)
    return next((words for part in get_args(kind) if (words := words_of(part))), ())


def shown(default: object) -> str:
    """Return a default as `--set` takes it, as Markdown code."""
    text = json.dumps(int(default) if type(default) is float and default.is_integer() else default)
    return "`" + text.strip('"') + "`"


def settings_tables() -> str:
    """Return a heading and a table for each chapter of the rulebook that has settings, in the order of the clauses."""
    titles = dict(
        re.findall(r"^## Chapter (\d+): (.+)$", (DOCS / "reference" / "rulebook.md").read_text(), re.MULTILINE)
    )
    chapters: dict[int, list[str]] = {}
    for (chapter, _), row in sorted(settings(), key=lambda setting: setting[0]):
        chapters.setdefault(chapter, []).append(row)
    head = "| setting | unit | default | meaning |\n|---|---|---|---|"
    return "\n\n".join(
        f"## {titles[str(chapter)]} (chapter {chapter})\n\n{head}\n" + "\n".join(rows)
        for chapter, rows in chapters.items()
    )


TABLES: dict[str, Callable[[], str]] = {
    "view.limits": partial(limits_table, Limits),
    "view.limits of prey": partial(limits_table, PreyLimits),
    "standard": lambda: column_table(columns(scenario("standard")), repeats=r"(target|rival)_([2-9]|1\d)\."),
    "a moving target": lambda: column_table(columns(scenario("wander")), "target_1."),
    "a rival in teams": lambda: column_table(columns(scenario("pairs")), "rival_1."),
    "prey": lambda: column_table(prey_columns(scenario("herd")), repeats=r"(hunter|prey)_[2-9]\."),
    "state": lambda: column_table(state_columns(scenario("standard")), repeats=r"(hunter_[1-9]|target_([2-9]|1\d))\."),
    "state of a moving target": lambda: column_table(state_columns(scenario("wander")), "target_1."),
    "state of prey": lambda: column_table(state_columns(scenario("herd")), "prey_0."),
    "settings": settings_tables,
}


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for name in PAGES:
        path = DOCS / name
        path.write_text(with_tables(path.read_text()))
        print(path.relative_to(DOCS.parent))

"""Write the tables in docs/ that are made from code; a test checks that they are up to date."""

import argparse
import ast
import dataclasses
import inspect
import json
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from catch_arena.config import ArenaConfig
from catch_arena.layout import SELF_COLUMNS, Column, columns, prey_columns, state_columns
from catch_arena.policy import Limits, PreyLimits
from catch_arena.scenarios import scenario

DOCS = Path(__file__).parent.parent / "docs"

HEAD = """# What an agent sees

Made from `catch_arena/layout.py` by `make docs`; do not edit. The clauses are R7.1 to R7.6, and R12.4 for prey.

An observation is one float32 vector. `catch_arena.View(observation, mask, limits)` gives it names. Numbers are SI
units in the hunter's own frame (forward, left), except its own
position, which is in the world's. The bounds are those of the observation space; `(o - low) / (high - low)` brings
every column into [0, 1].

The mask of the legal actions is `infos[agent]["action_mask"]`. With `mask_in_observation=True` an observation is
`{"observation": vector, "action_mask": mask}`, as PettingZoo's examples and Tianshou expect.
`action_space(agent).sample` takes either mask.

Below is the scenario `standard`: 4 hunters, 8 targets and 3 rivals in view. The columns of `target_2` to `target_8`
and of `rival_2` and `rival_3` repeat those of the first.
"""


MOVING = """Each target has three columns more there, and where there is prey (R7.4); of `target_1`:
"""

TEAMS = """Each rival has one column more where there are teams (R7.4). In `pairs`, of `rival_1`:
"""

PREY = """Prey has a vector of its own, in its own frame (R12.4). It sees all round, everywhere, and without noise: at
most eight hunters and eight other prey, the nearest first. While it is out everything is zero except `time_left` and
`times_caught`. In `herd`, where 4 hunters chase 4 prey:
"""

PARTIAL = """A scenario may limit what hunters see to a radius and a cone (R7.5), and blur it (R7.6). The columns stay:
what is not seen has no rank, and `forward` and `left` have wider bounds where they are blurred. `view.limits` says
what holds.
"""

STATE = """`state()` is one float32 vector in the world frame: the time left, then every hunter by seat, then
`max_targets` places for targets in spawning order.
"""

STATE_OF_MOVING = """
Where targets move, or there is prey, a target has three columns more. In `wander`:
"""

STATE_OF_PREY = """
Where there is prey, each prey follows, by index. In `herd`:
"""


SETTINGS_HEAD = """# Settings

Made from `catch_arena/config.py` by `make docs`; do not edit.

An arena is a scenario, and what is changed of it. These are the settings that can be changed, by
[the rulebook's](rulebook.md) chapters, with the defaults of the scenario `standard`. `catch-arena scenarios` shows what
is special in the others.

```sh
catch-arena match nearest first --set hunters=2 --set time_limit_s=30 --set faults.kill_down=0.2
```

```python
config = catch_arena.scenario("standard", hunters=2, time_limit_s=30, faults={"kill_down": 0.2})
```

What stands for each hunter is a list there, in the order of seats: `--set reach_m=[0.3,0.5]`, or `reach_m=(0.3, 0.5)`.
`null` is Python's None, `true` and `false` are its True and False. Commands do not take `control`: each agent states
its own.
"""
UNITS = {"m": "m", "mps": "m/s", "radps": "rad/s", "hz": "1/s", "ms": "ms", "s": "s", "deg": "degrees"}
"""By the last part of a setting's name."""


def table(rows: tuple[Column, ...], *, skip_repeats: tuple[str, ...], first: int = 0) -> str:
    """The columns as a Markdown table; `first` is the first one's index."""
    lines = ["| index | name | unit | low | high | meaning |", "|---:|---|---|---:|---:|---|"]
    for index, row in enumerate(rows, start=first):
        if not row.name.startswith(skip_repeats):
            lines.append(f"| {index} | {row.name} | {row.unit} | {row.low:.5g} | {row.high:.5g} | {row.meaning} |")
    return "\n".join(lines)


def observation_page() -> str:
    """docs/observation.md."""
    config = scenario("standard")
    others = tuple(f"{what}_{i}." for what in ("target", "rival") for i in range(2, 10))
    seats = (*(f"hunter_{i}." for i in range(1, 10)), *(f"target_{i}." for i in range(2, 17)), "target_1")
    wander = scenario("wander")
    of_moving_target = tuple(column for column in columns(wander) if column.name.startswith("target_1."))
    of_moving_place = [column for column in state_columns(wander) if column.name.startswith("target_1.")]
    pairs = columns(scenario("pairs"))
    of_team_rival = [column for column in pairs if column.name.startswith("rival_1.")]
    herd = scenario("herd")
    of_prey = [column for column in state_columns(herd) if column.name.startswith("prey_0.")]
    return "\n".join(
        (
            HEAD,
            table(columns(config), skip_repeats=others),
            "\n## Where targets move\n",
            MOVING,
            table(of_moving_target, skip_repeats=(), first=len(SELF_COLUMNS)),
            "\n## Where there are teams\n",
            TEAMS,
            table(tuple(of_team_rival), skip_repeats=(), first=pairs.index(of_team_rival[0])),
            "\n## What prey sees\n",
            PREY,
            table(
                prey_columns(herd),
                skip_repeats=tuple(f"{kind}_{i}." for kind in ("hunter", "prey") for i in range(2, 9)),
            ),
            "\n## What is not seen\n",
            PARTIAL.rstrip(),
            "\n## The global view\n",
            STATE,
            table(state_columns(config), skip_repeats=tuple(s for s in seats if s != "target_1")),
            STATE_OF_MOVING,
            table(tuple(of_moving_place), skip_repeats=(), first=state_columns(wander).index(of_moving_place[0])),
            STATE_OF_PREY,
            table(tuple(of_prey), skip_repeats=(), first=state_columns(herd).index(of_prey[0])),
            "",
        )
    )


def words_below(owner: type) -> dict[str, str]:
    """What the source says below each field of a class."""
    (definition,) = ast.parse(inspect.getsource(owner)).body
    found = {}
    for pair in pairwise(definition.body):
        match pair:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(words))):
                found[name] = words
    return found


def split_unit(words: str) -> tuple[str, str]:
    """The words without their [unit], and the unit."""
    unit = re.search(r" \[(.+?)\]", words)
    return (words, "") if unit is None else (words.replace(unit[0], "", 1), unit[1])


def limits_table(kind: type[Limits | PreyLimits]) -> str:
    """The fields of `view.limits` as a Markdown table, from the words below each of them in the source."""
    lines = ["| field | unit | meaning |", "|---|---|---|"]
    for name, words in words_below(kind).items():
        meaning, unit = split_unit(words)
        lines.append(f"| `{name}` | {unit} | {meaning} |")
    return "\n".join(lines)


def agents_page(page: str) -> str:
    """docs/agents.md with its tables of limits as they should be."""
    begin, end = "<!-- made from catch_arena/policy.py by `make docs` -->\n\n", "\n\n<!-- end -->"
    before, *parts = page.split(begin)
    tables = map(limits_table, (Limits, PreyLimits))
    made = (f"{begin}{table}{end}{part.partition(end)[2]}" for table, part in zip(tables, parts, strict=True))
    return before + "".join(made)


class Setting(NamedTuple):
    """One setting as a row of docs/settings.md."""

    chapter: int
    """Of the rulebook."""
    name: str
    unit: str
    default: str
    meaning: str


def words_for(owner: type, name: str) -> str:
    """What the source says below a setting, which must have words there."""
    words = words_below(owner)
    if name not in words:
        raise SystemExit(f"{owner.__name__}.{name} has no docstring, which docs/settings.md needs")
    return words[name]


def settings() -> Iterator[Setting]:
    """Every setting, those of groups too. One that names no clause stands with the one before it."""
    chapter = 2  # of the first one, `hunters`: where they start
    kinds = get_type_hints(ArenaConfig)
    for field in dataclasses.fields(ArenaConfig):
        kind: Any = kinds[field.name]
        if dataclasses.is_dataclass(kind):
            clause = (kind.__doc__ or "").partition(":")[0]
            for part in dataclasses.fields(kind):
                meaning, unit = split_unit(words_for(kind, part.name))
                default = shown(getattr(kind(), part.name))
                yield Setting(
                    chapter_of(clause), f"{field.name}.{part.name}", unit, default, f"{clause}: {as_in_a_line(meaning)}"
                )
            continue
        meaning = words_for(ArenaConfig, field.name)
        chapter = chapter_of(meaning) or chapter
        choices = words_of(kind)
        if choices:
            meaning += f" One of {', '.join(f'`{word}`' for word in choices)}."
        yield Setting(chapter, field.name, UNITS.get(field.name.rpartition("_")[2], ""), shown(field.default), meaning)


def chapter_of(words: str) -> int:
    """That of the first clause in them, 0 without one."""
    clause = re.match(r"R(\d+)\.", words)
    return 0 if clause is None else int(clause[1])


def as_in_a_line(words: str) -> str:
    """Without the great letter of a sentence."""
    return words[0].lower() + words[1:]


def words_of(kind: Any) -> tuple[str, ...]:
    """The words that a setting may be, where it is one of a few."""
    if get_origin(kind) is Literal:
        return get_args(kind)
    return next((words for part in get_args(kind) if (words := words_of(part))), ())


def shown(default: object) -> str:
    """A default as `--set` takes it."""
    text = json.dumps(int(default) if type(default) is float and default.is_integer() else default)
    return "`" + text.strip('"') + "`"


def settings_page() -> str:
    """docs/settings.md."""
    titles = dict(re.findall(r"^## Chapter (\d+): (.+)$", (DOCS / "rulebook.md").read_text(), re.MULTILINE))
    rows = list(settings())
    parts = [SETTINGS_HEAD]
    for chapter in sorted({row.chapter for row in rows}):
        parts.append(f"## {titles[str(chapter)]} (chapter {chapter})\n")
        parts += ["| setting | unit | default | meaning |", "|---|---|---|---|"]
        parts += [
            f"| `{row.name}` | {row.unit} | {row.default} | {row.meaning} |" for row in rows if row.chapter == chapter
        ]
        parts.append("")
    return "\n".join(parts)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    agents = DOCS / "agents.md"
    for path, text in (
        (DOCS / "observation.md", observation_page()),
        (DOCS / "settings.md", settings_page()),
        (agents, agents_page(agents.read_text())),
    ):
        path.write_text(text)
        print(path.relative_to(DOCS.parent))

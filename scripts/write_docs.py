"""Write the tables in docs/ that are made from code; a test checks that they are up to date."""

import argparse
import ast
import inspect
import re
from itertools import pairwise
from pathlib import Path

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

Below is the scenario `standard`: 4 hunters, 8 targets and 3 rivals in view. The columns of `target_2` to `target_8`
and of `rival_2` and `rival_3` repeat those of the first.
"""


MOVING = """Each target has three columns more there, and where there is prey (R7.4), and so it has in the global view;
of `target_1`:
"""

TEAMS = """Each rival has one column more where there are teams (R7.4). In `pairs`, of `rival_1`:
"""

PREY = """Prey has a vector of its own, in its own frame (R12.4). It sees all round, everywhere, and without noise: at
most eight hunters and eight other prey, the nearest first. While it is out everything is zero but for `time_left` and
`times_caught`. In `herd`, where 4 hunters chase 4 prey:
"""

PARTIAL = """A scenario may limit what hunters see to a radius and a cone (R7.5), and blur it (R7.6). The columns stay:
what is not seen has no rank, and `forward` and `left` have wider bounds where they are blurred. `view.limits` says
what holds.
"""

STATE = """`state()` is one float32 vector in the world frame: the time left, then every hunter by seat, then
`max_targets` places for targets in spawning order.
"""

STATE_OF_PREY = """
Where there is prey, each prey follows, by index. In `herd`:
"""


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
    moving = columns(scenario("standard", target_motion="wander"))
    of_moving_target = tuple(column for column in moving if column.name.startswith("target_1."))
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
            STATE_OF_PREY,
            table(tuple(of_prey), skip_repeats=(), first=state_columns(herd).index(of_prey[0])),
            "",
        )
    )


def limits_table(kind: type[Limits | PreyLimits]) -> str:
    """The fields of `view.limits` as a Markdown table, from the words below each of them in the source."""
    (limits,) = ast.parse(inspect.getsource(kind)).body
    lines = ["| field | unit | meaning |", "|---|---|---|"]
    for pair in pairwise(limits.body):
        match pair:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(words))):
                unit = re.search(r" \[(.+?)\]", words)
                meaning = words if unit is None else words.replace(unit[0], "", 1)
                lines.append(f"| `{name}` | {'' if unit is None else unit[1]} | {meaning} |")
    return "\n".join(lines)


def agents_page(page: str) -> str:
    """docs/agents.md with its tables of limits as they should be."""
    begin, end = "<!-- made from catch_arena/policy.py by `make docs` -->\n\n", "\n\n<!-- end -->"
    before, *parts = page.split(begin)
    tables = map(limits_table, (Limits, PreyLimits))
    made = (f"{begin}{table}{end}{part.partition(end)[2]}" for table, part in zip(tables, parts, strict=True))
    return before + "".join(made)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    agents = DOCS / "agents.md"
    for path, text in (
        (DOCS / "observation.md", observation_page()),
        (agents, agents_page(agents.read_text())),
    ):
        path.write_text(text)
        print(path.relative_to(DOCS.parent))

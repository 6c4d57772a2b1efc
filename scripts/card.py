"""Play the suite with every shipped agent, and write docs/reference/card.md.

The page has each agent's description, results and weaknesses.
The results of the references go to catch_arena/suite/references.json.

Matches are kept in out/card, and a second run continues from there: it plays only matches of changed agents again. If
agents are named, only their entries in the card change.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before the imports below, which take a second

import argparse
import importlib
import json
import re
import shutil
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from bench.machine import machine

from catch_arena.cli.options import Processes
from catch_arena.cli.tables import with_interval
from catch_arena.cli.terminal import progress_bar
from catch_arena.errors import CatchArenaError, ConfigError, OtherTournamentError
from catch_arena.files import write_whole
from catch_arena.suite.contents import HELD_OUT_OPPONENTS, REFERENCES, SUITE, TRAINING_OPPONENTS
from catch_arena.suite.measures import REFERENCES_FILE, AgentMeasures, facts_of, measure
from catch_arena.suite.tournaments import play, tournaments
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.loading import shipped
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.intervals import Estimate

PAGE: Final = Path(__file__).parent.parent / "docs" / "reference" / "card.md"
OUT: Final = Path("out/card")
WEAK: Final = 0.45
"""Normalised score below which a scenario is listed as a weakness."""

HEAD: Final = """# The agents that come with the package

Their results in `{suite}` (digest {digest}). [The protocol](../howto/suite.md) defines the figures.
Agents are sorted by their score in the held-out scenarios. 0.5 is level with the mean opponent.

Measured by `{command}` on {machine}. The protocol has {blocks} blocks of each scenario; results of fewer blocks are
preliminary. `?` marks a result of too few blocks. The time of a move is wall-clock time, in processes without
isolation, on a machine that did other work too.

| {headings} |
{rule}"""
HEADINGS: Final = ("agent", "control", "blocks", "training", "held out", "gap", "first", "forfeits", "per move")
TABLE: Final = re.compile(r"(?:^\| \[?`.*\n)+", re.MULTILINE)
"""Pattern of the rows of a table, one for each agent."""
CROSS_PLAY: Final = "## Cross-play of learned agents\n"
"""Heading of the last part of the card, which scripts/cross_play.py writes."""
SECTIONS: Final = re.compile(r"^(?=### )", re.MULTILINE)
"""Pattern of the beginning of an agent's section."""
KEY: Final = """
*Training*, *held out*: interquartile means of the normalised score, with 95 % intervals; *gap*: the first minus
the second. *First*: the number of scenarios in which the agent is surely first among itself and its opponents, in which
that is open, and in which it is surely not first.
"""


def main() -> int:
    """Write the card; return the exit code: 0, or 2 after printing the reason in a line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("agents", nargs="*", help="agents to put into the card; without names, all")
    parser.add_argument(
        "--blocks", type=int, default=SUITE.blocks, help="number of blocks of agents that are not references"
    )
    args = parser.parse_args()
    try:
        wanted = args.agents or list(shipped())
        agents = enter(sorted(wanted, key=lambda name: name not in REFERENCES))  # references are needed most
        measured = [result_of(one, args.blocks) for one in agents]
        measured.sort(key=lambda one: -one.held_out.mean)
        text = page(measured, args.blocks)
        card, heading, cross_play = PAGE.read_text(encoding="utf-8").partition(CROSS_PLAY)
        if args.agents:
            text = merged(card, text, args.blocks)
        write_whole(PAGE, (text + heading + cross_play).encode())
        write_whole(REFERENCES_FILE, references_text(REFERENCES_FILE.read_text(), measured).encode())
    except CatchArenaError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{PAGE}\n{REFERENCES_FILE}")
    return 0


def result_of(agent: Entrant, most: int) -> AgentMeasures:
    """Play an agent in the suite, and return its results; matches of other versions of it or its opponents are removed.

    Args:
        agent: the agent to measure.
        most: number of blocks of each scenario, unless the agent is a reference.
    """
    blocks = SUITE.blocks if agent.name in REFERENCES else most
    setups = tournaments(SUITE, agent, OUT, blocks, None)
    for one in setups:
        try:
            with one.begin(resume=True):
                pass
        except OtherTournamentError as error:
            print(f"{agent.name} is played again in {one.folder.name}: {error}", file=sys.stderr)
            shutil.rmtree(one.folder)
    with progress_bar(agent.name) as show:
        play(setups, Processes().workers, show)
    return measure(SUITE, setups)


def page(measured: Sequence[AgentMeasures], most: int) -> str:
    """Return the text of docs/reference/card.md; `most` is that of `result_of`."""
    command = "make card" if most == SUITE.blocks else f"scripts/card.py --blocks {most}"
    facts = {"suite": SUITE.name, "digest": SUITE.digest, "blocks": SUITE.blocks, "machine": machine()}
    head = HEAD.format(**facts, command=command, headings=" | ".join(HEADINGS), rule="|---" * len(HEADINGS) + "|")
    tables = [*of_scenarios(measured, held_out=False), *of_scenarios(measured, held_out=True)]
    sections = [line for one in measured for line in section(one)]
    return "\n".join([head, *map(summary, measured), KEY, *tables, *sections])


def merged(card: str, page: str, most: int) -> str:
    """Return the card with all agents of another page, highest held-out scores first; `most` is that of `result_of`.

    Raises:
        ConfigError: the card is of another suite, so its figures cannot be compared with these.
    """
    if f"(digest {SUITE.digest})" not in card:
        raise ConfigError(f"{PAGE} is of another suite than {SUITE.digest}; make the whole card: make card")
    head, *old = SECTIONS.split(card)
    sections = {name_in(one): one.rstrip() for one in old}
    for one in SECTIONS.split(page)[1:]:
        name = name_in(one)
        sections[name] = (
            f"{one.rstrip()}\n- Measured alone, by `scripts/card.py --blocks {most} {name}` on {machine()}."
        )
    tables = [
        {name_in(row): row for row in (*before.splitlines(), *rows.splitlines())}
        for before, rows in zip(TABLE.findall(head), TABLE.findall(page), strict=True)
    ]
    held_out = {name: float(row.split(" | ")[4].split()[0]) for name, row in tables[0].items()}
    order = sorted(held_out, key=lambda name: -held_out[name])
    texts = iter("".join(f"{rows[name]}\n" for name in order) for rows in tables)
    head = TABLE.sub(lambda _: next(texts), head)
    return head + "\n\n".join(sections[name] for name in order) + "\n"


def references_text(before: str, measured: Sequence[AgentMeasures]) -> str:
    """Return the text of references.json, `before` with newer figures of the references among these agents."""
    figures = {one["agent"]: one for one in json.loads(before)["agents"]}
    figures |= {one.agent.name: facts_of(SUITE, one, {}) for one in measured}
    return json.dumps({"agents": [one for name, one in figures.items() if name in REFERENCES]}, indent=1) + "\n"


def name_in(text: str) -> str:
    """Return the agent's name from its row or section."""
    return re.match(r"(?:### |\| \[?`)(\w+)", text)[1]  # type: ignore[index]


def summary(one: AgentMeasures) -> str:
    """Return an agent's row of the first table."""
    first = Counter(of.first for of in one.scenarios)
    cells = (
        f"[`{one.agent.name}`](#{one.agent.name})",
        one.agent.control,
        str(one.blocks),
        figure(one.training),
        figure(one.held_out),
        figure(one.gap),
        f"{first[True]} / {first[None]} / {first[False]}" if one.blocks == SUITE.blocks else "?",
        str(one.forfeits),
        f"{one.move_ms:.2f} ms",
    )
    return f"| {' | '.join(cells)} |"


def of_scenarios(measured: Sequence[AgentMeasures], *, held_out: bool) -> Iterator[str]:
    """Yield the lines of the table of held-out or of training scenarios."""
    scenarios = SUITE.part(held_out=held_out)
    yield f"## {'Held-out' if held_out else 'Training'} scenarios\n"
    yield "Normalised score, and the share of matches won.\n"
    yield f"| agent | {' | '.join(f'`{one.name}`' for one in scenarios)} |"
    yield "|---" * (len(scenarios) + 1) + "|"
    for one in measured:
        part = [of for of in one.scenarios if of.held_out == held_out]
        cells = [f"{figure(of.score)}, {100 * of.win_share.mean:.0f} %" for of in part]
        yield f"| `{one.agent.name}` | {' | '.join(cells)} |"
    yield ""


def section(one: AgentMeasures) -> Iterator[str]:
    """Yield the lines of an agent's section: its description, results and weaknesses."""
    module = importlib.import_module(one.agent.spec.partition(":")[0])
    made = "Trained" if one.agent.name.startswith("ppo_") else "Scripted"
    yield f"### {one.agent.name}\n"
    for part in (module.__doc__ or "").strip().split("\n\n"):
        yield f"{' '.join(part.split())}\n"
    yield f"- Control: {one.agent.control}. {made}. Source: digest {one.agent.digest}."
    yield f"- Held out {figure(one.held_out)}, training {figure(one.training)}; {one.move_ms:.2f} ms per move."
    yield f"- Matches: {sum(of.matches for of in one.scenarios)}, of which it forfeited {one.forfeits}."
    yield f"- Not good at: {weaknesses(one)}."
    for opponents, kind in ((TRAINING_OPPONENTS, "a training opponent"), (HELD_OUT_OPPONENTS, "a held-out opponent")):
        if one.agent.name in opponents:
            yield f"- It is {kind} of the suite, and plays against itself there."
    yield ""


def weaknesses(one: AgentMeasures) -> str:
    """Return the scenarios in which an agent is weak or forfeits, worst first; if none or all are, only the worst."""
    worst = sorted(one.scenarios, key=lambda of: of.score.mean)
    descriptions = {of.name: of.description.replace("`", "") for of in SUITE.scenarios}
    weak = [of for of in worst if of.score.mean < WEAK or of.forfeits]
    if len(weak) == len(worst):
        return (
            f"any scenario; worst of all `{worst[0].name}` ({descriptions[worst[0].name]}), {worst[0].score.mean:.2f}"
        )
    if not weak:
        return f"nothing here in particular; its lowest score is {worst[0].score.mean:.2f}, in `{worst[0].name}`"
    return "; ".join(f"`{of.name}` ({descriptions[of.name]}), {of.score.mean:.2f}" for of in weak)


def figure(estimate: Estimate) -> str:
    """Return an estimate with its interval."""
    return with_interval(estimate, ".2f")


if __name__ == "__main__":
    interrupts.run(main)

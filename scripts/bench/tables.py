"""Results as Markdown tables, for the screen and for docs/explanation/performance.md."""

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from ours import BATCH, LARGE, ONE_ARENA
from subject import UNITS


def written(figures: Mapping[str, Any]) -> str:
    """Return all results as Markdown."""
    versions: Mapping[str, Mapping[str, Any]] = figures["versions"]
    text = [f"{figures['machine']}. {figures['what']}. Command: `{figures['command']}`. {figures['rounds']}."]
    if "before" in versions:
        text.append(_compared(versions["before"], versions["now"]))
    else:
        text.append(_alone({**versions["now"], **versions.get("peers", {})}))
        if versions.get("peers"):
            text += ["How many times as fast ours are:", _peers(versions["now"], versions["peers"])]
    text += [f"Skipped: {name} ({reason})." for name, reason in figures["skipped"].items()]
    return "\n\n".join(text) + "\n"


def _in_unit(row: Mapping[str, Any], seconds: float) -> str:
    agents = row["agents"] if "agent" in row["unit"] else 1
    return f"{UNITS[row['unit']] * seconds / agents:,.4g}"


def _compared(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return the table of two versions, with the speed of the current one relative to the older one."""
    rows = []
    for name, row in now.items():
        pair = (before[name]["cpu"], row["cpu"])
        by_round = sorted(old / new for old, new in zip(*pair, strict=True))
        aside = len(by_round) // 4
        rows.append(
            (
                f"{name}, {row['unit']}",
                *(f"{_in_unit(row, statistics.median(one))} ({_in_unit(row, min(one))})" for one in pair),
                f"{rounded(statistics.median(pair[0]) / statistics.median(pair[1]))}x",
                f"{by_round[aside]:.3g} to {by_round[-1 - aside]:.3g}",
            )
        )
    head = ("median (least)", "before", "now", "times as fast", "middle half of the rounds")
    return table(head, rows)


def _alone(rows: Mapping[str, Mapping[str, Any]]) -> str:
    head = ("what", "agents", "floats seen", "median (least)", "unit", "agent-steps per CPU-s", "agent-steps per s")
    lines = []
    for name, row in rows.items():
        cost = f"{_in_unit(row, statistics.median(row['cpu']))} ({_in_unit(row, min(row['cpu']))})"
        stepped = row["unit"] in {"ns per agent-step", "us per step"}
        rates = [rounded(row["agents"] / statistics.median(row[clock])) if stepped else "" for clock in ("cpu", "wall")]
        sizes = [row["agents"] if stepped else "", row["floats"] or ""]
        lines.append((name, *sizes, cost, row["unit"], *rates))
    return table(head, lines)


def _peers(ours: Mapping[str, Any], peers: Mapping[str, Any]) -> str:
    """Return the table of ratios: a single environment is compared by its env-steps, a batch by its agent-steps."""
    references = [name for name in (ONE_ARENA, BATCH, LARGE) if name in ours]

    def ratio(name: str, peer: Mapping[str, Any]) -> str:
        row = ours[name]
        if row["envs"] == 1 and peer["envs"] > 1:
            return ""
        agents = 1.0 if row["envs"] == 1 else row["agents"] / peer["agents"]
        faster = agents * statistics.median(b / a for a, b in zip(row["cpu"], peer["cpu"], strict=True))
        return f"{rounded(faster)}x"

    units = ["env-steps" if name == ONE_ARENA else "agent-steps" for name in references]
    head = ("peer", *(f"our {name}, in {unit}" for name, unit in zip(references, units, strict=True)))
    return table(head, [(name, *(ratio(one, peer) for one in references)) for name, peer in peers.items()])


def rounded(value: float) -> str:
    """Return a number as text with three digits, the precision of a run."""
    return f"{float(f'{value:.3g}'):,.12g}"


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a Markdown table with aligned columns, readable on a screen; all but the first are right-aligned."""
    lines = [[str(cell) for cell in row] for row in (head, *rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    lines.insert(1, [f"{'-' * (width - 1)}{':' if column else '-'}" for column, width in enumerate(widths)])
    aligned = [[line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in aligned)

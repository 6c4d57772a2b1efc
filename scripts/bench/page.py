"""The figures as Markdown, for the screen and for docs/performance.md."""

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

import ours
from judged import judged
from measure import Subject, ratio
from peers import PEERS
from phases import WHOLE
from tables import number, rate, table, times


def written(figures: Mapping[str, Any], subjects: Sequence[Subject]) -> str:
    """Everything that was measured, as sections with a table each."""
    groups: dict[str, list[Subject]] = {}
    for subject in subjects:
        groups.setdefault(subject.group, []).append(subject)
    sections = [f"{figures['machine']}. {figures['version']}. Command: `{figures['command']}`."]
    if subjects:
        sections += ["### Wanted, and measured", _wanted(figures, subjects)]
    if PEERS in groups or figures["skipped"]:
        sections += ["### Beside others", _beside_others(subjects)]
        sections += [f"Skipped: {name} ({reason})." for name, reason in figures["skipped"].items()]
    if ours.RESET in groups:
        sections += ["### One arena, and batches", _alone(groups[ours.ENV] + groups[ours.BATCH])]
        for group in (ours.HUNTERS, ours.TARGETS):
            sections += [f"### {group.capitalize()}", _growth(groups[group])]
        sections += ["### Reset and memory", _reset_and_memory(groups[ours.RESET], figures["bytes_per_arena"])]
    if "startup" in figures:
        sections += ["### Import and start-up", _startup(figures["startup"])]
    if "limits" in figures:
        sections += ["### What stands in the way", _limits(figures["limits"])]
    if "phases" in figures:
        sections += ["### Where a step's time goes", _phases(figures["phases"])]
    return "\n\n".join(sections) + "\n"


def _wanted(figures: Mapping[str, Any], subjects: Sequence[Subject]) -> str:
    rows = [
        (one.what, "" if one.measured is None else number(one.measured), one.wanted.said(one.measured))
        for one in judged(figures, subjects)
    ]
    return table(("what", "measured", "target"), rows)


def _beside_others(subjects: Sequence[Subject]) -> str:
    """What each does in a step and how fast, and then how many times as fast ours are as each peer."""
    references, peers = subjects[: ours.REFERENCES], [s for s in subjects if s.group == PEERS]
    work = [
        (
            _titled(subject),
            subject.agents,
            subject.work.observation_floats,
            subject.work.physics_ticks,
            "yes" if subject.work.arbiter else "no",
            rate(statistics.median(subject.env_steps)),
            rate(subject.agent_steps),
        )
        for subject in (*references, *peers)
    ]
    head = (
        "environment",
        "agents",
        "floats seen",
        "physics ticks",
        "arbiter",
        "env-steps per CPU-s",
        "agent-steps per CPU-s",
    )
    if not peers:
        return table(head, work)
    ratios = [(_titled(peer), *(_beside(reference, peer) for reference in references)) for peer in peers]
    ratios_head = (
        "beside",
        "our one arena, in env-steps",
        *(f"our batch of {one.envs:,}, in agent-steps" for one in references[1:]),
    )
    return f"{table(head, work)}\n\nHow many times as fast ours are:\n\n{table(ratios_head, ratios)}"


def _titled(subject: Subject) -> str:
    return subject.name if subject.envs == 1 else f"{subject.name}, {subject.envs:,} at once"


def _beside(reference: Subject, peer: Subject) -> str:
    """A single environment is compared by its env-steps and with single ones only, a batch by its agent-steps."""
    if reference.envs == 1 and peer.envs > 1:
        return ""
    agents = 1.0 if reference.envs == 1 else reference.agents / peer.agents
    return times(ratio(reference.env_steps, peer.env_steps) * agents)


def _alone(subjects: Sequence[Subject]) -> str:
    rows = [
        (
            subject.name,
            f"{subject.envs:,}",
            subject.threads,
            rate(statistics.median(subject.env_steps)),
            rate(subject.agent_steps),
            rate(subject.agent_steps_on_the_wall),
            _beside_one_thread(subject, subjects),
        )
        for subject in subjects
    ]
    head = (
        "interface",
        "arenas",
        "threads",
        "env-steps per CPU-s",
        "agent-steps per CPU-s",
        "agent-steps per s",
        "beside 1 thread, per s",
    )
    return table(head, rows)


def _beside_one_thread(subject: Subject, subjects: Sequence[Subject]) -> str:
    if subject.threads == 1:
        return ""
    alike = (s for s in subjects if (s.name, s.envs, s.threads) == (subject.name, subject.envs, 1))
    return times(ratio(subject.env_steps_on_the_wall, next(alike).env_steps_on_the_wall))


def _growth(subjects: Sequence[Subject]) -> str:
    """Cost beside that of the standard 4 hunters and 16 targets."""
    usual = next((s for s in subjects if s.name == ours.USUAL), subjects[0])
    rows = [
        (
            subject.name,
            f"{subject.envs:,}",
            subject.work.observation_floats,
            rate(subject.agent_steps),
            f"{1e9 / subject.agent_steps:.1f}",
            times(ratio(usual.env_steps, subject.env_steps) * usual.agents / subject.agents),
        )
        for subject in subjects
    ]
    head = (
        "arena",
        "arenas",
        "floats seen",
        "agent-steps per CPU-s",
        "ns per agent-step",
        f"cost, beside {usual.name}",
    )
    return table(head, rows)


def _reset_and_memory(subjects: Sequence[Subject], bytes_per_arena: Mapping[int, float]) -> str:
    rows: list[tuple[object, ...]] = [
        (_titled(subject), f"{1e6 / statistics.median(subject.env_steps):.2f} us an arena") for subject in subjects
    ]
    rows += [
        (f"memory of a batch of {envs:,}", f"{held:,.0f} bytes an arena") for envs, held in bytes_per_arena.items()
    ]
    return table(("what", "cost"), rows)


def _startup(startup: Mapping[str, Mapping[str, float]]) -> str:
    rows = [(name, f"{one['wall_s']:.2f}", f"{one['cpu_s']:.2f}") for name, one in startup.items()]
    return table(("a process that ends with", "s", "CPU-s"), rows)


def _limits(limits: Mapping[str, Any]) -> str:
    """A small table for each."""
    parts = []
    for control, us in limits["one_arena_us"].items():
        rest = us["whole"] - us["engine"] - us["five dicts"]
        parts.append((control, *(f"{value:.2f}" for value in (us["whole"], us["engine"], us["five dicts"], rest))))
    head = ("one arena, us a step", "whole", "the engine alone", "an env that only makes five dicts", "the rest")
    tables = [table(head, parts)]
    for title, key, digits in (
        ("memory of a large batch, by part", "memory_bytes", "{:,.0f}"),
        ("first step of one arena, cold, by part", "cold_cpu_s", "{:.2f}"),
        ("two threads beside one, without an arena", "two_threads", "{:.2f}x"),
    ):
        if key in limits:
            unit = {"memory_bytes": "bytes an arena", "cold_cpu_s": "CPU-s", "two_threads": "on the wall"}[key]
            tables.append(table((title, unit), [(what, digits.format(one)) for what, one in limits[key].items()]))
    return "\n\n".join(tables)


def _phases(batches: Sequence[Mapping[str, Any]]) -> str:
    head = ["phase, ns per agent-step"]
    texts = []
    for one in batches:
        head += [one["title"], "share"]
        texts.append(
            f"- {one['title']}: a step writes {one['bytes_written_per_agent_step']:.0f} bytes of "
            f"observations, masks and rewards for each agent, and reads and writes {one['state_bytes_per_agent']:.0f} "
            f"bytes of state; this machine fills as much memory with {one['fill_gigabytes_per_s']:.1f} GB/s."
        )
    rows = []
    for phase in batches[0]["ns_per_agent_step"]:
        row = [phase]
        for one in batches:
            nanoseconds = one["ns_per_agent_step"]
            row += [f"{nanoseconds[phase]:.1f}", f"{100 * nanoseconds[phase] / nanoseconds[WHOLE]:.0f} %"]
        rows.append(row)
    return "\n".join(texts) + "\n\n" + table(head, rows)

"""Check of an agent before a tournament: it plays against itself, and every fault is reported in words."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from catch_arena.config import ArenaConfig
from catch_arena.policy import PreyView, player_limits
from catch_arena.text import last_lines
from catch_arena.tournament.entrants import SHIPPED_PREY, Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import MOST_TIMEOUTS, Forfeit, MatchResult, MoveTimes
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.parties import Parties
from catch_arena.verdicts import Verdict


@dataclass(frozen=True, slots=True)
class Finding:
    """Finding of the check."""

    level: Literal["ok", "warning", "error"]
    text: str
    """Text of the finding: the first line states it, further lines show evidence."""


def check_fitness(
    entrant: Entrant,
    arenas: Mapping[str, ArenaConfig],
    sandbox: Sandbox | None,
    progress: Callable[[int, int], None] = lambda *_: None,
    play: Callable[..., MatchResult] = play_entrants,
) -> Iterator[Finding]:
    """Yield the findings about an agent that plays against itself; `progress` gets (done, total) before each match.

    In the first arena without a forfeit it plays twice, to check that equal seeds give equal matches. `play` is called
    as `play_entrants`.
    """

    def play_in(config: ArenaConfig) -> MatchResult:
        return play(config, 0, [entrant] * len(Parties.of(config)), sandbox)

    if entrant.fault is not None:
        yield Finding("error", f"cannot begin: {entrant.fault}{_tail(entrant.log)}")
        return
    prey = f"{SHIPPED_PREY} plays prey for it" if entrant.needs_prey else "plays prey itself"
    yield Finding("ok", f"control {entrant.control}, {prey}, digest {entrant.digest}")
    step_ms = (Quotas() if sandbox is None else sandbox.quotas).step_ms
    reported: set[tuple[str, str]] = set()
    whole: dict[str, MatchResult] = {}
    late = 0
    for number, (name, config) in enumerate(arenas.items()):
        if late == MOST_TIMEOUTS:
            left = ", ".join(list(arenas)[number:])
            yield Finding("warning", f"was too slow in {late} arenas, and not tried in: {left}")
            return
        progress(number, len(arenas) + 1)
        result = play_in(config)
        yield from _findings(name, config, result, step_ms, reported)
        late += any(forfeit is not None and forfeit.late for forfeit in result.forfeits)
        if not any(result.forfeits):
            whole[name] = result
    if not whole:  # the forfeits have been reported, and there is no match to repeat
        return
    name, first = next(iter(whole.items()))
    progress(len(arenas), len(arenas) + 1)
    if play_in(arenas[name]) == first:
        yield Finding("ok", f"{name}: plays the same match again, given the same seed")
        return
    yield Finding(
        "warning",
        f"{name}: plays another match, given the same seed: "
        "draw from random.Random(seed) of reset, and not from the clock or the global random",
    )


def _findings(
    name: str, config: ArenaConfig, result: MatchResult, step_ms: float, reported: set[tuple[str, str]]
) -> Iterator[Finding]:
    """Yield the findings of one match; failures in `reported` are shown briefly, and new ones are added to it."""
    parties = Parties.of(config)
    failed: dict[tuple[str, str], tuple[int, Forfeit]] = {}  # the first of each kind
    for party, forfeit in enumerate(result.forfeits):
        if forfeit is not None:
            failed.setdefault((forfeit.code, forfeit.reason), (party, forfeit))
    for kind, (party, forfeit) in failed.items():
        shown = "" if kind in reported else f"{_shown_to(forfeit, config)}{_tail(result.logs[party])}"
        role = " as prey" if config.prey and forfeit.seat >= config.hunters else ""
        yield Finding("error", f"{name}{role}: {forfeit}{shown}")
    reported.update(failed)
    times = MoveTimes.of_all(result.thinking)
    longest_ms = 1000.0 * times.longest_s
    timing = f"{times.mean_ms:.1f} ms a step, at longest {longest_ms:.1f} of {step_ms:g}"
    if not failed:
        hunting = parties.hunting
        scores = ", ".join(map(str, result.scores[:hunting]))
        what = "its score is" if hunting == 1 else f"its {hunting} copies score"
        caught = f"; caught, as prey: {', '.join(map(str, result.scores[hunting:]))}" if config.prey else ""
        yield Finding("ok", f"{name}: {result.steps} steps; {what} {scores}{caught}; {timing}")
    if longest_ms > step_ms:
        yield Finding("warning", f"{name}: is too slow: {timing}; what is over comes out of the bank of the match")
    logs = zip(parties.seats, result.logs, strict=True)
    # a team's log begins with a line that names the seat
    printed = next((log.partition("\n")[2] if len(seats) > 1 else log for seats, log in logs if log), "")
    if printed and not failed:
        first_line = printed.lstrip().partition("\n")[0][:80]
        yield Finding("warning", f"{name}: prints, which goes to its log: {first_line!r}")
    for verdict in (Verdict.MALFORMED, Verdict.OUT_OF_REACH):
        count = sum(tally.get(verdict.name, 0) for tally in result.verdicts)
        if count:
            yield Finding("warning", f"{name}: {count} requests were {verdict.name}: {verdict.reason}")


def _shown_to(forfeit: Forfeit, config: ArenaConfig) -> str:
    """Return the view that the agent failed on, as a line; empty if there is none."""
    if forfeit.observation is None:
        return ""
    view = player_limits(config, forfeit.seat).view(*forfeit.observation)
    if isinstance(view, PreyView):
        hunters = ", ".join(f"{hunter.distance:.2f} m" for hunter in view.hunters)
        return (
            f"\nit saw: hunters {hunters or 'none (view.hunters is empty)'}; other prey {len(view.others)}; "
            f"{'alive' if view.alive else 'out'}; caught {view.times_caught:g} times; {view.time_left:.1f} s left"
        )
    targets = ", ".join(f"{target.rank}: {target.distance:.2f} m" for target in view.targets)
    return (
        f"\nit saw: targets {targets or 'none (view.targets is empty)'}; rivals {len(view.rivals)}; "
        f"mask {list(view.mask)}; score {view.score:g}; {view.time_left:.1f} s left"
    )


def _tail(log: str) -> str:
    return "".join(f"\n| {line}" for line in last_lines(log, 6).splitlines())

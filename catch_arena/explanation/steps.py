"""All about one step: what each hunter did, what it asked for, and how far everybody was from that."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

from catch_arena.core.arbiter import distance_um
from catch_arena.core.ranking import key_of
from catch_arena.errors import ConfigError
from catch_arena.explanation.match_summary import Contest, contests_of, json_ready
from catch_arena.explanation.seats import labels, seat_of
from catch_arena.replay import Replay
from catch_arena.verdicts import REASONS, Ruling, Verdict
from catch_arena.world import World


@dataclass(frozen=True, slots=True)
class HunterAction:
    """What one hunter did in a step, and the answer."""

    seat: int
    control: str
    action: str
    """In words."""
    chosen: str | None
    """The target of the rank that it named; None without one."""
    target: str | None
    """What it requested; None where it requested nothing, or a rank without a target."""
    verdict: Verdict | None
    """None where it requested nothing."""
    reason: str | None
    distance_um: int | None
    """The arbiter's evidence: None unless reach was tested."""
    winner: int | None


@dataclass(frozen=True, slots=True)
class StepExplanation:
    """One step; distances are those of the state that it was judged on (R5.1)."""

    step: int
    """Counted from 1."""
    begin_ms: int
    end_ms: int
    names: tuple[str, ...]
    """What the hunters are called, by seat."""
    asked: tuple[HunterAction, ...]
    """A line for each hunter that was asked about."""
    distances_um: dict[str, tuple[int, ...]]
    """For each target that these named or requested: every hunter's distance, by seat (R5.3)."""
    contests: tuple[Contest, ...]

    def lines(self) -> list[str]:
        """The step in words: a paragraph for each hunter, each target and each contest."""
        from catch_arena.explanation.sentences import step_paragraphs

        return step_paragraphs(self)

    def to_dict(self) -> dict[str, Any]:
        """The same for programs: JSON-ready; verdicts by name, lots in hexadecimal digits."""
        return {name: json_ready(value) for name, value in asdict(self).items()}


def explain_step(replay: Replay, step: int, hunter: int | str | None = None) -> StepExplanation:
    """Play a match as far as one step, counted from 1, and tell all about that.

    Args:
        replay: the recorded match.
        step: which step, from 1.
        hunter: a seat or an agent's name, to hear of that one alone.

    Raises:
        ReplayError: where the match does not play as recorded.
        ConfigError: for a step or a hunter that it does not have.
    """
    if not 1 <= step <= replay.steps:
        has = f"from 1 to {replay.steps}" if replay.steps else "one of the match, which has none"
        raise ConfigError(f"step must be {has}, got {step}")
    chosen = range(replay.config.hunters) if hunter is None else (seat_of(replay, hunter),)
    before, after = islice(replay.worlds(), step - 1, step + 1)
    rulings = {ruling.hunter: ruling for ruling in after.rulings}
    asked = tuple(_asked(replay, before, step, seat, rulings.get(seat)) for seat in chosen)
    named = {name for one in asked for name in (one.chosen, one.target) if name is not None}
    return StepExplanation(
        step=step,
        begin_ms=before.time_ms,
        end_ms=after.time_ms,
        names=labels(replay.names),
        asked=asked,
        distances_um={
            target.name: tuple(_distances(before, (target.x, target.y)))
            for target in before.targets
            if target.name in named
        },
        contests=tuple(
            contest for contest in contests_of(replay, after) if any(claim.seat in chosen for claim in contest.claims)
        ),
    )


def _asked(replay: Replay, before: World, step: int, seat: int, ruling: Ruling | None) -> HunterAction:
    rank = int(replay.choices[step - 1][seat])
    seen = _seen(replay, before, seat)
    return HunterAction(
        seat=seat,
        control=replay.config.controls[seat],
        action=replay.action(step - 1, seat),
        chosen=seen[rank - 1] if 0 < rank <= len(seen) else None,
        target=None if ruling is None or ruling.target is None else str(ruling.target),
        verdict=None if ruling is None else ruling.verdict,
        reason=None if ruling is None else REASONS[ruling.verdict],
        distance_um=None if ruling is None else ruling.distance_um,
        winner=None if ruling is None else ruling.winner,
    )


def _seen(replay: Replay, world: World, seat: int) -> Sequence[str]:
    """R7.1: the targets in a seat's view by rank: nearest first, and then by spawn number."""
    me = world.hunters[seat]
    ranked = sorted(
        (key_of(target.x - me.x, target.y - me.y, slot), target.name) for slot, target in enumerate(world.targets)
    )
    return [name for _, name in ranked[: replay.config.targets_seen]]


def _distances(world: World, place: tuple[float, float]) -> list[int]:
    return [int(distance_um(place[0] - hunter.x, place[1] - hunter.y)) for hunter in world.hunters]

"""All about one step: what each hunter did, what it asked for, and how far everybody was from that."""

from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

from catch_arena.core.arbiter import measure_um
from catch_arena.errors import ConfigError
from catch_arena.explanation.match_summary import Contest, contests_of, json_ready
from catch_arena.explanation.seats import find_seat, how_it_left, labels
from catch_arena.explanation.sight import Sight, Unseen
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
    out: str | None
    """Why it took no part: "withdrawn" (R1.6) or "dropped out" (R1.7); None for one that did."""
    seen: int
    """How many targets it saw (R7.5)."""
    unseen: tuple[Unseen, ...]
    """Those that it did not, the nearest first."""


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
    out_of_sight: dict[str, tuple[int, ...]]
    """For each of these: the seats that did not see it (R7.5)."""
    view_radius_m: float | None
    view_angle_deg: float
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
    chosen = range(replay.config.hunters) if hunter is None else (find_seat(replay, hunter),)
    before, after = islice(replay.worlds(), step - 1, step + 1)
    sight = Sight(replay.config)
    rulings = {ruling.hunter: ruling for ruling in after.rulings}
    asked = tuple(_asked(replay, sight, (before, after), seat, rulings.get(seat)) for seat in chosen)
    named = {name for one in asked for name in (one.chosen, one.target) if name is not None}
    unseen = [{one.target for one in sight.unseen(before, seat)} for seat in range(replay.config.hunters)]
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
        out_of_sight={
            name: tuple(seat for seat, missing in enumerate(unseen) if name in missing) for name in sorted(named)
        },
        view_radius_m=replay.config.view_radius_m,
        view_angle_deg=replay.config.view_angle_deg,
        contests=tuple(
            contest for contest in contests_of(replay, after) if any(claim.seat in chosen for claim in contest.claims)
        ),
    )


def _asked(replay: Replay, sight: Sight, worlds: tuple[World, World], seat: int, ruling: Ruling | None) -> HunterAction:
    before, after = worlds
    step = before.step
    rank = int(replay.choices[step][seat])
    view = sight.ranked(before, seat)
    unseen = tuple(sight.unseen(before, seat))
    return HunterAction(
        seat=seat,
        control=replay.config.controls[seat],
        action=replay.action(step, seat),
        chosen=view[rank - 1] if 0 < rank <= len(view) else None,
        target=None if ruling is None or ruling.target is None else str(ruling.target),
        verdict=None if ruling is None else ruling.verdict,
        reason=None if ruling is None else REASONS[ruling.verdict],
        distance_um=None if ruling is None else ruling.distance_um,
        winner=None if ruling is None else ruling.winner,
        out=how_it_left(replay, seat) if after.hunters[seat].withdrawn else None,
        seen=len(before.targets) - len(unseen),
        unseen=unseen,
    )


def _distances(world: World, place: tuple[float, float]) -> list[int]:
    return [int(measure_um(place[0] - hunter.x, place[1] - hunter.y)) for hunter in world.hunters]

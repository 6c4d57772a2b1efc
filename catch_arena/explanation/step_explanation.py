"""Explanation of one step: each agent's action, its requests, and the distances of all hunters to the targets."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

from catch_arena.core.arbiter import measure_um
from catch_arena.errors import ConfigError, require_type
from catch_arena.explanation.contests import contests_of, unseen_targets
from catch_arena.explanation.facts import Contest, HunterAction, PreyAction, json_ready
from catch_arena.explanation.formatting import metres, seconds
from catch_arena.explanation.seats import exit_cause, find_subjects, labels, prey_labels, with_seat
from catch_arena.explanation.sentences import contest_sentence, listed, request_phrase, target_label
from catch_arena.plain import real_number, whole_number
from catch_arena.replay import Replay
from catch_arena.text import counted, with_type


@dataclass(frozen=True, slots=True)
class StepExplanation:
    """Explanation of one step; distances are those of the state on which requests were judged (R5.1)."""

    step: int
    """Number of the step, from 1."""
    begin_ms: int
    end_ms: int
    names: tuple[str, ...]
    """Labels of the hunters, by seat."""
    hunters: tuple[HunterAction, ...]
    """Actions of the hunters that the explanation is about."""
    prey: tuple[PreyAction, ...]
    """Actions of the prey that the explanation is about."""
    prey_by_target: dict[str, str]
    """Label of the prey by the name of each target that it plays."""
    distances_um: dict[str, tuple[int, ...]]
    """Distances of all hunters, by seat, to each target that these agents play, chose or requested (R5.3)."""
    reaches_um: tuple[int, ...]
    """Reach of each hunter in micrometres, by seat (R5.3)."""
    view_radius_m: float | None
    view_angle_deg: float
    contests: tuple[Contest, ...]

    def lines(self) -> list[str]:
        """Return the step in words: a line for the step, each hunter, each prey, each target and each contest."""
        begin, end, prey = seconds(self.begin_ms), seconds(self.end_ms), self.prey_by_target
        return [
            f"Step {self.step}, from {begin} to {end}: requests are judged on the state at {begin} (R5.1).",
            *map(self._action, self.hunters),
            *map(self._prey_action, self.prey),
            *map(self._distances, self.distances_um),
            *(contest_sentence(fact, self.names, prey.get(fact.target)) for fact in self.contests),
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return JSON-ready values: verdicts by name, lots in hexadecimal digits, distances in micrometres."""
        found: dict[str, Any] = json_ready(asdict(self))
        return found

    def _action(self, hunter: HunterAction) -> str:
        """Return one hunter's action in words, with its requests and the targets out of its sight."""
        chosen = f" ({hunter.chosen})" if hunter.chosen else ""
        name = with_seat(self.names[hunter.seat], hunter.seat)
        sentences = [f"{name}, {hunter.control} control: {hunter.action}{chosen}."]
        if hunter.out is not None:
            sentences.append(f"It takes no part: {hunter.out}.")
        sentences.append(f"It requested {'; then '.join(self._requests(hunter)) or 'nothing'}.")
        if hunter.unseen:
            sentences.append(self._sight(hunter))
        return " ".join(sentences)

    def _requests(self, hunter: HunterAction) -> Iterator[str]:
        rulings = [] if hunter.ruling is None else [(hunter.ruling, False)]
        for ruling, by_name in [*rulings, *((one, True) for one in hunter.by_name)]:
            target, distances = None if ruling.target is None else str(ruling.target), (ruling.distance_um,) * 2
            yield request_phrase(target, ruling.verdict, distances, self.reaches_um[hunter.seat], by_name=by_name)

    def _sight(self, hunter: HunterAction) -> str:
        """Return the limits of a hunter's sight, and the targets out of it, the nearest first, in words."""
        limits = []
        if self.view_radius_m is not None:
            limits.append(f"nearer than {self.view_radius_m:g} m")
        if self.view_angle_deg < 360.0:
            limits.append(f"at most {self.view_angle_deg / 2.0:g} degrees off its heading")
        shown = [
            f"{one.target}, {metres(one.distance_um)} away and {one.off_heading_deg:.1f} degrees off its heading"
            for one in hunter.unseen[:3]
        ]
        saw = f"{hunter.seen} of {counted(hunter.seen + len(hunter.unseen), 'target')}"
        return f"It sees targets that are {listed(limits)} (R7.5): {saw}. The nearest others: {'; '.join(shown)}."

    def _prey_action(self, prey: PreyAction) -> str:
        """Return one prey's action in words, with its capture and return."""
        if prey.withdrawn:
            parts = ["withdrawn (R12.5)."]
        elif prey.target is None:
            parts = ["out (R12.3)."]
        else:
            parts = [f"{prey.action}, as {prey.target}."]
        if prey.caught_by is not None:
            parts.append(f"It was caught by {self.names[prey.caught_by]} (R12.3).")
        if prey.returned_as is not None:
            parts.append(f"It returned as {prey.returned_as}.")
        return f"{prey.name}: {' '.join(parts)}"

    def _distances(self, target: str) -> str:
        """Return the distance of every hunter to one target in words, the nearest first."""
        ranked = sorted(zip(self.distances_um[target], self.names, strict=True))
        distances = listed(f"{name} {metres(distance)}" for distance, name in ranked)
        return f"Distances to {target_label(target, self.prey_by_target.get(target))}: {distances}."


def step_at(replay: Replay, at_s: float) -> int:
    """Return the step, counted from 1, that is judged on the state at a time, or on the last state before it.

    Args:
        replay: the recorded match.
        at_s: the time since the beginning of the match [s].

    Raises:
        ConfigError: for a time outside the match's steps, or one that is no number.
    """
    require_type("replay", replay, Replay, "Replay.load(path)")
    time_s = real_number(at_s)
    if time_s is None:
        raise ConfigError(f"at must be a number of seconds, got {with_type(at_s)}")
    period_ms = replay.config.control_period_ms
    step = round(1000 * time_s) // period_ms + 1 if math.isfinite(time_s) else 0
    if not 1 <= step <= replay.steps:
        last = seconds(max(0, replay.steps - 1) * period_ms)
        raise ConfigError(f"at must be from 0 to {last}, when the last step is judged, got {time_s:g} s")
    return step


def explain_step(replay: Replay, step: int, hunter: int | str | None = None) -> StepExplanation:
    """Play a match again up to one step, and return the explanation of that step.

    Args:
        replay: the recorded match.
        step: the step, counted from 1.
        hunter: a seat, `prey_{index}`, or the name of an agent or a team, to explain only those; None for all.

    Raises:
        ReplayError: if the match does not play as recorded.
        ConfigError: for a step or a hunter that the match does not have.
    """
    seats, prey_indices = find_subjects(replay, hunter)
    number = whole_number(step)
    if number is None or not 1 <= number <= replay.steps:
        raise ConfigError(f"step must be a whole number from 1 to {replay.steps}, got {step!r}")
    before, after, by_name = next(islice(replay.judged_steps(), number - 1, None))
    config, contests = replay.config, contests_of(replay.config, after, replay.seed)
    unseen = {seat: tuple(unseen_targets(config, before, seat)) for seat in seats}
    rulings = {ruling.hunter: ruling for ruling in after.rulings}
    hunters = tuple(
        HunterAction(
            seat=seat,
            control=config.controls[seat],
            action=replay.action(before.step, seat),
            chosen=after.hunters[seat].active_target if replay.choices[before.step][seat] else None,
            ruling=rulings.get(seat),
            out=exit_cause(replay, seat) if after.hunters[seat].withdrawn else None,
            seen=len(before.targets) - len(unseen[seat]),
            unseen=unseen[seat],
            by_name=tuple(ruling for ruling in by_name if ruling.hunter == seat),
        )
        for seat in seats
    )
    prey_names = prey_labels(replay)
    prey = tuple(
        PreyAction(
            index=index,
            name=prey_names[index],
            action=replay.action(before.step, config.hunters + index),
            target=before.prey[index].target,
            caught_by=after.prey[index].caught_by,
            returned_as=None if after.prey[index].target == before.prey[index].target else after.prey[index].target,
            withdrawn=after.prey[index].withdrawn,
        )
        for index in prey_indices
    )
    played = {action.target for action in prey}
    requested = {
        ruling.target for action in hunters for ruling in (action.ruling, *action.by_name) if ruling is not None
    }
    named = played | requested | {action.chosen for action in hunters}
    shown = [target for target in before.targets if target.name in named]
    return StepExplanation(
        step=number,
        begin_ms=before.time_ms,
        end_ms=after.time_ms,
        names=labels(replay.hunter_names),
        hunters=hunters,
        prey=prey,
        prey_by_target={
            state.target: name for state, name in zip(before.prey, prey_names, strict=True) if state.target is not None
        },
        distances_um={
            target.name: tuple(int(measure_um(target.x - hunter.x, target.y - hunter.y)) for hunter in before.hunters)
            for target in shown
        },
        reaches_um=config.reaches_um,
        view_radius_m=config.view_radius_m,
        view_angle_deg=config.view_angle_deg,
        contests=tuple(
            contest
            for contest in contests
            if contest.target in played or any(claim.seat in seats for claim in contest.claims)
        ),
    )

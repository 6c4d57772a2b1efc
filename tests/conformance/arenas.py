"""Arenas under test (catch_arena.testing.ArenaUnderTest) made of the adjudicators of tests/rulebook."""

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from oracle.arena import OracleArena
from oracle.arithmetic import DROPOUT, KILL_DOWN, KILL_REFUSED, SPAWN_DOWN, SPAWN_REFUSED, draw, fraction, key
from oracle.turtles import Hunter, Target, in_own_frame
from rulebook.adjudicators import Adjudicator, OracleAdjudicator, adjudicator

from catch_arena.config import ArenaConfig
from catch_arena.layout import Group, groups
from catch_arena.verdicts import Verdict

STEPS, COUNTED = range(3), range(1, 6)
"""Steps, firings and numbers that the faults of a case are arranged for."""


class AdjudicatorUnderTest:
    """One adjudicator as an arena under test."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.match: Any = None
        self.is_observed = False
        """True after a step; the parallel env observes no other state."""

    def make(self, config: ArenaConfig) -> Adjudicator:
        return adjudicator(self.kind, config)

    def reset(self, settings: Mapping[str, Any]) -> None:
        seed, faults = arranged({fault: settings.get(fault, []) for fault in STREAMS})
        dropout_rate = faults.pop("drop_outs", 0.0)
        quiet = {"hunters": 1, "initial_targets": settings.get("prey", 0), "spawn_frequency_hz": 0.001}
        of_arena = {name: value for name, value in settings.items() if name not in STREAMS}
        config = ArenaConfig().replace(**quiet | of_arena, control="full", faults=faults, dropout_rate=dropout_rate)
        config = config.replace(observed_targets=config.max_targets)
        if self.match is None or self.match.config != config:
            self.match = self.make(config)
        self.match.reset(seed)
        self.is_observed = False

    def place(self, hunters: Sequence[tuple[float, float, float]], targets: Sequence[tuple[float, float]]) -> None:
        self.match.place(hunters, targets)
        self.is_observed = False

    def withdraw(self, seat: int) -> None:
        self.match.withdraw(seat)
        self.is_observed = False

    def withdraw_prey(self, index: int) -> None:
        self.match.withdraw_prey(index)
        self.is_observed = False

    def step(
        self,
        requests: Sequence[tuple[int, int]],
        drive: Mapping[int, tuple[float, float]],
        prey: Mapping[int, tuple[float, float]] | None = None,
    ) -> list[object]:
        config, ranks = self.match.config, dict(requests)
        actions = []
        for seat in range(config.hunters):
            v, w = drive.get(seat, (0.0, 0.0))
            rank = self.rank(seat, ranks[seat]) if seat in ranks else 0
            actions.append(((v / config.max_speeds[seat], w / config.max_turn_rates[seat]), rank))
        try:
            self.match.step(*actions, prey=self.commands(prey or {}))
        except RuntimeError:  # some adjudicators refuse to step after the end
            return [(Verdict.MATCH_OVER, seat, number) for seat, number in requests]
        self.is_observed = True
        found = self.match.evidence()
        assert {seat for seat, one in enumerate(found) if one is not None} <= ranks.keys()
        rulings: list[object] = []
        for seat, number in requests:
            one = found[seat]
            if one is not None:
                rulings.append((one.verdict, seat, one.number or 0, one.distance_um, one.winner))
            elif self.match.hunter(seat).withdrawn:  # the parallel env takes no actions of one that has left
                rulings.append((Verdict.HUNTER_INACTIVE, seat, number))
        return rulings

    def commands(self, prey: Mapping[int, tuple[float, float]]) -> list[tuple[float, float]]:
        """Prey's velocities as its actions."""
        config = self.match.config
        velocities = [prey.get(index, (0.0, 0.0)) for index in range(config.prey)]
        return [(v / config.target_speed_mps, w / config.target_turn_rate_radps) for v, w in velocities]

    def rank(self, seat: int, number: int) -> int:
        """R7.1, R7.5: the rank at which a seat sees that number; for what it does not see the first without a target.

        Worked out by the oracle: what was placed is not observed before the next step.
        """
        me, viewer = self.match.hunter(seat), OracleArena(self.match.config.to_dict())
        viewer.alive = [Target(int(one.number), one.x, one.y, one.theta, 0) for one in self.match.targets]
        numbers = [target.number for target in viewer._targets_in_view(Hunter(seat, me.x, me.y, me.theta))]
        return numbers.index(number) + 1 if number in numbers else len(numbers) + 1

    def seen(self, seat: int) -> list[int]:
        """R7.1: the numbers that a seat observes, by rank."""
        return self.found(seat, groups(self.match.config)[1], {int(one.number): one for one in self.match.targets})

    def rivals_seen(self, seat: int) -> list[int]:
        """R7.1: the seats of the rivals that a seat observes, by rank."""
        others = {other: self.match.hunter(other) for other in range(self.match.config.hunters) if other != seat}
        return self.found(seat, groups(self.match.config)[2], others)

    def found(self, seat: int, group: Group, things: Mapping[int, Any]) -> list[int]:
        """Which things, by label, the ranks of one kind in a seat's observation show: what stands just there."""
        me = self.match.hunter(seat)
        if me.withdrawn:
            return []
        observation = self.match.observation(seat)
        hunter, left_over, labels = Hunter(seat, me.x, me.y, me.theta), dict(things), []
        for at in range(group.first, group.end, len(group.table._fields)):
            if observation[at + 2]:
                shown = observation[at : at + 2]
                label = min(
                    left_over,
                    key=lambda one: math.dist(shown, in_own_frame(hunter, left_over[one].x, left_over[one].y)),
                )
                assert math.dist(shown, in_own_frame(hunter, left_over[label].x, left_over[label].y)) < 1e-5
                labels.append(label)
                del left_over[label]
        return labels

    def read(self) -> dict[str, object]:
        match = self.match
        seats = range(match.config.hunters)
        assert not (match.terminated and match.truncated)
        return {
            "time_ms": match.time,
            "alive": match.alive,
            "appeared_ms": [target.appeared for target in match.targets],
            "spawned": match.spawned,
            "skipped_full": match.skipped_full,
            "skipped_down": match.skipped_down,
            "refused": match.refused,
            "scores": match.scores,
            "team_scores": match.team_scores,
            "prey": [prey.number for prey in match.prey],
            "times_caught": [prey.times_caught for prey in match.prey],
            "ended": "terminated" if match.terminated else "truncated" if match.truncated else "",
            "seen": [self.seen(seat) for seat in seats] if self.is_observed else [],
            "rivals_seen": [self.rivals_seen(seat) for seat in seats] if self.is_observed else [],
        }


class OracleUnderTest(AdjudicatorUnderTest):
    """The oracle with another class of arena in it: a wrong one."""

    def __init__(self, arena: type) -> None:
        super().__init__("oracle")
        self.arena = arena

    def make(self, config: ArenaConfig) -> Adjudicator:
        made = OracleAdjudicator(config)
        made.oracle = self.arena(config.to_dict())
        return made


STREAMS = {
    "kill_down": lambda seed: {step: fraction(draw(key(seed, KILL_DOWN), step)) for step in STEPS},
    "kill_refused": lambda seed: {
        (step, number): fraction(draw(draw(key(seed, KILL_REFUSED), step), number))
        for step in STEPS
        for number in COUNTED
    },
    "spawn_down": lambda seed: {firing: fraction(draw(key(seed, SPAWN_DOWN), firing)) for firing in COUNTED},
    "drop_outs": lambda seed: {
        (step, seat): fraction(draw(draw(key(seed, DROPOUT), step), seat)) for step in STEPS for seat in range(3)
    },
    "spawn_refused": lambda seed: {number: fraction(draw(key(seed, SPAWN_REFUSED), number)) for number in COUNTED},
}
"""R8.3's random numbers, and R1.7's, from the appendix: a fault happens where its number lies below its rate."""


def arranged(wanted: Mapping[str, Collection[Any]]) -> tuple[int, dict[str, float]]:
    """The first seed, and rates, under which exactly those faults happen: in the first steps, firings and numbers."""
    events = {fault: {tuple(one) if isinstance(one, list) else one for one in wanted[fault]} for fault in STREAMS}
    for seed in itertools.count(1):
        rates = {}
        for fault, happen in events.items():
            numbers = STREAMS[fault](seed) if happen else {}
            assert happen <= numbers.keys(), "beyond what is arranged"
            low = max((numbers[one] for one in happen), default=0.0)
            high = min((number for one, number in numbers.items() if one not in happen), default=1.0)
            if low >= high:
                break
            rates[fault] = (low + high) / 2 if happen else 0.0
        else:
            return seed, rates
    raise AssertionError

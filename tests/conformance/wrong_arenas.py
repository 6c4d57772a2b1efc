"""The oracle's arena with one mistake each: about time, spawning, identity, outages and withdrawals, targets that move,
what is seen, and dropouts.
"""

# ruff: noqa: ARG002 - a mistake can consist in not looking at something

import math
from collections.abc import Sequence
from typing import Any

from oracle.arbiter import GRANTED, KILL_FAILED, LOST_CONTEST, Request
from oracle.arena import Command, OracleArena
from oracle.turtles import Hunter, Target, distance, micrometres


class CutsThePeriodOff(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        frequency = settings["spawn_frequency_hz"]
        self.spawn_period = max(1, int(1000 / frequency)) if frequency > 0 else 5000


class RoundsHalvesToEven(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        frequency = settings["spawn_frequency_hz"]
        self.spawn_period = max(1, round(1000 / frequency)) if frequency > 0 else 5000


class NeverFiresWithoutAFrequency(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        if settings["spawn_frequency_hz"] <= 0:
            self.spawn_period = 10**9


class FiresOnceAStep(OracleArena):
    def _spawn(self) -> None:
        period, self.period = self.period, min(self.period, self.spawn_period)
        super()._spawn()
        self.period = period


class FiresAtReset(OracleArena):
    def reset(self, seed: int) -> None:
        super().reset(seed)
        self.used += 1
        self._appear(self.used, 0)


class IgnoresItsRoom(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "max_targets": 64})


class UsesNumbersUpWhenFull(OracleArena):
    def _spawn(self) -> None:
        before = self.skipped_full
        super()._spawn()
        self.used += self.skipped_full - before


class UsesNumbersUpWhenDown(OracleArena):
    def _spawn(self) -> None:
        before = self.skipped_down
        super()._spawn()
        self.used += self.skipped_down - before


class NumbersByTheHighestAlive(OracleArena):
    def _appear(self, number: int, when: int) -> None:
        self.used = max((target.number for target in self.alive), default=0) + 1
        super()._appear(self.used, when)


class KeepsNumbersOverAReset(OracleArena):
    def reset(self, seed: int) -> None:
        used = getattr(self, "used", 0)
        super().reset(seed)
        for target in self.alive:
            target.number += used


class MovesTheLastIntoTheGap(OracleArena):
    """A table that fills the gap of a caught target with its last row."""

    def _commit(self, requests: Sequence[Request | None]) -> None:
        before = list(self.alive)
        super()._commit(requests)
        kept = {target.number for target in self.alive}
        self.alive = self.swapped(before, kept)

    def swapped(self, rows: list[Target], kept: set[int]) -> list[Target]:
        place = 0
        while place < len(rows):
            if rows[place].number in kept:
                place += 1
            elif place == len(rows) - 1:
                rows.pop()
            else:
                rows[place] = rows.pop()
        return rows


class JudgesAfterTheMotion(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        self._move()
        super()._judge(requests)


class SkipsTheLastStep(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        for request in requests:
            if request is not None and self.time + self.period >= self.limit:
                request.verdict = 1


class EndsBeforeItsLimit(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        self.limit = self.limit // self.period * self.period


class TruncatesWhatIsDone(OracleArena):
    def step(self, actions: Sequence[Any], prey_actions: Sequence[Command] = ()) -> None:
        super().step(actions, prey_actions)
        if self.terminated and self.time >= self.limit:
            self.terminated, self.truncated = False, True


class EndsWhenEmpty(OracleArena):
    def step(self, actions: Sequence[Any], prey_actions: Sequence[Command] = ()) -> None:
        super().step(actions, prey_actions)
        self.terminated = self.terminated or (self.budget is not None and not self.alive and self.spawned > 0)


class CreditsRefusedKills(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        for request in requests:
            if request is not None and request.verdict == KILL_FAILED:
                request.verdict = GRANTED
        super()._commit(requests)


class RemovesRefusedTargets(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        failed = {request.number for request in requests if request is not None and request.verdict == KILL_FAILED}
        self.alive = [target for target in self.alive if target.number not in failed]


class WithdrawsForOneStep(OracleArena):
    def step(self, actions: Sequence[Any], prey_actions: Sequence[Command] = ()) -> None:
        super().step(actions, prey_actions)
        for hunter in self.hunters:
            hunter.withdrawn = False


class ForfeitsTheScore(OracleArena):
    def withdraw(self, seat: int) -> None:
        super().withdraw(seat)
        self.hunters[seat].score = 0


class CreditsOneHunterOnly(OracleArena):
    """capstone: the second success for one turtle is not counted."""

    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        self.hunters[1:] = [self.without_score(hunter) for hunter in self.hunters[1:]]

    def without_score(self, hunter: Hunter) -> Hunter:
        hunter.score = 0
        return hunter


class MeasuresInMillimetres(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        self.reaches_um = [math.ceil(reach / 1000) * 1000 + 1 for reach in self.reaches_um]


class JudgesFromWhereTargetsWillBe(OracleArena):
    """Targets move before the requests are judged."""

    def _judge(self, requests: Sequence[Request | None]) -> None:
        for target in self.alive:
            self._drive(target, (self.time + self.period) // 16 - self.time // 16)
        super()._judge(requests)


class WandersAtOneSpeed(OracleArena):
    def _wander(self, target: Target, speed: float) -> None:
        super()._wander(target, self.settings["target_speed_mps"])


class AlarmInclusive(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "alarm_m": settings["alarm_m"] + 1e-6})


class FleesFromTheFirst(OracleArena):
    def _threat(self, target: Target) -> Hunter | None:
        found = super()._threat(target)
        near = [hunter for hunter in self.hunters if not hunter.withdrawn]
        return near[0] if found is not None else None


class FleesFromTheWithdrawn(OracleArena):
    def _threat(self, target: Target) -> Hunter | None:
        withdrawn = [hunter for hunter in self.hunters if hunter.withdrawn]
        for hunter in withdrawn:
            hunter.withdrawn = False
        found = super()._threat(target)
        for hunter in withdrawn:
            hunter.withdrawn = True
        return found


class FleesFromAllThatAreEquallyNear(OracleArena):
    """From their mean place."""

    def _flee(self, target: Target, threat: Hunter) -> None:
        def away(hunter: Hunter) -> int:
            return micrometres(distance(target.x, target.y, hunter.x, hunter.y))

        tied = [hunter for hunter in self.hunters if not hunter.withdrawn and away(hunter) == away(threat)]
        x, y = (math.fsum(getattr(hunter, axis) for hunter in tied) / len(tied) for axis in "xy")
        super()._flee(target, Hunter(threat.seat, x, y, 0.0))


class StopsBetweenTwoThreats(OracleArena):
    def _flee(self, target: Target, threat: Hunter) -> None:
        super()._flee(target, threat)
        least = distance(target.x, target.y, threat.x, threat.y)
        if sum(distance(target.x, target.y, hunter.x, hunter.y) == least for hunter in self.hunters) > 1:
            target.v = 0.0


class FreezesUnderAHunter(OracleArena):
    def _flee(self, target: Target, threat: Hunter) -> None:
        super()._flee(target, threat)
        if (target.x, target.y) == (threat.x, threat.y):
            target.v = 0.0


class KnowsNoWalls(OracleArena):
    def _push(self, c: float) -> float:
        return 0.0


class FearsWallsFromAfar(OracleArena):
    """The last two metres push."""

    def _push(self, c: float) -> float:
        return 2.0 - c if c < 2.0 else (self.side - 2.0) - c if c > self.side - 2.0 else 0.0


class ForgetsTheWall(OracleArena):
    def _wander(self, target: Target, speed: float) -> None:
        target.at_wall = False
        super()._wander(target, speed)


class TurnsFromTheWallBeforeItFlees(OracleArena):
    def _flee(self, target: Target, threat: Hunter) -> None:
        super()._flee(target, threat)
        if target.at_wall:
            self._wander(target, target.v)


class TargetsHaveAWatchdog(OracleArena):
    def _drive(self, turtle: Any, ticks: int) -> None:
        super()._drive(turtle, min(ticks, 62))


class StrollsWhereNobodyIsFledFrom(OracleArena):
    """Wanders at half the speed under `wander` too."""

    def _wander(self, target: Target, speed: float) -> None:
        super()._wander(target, min(speed, self.settings["target_speed_mps"] / 2.0))


class RefusedTargetsStandStill(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        asked_for = {request.number for request in requests if request is not None}
        for target in self.alive:
            target.v = 0.0 if target.number in asked_for else target.v


class ChoosesAtEveryTick(OracleArena):
    def _move(self) -> None:
        period, begin = self.period, self.time
        for tick in range(begin // 16 + 1, (begin + period) // 16 + 1):
            self.time, self.period = 16 * (tick - 1), 16
            for target in self.alive if self.targets_move else []:
                self._choose(target)
            super()._move()
        self.time, self.period = begin, period


class MovesStillTargets(OracleArena):
    def _move(self) -> None:
        super()._move()
        if not self.targets_move:
            for target in self.alive:
                target.x += 0.01


class MovesWhatHasJustAppeared(OracleArena):
    def _spawn(self) -> None:
        before = {target.number for target in self.alive}
        super()._spawn()
        for target in self.alive:
            if target.number not in before:
                self._choose(target)
                self._drive(target, (self.time + self.period) // 16 - target.appeared // 16)


class StartsALateStepLater(OracleArena):
    """What has appeared stands still for a whole step more."""

    def _choose(self, target: Target) -> None:
        super()._choose(target)
        if 0 < self.time - target.appeared < self.period or self.time == target.appeared > 0:
            target.v = 0.0


class RadiusInclusive(OracleArena):
    def __init__(self, settings: Any) -> None:
        radius = settings["view_radius_m"]
        super().__init__({**settings, "view_radius_m": radius and radius + 1e-6})


class LooksTwiceAsWide(OracleArena):
    """The angle to either side."""

    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "view_angle_deg": min(360.0, 2 * settings["view_angle_deg"])})


class LooksAllRound(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "view_angle_deg": 360.0})


class LooksAheadAtMost(OracleArena):
    """No cone is wider than 180 degrees."""

    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "view_angle_deg": min(180.0, settings["view_angle_deg"])})


class DoesNotFeelWhatItReaches(OracleArena):
    def _sees(self, hunter: Hunter, other: Any) -> bool:
        reaches, self.reaches_um = self.reaches_um, [0] * len(self.hunters)
        seen = super()._sees(hunter, other)
        self.reaches_um = reaches
        return seen


class FeelsAsFarAsTheFirst(OracleArena):
    def _sees(self, hunter: Hunter, other: Any) -> bool:
        reaches, self.reaches_um = self.reaches_um, [self.reaches_um[0]] * len(self.hunters)
        seen = super()._sees(hunter, other)
        self.reaches_um = reaches
        return seen


class FeelsTheEdgeOfItsReach(OracleArena):
    def _sees(self, hunter: Hunter, other: Any) -> bool:
        um = micrometres(distance(hunter.x, hunter.y, other.x, other.y))
        return super()._sees(hunter, other) or um == self.reaches_um[hunter.seat]


class SeesAllRivals(OracleArena):
    def _sees(self, hunter: Hunter, other: Any) -> bool:
        return isinstance(other, Hunter) or super()._sees(hunter, other)


class SeesTheWithdrawn(OracleArena):
    def _rivals(self, hunter: Hunter) -> list[tuple[float, ...]]:
        withdrawn = [other.withdrawn for other in self.hunters]
        for other in self.hunters:
            other.withdrawn = False
        rows = super()._rivals(hunter)
        for other, was in zip(self.hunters, withdrawn, strict=True):
            other.withdrawn = was
        return rows


class SeesWhatItSawBefore(OracleArena):
    """The view goes by the heading at the beginning of the step."""

    def _move(self) -> None:
        self.headings = [hunter.theta for hunter in self.hunters]
        super()._move()

    def _sees(self, hunter: Hunter, other: Any) -> bool:
        theta = hunter.theta
        hunter.theta = getattr(self, "headings", [theta] * 64)[hunter.seat]
        seen = super()._sees(hunter, other)
        hunter.theta = theta
        return seen


class WhoIsUnseenCannotWin(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        for request in requests:
            if request is not None and request.verdict == LOST_CONTEST and request.winner is not None:
                me, winner = self.hunters[request.seat], self.hunters[request.winner]
                request.verdict = request.verdict if self._sees(me, winner) else GRANTED


class DropsOutAfterTheRulings(OracleArena):
    def _drop_out(self) -> None:
        pass

    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        super()._drop_out()


class DropsOutForOneStep(OracleArena):
    def step(self, actions: Sequence[Any], prey_actions: Sequence[Command] = ()) -> None:
        before = [hunter.withdrawn for hunter in self.hunters]
        super().step(actions, prey_actions)
        for hunter, was in zip(self.hunters, before, strict=True):
            hunter.withdrawn = was


class DropoutsForfeit(OracleArena):
    def _drop_out(self) -> None:
        before = [hunter.withdrawn for hunter in self.hunters]
        super()._drop_out()
        for hunter, was in zip(self.hunters, before, strict=True):
            hunter.score = hunter.score if hunter.withdrawn == was else 0


class DropoutsEndTheMatch(OracleArena):
    def step(self, actions: Sequence[Any], prey_actions: Sequence[Command] = ()) -> None:
        super().step(actions, prey_actions)
        self.terminated = self.terminated or any(hunter.withdrawn for hunter in self.hunters)
        self.truncated = self.truncated and not self.terminated


WRONG: Sequence[tuple[type[OracleArena], str]] = (
    (CutsThePeriodOff, "spawning"),
    (RoundsHalvesToEven, "spawning"),
    (NeverFiresWithoutAFrequency, "spawning"),
    (FiresOnceAStep, "spawning"),
    (FiresAtReset, "spawning"),
    (IgnoresItsRoom, "spawning"),
    (UsesNumbersUpWhenFull, "spawning"),
    (UsesNumbersUpWhenDown, "spawning"),
    (NumbersByTheHighestAlive, "identity"),
    (KeepsNumbersOverAReset, "identity"),
    (MovesTheLastIntoTheGap, "identity"),
    (JudgesAfterTheMotion, "time"),
    (SkipsTheLastStep, "time"),
    (EndsBeforeItsLimit, "time"),
    (TruncatesWhatIsDone, "time"),
    (EndsWhenEmpty, "time"),
    (CreditsRefusedKills, "outages"),
    (RemovesRefusedTargets, "outages"),
    (WithdrawsForOneStep, "inactive"),
    (ForfeitsTheScore, "inactive"),
    (CreditsOneHunterOnly, "capstone"),
    (MeasuresInMillimetres, "reach"),
    (JudgesFromWhereTargetsWillBe, "moving"),
    (WandersAtOneSpeed, "moving"),
    (AlarmInclusive, "moving"),
    (FleesFromTheFirst, "moving"),
    (FleesFromTheWithdrawn, "moving"),
    (FleesFromAllThatAreEquallyNear, "moving"),
    (StopsBetweenTwoThreats, "moving"),
    (FreezesUnderAHunter, "moving"),
    (KnowsNoWalls, "moving"),
    (FearsWallsFromAfar, "moving"),
    (ForgetsTheWall, "moving"),
    (TurnsFromTheWallBeforeItFlees, "moving"),
    (TargetsHaveAWatchdog, "moving"),
    (StrollsWhereNobodyIsFledFrom, "moving"),
    (RefusedTargetsStandStill, "moving"),
    (ChoosesAtEveryTick, "moving"),
    (MovesStillTargets, "moving"),
    (MovesWhatHasJustAppeared, "moving"),
    (StartsALateStepLater, "moving"),
    (RadiusInclusive, "view"),
    (LooksTwiceAsWide, "view"),
    (LooksAllRound, "view"),
    (LooksAheadAtMost, "view"),
    (DoesNotFeelWhatItReaches, "view"),
    (FeelsAsFarAsTheFirst, "view"),
    (FeelsTheEdgeOfItsReach, "view"),
    (SeesAllRivals, "view"),
    (SeesTheWithdrawn, "view"),
    (SeesWhatItSawBefore, "view"),
    (WhoIsUnseenCannotWin, "view"),
    (DropsOutAfterTheRulings, "dropouts"),
    (DropsOutForOneStep, "dropouts"),
    (DropoutsForfeit, "dropouts"),
    (DropoutsEndTheMatch, "dropouts"),
    (FleesFromTheWithdrawn, "dropouts"),
    (SeesTheWithdrawn, "dropouts"),
)
"""Each wrong arena, and the group of cases that must catch it."""

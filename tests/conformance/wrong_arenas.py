"""The oracle's arena with one mistake each: about time, spawning, identity, outages and withdrawals."""

# ruff: noqa: ARG002 - a mistake can consist in not looking at something

import math
from collections.abc import Sequence
from typing import Any

from oracle.arena import GRANTED, KILL_FAILED, Hunter, OracleArena, Request, Target


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
    def step(self, actions: Sequence[Any]) -> None:
        super().step(actions)
        if self.terminated and self.time >= self.limit:
            self.terminated, self.truncated = False, True


class EndsWhenEmpty(OracleArena):
    def step(self, actions: Sequence[Any]) -> None:
        super().step(actions)
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
    def step(self, actions: Sequence[Any]) -> None:
        super().step(actions)
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


WRONG: Sequence[tuple[type[OracleArena], str, str]] = (
    (CutsThePeriodOff, "spawning", "targets appear at other times"),
    (RoundsHalvesToEven, "spawning", "targets appear at other times"),
    (NeverFiresWithoutAFrequency, "spawning", "targets do not appear"),
    (FiresOnceAStep, "spawning", "targets do not appear"),
    (FiresAtReset, "spawning", "too many targets are alive"),
    (IgnoresItsRoom, "spawning", "too many targets are alive"),
    (UsesNumbersUpWhenFull, "spawning", "spawn numbers are left out"),
    (UsesNumbersUpWhenDown, "spawning", "spawn numbers are left out"),
    (NumbersByTheHighestAlive, "identity", "spawn numbers are used again"),
    (KeepsNumbersOverAReset, "identity", "spawn numbers are left out"),
    (MovesTheLastIntoTheGap, "identity", "the alive targets change their order"),
    (JudgesAfterTheMotion, "time", "GRANTED where OUT_OF_REACH is right (R1.4)"),
    (SkipsTheLastStep, "time", "MATCH_OVER where GRANTED is right (R1.5)"),
    (EndsBeforeItsLimit, "time", "the match ends at another time, or in another way"),
    (TruncatesWhatIsDone, "time", "the match ends at another time, or in another way"),
    (EndsWhenEmpty, "time", "the match ends at another time, or in another way"),
    (CreditsRefusedKills, "outages", "a refused kill is GRANTED"),
    (RemovesRefusedTargets, "outages", "a target leaves although its kill was refused"),
    (WithdrawsForOneStep, "inactive", "GRANTED where HUNTER_INACTIVE is right (R1.6)"),
    (ForfeitsTheScore, "inactive", "a catch is not credited"),
    (CreditsOneHunterOnly, "capstone", "a catch is not credited"),
    (MeasuresInMillimetres, "reach", "within reach is tested with <="),
)
"""Each wrong arena, the group of cases that must catch it, and what it must be told."""

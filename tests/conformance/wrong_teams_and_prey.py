"""The oracle's arena with one mistake each: about teams, prey, and a spawn timer that is off."""

from collections.abc import Sequence
from typing import Any

from oracle.arbiter import GRANTED, KILL_FAILED, LOST_CONTEST, OUT_OF_REACH, Request
from oracle.arena import Command, OracleArena
from oracle.arithmetic import SPAWN_REFUSED, draw, fraction, key
from oracle.turtles import Prey, Target


class IgnoresThatTheTimerIsOff(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "spawning": True})


class SkipsFiringsOfATimerThatIsOff(OracleArena):
    def _spawn(self) -> None:
        super()._spawn()
        if not self.settings["spawning"]:
            self.skipped_full += (self.time + self.period) // self.spawn_period - self.time // self.spawn_period


class EndsByItsBudgetAlone(OracleArena):
    def _is_done(self) -> bool:
        return self.budget is not None and super()._is_done()


class MatesShareACatch(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        for request in requests:
            if (
                request is not None
                and request.verdict == LOST_CONTEST
                and request.winner in self._team_of(request.seat)
            ):
                request.verdict, request.winner = GRANTED, request.seat


class TheLargerTeamWins(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        contest = [one for one in requests if one is not None and one.verdict in (GRANTED, LOST_CONTEST)]
        for one in contest:
            mates = [other for other in contest if other.seat in self._team_of(one.seat)]
            if len({other.number for other in contest}) == 1 and len(mates) > 1 and one is mates[0]:
                for other in contest:
                    other.verdict, other.winner = LOST_CONTEST, one.seat
                one.verdict = GRANTED


class NamesTheTeamsFirstSeatAsWinner(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        for request in requests:
            if request is not None and request.verdict == LOST_CONTEST and request.winner is not None:
                request.winner = self._team_of(request.winner)[0]


class GrantsATeamOneCatchAStep(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        served: set[int] = set()
        for request in requests:
            if request is not None and request.verdict == GRANTED:
                if request.seat in served:
                    request.verdict = LOST_CONTEST
                served.update(self._team_of(request.seat))


class ReachesAsFarAsAnyMate(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        for request in requests:
            for other in requests:
                if request is None or other is None or request.verdict != OUT_OF_REACH or other.verdict != GRANTED:
                    continue
                if other.number == request.number and other.seat in self._team_of(request.seat):
                    request.verdict, request.winner = LOST_CONTEST, other.seat


class ForgetsWhoHasLeft(OracleArena):
    def team_scores(self) -> list[int]:
        score = [0 if hunter.withdrawn else hunter.score for hunter in self.hunters]
        return [sum(score[seat] for seat in team) for team in self.teams or ()]


class TakesTeamsForNeighbours(OracleArena):
    def team_scores(self) -> list[int]:
        scores, found = [hunter.score for hunter in self.hunters], []
        for team in self.teams or ():
            found.append(sum(scores[: len(team)]))
            scores = scores[len(team) :]
        return found


class PreyDodges(OracleArena):
    """It moves before the requests are judged."""

    def _judge(self, requests: Sequence[Request | None]) -> None:
        for prey in self.prey:
            if prey.target is not None:
                self._drive(prey.target, (self.time + self.period) // 16 - self.time // 16)
        super()._judge(requests)


class PreyIsDeaf(OracleArena):
    def _command(self, prey: Prey, action: Command) -> None:
        pass


class PreyReverses(OracleArena):
    def _command(self, prey: Prey, action: Command) -> None:
        super()._command(prey, action)
        if prey.target is not None and action[0] < 0:
            prey.target.v = action[0] * self.target_speed


class PreyFlees(OracleArena):
    def _command(self, prey: Prey, action: Command) -> None:
        super()._command(prey, action)
        if prey.target is not None and self.settings["target_motion"] == "flee":
            self._choose(prey.target)


class OnlyPreyMoves(OracleArena):
    def _choose(self, target: Target) -> None:
        if not self.prey:
            super()._choose(target)


class AllMoveWherePreyDoes(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        for target in self.alive:
            if self.prey and self.settings["target_motion"] == "still" and not self._is_played(target):
                self._wander(target, self.target_speed)
        super()._judge(requests)


class AnyCatchIsPreys(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        for prey in self.prey:
            if prey.target is not None and any(one is not None and one.verdict == GRANTED for one in requests):
                self.alive.remove(prey.target)
                prey.target, prey.caught_at = None, self.time
                prey.times_caught += 1
                self.caught_by[prey.index] = 0


class EveryTargetReturns(OracleArena):
    def reset(self, seed: int) -> None:
        super().reset(seed)
        self.due: list[float] = []

    def _commit(self, requests: Sequence[Request | None]) -> None:
        before = [target for target in self.alive if not self._is_played(target)]
        super()._commit(requests)
        lost = [target for target in before if target not in self.alive]
        self.due += [self.time + 1000 * self.settings["prey_returns_s"] for _ in lost]

    def _return_prey(self) -> None:
        super()._return_prey()
        for due in list(self.due):
            if self.time + self.period >= due:
                self.due.remove(due)
                self.used += 1
                self._appear(self.used, self.time + self.period)


class PreyIsNoCatch(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        for seat in self.caught_by:
            if seat is not None:
                self.hunters[seat].score -= 1


class RefusedKillsCount(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        failed = {one.number for one in requests if one is not None and one.verdict == KILL_FAILED}
        for prey in self.prey:
            if prey.target is not None and prey.target.number in failed:
                prey.times_caught += 1


class CountsFromTheStepsEnd(OracleArena):
    def _return_prey(self) -> None:
        self.period -= 100
        super()._return_prey()
        self.period += 100


class ReturnsAStepEarly(OracleArena):
    """At the last boundary before its time is up."""

    def __init__(self, settings: Any) -> None:
        away = settings["prey_returns_s"]
        super().__init__({**settings, "prey_returns_s": None if away is None else max(0.0, away - 0.099)})


class StaysOutForAStepAtLeast(OracleArena):
    def _return_prey(self) -> None:
        caught_now = [prey for prey in self.prey if prey.caught_at == self.time]
        for prey in caught_now:
            prey.caught_at = None
        super()._return_prey()
        for prey in caught_now:
            prey.caught_at = self.time


class ReturnsWhoWaitedLongest(OracleArena):
    def _return_prey(self) -> None:
        by_index = self.prey
        self.prey = sorted(by_index, key=lambda prey: prey.caught_at or 0)
        super()._return_prey()
        self.prey = by_index


class ReturnsInTheOrderOfItsCatchers(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        self.catchers: dict[int, int] = getattr(self, "catchers", {}) | {
            index: seat for index, seat in enumerate(self.caught_by) if seat is not None
        }

    def _return_prey(self) -> None:
        by_index = self.prey
        self.prey = sorted(by_index, key=lambda prey: self.catchers.get(prey.index, 0))
        super()._return_prey()
        self.prey = by_index


class ReturnsIntoAFullArena(OracleArena):
    def _return_prey(self) -> None:
        room = self.settings["max_targets"]
        self.settings["max_targets"] = 10**9
        super()._return_prey()
        self.settings["max_targets"] = room


class GivesUpWhereThereIsNoRoom(OracleArena):
    def _return_prey(self) -> None:
        super()._return_prey()
        for prey in self.prey:
            if prey.caught_at is not None and self.time + self.period >= prey.caught_at + self.away_ms():
                prey.caught_at = 10**9

    def away_ms(self) -> float:
        away: float | None = self.settings["prey_returns_s"]
        return 1e9 if away is None else 1000 * away


class WaitingIsSkipping(GivesUpWhereThereIsNoRoom):
    def _return_prey(self) -> None:
        OracleArena._return_prey(self)
        for prey in self.prey:
            if prey.caught_at is not None and self.time + self.period >= prey.caught_at + self.away_ms():
                self.skipped_full += 1


class WaitingUsesNumbersUp(GivesUpWhereThereIsNoRoom):
    def _return_prey(self) -> None:
        OracleArena._return_prey(self)
        for prey in self.prey:
            if prey.caught_at is not None and self.time + self.period >= prey.caught_at + self.away_ms():
                self.used += 1


class ReturnsBeforeTheFirings(OracleArena):
    def _spawn(self) -> None:
        self._return_prey()
        super()._spawn()


class ReturnsUnderItsNumber(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        numbers = [prey.target.number if prey.target is not None else 0 for prey in self.prey]
        super()._commit(requests)
        self.numbers_of = {index: number for index, number in enumerate(numbers) if number} | getattr(
            self, "numbers_of", {}
        )

    def _return_prey(self) -> None:
        out = [prey for prey in self.prey if prey.target is None]
        super()._return_prey()
        for prey in out:
            if prey.target is not None:
                prey.target.number = self.numbers_of[prey.index]


class ReturnsAsAFiring(OracleArena):
    """Numbers that the simulator refuses are refused to prey too."""

    def _return_prey(self) -> None:
        rate = self.settings["faults"]["spawn_refused"]
        if fraction(draw(key(self.seed, SPAWN_REFUSED), self.used + 1)) < rate:
            self.refused += 1
            self.used += 1
            return
        super()._return_prey()


class ReturnsAreNotSpawned(OracleArena):
    def _return_prey(self) -> None:
        before = self.spawned
        super()._return_prey()
        self.spawned = before


class CountsTheFirstCatchAlone(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        for prey in self.prey:
            prey.times_caught = min(prey.times_caught, 1)


class WithdrawnPreyIsGone(OracleArena):
    def withdraw_prey(self, index: int) -> None:
        super().withdraw_prey(index)
        target = self.prey[index].target
        self.alive = [one for one in self.alive if one is not target]
        self.prey[index].target = None


class WithdrawnPreyDrivesOn(OracleArena):
    def withdraw_prey(self, index: int) -> None:
        pass


class WithdrawnPreyStaysOut(OracleArena):
    def _return_prey(self) -> None:
        everybody = self.prey
        self.prey = [prey for prey in everybody if not prey.withdrawn]
        super()._return_prey()
        self.prey = everybody


class WithdrawnPreyIsNotCounted(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        before = [prey.times_caught for prey in self.prey]
        super()._commit(requests)
        for prey, count in zip(self.prey, before, strict=True):
            prey.times_caught = count if prey.withdrawn else prey.times_caught


class PreyAlwaysReturns(OracleArena):
    def __init__(self, settings: Any) -> None:
        super().__init__({**settings, "prey_returns_s": 2.0 if settings["prey_returns_s"] is None else 0.3})


class EndsWithItsPrey(OracleArena):
    def _is_done(self) -> bool:
        return self.prey_count > 0 and all(prey.target is None for prey in self.prey)


class EndsForTheOneWhoIsOut(OracleArena):
    def _is_done(self) -> bool:
        return self.settings["prey_returns_s"] is None and any(prey.target is None for prey in self.prey)


class NeverEndsWithPrey(OracleArena):
    def _is_done(self) -> bool:
        return self.prey_count == 0 and super()._is_done()


WRONG_OF_TEAMS_AND_PREY: Sequence[tuple[type[OracleArena], str]] = (
    (IgnoresThatTheTimerIsOff, "spawning"),
    (SkipsFiringsOfATimerThatIsOff, "spawning"),
    (EndsByItsBudgetAlone, "spawning"),
    (MatesShareACatch, "teams"),
    (TheLargerTeamWins, "teams"),
    (NamesTheTeamsFirstSeatAsWinner, "teams"),
    (GrantsATeamOneCatchAStep, "teams"),
    (ReachesAsFarAsAnyMate, "teams"),
    (ForgetsWhoHasLeft, "teams"),
    (TakesTeamsForNeighbours, "teams"),
    (PreyDodges, "prey"),
    (PreyIsDeaf, "prey"),
    (PreyReverses, "prey"),
    (PreyFlees, "prey"),
    (OnlyPreyMoves, "prey"),
    (AllMoveWherePreyDoes, "prey"),
    (AnyCatchIsPreys, "prey"),
    (EveryTargetReturns, "prey"),
    (PreyIsNoCatch, "prey"),
    (RefusedKillsCount, "prey"),
    (CountsFromTheStepsEnd, "prey"),
    (ReturnsAStepEarly, "prey"),
    (StaysOutForAStepAtLeast, "prey"),
    (ReturnsWhoWaitedLongest, "prey"),
    (ReturnsInTheOrderOfItsCatchers, "prey"),
    (ReturnsIntoAFullArena, "prey"),
    (GivesUpWhereThereIsNoRoom, "prey"),
    (WaitingIsSkipping, "prey"),
    (WaitingUsesNumbersUp, "prey"),
    (ReturnsBeforeTheFirings, "prey"),
    (ReturnsUnderItsNumber, "prey"),
    (ReturnsAsAFiring, "prey"),
    (ReturnsAreNotSpawned, "prey"),
    (CountsTheFirstCatchAlone, "prey"),
    (WithdrawnPreyIsGone, "prey"),
    (WithdrawnPreyDrivesOn, "prey"),
    (WithdrawnPreyStaysOut, "prey"),
    (WithdrawnPreyIsNotCounted, "prey"),
    (PreyAlwaysReturns, "prey"),
    (EndsWithItsPrey, "prey"),
    (EndsForTheOneWhoIsOut, "prey"),
    (NeverEndsWithPrey, "prey"),
)
"""Each wrong arena, and the group of cases that must catch it."""

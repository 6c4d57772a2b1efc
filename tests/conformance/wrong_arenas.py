"""The oracle's arena with one mistake each: every group of cases for arenas catches some of them."""

# ruff: noqa: ARG002 - a mistake can consist in not looking at something

from collections.abc import Callable, Sequence
from typing import Any

from oracle.arbiter import GRANTED, KILL_FAILED, LOST_CONTEST, Request
from oracle.arena import Command, OracleArena
from oracle.turtles import Hunter, Prey, Target

Settings = dict[str, Any]


def with_settings(change: Callable[[Settings], Settings]) -> type[OracleArena]:
    """An arena that plays by other settings than those that it is given."""

    class Wrong(OracleArena):
        def __init__(self, settings: Any) -> None:
            super().__init__({**settings, **change(settings)})

    return Wrong


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


class CreditsRefusedKills(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        for request in requests:
            if request is not None and request.verdict == KILL_FAILED:
                request.verdict = GRANTED
        super()._commit(requests)


class WithdrawsForOneStep(OracleArena):
    def step(self, actions: Sequence[Any], prey_actions: Sequence[Command] = ()) -> None:
        super().step(actions, prey_actions)
        for hunter in self.hunters:
            hunter.withdrawn = False


class CreditsOneHunterOnly(OracleArena):
    """capstone: the second success for one turtle is not counted."""

    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        self.hunters[1:] = [self.without_score(hunter) for hunter in self.hunters[1:]]

    def without_score(self, hunter: Hunter) -> Hunter:
        hunter.score = 0
        return hunter


class JudgesFromWhereTargetsWillBe(OracleArena):
    """Targets move before the requests are judged."""

    def _judge(self, requests: Sequence[Request | None]) -> None:
        for target in self.alive:
            self._drive(target, (self.time + self.period) // 16 - self.time // 16)
        super()._judge(requests)


class FleesFromTheFirst(OracleArena):
    def _threat(self, target: Target) -> Hunter | None:
        found = super()._threat(target)
        near = [hunter for hunter in self.hunters if not hunter.withdrawn]
        return near[0] if found is not None else None


class KnowsNoWalls(OracleArena):
    def _push(self, c: float) -> float:
        return 0.0


class ForgetsTheWall(OracleArena):
    def _wander(self, target: Target, speed: float) -> None:
        target.at_wall = False
        super()._wander(target, speed)


class MovesStillTargets(OracleArena):
    def _move(self) -> None:
        super()._move()
        if not self.targets_move:
            for target in self.alive:
                target.x += 0.01


class FeelsAsFarAsTheFirst(OracleArena):
    def _sees(self, hunter: Hunter, other: Any) -> bool:
        reaches, self.reaches_um = self.reaches_um, [self.reaches_um[0]] * len(self.hunters)
        seen = super()._sees(hunter, other)
        self.reaches_um = reaches
        return seen


class SeesAllRivals(OracleArena):
    def _sees(self, hunter: Hunter, other: Any) -> bool:
        return isinstance(other, Hunter) or super()._sees(hunter, other)


class DropsOutAfterTheRulings(OracleArena):
    def _drop_out(self) -> None:
        pass

    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        super()._drop_out()


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


class GrantsATeamOneCatchAStep(OracleArena):
    def _judge(self, requests: Sequence[Request | None]) -> None:
        super()._judge(requests)
        served: set[int] = set()
        for request in requests:
            if request is not None and request.verdict == GRANTED:
                if request.seat in served:
                    request.verdict = LOST_CONTEST
                served.update(self._team_of(request.seat))


class TakesTeamsForNeighbours(OracleArena):
    def team_scores(self) -> list[int]:
        scores, found = [hunter.score for hunter in self.hunters], []
        for team in self.teams or ():
            found.append(sum(scores[: len(team)]))
            scores = scores[len(team) :]
        return found


class PreyIsDeaf(OracleArena):
    def _command(self, prey: Prey, action: Command) -> None:
        pass


class PreyReverses(OracleArena):
    def _command(self, prey: Prey, action: Command) -> None:
        super()._command(prey, action)
        if prey.target is not None and action[0] < 0:
            prey.target.v = action[0] * self.target_speed


class RefusedKillsCount(OracleArena):
    def _commit(self, requests: Sequence[Request | None]) -> None:
        super()._commit(requests)
        failed = {one.number for one in requests if one is not None and one.verdict == KILL_FAILED}
        for prey in self.prey:
            if prey.target is not None and prey.target.number in failed:
                prey.times_caught += 1


class ReturnsIntoAFullArena(OracleArena):
    def _return_prey(self) -> None:
        room = self.settings["max_targets"]
        self.settings["max_targets"] = 10**9
        super()._return_prey()
        self.settings["max_targets"] = room


class ReturnsBeforeTheFirings(OracleArena):
    def _spawn(self) -> None:
        self._return_prey()
        super()._spawn()


class WithdrawnPreyStaysOut(OracleArena):
    def _return_prey(self) -> None:
        everybody = self.prey
        self.prey = [prey for prey in everybody if not prey.withdrawn]
        super()._return_prey()
        self.prey = everybody


class NeverEndsWithPrey(OracleArena):
    def _is_done(self) -> bool:
        return self.prey_count == 0 and super()._is_done()


WRONG: Sequence[tuple[str, type[OracleArena]]] = (
    ("spawning", with_settings(lambda _: {"max_targets": 64})),
    ("spawning", with_settings(lambda _: {"spawning": True})),
    ("time", with_settings(lambda own: {"time_limit_s": own["time_limit_s"] // 0.1 * 0.1})),
    ("reach", with_settings(lambda own: {"reach_m": own["reach_m"] + 1e-6})),
    ("moving", with_settings(lambda own: {"alarm_m": own["alarm_m"] + 1e-6})),
    ("view", with_settings(lambda own: {"view_radius_m": own["view_radius_m"] and own["view_radius_m"] + 1e-6})),
    ("view", with_settings(lambda own: {"view_angle_deg": min(360.0, 2 * own["view_angle_deg"])})),
    ("dropouts", with_settings(lambda _: {"dropout_rate": 0.0})),
    ("prey", with_settings(lambda own: {"prey_returns_s": 2.0 if own["prey_returns_s"] is None else 0.3})),
    ("spawning", UsesNumbersUpWhenFull),
    ("spawning", UsesNumbersUpWhenDown),
    ("identity", NumbersByTheHighestAlive),
    ("identity", KeepsNumbersOverAReset),
    ("time", JudgesAfterTheMotion),
    ("time", SkipsTheLastStep),
    ("outages", CreditsRefusedKills),
    ("inactive", WithdrawsForOneStep),
    ("capstone", CreditsOneHunterOnly),
    ("moving", JudgesFromWhereTargetsWillBe),
    ("moving", FleesFromTheFirst),
    ("moving", KnowsNoWalls),
    ("moving", ForgetsTheWall),
    ("moving", MovesStillTargets),
    ("view", FeelsAsFarAsTheFirst),
    ("view", SeesAllRivals),
    ("dropouts", DropsOutAfterTheRulings),
    ("partners", with_settings(lambda _: {"hunters_per_catch": 1})),
    ("partners", MatesShareACatch),
    ("teams", MatesShareACatch),
    ("teams", GrantsATeamOneCatchAStep),
    ("teams", TakesTeamsForNeighbours),
    ("prey", PreyIsDeaf),
    ("prey", PreyReverses),
    ("prey", RefusedKillsCount),
    ("prey", ReturnsIntoAFullArena),
    ("prey", ReturnsBeforeTheFirings),
    ("prey", WithdrawnPreyStaysOut),
    ("prey", NeverEndsWithPrey),
)
"""A group of cases, and a wrong arena that it must catch."""

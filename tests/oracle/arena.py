"""The oracle: a second arena in plain Python with one object per turtle.

It was written from docs/reference/rulebook.md and its appendix, bit_exact.md, alone.

It shares no code with the package. Where it and the engine differ, the book decides which of them is wrong.
"""

# ruff: noqa: FURB136 - the choices are written as the book writes them: min and max may treat zeros otherwise

import hashlib
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any, Final

from oracle.arbiter import (
    GRANTED,
    HUNTER_INACTIVE,
    LOST_CONTEST,
    MALFORMED,
    OUT_OF_REACH,
    SERVICE_DOWN,
    Request,
    decide_contests,
    refuse_without_partners,
)
from oracle.arithmetic import (
    DROPOUT,
    DT,
    ERROR,
    KILL_DOWN,
    KILL_REFUSED,
    PI,
    PLACE,
    SPAWN_DOWN,
    SPAWN_REFUSED,
    START_TURN,
    TAU,
    THREAT_LOT,
    WANDER,
    atan2,
    clamp,
    draw,
    fraction,
    key,
    sincos,
    to_float32,
    wrap,
)
from oracle.turtles import (
    Hunter,
    Prey,
    Target,
    Turtle,
    by_seat,
    distance,
    in_own_frame,
    micrometres,
    nearness,
    reach_in_micrometres,
    relative_heading,
)

PART_NAMES: Final = ("catch", "rival_catch", "lost_contest", "rejected_request", "progress", "time", "mate_catch")
PREY_PART_NAMES: Final = ("caught", "survived", "gained")

Action = Any
"""An int under target control, (a1, a2) under velocity control, ((a1, a2), rank) under full control."""
Command = tuple[float, float]
"""(a1, a2), prey's action."""
Pose = tuple[float, float, float]
Chase = tuple[tuple[float, float], tuple[float, float] | None]
"""Place of a prey, and the hunter nearest to it."""
RulingTuple = tuple[int, int | None, int | None, int | None]
"""(verdict, target's number, distance in micrometres, winner's seat)."""


class OracleArena:
    """One arena under one set of settings (what ArenaConfig.to_dict gives)."""

    def __init__(self, settings: Mapping[str, Any]) -> None:
        self.settings = dict(settings)
        count = settings["hunters"]
        control = settings["control"]
        self.controls: list[str] = [control] * count if isinstance(control, str) else list(control)
        self.side: float = settings["side_m"]
        seen = settings["observed_targets"]
        self.targets_seen: int = min(8, settings["max_targets"]) if seen is None else seen
        seen = settings["observed_hunters"]
        self.hunters_seen: int = min(count - 1, 7) if seen is None else seen
        self.period: int = settings["control_period_ms"]
        if settings["max_cycles"] is not None:
            self.limit = settings["max_cycles"] * self.period
        else:
            self.limit = max(1, math.floor(1000.0 * settings["time_limit_s"] + 0.5))
        frequency = settings["spawn_frequency_hz"]
        self.spawn_period = max(1, math.floor(1000 / frequency + 0.5)) if frequency > 0 else 5000
        self.reaches_um = [reach_in_micrometres(reach) for reach in by_seat(settings["reach_m"], count)]
        self.v_max = by_seat(settings["max_speed_mps"], count)
        self.v_low = [-v_max if settings["reverse"] else 0.0 for v_max in self.v_max]
        self.w_max = by_seat(settings["max_turn_rate_radps"], count)
        self.teams: Sequence[Sequence[int]] | None = settings["teams"]
        self.prey_count: int = settings["prey"]
        self.target_speed: float = settings["target_speed_mps"]
        self.target_turn_rate: float = settings["target_turn_rate_radps"]
        self.targets_move: bool = settings["target_motion"] != "still" or self.prey_count > 0
        self.policy: str = settings["policy"]
        self.budget: int | None = settings["target_budget"]

    # ---- reset and what stands between steps ----

    def reset(self, seed: int) -> None:
        """A.6: the first state of the episode with that seed."""
        self.seed = seed
        self.time = 0
        self.steps = 0
        self.spawned = 0
        self.used = 0
        self.firings = 0
        self.skipped_full = 0
        self.skipped_down = 0
        self.refused = 0
        self.alive: list[Target] = []
        self.terminated = False
        self.truncated = False
        self.hunters = [Hunter(seat, *pose) for seat, pose in enumerate(self._start_poses())]
        for _ in range(self.settings["initial_targets"]):
            self.used += 1
            self._appear(self.used, 0)
        self.prey = [Prey(index, target) for index, target in enumerate(self.alive[: self.prey_count])]
        self._no_results()

    def _no_results(self) -> None:
        self.rulings: list[RulingTuple | None] = [None] * len(self.hunters)
        self.rewards = [0.0] * len(self.hunters)
        self.parts = [(0.0,) * len(PART_NAMES)] * len(self.hunters)
        self.caught_by: list[int | None] = [None] * self.prey_count
        self.prey_rewards = [0.0] * self.prey_count
        self.prey_parts = [(0.0,) * len(PREY_PART_NAMES)] * self.prey_count

    def _start_poses(self) -> list[tuple[float, float, float]]:
        poses = self.settings["hunter_poses"]
        if poses is not None:
            return [(x, y, wrap(theta)) for x, y, theta in poses]
        count = self.settings["hunters"]
        side = self.side
        if count == 1:
            return [(side / 2.0, side / 2.0, 0.0)]
        radius = self.settings["start_radius_m"]
        if radius is None:
            radius = 0.3 * side
        turn = TAU * fraction(draw(key(self.seed, START_TURN), 0))
        found = []
        for seat in range(count):
            angle = wrap(turn + TAU * seat / count)
            sine, cosine = sincos(angle)
            found.append((side / 2.0 + radius * cosine, side / 2.0 + radius * sine, wrap(angle + PI)))
        return found

    def _appear(self, number: int, when: int) -> Target:
        """R3.2, R3.3: the target with that number appears at its place."""
        stream = key(self.seed, PLACE)
        f_x, f_y, f_theta = (fraction(draw(stream, 3 * (number - 1) + j)) for j in range(3))
        low = 0.5
        high = self.side - (11.088889122009277 - 10.5)
        last = math.nextafter(high, -math.inf)
        x = low + f_x * (high - low)
        x = last if x > last else x
        y = low + f_y * (high - low)
        y = last if y > last else y
        theta = TAU * f_theta
        if self.targets_move:
            theta = wrap(theta)
        target = Target(number, x, y, theta, when)
        self.alive.append(target)
        self.spawned += 1
        return target

    def withdraw(self, seat: int) -> None:
        """R1.6: the hunter takes no further part."""
        hunter = self.hunters[seat]
        hunter.withdrawn = True
        hunter.stand_still()

    def withdraw_prey(self, index: int) -> None:
        """R12.5: it stands still from now on."""
        prey = self.prey[index]
        prey.withdrawn = True
        if prey.target is not None:
            prey.target.v = prey.target.w = 0.0

    def place(
        self,
        hunters: Sequence[Pose],
        targets: Sequence[tuple[float, float]],
        prey: Sequence[Pose] | None = None,
    ) -> None:
        """For tests: hunters at rest at these poses, and these targets, with new numbers, instead of the alive ones
        that nobody plays; and prey that is in play at rest at its pose, by index, where there are any.
        """
        for hunter, (x, y, theta) in zip(self.hunters, hunters, strict=True):
            hunter.x, hunter.y, hunter.theta = x, y, wrap(theta)
            hunter.stand_still()
            hunter.at_wall = False
        for played, pose in zip(self.prey, prey or (), strict=prey is not None):
            target = played.target
            if target is not None:
                target.x, target.y, target.theta = *pose[:2], wrap(pose[2])
                target.v = target.w = 0.0
                target.at_wall = False
        self.alive = [target for target in self.alive if self._is_played(target)]
        for x, y in targets:
            self.used += 1
            self.spawned += 1
            self.alive.append(Target(self.used, x, y, 0.0, self.time))

    # ---- one step ----

    def step(self, actions: Sequence[Action], prey_actions: Sequence[Command] = ()) -> None:
        """R1.4's seven phases, with an action for each seat and each prey."""
        if self.terminated or self.truncated:
            raise RuntimeError("the episode has ended")
        self._drop_out()
        requests = [self._intake(hunter, action) for hunter, action in zip(self.hunters, actions, strict=True)]
        for prey, action in zip(self.prey, prey_actions, strict=True):
            self._command(prey, action)
        if self.settings["target_motion"] != "still":
            for target in self.alive:
                if not self._is_played(target):
                    self._choose(target)
        self._judge(requests)
        chased = self._chased()
        self._commit(requests)
        references = [self._progress_reference(hunter) for hunter in self.hunters]
        before = [
            distance(hunter.x, hunter.y, *reference) if reference is not None else 0.0
            for hunter, reference in zip(self.hunters, references, strict=True)
        ]
        self._move()
        self._spawn()
        self._return_prey()
        self.time += self.period
        self.steps += 1
        self.terminated = self._is_done()
        self.truncated = not self.terminated and self.time >= self.limit
        self._reward(requests, references, before)
        self._reward_prey(chased)

    def _is_done(self) -> bool:
        """R1.5, R12.6: no target is alive, and none will appear."""
        all_spawned = self.budget is not None and self.spawned >= self.budget
        some_return = self.prey_count > 0 and self.settings["prey_returns_s"] is not None
        return not self.alive and (all_spawned or not self.settings["spawning"]) and not some_return

    def _drop_out(self) -> None:
        """R1.7: before phase 1."""
        stream = draw(key(self.seed, DROPOUT), self.steps)
        for hunter in self.hunters:
            if not hunter.withdrawn and fraction(draw(stream, hunter.seat)) < self.settings["dropout_rate"]:
                self.withdraw(hunter.seat)

    def _intake(self, hunter: Hunter, action: Action) -> Request | None:
        """Phases 1 and 2: the hunter's command for this step; its request, if it makes one."""
        control = self.controls[hunter.seat]
        view = self._targets_in_view(hunter)
        command: tuple[float, float] | None = None
        rank = 0
        if control == "target":
            rank = action
        elif control == "velocity":
            command = action
        else:
            command, rank = action
        if rank > len(view):
            hunter.stand_still()
            return Request(hunter.seat, None)
        wanted: Target | None = None
        if control == "velocity":
            wanted = view[0] if view and self._in_reach(hunter, view[0]) else None
        elif rank > 0:
            wanted = view[rank - 1]
        if hunter.withdrawn:
            hunter.stand_still()
        elif control == "target":
            if wanted is None:
                hunter.stand_still()
            else:
                self._steer(hunter, wanted)
        else:
            assert command is not None
            hunter.stand_still()
            hunter.active = wanted.number if wanted is not None and control == "full" else 0
            v_max, w_max = self.v_max[hunter.seat], self.w_max[hunter.seat]
            hunter.v = clamp(to_float32(command[0]) * v_max, self.v_low[hunter.seat], v_max)
            hunter.w = clamp(to_float32(command[1]) * w_max, -w_max, w_max)
        if wanted is None or (control == "target" and not self._in_reach(hunter, wanted)):
            return None
        return Request(hunter.seat, wanted.number)

    def _in_reach(self, hunter: Hunter, target: Target) -> bool:
        return micrometres(distance(hunter.x, hunter.y, target.x, target.y)) < self.reaches_um[hunter.seat]

    def _steer(self, hunter: Hunter, target: Target) -> None:
        """R4.3: the hosted controller."""
        gains = self.settings["gains"]
        seconds = self.period / 1000.0
        v_low, v_max, w_max = self.v_low[hunter.seat], self.v_max[hunter.seat], self.w_max[hunter.seat]
        if target.number != hunter.active:
            hunter.distance_integral = hunter.bearing_integral = 0.0
        hunter.active = target.number
        forward, left = in_own_frame(hunter, target.x, target.y)
        d = distance(hunter.x, hunter.y, target.x, target.y)
        e = wrap(atan2(left, forward))

        grown = hunter.distance_integral + d * seconds
        v = gains["kp_v"] * d + gains["ki_v"] * grown
        if not ((v > v_max and d > 0) or (v < v_low and d < 0)):
            hunter.distance_integral = grown
        hunter.v = clamp(v, v_low, v_max)

        grown = hunter.bearing_integral + e * seconds
        w = gains["kp_w"] * e + gains["ki_w"] * grown
        if not ((w > w_max and e > 0) or (w < -w_max and e < 0)):
            hunter.bearing_integral = grown
        hunter.w = clamp(w, -w_max, w_max)

    def _command(self, prey: Prey, action: Command) -> None:
        """R12.2: phase 2 of prey."""
        if prey.target is None or prey.withdrawn:
            return
        slowest = -self.target_speed if self.settings["reverse"] else 0.0
        prey.target.v = clamp(to_float32(action[0]) * self.target_speed, slowest, self.target_speed)
        prey.target.w = clamp(
            to_float32(action[1]) * self.target_turn_rate, -self.target_turn_rate, self.target_turn_rate
        )

    def _is_played(self, target: Target) -> bool:
        return any(prey.target is target for prey in self.prey)

    def _choose(self, target: Target) -> None:
        """R3.8: phase 2 of a moving target that nobody plays."""
        if self.settings["target_motion"] == "wander":
            self._wander(target, self.target_speed)
            return
        threat = self._threat(target)
        if threat is None:
            self._wander(target, self.target_speed / 2.0)
        else:
            self._flee(target, threat)

    def _wander(self, target: Target, speed: float) -> None:
        """R3.9."""
        if target.at_wall:
            target.w = self._turn_towards(target, self.side / 2.0 - target.x, self.side / 2.0 - target.y)
        else:
            periods = (self.time - target.appeared) // self.settings["wander_period_ms"]
            f = fraction(draw(draw(key(self.seed, WANDER), target.number), periods))
            target.w = (2.0 * f - 1.0) * self.target_turn_rate
        target.v = speed

    def _threat(self, target: Target) -> Hunter | None:
        """R3.10: the hunter that the target flees from, if there is one."""
        hunter = self._nearest_hunter(target)
        if hunter is None:
            return None
        um = micrometres(distance(target.x, target.y, hunter.x, hunter.y))
        return hunter if um < micrometres(self.settings["alarm_m"]) else None

    def _nearest_hunter(self, target: Target) -> Hunter | None:
        """R3.10, R12.5: of those equally near one by lot; None if all are withdrawn."""
        lots = draw(draw(key(self.seed, THREAT_LOT), self.steps), target.number)
        found = [
            (micrometres(distance(target.x, target.y, hunter.x, hunter.y)), draw(lots, hunter.seat), hunter.seat)
            for hunter in self.hunters
            if not hunter.withdrawn
        ]
        return self.hunters[min(found)[2]] if found else None

    def _flee(self, target: Target, threat: Hunter) -> None:
        """R3.10: away from the threat, and off the walls."""
        d = distance(target.x, target.y, threat.x, threat.y)
        if d > 0:
            away_x = (target.x - threat.x) / d
            away_y = (target.y - threat.y) / d
        else:
            away_y, away_x = sincos(target.theta)
        push_x, push_y = self._push(target.x), self._push(target.y)
        target.w = self._turn_towards(target, away_x + 2.0 * push_x, away_y + 2.0 * push_y)
        target.v = self.target_speed

    def _push(self, c: float) -> float:
        """A.7: how deep in the wall's metre a coordinate lies, with the sign of the way out."""
        return 1.0 - c if c < 1.0 else ((self.side - 1.0) - c if c > self.side - 1.0 else 0.0)

    def _turn_towards(self, target: Target, px: float, py: float) -> float:
        """A.7's steer: the turn rate towards a direction in the world frame."""
        sine, cosine = sincos(target.theta)
        e = wrap(atan2(cosine * py - sine * px, cosine * px + sine * py))
        return clamp(6.0 * e, -self.target_turn_rate, self.target_turn_rate)

    def _judge(self, requests: Sequence[Request | None]) -> None:
        """Phase 3: R5.2's tests, for the requests that a step can hold."""
        faults = self.settings["faults"]
        down = fraction(draw(key(self.seed, KILL_DOWN), self.steps)) < faults["kill_down"]
        made = [request for request in requests if request is not None]
        by_number = {target.number: target for target in self.alive}
        for request in made:
            hunter = self.hunters[request.seat]
            if request.number is None:
                request.verdict = MALFORMED
            elif hunter.withdrawn:
                request.verdict = HUNTER_INACTIVE
            elif down:
                request.verdict = SERVICE_DOWN
            elif self.policy == "capstone":
                request.verdict = GRANTED
                request.winner = request.seat
            else:
                target = by_number[request.number]
                request.distance_um = micrometres(distance(hunter.x, hunter.y, target.x, target.y))
                if not request.distance_um < self.reaches_um[request.seat]:
                    request.verdict = OUT_OF_REACH
        refuse_without_partners(made, self.teams, self.settings["hunters_per_catch"])
        decide_contests(made, self._unkillable(), self.policy, self.seed, self.steps)

    def _unkillable(self) -> list[int]:
        """R8.3: the alive targets whose kill the simulator refuses in this step."""
        stream = draw(key(self.seed, KILL_REFUSED), self.steps)
        rate = self.settings["faults"]["kill_refused"]
        return [target.number for target in self.alive if fraction(draw(stream, target.number)) < rate]

    def _commit(self, requests: Sequence[Request | None]) -> None:
        """Phase 4: grants are credited, and caught targets leave."""
        caught = set()
        self.rulings = [None] * len(self.hunters)
        for request in requests:
            if request is None:
                continue
            self.rulings[request.seat] = (request.verdict, request.number, request.distance_um, request.winner)
            if request.verdict == GRANTED:
                self.hunters[request.seat].score += 1
                caught.add(request.number)
        if self.policy == "capstone":  # the grant stands, but what the simulator refuses to kill stays alive
            caught -= set(self._unkillable())
        self.alive = [target for target in self.alive if target.number not in caught]
        self.caught_by = [None] * self.prey_count
        for prey in self.prey:
            if prey.target is None or prey.target.number not in caught:
                continue
            granted = (GRANTED, prey.target.number)
            self.caught_by[prey.index] = next(
                one.seat for one in requests if one and (one.verdict, one.number) == granted
            )
            prey.target = None
            prey.times_caught += 1
            prey.caught_at = self.time

    def _move(self) -> None:
        """Phase 5, motion: chapter 2 for the ticks in (t, t + period]."""
        ticks = range(self.time // 16 + 1, (self.time + self.period) // 16 + 1)
        fresh = [tick for tick in ticks if 16 * tick - self.time <= 1000]
        for hunter in self.hunters:
            hunter.at_wall = False
            if hunter.withdrawn:
                continue
            self._drive(hunter, len(fresh))
            if len(fresh) < len(ticks):
                hunter.v = hunter.w = 0.0
        if self.targets_move:
            for target in self.alive:
                target.at_wall = False
                self._drive(target, len(ticks))

    def _drive(self, turtle: Turtle, ticks: int) -> None:
        stride = turtle.v * DT
        turn = turtle.w * DT
        sine, cosine = sincos(turtle.theta)
        turn_sine, turn_cosine = sincos(turn)
        for _ in range(ticks):
            sine, cosine = sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine
            x = turtle.x + cosine * stride
            y = turtle.y + sine * stride
            turtle.x = clamp(x, 0.0, self.side)
            turtle.y = clamp(y, 0.0, self.side)
            if turtle.x != x or turtle.y != y:
                turtle.at_wall = True
        turtle.theta = wrap(turtle.theta + turn * ticks)

    def _spawn(self) -> None:
        """Phase 5, spawning: the timer's firings in (t, t + period], unless it is off."""
        if not self.settings["spawning"]:
            return
        faults = self.settings["faults"]
        first = self.time // self.spawn_period + 1
        last = (self.time + self.period) // self.spawn_period
        for firing in range(first, last + 1):
            self.firings += 1
            if self.budget is not None and self.spawned >= self.budget:
                continue
            if len(self.alive) >= self.settings["max_targets"]:
                self.skipped_full += 1
            elif fraction(draw(key(self.seed, SPAWN_DOWN), firing)) < faults["spawn_down"]:
                self.skipped_down += 1
            else:
                self.used += 1
                if fraction(draw(key(self.seed, SPAWN_REFUSED), self.used)) < faults["spawn_refused"]:
                    self.refused += 1
                else:
                    self._appear(self.used, firing * self.spawn_period)

    def _return_prey(self) -> None:
        """R12.3: at the end of phase 5."""
        away = self.settings["prey_returns_s"]
        if away is None:
            return
        end = self.time + self.period
        for prey in self.prey:
            is_due = prey.caught_at is not None and end >= prey.caught_at + math.floor(1000.0 * away + 0.5)
            if is_due and len(self.alive) < self.settings["max_targets"]:
                self.used += 1
                prey.target = self._appear(self.used, end)
                prey.caught_at = None

    def _progress_reference(self, hunter: Hunter) -> tuple[float, float] | None:
        """R6.2: where the nearest seen target stood on S_t."""
        ranked = self._ranked_targets(hunter)
        return (ranked[0].x, ranked[0].y) if ranked else None

    def _reward(
        self,
        requests: Sequence[Request | None],
        references: Sequence[tuple[float, float] | None],
        before: Sequence[float],
    ) -> None:
        """Phase 7: R6.2, and R11.2."""
        weights = self.settings["rewards"]
        verdicts = [0 if request is None else request.verdict for request in requests]
        catches = [1.0 if verdict == GRANTED else 0.0 for verdict in verdicts]
        self.rewards, self.parts = [], []
        for hunter, verdict, reference, was in zip(self.hunters, verdicts, references, before, strict=True):
            progress = 0.0
            if reference is not None:
                progress = was - distance(hunter.x, hunter.y, *reference)
            own = catches[hunter.seat]
            mates = sum(catches[seat] for seat in self._team_of(hunter.seat)) - own
            parts = (
                own,
                sum(catches) - own - mates,
                1.0 if verdict == LOST_CONTEST else 0.0,
                1.0 if verdict not in (0, GRANTED, LOST_CONTEST) else 0.0,
                progress,
                self.period / 1000.0,
                mates,
            )
            if hunter.withdrawn:
                parts = (0.0,) * len(parts)
            paid = [name for name in PART_NAMES if name != "mate_catch"] + ["mate_catch"] * (self.teams is not None)
            reward, *others = (weights[name] * parts[PART_NAMES.index(name)] for name in paid)
            for other in others:
                reward = reward + other
            self.parts.append(parts)
            self.rewards.append(reward)
        if self.teams is not None and self.settings["team_share"] > 0:
            self.rewards = [self._shared(hunter, self.rewards) for hunter in self.hunters]

    def _team_of(self, seat: int) -> list[int]:
        """R11.1: the seats of a seat's team, in ascending order; without teams its own."""
        return next((sorted(team) for team in self.teams or () if seat in team), [seat])

    def _shared(self, hunter: Hunter, own: Sequence[float]) -> float:
        """R11.2: a hunter's reward where its team shares."""
        if hunter.withdrawn:
            return 0.0
        first, *others = self._team_of(hunter.seat)
        total = own[first]
        for seat in others:
            total = total + own[seat]
        q: float = self.settings["team_share"]
        return (1.0 - q) * own[hunter.seat] + q * (total / (1 + len(others)))

    def _chased(self) -> list[Chase | None]:
        """R12.5: where each prey stands on S_t, and the nearest hunter, if there is one; None of prey that is out."""
        found: list[Chase | None] = []
        for prey in self.prey:
            if prey.target is None:
                found.append(None)
                continue
            hunter = self._nearest_hunter(prey.target)
            found.append(((prey.target.x, prey.target.y), None if hunter is None else (hunter.x, hunter.y)))
        return found

    def _reward_prey(self, chased: Sequence[Chase | None]) -> None:
        """Phase 7: R12.5."""
        weights = self.settings["prey_rewards"]
        self.prey_rewards, self.prey_parts = [], []
        for prey, chase in zip(self.prey, chased, strict=True):
            caught = survived = gained = 0.0
            if not prey.withdrawn and self.caught_by[prey.index] is not None:
                caught = 1.0
            elif not prey.withdrawn and chase is not None:
                survived = self.period / 1000.0
                (x, y), hunter = chase
                if hunter is not None:
                    assert prey.target is not None
                    gained = distance(prey.target.x, prey.target.y, *hunter) - distance(x, y, *hunter)
            parts = (caught, survived, gained)
            reward = weights["caught"] * caught + weights["survived"] * survived + weights["gained"] * gained
            self.prey_parts.append(parts)
            self.prey_rewards.append(0.0 if prey.withdrawn else reward)

    def team_scores(self) -> list[int]:
        """R11.1: by team, in the order in which the settings name them; without teams by seat."""
        teams = self.teams if self.teams is not None else [[hunter.seat] for hunter in self.hunters]
        return [sum(self.hunters[seat].score for seat in team) for team in teams]

    # ---- what is seen ----

    def _sees(self, hunter: Hunter, other: Turtle) -> bool:
        """R7.5: within reach, or within the radius and the cone."""
        d = distance(hunter.x, hunter.y, other.x, other.y)
        um = micrometres(d)
        if um < self.reaches_um[hunter.seat]:
            return True
        radius, angle = self.settings["view_radius_m"], self.settings["view_angle_deg"]
        if radius is not None and not um < micrometres(radius):
            return False
        if angle == 360:
            return True
        _, edge = sincos(angle * PI / 360.0)
        forward, _ = in_own_frame(hunter, other.x, other.y)
        return forward >= d * edge

    def _ranked_targets(self, hunter: Hunter) -> list[Target]:
        """R7.1's order of the seen targets: near, then spawn number."""
        return sorted(
            (target for target in self.alive if self._sees(hunter, target)),
            key=lambda target: (
                nearness(hunter.x, hunter.y, target.x, target.y),
                target.number,
            ),
        )

    def _targets_in_view(self, hunter: Hunter) -> list[Target]:
        return self._ranked_targets(hunter)[: self.targets_seen]

    def masks(self) -> list[list[int] | None]:
        """R7.2: by seat; None under velocity control."""
        masks: list[list[int] | None] = []
        for hunter in self.hunters:
            if self.controls[hunter.seat] == "velocity":
                masks.append(None)
                continue
            seen = len(self._targets_in_view(hunter))
            masks.append([1] + [1] * seen + [0] * (self.targets_seen - seen))
        return masks

    def observations(self) -> list[list[float]]:
        """R7.1: by seat, every number rounded to float32."""
        return [[to_float32(value) for value in self._observe(hunter)] for hunter in self.hunters]

    def _time_left(self) -> float:
        return (self.limit - self.time) / 1000.0 if self.limit > self.time else 0.0

    def _observe(self, hunter: Hunter) -> list[float]:
        sine, cosine = sincos(hunter.theta)
        numbers = [
            hunter.x,
            hunter.y,
            cosine,
            sine,
            hunter.v,
            hunter.w,
            self._time_left(),
            float(hunter.score),
            hunter.distance_integral,
            hunter.bearing_integral,
        ]
        targets = self._targets_in_view(hunter)
        for target in targets:
            forward, left = in_own_frame(hunter, target.x, target.y)
            active = 1.0 if target.number == hunter.active else 0.0
            numbers += self._blurred(forward, left, hunter.seat, 0, target.number)
            numbers += [1.0, (self.time - target.appeared) / 1000.0, active]
            if self.targets_move:
                numbers += [*relative_heading(hunter, target), target.v]
        columns = 8 if self.targets_move else 5
        numbers += [0.0] * (columns * (self.targets_seen - len(targets)))
        rivals = sorted(self._rivals(hunter))[: self.hunters_seen]
        for _, minus_left, *others, mate, seat in rivals:
            forward, relative_cosine, relative_sine, velocity, difference = (-number for number in others)
            numbers += self._blurred(forward, -minus_left, hunter.seat, 1, int(seat))
            numbers += [1.0, relative_cosine, relative_sine, velocity, difference]
            if self.teams is not None:
                numbers.append(-mate)
        columns = 7 if self.teams is None else 8
        numbers += [0.0] * (columns * (self.hunters_seen - len(rivals)))
        return numbers

    def prey_observations(self) -> list[list[float]]:
        """R12.4: by index, every number rounded to float32."""
        return [[to_float32(value) for value in self._observe_as_prey(prey)] for prey in self.prey]

    def _observe_as_prey(self, prey: Prey) -> list[float]:
        most = (min(len(self.hunters), 8), min(self.prey_count - 1, 8))
        me = prey.target
        if me is None:
            return [0.0] * 6 + [self._time_left(), float(prey.times_caught), 0.0] + [0.0] * (6 * sum(most))
        sine, cosine = sincos(me.theta)
        numbers = [me.x, me.y, cosine, sine, me.v, me.w, self._time_left(), float(prey.times_caught), 1.0]
        hunters = [hunter for hunter in self.hunters if not hunter.withdrawn]
        others = [other.target for other in self.prey if other is not prey and other.target is not None]
        for seen, ranks in zip((hunters, others), most, strict=True):
            rows = sorted(body_row(me, turtle) for turtle in seen)[:ranks]
            for _, minus_left, *row in rows:
                forward, relative_cosine, relative_sine, velocity = (-number for number in row)
                numbers += [forward, -minus_left, 1.0, relative_cosine, relative_sine, velocity]
            numbers += [0.0] * (6 * (ranks - len(rows)))
        return numbers

    def _blurred(self, forward: float, left: float, observer: int, kind: int, who: int) -> list[float]:
        """R7.6: forward and left as the observer has them."""
        if self.settings["view_noise_m"] == 0:
            return [forward, left]
        return [forward + self._noise(observer, kind, who, 0), left + self._noise(observer, kind, who, 1)]

    def _noise(self, observer: int, kind: int, who: int, axis: int) -> float:
        k = draw(draw(draw(draw(draw(key(self.seed, ERROR), self.steps), observer), kind), who), axis)
        f_0, f_1, f_2, f_3 = (fraction(draw(k, i)) for i in range(4))
        s: float = self.settings["view_noise_m"]
        return s * 1.7320508075688772 * (f_0 + f_1 + f_2 + f_3 - 2.0)

    def _rivals(self, hunter: Hunter) -> list[tuple[float, ...]]:
        """For each seen rival a tuple that sorts as R7.1 says: near, its numbers negated, left first, and its seat."""
        rows = []
        for rival in self.hunters:
            if rival is hunter or rival.withdrawn or not self._sees(hunter, rival):
                continue
            difference = float(rival.score - hunter.score)
            mate = 1.0 if rival.seat in self._team_of(hunter.seat) else 0.0
            rows.append((*body_row(hunter, rival), -difference, -mate, rival.seat))
        return rows

    # ---- digest ----

    def numbers(self) -> list[float]:
        """A.8: the state as a list of numbers."""
        numbers: list[float] = [
            self.time,
            self.steps,
            self.spawned,
            self.used,
            self.firings,
            self.skipped_full,
            self.skipped_down,
            self.refused,
        ]
        for hunter in self.hunters:
            numbers += [
                hunter.x,
                hunter.y,
                hunter.theta,
                hunter.v,
                hunter.w,
                hunter.distance_integral,
                hunter.bearing_integral,
                hunter.active,
                hunter.score,
                hunter.at_wall,
                hunter.withdrawn,
            ]
        for target in self.alive:
            numbers += [target.number, target.x, target.y, target.theta, target.appeared]
            if self.targets_move:
                numbers += [target.v, target.w, target.at_wall]
        for prey in self.prey:
            number = 0 if prey.target is None else prey.target.number
            numbers += [number, prey.times_caught, -1 if prey.caught_at is None else prey.caught_at]
        return [float(number) for number in numbers]

    def number_names(self) -> list[str]:
        """Names of `numbers`, for messages."""
        names = ["time", "step", "spawned", "used", "firings", "skipped_full", "skipped_down", "refused"]
        own = ("x", "y", "theta", "v", "w", "I_d", "I_e", "active", "score", "at_wall", "withdrawn")
        for hunter in self.hunters:
            names += [f"hunter_{hunter.seat}.{name}" for name in own]
        moving = ("v", "w", "at_wall") if self.targets_move else ()
        for target in self.alive:
            names += [f"target {target.number}.{name}" for name in ("number", "x", "y", "theta", "appeared", *moving)]
        for prey in self.prey:
            names += [f"prey_{prey.index}.{name}" for name in ("number", "times_caught", "caught_at")]
        return names

    def digest(self) -> bytes:
        """A.8: 8 bytes of BLAKE2b."""
        numbers = self.numbers()
        return hashlib.blake2b(struct.pack(f"<{len(numbers)}d", *numbers), digest_size=8).digest()


def body_row(observer: Turtle, other: Turtle) -> tuple[float, ...]:
    """Sort key of R7.1 for rivals, and of R12.4 for all: near, and then the columns negated, left first."""
    forward, left = in_own_frame(observer, other.x, other.y)
    relative_cosine, relative_sine = relative_heading(observer, other)
    near = nearness(observer.x, observer.y, other.x, other.y)
    return (near, -left, -forward, -relative_cosine, -relative_sine, -other.v)

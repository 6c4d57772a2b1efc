"""The oracle: a second arena, written from docs/rulebook.md alone, in plain Python with one object per turtle.

It shares no code with the package. Where it and the engine differ, the book decides which of them is wrong.
"""

# ruff: noqa: FURB136 - the choices are written as the book writes them: min and max may treat zeros otherwise

import hashlib
import math
import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from oracle.arithmetic import (
    DROPOUT,
    DT,
    ERROR,
    KILL_DOWN,
    KILL_REFUSED,
    PI,
    PLACE,
    SERVICE_LOT,
    SPAWN_DOWN,
    SPAWN_REFUSED,
    START_TURN,
    TAU,
    THREAT_LOT,
    TIE_LOT,
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

MATCH_OVER: Final = 1
MALFORMED: Final = 2
HUNTER_INACTIVE: Final = 3
DUPLICATE: Final = 4
UNKNOWN_TARGET: Final = 5
ALREADY_CAUGHT: Final = 6
SERVICE_DOWN: Final = 7
OUT_OF_REACH: Final = 8
LOST_CONTEST: Final = 9
KILL_FAILED: Final = 10
GRANTED: Final = 11

PART_NAMES: Final = ("catch", "rival_catch", "lost_contest", "rejected_request", "progress", "time")

Action = Any
"""An int under target control, (a1, a2) under velocity control, ((a1, a2), rank) under full control."""
RulingTuple = tuple[int, int | None, int | None, int | None]
"""(verdict, target's number, distance in micrometres, winner's seat)."""


def distance(x: float, y: float, x_other: float, y_other: float) -> float:
    """A.7, geometry: d [m]."""
    dx = x_other - x
    dy = y_other - y
    return math.sqrt(dx * dx + dy * dy)


def micrometres(d: float) -> int:
    """R5.3: a distance [m] in whole micrometres."""
    return math.floor(1000000.0 * d + 0.5)


def reach_in_micrometres(reach_m: float) -> int:
    """R5.3: the reach that a distance must stay below."""
    return max(1, math.floor(1000000.0 * reach_m + 0.5))


def by_seat(value: float | Sequence[float], count: int) -> list[float]:
    """R2.7: a number for all hunters, or one for each seat."""
    return [value] * count if isinstance(value, int | float) else list(value)


def nearness(x: float, y: float, x_other: float, y_other: float) -> int:
    """A.7, geometry: near, by which what is seen is ordered."""
    dx = x_other - x
    dy = y_other - y
    (bits,) = struct.unpack("<I", struct.pack("<f", dx * dx + dy * dy))
    return (int(bits) + 32) // 64


class Turtle:
    """What chapter 2 moves: a pose, a command, and whether the last step met a wall."""

    def __init__(self, x: float, y: float, theta: float) -> None:
        self.x = x
        self.y = y
        self.theta = theta
        self.v = 0.0
        self.w = 0.0
        self.at_wall = False


class Hunter(Turtle):
    """One hunter: besides, its controller's memory and its score."""

    def __init__(self, seat: int, x: float, y: float, theta: float) -> None:
        super().__init__(x, y, theta)
        self.seat = seat
        self.distance_integral = 0.0
        self.bearing_integral = 0.0
        self.active = 0
        self.score = 0
        self.withdrawn = False

    def stand_still(self) -> None:
        """What holding does: no velocity, no integrals, no active target (A.7)."""
        self.v = self.w = 0.0
        self.distance_integral = self.bearing_integral = 0.0
        self.active = 0


class Target(Turtle):
    """One alive target."""

    def __init__(self, number: int, x: float, y: float, theta: float, appeared: int) -> None:
        super().__init__(x, y, theta)
        self.number = number
        self.appeared = appeared


class Request:
    """One catch request on its way through the arbiter's tests."""

    def __init__(self, seat: int, number: int | None) -> None:
        self.seat = seat
        self.number = number
        """The target's number; None where no target can be meant."""
        self.verdict = 0
        self.distance_um: int | None = None
        self.winner: int | None = None


def contest_winner(eligible: Sequence[Request], number: int, policy: str, seed: int, step: int) -> int:
    """R5.4, R5.5, R5.9: the seat that wins one target."""
    seats = [request.seat for request in eligible]
    if policy == "first_come":
        lots = draw(key(seed, SERVICE_LOT), step)
        return min(seats, key=lambda seat: (draw(lots, seat), seat))
    nearest = min(request.distance_um for request in eligible if request.distance_um is not None)
    tied = [request.seat for request in eligible if request.distance_um == nearest]
    lots = draw(draw(key(seed, TIE_LOT), step), number)
    return min(tied, key=lambda seat: (draw(lots, seat), seat))


def decide_contests(requests: Sequence[Request], refused: Iterable[int], policy: str, seed: int, step: int) -> None:
    """R5.4 to R5.7: verdicts for all requests that no earlier test has refused."""
    contests: dict[int, list[Request]] = {}
    for request in requests:
        if request.verdict == 0 and request.number is not None:
            contests.setdefault(request.number, []).append(request)
    unkillable = set(refused)
    for number, eligible in contests.items():
        winner = contest_winner(eligible, number, policy, seed, step)
        for request in eligible:
            if request.seat != winner:
                request.verdict = LOST_CONTEST
                request.winner = winner
            elif number in unkillable:
                request.verdict = KILL_FAILED
                request.winner = winner if len(eligible) > 1 else None
            else:
                request.verdict = GRANTED
                request.winner = winner


def judge(
    *,
    hunters: Sequence[tuple[float, float]],
    targets: Mapping[str, tuple[float, float]],
    requests: Sequence[tuple[int, object]],
    reach_m: float | Sequence[float] = 0.3,
    policy: str = "nearest",
    seed: int = 0,
    step: int = 0,
    caught: Iterable[str] = (),
    inactive: Iterable[int] = (),
    kill_service_up: bool = True,
    kill_refused: Iterable[str] = (),
    match_over: bool = False,
) -> list[tuple[int, int, object, int | None, int | None]]:
    """Chapter 5 for requests by name: (verdict, seat, name, distance_um, winner) in the order of the requests."""
    names = list(targets)
    number_of = {name: place for place, name in enumerate(names, start=1)}
    caught, inactive = set(caught), set(inactive)
    reaches_um = [reach_in_micrometres(reach) for reach in by_seat(reach_m, len(hunters))]
    judged: list[Request] = []
    seen: set[int] = set()
    for seat, name in requests:
        if not 0 <= seat < len(hunters):
            raise ValueError(f"no hunter has seat {seat}")
        request = Request(seat, None)
        judged.append(request)
        is_first = seat not in seen
        seen.add(seat)
        if match_over:
            request.verdict = MATCH_OVER
        elif not isinstance(name, str) or len(name) > 255:
            request.verdict = MALFORMED
        elif seat in inactive:
            request.verdict = HUNTER_INACTIVE
        elif policy == "capstone":
            request.verdict = GRANTED if kill_service_up else SERVICE_DOWN
            request.winner = seat if kill_service_up else None
        elif not is_first:
            request.verdict = DUPLICATE
        elif name not in number_of and name not in caught:
            request.verdict = UNKNOWN_TARGET
        elif name in caught:
            request.verdict = ALREADY_CAUGHT
        elif not kill_service_up:
            request.verdict = SERVICE_DOWN
        else:
            request.number = number_of[name]
            request.distance_um = micrometres(distance(*hunters[seat], *targets[name]))
            if not request.distance_um < reaches_um[seat]:
                request.verdict = OUT_OF_REACH
    refused = [number_of[name] for name in kill_refused if name in number_of]
    decide_contests(judged, refused, policy, seed, step)
    return [
        (request.verdict, request.seat, name, request.distance_um, request.winner)
        for request, (_, name) in zip(judged, requests, strict=True)
    ]


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
        self.targets_move: bool = settings["target_motion"] != "still"
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
        self._no_results()

    def _no_results(self) -> None:
        self.rulings: list[RulingTuple | None] = [None] * len(self.hunters)
        self.rewards = [0.0] * len(self.hunters)
        self.parts = [(0.0,) * 6] * len(self.hunters)

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

    def _appear(self, number: int, when: int) -> None:
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
        self.alive.append(Target(number, x, y, theta, when))
        self.spawned += 1

    def withdraw(self, seat: int) -> None:
        """R1.6: the hunter takes no further part."""
        hunter = self.hunters[seat]
        hunter.withdrawn = True
        hunter.stand_still()

    def place(self, hunters: Sequence[tuple[float, float, float]], targets: Sequence[tuple[float, float]]) -> None:
        """For tests: hunters at rest at these poses, and these targets, with new numbers, instead of the alive ones."""
        for hunter, (x, y, theta) in zip(self.hunters, hunters, strict=True):
            hunter.x, hunter.y, hunter.theta = x, y, wrap(theta)
            hunter.stand_still()
            hunter.at_wall = False
        self.alive = []
        for x, y in targets:
            self.used += 1
            self.spawned += 1
            self.alive.append(Target(self.used, x, y, 0.0, self.time))

    # ---- one step ----

    def step(self, actions: Sequence[Action]) -> None:
        """R1.4's seven phases."""
        if self.terminated or self.truncated:
            raise RuntimeError("the episode has ended")
        self._drop_out()
        requests = [self._intake(hunter, action) for hunter, action in zip(self.hunters, actions, strict=True)]
        if self.targets_move:
            for target in self.alive:
                self._choose(target)
        self._judge(requests)
        self._commit(requests)
        goals = [self._goal(hunter) for hunter in self.hunters]
        before = [
            distance(hunter.x, hunter.y, *goal) if goal is not None else 0.0
            for hunter, goal in zip(self.hunters, goals, strict=True)
        ]
        self._move()
        self._spawn()
        self.time += self.period
        self.steps += 1
        done = self.budget is not None and self.spawned >= self.budget and not self.alive
        self.terminated = done
        self.truncated = not done and self.time >= self.limit
        self._reward(requests, goals, before)

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

    def _choose(self, target: Target) -> None:
        """R3.8: phase 2 of a moving target."""
        speed: float = self.settings["target_speed_mps"]
        if self.settings["target_motion"] == "wander":
            self._wander(target, speed)
            return
        threat = self._threat(target)
        if threat is None:
            self._wander(target, speed / 2.0)
        else:
            self._flee(target, threat)

    def _wander(self, target: Target, speed: float) -> None:
        """R3.9."""
        if target.at_wall:
            target.w = self._turn_towards(target, self.side / 2.0 - target.x, self.side / 2.0 - target.y)
        else:
            periods = (self.time - target.appeared) // self.settings["wander_period_ms"]
            f = fraction(draw(draw(key(self.seed, WANDER), target.number), periods))
            target.w = (2.0 * f - 1.0) * self.settings["target_turn_rate_radps"]
        target.v = speed

    def _threat(self, target: Target) -> Hunter | None:
        """R3.10: the hunter that the target flees from, if there is one."""
        lots = draw(draw(key(self.seed, THREAT_LOT), self.steps), target.number)
        found = [
            (micrometres(distance(target.x, target.y, hunter.x, hunter.y)), draw(lots, hunter.seat), hunter.seat)
            for hunter in self.hunters
            if not hunter.withdrawn
        ]
        if not found:
            return None
        um, _, seat = min(found)
        return self.hunters[seat] if um < micrometres(self.settings["alarm_m"]) else None

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
        target.v = self.settings["target_speed_mps"]

    def _push(self, c: float) -> float:
        """A.7: how deep in the wall's metre a coordinate lies, with the sign of the way out."""
        return 1.0 - c if c < 1.0 else ((self.side - 1.0) - c if c > self.side - 1.0 else 0.0)

    def _turn_towards(self, target: Target, px: float, py: float) -> float:
        """A.7's steer: the turn rate towards a direction in the world frame."""
        sine, cosine = sincos(target.theta)
        e = wrap(atan2(cosine * py - sine * px, cosine * px + sine * py))
        w_max = self.settings["target_turn_rate_radps"]
        return clamp(6.0 * e, -w_max, w_max)

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
        """Phase 5, spawning: the timer's firings in (t, t + period]."""
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

    def _goal(self, hunter: Hunter) -> tuple[float, float] | None:
        """R6.2: where the nearest seen target stood on S_t."""
        ranked = self._ranked_targets(hunter)
        return (ranked[0].x, ranked[0].y) if ranked else None

    def _reward(
        self,
        requests: Sequence[Request | None],
        goals: Sequence[tuple[float, float] | None],
        before: Sequence[float],
    ) -> None:
        """Phase 7: R6.2."""
        weights = self.settings["rewards"]
        verdicts = [0 if request is None else request.verdict for request in requests]
        catches = [1.0 if verdict == GRANTED else 0.0 for verdict in verdicts]
        self.rewards, self.parts = [], []
        for hunter, verdict, goal, was in zip(self.hunters, verdicts, goals, before, strict=True):
            progress = 0.0
            if goal is not None:
                progress = was - distance(hunter.x, hunter.y, *goal)
            own = catches[hunter.seat]
            parts = (
                own,
                sum(catches) - own,
                1.0 if verdict == LOST_CONTEST else 0.0,
                1.0 if verdict not in (0, GRANTED, LOST_CONTEST) else 0.0,
                progress,
                self.period / 1000.0,
            )
            if hunter.withdrawn:
                parts = (0.0,) * 6
            reward = weights[PART_NAMES[0]] * parts[0]
            for name, amount in zip(PART_NAMES[1:], parts[1:], strict=True):
                reward = reward + weights[name] * amount
            self.parts.append(parts)
            self.rewards.append(reward)

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

    def _observe(self, hunter: Hunter) -> list[float]:
        sine, cosine = sincos(hunter.theta)
        left_over = (self.limit - self.time) / 1000.0 if self.limit > self.time else 0.0
        numbers = [
            hunter.x,
            hunter.y,
            cosine,
            sine,
            hunter.v,
            hunter.w,
            left_over,
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
        for _, minus_left, *others, seat in rivals:
            forward, relative_cosine, relative_sine, velocity, difference = (-number for number in others)
            numbers += self._blurred(forward, -minus_left, hunter.seat, 1, int(seat))
            numbers += [1.0, relative_cosine, relative_sine, velocity, difference]
        numbers += [0.0] * (7 * (self.hunters_seen - len(rivals)))
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
            forward, left = in_own_frame(hunter, rival.x, rival.y)
            near = nearness(hunter.x, hunter.y, rival.x, rival.y)
            relative_cosine, relative_sine = relative_heading(hunter, rival)
            difference = float(rival.score - hunter.score)
            row = (near, -left, -forward, -relative_cosine, -relative_sine, -rival.v, -difference, rival.seat)
            rows.append(row)
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
        return [float(number) for number in numbers]

    def number_names(self) -> list[str]:
        """What each of `numbers` is, for messages."""
        names = ["time", "step", "spawned", "used", "firings", "skipped_full", "skipped_down", "refused"]
        own = ("x", "y", "theta", "v", "w", "I_d", "I_e", "active", "score", "at_wall", "withdrawn")
        for hunter in self.hunters:
            names += [f"hunter_{hunter.seat}.{name}" for name in own]
        moving = ("v", "w", "at_wall") if self.targets_move else ()
        for target in self.alive:
            names += [f"target {target.number}.{name}" for name in ("number", "x", "y", "theta", "appeared", *moving)]
        return names

    def digest(self) -> bytes:
        """A.8: 8 bytes of BLAKE2b."""
        numbers = self.numbers()
        return hashlib.blake2b(struct.pack(f"<{len(numbers)}d", *numbers), digest_size=8).digest()


def in_own_frame(hunter: Hunter, x: float, y: float) -> tuple[float, float]:
    """A.7, geometry: (forward, left) of a point [m]."""
    sine, cosine = sincos(hunter.theta)
    dx = x - hunter.x
    dy = y - hunter.y
    return cosine * dx + sine * dy, cosine * dy - sine * dx


def relative_heading(hunter: Hunter, other: Turtle) -> tuple[float, float]:
    """A.7, observation: cosine and sine of another's heading relative to the hunter's."""
    sine, cosine = sincos(hunter.theta)
    its_sine, its_cosine = sincos(other.theta)
    return its_cosine * cosine + its_sine * sine, its_sine * cosine - its_cosine * sine

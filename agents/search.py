"""Looks ahead: tries each place to go to in an arena of its own, with rivals as it expects them.

What is in view is copied into a light arena, once for each place that the hunter could go to: the targets, some points
to wait at, and where it is. All copies are played on for some seconds, in which everybody runs the race that suits it
best; then the hunter goes where that was worth most. The work of a move is bounded, whatever is in view and however
fast the machine is, so that a match can be repeated. Nothing is remembered or drawn.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, View

Float64Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STEP_S: Final = 0.2
"""A step of the look-ahead: coarser than the arena's own."""
TARGETS: Final = 8
RIVALS: Final = 7
"""At most so many of the nearest are looked at."""
WAITING: Final = 3
"""A grid of WAITING x WAITING points of the spawn area where the hunter could wait."""
GROUND: Final = 5
"""The spawn area is shared out in GROUND x GROUND points."""
LOOKS_AT_GROUND: Final = 3
"""How often in a look-ahead."""
LOST: Final = 1e3
"""Above every time [s]: a race that is lost comes behind all that are won."""
LONGEST_LEAD_S: Final = 1.5
"""Nobody knows where a target turns to after that."""
SLOWEST_GAIN_MPS: Final = 0.1
"""What flees nearly as fast as the hunter is caught at some time as well: at a wall, or by two."""
THERE_M: Final = 0.02
"""Who waits stands still so near to its place."""
SPAWN_LOW_M: Final = 0.5
SPAWN_WALL_M: Final = 0.5889
"""R3.2: spawns keep these distances from the walls at 0 and from those opposite. The second is rounded, as in the agent
`patrol`; engine/core_settings.py has all of its digits, but with those `search` could decide otherwise than it was
rated.
"""
TURN_GAIN: Final = 6.0
"""Turn rate per radian of bearing [1/s]."""
BRAKE_GAIN: Final = 2.0
"""Speed per metre that is left to a resting place [1/s]."""
CIRCLE: Final = 0.3
"""Of the arena's side: the circle on which a hunter drives that sees a part of the arena only, and there nothing."""
FURTHER_RAD: Final = 0.8
"""How far ahead on it."""


class Weights(NamedTuple):
    """What a look-ahead is, and what counts in it."""

    steps: int = 9
    """Of STEP_S each."""
    discount: float = 0.25
    """By how much less a catch counts for each second that it comes later [1/s]."""
    rivals: float = 0.33
    """What a rival's catch costs [own catches]."""
    ground: float = 0.6
    """What all the ground is worth [own catches]."""
    lost_by_s: float = 0.4
    """After the first goal the hunter runs no race that it loses by more than this."""
    wait_s: float = 1.0
    """For how long it goes to a place where it waits."""


class Agent:
    """Drives itself to the place from where it expects most, and decides anew in every step."""

    control = "velocity"
    weights = Weights()

    def reset(self, seed: int) -> None:
        """Nothing to forget, and nothing is drawn."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        observations = np.array([view.observation], dtype=np.float32)
        masks = np.zeros((1, 0), dtype=np.int8)
        speed, turn = self.act_batch(BatchView(observations, masks, view.limits))[0].tolist()
        return speed, turn

    def act_batch(self, view: BatchView) -> NDArray[np.float64]:
        """The same for N hunters: (N, 2)."""
        scene = Scene.of(view)
        return drive_to(scene, look_ahead(scene, self.weights).argmax(axis=1))


class Scene(NamedTuple):
    """What N hunters see, in the world frame: H hunters, each itself first, K targets, and C places to go to:
    the targets, where it is, and where it could wait.
    """

    limits: Limits
    x: Float64Array
    """(N, H) [m]."""
    y: Float64Array
    heading: Float64Array
    """(N, H) [rad]."""
    here: BoolArray
    """(N, H): whether there is such a hunter."""
    races: BoolArray
    """(N, H): who stands still races for nothing."""
    mates: BoolArray
    """(N, H): itself and its team-mates."""
    target_x: Float64Array
    """(N, K) [m]."""
    target_y: Float64Array
    target_vx: Float64Array
    """(N, K) [m/s]."""
    target_vy: Float64Array
    alive: BoolArray
    """(N, K)."""
    goal_x: Float64Array
    """(N, C) [m]."""
    goal_y: Float64Array
    open: BoolArray
    """(N, C): what is there, and is not as good as caught."""

    @classmethod
    def of(cls, view: BatchView) -> "Scene":
        """What stands in a view."""
        limits, own = view.limits, view.own
        x, y, cosine, sine = (
            np.asarray(c, np.float64)[:, None] for c in (own.x, own.y, own.heading_cos, own.heading_sin)
        )
        heading = np.arctan2(sine, cosine)
        most = max(1, min(TARGETS, int((view.targets.present > 0).sum(axis=1).max(initial=0))))
        its = {name: np.asarray(c[:, :most], np.float64) for name, c in view.targets._asdict().items()}
        others = {name: np.asarray(c[:, :RIVALS], np.float64) for name, c in view.rivals._asdict().items()}
        alive, me = its["present"] > 0, np.ones((len(x), 1), np.bool_)
        there = others["present"] > 0
        target_x, target_y = (
            x + cosine * its["forward"] - sine * its["left"],
            y + sine * its["forward"] + cosine * its["left"],
        )
        vx, vy = np.zeros(alive.shape), np.zeros(alive.shape)
        if limits.targets_move:
            ahead, aside = (its["linear_velocity"] * its[name] for name in ("heading_cos", "heading_sin"))
            vx, vy = cosine * ahead - sine * aside, sine * ahead + cosine * aside
        hunters_x = np.concatenate((x, x + cosine * others["forward"] - sine * others["left"]), axis=1)
        hunters_y = np.concatenate((y, y + sine * others["forward"] + cosine * others["left"]), axis=1)
        waiting_x, waiting_y = (np.broadcast_to(c, (len(x), c.size)) for c in spawn_area(limits, WAITING))
        mates = others["mate"] > 0 if limits.teams else np.zeros(there.shape, np.bool_)
        scene = cls(
            limits=limits,
            x=hunters_x,
            y=hunters_y,
            heading=np.concatenate(
                (heading, heading + np.arctan2(others["heading_sin"], others["heading_cos"])), axis=1
            ),
            here=np.concatenate((me, there), axis=1),
            races=np.concatenate((me, there & (others["linear_velocity"] != 0)), axis=1),
            mates=np.concatenate((me, mates), axis=1),
            target_x=target_x,
            target_y=target_y,
            target_vx=vx,
            target_vy=vy,
            alive=alive,
            goal_x=np.concatenate((target_x, x, waiting_x), axis=1),
            goal_y=np.concatenate((target_y, y, waiting_y), axis=1),
            open=np.ones((len(x), alive.shape[1] + 1 + waiting_x.shape[1]), np.bool_),
        )
        return scene._replace(open=scene._open())

    def _open(self) -> BoolArray:
        distance = np.hypot(self.target_x[:, None] - self.x[:, :, None], self.target_y[:, None] - self.y[:, :, None])
        distance = np.where(self.here[:, :, None], distance, np.inf)
        caught = (distance[:, 0] < self.limits.reach_m) & (distance[:, 0] <= distance.min(axis=1))
        return np.concatenate((self.alive & ~caught, self.open[:, self.alive.shape[1] :]), axis=1)


def spawn_area(limits: Limits, points: int) -> tuple[Float64Array, Float64Array]:
    """R3.2: a grid of points in it: x and y [m], (points * points,)."""
    step = (limits.side_m - SPAWN_LOW_M - SPAWN_WALL_M) / points
    places = SPAWN_LOW_M + (np.arange(points) + 0.5) * step
    return np.repeat(places, points), np.tile(places, points)


def look_ahead(scene: Scene, weights: Weights) -> Float64Array:
    """What each place to go to is worth: (N, C); -inf for those that are not open."""
    arena, worth = RolloutArena(scene, weights), np.zeros(scene.goal_x.shape)
    looks = {weights.steps * look // LOOKS_AT_GROUND for look in range(1, LOOKS_AT_GROUND + 1)}
    for step in range(weights.steps):
        worth += arena.catch() * np.exp(-weights.discount * STEP_S * step)
        arena.move(waits=STEP_S * step < weights.wait_s)
        if step + 1 in looks:
            worth += weights.ground / len(looks) * arena.own_ground()
    worth += arena.still_to_come()
    return np.where(scene.open, worth, -np.inf)


class RolloutArena:
    """The light arena: C copies of each of N scenes; in each the hunter goes to another place first.

    Its clock is coarse, and no targets appear, since the places are not known. What counts instead is the share of the
    ground that is a hunter's own, since new targets are spread evenly (R3.2).

    Everybody drives to where it would meet a target that moves, and a target that flees takes longer; but straight to
    where it is now if it is faster, and where prey is played.
    """

    def __init__(self, scene: Scene, weights: Weights) -> None:
        self.scene, self.weights, self.limits = scene, weights, scene.limits
        count, copies, self.targets = len(scene.x), scene.goal_x.shape[1], scene.alive.shape[1]
        self.x: Float64Array = np.repeat(scene.x[:, None], copies, axis=1)
        self.y: Float64Array = np.repeat(scene.y[:, None], copies, axis=1)
        self.heading: Float64Array = np.repeat(scene.heading[:, None], copies, axis=1)
        self.target_x: Float64Array = np.repeat(scene.target_x[:, None], copies, axis=1)
        self.target_y: Float64Array = np.repeat(scene.target_y[:, None], copies, axis=1)
        self.alive: BoolArray = np.repeat(scene.alive[:, None], copies, axis=1)
        self.goal_x, self.goal_y = scene.goal_x.copy(), scene.goal_y.copy()
        self.absent = np.where(scene.here, 0.0, np.inf)[:, None, :, None]
        self.idle = np.where(scene.races, 0.0, np.inf)[:, None, :, None]
        self.strangers = np.where(scene.mates, np.inf, 0.0)[:, None, :, None]
        self.worth = np.where(scene.mates, 1.0, -weights.rivals)
        slower = self.limits.target_speed_mps < self.limits.max_speed_mps
        self.leads = self.limits.targets_move and slower and not self.limits.prey  # where prey turns to, nobody knows
        self.rows, self.copies = np.arange(count)[:, None, None], np.arange(copies)[:, None]
        self.numbers = np.arange(self.x.shape[2])
        self._look()

    def _look(self) -> None:
        """From each hunter to each target: (N, C, H, K)."""
        self.dx = self.target_x[:, :, None] - self.x[..., None]
        self.dy = self.target_y[:, :, None] - self.y[..., None]
        self.distance = np.sqrt(self.dx * self.dx + self.dy * self.dy)
        self.cosine, self.sine = np.cos(self.heading), np.sin(self.heading)
        if self.limits.targets_move:
            self.target_vx, self.target_vy = self._target_velocities()
        self.meet_x, self.meet_y = self._meetings()

    def _target_velocities(self) -> tuple[Float64Array, Float64Array]:
        """Straight on, or, with a hunter nearer than the alarm, away from it (R3.10): (N, C, K)."""
        straight = self.scene.target_vx[:, None], self.scene.target_vy[:, None]
        if not self.limits.alarm_m:
            return straight
        threat, targets = (self.distance + self.absent).argmin(axis=2), np.arange(self.targets)
        away = self.distance[self.rows, self.copies, threat, targets]
        speed = self.limits.target_speed_mps / np.maximum(1e-6, away)
        vx, vy = (
            np.where(away < self.limits.alarm_m, speed * from_all[self.rows, self.copies, threat, targets], calm)
            for from_all, calm in zip((self.dx, self.dy), straight, strict=True)
        )
        return vx, vy

    def _meetings(self) -> tuple[Float64Array, Float64Array]:
        """Where each hunter drives for each target: to meet it if it moves on as it does now: (N, C, H, K)."""
        x, y = (np.broadcast_to(c[:, :, None], self.distance.shape) for c in (self.target_x, self.target_y))
        if not self.leads:
            return x, y
        lead, side = np.minimum(LONGEST_LEAD_S, self.distance / self.limits.max_speed_mps), self.limits.side_m
        return (
            np.clip(x + lead * self.target_vx[:, :, None], 0.0, side),
            np.clip(y + lead * self.target_vy[:, :, None], 0.0, side),
        )

    def _arrivals_s(self, dx: Float64Array, dy: Float64Array, way: Float64Array) -> Float64Array:
        """The way at full speed, and half of the turn; infinite for who is not there."""
        cosine, sine = self.cosine[..., None], self.sine[..., None]
        turn: Any = np.abs(np.arctan2(cosine * dy - sine * dx, cosine * dx + sine * dy))
        arrivals: Float64Array = (
            way / self.limits.max_speed_mps + 0.5 / self.limits.max_turn_rate_radps * turn + self.absent
        )
        return arrivals

    def _races_s(self) -> Float64Array:
        """When each hunter could reach each target; infinite for who does not race: (N, C, H, K)."""
        limits, dx, dy = self.limits, self.dx, self.dy
        way = np.maximum(0.0, self.distance - limits.reach_m)
        if limits.alarm_m and self.leads:  # on what flees the hunter gains by the difference of both speeds alone
            gains = max(SLOWEST_GAIN_MPS, limits.max_speed_mps - limits.target_speed_mps)
            chase = np.maximum(0.0, np.minimum(self.distance, limits.alarm_m) - limits.reach_m)
            way = way + limits.target_speed_mps / gains * chase
        elif self.leads:
            dx, dy = self.meet_x - self.x[..., None], self.meet_y - self.y[..., None]
            way = np.maximum(0.0, np.sqrt(dx * dx + dy * dy) - limits.reach_m)
        return self._arrivals_s(dx, dy, way) + self.idle

    def catch(self) -> Float64Array:
        """Whoever is nearest to a target, and within reach, catches it: what that is worth, (N, C)."""
        distance = self.distance + self.absent
        caught = (distance.min(axis=2) < self.limits.reach_m) & self.alive
        if not caught.any():
            return np.zeros(caught.shape[:2])
        self.alive &= ~caught
        return self._worth_of(distance.argmin(axis=2), caught)

    def still_to_come(self) -> Float64Array:
        """What the targets that are left are worth to those who will reach them first: (N, C)."""
        races = self._races_s()
        soon = self.weights.steps * STEP_S + races.min(axis=2)
        return self._worth_of(races.argmin(axis=2), np.exp(-self.weights.discount * soon) * self.alive)

    def _worth_of(self, winners: NDArray[np.intp], counts: Any) -> Float64Array:
        """What targets are worth, (N, C), of which so many go to these hunters, (N, C, K)."""
        worth: Float64Array = (counts * self.worth[self.rows, winners]).sum(axis=2)
        return worth

    def own_ground(self) -> Float64Array:
        """The share of the spawn area that the hunter, or a team-mate, would reach first: (N, C)."""
        x, y = spawn_area(self.limits, GROUND)
        dx, dy = x - self.x[..., None], y - self.y[..., None]
        arrivals = self._arrivals_s(dx, dy, np.sqrt(dx * dx + dy * dy))
        share: Float64Array = (arrivals.min(axis=2) < (arrivals + self.strangers).min(axis=2)).mean(axis=2)
        return share

    def costs(self) -> Float64Array:
        """What each hunter decides by, (N, C, H, K): when it wins a race, or LOST and by how much it loses it; infinite
        for what it does not run at all.
        """
        races = self._races_s()
        late = races - races.min(axis=2, keepdims=True)
        cost: Float64Array = np.where(late > 0.0, LOST + late, races) + np.where(self.alive, 0.0, np.inf)[:, :, None]
        cost[:, :, 0][late[:, :, 0] > self.weights.lost_by_s] = np.inf
        return cost

    def move(self, *, waits: bool) -> None:
        """A step: everybody drives to the race that it wins soonest, or else loses by least; targets drive on.

        Args:
            waits: whether the hunter is still on its way where it goes to a place to wait.
        """
        cost = self.costs()
        choice, drives = cost.argmin(axis=3), cost.min(axis=3) < np.inf
        x, y = (c[self.rows, self.copies, self.numbers, choice] for c in (self.meet_x, self.meet_y))
        for goal, meet in ((self.goal_x, self.meet_x), (self.goal_y, self.meet_y)):
            goal[:, : self.targets] = meet[:, :, 0].diagonal(axis1=1, axis2=2)
        sent = np.full(self.goal_x.shape, waits)
        sent[:, : self.targets] = self.alive.diagonal(axis1=1, axis2=2)
        x[:, :, 0], y[:, :, 0] = np.where(sent, self.goal_x, x[:, :, 0]), np.where(sent, self.goal_y, y[:, :, 0])
        drives[:, :, 0] |= sent
        self._drive(x - self.x, y - self.y, drives)
        if self.limits.targets_move:
            self._move_targets()
        self._look()

    def _drive(self, dx: Float64Array, dy: Float64Array, drives: BoolArray) -> None:
        """All hunters, (N, C, H), by as much; as `drive`, but that who is quick enough turns in one step."""
        fastest = self.limits.max_turn_rate_radps
        bearing = np.arctan2(self.cosine * dy - self.sine * dx, self.cosine * dx + self.sine * dy)
        distance = np.sqrt(dx * dx + dy * dy)
        turn = np.where(drives, np.minimum(np.maximum(bearing, -fastest * STEP_S), fastest * STEP_S), 0.0)
        diameter = (distance + self.limits.reach_m / 2) / np.maximum(1e-6, np.abs(np.sin(bearing)))
        speed = np.minimum(self.limits.max_speed_mps, np.minimum(fastest / 2 * diameter, distance / STEP_S))
        way = np.where(drives & (np.abs(bearing) < np.pi / 2), STEP_S * speed, 0.0)
        self.x += way * np.cos(self.heading + 0.5 * turn)
        self.y += way * np.sin(self.heading + 0.5 * turn)
        self.heading += turn

    def _move_targets(self) -> None:
        """By a step, as they drive now."""
        self.target_x = np.clip(self.target_x + STEP_S * self.target_vx, 0.0, self.limits.side_m)
        self.target_y = np.clip(self.target_y + STEP_S * self.target_vy, 0.0, self.limits.side_m)


def drive_to(scene: Scene, choice: NDArray[np.intp]) -> Float64Array:
    """The commands (N, 2) that bring each hunter to the place that it chose: flat out to a target, ahead of it where it
    moves, and at rest where it waits.
    """
    limits, rows, targets = scene.limits, np.arange(len(choice)), scene.alive.shape[1]
    x, y = scene.goal_x[rows, choice], scene.goal_y[rows, choice]
    waits = choice >= targets
    if limits.targets_move and targets:
        target, distance = np.minimum(choice, targets - 1), np.hypot(x - scene.x[:, 0], y - scene.y[:, 0])
        lead = np.where(waits, 0.0, np.minimum(LONGEST_LEAD_S, distance / limits.max_speed_mps))
        x, y = x + lead * scene.target_vx[rows, target], y + lead * scene.target_vy[rows, target]
    if limits.view_radius_m is not None or limits.view_angle_deg < 360.0:
        ahead_x, ahead_y = on_the_circle(scene)
        blind = ~scene.alive.any(axis=1)
        x, y, waits = np.where(blind, ahead_x, x), np.where(blind, ahead_y, y), waits & ~blind
    return drive(scene, x, y, waits)


def drive(scene: Scene, x: Float64Array, y: Float64Array, waits: BoolArray) -> Float64Array:
    """The commands (N, 2) that bring each hunter to a point [m], and to rest there where it waits."""
    limits = scene.limits
    dx, dy = x - scene.x[:, 0], y - scene.y[:, 0]
    cosine, sine = np.cos(scene.heading[:, 0]), np.sin(scene.heading[:, 0])
    bearing = np.arctan2(cosine * dy - sine * dx, cosine * dx + sine * dy)
    distance = np.hypot(dx, dy)
    turn = np.clip(TURN_GAIN * bearing / limits.max_turn_rate_radps, -1.0, 1.0)
    # the circle that is tangent to the heading and passes half a reach from the point
    diameter = (distance + limits.reach_m / 2) / np.maximum(1e-6, np.abs(np.sin(bearing)))
    arrives = np.where(waits, BRAKE_GAIN * distance, distance / (limits.control_period_ms / 1000.0))
    speed = np.minimum(limits.max_turn_rate_radps / 2 * diameter, arrives) / limits.max_speed_mps
    ahead = np.abs(bearing) < np.pi / 2  # else driving would only lead away
    commands = np.stack((np.where(ahead, np.minimum(1.0, speed), 0.0), turn), axis=1)
    commands[waits & (distance < THERE_M)] = 0.0
    return commands


def on_the_circle(scene: Scene) -> tuple[Float64Array, Float64Array]:
    """A place further on, on a circle about the arena's middle, to see most of it in turn: x and y [m], (N,) each."""
    middle = scene.limits.side_m / 2
    angle = np.arctan2(scene.y[:, 0] - middle, scene.x[:, 0] - middle) + FURTHER_RAD
    radius = CIRCLE * scene.limits.side_m
    return middle + radius * np.cos(angle), middle + radius * np.sin(angle)

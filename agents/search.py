"""Looks ahead: simulates driving to each possible place, with predicted rivals, and goes to the best one.

The view is copied into a simplified arena, once for each place that the hunter could go to: the targets, some points
to wait at, and its own place. All copies are simulated for some seconds, in which every hunter runs its best race. Then
the hunter goes to the place of the greatest worth. The work of a move has a limit that depends neither on the view nor
on the machine's speed, so a match can be repeated. The agent keeps no state and draws no random numbers.
"""

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.geometry import own_frame, world_frame
from catch_arena.policy import Limits, View
from catch_arena.steering import LONGEST_LEAD_S, arc_speed_mps, drive_each, spawn_at, travel_s

Float64Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STEP_S: Final = 0.2
"""Step of the look-ahead [s], coarser than the arena's own."""
TARGETS: Final = 8
RIVALS: Final = 7
"""Most rivals that are simulated, the nearest first; TARGETS is the same for targets."""
WAITING: Final = 3
"""Points along each side of the grid of waiting places in the spawn area."""
GROUND: Final = 5
"""Points along each side of the grid over which shares of the spawn area are counted."""
LOOKS_AT_GROUND: Final = 3
"""Number of times in a look-ahead that the share of the ground is counted."""
LOST: Final = 1e3
"""Cost above every time [s], so that a lost race ranks after all that are won."""
SLOWEST_GAIN_MPS: Final = 0.1
"""Least speed at which a hunter gains on a fleeing target [m/s]: even a fast one is caught at a wall, or by two."""
THERE_M: Final = 0.02
"""Distance from its waiting place below which a hunter stands still [m]."""
CIRCLE: Final = 0.3
"""Radius, as a part of the side, of the circle on which a hunter with a partial view drives if it sees no target."""
FURTHER_RAD: Final = 0.8
"""Angle to the next point on that circle [rad]."""
SHOWN: Final = 0.5
"""Share of the arena that the circle must show; if it shows less, the hunter drives in lanes over the whole arena."""


class Weights(NamedTuple):
    """Length of a look-ahead, and the weights of its results."""

    steps: int = 9
    """Number of simulated steps of STEP_S each."""
    discount: float = 0.25
    """Rate of the exponential discount of later catches [1/s]."""
    rivals: float = 0.33
    """Cost of a rival's catch [own catches]."""
    ground: float = 0.6
    """Worth of the whole ground [own catches]."""
    lost_by_s: float = 0.4
    """Largest delay with which the hunter still runs a race after its first goal [s]."""
    wait_s: float = 1.0
    """Time for which the hunter goes to a waiting place [s]."""


class Agent:
    """Agent that drives to the place of the greatest expected worth, and decides again in every step."""

    control = "velocity"
    weights = Weights()

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state and draws no random numbers."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        observations = np.array([view.observation], dtype=np.float32)
        masks = np.zeros((1, 0), dtype=np.int8)
        speed, turn = self.act_batch(BatchView(observations, masks, view.limits))[0].tolist()
        return speed, turn

    def act_batch(self, view: BatchView) -> NDArray[np.float64]:
        """Return the commands of N hunters, (N, 2); `act` gives the same command for one."""
        scene = Scene.of(view)
        return drive_to(scene, look_ahead(scene, self.weights).argmax(axis=1))


class Scene(NamedTuple):
    """Views of N hunters in the world frame, each with H hunters (itself first), K targets and C places to go to.

    The places are the targets, the hunter's own place, and its waiting places.
    """

    limits: Limits
    x: Float64Array
    """Hunters' places (N, H) [m]; `y` has the same shape."""
    y: Float64Array
    heading: Float64Array
    """Hunters' headings (N, H) [rad]."""
    here: BoolArray
    """Mask (N, H) of the hunters that exist."""
    races: BoolArray
    """Mask (N, H) of the hunters that race: itself, and rivals that move."""
    mates: BoolArray
    """Mask (N, H) of the hunter itself and its team-mates."""
    target_x: Float64Array
    """Targets' places (N, K) [m]; `target_y` has the same shape."""
    target_y: Float64Array
    target_vx: Float64Array
    """Targets' velocities (N, K) [m/s], 0 if targets do not move; `target_vy` has the same shape."""
    target_vy: Float64Array
    alive: BoolArray
    """Mask (N, K) of the targets that are alive."""
    goal_x: Float64Array
    """Places to go to (N, C) [m]; `goal_y` has the same shape."""
    goal_y: Float64Array
    open: BoolArray
    """Mask (N, C) of the places that can be chosen: not absent targets, nor those as good as caught."""

    @classmethod
    def of(cls, view: BatchView) -> "Scene":
        """Return the scene of a batch of views."""
        limits, own = view.limits, view.own
        x, y, cosine, sine = (
            np.asarray(c, np.float64)[:, None] for c in (own.x, own.y, own.heading_cos, own.heading_sin)
        )
        heading = np.arctan2(sine, cosine)
        count = max(1, min(TARGETS, int((view.targets.present > 0).sum(axis=1).max(initial=0))))
        targets = {name: np.asarray(c[:, :count], np.float64) for name, c in view.targets._asdict().items()}
        rivals = {name: np.asarray(c[:, :RIVALS], np.float64) for name, c in view.rivals._asdict().items()}
        alive, itself = targets["present"] > 0, np.ones((len(x), 1), np.bool_)
        present = rivals["present"] > 0
        target_dx, target_dy = world_frame(cosine, sine, targets["forward"], targets["left"])
        rival_dx, rival_dy = world_frame(cosine, sine, rivals["forward"], rivals["left"])
        target_x, target_y = x + target_dx, y + target_dy
        vx, vy = np.zeros(alive.shape), np.zeros(alive.shape)
        if limits.targets_move:
            ahead, aside = (targets["linear_velocity"] * targets[name] for name in ("heading_cos", "heading_sin"))
            vx, vy = world_frame(cosine, sine, ahead, aside)
        waiting_x, waiting_y = (np.broadcast_to(c, (len(x), c.size)) for c in spawn_area(limits, WAITING))
        mates = rivals["mate"] > 0 if limits.teams else np.zeros(present.shape, np.bool_)
        scene = cls(
            limits=limits,
            x=np.concatenate((x, x + rival_dx), axis=1),
            y=np.concatenate((y, y + rival_dy), axis=1),
            heading=np.concatenate(
                (heading, heading + np.arctan2(rivals["heading_sin"], rivals["heading_cos"])), axis=1
            ),
            here=np.concatenate((itself, present), axis=1),
            races=np.concatenate((itself, present & (rivals["linear_velocity"] != 0)), axis=1),
            mates=np.concatenate((itself, mates), axis=1),
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
    """R3.2: return x and y [m] of a grid of points in the spawn area, (points * points,) each."""
    places = spawn_at(np.arange(points, dtype=np.float64), points, limits)
    return np.repeat(places, points), np.tile(places, points)


def look_ahead(scene: Scene, weights: Weights) -> Float64Array:
    """Return the worth of each place to go to, (N, C); -inf for those that are not open."""
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
    """Simplified arena: C copies of each of N scenes; in each copy the hunter goes to another place first.

    The clock is coarse. No targets appear, since their places are unknown. Instead the share of the ground that is the
    hunter's own counts, since new targets are spread evenly (R3.2).

    Every hunter drives to the point at which it would meet a moving target, and a fleeing target takes longer. If
    targets are at least as fast as hunters, or are prey, hunters drive straight to a target's current place.
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
        self.leads = self.limits.targets_move and slower and not self.limits.prey  # prey can turn at any time
        self.rows, self.copies = np.arange(count)[:, None, None], np.arange(copies)[:, None]
        self.numbers = np.arange(self.x.shape[2])
        self._look()

    def _look(self) -> None:
        """Update the geometry from each hunter to each target, (N, C, H, K), after they have moved."""
        self.dx = self.target_x[:, :, None] - self.x[..., None]
        self.dy = self.target_y[:, :, None] - self.y[..., None]
        self.distance = np.sqrt(self.dx * self.dx + self.dy * self.dy)
        self.cosine, self.sine = np.cos(self.heading), np.sin(self.heading)
        if self.limits.targets_move:
            self.target_vx, self.target_vy = self._target_velocities()
        self.meet_x, self.meet_y = self._meetings()

    def _target_velocities(self) -> tuple[Float64Array, Float64Array]:
        """R3.10: return targets' velocities (N, C, K): straight on, or away from a hunter nearer than the alarm."""
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
        """Return the points (N, C, H, K) at which each hunter meets each target if that keeps its velocity."""
        x, y = (np.broadcast_to(c[:, :, None], self.distance.shape) for c in (self.target_x, self.target_y))
        if not self.leads:
            return x, y
        lead, side = np.minimum(LONGEST_LEAD_S, self.distance / self.limits.max_speed_mps), self.limits.side_m
        return (
            np.clip(x + lead * self.target_vx[:, :, None], 0.0, side),
            np.clip(y + lead * self.target_vy[:, :, None], 0.0, side),
        )

    def _arrivals_s(self, dx: Float64Array, dy: Float64Array, way: Float64Array) -> Float64Array:
        """Return times to arrive [s]: the way at full speed, and half of the turn; infinite for absent hunters."""
        forward, left = own_frame(self.cosine[..., None], self.sine[..., None], dx, dy)
        return travel_s(way, np.arctan2(left, forward), self.limits) + self.absent

    def _races_s(self) -> Float64Array:
        """Return the time for each hunter to reach each target [s], (N, C, H, K); infinite if it does not race."""
        limits, dx, dy, distance = self.limits, self.dx, self.dy, self.distance
        if self.leads and not limits.alarm_m:
            dx, dy = self.meet_x - self.x[..., None], self.meet_y - self.y[..., None]
            distance = np.sqrt(dx * dx + dy * dy)
        way = np.maximum(0.0, distance - limits.reach_m)
        if self.leads and limits.alarm_m:  # on a fleeing target a hunter gains only by the difference of speeds
            gains = max(SLOWEST_GAIN_MPS, limits.max_speed_mps - limits.target_speed_mps)
            chase = np.maximum(0.0, np.minimum(distance, limits.alarm_m) - limits.reach_m)
            way = way + limits.target_speed_mps / gains * chase
        return self._arrivals_s(dx, dy, way) + self.idle

    def catch(self) -> Float64Array:
        """Let the nearest hunter within reach catch each target; return the worth of these catches, (N, C)."""
        distance = self.distance + self.absent
        caught = (distance.min(axis=2) < self.limits.reach_m) & self.alive
        if not caught.any():
            return np.zeros(caught.shape[:2])
        self.alive &= ~caught
        return self._worth_of(distance.argmin(axis=2), caught)

    def still_to_come(self) -> Float64Array:
        """Return the discounted worth, (N, C), of the remaining targets, each for the hunter that reaches it first."""
        races = self._races_s()
        soon = self.weights.steps * STEP_S + races.min(axis=2)
        return self._worth_of(races.argmin(axis=2), np.exp(-self.weights.discount * soon) * self.alive)

    def _worth_of(self, winners: NDArray[np.intp], counts: Any) -> Float64Array:
        """Return the worth, (N, C), of targets weighted by `counts` that go to `winners`, (N, C, K) each."""
        worth: Float64Array = (counts * self.worth[self.rows, winners]).sum(axis=2)
        return worth

    def own_ground(self) -> Float64Array:
        """Return the share of the spawn area, (N, C), that the hunter or a team-mate would reach first."""
        x, y = spawn_area(self.limits, GROUND)
        dx, dy = x - self.x[..., None], y - self.y[..., None]
        arrivals = self._arrivals_s(dx, dy, np.sqrt(dx * dx + dy * dy))
        share: Float64Array = (arrivals.min(axis=2) < (arrivals + self.strangers).min(axis=2)).mean(axis=2)
        return share

    def costs(self) -> Float64Array:
        """Return the cost of each race, (N, C, H, K): the time if the hunter wins it, else LOST plus the delay [s].

        Races that the hunter does not run cost infinity.
        """
        races = self._races_s()
        late = races - races.min(axis=2, keepdims=True)
        cost: Float64Array = np.where(late > 0.0, LOST + late, races) + np.where(self.alive, 0.0, np.inf)[:, :, None]
        cost[:, :, 0][late[:, :, 0] > self.weights.lost_by_s] = np.inf
        return cost

    def move(self, *, waits: bool) -> None:
        """Simulate a step: every hunter drives to the race that it wins soonest, or loses by least; targets drive on.

        Args:
            waits: whether a hunter that goes to a waiting place is still on its way.
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
        """Drive hunters, (N, C, H), along offsets [m] like `steering.drive`, but turn fully in one step if possible."""
        fastest = self.limits.max_turn_rate_radps
        forward, left = own_frame(self.cosine, self.sine, dx, dy)
        bearing, distance = np.arctan2(left, forward), np.sqrt(dx * dx + dy * dy)
        turn = np.where(drives, np.minimum(np.maximum(bearing, -fastest * STEP_S), fastest * STEP_S), 0.0)
        arc_speed = arc_speed_mps(distance, np.maximum(1e-6, np.abs(np.sin(bearing))), self.limits)
        speed = np.minimum(self.limits.max_speed_mps, np.minimum(arc_speed, distance / STEP_S))
        way = np.where(drives & (np.abs(bearing) < np.pi / 2), STEP_S * speed, 0.0)
        self.x += way * np.cos(self.heading + 0.5 * turn)
        self.y += way * np.sin(self.heading + 0.5 * turn)
        self.heading += turn

    def _move_targets(self) -> None:
        """Move targets for one step at their current velocities."""
        self.target_x = np.clip(self.target_x + STEP_S * self.target_vx, 0.0, self.limits.side_m)
        self.target_y = np.clip(self.target_y + STEP_S * self.target_vy, 0.0, self.limits.side_m)


def drive_to(scene: Scene, choice: NDArray[np.intp]) -> Float64Array:
    """Return the commands (N, 2) that bring each hunter to its chosen place.

    It drives at full speed to a target, or ahead of a moving one, and comes to rest at a waiting place.
    """
    limits, rows, targets = scene.limits, np.arange(len(choice)), scene.alive.shape[1]
    x, y = scene.goal_x[rows, choice], scene.goal_y[rows, choice]
    waits = choice >= targets
    if limits.targets_move and targets:
        target, distance = np.minimum(choice, targets - 1), np.hypot(x - scene.x[:, 0], y - scene.y[:, 0])
        lead = np.where(waits, 0.0, np.minimum(LONGEST_LEAD_S, distance / limits.max_speed_mps))
        x, y = x + lead * scene.target_vx[rows, target], y + lead * scene.target_vy[rows, target]
    if limits.view_radius_m is not None or limits.view_angle_deg < 360.0:
        ahead_x, ahead_y = on_the_circle(scene) if circle_is_enough(limits) else on_the_lanes(scene)
        blind = ~scene.alive.any(axis=1)
        x, y, waits = np.where(blind, ahead_x, x), np.where(blind, ahead_y, y), waits & ~blind
    dx, dy, heading = x - scene.x[:, 0], y - scene.y[:, 0], scene.heading[:, 0]
    commands = drive_each(*own_frame(np.cos(heading), np.sin(heading), dx, dy), waits, limits)
    distance = np.hypot(dx, dy)
    in_one_step = distance / (limits.control_period_ms / 1000.0) / limits.max_speed_mps
    commands[:, 0] = np.where(waits, commands[:, 0], np.minimum(commands[:, 0], in_one_step))
    commands[waits & (distance < THERE_M)] = 0.0
    return commands


def circle_is_enough(limits: Limits) -> bool:
    """Return whether a hunter that drives on the circle sees most of the arena in turn."""
    radius_m = math.inf if limits.view_radius_m is None else limits.view_radius_m
    return 4.0 * math.pi * CIRCLE * radius_m >= SHOWN * limits.side_m


def on_the_lanes(scene: Scene) -> tuple[Float64Array, Float64Array]:
    """Return x and y [m], (N,) each, of the next point on a closed path that shows the whole arena in turn.

    The path goes through the middles of square cells that a view covers. It follows one column of cells down, and comes
    back up in lanes through the other columns, to the right and to the left in turn.
    """
    side, radius = scene.limits.side_m, scene.limits.view_radius_m or scene.limits.side_m
    cells = 2 * math.ceil(side / (4.0 * radius))  # along each side, an even number
    size = side / cells
    column, row = (np.clip(np.floor(at[:, 0] / size), 0, cells - 1) for at in (scene.x, scene.y))
    to_right = row % 2 == 0
    last = np.where(to_right, column == cells - 1, (column == 1) & (row < cells - 1))
    returns = (column == 0) & (row > 0)
    step_x = np.where(returns | last, 0.0, np.where(to_right, 1.0, -1.0))
    step_y = np.where(returns, -1.0, np.where(last, 1.0, 0.0))
    return (column + step_x + 0.5) * size, (row + step_y + 0.5) * size


def on_the_circle(scene: Scene) -> tuple[Float64Array, Float64Array]:
    """Return x and y [m], (N,) each, of the next point on a circle that shows most of the arena in turn."""
    middle = scene.limits.side_m / 2
    angle = np.arctan2(scene.y[:, 0] - middle, scene.x[:, 0] - middle) + FURTHER_RAD
    radius = CIRCLE * scene.limits.side_m
    return middle + radius * np.cos(angle), middle + radius * np.sin(angle)

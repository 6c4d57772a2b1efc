"""The typed, read-only picture of one arena, in the world frame: what people, rendering and the service view read."""

from dataclasses import dataclass, field

from catch_arena.messages import Pose, Turtle, TurtleArray
from catch_arena.verdicts import Ruling


@dataclass(frozen=True, slots=True)
class HunterState:
    """One hunter; metres, radians in [-pi, pi), metres and radians per second."""

    name: str
    """The PettingZoo name, `hunter_{seat}`."""
    x: float
    y: float
    theta: float
    linear_velocity: float
    """The velocity that moves it (after R2.5's limits), signed; turtlesim's habit: not reduced by a wall."""
    angular_velocity: float
    score: int
    active_target: str | None = None
    """The target that it chose for its hosted controller, or asked for under full control."""
    at_wall: bool = False
    """R2.3: it was clamped to the arena during the last step."""
    withdrawn: bool = False
    """R1.6: it takes no further part."""
    team: int = field(kw_only=True)
    """R11.1: its team, as its place among the config's `team_seats`; without teams its seat."""

    @property
    def pose(self) -> Pose:
        """The hunter as turtlesim publishes it: its linear velocity has no sign."""
        return Pose(self.x, self.y, self.theta, abs(self.linear_velocity), self.angular_velocity)


@dataclass(frozen=True, slots=True)
class TargetState:
    """One alive target; theta is in [0, 2 pi), as drawn (R3.2), where targets move in [-pi, pi); metres and radians."""

    name: str
    number: int
    """R3.4: its identity, from 1, never used again in the episode."""
    x: float
    y: float
    theta: float
    spawned_ms: int
    """When it appeared [ms since reset]."""
    linear_velocity: float = 0.0
    angular_velocity: float = 0.0
    at_wall: bool = False
    """R2.3, R3.9: it was clamped to the arena during the last step."""
    prey: str | None = None
    """R12.1: which prey plays it, None for nobody."""


@dataclass(frozen=True, slots=True)
class PreyState:
    """One prey; where it is, and how it moves, its target says."""

    name: str
    """The PettingZoo name, `prey_{index}`."""
    target: str | None
    """The target that it plays, by name; None while it is out (R12.3)."""
    times_caught: int
    """Its score (R12.5)."""
    caught_ms: int | None = None
    """While it is out, the time of the state on which it was caught [ms since reset]."""
    caught_by: int | None = None
    """The seat of the hunter that caught it in the step that led here."""
    withdrawn: bool = False
    """R12.5: it takes no further part, and stands still."""


@dataclass(frozen=True, slots=True)
class World:
    """One arena at a step's boundary."""

    time_ms: int
    step: int
    """How many steps have been played."""
    side_m: float
    hunters: tuple[HunterState, ...]
    """By seat."""
    targets: tuple[TargetState, ...]
    """The alive ones, in spawning order (R8.2)."""
    rulings: tuple[Ruling, ...] = ()
    """The verdicts of the step that led here, by seat."""
    spawned: int = 0
    """How many targets have appeared so far: catches of all hunters + alive (R5.8)."""
    prey: tuple[PreyState, ...] = ()
    """By index."""

    @property
    def team_scores(self) -> tuple[int, ...]:
        """R11.1: the sums of the scores of each team's hunters; without teams, each hunter's."""
        scores = [0] * (1 + max(hunter.team for hunter in self.hunters))
        for hunter in self.hunters:
            scores[hunter.team] += hunter.score
        return tuple(scores)

    @property
    def alive_turtles(self) -> TurtleArray:
        """R8.2: the alive list as the exercise's spawner publishes it."""
        return TurtleArray(tuple(Turtle(target.name, target.x, target.y, target.theta) for target in self.targets))

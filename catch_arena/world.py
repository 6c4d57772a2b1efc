"""Typed, read-only state of one arena in the world frame, for people and rendering."""

from dataclasses import dataclass
from typing import NamedTuple

from catch_arena.messages import Pose, Turtle, TurtleArray
from catch_arena.verdicts import Ruling


class HunterState(NamedTuple):
    """State of one hunter, in m, m/s, rad/s; theta in rad in [-pi, pi)."""

    name: str
    """Name in PettingZoo's interface, `hunter_{seat}`."""
    x: float
    y: float
    theta: float
    linear_velocity: float
    """Signed velocity after R2.5's limits; a wall does not reduce it, as in turtlesim."""
    angular_velocity: float
    score: int
    team: int
    """R11.1: index of the hunter's team in the config's `team_seats`; without teams, its seat."""
    active_target: str | None = None
    """Name of the target chosen for the hosted controller, or asked for under full control; None without one."""
    at_wall: bool = False
    """R2.3: true if the hunter was clamped to the arena during the last step."""
    withdrawn: bool = False
    """R1.6, R1.7: true if the hunter takes no further part."""

    @property
    def pose(self) -> Pose:
        """Pose as turtlesim publishes it: the linear velocity has no sign."""
        return Pose(self.x, self.y, self.theta, abs(self.linear_velocity), self.angular_velocity)


class TargetState(NamedTuple):
    """State of one alive target, in m, m/s, rad/s; theta in rad in [0, 2 pi) (R3.2), or [-pi, pi) if targets move."""

    name: str
    number: int
    """R3.4: number of the target, from 1, unique in the episode."""
    x: float
    y: float
    theta: float
    spawned_ms: int
    """Time at which the target appeared [ms since reset]."""
    linear_velocity: float = 0.0
    angular_velocity: float = 0.0
    at_wall: bool = False
    """R2.3, R3.9: true if the target was clamped to the arena during the last step."""
    prey: str | None = None
    """R12.1: name of the prey that plays the target; None if no prey does."""


class PreyState(NamedTuple):
    """State of one prey; its pose and velocities are those of its target."""

    name: str
    """Name in PettingZoo's interface, `prey_{index}`."""
    target: str | None
    """Name of the target that the prey plays; None while it is out (R12.3)."""
    times_caught: int
    """Number of times that the prey was caught, which is its score (R12.5)."""
    caught_ms: int | None = None
    """Time of the state on which the prey was caught [ms since reset]; None while it is in play."""
    caught_by: int | None = None
    """Seat of the hunter that caught the prey in the last step; None if no hunter did."""
    withdrawn: bool = False
    """R12.5: true if the prey takes no further part, and stands still."""


@dataclass(frozen=True, slots=True)
class World:
    """State of one arena between two steps."""

    time_ms: int
    step: int
    """Number of steps played so far."""
    side_m: float
    hunters: tuple[HunterState, ...]
    """States of the hunters, by seat."""
    targets: tuple[TargetState, ...]
    """States of the alive targets, in spawning order (R8.2)."""
    rulings: tuple[Ruling, ...] = ()
    """Rulings of the last step, by seat."""
    spawned: int = 0
    """Number of targets that have appeared so far: catches of all hunters plus alive targets (R5.8)."""
    prey: tuple[PreyState, ...] = ()
    """States of the prey, by index."""

    @property
    def team_scores(self) -> tuple[int, ...]:
        """R11.1: sum of the scores of each team's hunters; without teams, each hunter's score."""
        scores = [0] * (1 + max(hunter.team for hunter in self.hunters))
        for hunter in self.hunters:
            scores[hunter.team] += hunter.score
        return tuple(scores)

    @property
    def alive_turtles(self) -> TurtleArray:
        """R8.2: alive targets as the exercise's spawner publishes them."""
        return TurtleArray(tuple(Turtle(target.name, target.x, target.y, target.theta) for target in self.targets))

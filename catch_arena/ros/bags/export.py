"""A recorded match as the messages that a ROS 2 bus would have carried while it was played."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from catch_arena.core.physics import TICK_MS
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Pose, Turtle, TurtleArray
from catch_arena.replay import Replay
from catch_arena.replay.motion import StepMotion, step_motion
from catch_arena.ros.bags.files import Storage, TimedMessage, whole_bag
from catch_arena.ros.bags.service_events import (
    REQUEST_RECEIVED,
    RESPONSE_SENT,
    TOPIC,
    EventInfo,
    ServiceEvent,
    event_of,
)
from catch_arena.ros.middleware.graph_names import (
    ALIVE_TURTLES,
    CATCH_TURTLE,
    RULINGS,
    TURTLE,
    catch_turtle_of,
    pose_of,
)
from catch_arena.ros.middleware.interfaces import RULING, Interfaces, MessageType, Time
from catch_arena.ros.middleware.rulings import ruling_message
from catch_arena.verdicts import Ruling
from catch_arena.world import HunterState

_NS: Final = 1_000_000
"""In a millisecond."""


class BusTopics:
    """Which topics a match has; one hunter alone goes by the exercise's name, turtle1."""

    def __init__(self, replay: Replay, interfaces: Interfaces) -> None:
        hunters = replay.config.hunter_names
        turtles = (TURTLE,) if len(hunters) == 1 else hunters
        self.hunters = hunters
        self.poses = tuple(pose_of(turtle) for turtle in turtles)
        services = (CATCH_TURTLE,) if len(hunters) == 1 else tuple(map(catch_turtle_of, hunters))
        self.requests = tuple(f"{service}{TOPIC}" for service in services)
        self.pose, self.alive = interfaces.pose, interfaces.turtle_array
        self.request = event_of(interfaces.catch_turtle)

    def all(self) -> Iterator[tuple[str, MessageType]]:
        """Each with its type."""
        yield from ((topic, self.pose) for topic in self.poses)
        yield ALIVE_TURTLES, self.alive
        yield from ((topic, self.request) for topic in self.requests)
        yield RULINGS, RULING


def export_bag(
    replay: Replay,
    folder: Path,
    storage: Storage,
    interfaces: Interfaces,
    *,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Write a match as a bag.

    Args:
        replay: the recorded match.
        folder: the bag's.
        storage: the kind of its file.
        interfaces: the packages of the types.
        force: whether it takes the place of a bag that is there.
        progress: called with (steps written, steps in all).

    Returns:
        how many messages it has.

    Raises:
        ReplayError: where the replay does not play as recorded.
        OutputError: where the bag cannot be written; nothing half-written is left.
    """
    topics = BusTopics(replay, interfaces)
    count = 0
    with whole_bag(folder, storage, force=force) as bag:
        for topic, kind in topics.all():
            bag.announce(topic, kind)
        for one in bus_messages(replay, topics, progress):
            bag.write(one)
            count += 1
    return count


def bus_messages(
    replay: Replay, topics: BusTopics, progress: Callable[[int, int], None] | None = None
) -> Iterator[TimedMessage]:
    """The messages in their order; time is the match's own, from 0."""
    worlds = replay.worlds()
    before = next(worlds)
    yield from _poses(topics, 0, before.hunters, [(hunter.x, hunter.y, hunter.theta) for hunter in before.hunters])
    yield TimedMessage(0, ALIVE_TURTLES, topics.alive, before.alive_turtles)
    numbers = [0] * len(topics.hunters)
    for after in worlds:
        motion = step_motion(before, after)
        rulings = [*after.rulings, *replay.named_rulings(before, after)]
        yield from _judged(topics, before.time_ms, rulings, numbers)
        if {target.number for target in before.targets} - {target.number for target in after.targets}:
            yield _alive(topics, motion, before.time_ms)
        yield from _moved(topics, motion, always=replay.config.targets_move)
        before = after
        if progress is not None:
            progress(after.step, replay.steps)


def _judged(topics: BusTopics, time_ms: int, rulings: Sequence[Ruling], numbers: list[int]) -> Iterator[TimedMessage]:
    """R1.4: the requests of a step are judged on the state at its beginning."""
    for ruling in rulings:
        seat, asked = ruling.hunter, ruling
        if ruling.target is not None:  # a rank that no target has is nothing that could be asked by name
            name = str(ruling.target).encode(errors="backslashreplace").decode()  # half of a pair is no UTF-8
            asked = replace(ruling, target=name)
            numbers[seat] += 1
            for event in _call(asked, time_ms, numbers[seat]):
                yield TimedMessage(time_ms * _NS, topics.requests[seat], topics.request, event)
        yield TimedMessage(time_ms * _NS, RULINGS, RULING, ruling_message(asked, time_ms, topics.hunters))


def _call(ruling: Ruling, time_ms: int, number: int) -> tuple[ServiceEvent, ServiceEvent]:
    """The request as it came in, and the response as it went out."""
    seconds, rest = divmod(time_ms, 1000)
    stamp = Time(seconds, rest * _NS)
    client = (ruling.hunter + 1).to_bytes(16, "big")
    return (
        ServiceEvent(EventInfo(REQUEST_RECEIVED, stamp, client, number), (CatchTurtleRequest(str(ruling.target)),), ()),
        ServiceEvent(EventInfo(RESPONSE_SENT, stamp, client, number), (), (CatchTurtleResponse(ruling.success),)),
    )


def _moved(topics: BusTopics, motion: StepMotion, *, always: bool) -> Iterator[TimedMessage]:
    """A step's ticks with the poses, and the alive list where a target appears; where targets move, also at the end.
    At one instant motion comes first (R1.4).
    """
    before, after = motion.before, motion.after
    first = before.time_ms // TICK_MS
    times = {target.spawned_ms for target in after.targets if target.spawned_ms > before.time_ms}
    times |= {after.time_ms} if always and after.targets else set()
    ticks = range((first + 1) * TICK_MS, after.time_ms + 1, TICK_MS)
    for time_ms in sorted({*times, *ticks}):
        if time_ms % TICK_MS == 0:
            poses = motion.poses[min(time_ms // TICK_MS - first, len(motion.poses) - 1)]
            yield from _poses(topics, time_ms, after.hunters, poses.hunters)
        if time_ms in times:
            yield _alive(topics, motion, time_ms)


def _poses(
    topics: BusTopics,
    time_ms: int,
    hunters: tuple[HunterState, ...],
    poses: "list[tuple[float, float, float]] | tuple[tuple[float, float, float], ...]",
) -> Iterator[TimedMessage]:
    for topic, hunter, (x, y, theta) in zip(topics.poses, hunters, poses, strict=True):
        pose = Pose(x, y, theta, *hunter.pose[3:])
        yield TimedMessage(time_ms * _NS, topic, topics.pose, pose)


def _alive(topics: BusTopics, motion: StepMotion, time_ms: int) -> TimedMessage:
    """R8.2: who is alive, and where, at an instant of a step after its commit."""
    poses = motion.poses[min(time_ms // TICK_MS - motion.before.time_ms // TICK_MS, len(motion.poses) - 1)]
    turtles = tuple(
        Turtle(target.name, *poses.targets[target.number])
        for target in motion.after.targets
        if target.spawned_ms <= time_ms
    )
    return TimedMessage(time_ms * _NS, ALIVE_TURTLES, topics.alive, TurtleArray(turtles))

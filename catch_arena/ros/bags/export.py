"""Export of a recorded match as a bag, with the messages that a ROS 2 bus would have carried while it was played."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from catch_arena.core.physics import TICK_MS
from catch_arena.replay import Replay
from catch_arena.replay.motion import Poses, poses_of, step_motion
from catch_arena.ros.bags.files import BagWriter, Storage, whole_bag
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, RULINGS, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import RULING, Interfaces, RulingMessage
from catch_arena.verdicts import Ruling
from catch_arena.world import HunterState, TargetState, World


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
        folder: the bag's folder.
        storage: the kind of its file.
        interfaces: the packages of the types.
        force: whether it may replace a bag that exists.
        progress: called with (steps written, steps in all).

    Returns:
        the number of its messages.

    Raises:
        ReplayError: if the replay does not play as recorded.
        OutputError: if the bag cannot be written; nothing unfinished is left.
    """
    with whole_bag(folder, storage, force=force) as bag:
        match = _MatchWriter(bag, replay, interfaces)
        worlds = replay.worlds()
        before = next(worlds)
        match.write_poses(0, before.hunters, poses_of(before))
        match.write_alive(0, before.targets, poses_of(before))
        for after in worlds:
            match.write_step(before, after)
            before = after
            if progress is not None:
                progress(after.step, replay.steps)
        return bag.messages


class _MatchWriter:
    """Writer of one match; times are milliseconds of the match. A single hunter has the exercise's name, turtle1."""

    def __init__(self, bag: BagWriter, replay: Replay, interfaces: Interfaces) -> None:
        self._bag, self._replay = bag, replay
        self._turtle = interfaces.turtle.name
        self._hunters = replay.config.hunter_names
        self._poses = [pose_of(turtle) for turtle in ([TURTLE] if len(self._hunters) == 1 else self._hunters)]
        for topic in self._poses:
            bag.announce(topic, interfaces.pose)
        bag.announce(ALIVE_TURTLES, interfaces.turtle_array)
        bag.announce(RULINGS, RULING)

    def write_step(self, before: World, after: World) -> None:
        """Write one step. R1.4: its requests are judged on the state at its beginning; then comes the motion."""
        motion = step_motion(before, after)
        for ruling in (*after.rulings, *self._replay.named_rulings(before, after)):
            self._write_ruling(before.time_ms, ruling)
        if {target.number for target in before.targets} - {target.number for target in after.targets}:
            self.write_alive(before.time_ms, after.targets, motion.poses[0])
        first = before.time_ms // TICK_MS
        lists = {target.spawned_ms for target in after.targets if target.spawned_ms > before.time_ms}
        if self._replay.config.targets_move and after.targets:
            lists.add(after.time_ms)
        for time_ms in sorted({*lists, *range((first + 1) * TICK_MS, after.time_ms + 1, TICK_MS)}):
            poses = motion.poses[min(time_ms // TICK_MS - first, len(motion.poses) - 1)]
            if time_ms % TICK_MS == 0:
                self.write_poses(time_ms, after.hunters, poses)
            if time_ms in lists:
                self.write_alive(time_ms, after.targets, poses)

    def write_poses(self, time_ms: int, hunters: Sequence[HunterState], poses: Poses) -> None:
        """Write the pose of each hunter."""
        for topic, hunter, pose in zip(self._poses, hunters, poses.hunters, strict=True):
            self._bag.write(topic, time_ms, *pose, *hunter.pose[3:])

    def write_alive(self, time_ms: int, targets: Sequence[TargetState], poses: Poses) -> None:
        """R8.2: write the list of the targets that have appeared."""
        alive = [target for target in targets if target.spawned_ms <= time_ms]
        turtles = [self._bag.make(self._turtle, target.name, *poses.targets[target.number]) for target in alive]
        self._bag.write(ALIVE_TURTLES, time_ms, turtles)

    def _write_ruling(self, time_ms: int, ruling: Ruling) -> None:
        """Write a ruling; half of a surrogate pair in a name is no UTF-8, and is written as an escape."""
        if ruling.target is not None:
            ruling = replace(ruling, target=str(ruling.target).encode(errors="backslashreplace").decode())
        self._bag.write(RULINGS, time_ms, *RulingMessage.of(ruling, time_ms, self._hunters))

"""Captures of prey (chapter 12): catcher, distance and return of each."""

from catch_arena.explanation.facts import Capture, PreySummary
from catch_arena.explanation.seats import prey_labels
from catch_arena.replay import Replay
from catch_arena.world import World


class PreyRecord:
    """Captures of a match and a summary of each prey, collected world by world."""

    def __init__(self, replay: Replay) -> None:
        self._period_ms = replay.config.control_period_ms
        self._last: World | None = None
        self._open: dict[int, Capture] = {}
        self.captures: list[Capture] = []
        self.by_target: dict[str, str] = {}
        """Label of the prey by the name of each target that it has played."""
        self.summaries = [PreySummary(index, name) for index, name in enumerate(prey_labels(replay))]

    def note(self, world: World) -> None:
        """Add the next world of the match."""
        last, self._last = self._last, world
        for summary, now in zip(self.summaries, world.prey, strict=True):
            if now.target is not None:
                self.by_target[now.target] = summary.name
        if last is None:
            return
        for summary, then, now in zip(self.summaries, last.prey, world.prey, strict=True):
            if now.withdrawn and summary.withdrawn_ms is None:
                summary.withdrawn_ms = last.time_ms
            if then.target is not None and now.caught_by is not None:
                self._note_capture(summary.index, last, world, now.caught_by)
            elif then.target is not None and not now.withdrawn:
                summary.in_play_ms += self._period_ms
            summary.times_caught, summary.out = now.times_caught, now.target is None
            if now.target is not None and summary.index in self._open:
                capture = self._open.pop(summary.index)
                capture.returned_ms, capture.returned_as = world.time_ms, now.target
                summary.returns += 1

    def _note_capture(self, index: int, before: World, after: World, seat: int) -> None:
        target = next(state for state in before.targets if state.name == before.prey[index].target)
        distance = next((ruling.distance_um for ruling in after.rulings if ruling.hunter == seat), None)
        in_play_ms = before.time_ms - target.spawned_ms
        capture = Capture(index, after.step, before.time_ms, seat, target.name, distance, in_play_ms)
        self._open[index] = capture
        self.captures.append(capture)

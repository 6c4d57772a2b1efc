"""Reading of arenas in memory, for people and for the digest: worlds, rulings, and views of the chunks by content."""

import hashlib
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core import rows
from catch_arena.core.memory import Sections, settings_in
from catch_arena.core.state import ABSENT, ALL_OPTIONS, regions_of
from catch_arena.core.vectors import LANES
from catch_arena.verdicts import NO_REQUEST, Ruling, Verdict
from catch_arena.world import HunterState, PreyState, TargetState, World


def row_of(offset: int) -> int:
    """Return the row at one of core/rows.py's offsets, which count numbers, LANES to a row."""
    return offset // LANES


_HUNTER_DIGEST: Final = np.array(rows.HUNTER_DIGEST) // LANES
"""A.8: rows of a hunter that the digest reads, in its order."""
_RULING: Final = slice(row_of(rows.RULING[0]), row_of(rows.RULING[-1]) + 1)
"""Rows of a hunter's answer."""


class ArenaReader:
    """Arenas of one config in memory, and what people read in them."""

    config: ArenaConfig
    num_arenas: int

    def _bind_views(self, sections: Sections) -> None:
        """Bind views of the chunks, each [chunk, ..., row, lane]; writing to a view writes to the arena."""
        config, chunks = self.config, sections.chunks
        settings = settings_in(sections.settings, ALL_OPTIONS)
        first_hunter, first_target, first_prey, end = map(row_of, regions_of(settings))
        moving, number = config.targets_move, len(chunks)
        self._fields = chunks.reshape(number, end, LANES)
        """All rows; the arena's own come first: [chunk, row, lane]."""
        of_hunters, of_targets = self._fields[:, first_hunter:first_target], self._fields[:, first_target:first_prey]
        self._hunters = of_hunters.reshape(number, config.hunters, rows.HUNTER_ROWS, LANES)
        """Rows of the hunters: [chunk, seat, row, lane]."""
        self._targets = of_targets.reshape(number, config.max_targets, row_of(settings.slot_size), LANES)
        """Rows of the target slots: [chunk, slot, row, lane]."""
        self._prey = self._fields[:, first_prey:].reshape(number, config.prey, rows.PREY_ROWS, LANES)
        """Rows of prey: [chunk, index, row, lane]."""
        self._target_orders = sections.target_orders.reshape(number, config.hunters, config.targets_seen, LANES)
        """Slots in the order in which each seat sees the targets: [chunk, seat, rank, lane]."""
        self._target_digest = np.array(rows.MOVING_TARGET_DIGEST if moving else rows.TARGET_DIGEST) // LANES
        """A.8: rows of a slot that the digest reads, in its order."""
        self.ruling_rows = self._hunters[0, :, _RULING, 0]
        """R5.6: answers of the first arena in its last step: (H, 4). Columns: the target's number, 0 for none; verdict;
        distance [micrometres] and winner's seat, -1 for none. Verdict 0 is no request; ignore the other columns then.
        """
        self.caught_by = self._prey[0, :, row_of(rows.CAUGHT_BY), 0]
        """R12.3: seat that caught each prey of the first arena in its last step, -1 for none: (P,)."""

    def _rows_of(self, arena: int) -> tuple[NDArray[np.float64], ...]:
        """Return the rows of one arena: its own, (ARENA_ROWS,), and those of each hunter, alive target and prey, as
        (H, HUNTER_ROWS), (T, rows of a slot) and (P, PREY_ROWS).
        """
        chunk, lane = divmod(arena, LANES)
        own = self._fields[chunk, : rows.ARENA_ROWS, lane]
        targets = self._targets[chunk, : int(own[row_of(rows.ALIVE)]), :, lane]
        return own, self._hunters[chunk, :, :, lane], targets, self._prey[chunk, :, :, lane]

    def rulings(self, arena: int) -> tuple[Ruling, ...]:
        """R5.6: return the verdicts of the last step with their evidence, by seat."""
        own, hunters, _, _ = self._rows_of(arena)
        found, steps = [], int(own[row_of(rows.STEP)])
        for seat, (number, verdict, distance, winner) in enumerate(hunters[:, _RULING].tolist()):
            if verdict == NO_REQUEST:
                continue
            step = steps if verdict == Verdict.MATCH_OVER else steps - 1
            target = self.config.target_name(int(number)) if number else None
            found.append(Ruling.of_numbers(verdict, seat, target, distance, winner, step))
        return tuple(found)

    def world(self, arena: int = 0) -> World:
        """Return one arena as a World, with names."""
        config = self.config
        own, hunters, targets, prey = self._rows_of(arena)
        played = _numbers_played(targets, prey).tolist() if config.prey else []
        players = dict(zip(played, config.prey_names, strict=True))
        return World(
            time_ms=int(own[row_of(rows.TIME)]),
            step=int(own[row_of(rows.STEP)]),
            side_m=config.side_m,
            hunters=tuple(
                HunterState(
                    name=name,
                    x=x,
                    y=y,
                    theta=theta,
                    linear_velocity=speed,
                    angular_velocity=turn_rate,
                    score=int(score),
                    active_target=config.target_name(int(active)) if active else None,
                    at_wall=at_wall > 0,
                    withdrawn=withdrawn > 0,
                    team=team,
                )
                for name, team, (x, y, theta, speed, turn_rate, _, _, active, score, at_wall, withdrawn) in zip(
                    config.hunter_names, config.team_by_seat, hunters.take(_HUNTER_DIGEST, axis=1).tolist(), strict=True
                )
            ),
            targets=tuple(
                TargetState(
                    name=config.target_name(int(number)),
                    number=int(number),
                    x=x,
                    y=y,
                    theta=theta,
                    spawned_ms=int(appeared),
                    linear_velocity=motion[0] if motion else 0.0,
                    angular_velocity=motion[1] if motion else 0.0,
                    at_wall=bool(motion and motion[2]),
                    prey=players.get(number),
                )
                for number, x, y, theta, appeared, *motion in targets.take(self._target_digest, axis=1).tolist()
            ),
            rulings=self.rulings(arena),
            spawned=int(own[row_of(rows.SPAWNED)]),
            prey=tuple(
                PreyState(
                    name=name,
                    target=config.target_name(int(number)) if number else None,
                    times_caught=int(me[row_of(rows.TIMES_CAUGHT)]),
                    caught_ms=None if number else int(me[row_of(rows.CAUGHT_AT)]),
                    caught_by=None if me[row_of(rows.CAUGHT_BY)] < 0 else int(me[row_of(rows.CAUGHT_BY)]),
                    withdrawn=me[row_of(rows.PREY_WITHDRAWN)] > 0,
                )
                for name, number, me in zip(config.prey_names, played, prey.tolist(), strict=True)
            ),
        )

    def rank_of(self, arena: int, seat: int, name: str) -> int:
        """R7.1: return the rank at which a seat sees the target of that name; 0 if it does not see it."""
        names = [self.config.target_name(number) for number in self.numbers_seen(seat)[arena] if number]
        return names.index(name) + 1 if name in names else 0

    def numbers_seen(self, seat: int) -> NDArray[np.int64]:
        """R7.1: return the numbers of the targets that a seat sees in each arena, by rank: (B, ranks), 0 for none."""
        slots = self._target_orders[:, seat].swapaxes(1, 2)
        none = np.cumsum(slots == ABSENT, axis=2) > 0
        numbers = self._targets[:, :, row_of(rows.NUMBER)].swapaxes(1, 2)
        seen = np.take_along_axis(numbers, np.where(none, 0, slots).astype(np.int64), axis=2)
        return np.where(none, 0.0, seen).astype(np.int64).reshape(-1, slots.shape[2])[: self.num_arenas]

    def active_targets(self) -> NDArray[np.int64]:
        """R4.1: return the numbers of the hunters' active targets in each arena: (B, H), 0 for none."""
        numbers = self._hunters[:, :, row_of(rows.ACTIVE)].swapaxes(1, 2).astype(np.int64)
        return numbers.reshape(-1, self.config.hunters)[: self.num_arenas]

    def seeds(self) -> NDArray[np.uint64]:
        """Return the seeds of the current episodes: (B,)."""
        high, low = (
            self._fields[:, row_of(offset)].reshape(-1).astype(np.uint64) for offset in (rows.SEED_HIGH, rows.SEED_LOW)
        )
        return ((high << np.uint64(32)) | low)[: self.num_arenas]

    def state(self, arena: int = 0) -> NDArray[np.float64]:
        """A.8: return the numbers of one arena's state, (n,), in the order in which the digest reads them."""
        own, hunters, targets, prey = self._rows_of(arena)
        parts = [own[: rows.ARENA_DIGEST_ROWS], hunters.take(_HUNTER_DIGEST, axis=1)]
        parts.append(targets.take(self._target_digest, axis=1))
        if len(prey):
            times = prey[:, [row_of(rows.TIMES_CAUGHT), row_of(rows.CAUGHT_AT)]]
            parts.append(np.column_stack((_numbers_played(targets, prey), times)))
        return np.concatenate([part.reshape(-1) for part in parts])

    def digest(self, arena: int = 0) -> bytes:
        """A.8: return the digest of one arena's state, eight bytes."""
        return hashlib.blake2b(self.state(arena).astype("<f8", copy=False).tobytes(), digest_size=8).digest()


def _numbers_played(targets: NDArray[np.float64], prey: NDArray[np.float64]) -> NDArray[np.float64]:
    """R12.1: return the numbers of the targets that prey plays, 0 for prey that is out: (P,)."""
    numbers = np.append(targets[:, row_of(rows.NUMBER)], 0.0)  # the last one is for NO_TARGET, -1
    return numbers[prey[:, row_of(rows.PREY_SLOT)].astype(np.int64)]

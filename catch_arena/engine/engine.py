"""The engine: owns the memory of a batch of arenas, and calls the core. It checks seeds and saved states; envs and
service check all other arguments.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core import dropouts, placing, rows, spawner, state, tick
from catch_arena.core.arbiter import REQUEST_COLUMNS, RequestTable
from catch_arena.core.compiling import ALL_S, COMMON_S, announced
from catch_arena.core.controllers import CONTROLS
from catch_arena.core.memory import Bytes, Sections, copy_of, lay_out, sections_of
from catch_arena.core.prey import withdraw_prey_at
from catch_arena.core.state import ABSENT, ALL_OPTIONS
from catch_arena.core.vectors import LANES, PLAYED, SINGLE, WIDE
from catch_arena.engine.core_settings import limits_by_seat, settings_of, sizes_of
from catch_arena.engine.reading import RULING, row_of, rulings_in, state_in, views_of, world_in
from catch_arena.equality import EqualByBits
from catch_arena.errors import ConfigError
from catch_arena.seeding import checked_seed
from catch_arena.text import shortened
from catch_arena.threads import run_in_threads
from catch_arena.verdicts import Ruling
from catch_arena.world import World

_HUNTERS_A_PART: Final = 4096
"""Least number of hunters that a thread plays at a time: fewer are not worth the cost of waking it."""
_NO_RESETS: Final = np.zeros((0, 2), dtype=np.uint64)
NO_CHOICES: Final = np.zeros((0, 0), dtype=np.int64)
NO_COMMANDS: Final = np.zeros((0, 0, 2), dtype=np.float32)
_NO_REQUESTS: Final = np.zeros((0, REQUEST_COLUMNS), dtype=np.int64)
_NO_ACTIONS: Final = (NO_CHOICES, NO_COMMANDS, _NO_REQUESTS)
_LAYOUT: Final = hashlib.blake2b(
    repr([(name, row) for name, row in vars(rows).items() if name.isupper()]).encode(), digest_size=8
).hexdigest()
"""Digest of core/rows.py, which says what each row of a saved state means."""


@dataclass(frozen=True, slots=True, eq=False)
class SavedState(EqualByBits):
    """State of a batch of arenas, or of one of them. Two are equal if every bit is equal."""

    config: str
    """Digest of the arena's config."""
    layout: str
    """Digest of the rows that an arena has in this version."""
    num_envs: int | None
    """Number of arenas in the batch; None for a single row."""
    controls: NDArray[np.int8]
    """Controls of the hunters, as `VectorArena.set_controls` takes them: (B, H)."""
    memory: tuple[NDArray[Any], ...]
    """Parts of the engine's memory: the arenas, and the results of their last step."""
    finished: tuple[NDArray[Any], ...]
    """Records of finished episodes, of an engine with `auto_reset`; otherwise empty."""


class Engine:
    """A batch of arenas of one config, played in lockstep.

    Args:
        config: the arena's settings.
        num_arenas: B, from 1 up.
        with_infos: whether to keep R6.2's and R12.5's parts of the rewards, which infos hold.
        auto_reset: whether an arena whose episode ends begins the next one immediately.
        num_threads: the greatest number of threads that play.
        any_control: whether `controls` may differ by arena.

    `rewards`, `observations` and so on are arrays of `core.memory.Sections`, which gives their shapes. They change with
    every step: copy the arrays that must last. Of N agents the H hunters come first, by seat, and then the P prey, by
    index.
    """

    def __init__(
        self,
        config: ArenaConfig,
        num_arenas: int = 1,
        *,
        with_infos: bool = True,
        auto_reset: bool = False,
        num_threads: int = 1,
        any_control: bool = False,
    ) -> None:
        settings = settings_of(config, any_control=any_control)
        options = state.options_of(settings)
        width, view_width = (SINGLE, SINGLE) if num_arenas == 1 else (PLAYED, WIDE)
        self._kind = (width, view_width, options)
        """First argument of `tick.run`, whose type determines the compiled code."""
        self.config = config
        self._config_digest = config.digest  # computed once, since it takes longer than saving
        self.num_arenas = num_arenas
        self._options: dict[str, Any] = {
            "with_infos": with_infos,
            "auto_reset": auto_reset,
            "num_threads": num_threads,
            "any_control": any_control,
        }
        self._num_chunks = -(-num_arenas // LANES)
        self._num_parts = self._num_chunks * LANES * config.hunters // _HUNTERS_A_PART
        self.num_threads = max(1, min(num_threads, self._num_parts))
        sizes = sizes_of(config, settings, num_arenas, self.num_threads, with_infos=with_infos, auto_reset=auto_reset)
        memory, sections = lay_out(sizes)
        sections.settings[:] = settings
        if config.hunter_poses is not None:
            sections.start_poses[:] = config.hunter_poses
        sections.controls[:] = [CONTROLS[control] for control in config.controls]
        sections.limits[:] = limits_by_seat(config)
        sections.teams[:] = [min(config.team_seats[team]) for team in config.team_by_seat]
        sections.team_seats[:] = [min(seats) for seats in config.teams or ()]
        self._bind_sections(memory, sections)
        rules, seconds = ("all rules", ALL_S) if options == ALL_OPTIONS else ("the common rules", COMMON_S)
        with announced(f"{rules} for {'one arena' if num_arenas == 1 else 'a batch'}", seconds):
            tick.run(self._kind, memory, 0, 0, 0, _NO_RESETS, True, *_NO_ACTIONS)  # plays no chunk
        spare = num_arenas - (self._num_chunks - 1) * LANES  # lanes without an arena hold only withdrawn hunters
        self.views.hunters[-1, :, row_of(rows.WITHDRAWN), spare:] = 1.0

    def _bind_sections(self, memory: Bytes, sections: Sections) -> None:
        """Bind the memory's sections to attributes."""
        self._memory = memory
        self.controls = sections.controls
        self.rewards = sections.rewards
        self.parts = sections.parts
        self.prey_parts = sections.prey_parts
        self.observations = sections.observations
        self.masks = sections.masks
        self.ends = sections.ends
        self.active = sections.active.view(np.bool_)
        self.team_scores = sections.team_scores
        self.final_observations = sections.final_observations
        self.final_masks = sections.final_masks
        self.lengths = sections.lengths
        self.records = sections.records
        self.views = views_of(self.config, sections)
        self.ruling_rows = self.views.hunters[0, :, RULING, 0]
        """R5.6: answers of the first arena in its last step, (H, 4); `reading.RULING` gives the columns."""
        self.caught_by = self.views.prey[0, :, row_of(rows.CAUGHT_BY), 0]
        """R12.3: seat that caught each prey of the first arena in its last step, -1 for none: (P,)."""
        of_results, of_records = map(Sections._fields.index, ("rewards", "final_observations"))
        self._results = [section for section in sections[of_results:of_records] if section.size]
        self._records = [section for section in sections[of_records:] if section.size]

    # playing

    def reset(
        self, seeds: Sequence[int] | NDArray[np.uint64], arenas: Sequence[int] | NDArray[np.int64] | None = None
    ) -> None:
        """Begin an episode in all arenas, or in the named ones; one seed in [0, 2^64) for each.

        Raises:
            ConfigError: if the numbers of seeds and arenas differ, and for a seed outside [0, 2^64).
        """
        chosen = np.arange(self.num_arenas) if arenas is None else np.asarray(arenas, dtype=np.int64)
        if len(seeds) != len(chosen):
            raise ConfigError(f"seeds must be one for each of {len(chosen)} arenas, got {len(seeds)}")
        if not isinstance(seeds, np.ndarray) or seeds.dtype != np.uint64:
            seeds = np.array([checked_seed(seed) for seed in seeds], dtype=np.uint64)
        self._clear_results(chosen)
        resets = np.stack((chosen.astype(np.uint64), seeds), axis=1)
        self._observe(chosen, resets)

    def step(
        self,
        choices: NDArray[np.int64],
        commands: NDArray[np.float32],
        requests: RequestTable = _NO_REQUESTS,
    ) -> None:
        """R1.4: play one step of every arena.

        Args:
            choices: (B, H) int64: the rank chosen under target control, or requested under full control, 0 for none.
            commands: (B, N, 2) float32 in [-1, 1]: linear and angular velocity as fractions of the limits. An array
                that no agent reads may be empty.
            requests: for a single arena, further requests by name: a table of `arbiter`, (H + n, columns), whose first
                H rows are for the requests of `choices` and of the hosted controllers. Of the others REQUEST_SEAT and
                REQUEST_TARGET (a slot, or a code for none) are read, and all other columns are written.
        """
        kind, memory, chunks, playing = self._kind, self._memory, self._num_chunks, True
        if 0 < len(requests) < self.config.hunters:
            raise ConfigError(f"requests must begin with {self.config.hunters} rows, one a hunter, got {len(requests)}")
        if self.num_threads == 1:
            tick.run(kind, memory, 0, 0, chunks, _NO_RESETS, playing, choices, commands, requests)
            return

        def play(thread: int, part: int) -> None:
            first, stop = part * chunks // self._num_parts, (part + 1) * chunks // self._num_parts
            tick.run(kind, memory, thread, first, stop, _NO_RESETS, playing, choices, commands, requests)

        run_in_threads(self.num_threads, self._num_parts, play)

    def _clear_results(self, arenas: NDArray[np.int64]) -> None:
        for results in (self.rewards, self.ends, self.parts, self.prey_parts):
            if results.size:
                results[arenas] = 0

    def _observe(self, arenas: Sequence[int] | NDArray[np.int64], resets: NDArray[np.uint64] = _NO_RESETS) -> None:
        """Begin episodes, and write the observations and masks of the chunks that contain these arenas."""
        kind, memory, playing = self._kind, self._memory, False
        for chunk in sorted(set((np.asarray(arenas) // LANES).tolist())):
            tick.run(kind, memory, 0, chunk, chunk + 1, resets, playing, *_NO_ACTIONS)
            resets = _NO_RESETS  # all episodes have begun

    def withdraw(self, arena: int, agent: int) -> None:
        """R1.6, R12.5: withdraw an agent, one of N: it stands still from now on, and the others do not see a hunter."""
        if agent < self.config.hunters:
            dropouts.withdraw_at(self._memory, arena, agent)
        else:
            withdraw_prey_at(self._memory, arena, agent - self.config.hunters)
        self._observe([arena])

    def place(
        self,
        arena: int,
        hunters: Sequence[tuple[float, float, float]],
        targets: Sequence[tuple[float, float]],
        prey: Sequence[tuple[float, float, float]] | None = None,
        ages: Sequence[float] = (),
    ) -> None:
        """Set up a position for tests and lessons: hunters at rest at these poses, and these targets instead of the
        alive targets that no prey plays.

        The targets take the next spawn numbers, in their order, and appear now with theta 0, or have the given `ages`
        [s], rounded to the millisecond. Prey stays as it is, under its numbers; if poses of all prey are given, prey in
        play is at rest there.
        """
        placed = np.zeros((len(targets), 5))
        placed[:, :2] = np.reshape(targets, (-1, 2))
        if ages:
            placed[:, 4] = _in_ms(np.array(ages))
        # 0.0 is added so that no zero is negative
        poses, poses_of_prey = (np.reshape(given or (), (-1, 3)) + 0.0 for given in (hunters, prey))
        placing.place(self._memory, arena, poses, poses_of_prey, placed + 0.0)
        self._observe([arena])

    def place_batch(
        self,
        arenas: NDArray[np.int64],
        hunters: NDArray[np.float64],
        targets: NDArray[np.float64],
        steps: NDArray[np.int64],
    ) -> None:
        """Begin episodes with these bodies instead of those that the seeds give; later draws still follow from the
        seeds. Do not call it for arenas with prey.

        Args:
            arenas: (n,), all different.
            hunters: (n, H, 4): x, y, theta, linear velocity; NaN for a withdrawn hunter.
            targets: (n, T, 5): x, y, theta, linear velocity, age [s]; NaN for no target. Their numbers count from 1,
                the oldest first.
            steps: (n,), number of steps already played.
        """
        placed = targets + 0.0
        placed[:, :, 4] = _in_ms(targets[:, :, 4])
        there = ~np.isnan(targets[:, :, 0])
        oldest_first = np.argsort(np.where(there, -placed[:, :, 4], np.inf), axis=1, kind="stable")  # R8.2
        placed = np.take_along_axis(placed, oldest_first[:, :, None], axis=1)
        placing.place_all(self._memory, arenas, hunters + 0.0, placed, steps)
        self._clear_results(arenas)
        self._observe(arenas)

    def spawn(self, arena: int, x: float, y: float, theta: float) -> int:
        """R8.1: add a target outside the timer and return its number, the next one; return 0 in a full arena (R3.5)."""
        number = spawner.spawn_at(self._memory, arena, x + 0.0, y + 0.0, theta + 0.0)  # so that no zero is negative
        self._observe([arena])
        return number

    def kill(self, arena: int, number: int) -> bool:
        """R8.1: remove an alive target, which no longer counts as spawned (R5.8). Return False if it is not alive, or
        if prey plays it, since such a target is never killed.
        """
        killed = spawner.kill(self._memory, arena, number)
        self._observe([arena])
        return killed

    # reading

    def world(self, arena: int = 0) -> World:
        """Return one arena as a World, with names."""
        return world_in(self.views, arena)

    def rulings(self, arena: int) -> tuple[Ruling, ...]:
        """R5.6: return the verdicts of the last step with their evidence, by seat."""
        return rulings_in(self.views, arena)

    def state(self, arena: int = 0) -> NDArray[np.float64]:
        """A.8: return the numbers of one arena's state, (n,), in the order in which the digest reads them."""
        return state_in(self.views, arena)

    def digest(self, arena: int = 0) -> bytes:
        """A.8: return the digest of one arena's state, eight bytes."""
        return hashlib.blake2b(self.state(arena).astype("<f8", copy=False).tobytes(), digest_size=8).digest()

    def numbers_seen(self, seat: int) -> NDArray[np.int64]:
        """R7.1: return the numbers of the targets that a seat sees in each arena, by rank: (B, ranks), 0 for none."""
        slots = self.views.target_orders[:, seat].swapaxes(1, 2)
        none = np.cumsum(slots == ABSENT, axis=2) > 0
        numbers = self.views.targets[:, :, row_of(rows.NUMBER)].swapaxes(1, 2)
        seen = np.take_along_axis(numbers, np.where(none, 0, slots).astype(np.int64), axis=2)
        return np.where(none, 0.0, seen).astype(np.int64).reshape(-1, slots.shape[2])[: self.num_arenas]

    def active_targets(self) -> NDArray[np.int64]:
        """R4.1: return the numbers of the hunters' active targets in each arena: (B, H), 0 for none."""
        numbers = self.views.hunters[:, :, row_of(rows.ACTIVE)].swapaxes(1, 2).astype(np.int64)
        return numbers.reshape(-1, self.config.hunters)[: self.num_arenas]

    def seeds(self) -> NDArray[np.uint64]:
        """Return the seeds of the current episodes: (B,)."""
        high, low = (
            self.views.fields[:, row_of(offset)].reshape(-1).astype(np.uint64)
            for offset in (rows.SEED_HIGH, rows.SEED_LOW)
        )
        return ((high << np.uint64(32)) | low)[: self.num_arenas]

    # saving

    def save(self, arena: int | None = None) -> SavedState:
        """R10.2: return the state of all arenas with the results of their last step, and the records of ended episodes,
        which only `auto_reset` keeps. `restore` takes it, in this engine or in one of an equal config and size.

        Args:
            arena: the arena whose state is returned, alone; any arena of an engine of an equal config can take it.
        """
        controls, memory, finished = self._parts(arena)
        return SavedState(
            self._config_digest,
            _LAYOUT,
            self.num_arenas if arena is None else None,
            controls.copy(),
            tuple(part.copy() for part in memory),
            tuple(part.copy() for part in finished),
        )

    def restore(self, saved: SavedState, arena: int | None = None) -> None:
        """Continue from a saved state.

        Args:
            saved: the saved state. Its records are ignored if this engine or the other has no `auto_reset`.
            arena: the arena that continues, if the state is that of a single one.

        Raises:
            ConfigError: for anything else, such as a state of another config or of another version of this package.
        """
        if not isinstance(saved, SavedState):
            raise ConfigError(f"saved must be a state that a batch's save() returned, got {shortened(saved)}")
        if getattr(saved, "layout", None) != _LAYOUT:  # a state that was pickled earlier may lack it
            raise ConfigError("saved must come from this version of Catch Arena, got the state of another version")
        if saved.config != self._config_digest:
            raise ConfigError(
                f"saved must come from an arena with an equal config (digest {self._config_digest}), got {saved.config}"
            )
        num_envs = self.num_arenas if arena is None else None
        if saved.num_envs != num_envs:
            wanted, got = ("a single row" if size is None else f"{size} arenas" for size in (num_envs, saved.num_envs))
            raise ConfigError(f"a saved state must be that of {wanted} here, got that of {got}")
        controls, memory, finished = self._parts(arena)
        if [(part.shape, part.dtype) for part in saved.memory] != [(part.shape, part.dtype) for part in memory]:
            size, found = (sum(part.nbytes for part in parts) for parts in (memory, saved.memory))
            raise ConfigError(f"saved must come from an arena of the same kind, with {size} bytes, got {found} bytes")
        if (saved.controls != controls).any():
            self.require_any_control()
        controls[:] = saved.controls
        for part, content in zip([*memory, *finished], [*saved.memory, *saved.finished], strict=False):
            part[:] = content

    def require_any_control(self) -> None:
        """Raise a ConfigError unless the arenas may differ in their hunters' controls."""
        if not self._options["any_control"]:
            raise ConfigError("the arenas of this batch cannot differ in their controls: make it with any_control=True")

    def _parts(self, arena: int | None) -> tuple[NDArray[np.int8], list[NDArray[Any]], list[NDArray[Any]]]:
        """Return the parts of the memory of which a `SavedState` has copies: those of one arena, or of all."""
        every: tuple[Any, Any, Any] = slice(None), slice(None), slice(None)
        chunk, lane, row = every if arena is None else (*divmod(arena, LANES), slice(arena, arena + 1))
        state: list[NDArray[Any]] = [self.views.fields[chunk, :, lane], self.views.target_orders[chunk, :, :, lane]]
        memory, finished = ([part[row] for part in parts] for parts in (self._results, self._records))
        return self.controls[row], state + memory, finished

    def __deepcopy__(self, memo: object) -> "Engine":
        """Return an independent engine in the same state."""
        twin = object.__new__(Engine)
        twin.__dict__.update(self.__dict__)
        memory = copy_of(self._memory)
        twin._bind_sections(memory, sections_of(memory))
        return twin

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the constructor's arguments and the memory: arrays share it, which a plain pickle would not keep."""
        return partial(Engine, **self._options), (self.config, self.num_arenas), self._memory

    def __setstate__(self, state: Bytes) -> None:
        """Copy the memory of another engine of the same config and size."""
        self._memory[:] = state


def _in_ms(ages: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ages in seconds as whole milliseconds."""
    return np.floor(1000.0 * ages + 0.5)

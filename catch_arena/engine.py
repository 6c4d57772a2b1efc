"""The engine: owns the memory of a batch of arenas, and calls the core. Trusts its callers; the doors (envs,
arbitration) check what people give.
"""

import gc
import hashlib
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.compiling import progress_shown
from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig
from catch_arena.core import spawner, tick
from catch_arena.core import state as rows
from catch_arena.core.arbiter import POLICIES, REQUEST_COLUMNS, RequestTable
from catch_arena.core.compiler import quick_typing
from catch_arena.core.controllers import CONTROLS
from catch_arena.core.episodes import RECORD_COLUMNS
from catch_arena.core.jit import INTERPRETED
from catch_arena.core.math import PI, sincos, wrap
from catch_arena.core.memory import DTYPES, Bytes, Sections, copy_of, lay_out, place_of, sections_of, whole_lines, zeros
from catch_arena.core.prey import PREY_PART_NAMES, PREY_RECORD_COLUMNS
from catch_arena.core.random import advance_seeds, derive_row_seeds
from catch_arena.core.ranking import selection_network
from catch_arena.core.rewards import PART_NAMES
from catch_arena.core.state import LANES, MOTIONS, SeatLimits, Settings, first_prey_row, slot_rows, target_order_rows
from catch_arena.core.vectors import HALF, SINGLE, WIDE
from catch_arena.core.workspace import scratch_shapes
from catch_arena.errors import ConfigError
from catch_arena.layout import hunters_seen_by_prey, prey_seen_by_prey, prey_width, width
from catch_arena.seeding import checked_seed, fresh_seed
from catch_arena.threads import Threads
from catch_arena.verdicts import NO_REQUEST, Ruling, Verdict
from catch_arena.world import HunterState, PreyState, TargetState, World


def _row(place: int) -> int:
    """Which row one of core/state.py's places is: there they are in numbers, LANES to a row."""
    return place // LANES


_HUNTER_DIGEST: Final = [_row(row) for row in rows.HUNTER_DIGEST]
_HUNTERS_A_PART: Final = 4096
"""How many hunters a thread plays at a time, at least: fewer are not worth the waking."""
_NO_RESETS: Final = np.zeros((0, 2), dtype=np.uint64)
_NO_CHOICES: Final = np.zeros((0, 0), dtype=np.int64)
_NO_COMMANDS: Final = np.zeros((0, 0, 2), dtype=np.float32)
_NO_REQUESTS: Final = np.zeros((0, REQUEST_COLUMNS), dtype=np.int64)
_NO_PREY: Final = np.zeros(0)
_NO_NETWORK: Final = np.zeros((0, 2), dtype=np.int64)
_network: Final = cache(selection_network)
"""For engines that copy it."""
_SEES_ALL_ROUND: Final = -2.0
"""Below every cosine."""
_SPAWN_LOW_M: Final = 0.5
_SPAWN_WALL_M: Final = TURTLESIM_SIDE_M - 10.5


def settings_of(config: ArenaConfig, *, progress_wanted: bool, any_control: bool = False) -> Settings:
    """The scalars of a config, as the core reads them."""
    high = config.side_m - _SPAWN_WALL_M
    return Settings(
        hunters=config.hunters,
        max_targets=config.max_targets,
        targets_seen=config.targets_seen,
        hunters_seen=config.hunters_seen,
        policy=POLICIES[config.policy],
        progress_wanted=int(progress_wanted or config.rewards.progress != 0.0),
        any_control=int(any_control),
        target_budget=math.inf if config.target_budget is None else float(config.target_budget),
        spawned_in_full=_spawned_in_full(config),
        side_m=float(config.side_m),
        kp_v=float(config.gains.kp_v),
        ki_v=float(config.gains.ki_v),
        kp_w=float(config.gains.kp_w),
        ki_w=float(config.gains.ki_w),
        period_ms=float(config.control_period_ms),
        period_s=config.control_period_ms / 1000.0,
        time_limit_ms=float(config.time_limit_ms),
        spawn_period_ms=float(config.spawn_period_ms) if config.spawning else math.inf,
        spawn_low_m=_SPAWN_LOW_M,
        spawn_high_m=high,
        spawn_last_m=math.nextafter(high, 0.0),
        start_radius_m=0.3 * config.side_m if config.start_radius_m is None else float(config.start_radius_m),
        initial_targets=config.initial_targets,
        slot_size=slot_rows(config.targets_move) * LANES,
        targets_move=int(config.targets_move),
        target_motion=MOTIONS[config.target_motion],
        target_speed_mps=float(config.target_speed_mps),
        target_turn_rate_radps=float(config.target_turn_rate_radps),
        wander_period_ms=float(config.wander_period_ms),
        alarm_um=float(config.alarm_um),
        prey=config.prey,
        prey_min_speed_mps=-float(config.target_speed_mps) if config.reverse else 0.0,
        prey_returns_ms=math.inf if config.prey_returns_ms is None else float(config.prey_returns_ms),
        prey_distance_wanted=int(progress_wanted or config.prey_rewards.gained != 0.0),
        partial_view=int(config.partial_view),
        view_radius_um=math.inf if config.view_radius_um is None else float(config.view_radius_um),
        view_cosine=_SEES_ALL_ROUND
        if config.view_angle_deg == 360.0
        else sincos(config.view_angle_deg * PI / 360.0)[1],
        view_noise_m=float(config.view_noise_m),
        dropout_rate=float(config.dropout_rate),
        kill_down_rate=float(config.faults.kill_down),
        kill_refused_rate=float(config.faults.kill_refused),
        spawn_down_rate=float(config.faults.spawn_down),
        spawn_refused_rate=float(config.faults.spawn_refused),
        catch_weight=float(config.rewards.catch),
        rival_catch_weight=float(config.rewards.rival_catch),
        lost_contest_weight=float(config.rewards.lost_contest),
        rejected_request_weight=float(config.rewards.rejected_request),
        progress_weight=float(config.rewards.progress),
        time_weight=float(config.rewards.time),
        has_teams=int(config.teams is not None),
        team_share=0.0 if config.teams is None else float(config.team_share),
        mate_catch_weight=float(config.rewards.mate_catch),
        caught_weight=float(config.prey_rewards.caught),
        survived_weight=float(config.prey_rewards.survived),
        gained_weight=float(config.prey_rewards.gained),
    )


def _spawned_in_full(config: ArenaConfig) -> float:
    """R1.5, R12.6: how many targets have appeared when none will any more."""
    if config.prey and config.prey_returns_s is not None:
        return math.inf
    if not config.spawning:
        return 0.0
    return math.inf if config.target_budget is None else float(config.target_budget)


def limits_of(config: ArenaConfig) -> NDArray[np.float64]:
    """R2.5, R2.7: the limits of every seat, as the core reads them: (H, 4)."""
    limits = zip(config.max_speeds, config.max_turn_rates, config.reaches_um, strict=True)
    return np.array(
        [
            SeatLimits(
                max_speed=float(speed),
                min_speed=-float(speed) if config.reverse else 0.0,
                max_turn_rate=float(turn_rate),
                reach_um=float(reach_um),
            )
            for speed, turn_rate, reach_um in limits
        ]
    )


class Engine:
    """A batch of arenas of one config, played in lockstep.

    Args:
        config: the arena's settings.
        num_arenas: B, from 1 up.
        infos_wanted: whether R6.2's parts are kept beside their sum.
        auto_reset: whether the next episode begins at once where one has ended.
        num_threads: how many may play.
        any_control: whether `controls` may differ by arena.

    All arrays below are the engine's own and change with every step: copy what is to be kept.
    """

    def __init__(
        self,
        config: ArenaConfig,
        num_arenas: int = 1,
        *,
        infos_wanted: bool = True,
        auto_reset: bool = False,
        num_threads: int = 1,
        any_control: bool = False,
    ) -> None:
        _compile_once(one=num_arenas == 1)
        self.config = config
        self.num_arenas = num_arenas
        self.infos_wanted = infos_wanted
        self.auto_reset = auto_reset
        hunters, seen = config.hunters, config.targets_seen
        slot, prey = slot_rows(config.targets_move), config.prey
        prey_begin = first_prey_row(hunters, config.max_targets, slot, seen)
        num_blocks, num_rows = -(-num_arenas // LANES), prey_begin + prey * rows.PREY_ROWS
        self._shares = num_blocks * LANES * hunters // _HUNTERS_A_PART
        self.threads = Threads(max(1, min(num_threads, self._shares)))
        with_infos = num_arenas if infos_wanted else 0
        kept = num_arenas if auto_reset else 0
        seen_by_prey = prey_width(config)
        team_play = config.teams is not None
        columns = max(hunters * width(config), prey * seen_by_prey)
        scratch = scratch_shapes(hunters, prey, num_rows, columns, team_play=team_play)
        memory, sections = lay_out(
            Sections(
                settings=np.array(
                    settings_of(config, progress_wanted=infos_wanted, any_control=any_control), dtype=np.float64
                ),
                start_poses=np.array(config.hunter_poses or (), dtype=np.float64).reshape(-1, 3),
                controls=np.tile(
                    np.array([CONTROLS[control] for control in config.controls], np.int8), (num_arenas, 1)
                ),
                limits=limits_of(config),
                teams=np.array([min(config.team_seats[team]) for team in config.team_by_seat]),
                target_network=_network(config.max_targets, seen),
                # one rank more than is seen: a tie at the edge of the view has to be noticed
                rival_network=_network(hunters, min(hunters, config.hunters_seen + 1)),
                prey_commands=zeros(num_arenas, prey, 2, dtype=np.float32),
                hunter_network=_network(hunters, min(hunters, hunters_seen_by_prey(config) + 1))
                if prey
                else _NO_NETWORK,
                prey_network=_network(prey, min(prey, prey_seen_by_prey(config) + 1)) if prey else _NO_NETWORK,
                blocks=zeros(num_blocks, num_rows * LANES),
                parts=zeros(with_infos, hunters, 1 + len(PART_NAMES)),
                evidence=zeros(with_infos, hunters, len(rows.EVIDENCE)),
                observations=zeros(num_arenas, hunters, width(config), dtype=np.float32),
                masks=zeros(num_arenas, hunters, seen + 1, dtype=np.int8),
                prey_parts=zeros(with_infos, prey, 1 + len(PREY_PART_NAMES)),
                prey_observations=zeros(num_arenas, prey, seen_by_prey, dtype=np.float32),
                ends=zeros(num_arenas, dtype=np.int8),
                rewards=zeros(num_arenas - with_infos, hunters, dtype=np.float32),
                prey_rewards=zeros(num_arenas - with_infos, prey, dtype=np.float32),
                last_observations=zeros(kept, hunters, width(config), dtype=np.float32),
                last_masks=zeros(kept, hunters, seen + 1, dtype=np.int8),
                records=zeros(kept, hunters, RECORD_COLUMNS, dtype=np.float32),
                prey_last_observations=zeros(kept, prey, seen_by_prey, dtype=np.float32),
                prey_records=zeros(kept, prey, PREY_RECORD_COLUMNS, dtype=np.float32),
                **{name: zeros(self.threads.size, *shape, dtype=DTYPES[name]) for name, shape in scratch.items()},
            )
        )
        self._look_at(memory, sections)
        spare = num_arenas - (num_blocks - 1) * LANES
        self._hunters[-1, :, _row(rows.WITHDRAWN), spare:] = 1.0  # in lanes that are no arenas nobody does anything

    def _look_at(self, memory: Bytes, sections: Sections) -> None:
        """Give the parts of the memory their names."""
        self._memory = memory
        self.blocks = sections.blocks
        """The arenas' memory: see core/state.py."""
        self.controls = sections.controls
        """R4.1, R4.4: how each hunter is driven, in the numbers of `controllers.CONTROLS`: (B, H). The config's, until
        somebody writes others; what they read of `choices` and `commands` must then be there.
        """
        self.observations = sections.observations
        """R7.1: (B, H, D)."""
        self.masks = sections.masks
        """R7.2: (B, H, K + 1)."""
        self.rewards: NDArray[Any] = sections.parts[:, :, 0] if self.infos_wanted else sections.rewards
        """R6.2: (B, H), float64 with the parts and float32 without."""
        self.parts = sections.parts[:, :, 1:]
        """R6.2: the parts of the last reward, unweighted, in the order of `rewards.PART_NAMES`: (B, H, 7), or (0, H, 7)
        where they are not wanted.
        """
        self.ends = sections.ends
        """R1.5: how the last step ended each episode: RUNNING, TERMINATED or TRUNCATED of core/state.py, (B,)."""
        self.last_observations = sections.last_observations
        """With auto_reset the last observations of the latest episode that ended in each arena: (B, H, D)."""
        self.last_masks = sections.last_masks
        """And the masks that belong to them: (B, H, K + 1)."""
        self.records = sections.records
        """With auto_reset that episode in figures, in the columns of core/episodes.py: (B, H, RECORD_COLUMNS)."""
        self.prey_observations = sections.prey_observations
        """R12.4: (B, P, E)."""
        self.prey_rewards: NDArray[Any] = sections.prey_parts[:, :, 0] if self.infos_wanted else sections.prey_rewards
        """R12.5: (B, P), as `rewards`."""
        self.prey_parts = sections.prey_parts[:, :, 1:]
        """R12.5: the parts of the last reward, unweighted, in the order of `prey.PREY_PART_NAMES`: (B, P, 3), or
        (0, P, 3) where they are not wanted.
        """
        self.prey_last_observations = sections.prey_last_observations
        """With auto_reset as `last_observations`: (B, P, E)."""
        self.prey_records = sections.prey_records
        """With auto_reset as `records`, in the columns of core/prey.py: (B, P, PREY_RECORD_COLUMNS)."""
        self._prey_commands = sections.prey_commands
        begin, end = place_of("parts", memory), place_of("ends", memory)
        self.outputs = self._memory[begin:end].view(np.float32)
        """`parts`, `evidence`, `observations`, `masks`, `prey_parts` and `prey_observations` as they lie one behind the
        other: copied, all at once.
        """
        self.evidence = sections.evidence
        """R5.6: (B, H, 4), the rows of `state.EVIDENCE`; or (0, H, 4) where infos are not wanted."""
        begin = place_of("blocks", memory)
        self._kept, self._kept_by_all = memory[begin:], place_of("last_observations", memory) - begin
        of_arenas: tuple[NDArray[Any], ...] = sections[Sections._fields.index("blocks") + 1 :]
        self._told = [section.view(np.uint8).reshape(self.num_arenas, -1) for section in of_arenas if section.size]
        """What stands of each arena beside the blocks: (B, bytes) each."""
        config, hunters, prey = self.config, self.config.hunters, self.config.prey
        num_blocks, num_rows = len(self.blocks), self.blocks.shape[1] // LANES
        slot = slot_rows(config.targets_move)
        prey_begin = num_rows - prey * rows.PREY_ROWS
        self._team_by_seat = config.team_by_seat
        self._widths = (SINGLE, SINGLE) if self.num_arenas == 1 else (HALF, WIDE)
        self._fields = self.blocks.reshape(num_blocks, num_rows, LANES)  # the same memory: [block, row, lane]
        self._hunters = self._fields[:, rows.ARENA_ROWS : rows.ARENA_ROWS + hunters * rows.HUNTER_ROWS].reshape(
            num_blocks, hunters, rows.HUNTER_ROWS, LANES
        )
        first = rows.ARENA_ROWS + hunters * rows.HUNTER_ROWS
        digest = rows.MOVING_TARGET_DIGEST if config.targets_move else rows.TARGET_DIGEST
        self._target_digest = [_row(row) for row in digest]
        self._targets = self._fields[:, first : first + config.max_targets * slot].reshape(
            num_blocks, config.max_targets, slot, LANES
        )
        self._target_orders = self._fields[:, first + config.max_targets * slot : prey_begin].reshape(
            num_blocks, hunters, target_order_rows(config.targets_seen), LANES
        )
        self._prey = self._fields[:, prey_begin:].reshape(num_blocks, prey, rows.PREY_ROWS, LANES)

    # playing

    def reset(
        self, seeds: Sequence[int] | NDArray[np.uint64], arenas: Sequence[int] | NDArray[np.int64] | None = None
    ) -> None:
        """Begin an episode in all arenas, or in those named; one seed in [0, 2^64) for each.

        Raises:
            ConfigError: for a number of seeds that is not that of the arenas, and a seed outside [0, 2^64).
        """
        chosen = np.arange(self.num_arenas) if arenas is None else np.asarray(arenas, dtype=np.int64)
        if len(seeds) != len(chosen):
            raise ConfigError(f"seeds must be one for each of {len(chosen)} arenas, got {len(seeds)}")
        if not isinstance(seeds, np.ndarray) or seeds.dtype != np.uint64:
            seeds = np.array([checked_seed(seed) for seed in seeds], dtype=np.uint64)
        self.rewards[chosen] = 0.0
        self.ends[chosen] = 0
        self.prey_rewards[chosen] = 0.0
        if self.infos_wanted:
            self.parts[chosen] = 0.0
            self.prey_parts[chosen] = 0.0
        resets = np.stack((chosen.astype(np.uint64), seeds), axis=1)
        if arenas is None:
            self._observe(0, len(self.blocks), resets)
            return
        if not len(chosen):
            return
        resets = resets[np.argsort(chosen)]
        gaps = np.flatnonzero(np.diff(resets[:, 0] // LANES) > 1) + 1
        for some in np.split(resets, gaps):  # one call for blocks that adjoin; the others keep what they observe
            first, last = (some[[0, -1], 0] // LANES).tolist()
            self._observe(first, last + 1, some)

    def step(
        self,
        choices: NDArray[np.int64],
        commands: NDArray[np.float32],
        prey_commands: NDArray[np.float32] | None = None,
        requests: RequestTable = _NO_REQUESTS,
    ) -> None:
        """R1.4: one step of every arena.

        Args:
            choices: (B, H) int64: the rank chosen under target control, or requested under full control, 0 for none.
            commands: (B, H, 2) float32 in [-1, 1]: linear and angular velocity as fractions of the limits. What no
                seat's control reads may be an empty array.
            prey_commands: where there is prey (B, P, 2) float32, the same for prey, in [-1, 1].
            requests: of a single arena, in the place of what the hunters ask for: a table of `arbiter`, (n, columns),
                of which REQUEST_SEAT and REQUEST_TARGET (a slot, or a code for none) are read, and all else is written.
        """
        if prey_commands is not None:
            self._prey_commands[:] = prey_commands
        blocks, parts = len(self.blocks), self._shares
        if self.threads.size == 1:
            tick.run(*self._widths, self._memory, 0, 0, blocks, _NO_RESETS, True, choices, commands, requests)
            return

        def play(thread: int, part: int) -> None:
            first, last = part * blocks // parts, (part + 1) * blocks // parts
            tick.run(*self._widths, self._memory, thread, first, last, _NO_RESETS, True, choices, commands, requests)

        self.threads.run(parts, play)

    def observe(self, arena: int | None = None) -> None:
        """Write observations and masks as things stand, of all arenas or of those in one arena's block."""
        first, last = (0, len(self.blocks)) if arena is None else (arena // LANES, arena // LANES + 1)
        self._observe(first, last, _NO_RESETS)

    def _observe(self, first: int, last: int, resets: NDArray[np.uint64]) -> None:
        """Begin episodes, and observe those blocks; nobody plays."""
        tick.run(*self._widths, self._memory, 0, first, last, resets, False, _NO_CHOICES, _NO_COMMANDS, _NO_REQUESTS)

    def withdraw(self, arena: int, seat: int) -> None:
        """R1.6: the hunter stands still from now on, and the others do not see it."""
        me = self._hunters[arena // LANES, seat, :, arena % LANES]
        me[_row(rows.WITHDRAWN)] = 1.0
        for row in rows.AT_REST:
            me[_row(row)] = 0.0
        self.observe(arena)

    def withdraw_prey(self, arena: int, index: int) -> None:
        """R12.5: the prey stands still from now on."""
        me = self.prey_rows(arena)[index]
        me[_row(rows.PREY_WITHDRAWN)] = 1.0
        slot = int(me[_row(rows.PREY_SLOT)])
        if slot != rows.NO_TARGET:
            for row in (rows.SPEED, rows.TURN_RATE):
                self._targets[arena // LANES, slot, _row(rows.BODY + row), arena % LANES] = 0.0
        self.observe(arena)

    def place(
        self,
        arena: int,
        hunters: Sequence[tuple[float, float, float]],
        targets: Sequence[tuple[float, float]],
        prey: Sequence[tuple[float, float, float]] | None = None,
    ) -> None:
        """A position for tests and lessons: hunters at rest at these poses, and these targets alive instead of those
        that were and that nobody played.

        The targets take the next spawn numbers, in their order, and appear now with theta 0. Prey stays as it is, under
        its numbers; where poses of all prey are given, those who are in play are at rest there.
        """
        block, lane = divmod(arena, LANES)
        for seat, (x, y, theta) in enumerate(hunters):
            me = self._hunters[block, seat, :, lane]
            # 0.0 is added so that no zero has a sign
            me[[_row(row) for row in (rows.X, rows.Y, rows.THETA)]] = x + 0.0, y + 0.0, wrap(theta + 0.0)
            for row in (*rows.AT_REST, rows.AT_WALL):
                me[_row(row)] = 0.0
        slots, players = self._targets[block, :, :, lane], self.prey_rows(arena)[:, _row(rows.PREY_SLOT)]
        played = np.sort(players[players != rows.NO_TARGET]).astype(np.int64)
        kept = slots[played]
        slots[:] = 0.0
        slots[: len(played)] = kept
        self._fields[block, _row(rows.ALIVE), lane] = len(played)
        players[:] = [np.searchsorted(played, slot) if slot != rows.NO_TARGET else slot for slot in players]
        for slot, (x, y, theta) in zip(players.astype(np.int64), prey or (), strict=prey is not None):
            if slot != rows.NO_TARGET:
                pose = [_row(rows.BODY + row) for row in (rows.X, rows.Y, rows.THETA)]
                slots[slot, pose] = x + 0.0, y + 0.0, wrap(theta + 0.0)
                for row in (rows.SPEED, rows.TURN_RATE, rows.AT_WALL):
                    slots[slot, _row(rows.BODY + row)] = 0.0
        for x, y in targets:
            spawner.spawn_at(self._memory, arena, float(x), float(y), 0.0)
        self.observe(arena)

    def place_batch(
        self,
        arenas: NDArray[np.int64],
        hunters: NDArray[np.float64],
        targets: NDArray[np.float64],
        steps: NDArray[np.int64],
    ) -> None:
        """Begin episodes with these bodies in place of those that the seeds give; the seeds stay, for all that follows.
        Not for arenas with prey.

        Args:
            arenas: (n,), all different.
            hunters: (n, H, 4): x, y, theta, linear velocity; NaN: withdrawn.
            targets: (n, T, 5): x, y, theta, linear velocity, age [s]; NaN: none. They take the numbers from 1, the
                oldest first.
            steps: (n,), how many have been played.
        """
        config, (block, lane), count = self.config, np.divmod(arenas, LANES), len(arenas)
        period = int(config.spawn_period_ms) if config.spawning else None
        time = steps * config.control_period_ms
        alive = ~np.isnan(targets[:, :, 0])
        own = {
            rows.TIME: time,
            rows.STEP: steps,
            rows.SPAWNED: alive.sum(axis=1),
            rows.NUMBERS: alive.sum(axis=1),
            rows.FIRINGS: 0 if period is None else time // period,
            rows.ALIVE: alive.sum(axis=1),
        }
        for row in (*range(rows.ARENA_DIGEST_ROWS), _row(rows.ALIVE), _row(rows.ENDED)):
            self._fields[block, row, lane] = own.get(row * LANES, 0.0)

        seats = np.zeros((count, config.hunters, rows.HUNTER_ROWS))
        here = ~np.isnan(hunters[:, :, 0])
        for row, column in ((rows.X, 0), (rows.Y, 1), (rows.THETA, 2), (rows.SPEED, 3)):
            seats[:, :, _row(row)] = np.where(here, hunters[:, :, column], 0.0)
        seats[:, :, _row(rows.THETA)] = _wrapped(seats[:, :, _row(rows.THETA)])
        seats[:, :, _row(rows.WITHDRAWN)] = ~here
        seats[:, :, _row(rows.REQUESTED_SLOT)] = rows.NO_TARGET
        seats[:, :, [_row(rows.DISTANCE_UM), _row(rows.WINNER)]] = -1.0
        self._hunters[block, :, :, lane] = seats

        age_ms = np.floor(1000.0 * targets[:, :, 4] + 0.5)
        order = np.argsort(np.where(alive, -age_ms, np.inf), axis=1, kind="stable")  # R8.2
        ranked = np.take_along_axis(targets, order[:, :, None], axis=1)
        there = np.take_along_axis(alive, order, axis=1)
        slots = np.zeros((count, config.max_targets, slot_rows(config.targets_move)))
        slots_used = slots[:, : targets.shape[1]]
        theta = _wrapped(ranked[:, :, 2]) if config.targets_move else ranked[:, :, 2]
        appeared = time[:, None] - np.take_along_axis(age_ms, order, axis=1)
        values = {
            rows.NUMBER: np.arange(1, targets.shape[1] + 1)[None, :],
            rows.APPEARED: appeared,
            rows.TARGET_X: ranked[:, :, 0],
            rows.TARGET_Y: ranked[:, :, 1],
            rows.BODY + rows.THETA: theta,
        }
        if config.targets_move:
            values[rows.BODY + rows.SPEED] = ranked[:, :, 3]
        for row, value in values.items():
            slots_used[:, :, _row(row)] = np.where(there, value, 0.0)
        self._targets[block, :, :, lane] = slots
        self.ends[arenas] = 0
        for told in (self.rewards, self.parts, self.evidence):
            told[arenas[: len(told)]] = 0.0
        self.observe()

    def spawn(self, arena: int, x: float, y: float, theta: float) -> int:
        """R8.1: a target outside the timer, with the next number, which is returned; 0 in a full arena (R3.5)."""
        number = spawner.spawn_at(self._memory, arena, x + 0.0, y + 0.0, theta + 0.0)  # so that no zero has a sign
        self.observe(arena)
        return number

    def kill(self, arena: int, number: int) -> bool:
        """R8.1: an alive target leaves uncaught and no longer counts as spawned (R5.8). False where it is not alive."""
        killed = spawner.kill(self._memory, arena, number)
        self.observe(arena)
        return killed

    # reading

    @property
    def terminated(self) -> NDArray[np.bool_]:
        """R1.5: (B,)."""
        return np.equal(self._ended(), rows.TERMINATED)

    @property
    def truncated(self) -> NDArray[np.bool_]:
        """R1.5: (B,)."""
        return np.equal(self._ended(), rows.TRUNCATED)

    def _ended(self) -> NDArray[np.float64]:
        return self._fields[:, _row(rows.ENDED)].reshape(-1)[: self.num_arenas]

    def hunter_rows(self, arena: int) -> NDArray[np.float64]:
        """One arena's hunters as core/state.py stores them: (H, HUNTER_ROWS), the engine's own memory."""
        return self._hunters[arena // LANES, :, :, arena % LANES]

    def prey_rows(self, arena: int) -> NDArray[np.float64]:
        """One arena's prey as core/state.py stores it: (P, PREY_ROWS), the engine's own memory."""
        return self._prey[arena // LANES, :, :, arena % LANES]

    def prey_active(self) -> NDArray[np.bool_]:
        """R12.3: which prey is not out: (B, P)."""
        slots = self._prey[:, :, _row(rows.PREY_SLOT)]
        by_arena = slots.transpose(0, 2, 1).reshape(len(self.blocks) * LANES, self.config.prey)
        return np.greater_equal(by_arena[: self.num_arenas], 0.0)

    def team_scores(self) -> NDArray[np.float64]:
        """R11.1: the sums of the scores of each team's hunters: (B, teams)."""
        scores = self._hunters[:, :, _row(rows.SCORE)].transpose(0, 2, 1).reshape(-1, self.config.hunters)
        return np.stack([scores[: self.num_arenas, seats].sum(axis=1) for seats in self.config.team_seats], axis=1)

    def active(self) -> NDArray[np.bool_]:
        """R1.6, R1.7: which hunters take part: (B, H)."""
        withdrawn = self._hunters[:, :, _row(rows.WITHDRAWN)]
        return np.equal(withdrawn.transpose(0, 2, 1).reshape(-1, self.config.hunters)[: self.num_arenas], 0.0)

    def rulings(self, arena: int) -> tuple[Ruling, ...]:
        """R5.6: the verdicts of the last step with their evidence, by seat."""
        found = []
        steps = int(self._fields[arena // LANES, _row(rows.STEP), arena % LANES])
        for seat, me in enumerate(self.hunter_rows(arena).tolist()):
            number, verdict, distance, winner = (me[_row(row)] for row in rows.EVIDENCE)
            if verdict == NO_REQUEST:
                continue
            step = steps if verdict == Verdict.MATCH_OVER else steps - 1
            target = self.config.target_name(int(number)) if number else None
            found.append(Ruling.of_numbers(verdict, seat, target, distance, winner, step))
        return tuple(found)

    def world(self, arena: int = 0) -> World:
        """One arena as people read it."""
        block, lane = divmod(arena, LANES)
        own = self._fields[block, : rows.ARENA_ROWS, lane]
        alive = int(own[_row(rows.ALIVE)])
        prey, players = self._prey_states(arena)
        return World(
            time_ms=int(own[_row(rows.TIME)]),
            step=int(own[_row(rows.STEP)]),
            side_m=self.config.side_m,
            hunters=tuple(
                HunterState(
                    name=name,
                    x=me[_row(rows.X)],
                    y=me[_row(rows.Y)],
                    theta=me[_row(rows.THETA)],
                    linear_velocity=me[_row(rows.SPEED)],
                    angular_velocity=me[_row(rows.TURN_RATE)],
                    score=int(me[_row(rows.SCORE)]),
                    active_target=self.config.target_name(int(me[_row(rows.ACTIVE)]))
                    if me[_row(rows.ACTIVE)]
                    else None,
                    at_wall=me[_row(rows.AT_WALL)] > 0,
                    withdrawn=me[_row(rows.WITHDRAWN)] > 0,
                    team=team,
                )
                for name, team, me in zip(
                    self.config.hunter_names, self._team_by_seat, self.hunter_rows(arena).tolist(), strict=True
                )
            ),
            targets=tuple(
                TargetState(
                    name=self.config.target_name(int(number)),
                    number=int(number),
                    x=x,
                    y=y,
                    theta=theta,
                    spawned_ms=int(appeared),
                    linear_velocity=motion[0] if motion else 0.0,
                    angular_velocity=motion[1] if motion else 0.0,
                    at_wall=bool(motion and motion[2]),
                    prey=players.get(slot),
                )
                for slot, (number, x, y, theta, appeared, *motion) in enumerate(
                    self._targets[block, :alive, self._target_digest, lane].T.tolist()
                )
            ),
            rulings=self.rulings(arena),
            spawned=int(own[_row(rows.SPAWNED)]),
            prey=prey,
        )

    def _prey_states(self, arena: int) -> tuple[tuple[PreyState, ...], dict[int, str]]:
        """R12.1: one arena's prey, and who plays the target in a slot."""
        states, players = [], {}
        numbers = self._prey_numbers(arena).tolist()
        for name, number, me in zip(self.config.prey_names, numbers, self.prey_rows(arena).tolist(), strict=True):
            states.append(
                PreyState(
                    name=name,
                    target=self.config.target_name(int(number)) if number else None,
                    times_caught=int(me[_row(rows.TIMES_CAUGHT)]),
                    caught_ms=None if number else int(me[_row(rows.CAUGHT_AT)]),
                    caught_by=None if me[_row(rows.CAUGHT_BY)] < 0 else int(me[_row(rows.CAUGHT_BY)]),
                    withdrawn=me[_row(rows.PREY_WITHDRAWN)] > 0,
                )
            )
            players[int(me[_row(rows.PREY_SLOT)])] = name
        return tuple(states), players

    def _prey_numbers(self, arena: int) -> NDArray[np.float64]:
        """R12.1: the numbers of the targets that one arena's prey plays, 0 for prey that is out: (P,)."""
        slots = self.prey_rows(arena)[:, _row(rows.PREY_SLOT)].astype(np.int64)
        numbers = self._targets[arena // LANES, slots, _row(rows.NUMBER), arena % LANES]
        return np.where(slots == rows.NO_TARGET, 0.0, numbers)

    def rank_of(self, arena: int, seat: int, name: str) -> int:
        """R7.1: the rank at which a seat sees the target of that name, 0 where it does not."""
        block, lane = divmod(arena, LANES)
        view = self._target_orders[block, seat, :, lane].copy().view(np.uint8)  # a slot is a byte: see RANKS_PER_WORD
        for rank in range(int(self.hunter_rows(arena)[seat, _row(rows.SEEN)])):
            slot = view[rank]
            if self.config.target_name(int(self._targets[block, slot, _row(rows.NUMBER), lane])) == name:
                return rank + 1
        return 0

    def seeds(self) -> NDArray[np.uint64]:
        """The seeds of the episodes under way: (B,)."""
        high, low = (
            self._fields[:, _row(row)].reshape(-1)[: self.num_arenas].astype(np.uint64)
            for row in (rows.SEED_HIGH, rows.SEED_LOW)
        )
        return (high << np.uint64(32)) | low

    def state(self, arena: int = 0) -> NDArray[np.float64]:
        """A.8: the numbers of one arena's state, in the order in which the digest reads them."""
        block, lane = divmod(arena, LANES)
        own = self._fields[block, :, lane]
        alive = int(own[_row(rows.ALIVE)])
        return np.concatenate(
            (
                own[: rows.ARENA_DIGEST_ROWS],
                self._hunters[block, :, _HUNTER_DIGEST, lane].T.reshape(-1),
                self._targets[block, :alive, self._target_digest, lane].T.reshape(-1),
                self._prey_digest(arena),
            )
        )

    def _prey_digest(self, arena: int) -> NDArray[np.float64]:
        """A.8: what stands of prey in the digest: (3 P,)."""
        if not self.config.prey:
            return _NO_PREY
        times = self.prey_rows(arena)[:, [_row(rows.TIMES_CAUGHT), _row(rows.CAUGHT_AT)]]
        return np.column_stack((self._prey_numbers(arena), times)).reshape(-1)

    def digest(self, arena: int = 0) -> bytes:
        """A.8: eight bytes that stand for one arena's state."""
        return hashlib.blake2b(self.state(arena).astype("<f8", copy=False).tobytes(), digest_size=8).digest()

    # keeping

    def save(self) -> Bytes:
        """R10.2: all arenas, with what was told of their last step; `restore` takes it back, here or in an engine of an
        equal config and size. What only `auto_reset` keeps comes last.
        """
        return self._kept.copy()

    def restore(self, saved: Bytes) -> None:
        """Go on from a saved state."""
        size = min(len(saved), len(self._kept))
        self._kept[:size] = saved[:size]

    def save_row(self, arena: int) -> Bytes:
        """R10.2: the same of one arena, which any row of an engine of an equal config can take."""
        column = self._fields[arena // LANES, :, arena % LANES].copy()
        return np.concatenate((column.view(np.uint8), *[told[arena] for told in self._told]))

    def restore_row(self, arena: int, saved: Bytes) -> None:
        """Go on, in one arena, from a saved state."""
        begin = self._fields.shape[1] * 8
        self._fields[arena // LANES, :, arena % LANES] = saved[:begin].view(np.float64)
        for told in self._told:
            end = begin + told.shape[1]
            if end > len(saved):  # of an engine without auto_reset
                break
            told[arena] = saved[begin:end]
            begin = end

    def saved_sizes(self, *, row: bool) -> tuple[int, int]:
        """How long a saved state can be, of a row or of all: without what only `auto_reset` keeps, and with it."""
        figures = self.config.hunters * RECORD_COLUMNS, self.config.prey * PREY_RECORD_COLUMNS
        records = [self.num_arenas * count * np.dtype(np.float32).itemsize for count in figures]
        views = (self.observations, self.masks, self.prey_observations)
        own = [*records, *(section.nbytes for section in views)]
        if not row:
            return self._kept_by_all, self._kept_by_all + sum(map(whole_lines, own))
        told = self._fields.shape[1] * self._fields.itemsize + sum(told.shape[1] for told in self._told)
        of_ends = sum(own) // self.num_arenas
        return (told - of_ends, told) if self.auto_reset else (told, told + of_ends)

    def clone(self) -> "Engine":
        """An engine of its own in the same state."""
        twin = object.__new__(Engine)
        twin.config, twin.num_arenas = self.config, self.num_arenas
        twin.infos_wanted, twin.auto_reset = self.infos_wanted, self.auto_reset
        twin._shares, twin.threads = self._shares, Threads(self.threads.size)
        memory = copy_of(self._memory)
        twin._look_at(memory, sections_of(memory))
        return twin

    def __deepcopy__(self, memo: object) -> "Engine":
        return self.clone()

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by what it is made from: its arrays share their memory, which a plain pickle would part."""
        make = partial(
            Engine, infos_wanted=self.infos_wanted, auto_reset=self.auto_reset, num_threads=self.threads.size
        )
        return make, (self.config, self.num_arenas), self._memory

    def __setstate__(self, state: Bytes) -> None:
        """Take over what another engine holds."""
        self._memory[:] = state


def next_seeds(seeds: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """A.5: the seeds of the episodes that follow, where a reset names none: (n,)."""
    following = seeds.copy()
    advance_seeds(following)
    return following


def episode_seed(given: int | None, before: int | None) -> int:
    """The seed of one arena's next episode.

    Args:
        given: a whole number in [0, 2^64), or None.
        before: the seed of the episode before, which it then follows (A.5); None for a first one, which is the
            operating system's.

    Raises:
        ConfigError: for a seed outside [0, 2^64).
    """
    if given is not None:
        return checked_seed(given)
    return fresh_seed() if before is None else int(next_seeds(np.array([before], dtype=np.uint64))[0])


def batch_seeds(seed: int, num_arenas: int) -> NDArray[np.uint64]:
    """A.5: the seeds of a batch's rows from one seed: (B,)."""
    seeds = np.zeros(num_arenas, dtype=np.uint64)
    derive_row_seeds(np.uint64(seed), seeds)
    return seeds


def _wrapped(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """A.2's wrap of many angles, without the sign of zeros."""
    turned = angles - 2.0 * PI * np.floor((angles + PI) / (2.0 * PI))
    turned = np.where(turned < -PI, turned + 2.0 * PI, turned)
    return np.where(turned >= PI, turned - 2.0 * PI, turned) + 0.0


_compiled: set[bool] = set()
"""In this process: for one arena, True, and for batches, False."""


def _compile_once(*, one: bool) -> None:
    """Compile, or load from the cache, all that an engine of one arena or of a batch calls, and say so where it takes
    long.
    """
    if INTERPRETED or one in _compiled:
        return
    _compiled.add(one)
    with (
        progress_shown(),
        quick_typing(),
        _without_garbage_collection(),  # which would look at the compiler's many objects again and again
    ):
        size = 1 if one else 2
        smallest = Engine(ArenaConfig(hunters=1, max_targets=1, initial_targets=1), size)
        smallest.reset([0] * size)
        smallest.step(np.zeros((size, 1), dtype=np.int64), np.zeros((size, 1, 2), dtype=np.float32))


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()

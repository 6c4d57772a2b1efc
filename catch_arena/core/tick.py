"""Rulebook R1.4: one step, phase by phase. This file is the table of contents of the core."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.addresses import by_address
from catch_arena.core.arbiter import RequestTable
from catch_arena.core.catching import resolve_requests
from catch_arena.core.controllers import apply_actions
from catch_arena.core.dropouts import drop_out, write_active
from catch_arena.core.episodes import (
    any_ended,
    begin,
    begin_again,
    end_test,
    restore_finished,
    take_snapshot,
    write_ends,
)
from catch_arena.core.jit import Rows, entry, phase
from catch_arena.core.memory import Bytes, Sections, sections_of, settings_in
from catch_arena.core.observations import observe
from catch_arena.core.physics import move
from catch_arena.core.prey import command_prey, return_prey, reward_prey
from catch_arena.core.rewards import note_references, reward, write_team_scores
from catch_arena.core.spawner import spawn_through
from catch_arena.core.state import STILL, Options, Settings, targets_of
from catch_arena.core.targets import command_targets
from catch_arena.core.vectors import LANES, Width


@phase
def play(
    chunk: Rows,
    s: Settings,
    width: Width,
    first_arena: int,
    stop_arena: int,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    given_requests: RequestTable,
    sections: Sections,
) -> None:
    """R1.4: play one step of a chunk, whose arenas are those from `first_arena` up to, but not including,
    `stop_arena`.
    """
    lanes = stop_arena - first_arena
    targets = targets_of(chunk, s)
    rewards, parts = sections.rewards[first_arena:stop_arena], sections.parts[first_arena:stop_arena]
    had_ended = any_ended(chunk, lanes)
    if had_ended:
        take_snapshot(chunk, sections.snapshot)
    if s.dropout_rate > 0.0:
        drop_out(chunk, s, lanes)
    orders, controls = sections.target_orders[first_arena // LANES], sections.controls[first_arena:stop_arena]
    choices, commands = choices[first_arena:stop_arena], commands[first_arena:stop_arena]
    apply_actions(chunk, s, width, lanes, orders, controls, choices, commands, sections)
    note_references(chunk, s, lanes, orders, targets, sections)
    if s.target_motion != STILL:
        command_targets(chunk, s, width, lanes, targets, sections.scratch_rows)
    if s.prey > 0:
        command_prey(chunk, s, lanes, targets, commands, sections)
    resolve_requests(chunk, s, lanes, targets, given_requests, sections)
    move(chunk, s, width, lanes, targets, sections.scratch_rows)
    spawn_through(chunk, s, lanes, targets)
    if s.prey > 0:
        return_prey(chunk, s, lanes, targets)
    end_test(chunk, s, width)
    reward(chunk, s, width, lanes, sections, rewards, parts)
    if had_ended:
        restore_finished(chunk, s, lanes, sections, rewards, parts)
    if s.prey > 0:
        reward_prey(chunk, s, lanes, targets, had_ended, sections, rewards, sections.prey_parts[first_arena:stop_arena])
    write_ends(chunk, lanes, sections.ends[first_arena:stop_arena])


@entry
def run(
    kind: tuple[Width, Width, Options],
    memory: Bytes,
    thread: int,
    first_chunk: int,
    stop_chunk: int,
    resets: NDArray[np.uint64],
    playing: bool,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    given_requests: RequestTable,
) -> None:
    """Begin the requested episodes, play one step (R1.4) if `playing` is true, and write the observations.

    Args:
        kind: what the code is compiled for: number of lanes that play together, number of lanes that observe together,
            and its options, see `state.Options`.
        thread: the thread whose scratch sections are used, from 0 up.
        first_chunk: the first chunk that is played and observed.
        stop_chunk: the chunk after the last one.
        resets: (n, 2), arenas and the seeds with which they begin.
        choices: (B, H), ranks or 0; may be empty if no seat's control reads them.
        commands: (B, N, 2), fractions of the limits in [-1, 1], of the hunters and then of prey; may be empty if no
            agent reads them.
        given_requests: for a single arena: see `catching.resolve_requests`; they are judged in place.
    """
    width, view_width, options = kind
    sections = sections_of(memory, thread)
    s = settings_in(sections.settings, options)
    ranks, velocities, table = by_address(choices), by_address(commands), by_address(given_requests)
    for i in range(len(resets)):
        arena = int(resets[i, 0])
        begin(sections.chunks[arena // LANES], s, arena % LANES, sections.start_poses, resets[i, 1])
    for index in range(first_chunk, stop_chunk):
        chunk = sections.chunks[index]
        first_arena = index * LANES
        stop_arena = min(first_arena + LANES, len(sections.ends))
        lanes = stop_arena - first_arena
        if playing:
            play(chunk, s, width, first_arena, stop_arena, ranks, velocities, table, sections)
        # if episodes have ended, their last states are observed first, and the new ones after that; in a loop, so that
        # `observe` is compiled once
        renewing = playing and len(sections.records) > 0 and any_ended(chunk, lanes)
        for turn in range(2 if renewing else 1):
            if turn == 1:
                begin_again(chunk, s, lanes, first_arena, sections)
            observe(chunk, s, view_width, first_arena, stop_arena, sections)
        if s.dropout_rate > 0.0 or s.prey > 0:
            write_active(chunk, s, lanes, sections.active[first_arena:stop_arena])
        if s.has_teams:
            write_team_scores(chunk, s, lanes, sections, sections.team_scores[first_arena:stop_arena])

"""Rulebook R1.4: one step, phase by phase. This file is the table of contents of the core."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.catching import note_evidence, settle
from catch_arena.core.controllers import take_in
from catch_arena.core.episodes import begin, begin_again, end_test, keep, note_ends, put_back_ended, some_ended
from catch_arena.core.jit import Block, entry, passage
from catch_arena.core.memory import Bytes, Sections, sections_of, settings_in
from catch_arena.core.observations import observe
from catch_arena.core.physics import move
from catch_arena.core.rewards import reward
from catch_arena.core.spawner import spawn_through
from catch_arena.core.state import LANES, Settings, targets_of
from catch_arena.core.vectors import Width
from catch_arena.core.workspace import Scratch, scratch_of


@passage
def play(
    block: Block,
    s: Settings,
    width: Width,
    first: int,
    last: int,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
    sections: Sections,
    scratch: Scratch,
) -> None:
    """R1.4, but for the observations: one step of the arenas from `first` up to, but not including, `last`."""
    lanes = last - first
    targets = targets_of(block, s)
    rewards, parts = sections.rewards[first:last], sections.parts[first:last]
    had_ended = some_ended(block, lanes)
    if had_ended:
        keep(block, scratch.kept)
    take_in(block, s, width, lanes, sections.controls, choices[first:last], commands[first:last], scratch)
    settle(block, s, width, lanes, targets, scratch)
    move(block, s, width, lanes, scratch.rows)
    spawn_through(block, targets, lanes, s)
    end_test(block, s, width)
    reward(block, s, width, lanes, scratch, rewards, parts)
    if had_ended:
        put_back_ended(block, s, lanes, scratch.kept, rewards, parts)
    note_ends(block, lanes, sections.ends[first:last])


@entry
def run(
    width: Width,
    view_width: Width,
    memory: Bytes,
    thread: int,
    begin_block: int,
    end_block: int,
    resets: NDArray[np.uint64],
    playing: bool,
    choices: NDArray[np.int64],
    commands: NDArray[np.float32],
) -> None:
    """Episodes begin where that is asked for, then one step of every arena (R1.4) where there is play, and then all
    observe.

    Args: `width` and `view_width`, how many lanes play and observe at a time; `memory`, see core/memory.py; `thread`,
    whose scratch memory is used; the blocks from `begin_block` up to, but not including, `end_block`; `resets` (n, 2),
    arenas and seeds; the actions `choices` (B, H) and `commands` (B, H, 2).
    """
    sections = sections_of(memory)
    s = settings_in(sections.settings)
    scratch = scratch_of(sections, thread)
    for i in range(len(resets)):
        arena = int(resets[i, 0])
        begin(sections.blocks[arena // LANES], s, arena % LANES, sections.start_poses, resets[i, 1])
    for index in range(begin_block, end_block):
        block = sections.blocks[index]
        first = index * LANES
        last = min(first + LANES, len(sections.ends))
        if playing:
            play(block, s, width, first, last, choices, commands, sections, scratch)
        renewing = playing and len(sections.records) > 0 and some_ended(block, last - first)
        for last_view in range(1 if renewing else 0, -1, -1):  # one call of `observe` is compiled once
            observe(block, s, view_width, first, last, sections, scratch)
            if last_view > 0:
                begin_again(block, s, first, last, sections)
        note_evidence(block, s, last - first, sections.evidence[first:last])

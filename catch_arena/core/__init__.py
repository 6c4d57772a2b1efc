"""The rules as compiled functions over arrays: NumPy, Numba with its llvmlite, and platformdirs for the cache's place;
no frameworks, no validation.

A *rule* works out a value, or a few, for one lane or a group of lanes, from numbers or from what it reads in arrays. It
writes nothing, and cites its clause if it stands for one. A *phase* is one block: the loop over its lanes, or other
phases in their order; an *outlined* one is made small, since it is rare. An *entry* is what Python calls: it walks the
blocks.

- tick: one step, phase by phase: begin to read here. episodes: how an episode begins and ends. placing: with bodies put
  where somebody wants them.
- What is kept: state (an arena's rows), memory (an engine's bytes, with scratch of each thread).
- The phases: controllers, targets, dropouts, catching with arbiter, physics, spawner, rewards; prey: chapter 12's.
- What is seen: observations, features (of each thing), tiles (what is known of it), ranking (in which order),
  visibility (how far, how blurred), prey_views.
- math, random: functions and random numbers with the same bits on every machine.
- vectors, transfers: several arenas in one instruction, and numbers moved between arrays.
- jit, compiler: how it is compiled. cache: compiled code on the disk. extending: how the compiler is told of functions
  and types of ours; addresses: arrays as it has them.

Parameters that have the same meaning in every function, which docstrings do not repeat:

- memory: see memory.py. arena: which of the batch. choices, commands and given_requests: see `tick.run`, of the lanes.
  sections: see `memory.Sections`; so are controls (of the lanes), limits, teams and team_seats.
- s: the settings, see `state.Settings`. block: the rows of LANES arenas, see state.py; lane: one of them. lanes: how
  many of its lanes are arenas, from 0 up. first and last: the first arena of the block, and the one behind its last.
- width: how many lanes a group has; first: the first of those, where a function is about one group (see vectors.py).
- seat: which hunter. me: the rows of whom the function is about. index: which prey. targets: the slots of the block;
  slot: one of them. order: the slots or seats that a seat sees, by rank, see `state.slot_at_rank`.
- place: where observations are written, see `transfers.Place`. tiles: see tiles.py.
"""

"""The rules as compiled functions over arrays: NumPy, Numba with its llvmlite, and platformdirs for the place of the
cache; no frameworks, no validation.

A *rule* computes one or a few values for one lane or a group of lanes, from numbers and arrays. It writes nothing, and
cites its clause if it stands for one. A *phase* works on one chunk: a loop over its lanes, or other phases in order; an
*outlined* one is compiled as small code, since it is rare. An *entry* is a function that Python calls: it walks the
chunks.

- tick: one step, phase by phase: begin to read here. episodes: begin and end of episodes. placing: bodies at given
  poses.
- Memory: rows (those of an arena), state (settings, and views of the rows), memory (an engine's bytes, with scratch of
  each thread).
- The phases: controllers, targets, dropouts, catching with arbiter, physics, spawner, rewards; prey: chapter 12's.
- Views: observations, features (of each body), ranking (order), visibility (limits and noise), prey_views.
- math, random: functions and random numbers with the same bits on every machine.
- vectors, transfers: several arenas in one instruction, and numbers moved between arrays.
- modes: whether the core is compiled, and how. jit, compiler: compilation; compiling: the line printed meanwhile.
  cache, cache_folder: compiled code on the disk. extending: registration of our functions and types with the compiler.
  addresses: the compiler's arrays.

Parameters that have the same meaning in every function; docstrings do not repeat them:

- memory: see memory.py. arena: its number in the batch. choices, commands and given_requests: see `tick.run`; after
  `tick.play` those of the lanes. sections: see `memory.Sections`; so are controls (of the lanes), limits and teams.
- They mostly come in this order: chunk or me; s; first and width; lanes or lane; seat; order; targets; slot, index or
  at; other numbers; sections; and last the results, or the room for them.
- s: the settings, see `state.Settings`. chunk: the rows of LANES arenas, see rows.py; lane: one of them. lanes: number
  of the chunk's lanes that are arenas, from 0 up. first_arena and stop_arena: the chunk's first, and the one after its
  last.
- width: a tuple as long as a group has lanes; first: the first lane of the group (see vectors.py).
- seat: number of a hunter. me: the rows of the body, hunter or prey that the function works on. index: number of a
  prey. one, other: the rows, or the seats, of two that are compared. bodies: see `ranking.Bodies`.
- targets: the slots of the chunk; slot: one of them; at: offset of one in `targets`, its lane included; slots: number
  of slots in use in the lane that uses most. order: the slots or seats that a seat sees, by rank, see
  `state.Order`; orders: those of the targets, of all seats.
- x, y: a position [m]; theta: a heading [rad]; sine, cosine: those of a heading. side: side of the arena [m]. number: a
  spawn number, from 1. seed: the arena's seed. step: number of steps played before this one. time_ms: time since the
  reset.
- requested and active_targets: see `controllers.look_up_choices`. reference: the references of one hunter's or prey's
  reward, see `memory.Sections`. rewards and parts: see `rewards`. keys: sorting keys, rows of LANES. tied: one row of
  flags, see `ranking.any_tied`. ranks: number of bodies that are seen.
- place: place at which observations are written, see `transfers.Place`. tiles: see features.py.
"""

"""The engine: arenas of one config in one memory, which the compiled core steps. No names, spaces or dicts: envs/ has
those.

- engine: `Engine`. The envs, the service and the replays stand on it.
- compiling: the core is compiled once in a process, and what is printed meanwhile.
- core_settings: a config as the core's numbers. episode_seeds: the seed of each episode.
- block_views: the memory by what lies in it. world_reading: it is read as a World.
"""

from catch_arena.engine.engine import Engine as Engine

"""The engine: arenas of one config in one memory, which the compiled core steps. Names, spaces and dicts belong to
envs/.

- engine: `Engine`, which the envs, `ros.arena_service` and the replays use, and its `SavedState`.
- core_settings: a config as the core's numbers. episode_seeds: the seed of each episode.
- reading: what people read in the memory: views of it by content, worlds with their rulings, and the state that the
  digest reads.
"""

from catch_arena.engine.engine import Engine as Engine
from catch_arena.engine.engine import SavedState as SavedState

"""PettingZoo's parallel and AEC environments, and VectorArena, the batch as arrays, over the engine.

- parallel: PettingZoo's parallel environment; aec: the same hunter by hunter. vector: VectorArena.
- spaces: the spaces, and the check of an action against them. infos: made when somebody asks for them.
  saved: the check of a saved state.
- global_state: R7.3's view of a whole arena.
- registration: every scenario under a name of PettingZoo's, by `import catch_arena`.
"""

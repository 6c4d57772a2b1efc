"""PettingZoo's parallel and AEC environments, and VectorArena, the batch as arrays, over the engine.

- parallel: PettingZoo's parallel environment; aec: the same hunter by hunter. vector: VectorArena.
- actions: the check of what agents give. results: the dictionaries that they get. spaces: the spaces of both.
- agent_names: what agents are called.
- recorder: episodes as replays. display: frames, a window, a notebook. saved: states that are kept, and their check.
- global_state: R7.3's view of a whole arena.
- registration: every scenario under a name of PettingZoo's, by `import catch_arena`.
"""

"""PettingZoo's parallel and AEC environments, and VectorArena, the batch as arrays, over the engine.

- parallel: PettingZoo's parallel environment. aec: PettingZoo's AEC environment. vector: VectorArena.
- actions: check of actions. dictionaries: actions, observations, rewards and infos by agent. spaces: spaces of both.
- registration: every scenario under a name of PettingZoo's, once it is imported.
"""

"""Frozen learned agents, the opponents of the suite `catch_arena_ladder_v1`; scripts/ladder.py writes the files.

A file's name says its scenario, its side, the seed of its training, and its age in thousands of decisions:
`ladder.tag_prey_1_400k` is an agent for any tournament. Agents for prey hunt as the hunters of the same training run.
"""

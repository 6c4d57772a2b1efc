"""Goes to a target with its team-mate by a trained network, where a catch needs two hunters.

PPO trained one seat in `partners`, with and against together and its earlier versions (examples/train_sides.py): 2.5
million decisions, seed 2. So it plays with team-mates that it has not met. It has not met the held-out opponents.
"""

from catch_arena.agents.ladder.partners_seat_2_2514k import Agent

__all__ = ["Agent"]

"""Infos of a step: the parts of a reward stand in the rulebook's order, and later steps do not change them."""

import dataclasses
import json

from catch_arena import parallel_env
from catch_arena.config import PreyRewardWeights, RewardWeights
from catch_arena.core.state import PART_NAMES, PREY_PART_NAMES


def test_parts_stand_in_the_order_of_the_rulebook():
    """That of the fields of the weights, of both sides."""
    env = parallel_env("tag")
    env.reset(seed=5)
    env._engine.parts[0], env._engine.prey_parts[0] = range(len(PART_NAMES)), range(3)
    infos = env._results.infos(())

    assert infos["hunter_1"]["reward_parts"].tolist() == list(range(len(PART_NAMES)))
    assert infos["prey_0"]["reward_parts"].tolist() == list(range(3))
    assert tuple(field.name for field in dataclasses.fields(RewardWeights)) == PART_NAMES
    assert tuple(field.name for field in dataclasses.fields(PreyRewardWeights)) == PREY_PART_NAMES


def test_later_steps_do_not_change_infos():
    env, again = parallel_env("crowd"), parallel_env("crowd")
    env.reset(seed=5)
    again.reset(seed=5)
    kept, seen = [], []
    for _ in range(60):
        actions = dict.fromkeys(env.agents, 1)
        kept.append(env.step(actions)[4])
        seen.append(json.dumps(again.step(actions)[4], default=lambda array: array.tolist()))

    assert [json.dumps(infos, default=lambda array: array.tolist()) for infos in kept] == seen
    assert len(set(seen)) == 60

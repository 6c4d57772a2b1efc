"""Infos of a step stay as they are while later steps are played."""

import json

from catch_arena import parallel_env


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

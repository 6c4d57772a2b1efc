"""Matches that the tests of this folder draw."""

import catch_arena
from catch_arena.replay import Replay


def played(scenario: str = "standard", *, seed: int = 3, names=None, title: str = "", **overrides: object) -> Replay:
    """A match in which everybody chases the nearest target, with any settings; who drives itself does so at random."""
    env = catch_arena.parallel_env(scenario, **overrides)
    env.record(names, title)
    _, infos = env.reset(seed=seed)
    for place, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(place)
    chasing = dict.fromkeys(env.possible_agents, False)  # prey drives itself
    chasing |= {
        agent: control == "target" for agent, control in zip(env.config.hunter_names, env.config.controls, strict=True)
    }
    while env.agents:
        actions = {
            agent: int(infos[agent]["action_mask"][1]) if chasing[agent] else env.action_space(agent).sample()
            for agent in env.agents
        }
        _, _, _, _, infos = env.step(actions)
    return env.replay()

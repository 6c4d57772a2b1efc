"""Episodes of parallel envs, step by step."""

import numpy as np


def chase(env, infos):
    """Actions of all agents: hunters want the nearest target, prey drives in arcs."""
    return {
        agent: int(infos[agent]["action_mask"][1]) if agent.startswith("hunter") else np.array([0.6, 0.4], np.float32)
        for agent in env.agents
    }


def chased(env, seed):
    """(agents before, what `step` gives) of each step of one episode."""
    _, infos = env.reset(seed=seed)
    while env.agents:
        agents = list(env.agents)
        step = env.step(chase(env, infos))
        infos = step[-1]
        yield agents, step

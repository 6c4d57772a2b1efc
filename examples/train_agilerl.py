"""AgileRL: IPPO and MADDPG over the parallel env, in AgileRL's vector env."""

from agilerl.algorithms import IPPO, MADDPG
from agilerl.components.replay_buffer import ReplayBuffer
from agilerl.training.train_multi_agent_off_policy import train_multi_agent_off_policy
from agilerl.training.train_multi_agent_on_policy import train_multi_agent_on_policy
from agilerl.vector.pz_async_vec_env import AsyncPettingZooVecEnv

import catch_arena


def make() -> catch_arena.parallel_env:
    """Return a duel with empty infos, since AgileRL accepts no arrays in infos."""
    return catch_arena.parallel_env("duel", infos="none", max_cycles=30)


if __name__ == "__main__":
    plain = make()
    spaces = {
        "observation_spaces": [plain.observation_space(agent) for agent in plain.possible_agents],
        "action_spaces": [plain.action_space(agent) for agent in plain.possible_agents],
        "agent_ids": plain.possible_agents,
    }
    quiet = {"max_steps": 120, "evo_steps": 120, "eval_steps": 30, "verbose": False, "wb": False}
    env = AsyncPettingZooVecEnv([make, make])  # closed by the training
    agents, _ = train_multi_agent_on_policy(env, "duel", "IPPO", [IPPO(**spaces, learn_step=60)], **quiet)
    assert agents[0].steps >= 120
    env, learner = AsyncPettingZooVecEnv([make, make]), MADDPG(**spaces, batch_size=32, learn_step=20, vect_noise_dim=2)
    agents, _ = train_multi_agent_off_policy(env, "duel", "MADDPG", [learner], ReplayBuffer(1000), **quiet)
    assert agents[0].steps >= 120

"""Tianshou: DQN for each of two hunters over the AEC env, with masks in the observations."""

import torch
from tianshou.algorithm import DQN
from tianshou.algorithm.modelfree.dqn import DiscreteQLearningPolicy
from tianshou.algorithm.multiagent.marl import MultiAgentOffPolicyAlgorithm
from tianshou.algorithm.optim import AdamOptimizerFactory
from tianshou.data import Collector, VectorReplayBuffer
from tianshou.env import DummyVectorEnv, PettingZooEnv
from tianshou.utils.net.common import Net

import catch_arena

torch.manual_seed(1)


def make() -> PettingZooEnv:
    """Return the AEC env in Tianshou's wrapper."""
    return PettingZooEnv(catch_arena.env("duel", mask_in_observation=True, infos="none", max_cycles=30))


env = make()
width = env.observation_space["observation"].shape


def learner() -> DQN:
    """Return the DQN learner of one hunter."""
    policy = DiscreteQLearningPolicy(
        model=Net(state_shape=width, action_shape=env.action_space.n, hidden_sizes=[64]),
        action_space=env.action_space,
        eps_training=0.2,
    )
    return DQN(policy=policy, optim=AdamOptimizerFactory(lr=1e-3), target_update_freq=100)


learners = [learner(), learner()]
before = [[weights.detach().clone() for weights in one.policy.parameters()] for one in learners]
both = MultiAgentOffPolicyAlgorithm(algorithms=learners, env=env)
collector = Collector(both, DummyVectorEnv([make, make]), VectorReplayBuffer(4000, 2), exploration_noise=True)
collector.reset()
for _ in range(2):
    found = collector.collect(n_step=120)
    with both.policy.torch_train_mode() if hasattr(both.policy, "torch_train_mode") else torch.enable_grad():
        both.policy.is_within_training_step = True
        both.update(buffer=collector.buffer, sample_size=64)
assert found.n_collected_steps >= 120
for one, old in zip(learners, before, strict=True):
    assert any((weights != was).any() for weights, was in zip(one.policy.parameters(), old, strict=True))

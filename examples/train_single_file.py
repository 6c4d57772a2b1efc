"""Single file in the style of CleanRL: PPO with masks over `GymnasiumVectorEnv`, without a training library."""

import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical

from catch_arena.training import GymnasiumVectorEnv

STEPS, ITERATIONS, EPOCHS, GAMMA, LAMBDA, CLIP = 32, 6, 3, 0.99, 0.95, 0.2

torch.manual_seed(1)
torch.set_num_threads(1)
envs = GymnasiumVectorEnv("standard", 32, opponents=["nearest", "patrol"], normalise=True, max_cycles=60)
rows, width = envs.observation_space.shape
choices = int(envs.single_action_space.n)
body = nn.Sequential(nn.Linear(width, 64), nn.Tanh())
actor, critic = nn.Linear(64, choices), nn.Linear(64, 1)
optimizer = torch.optim.Adam([*body.parameters(), *actor.parameters(), *critic.parameters()], 1e-3)


def policy(observations: torch.Tensor, masks: torch.Tensor) -> Categorical:
    """Return the distribution over choices; illegal ones are never drawn."""
    return Categorical(logits=actor(body(observations)).masked_fill(~masks, -1e9))


observations, infos = envs.reset(seed=1)
ended = 0
for _ in range(ITERATIONS):
    seen, masks, acted = torch.zeros(STEPS, rows, width), torch.zeros(STEPS, rows, choices).bool(), []
    chances, values, rewards, dones = (torch.zeros(STEPS, rows) for _ in range(4))
    for step in range(STEPS):
        seen[step], masks[step] = torch.from_numpy(observations), torch.from_numpy(infos["action_mask"])
        with torch.no_grad():
            drawn = policy(seen[step], masks[step])
            actions = drawn.sample()
            values[step] = critic(body(seen[step]))[:, 0]
        chances[step] = drawn.log_prob(actions)
        acted.append(actions)
        observations, gained, terminations, truncations, infos = envs.step(actions.numpy())
        rewards[step] = torch.from_numpy(gained)
        dones[step] = torch.from_numpy(terminations | truncations)
        if truncations.any():  # at a time limit the value of the final state counts
            with torch.no_grad():
                following = critic(body(torch.from_numpy(infos["final_obs"])))[:, 0]
            rewards[step] += GAMMA * following * torch.from_numpy(truncations & ~terminations)
            ended += int(truncations.sum())
    with torch.no_grad():
        following = critic(body(torch.from_numpy(observations)))[:, 0]
    advantages, running = torch.zeros(STEPS, rows), torch.zeros(rows)
    for step in reversed(range(STEPS)):
        going_on = 1 - dones[step]
        running = rewards[step] + GAMMA * following * going_on - values[step] + GAMMA * LAMBDA * going_on * running
        advantages[step], following = running, values[step]
    for _ in range(EPOCHS):
        drawn = policy(seen, masks)
        ratio = (drawn.log_prob(torch.stack(acted)) - chances).exp()
        scaled = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        gain = torch.minimum(ratio * scaled, ratio.clamp(1 - CLIP, 1 + CLIP) * scaled).mean()
        error = (critic(body(seen))[..., 0] - advantages - values).square().mean()
        optimizer.zero_grad()
        (error - gain - 0.01 * drawn.entropy().mean()).backward()
        optimizer.step()
assert ended >= 32 * (STEPS * ITERATIONS // 60)
assert np.isfinite(float(error.detach()))
print("mean reward", float(rewards.mean()))

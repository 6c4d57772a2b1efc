"""TorchRL: the specs of the parallel and the AEC env, and masked PPO over `TorchRLEnv` with opponents."""

import contextlib

import torch
from tensordict.nn import TensorDictModule
from tensordict.nn.probabilistic import InteractionType
from torchrl.collectors import Collector
from torchrl.envs import PettingZooWrapper
from torchrl.envs.utils import check_env_specs
from torchrl.modules import MaskedCategorical, ProbabilisticActor
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

import catch_arena
from catch_arena.errors import ConfigError
from catch_arena.training import TorchRLEnv
from catch_arena.training.torchrl import GROUP

torch.manual_seed(1)
torch.set_num_threads(1)

for infos in ("full", "mask", "none"):
    for control in ("target", "velocity"):
        parallel = catch_arena.parallel_env("duel", infos=infos, control=control, max_cycles=20)
        check_env_specs(PettingZooWrapper(parallel))
agents = PettingZooWrapper(
    catch_arena.env("duel", infos="none", mask_in_observation=True, max_cycles=20), use_mask=True
)
check_env_specs(agents)
agents.rollout(30)
for settings in ({}, {"opponents": ["nearest", "patrol"], "learners": 2, "normalise": True}, {"control": "velocity"}):
    check_env_specs(TorchRLEnv("standard", 3, max_cycles=20, **settings))

with contextlib.suppress(ConfigError):  # an arena that has ended waits until TorchRL resets it
    TorchRLEnv("duel", 2, auto_reset=True)
    raise AssertionError("an env that never resets was made")

env = TorchRLEnv("standard", 16, opponents=["nearest", "patrol"], normalise=True, max_cycles=60)
seen, choices = env.batch.observation_space.shape[0], int(env.batch.action_space.n)


def network(outputs: int) -> torch.nn.Module:
    """Return a small MLP."""
    return torch.nn.Sequential(torch.nn.Linear(seen, 64), torch.nn.Tanh(), torch.nn.Linear(64, outputs))


actor = ProbabilisticActor(
    TensorDictModule(network(choices), in_keys=[(GROUP, "observation")], out_keys=[(GROUP, "logits")]),
    in_keys={"logits": (GROUP, "logits"), "mask": (GROUP, "action_mask")},
    out_keys=[(GROUP, "action")],
    distribution_class=MaskedCategorical,
    default_interaction_type=InteractionType.RANDOM,
    return_log_prob=True,
    log_prob_key=(GROUP, "log_prob"),
)
critic = TensorDictModule(network(1), in_keys=[(GROUP, "observation")], out_keys=[(GROUP, "value")])
loss = ClipPPOLoss(actor, critic, normalize_advantage=True)
keys = {"reward": (GROUP, "reward"), "done": (GROUP, "done"), "terminated": (GROUP, "terminated")}
loss.set_keys(
    action=(GROUP, "action"),
    sample_log_prob=(GROUP, "log_prob"),
    value=(GROUP, "value"),
    advantage=(GROUP, "advantage"),
    value_target=(GROUP, "target"),
    **keys,
)
advantages = GAE(gamma=0.99, lmbda=0.95, value_network=critic)
advantages.set_keys(value=(GROUP, "value"), advantage=(GROUP, "advantage"), value_target=(GROUP, "target"), **keys)
optimizer = torch.optim.Adam(loss.parameters(), 1e-3)
before = [weights.detach().clone() for weights in actor.parameters()]
for data in Collector(env, actor, frames_per_batch=16 * 64, total_frames=16 * 64 * 5):
    assert data[GROUP, "action_mask"].gather(-1, data[GROUP, "action"][..., None]).all()
    for name in ("done", "terminated"):  # an arena ends for all of its learners together
        shape = data["next", GROUP, "reward"].shape
        data["next", GROUP, name] = data["next", name][..., None].expand(shape)
    with torch.no_grad():
        advantages(data)
    for _ in range(4):
        values = loss(data)
        total = values["loss_objective"] + values["loss_critic"] + values["loss_entropy"]
        optimizer.zero_grad()
        total.backward()
        optimizer.step()
assert any((old != new).any() for old, new in zip(before, actor.parameters(), strict=True))
print("mean reward", float(data["next", GROUP, "reward"].mean()))

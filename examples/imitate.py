"""Copy an agent into a network that decides velocities: `python examples/imitate.py ppo_destination --out runs/copy`.

The network plays, and learns what the agent would do in the states that it reaches (DAgger: Ross et al., 2011). Then
`python examples/train_ppo.py --head velocity --start runs/copy/agent.npz` trains it further.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before the imports below, which take seconds

import argparse

import numpy as np
import train_ppo as ppo  # which names torch if it is missing
from train_ppo import torch

from catch_arena.policy import control_of
from catch_arena.tournament.agent_spec import resolve
from catch_arena.tournament.loading import create_policy
from catch_arena.training.destinations import destinations

DECISIONS = 400_000  # number of decisions that are copied
KEPT = 256  # number of rounds from which the network learns
NOISE = 0.1  # standard deviation that is added to the velocities, so that more states are met


@ppo.errors_in_one_line("imitate")
def main() -> None:
    """Train a network to decide as the agent, and write it as an agent."""
    parser = argparse.ArgumentParser(description=__doc__, epilog="The other options are those of train_ppo.py.")
    parser.add_argument("agent", help="agent to copy, with act_batch and velocity control")
    given, others = parser.parse_known_args()
    settings, _ = ppo.settings_from(["--head", "velocity", *others])
    teacher = create_policy(resolve(given.agent).spec)
    if not hasattr(teacher, "act_batch") or control_of(teacher) != "velocity":
        raise ValueError(f"agent must have act_batch and velocity control, got {given.agent}")
    teacher.reset(settings.seed)
    torch.set_num_threads(1)
    torch.manual_seed(settings.seed)
    arenas, network = ppo.Arenas(settings), ppo.Network(settings.head, settings.hidden, settings.prior)
    optimiser = torch.optim.Adam(network.parameters(), ppo.RATE, eps=1e-5)
    kept: list[tuple[tuple[torch.Tensor, ...], torch.Tensor]] = []
    rounds = -(-DECISIONS // arenas.batch.num_rows)
    for moment in range(rounds):
        seen, label = destinations(arenas.view), np.array(teacher.act_batch(arenas.view))
        kept = [*kept[1 - KEPT :], (ppo.tensors(seen), torch.from_numpy(label))]
        with torch.no_grad():
            _, mean, _ = network(*kept[-1][0])
        velocity = mean.numpy() if moment * 5 > rounds else label  # the teacher drives at first
        arenas.play(seen, velocity + np.random.default_rng(moment).normal(0, NOISE, velocity.shape))
        for place in np.random.default_rng(moment).integers(0, len(kept), 4):
            inputs, wanted = kept[place]
            loss = (network(*inputs)[1] - wanted).square().mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        if moment % 100 == 0:
            print(f"round {moment} of {rounds}, loss {loss.item():.4f}", flush=True)
    ppo.export(network.agent(), settings.out, "agent")
    print(f"{settings.out / 'agent.py'}: catch-arena check-agent {settings.out / 'agent.py'}")


if __name__ == "__main__":
    interrupts.run(main)

"""Train an agent by PPO, against scripted agents and its past selves: `python examples/train_ppo.py --out runs/first`.

The method is proximal policy optimisation (Schulman et al., 2017), with the details of Huang et al., "The 37
Implementation Details of PPO", 2022. A past self that wins more is drawn more often (prioritised fictitious self-play:
Vinyals et al., "Grandmaster level in StarCraft II", 2019). Tournaments against fixed agents measure the progress,
because the score against oneself stays the same while both sides improve.

Files in --out: `agent.py` and `agent.npz`, an agent for any tournament; `curve.csv`, the tournaments; `progress.csv`,
one row per update; `state.pt`, from which --resume continues.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before the imports below, which take seconds

import csv
import os
import subprocess
import sys
import time
from argparse import ArgumentDefaultsHelpFormatter, ArgumentParser, Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads would wait for those of torch and of other runs

import numpy as np

from catch_arena.errors import CatchArenaError, install_hint

try:
    import torch
    from torch import Tensor, nn
except ModuleNotFoundError:
    sys.exit(f"{Path(sys.argv[0]).stem}: torch is not installed: {install_hint('train')}")

from catch_arena.batch_policy import BatchView
from catch_arena.config import RULESET, RewardWeights
from catch_arena.files import prepare_folder, whole_file
from catch_arena.geometry import own_frame, world_frame
from catch_arena.policy import Limits
from catch_arena.scenarios import scenario
from catch_arena.steering import drive_each
from catch_arena.training import LearnerBatch
from catch_arena.training.destinations import VERSION, Destinations, destinations
from catch_arena.training.flat import FlatAgent
from catch_arena.training.opponents import Opponents
from catch_arena.training.pointer import CONTROL_OF, QUERIES, Head, PointerAgent, PointerNetwork, weight_shapes

ARENAS = 256  # stepped together
HORIZON = 64  # decisions of each learner in a rollout
EPOCHS = 3  # number of times that a rollout is learned from
MINIBATCH = 2048  # decisions in a gradient step
RATE = 5e-4  # learning rate at the beginning; it falls linearly to a twentieth
GAMMA = 0.985  # discount of a step
LAMBDA = 0.9  # of generalised advantage estimation (Schulman et al., 2016)
CLIP = 0.2  # limit of the change of a probability ratio in an update
ENTROPY = 0.002  # weight of the entropy in the loss
SPREAD = 0.3  # initial standard deviation of the velocities, with the head velocity
SNAPSHOT = 300_000  # decisions between two past selves
MOST_SELVES = 6  # past selves in the pool: the strongest
AGAINST = ("patrol", "contested_by_time", "contested")  # opponents in the tournaments
MAY_CHANGE = ("out", "resume", "decisions", "evaluate", "evaluate_rounds")  # options that --resume may change
SAVED = ("decisions", "seconds", "progress", "curve")  # attributes of a learner in state.pt
STATE_VERSION = f"{RULESET}, features {VERSION}, trainer 3"  # of state.pt; another one is refused


def settings_from(arguments: list[str]) -> tuple[Namespace, dict[str, Any] | None]:
    """Return the options of a command line, and with --resume the saved state, whose options are the defaults."""
    parser = ArgumentParser(description=(__doc__ or "").splitlines()[0], formatter_class=ArgumentDefaultsHelpFormatter)
    add = parser.add_argument
    add("--out", type=Path, default=Path("runs/ppo"), help="folder of the run")
    add("--resume", action="store_true", help="continue the run in --out")
    add("--head", choices=CONTROL_OF, default="destination", help="output of the network")
    add("--scenario", default="standard", help="scenario to learn in")
    add("--opponents", default=",".join(AGAINST), help="agents in the other seats, separated by commas")
    add("--self-play", type=float, default=0.3, help="share of the other seats that past selves play")
    add("--decisions", type=int, default=4_000_000, help="number of decisions in the whole run")
    add("--seed", type=int, default=1, help="seed of the network and the arenas")
    add("--hold", type=int, default=2, help="number of steps for which a decision holds")
    add("--hidden", type=int, default=64, help="units of each layer")
    add("--prior", type=float, default=0.0, help="added to the logit of the candidate that a scripted agent would take")
    add("--start", default="", help=".npz file with the first weights")
    add("--evaluate", type=int, default=1_000_000, help="decisions between tournaments; 0 for no tournaments")
    add("--evaluate-rounds", type=int, default=6, help="rounds of a tournament, of 4 matches each")
    settings = parser.parse_args(arguments)
    for name in ("decisions", "hold", "hidden", "evaluate_rounds"):
        if getattr(settings, name) < 1:
            parser.error(f"--{name.replace('_', '-')} must be at least 1, got {getattr(settings, name)}")
    if not settings.resume:
        return settings, None
    state = torch.load(settings.out / "state.pt", weights_only=True)  # runs no code of the file
    if state["version"] != STATE_VERSION:
        raise ValueError(f"{settings.out / 'state.pt'} is of another version; begin a new run")
    parser.set_defaults(**state["settings"])
    settings = parser.parse_args(arguments)
    for name, began in state["settings"].items():
        if name not in MAY_CHANGE and getattr(settings, name) != began:
            parser.error(f"--{name.replace('_', '-')} must be {began}, as in the saved run; leave it out")
    return settings, state


class Network(nn.Module):
    """Actor, which is `PointerNetwork` in torch, and critic, which reads the first layer of the actor."""

    def __init__(self, head: Head, hidden: int, prior: float) -> None:
        super().__init__()
        self.head = head
        self.weights = nn.ParameterDict()
        for name, shape in weight_shapes(head, hidden).items():
            if name != "prior":
                self.weights[name] = nn.Parameter(torch.randn(shape) * (shape[0] ** -0.5 if len(shape) == 2 else 0.0))
        self.weights["prior"] = nn.Parameter(torch.tensor(prior), requires_grad=False)
        self.weights["logit"] = nn.Parameter(torch.randn(hidden) * 0.01)  # small, so that a prior decides at first
        self.log_spread = nn.Parameter(torch.full((2,), float(np.log(SPREAD))))
        self.attend = nn.Linear(hidden, QUERIES, bias=False)
        self.value = nn.Sequential(nn.Linear(QUERIES * hidden, hidden), nn.ReLU(), nn.Linear(hidden, 1))

    def forward(self, features: Tensor, legal: Tensor, preferred: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Compute log-probabilities of the candidates (N, C), mean velocities (N, 2) and values (N,)."""
        w = self.weights
        rows, candidates, width = features.shape
        hidden = torch.relu(torch.addmm(w["encode_bias"], features.reshape(-1, width), w["encode"]))
        table = hidden.view(rows, candidates, -1)
        common = torch.addmm(w["mix_bias"], pooled(hidden @ w["attend"], table, legal), w["pool"])
        mixed = torch.relu((hidden @ w["mix"]).view(rows, candidates, -1) + common[:, None])
        logits = mixed @ w["logit"] + w["prior"] * nn.functional.one_hot(preferred, candidates)
        if not logits.isfinite().all():
            raise ValueError("the network's output is not finite; lower RATE in train_ppo.py")
        log_p = torch.log_softmax(logits.masked_fill(~legal, -1e9), -1)
        mean = log_p.new_zeros(rows, 2)
        if self.head == "velocity":
            drives = torch.tanh(mixed @ w["drive"] + w["drive_bias"])
            mean = (drives * log_p.exp()[..., None]).sum(1)
        return log_p, mean, self.value(pooled(self.attend(table.flatten(0, 1)), table, legal))[:, 0]

    def judge(self, log_p: Tensor, mean: Tensor, choices: Tensor, velocities: Tensor) -> tuple[Tensor, Tensor]:
        """Return the log-probability of each decision, and the entropy: (N,) each."""
        if self.head == "velocity":
            normal = torch.distributions.Normal(mean, self.log_spread.exp(), validate_args=False)
            return normal.log_prob(velocities).sum(1), normal.entropy().sum(1)
        entropy = -(log_p.exp() * log_p.clamp(min=-20)).sum(1)
        return log_p.gather(1, choices[:, None])[:, 0], entropy

    def agent(self) -> PointerAgent:
        """Return the actor in NumPy, which does not explore."""
        weights = {name: one.detach().numpy().copy() for name, one in self.weights.items()}
        return PointerAgent(PointerNetwork(self.head, weights))

    def load_actor(self, actor: PointerNetwork) -> None:
        """Copy the weights of an actor; weights that it lacks stay as they are."""
        if len(self.weights["logit"]) != (given := len(actor.weights["logit"])):
            raise ValueError(f"--hidden must be {given}, as in --start, got {len(self.weights['logit'])}")
        self.weights.load_state_dict({name: torch.from_numpy(one) for name, one in actor.weights.items()}, strict=False)


def pooled(scores: Tensor, table: Tensor, legal: Tensor) -> Tensor:
    """Return the mean of the candidates for each query, weighted by a softmax of its scores: (N, QUERIES * H)."""
    weights = scores.view(*legal.shape, QUERIES).masked_fill(~legal[..., None], -1e9).softmax(1)
    return torch.bmm(weights.transpose(1, 2), table).flatten(1)


def tensors(seen: Destinations) -> tuple[Tensor, Tensor, Tensor]:
    """Return the inputs of the network."""
    return torch.from_numpy(seen.features), torch.from_numpy(seen.legal), torch.from_numpy(seen.preferred)


class Pool:
    """Scripted agents and past selves; one that wins more is drawn more often."""

    def __init__(self, opponents: Opponents, self_play: float) -> None:
        self.opponents, self.self_play, self.scripted = opponents, self_play, len(opponents.names)
        self.beaten = np.full(self.scripted, 0.5)  # share of wins of the learner against each: a moving average
        self.alive = np.ones(self.scripted, np.bool_)

    def count(self, figures: dict[str, np.ndarray]) -> None:
        """Count matches that have ended."""
        own, rivals = figures["score"][:, None], figures["opponent_scores"]
        beaten = np.where(own == rivals, 0.5, own > rivals)
        for opponent in np.unique(figures["opponents"]):
            share = beaten[figures["opponents"] == opponent].mean()
            self.beaten[opponent] += 0.05 * (share - self.beaten[opponent])

    def grow(self, agent: PointerAgent) -> None:
        """Add the present self, and retire the weakest if there are too many."""
        self.opponents.add(agent)
        self.beaten, self.alive = np.append(self.beaten, 0.5), np.append(self.alive, True)
        present = np.flatnonzero(self.alive[self.scripted :]) + self.scripted
        if len(present) > MOST_SELVES:
            self.alive[present[self.beaten[present].argmax()]] = False

    def weigh(self) -> None:
        """Give more weight to an opponent that wins more."""
        hard = np.where(self.alive, (1 - self.beaten) ** 2 + 0.05, 0)
        share = self.self_play if len(hard) > self.scripted else 0.0
        hard[: self.scripted] *= (1 - share) / hard[: self.scripted].sum()
        if share:
            hard[self.scripted :] *= share / hard[self.scripted :].sum()
        self.opponents.weigh(hard)


class Arenas:
    """A batch of arenas in which a decision holds for some steps."""

    def __init__(self, settings: Namespace) -> None:
        config = scenario(settings.scenario, control=CONTROL_OF[settings.head])
        rivals = config.hunters - (1 if config.teams is None else len(config.teams[0]))
        config = config.replace(rewards=RewardWeights(catch=1.0, rival_catch=-1 / max(1, rivals)))  # zero-sum
        if len({Limits.of(config, seat) for seat in range(config.hunters)}) > 1 or config.prey:
            raise ValueError(f"--scenario must have equal hunters and no prey, got {settings.scenario}")
        self.head, self.hold, self.limits = settings.head, settings.hold, Limits.of(config)
        self.batch = LearnerBatch(config, ARENAS, opponents=settings.opponents.split(","), distinct=True)
        self.pool = Pool(self.batch.opponents, settings.self_play)
        self.observations, self.masks = self.batch.reset(settings.seed)
        # the arenas start at different times of their matches, so that each rollout has all parts of a match
        lead = np.random.default_rng(settings.seed).integers(0, config.max_steps, ARENAS)
        for t in range(0, config.max_steps, self.hold):
            seen = destinations(self.view)
            self.play(seen, seen.preferred)
            self.observations, self.masks = self.batch.reset(arenas=lead // self.hold == t // self.hold)
        self.pool.beaten[:] = 0.5  # the learner has not played yet

    @property
    def view(self) -> BatchView:
        """Observations of all learners."""
        return BatchView(self.observations, self.masks.astype(np.int8), self.limits)

    def play(self, seen: Destinations, decision: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Play these candidates (N,) or velocities (N, 2) for --hold steps; return rewards and ended matches, (N,)."""
        by_velocity = decision.ndim == 2
        rows, choice = np.arange(len(decision)), seen.preferred if by_velocity else decision
        forward, left = seen.forward[rows, choice], seen.left[rows, choice]
        x, y, cosine, sine = self.observations.T[:4].astype(np.float64)
        dx, dy = world_frame(cosine, sine, forward, left)
        east, north = x + dx, y + dy
        rewards, ended = np.zeros(len(choice), np.float32), np.zeros(len(choice), np.bool_)
        for turn in range(self.hold):
            if by_velocity:
                action: Any = np.clip(decision, -1, 1)
            elif self.head == "rank":
                action = choice if turn == 0 else self.rank_at(forward, left, choice > 0)
            else:
                action = drive_each(forward, left, choice < seen.places, self.limits)
            step = self.batch.step(action)
            rewards += np.where(ended, 0, step.rewards)
            ended |= step.terminations | step.truncations
            if len(step.ended):
                self.pool.count(step.figures)
            self.observations, self.masks = step.observations, step.masks
            x, y, cosine, sine = self.observations.T[:4].astype(np.float64)
            forward, left = own_frame(cosine, sine, east - x, north - y)
        return rewards, ended

    def rank_at(self, forward: np.ndarray, left: np.ndarray, chased: np.ndarray) -> np.ndarray:
        """Return the present rank of the target at this place, which may have changed; 0 if it is gone."""
        targets = self.view.targets
        off = (targets.forward - forward[:, None]) ** 2 + (targets.left - left[:, None]) ** 2
        off = np.where((targets.present > 0) & self.masks[:, 1:], off, np.inf)
        return np.where(chased & (off.min(axis=1) < 0.5**2), off.argmin(axis=1) + 1, 0)


@torch.no_grad()
def rollout(arenas: Arenas, network: Network) -> tuple[Tensor, ...]:
    """Play T decisions of N learners, and return the inputs of the network, choices, velocities, log-probabilities,
    values, rewards and ends of matches: (T, N, ...) each; and the values (N,) of the states after them.
    """
    kept = []
    for _ in range(HORIZON):
        seen = destinations(arenas.view)
        inputs = tensors(seen)
        every, mean, value = network(*inputs)
        by_velocity = network.head == "velocity"
        choice = every.argmax(1) if by_velocity else torch.multinomial(every.exp(), 1)[:, 0]
        velocity = mean + network.log_spread.exp() * torch.randn_like(mean)
        log_p, _ = network.judge(every, mean, choice, velocity)
        reward, ended = arenas.play(seen, (velocity if by_velocity else choice).numpy())
        kept.append((*inputs, choice, velocity, log_p, value, torch.from_numpy(reward), torch.from_numpy(ended)))
    following = network(*tensors(destinations(arenas.view)))[2]
    return *map(torch.stack, zip(*kept, strict=True)), following


def advantages_of(rewards: Tensor, ended: Tensor, values: Tensor, following: Tensor, gamma: float) -> Tensor:
    """Estimate the advantages (GAE): (T, N). No value follows the time limit, which is in view all along."""
    result, running = torch.zeros_like(values), torch.zeros_like(following)
    for t in reversed(range(len(values))):
        going_on = 1 - ended[t].float()
        error = rewards[t] + gamma * going_on * following - values[t]
        running = error + gamma * LAMBDA * going_on * running
        result[t], following = running, values[t]
    return result


def improve(network: Any, optimiser: Any, played: list[Tensor], bonus: float = ENTROPY) -> dict[str, Any]:
    """Make some epochs of PPO with N decisions, and return figures of the last minibatch.

    `played` has the network's inputs, choices, velocities, their log-probabilities, advantages and returns: (N, ...).
    `bonus` is the weight of the entropy in the loss.
    """
    *seen, choices, velocities, before, advantages, returns = played
    advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(before)).split(MINIBATCH):
            every, mean, value = network(*(part[rows] for part in seen))
            log_p, entropy = network.judge(every, mean, choices[rows], velocities[rows])
            ratio = (log_p - before[rows]).exp()
            clipped = ratio.clamp(1 - CLIP, 1 + CLIP)
            gain = torch.minimum(ratio * advantages[rows], clipped * advantages[rows]).mean()
            error = (value - returns[rows]).square().mean()
            optimiser.zero_grad()
            (0.5 * error - gain - bonus * entropy.mean()).backward()
            nn.utils.clip_grad_norm_(network.parameters(), 0.5)
            optimiser.step()
    return {"gain": gain.item(), "value_error": error.item(), "entropy": entropy.mean().item()}


AGENT = '''"""Agent that PPO has trained; its weights are in the .npz file next to this one."""

from pathlib import Path

{hunts}from {module} import {base}


class {kind}({base}):
    """Agent that plays as its network decides."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"){trained})
'''
HUNTS = "from catch_arena.agents.nearest import Agent as Agent  # each entrant of a tournament hunts too\n"


class Learner:
    """Side that learns: its network, its arenas, and the number of decisions so far."""

    def __init__(self, settings: Namespace) -> None:
        self.settings, self.out = settings, settings.out
        self.arenas, self.network = Arenas(settings), Network(settings.head, settings.hidden, settings.prior)
        self.pool = self.arenas.pool
        self.optimiser = torch.optim.Adam(self.network.parameters(), RATE, eps=1e-5)
        self.decisions, self.seconds = 0, 0.0
        self.progress: list[dict[str, Any]] = []
        self.curve: list[dict[str, Any]] = []

    def update(self) -> None:
        """Play, learn, let the pool grow if it is time, report, and save the run."""
        begun, settings = time.perf_counter(), self.settings
        self.optimiser.param_groups[0]["lr"] = RATE * max(0.05, 1 - self.decisions / settings.decisions)
        *parts, rewards, ended, following = rollout(self.arenas, self.network)
        advantages = advantages_of(rewards, ended, parts[-1], following, GAMMA**settings.hold)
        *decided, values, advantages = (part.flatten(0, 1) for part in (*parts, advantages))
        figures = improve(self.network, self.optimiser, [*decided, advantages, advantages + values])
        before = self.decisions
        self.decisions += HORIZON * self.arenas.batch.num_rows
        if settings.self_play and self.decisions // SNAPSHOT > before // SNAPSHOT:
            self.pool.grow(self.network.agent())
        self.pool.weigh()
        self.seconds = round(self.seconds + time.perf_counter() - begun, 3)
        figures["wins"] = float(self.pool.beaten[: self.pool.scripted].mean())
        self.progress.append({"decisions": self.decisions, "seconds": self.seconds, **figures})
        shown = [f"{name} {value:,.2f}" for name, value in figures.items()]
        print(f"{self.decisions:,} decisions, {self.seconds:.0f} s: {', '.join(shown)}", flush=True)
        self.save()

    def evaluate(self) -> None:
        """Play a tournament against fixed agents, and add it to curve.csv."""
        folder, rounds = self.out / "evaluation" / str(self.decisions), str(self.settings.evaluate_rounds)
        export(self.network.agent(), folder, "ppo")
        command = [sys.executable, "-m", "catch_arena", "tournament", str(folder / "ppo.py"), *AGAINST]
        command += ["--scenario", self.settings.scenario, "--rounds", rounds, "--seed", str(10**6 + self.settings.seed)]
        command += ["--trusted", "--force", "--out", str(folder / "results")]
        print(f"playing a tournament after {self.decisions:,} decisions", flush=True)
        if subprocess.Popen(command, start_new_session=True).wait():  # after Ctrl-C `interrupts` ends it
            raise OSError(f"the tournament after {self.decisions:,} decisions failed")
        when = {"decisions": self.decisions, "seconds": self.seconds}
        with (folder / "results" / "standings.csv").open(newline="") as file:
            self.curve += [when | row for row in csv.DictReader(file)]
        self.save()

    def save(self) -> None:
        """Write the agent, the tables and state.pt."""
        export(self.network.agent(), self.out, "agent")
        for name in ("progress", "curve"):
            if rows := getattr(self, name):
                with whole_file(self.out / f"{name}.csv") as file:
                    table = csv.DictWriter(TextIOWrapper(file, newline="", write_through=True), list(rows[0]))
                    table.writeheader()
                    table.writerows(rows)
        selves = [player.policy.network for player in self.pool.opponents.pool[self.pool.scripted :]]
        state = {name: getattr(self, name) for name in SAVED} | {
            "version": STATE_VERSION,
            "settings": vars(self.settings) | {"out": str(self.out)},
            "network": self.network.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "selves": [{name: torch.tensor(w) for name, w in one.weights.items()} for one in selves],
            "beaten": self.pool.beaten.tolist(),
            "alive": self.pool.alive.tolist(),
            "random": torch.get_rng_state(),
        }
        with whole_file(self.out / "state.pt") as file:
            torch.save(state, file)

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from the state that `save` wrote."""
        for name in SAVED:
            setattr(self, name, state[name])
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        for weights in state["selves"]:
            network = PointerNetwork(self.settings.head, {name: one.numpy() for name, one in weights.items()})
            self.pool.grow(PointerAgent(network))
        self.pool.beaten, self.pool.alive = np.array(state["beaten"]), np.array(state["alive"])
        self.pool.weigh()
        torch.set_rng_state(state["random"])


def export(agent: PointerAgent | FlatAgent, folder: Path, name: str, *, prey: bool = False) -> None:
    """Write an agent for any tournament: its file, and its weights next to it."""
    agent.network.save(prepare_folder(folder) / f"{name}.npz")
    trained = f', "{agent.trained}"' if isinstance(agent, FlatAgent) else ""
    words = {"kind": "Prey", "hunts": HUNTS} if prey else {"kind": "Agent", "hunts": ""}
    words |= {"module": type(agent).__module__, "base": type(agent).__name__, "trained": trained}
    (folder / f"{name}.py").write_text(AGENT.format(**words))


@contextmanager
def errors_in_one_line(program: str) -> Iterator[None]:
    """End the program with one line after an expected error."""
    try:
        yield
    except (CatchArenaError, ValueError, OSError) as error:
        sys.exit(f"{program}: {error}")


@errors_in_one_line("train_ppo")
def main() -> None:
    """Train to the last decision, with a tournament after every --evaluate decisions."""
    settings, state = settings_from(sys.argv[1:])
    if state is None and (settings.out / "state.pt").exists():
        raise ValueError(f"--out must be a new folder, or give --resume: a run is kept in {settings.out}")
    torch.set_num_threads(1)
    torch.manual_seed(settings.seed)
    learner = Learner(settings)
    interrupts.add_to_message("each finished update is kept; --resume continues")
    if state is not None:
        learner.restore(state)
    elif settings.start:
        learner.network.load_actor(PointerNetwork.load(settings.start))
    while True:
        evaluated, every = learner.curve[-1]["decisions"] if learner.curve else 0, settings.evaluate
        if every and learner.decisions // every > evaluated // every:
            learner.evaluate()
        if learner.decisions >= settings.decisions:
            break
        learner.update()
    print(f"{settings.out / 'agent.py'}: catch-arena check-agent {settings.out / 'agent.py'}", flush=True)


if __name__ == "__main__":
    interrupts.run(main)

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

import argparse
import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

# past selves play in NumPy, whose threads would wait for those of torch and of other runs
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from catch_arena.errors import CatchArenaError, install_hint

try:
    import torch
    from torch import Tensor, nn
except ModuleNotFoundError:
    sys.exit(f"train_ppo: torch is not installed: {install_hint('train')}")

from catch_arena.batch_policy import BatchView
from catch_arena.config import RULESET, RewardWeights
from catch_arena.files import prepare_folder, whole_file
from catch_arena.policy import Limits, control_of
from catch_arena.scenarios import scenario
from catch_arena.tournament.agent_spec import resolve_spec
from catch_arena.tournament.loading import create_policy
from catch_arena.training import LearnerBatch
from catch_arena.training.destinations import VERSION, Destinations, destinations
from catch_arena.training.pointer import CONTROL_OF, QUERIES, PointerAgent, PointerNetwork, drive, weight_shapes

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
IMITATED = 400_000  # decisions that are copied from the agent of --imitate
SNAPSHOT = 300_000  # decisions between two past selves, and between two saved states
MOST_SELVES = 6  # past selves in the pool: the strongest
AGAINST = ("patrol", "contested_by_time", "contested")  # opponents in the tournaments
MAY_CHANGE = ("out", "resume", "decisions", "evaluate", "evaluate_rounds")  # options that --resume may change
STATE_VERSION = f"{RULESET}, features {VERSION}, trainer 2"  # of state.pt; another one is refused


def settings_from(arguments: list[str]) -> tuple[argparse.Namespace, dict[str, Any] | None]:
    """Return the options of a command line, and with --resume the saved state, whose options are the defaults."""
    about, form = (__doc__ or "").partition("\n\n")[0], argparse.ArgumentDefaultsHelpFormatter
    parser = argparse.ArgumentParser(usage="%(prog)s [options]", description=about, formatter_class=form)
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
    add("--imitate", default="", help="agent with act_batch to copy first, with --head velocity")
    add("--evaluate", type=int, default=1_000_000, help="decisions between tournaments; 0 for no tournaments")
    add("--evaluate-rounds", type=int, default=6, help="rounds of a tournament, of 4 matches each")
    settings = parser.parse_args(arguments)
    if settings.imitate and settings.head != "velocity":
        parser.error("--imitate needs --head velocity: agents do not show the target that they go to")
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

    def __init__(self, settings: argparse.Namespace) -> None:
        super().__init__()
        self.head, hidden = settings.head, settings.hidden
        self.weights = nn.ParameterDict()
        for name, shape in weight_shapes(self.head, hidden).items():
            if name != "prior":
                self.weights[name] = nn.Parameter(torch.randn(shape) * (shape[0] ** -0.5 if len(shape) == 2 else 0.0))
        self.weights["logit"] = nn.Parameter(torch.randn(hidden) * 0.01)  # small, so that a prior decides at first
        self.log_spread = nn.Parameter(torch.full((2,), float(np.log(SPREAD))))
        self.attend = nn.Linear(hidden, QUERIES, bias=False)
        self.value = nn.Sequential(nn.Linear(QUERIES * hidden, hidden), nn.ReLU(), nn.Linear(hidden, 1))
        self.register_buffer("prior", torch.tensor(settings.prior))

    def forward(self, features: Tensor, legal: Tensor, preferred: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Compute log-probabilities of the candidates (N, C), mean velocities (N, 2) and values (N,)."""
        w = self.weights
        rows, candidates, width = features.shape
        hidden = torch.relu(torch.addmm(w["encode_bias"], features.reshape(-1, width), w["encode"]))
        table = hidden.view(rows, candidates, -1)
        common = torch.addmm(w["mix_bias"], pooled(hidden @ w["attend"], table, legal), w["pool"])
        mixed = torch.relu((hidden @ w["mix"]).view(rows, candidates, -1) + common[:, None])
        logits = mixed @ w["logit"] + self.prior * nn.functional.one_hot(preferred, candidates)
        if not logits.isfinite().all():
            raise FloatingPointError("the network's output is not finite; lower RATE in train_ppo.py")
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

    def actor(self) -> PointerNetwork:
        """Return the actor in NumPy."""
        weights = {**self.weights, "prior": self.prior}
        return PointerNetwork(self.head, {name: value.detach().numpy().copy() for name, value in weights.items()})

    def load_actor(self, actor: PointerNetwork) -> None:
        """Copy the weights of an actor; weights that it lacks stay as they are."""
        if len(self.weights["logit"]) != (given := len(actor.weights["logit"])):
            raise ValueError(f"--hidden must be {given}, as in --start, got {len(self.weights['logit'])}")
        for name in self.weights.keys() & actor.weights.keys():
            self.weights[name].data = torch.from_numpy(actor.weights[name].copy())
        self.prior.fill_(float(actor.weights["prior"]))


def pooled(scores: Tensor, table: Tensor, legal: Tensor) -> Tensor:
    """Return the mean of the candidates for each query, weighted by a softmax of its scores: (N, QUERIES * H)."""
    weights = scores.view(*legal.shape, QUERIES).masked_fill(~legal[..., None], -1e9).softmax(1)
    return torch.bmm(weights.transpose(1, 2), table).flatten(1)


def tensors(seen: Destinations) -> tuple[Tensor, Tensor, Tensor]:
    """Return the inputs of the network."""
    return torch.from_numpy(seen.features), torch.from_numpy(seen.legal), torch.from_numpy(seen.preferred)


class Arenas:
    """A batch of arenas in which a decision holds for some steps."""

    def __init__(self, settings: argparse.Namespace) -> None:
        config = scenario(settings.scenario, control=CONTROL_OF[settings.head])
        rivals = config.hunters - (1 if config.teams is None else len(config.teams[0]))
        config = config.replace(rewards=RewardWeights(catch=1.0, rival_catch=-1 / max(1, rivals)))  # zero-sum
        if len({Limits.of(config, seat) for seat in range(config.hunters)}) > 1 or config.prey:
            raise ValueError(f"--scenario must have equal hunters and no prey, got {settings.scenario}")
        self.head, self.hold, self.limits = settings.head, settings.hold, Limits.of(config)
        self.batch = LearnerBatch(config, ARENAS, opponents=settings.opponents.split(","), distinct=True)
        self.observations, self.masks = self.batch.reset(settings.seed)
        self.results: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        # the arenas start at different times of their matches, so that each rollout has all parts of a match
        lead = np.random.default_rng(settings.seed).integers(0, config.max_steps, ARENAS)
        for t in range(0, config.max_steps, self.hold):
            seen = destinations(self.view)
            self.play(seen, seen.preferred)
            late = np.flatnonzero((lead >= t) & (lead < t + self.hold))
            if len(late):
                self.observations, self.masks = self.batch.reset(arenas=late)
        self.results.clear()

    @property
    def view(self) -> BatchView:
        """Observations of all learners."""
        return BatchView(self.observations, self.masks.astype(np.int8), self.limits)

    def play(
        self, seen: Destinations, choice: np.ndarray, velocity: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Play one decision: these candidates (N,), or these velocities (N, 2).

        Returns:
            the rewards, and if the match has ended meanwhile: (N,) each.
        """
        rows = np.arange(len(choice))
        forward, left = seen.forward[rows, choice], seen.left[rows, choice]
        x, y, cosine, sine = self.observations.T[:4].astype(np.float64)
        east, north = x + cosine * forward - sine * left, y + sine * forward + cosine * left
        rewards, ended = np.zeros(len(choice), np.float32), np.zeros(len(choice), np.bool_)
        for turn in range(self.hold):
            if velocity is not None:
                action: Any = np.clip(velocity, -1, 1)
            elif self.head == "rank":
                action = choice if turn == 0 else self.rank_at(forward, left, choice > 0)
            else:
                action = drive(forward, left, choice < seen.places, self.limits)
            step = self.batch.step(action)
            rewards += np.where(ended, 0, step.rewards)
            ended |= step.terminations | step.truncations
            if len(step.ended):
                self.results.append((step.figures["opponents"], step.figures["score"], step.figures["opponent_scores"]))
            self.observations, self.masks = step.observations, step.masks
            x, y, cosine, sine = self.observations.T[:4].astype(np.float64)
            forward = cosine * (east - x) + sine * (north - y)
            left = cosine * (north - y) - sine * (east - x)
        return rewards, ended

    def rank_at(self, forward: np.ndarray, left: np.ndarray, chased: np.ndarray) -> np.ndarray:
        """Return the present rank of the target at this place, which may have changed; 0 if it is gone."""
        targets = self.view.targets
        off = (targets.forward - forward[:, None]) ** 2 + (targets.left - left[:, None]) ** 2
        off = np.where((targets.present > 0) & self.masks[:, 1:], off, np.inf)
        return np.where(chased & (off.min(axis=1) < 0.5**2), off.argmin(axis=1) + 1, 0)


@torch.no_grad()
def rollout(arenas: Arenas, network: Network) -> tuple[Tensor, ...]:
    """Play T decisions of N learners.

    Returns:
        the three inputs of the network, choices, velocities, log-probabilities, values, rewards, and if the match has
        ended: (T, N, ...) each; and the values (N,) of the states after them.
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
        reward, ended = arenas.play(seen, choice.numpy(), velocity.numpy() if by_velocity else None)
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


def learn(played: tuple[Tensor, ...], network: Network, optimiser: torch.optim.Adam, gamma: float) -> dict[str, Any]:
    """Make some epochs of PPO, and return figures of the rollout and of the last minibatch."""
    *parts, rewards, ended, following = played
    *seen, choices, velocities, before, values = (part.flatten(0, 1) for part in parts)
    advantages = advantages_of(rewards, ended, parts[-1], following, gamma)
    returns = advantages.flatten() + values
    advantages = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).flatten()
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(before)).split(MINIBATCH):
            every, mean, value = network(*(part[rows] for part in seen))
            log_p, entropy = network.judge(every, mean, choices[rows], velocities[rows])
            ratio = (log_p - before[rows]).exp()
            clipped = ratio.clamp(1 - CLIP, 1 + CLIP)
            gain = torch.minimum(ratio * advantages[rows], clipped * advantages[rows]).mean()
            error = (value - returns[rows]).square().mean()
            optimiser.zero_grad()
            (0.5 * error - gain - ENTROPY * entropy.mean()).backward()
            nn.utils.clip_grad_norm_(network.parameters(), 0.5)
            optimiser.step()
    figures = {"gain": gain.item(), "value_error": error.item(), "entropy": entropy.mean().item()}
    explained = 1 - float((returns - values).var() / (returns.var() + 1e-8))
    return figures | {"explained": explained, "reward": float(rewards.sum()) / rewards.numel()}


def imitate(arenas: Arenas, network: Network, agent: str, seed: int) -> float:
    """Copy an agent in the states that the network itself reaches (DAgger: Ross et al., 2011); return the time [s]."""
    begun = time.perf_counter()
    teacher = create_policy(resolve_spec(agent))
    if not hasattr(teacher, "act_batch") or control_of(teacher) != "velocity":
        raise ValueError(f"--imitate must name an agent with act_batch and velocity control, got {agent}")
    teacher.reset(seed)
    optimiser = torch.optim.Adam(network.parameters(), RATE, eps=1e-5)
    kept: list[tuple[tuple[Tensor, ...], Tensor]] = []
    rounds = -(-IMITATED // arenas.batch.num_rows)
    for moment in range(rounds):
        seen, label = destinations(arenas.view), np.array(teacher.act_batch(arenas.view))
        kept = [*kept[-255:], (tensors(seen), torch.from_numpy(label))]
        with torch.no_grad():
            every, mean, _ = network(*kept[-1][0])
        velocity = mean.numpy() if moment * 5 > rounds else label  # the teacher drives at first
        noise = np.random.default_rng(moment).normal(0, 0.1, velocity.shape)
        arenas.play(seen, every.argmax(1).numpy(), velocity + noise)
        for place in np.random.default_rng(moment).integers(0, len(kept), 4):
            inputs, wanted = kept[place]
            loss = (network(*inputs)[1] - wanted).square().mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        if moment % 100 == 0:
            print(f"imitating {agent}: round {moment} of {rounds}, loss {loss.item():.4f}", flush=True)
    return time.perf_counter() - begun


class Pool:
    """Scripted agents and past selves, each with the probability of being drawn."""

    def __init__(self, arenas: Arenas, settings: argparse.Namespace) -> None:
        self.arenas, self.self_play = arenas, settings.self_play
        self.scripted = len(settings.opponents.split(","))
        self.selves: list[PointerNetwork] = []
        self.beaten = np.full(self.scripted, 0.5)  # share of wins of the learner against each: a moving average
        self.alive = np.ones(self.scripted, np.bool_)

    def grow(self, network: PointerNetwork) -> None:
        """Add the present self, and retire the weakest if there are too many."""
        self.selves.append(network)
        self.beaten, self.alive = np.append(self.beaten, 0.5), np.append(self.alive, True)
        self.arenas.batch.opponents.add(PointerAgent(network))
        present = np.flatnonzero(self.alive[self.scripted :]) + self.scripted
        if len(present) > MOST_SELVES:
            self.alive[present[self.beaten[present].argmax()]] = False

    def weigh(self) -> None:
        """Give more weight to an opponent that wins more."""
        hard = np.where(self.alive, (1 - self.beaten) ** 2 + 0.05, 0)
        share = self.self_play if self.selves else 0.0
        hard[: self.scripted] *= (1 - share) / hard[: self.scripted].sum()
        if self.selves:
            hard[self.scripted :] *= share / hard[self.scripted :].sum()
        self.arenas.batch.opponents.weigh(hard)

    def count_results(self) -> dict[str, float | None]:
        """Count the matches that have ended, and return their mean score and share of wins."""
        scores, wins = [], []
        for opponents, own, opponent_scores in self.arenas.results:
            beaten = np.where(own[:, None] == opponent_scores, 0.5, own[:, None] > opponent_scores)
            for opponent in np.unique(opponents):
                self.beaten[opponent] += 0.05 * (beaten[opponents == opponent].mean() - self.beaten[opponent])
            best = opponent_scores.max(axis=1)
            shared = 1 / (1 + (opponent_scores == best[:, None]).sum(1))
            scores.append(own.mean())
            wins.append(np.where(own > best, 1, np.where(own == best, shared, 0)).mean())
        self.arenas.results.clear()
        return {name: float(np.mean(of)) if of else None for name, of in (("score", scores), ("wins", wins))}


AGENT = '''"""Agent that examples/train_ppo.py has trained; its weights are in the .npz file next to it."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    control = "{control}"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
'''
COLUMNS = ("agent", "matches", "rating", "rating_low", "rating_high", "win_share", "win_share_low", "win_share_high")


class Learner:
    """Side that learns: its network, its opponents, and the number of decisions so far."""

    KEPT = ("decisions", "seconds", "progress", "curve")

    def __init__(self, arenas: Arenas, settings: argparse.Namespace) -> None:
        self.arenas, self.settings, self.out = arenas, settings, settings.out
        self.network, self.pool = Network(settings), Pool(arenas, settings)
        self.optimiser = torch.optim.Adam(self.network.parameters(), RATE, eps=1e-5)
        self.decisions, self.seconds = 0, 0.0
        self.progress: list[dict[str, Any]] = []
        self.curve: list[dict[str, Any]] = []

    def update(self) -> None:
        """Play, learn, report, and grow the pool and save the run if it is time."""
        begun, settings, before = time.perf_counter(), self.settings, self.decisions
        self.optimiser.param_groups[0]["lr"] = RATE * max(0.05, 1 - before / settings.decisions)
        played = rollout(self.arenas, self.network)
        figures = learn(played, self.network, self.optimiser, GAMMA**settings.hold) | self.pool.count_results()
        made = HORIZON * self.arenas.batch.num_rows
        self.decisions = before + made
        snapshot = self.decisions // SNAPSHOT > before // SNAPSHOT
        if snapshot and settings.self_play:
            self.pool.grow(self.network.actor())
        self.pool.weigh()
        spent = time.perf_counter() - begun
        self.seconds += spent
        figures["agent_steps_per_s"] = made * settings.hold * self.arenas.batch.config.hunters / spent
        self.progress.append({"decisions": self.decisions, "seconds": round(self.seconds, 1), **figures})
        write_table(self.out / "progress.csv", self.progress)
        shown = [f"{name} {value:,.2f}" for name, value in figures.items() if value is not None]
        print(f"{self.decisions:,} decisions, {self.seconds:.0f} s: {', '.join(shown)}", flush=True)
        if snapshot or self.decisions >= settings.decisions:
            self.save()

    def evaluate(self) -> None:
        """Play a tournament against fixed agents, and add it to curve.csv."""
        self.save()  # in case that the tournament fails
        folder, rounds = self.out / "evaluation" / str(self.decisions), str(self.settings.evaluate_rounds)
        export(self.network.actor(), folder, "ppo")
        command = [sys.executable, "-m", "catch_arena", "tournament", str(folder / "ppo.py"), *AGAINST]
        command += ["--scenario", self.settings.scenario, "--rounds", rounds, "--seed", str(10**6 + self.settings.seed)]
        command += ["--trusted", "--force", "--out", str(folder / "results")]
        print(f"playing a tournament after {self.decisions:,} decisions", flush=True)
        with (folder / "log.txt").open("wb") as log:
            failed = subprocess.Popen(command, stdout=log, stderr=log).wait()  # after Ctrl-C `interrupts` ends it
        if failed:
            raise OSError(f"the tournament after {self.decisions:,} decisions failed; see {folder / 'log.txt'}")
        when = {"decisions": self.decisions, "seconds": round(self.seconds, 1)}
        standings = json.loads((folder / "results" / "standings.json").read_text())["standings"]
        self.curve += [when | {name: row[name] for name in COLUMNS} for row in standings]
        write_table(self.out / "curve.csv", self.curve)
        own = next(row for row in standings if row["agent"] == "ppo")
        print(f"rating {own['rating']:.0f}, wins {100 * own['win_share']:.0f} %", flush=True)
        self.save()

    def save(self) -> None:
        """Write the agent and state.pt; each file is complete or stays as it was."""
        export(self.network.actor(), self.out, "agent")
        state = {name: getattr(self, name) for name in self.KEPT} | {
            "version": STATE_VERSION,
            "settings": vars(self.settings) | {"out": str(self.out)},
            "network": self.network.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "selves": [{name: torch.tensor(w) for name, w in one.weights.items()} for one in self.pool.selves],
            "beaten": self.pool.beaten.tolist(),
            "alive": self.pool.alive.tolist(),
            "random": torch.get_rng_state(),
        }
        with whole_file(self.out / "state.pt") as file:
            torch.save(state, file)

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from the state that `save` wrote."""
        for name in self.KEPT:
            setattr(self, name, state[name])
        if self.decisions >= self.settings.decisions:
            raise ValueError(f"--decisions must be above {self.decisions:,}, which the run has reached")
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        for weights in state["selves"]:
            self.pool.grow(PointerNetwork(self.settings.head, {name: one.numpy() for name, one in weights.items()}))
        self.pool.beaten, self.pool.alive = np.array(state["beaten"]), np.array(state["alive"])
        self.pool.weigh()
        torch.set_rng_state(state["random"])


def export(network: PointerNetwork, folder: Path, name: str) -> None:
    """Write an agent for any tournament: its file, and its weights next to it."""
    network.save(prepare_folder(folder) / f"{name}.npz")
    (folder / f"{name}.py").write_text(AGENT.format(control=CONTROL_OF[network.head]))


def write_table(path: Path, rows: list[dict[str, Any]]) -> None:
    """Write rows as a CSV file."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


def train() -> None:
    """Train to the last decision, with a tournament after every --evaluate decisions."""
    settings, state = settings_from(sys.argv[1:])
    if state is None and (settings.out / "state.pt").exists():
        raise ValueError(f"--out must be a new folder, or give --resume: a run is kept in {settings.out}")
    torch.set_num_threads(1)
    torch.manual_seed(settings.seed)
    learner = Learner(Arenas(settings), settings)
    prepare_folder(settings.out)
    interrupts.add_to_message(lambda: f"after {learner.decisions:,} decisions; --resume continues")
    if state is not None:
        learner.restore(state)
    else:
        if settings.start:
            learner.network.load_actor(PointerNetwork.load(settings.start))
        if settings.imitate:
            learner.seconds = imitate(learner.arenas, learner.network, settings.imitate, settings.seed)
            learner.save()
    try:
        while True:
            evaluated, every = learner.curve[-1]["decisions"] if learner.curve else 0, settings.evaluate
            if every and learner.decisions // every > evaluated // every:
                learner.evaluate()
            if learner.decisions >= settings.decisions:
                break
            interrupts.run_uninterrupted(learner.update)  # Ctrl-C does not break off an update
    except KeyboardInterrupt:
        interrupts.run_uninterrupted(learner.save)
        raise
    print(f"{settings.out / 'agent.py'}: catch-arena check-agent {settings.out / 'agent.py'}", flush=True)


def main() -> None:
    """Train; an error is one line."""
    try:
        train()
    except (CatchArenaError, ValueError, OSError, FloatingPointError) as error:
        sys.exit(f"train_ppo: {error}")


if __name__ == "__main__":
    interrupts.run(main)

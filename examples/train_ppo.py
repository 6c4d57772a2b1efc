"""Train an agent by PPO, against scripted agents and its past selves: `python examples/train_ppo.py --out runs/first`.

The file reads from top to bottom: settings, network, arenas, rollout, update, pool of opponents, evaluation, loop.
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
import dataclasses
import json
import math
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# past selves play in NumPy, whose threads would wait for those of torch and of other runs
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from catch_arena.errors import CatchArenaError, install_hint

try:
    import torch
    from torch import Tensor, nn
    from torch.optim import Adam
except ModuleNotFoundError:
    sys.exit(f"train_ppo: it needs torch, which is not installed: {install_hint('train')}")

from catch_arena.batch_policy import BatchView
from catch_arena.config import RULESET, RewardWeights
from catch_arena.files import prepare_folder, whole_file, write_whole
from catch_arena.policy import Limits, control_of
from catch_arena.scenarios import scenario as arena_config
from catch_arena.tournament.agent_spec import resolve_spec
from catch_arena.tournament.loading import create_policy
from catch_arena.training import LearnerBatch
from catch_arena.training.destinations import VERSION, Destinations, destinations
from catch_arena.training.pointer import CONTROL_OF, QUERIES, PointerAgent, PointerNetwork, drive, weight_shapes

# settings


def option(default: Any, meaning: str, least: float | None = None, most: float = math.inf) -> Any:
    """Return a field of `Settings`, which is also a command-line option."""
    return dataclasses.field(default=default, metadata={"help": meaning, "least": least, "most": most})


@dataclass(frozen=True)
class Settings:
    """Settings of a run; each is an option of the same name."""

    out: Path = option(Path("runs/ppo"), "Folder of the run.")  # noqa: RUF009 - it returns a field
    head: str = option("destination", 'Output: "destination" for a scripted driver, "rank" of a target, or "velocity".')
    scenarios: str = option("standard", "Where it learns; several, separated by commas, take turns.")
    opponents: str = option("patrol,contested_by_time,contested", "Scripted agents in the other seats.")
    self_play: float = option(0.3, "Share of the other seats that past selves play.", 0, 1)
    decisions: int = option(4_000_000, "Decisions in all.", 1)
    seed: int = option(1, "Seed of the networks, the arenas and all that is drawn.", 0, 2**62)
    imitate: str = option("", "Agent with act_batch to copy first, with the head rank or velocity.")
    imitate_decisions: int = option(400_000, "Decisions that it copies.", 1)
    start: str = option("", "An .npz file to begin from.")
    arenas: int = option(256, "Arenas in lockstep.", 1)
    horizon: int = option(64, "Decisions of each learner in a rollout.", 2)
    hold: int = option(2, "Steps for which a decision holds.", 1)
    hidden: int = option(64, "Units of each layer.", 1)
    prior: float = option(0.0, "Added to the logit of the candidate that a scripted agent would take.", 0, 1e6)
    rate: float = option(5e-4, "Learning rate at the beginning; it falls linearly to a twentieth.", 0)
    gamma: float = option(0.985, "Discount of a step.", 0, 1)
    trace: float = option(0.9, "Lambda of generalised advantage estimation (Schulman et al., 2016).", 0, 1)
    clip: float = option(0.2, "Limit of the change of a probability ratio in an update.", 0, 1)
    entropy: float = option(0.002, "Weight of the entropy.", 0)
    epochs: int = option(3, "Number of times that each decision is learned from.", 1)
    minibatch: int = option(2048, "Decisions in a gradient step.", 1)
    spread: float = option(0.3, "Initial standard deviation of the velocities, with the head velocity.", 0.001, 1e6)
    snapshot: int = option(300_000, "Decisions from one past self, and one save of the run, to the next.", 1)
    most_selves: int = option(6, "Past selves that stay in the pool: the strongest.", 1)
    evaluate: int = option(1_000_000, "Decisions from one tournament to the next; 0 for no tournaments.", 0)
    evaluate_rounds: int = option(6, "Rounds of a tournament; 4 matches each if four agents play.", 1)
    evaluate_against: str = option("patrol,contested_by_time,contested", "Its opponents in tournaments.")
    threads: int = option(1, "Threads of torch.", 1)

    def __post_init__(self) -> None:
        if self.head not in CONTROL_OF:
            raise ValueError(f"--head must be one of {', '.join(CONTROL_OF)}, got {self.head!r}")
        if self.imitate and self.head == "destination":
            raise ValueError("--imitate needs the head rank or velocity: agents do not show where they want to go")
        for field in dataclasses.fields(self):
            value, least, most = getattr(self, field.name), field.metadata["least"], field.metadata["most"]
            if least is not None and not least <= value <= most:
                raise ValueError(f"{flag(field.name)} must be in [{least}, {most}], got {value}")


MAY_CHANGE = ("out", "decisions", "threads", "evaluate", "evaluate_rounds", "evaluate_against")
"""Settings that --resume may change."""


def flag(name: str) -> str:
    """Return the command-line option of a setting."""
    return f"--{name.replace('_', '-')}"


def settings_from(arguments: list[str]) -> tuple[Settings, dict[str, Any] | None]:
    """Return the settings of a command line, and with --resume the saved state, whose settings are the defaults."""
    parser = argparse.ArgumentParser(usage="%(prog)s [options]", description=(__doc__ or "").partition("\n\n")[0])
    for field in dataclasses.fields(Settings):
        meaning = f"{field.metadata['help']} Default: {'none' if field.default == '' else field.default}"
        metavar = {Path: "FOLDER", int: "N", float: "X", str: "TEXT"}[field.type]
        parser.add_argument(flag(field.name), type=field.type, default=argparse.SUPPRESS, metavar=metavar, help=meaning)
    parser.add_argument("--resume", action="store_true", help="Continue the run in --out.")
    given = vars(parser.parse_args(arguments))
    if not given.pop("resume"):
        return Settings(**given), None
    state = read_state(given.get("out", Settings.out) / "state.pt")
    began = state["settings"]
    for name, value in given.items():
        if name not in MAY_CHANGE and began[name] != value:
            raise ValueError(f"{flag(name)} must be {began[name]}, as the run began, got {value}")
    return Settings(**{**began, "out": Settings.out, **given}), state


# the network


class Network(nn.Module):
    """Actor, which is `PointerNetwork` in torch, and critic, which reads the first layer of the actor."""

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.weights = nn.ParameterDict()
        hidden = settings.hidden
        for name, shape in weight_shapes(settings.head, hidden).items():
            if name != "prior":
                self.weights[name] = nn.Parameter(torch.randn(shape) * (shape[0] ** -0.5 if len(shape) == 2 else 0.0))
        self.weights["logit"] = nn.Parameter(torch.randn(hidden) * 0.01)  # a prior decides at first
        self.log_spread = nn.Parameter(torch.full((2,), float(np.log(settings.spread))))
        self.attend = nn.Linear(hidden, QUERIES, bias=False)
        self.value = nn.Sequential(nn.Linear(QUERIES * hidden, hidden), nn.ReLU(), nn.Linear(hidden, 1))
        self.register_buffer("prior", torch.tensor(settings.prior))
        self.head = settings.head

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
            raise FloatingPointError("the network's output is not finite: a lower --rate may help")
        log_p = torch.log_softmax(logits.masked_fill(~legal, -1e9), -1)
        if self.head == "velocity":
            drives = torch.tanh(mixed @ w["drive"] + w["drive_bias"])
            mean = (drives * log_p.exp()[..., None]).sum(1)
        else:
            mean = log_p.new_zeros(rows, 2)
        return log_p, mean, self.value(pooled(self.attend(table.flatten(0, 1)), table, legal))[:, 0]

    def judge(self, log_p: Tensor, mean: Tensor, choices: Tensor, velocities: Tensor) -> tuple[Tensor, Tensor]:
        """Return the log-probability of each decision, and the entropy: (N,) each."""
        if self.head == "velocity":
            normal = torch.distributions.Normal(mean, self.log_spread.exp(), validate_args=False)
            return normal.log_prob(velocities).sum(1), normal.entropy().sum(1)
        entropy = -(log_p.exp() * log_p.clamp(min=-20)).sum(1)
        return log_p.gather(1, choices[:, None])[:, 0], entropy

    def exported(self) -> PointerNetwork:
        """Return the actor in NumPy."""
        weights = {**self.weights, "prior": self.prior}
        return PointerNetwork(self.head, {name: value.detach().numpy().copy() for name, value in weights.items()})

    def take(self, actor: PointerNetwork) -> None:
        """Copy the weights of an actor; those that it lacks stay as they are."""
        hidden, given = len(self.weights["logit"]), len(actor.weights["logit"])
        if hidden != given:
            raise ValueError(f"--hidden must be {given}, as in --start, got {hidden}")
        for name in self.weights.keys() & actor.weights.keys():
            self.weights[name].data = torch.from_numpy(actor.weights[name].copy())
        self.prior.fill_(float(actor.weights["prior"]))


def pooled(scores: Tensor, table: Tensor, legal: Tensor) -> Tensor:
    """Return the mean of the candidates for each query, weighted by a softmax of its scores: (N, QUERIES * H)."""
    weights = scores.view(*legal.shape, QUERIES).masked_fill(~legal[..., None], -1e9).softmax(1)
    return torch.bmm(weights.transpose(1, 2), table).flatten(1)


def tensors(seen: Destinations) -> tuple[Tensor, ...]:
    """Return the inputs of the network."""
    return tuple(map(torch.from_numpy, (seen.features, seen.legal, seen.preferred)))


# the arenas


class Arenas:
    """A batch of arenas of one scenario, in which a decision holds for some steps."""

    def __init__(self, name: str, settings: Settings, seed: int) -> None:
        config = arena_config(name, control=CONTROL_OF[settings.head])
        rivals = config.hunters - (1 if config.teams is None else len(config.teams[0]))
        config = config.replace(rewards=RewardWeights(catch=1.0, rival_catch=-1 / max(1, rivals)))  # zero-sum
        if len({Limits.of(config, seat) for seat in range(config.hunters)}) > 1 or config.prey:
            raise ValueError(f"--scenarios must be such that all hunters are alike and no prey is played, got {name}")
        self.name, self.settings, self.limits = name, settings, Limits.of(config)
        self.batch = LearnerBatch(config, settings.arenas, opponents=settings.opponents.split(","), distinct=True)
        self.observations, self.masks = self.batch.reset(seed)
        self.results: list[tuple[np.ndarray, ...]] = []
        # the arenas start at different times of their matches, so that each rollout has all parts of a match
        lead = np.random.default_rng(seed).integers(0, config.max_steps, self.batch.num_envs)
        for moment in range(0, config.max_steps, settings.hold):
            seen = destinations(self.view)
            self.play(seen, seen.preferred, None)
            late = np.flatnonzero((lead >= moment) & (lead < moment + settings.hold))
            if len(late):
                self.observations, self.masks = self.batch.reset(arenas=late)
        self.results.clear()

    @property
    def view(self) -> BatchView:
        """Observations of all learners."""
        return BatchView(self.observations, self.masks.astype(np.int8), self.limits)

    def play(
        self, seen: Destinations, choice: np.ndarray, velocity: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Play one decision: these candidates (N,), or these velocities (N, 2).

        Returns:
            the reward, and if the match has ended meanwhile: (N,) each.
        """
        rows = np.arange(len(choice))
        forward, left = seen.forward[rows, choice], seen.left[rows, choice]
        x, y, cosine, sine = self.observations.T[:4].astype(np.float64)
        east, north = x + cosine * forward - sine * left, y + sine * forward + cosine * left
        gained, ended = np.zeros(len(choice), np.float32), np.zeros(len(choice), np.bool_)
        for turn in range(self.settings.hold):
            if velocity is not None:
                action: Any = np.clip(velocity, -1, 1)
            elif self.settings.head == "rank":
                action = choice if turn == 0 else self.rank_at(forward, left, choice > 0)
            else:
                action = drive(forward, left, choice < seen.places, self.limits)
            step = self.batch.step(action)
            gained += np.where(ended, 0, step.rewards)
            ended |= step.terminations | step.truncations
            if len(step.ended):
                self.results.append((step.figures["opponents"], step.figures["score"], step.figures["opponent_scores"]))
            self.observations, self.masks = step.observations, step.masks
            x, y, cosine, sine = self.observations.T[:4].astype(np.float64)
            forward = cosine * (east - x) + sine * (north - y)
            left = cosine * (north - y) - sine * (east - x)
        return gained, ended

    def rank_at(self, forward: np.ndarray, left: np.ndarray, chased: np.ndarray) -> np.ndarray:
        """Return the present rank of the target at this place, which may have changed; 0 if it is gone."""
        targets = self.view.targets
        off = (targets.forward - forward[:, None]) ** 2 + (targets.left - left[:, None]) ** 2
        off = np.where((targets.present > 0) & self.masks[:, 1:], off, np.inf)
        return np.where(chased & (off.min(axis=1) < 0.5**2), off.argmin(axis=1) + 1, 0)


# a rollout


@dataclass
class Rollout:
    """T decisions of N learners, and the value (N,) of what follows."""

    seen: list[tuple[Tensor, ...]]
    choices: Tensor
    velocities: Tensor
    log_p: Tensor
    values: Tensor
    gained: Tensor
    ended: Tensor
    following: Tensor
    network_s: float = 0.0


@torch.no_grad()
def rollout(arenas: Arenas, network: Network) -> Rollout:
    """Play, and keep the candidates, decisions and rewards."""
    rows = (arenas.settings.horizon, arenas.batch.num_rows)
    seen, network_s, drives = [], 0.0, network.head == "velocity"
    choices, velocities = torch.zeros(rows, dtype=torch.int64), torch.zeros((*rows, 2))
    log_p, values, gained, ended = (torch.zeros(rows) for _ in range(4))
    for moment in range(rows[0]):
        arrays = destinations(arenas.view)
        seen.append(tensors(arrays))
        begun = time.perf_counter()
        every, mean, values[moment] = network(*seen[-1])
        choices[moment] = every.argmax(1) if drives else torch.multinomial(every.exp(), 1)[:, 0]
        velocities[moment] = mean + network.log_spread.exp() * torch.randn_like(mean)
        log_p[moment], _ = network.judge(every, mean, choices[moment], velocities[moment])
        network_s += time.perf_counter() - begun
        reward, over = arenas.play(arrays, choices[moment].numpy(), velocities[moment].numpy() if drives else None)
        gained[moment], ended[moment] = torch.from_numpy(reward), torch.from_numpy(over)
    following = network(*tensors(destinations(arenas.view)))[2]
    return Rollout(seen, choices, velocities, log_p, values, gained, ended, following, network_s)


# the update


def advantages_of(played: Rollout, settings: Settings) -> Tensor:
    """Estimate the advantages (GAE): (T, N). No value follows the time limit, which is in view all along."""
    gamma = settings.gamma**settings.hold
    result, running, following = torch.zeros_like(played.values), torch.zeros_like(played.following), played.following
    for moment in reversed(range(settings.horizon)):
        going_on = 1 - played.ended[moment]
        error = played.gained[moment] + gamma * going_on * following - played.values[moment]
        running = error + gamma * settings.trace * going_on * running
        result[moment], following = running, played.values[moment]
    return result


def learn(played: Rollout, network: Network, optimiser: Adam, settings: Settings) -> dict[str, Any]:
    """Make some epochs of PPO, and return figures of the last minibatch."""
    advantages = advantages_of(played, settings)
    returns = (advantages + played.values).flatten()
    advantages = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).flatten()
    seen = [torch.cat(parts) for parts in zip(*played.seen, strict=True)]
    choices, velocities = played.choices.flatten(), played.velocities.flatten(0, 1)
    before = played.log_p.flatten()
    for _ in range(settings.epochs):
        for rows in torch.randperm(len(before)).split(settings.minibatch):
            every, mean, values = network(*(part[rows] for part in seen))
            log_p, entropy = network.judge(every, mean, choices[rows], velocities[rows])
            ratio = (log_p - before[rows]).exp()
            clipped = ratio.clamp(1 - settings.clip, 1 + settings.clip)
            gain = torch.minimum(ratio * advantages[rows], clipped * advantages[rows]).mean()
            error = (values - returns[rows]).square().mean()
            optimiser.zero_grad()
            (0.5 * error - gain - settings.entropy * entropy.mean()).backward()
            nn.utils.clip_grad_norm_(network.parameters(), 0.5)
            optimiser.step()
    figures = {"gain": gain.item(), "value_error": error.item(), "entropy": entropy.mean().item()}
    return figures | {"explained": 1 - float((returns - played.values.flatten()).var() / (returns.var() + 1e-8))}


def imitate(arenas: Arenas, network: Network, optimiser: Adam, settings: Settings) -> None:
    """Copy an agent in the states that the network itself reaches (DAgger: Ross, Gordon and Bagnell, 2011)."""
    teacher, control = create_policy(resolve_spec(settings.imitate)), CONTROL_OF[settings.head]
    drives = settings.head == "velocity"
    if not hasattr(teacher, "act_batch") or control_of(teacher) != control:
        raise ValueError(f"--imitate must name an agent with act_batch and {control} control, got {settings.imitate}")
    teacher.reset(settings.seed)
    kept: list[tuple[tuple[Tensor, ...], Tensor]] = []
    rounds = -(-settings.imitate_decisions // arenas.batch.num_rows)
    for moment in range(rounds):
        arrays = destinations(arenas.view)
        label = np.array(teacher.act_batch(arenas.view))
        kept = [*kept[-255:], (tensors(arrays), torch.from_numpy(label))]
        with torch.no_grad():
            every, mean, _ = network(*kept[-1][0])
        choice, own = every.argmax(1).numpy(), moment * 5 > rounds  # the teacher drives at first
        if drives:
            velocity = mean.numpy() if own else label
            arenas.play(arrays, choice, velocity + np.random.default_rng(moment).normal(0, 0.1, velocity.shape))
        else:
            arenas.play(arrays, choice if own else label, None)
        for place in np.random.default_rng(moment).integers(0, len(kept), 4):
            seen, wanted = kept[place]
            every, mean, _ = network(*seen)
            loss = (mean - wanted).square().mean() if drives else nn.functional.nll_loss(every, wanted.long())
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        if moment % 100 == 0:
            print(f"imitating {settings.imitate}: round {moment} of {rounds}, loss {loss.item():.4f}", flush=True)


# the pool of opponents


class Pool:
    """Scripted agents and past selves, and how often each is drawn."""

    def __init__(self, arenas: list[Arenas], settings: Settings) -> None:
        self.arenas, self.settings = arenas, settings
        self.scripted = len(settings.opponents.split(","))
        self.selves: list[PointerNetwork] = []
        self.beaten = np.full(self.scripted, 0.5)  # how often the learner beats each: a moving average
        self.alive = np.ones(self.scripted, np.bool_)

    def grow(self, network: PointerNetwork) -> None:
        """Add the present self, and retire the weakest if there are too many."""
        self.selves.append(network)
        self.beaten, self.alive = np.append(self.beaten, 0.5), np.append(self.alive, True)
        for arenas in self.arenas:
            arenas.batch.opponents.add(PointerAgent(network))
        present = np.flatnonzero(self.alive[self.scripted :]) + self.scripted
        if len(present) > self.settings.most_selves:
            self.alive[present[self.beaten[present].argmax()]] = False
        self.weigh()

    def weigh(self) -> None:
        """Draw an opponent more often the more often it wins."""
        hard = np.where(self.alive, (1 - self.beaten) ** 2 + 0.05, 0)
        share = self.settings.self_play if self.selves else 0.0
        hard[: self.scripted] *= (1 - share) / hard[: self.scripted].sum()
        if self.selves:
            hard[self.scripted :] *= share / hard[self.scripted :].sum()
        for arenas in self.arenas:
            arenas.batch.opponents.weigh(hard)

    def note(self, arenas: Arenas) -> tuple[float | None, float | None]:
        """Count the matches that have ended, and return their mean score and share of wins, if there are any."""
        scores, wins = [], []
        for who, own, theirs in arenas.results:
            beaten = np.where(own[:, None] == theirs, 0.5, own[:, None] > theirs)
            for number in np.unique(who):
                self.beaten[number] += 0.05 * (beaten[who == number].mean() - self.beaten[number])
            best = theirs.max(axis=1)
            shared = 1 / (1 + (theirs == best[:, None]).sum(1))
            scores.append(own.mean())
            wins.append(np.where(own > best, 1, np.where(own == best, shared, 0)).mean())
        arenas.results.clear()
        return (float(np.mean(scores)), float(np.mean(wins))) if scores else (None, None)


# evaluation

AGENT = '''"""Agent that examples/train_ppo.py has trained; its weights are in the .npz file next to it."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    control = "{control}"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
'''
COLUMNS = ("agent", "matches", "rating", "rating_low", "rating_high", "win_share", "win_share_low", "win_share_high")


def export(network: PointerNetwork, folder: Path, name: str = "agent") -> None:
    """Write an agent for any tournament: its file, and its weights next to it."""
    network.save(prepare_folder(folder) / f"{name}.npz")
    write_whole(folder / f"{name}.py", AGENT.format(control=CONTROL_OF[network.head]).encode())


def evaluate(network: PointerNetwork, decisions: int, seconds: float, settings: Settings) -> None:
    """Play a tournament against fixed agents, and add it to curve.csv."""
    folder = settings.out / "evaluation" / str(decisions)
    export(network, folder, "ppo")
    command = [sys.executable, "-m", "catch_arena", "tournament", str(folder / "ppo.py")]
    command += [*settings.evaluate_against.split(","), "--scenario", settings.scenarios.split(",")[0]]
    command += ["--rounds", str(settings.evaluate_rounds), "--seed", str(1_000_000 + settings.seed)]
    command += ["--trusted", "--force", "--out", str(folder / "results")]
    print(f"playing a tournament after {decisions:,} decisions", flush=True)
    with (folder / "log.txt").open("wb") as log:
        failed = subprocess.Popen(command, stdout=log, stderr=log).wait()  # after Ctrl-C `interrupts` ends it
    if failed:
        print(f"train_ppo: the tournament after {decisions:,} decisions failed; see {folder / 'log.txt'}", flush=True)
        return
    standings = json.loads((folder / "results" / "standings.json").read_text())["standings"]
    when = {"decisions": decisions, "seconds": round(seconds, 1)}
    append(settings.out / "curve.csv", [when | {name: row[name] for name in COLUMNS} for row in standings])
    own = next(row for row in standings if row["agent"] == "ppo")
    print(f"rating {own['rating']:.0f}, wins {100 * own['win_share']:.0f} %", flush=True)


# files

STATE_VERSION = [RULESET, VERSION, *(field.name for field in dataclasses.fields(Settings))]
"""Ruleset, features and settings of a state; another state is refused."""


def append(path: Path, rows: list[dict[str, Any]]) -> None:
    """Add rows to a table, and before the first row the names of the columns."""
    with path.open("a", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        if file.tell() == 0:
            table.writeheader()
        table.writerows(rows)


def drop_after(path: Path, decisions: int) -> int:
    """Remove the rows that a run wrote after its last save; return the decisions of the last row, or 0."""
    head, *rows = (path.read_text() if path.exists() else "").splitlines(keepends=True) or [""]
    kept = [row for row in rows if int(row.partition(",")[0]) <= decisions]
    write_whole(path, "".join((head, *kept)).encode())
    return int(kept[-1].partition(",")[0]) if kept else 0


def read_state(path: Path) -> dict[str, Any]:
    """Read the state of a run: numbers, strings and tensors, so that reading it runs no code."""
    if not path.exists():
        raise ValueError(f"--resume needs a run to go on with, and there is no {path}")
    try:
        state: dict[str, Any] = torch.load(path, weights_only=True)
        known = state["version"] == STATE_VERSION
    except Exception:  # noqa: BLE001 - torch raises all kinds of errors for a damaged file
        known = False
    if not known:
        raise ValueError(f"{path} must be the state of a run of this version, and complete: begin a new run")
    return state


# the loop


class Run:
    """A run: the network, its opponents, and the number of decisions so far."""

    def __init__(self, settings: Settings, state: dict[str, Any] | None) -> None:
        if state is None and (settings.out / "state.pt").exists():
            raise ValueError(f"--out must be a new folder, or give --resume: a run is kept in {settings.out}")
        for name in settings.evaluate_against.split(","):
            resolve_spec(name)
        torch.set_num_threads(settings.threads)
        torch.manual_seed(settings.seed)
        prepare_folder(settings.out)
        names = settings.scenarios.split(",")
        self.settings, self.decisions, self.turn, self.evaluated = settings, 0, 0, 0
        self.arenas = [Arenas(name, settings, settings.seed + 1000 * place) for place, name in enumerate(names)]
        self.pool, self.network = Pool(self.arenas, settings), Network(settings)
        self.optimiser = Adam(self.network.parameters(), settings.rate, eps=1e-5)
        self.begun, self.earlier_s, self.network_s, self.agent_steps = time.perf_counter(), 0.0, 0.0, 0
        if state is not None:
            self.restore(state)
            return
        if settings.start:
            self.network.take(PointerNetwork.load(settings.start))
        if settings.imitate:
            imitate(self.arenas[0], self.network, self.optimiser, settings)
            self.optimiser = Adam(self.network.parameters(), settings.rate, eps=1e-5)  # without memory
            interrupts.keep(self.save)

    @property
    def seconds(self) -> float:
        """Duration of the run without its tournaments, also before --resume."""
        return self.earlier_s + time.perf_counter() - self.begun

    def train(self) -> None:
        """Train to the last decision."""
        interrupts.also_say(lambda: f"after {self.decisions:,} decisions; --resume goes on")
        every = self.settings.evaluate
        try:
            while True:
                if every and self.decisions // every > self.evaluated // every:
                    paused = time.perf_counter()
                    evaluate(self.network.exported(), self.decisions, self.seconds, self.settings)
                    self.evaluated, self.begun = self.decisions, self.begun + time.perf_counter() - paused
                if self.decisions >= self.settings.decisions:
                    break
                interrupts.keep(self.update)  # Ctrl-C does not break off an update
        except KeyboardInterrupt:
            interrupts.keep(self.save)
            raise

    def update(self) -> None:
        """Play, learn, report, and grow the pool and save the run if it is time."""
        settings, here = self.settings, self.arenas[self.turn % len(self.arenas)]
        self.optimiser.param_groups[0]["lr"] = settings.rate * max(0.05, 1 - self.decisions / settings.decisions)
        played = rollout(here, self.network)
        begun = time.perf_counter()
        figures = learn(played, self.network, self.optimiser, settings)
        self.network_s += played.network_s + time.perf_counter() - begun
        figures["score"], figures["wins"] = self.pool.note(here)
        made, before = played.gained.numel(), self.decisions
        figures["reward"] = float(played.gained.sum()) / made
        self.decisions, self.turn = before + made, self.turn + 1
        self.agent_steps += made * settings.hold * here.batch.config.hunters
        spent = time.perf_counter() - self.begun
        figures |= {"agent_steps_per_s": self.agent_steps / spent, "network_share": self.network_s / spent}
        row = {"decisions": self.decisions, "seconds": round(self.seconds, 1), "scenario": here.name}
        append(settings.out / "progress.csv", [row | figures])
        if self.turn % 10 == 0:
            shown = [f"{name} {value:,.2f}" for name, value in figures.items() if value is not None]
            print(f"{self.decisions:,} decisions, {self.seconds:.0f} s, {here.name}: {', '.join(shown)}", flush=True)
        if self.decisions // settings.snapshot > before // settings.snapshot:
            if settings.self_play:
                self.pool.grow(self.network.exported())
            self.save()
        elif self.decisions >= settings.decisions:
            self.save()
        self.pool.weigh()

    def save(self) -> None:
        """Write the agent and state.pt; each file is complete or stays as it was."""
        export(self.network.exported(), self.settings.out)
        state = {
            "version": STATE_VERSION,
            "settings": dataclasses.asdict(self.settings) | {"out": str(self.settings.out)},
            "decisions": self.decisions,
            "seconds": self.seconds,
            "network": self.network.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "selves": [{name: torch.tensor(w) for name, w in one.weights.items()} for one in self.pool.selves],
            "beaten": self.pool.beaten.tolist(),
            "alive": self.pool.alive.tolist(),
            "random": torch.get_rng_state(),
        }
        with whole_file(self.settings.out / "state.pt") as file:
            torch.save(state, file)

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from what `save` has written, and remove later rows of the tables."""
        self.decisions, self.earlier_s = state["decisions"], state["seconds"]
        if self.decisions >= self.settings.decisions:
            raise ValueError(f"--decisions must be above the {self.decisions:,} that the run has made")
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        for weights in state["selves"]:
            self.pool.grow(PointerNetwork(self.settings.head, {name: one.numpy() for name, one in weights.items()}))
        self.pool.beaten, self.pool.alive = np.array(state["beaten"]), np.array(state["alive"])
        self.pool.weigh()
        torch.set_rng_state(state["random"])
        drop_after(self.settings.out / "progress.csv", self.decisions)
        self.evaluated = drop_after(self.settings.out / "curve.csv", self.decisions)


def main() -> None:
    """Train; an error is one line."""
    try:
        settings, state = settings_from(sys.argv[1:])
        Run(settings, state).train()
        print(f"{settings.out / 'agent.py'}: catch-arena check-agent {settings.out / 'agent.py'}", flush=True)
    except (CatchArenaError, ValueError, OSError, FloatingPointError) as error:
        sys.exit(f"train_ppo: {error}")


if __name__ == "__main__":
    interrupts.run(main)

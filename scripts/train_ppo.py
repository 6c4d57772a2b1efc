"""Trains an agent by PPO, against scripted agents and its own past: `python scripts/train_ppo.py --out runs/first`.

It reads from top to bottom: settings, the network, the arenas, a rollout, the update, the pool of opponents,
evaluation, and the loop. Proximal policy optimisation: Schulman et al., 2017; what it does follows Huang et al., "The
37 Implementation Details of PPO", 2022. Past selves are drawn the more often the more they win (prioritised fictitious
self-play: Vinyals et al., "Grandmaster level in StarCraft II", 2019). How strong the network has become is told by a
tournament against fixed agents, since a score against oneself stands still while both get better.

What it writes into --out: `agent.py` and `agent.npz`, which any tournament takes; `curve.csv`, the tournaments;
`progress.csv`, and TensorBoard's files where that is installed; `state.pt`, from which --resume goes on.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before what follows is imported, which takes seconds

import argparse
import ast
import contextlib
import copy
import csv
import dataclasses
import inspect
import itertools
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

# past selves play in NumPy, whose threads would wait for torch's, and for those of another run
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from catch_arena.errors import CatchArenaError, install_hint, reason

try:
    import torch
    from torch import nn
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

_MOST = 2**62


@dataclass(frozen=True)
class Settings:
    """All that a run depends on; each is an option of the same name."""

    out: Path = Path("runs/ppo")
    """Where it writes."""
    head: str = "destination"
    """What the network decides: "destination", to which a driver of ours goes; "rank", of a target; or "velocity"."""
    scenarios: str = "standard"
    """Where it learns; several with commas are taken in turn."""
    opponents: str = "patrol,contested_by_time,contested"
    """The scripted agents that play the other seats; one that has no act_batch is slow."""
    self_play: float = 0.3
    """The share of these seats that its past selves play, once there are some."""
    decisions: int = 4_000_000
    """How many it makes in all."""
    seed: int = 1
    """The networks, the arenas and all that is drawn follow from it."""
    imitate: str = ""
    """With the heads rank and velocity: an agent of that control to copy first, a name or a file with act_batch."""
    imitate_decisions: int = 400_000
    """How many it copies."""
    start: str = ""
    """An .npz file to begin from."""
    arenas: int = 256
    """In lockstep."""
    horizon: int = 64
    """Decisions of each learner in a rollout."""
    hold: int = 2
    """Steps for which a decision holds."""
    hidden: int = 64
    """Units of each layer."""
    prior: float = 0.0
    """What is added to the logit of the candidate that a scripted agent would take; at 3 it decides at first."""
    rate: float = 5e-4
    """The learning rate at the beginning; it falls linearly to a twentieth."""
    gamma: float = 0.985
    """The discount of a step."""
    trace: float = 0.9
    """Lambda of generalised advantage estimation (Schulman et al., 2016)."""
    clip: float = 0.2
    """How far a probability may move in an update."""
    entropy: float = 0.002
    """The weight of the entropy."""
    epochs: int = 3
    """How often each decision is learned from."""
    minibatch: int = 2048
    """Decisions in a gradient step."""
    spread: float = 0.3
    """With the head "velocity": the standard deviation of what is tried, at the beginning."""
    snapshot: int = 300_000
    """Decisions from one past self to the next; then the agent and the run are also written down."""
    most_selves: int = 6
    """Past selves that stay in the pool: the strongest."""
    evaluate: int = 1_000_000
    """Decisions from one tournament to the next; 0: none."""
    evaluate_rounds: int = 6
    """Rounds of a tournament, 4 matches each where four play."""
    evaluate_against: str = "patrol,contested_by_time,contested"
    """Whom it meets there."""
    threads: int = 1
    """That torch may use."""

    # these may change when a run goes on
    FREE: ClassVar = ("out", "decisions", "threads", "evaluate", "evaluate_rounds", "evaluate_against")
    COUNTS: ClassVar = (
        *("decisions", "imitate_decisions", "arenas", "horizon", "hold", "hidden", "epochs", "minibatch", "snapshot"),
        *("most_selves", "evaluate_rounds", "threads"),
    )

    def __post_init__(self) -> None:
        """Look at what can be wrong.

        Raises:
            ValueError: that names it.
        """
        if self.head not in CONTROL_OF:
            raise ValueError(f"--head must be one of {', '.join(CONTROL_OF)}, got {self.head!r}")
        for name in self.COUNTS:
            if getattr(self, name) < 1:
                raise ValueError(f"{option(name)} must be at least 1, got {getattr(self, name)}")
        for name in ("seed", "evaluate"):
            if not 0 <= getattr(self, name) <= _MOST:
                raise ValueError(f"{option(name)} must be from 0 to {_MOST}, got {getattr(self, name)}")
        for name in ("self_play", "gamma", "trace", "clip"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{option(name)} must be from 0 to 1, got {getattr(self, name)}")
        for name in ("rate", "entropy", "spread", "prior"):
            if not 0 <= getattr(self, name) < float("inf"):
                raise ValueError(f"{option(name)} must be a finite number of at least 0, got {getattr(self, name)}")
        for name in ("scenarios", "opponents", "evaluate_against"):
            names = getattr(self, name).split(",")
            if not all(names) or len(set(names)) < len(names):
                must = "different names with commas between them"
                raise ValueError(f"{option(name)} must be {must}, got {getattr(self, name)!r}")
        if self.arenas * self.horizon < 2:
            raise ValueError("--arenas times --horizon must be at least 2: one decision has nothing beside it, got 1")
        if self.imitate and self.head == "destination":
            raise ValueError("--imitate needs the head rank or velocity: nobody tells where an agent wants to go")


def option(name: str) -> str:
    """The option of a setting."""
    return f"--{name.replace('_', '-')}"


def settings_of(arguments: list[str]) -> tuple[Settings, dict[str, Any] | None]:
    """What the command line asks for, and the state to go on from, if there is one. Its settings hold where the command
    line has none.
    """
    said = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    (body,) = [node.body for node in ast.parse(inspect.getsource(Settings)).body if isinstance(node, ast.ClassDef)]
    meaning = {
        here.target.id: after.value.value
        for here, after in itertools.pairwise(body)
        if isinstance(here, ast.AnnAssign) and isinstance(here.target, ast.Name)
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
    }
    for field in dataclasses.fields(Settings):
        kind: Any = field.type if isinstance(field.type, type) else str
        said.add_argument(
            option(field.name),
            type=kind,
            default=argparse.SUPPRESS,
            metavar={Path: "FOLDER", int: "N", float: "X"}.get(kind, "TEXT"),
            help=f"{meaning[field.name]} Default: {field.default or 'none'}".replace("%", "%%"),
        )
    said.add_argument("--resume", action="store_true", help="go on with the run in --out")
    given = vars(said.parse_args(arguments))
    if not given.pop("resume"):
        return Settings(**given), None
    state = read_state(given.get("out", Settings.out) / "state.pt")
    began = state["settings"]
    for name, value in given.items():
        if name not in Settings.FREE and began[name] != value:
            raise ValueError(f"{option(name)} must be {began[name]}, as the run began, got {value}")
    return Settings(**{**began, "out": Settings.out, **given}), state


# the network


class Actor(nn.Module):
    """`PointerNetwork` in torch: the same weights under the same names."""

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        shapes = weight_shapes(settings.head, settings.hidden)  # type: ignore[arg-type] # checked
        self.weights = nn.ParameterDict()
        for name, shape in shapes.items():
            if name == "prior":
                continue
            scale = shape[0] ** -0.5 if len(shape) == 2 else 0.0
            self.weights[name] = nn.Parameter(torch.randn(shape) * scale)
        self.weights["logit"] = nn.Parameter(torch.randn(settings.hidden) * 0.01)  # a prior decides at first
        self.log_spread = nn.Parameter(torch.full((2,), float(np.log(max(settings.spread, 1e-3)))))
        self.prior = settings.prior

    def forward(self, seen: "Seen") -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Log-probabilities of the candidates (N, C); the mean velocities (N, 2) where it drives by itself; and the
        first layer, with which the critic goes on, (N, C, H).
        """
        w = self.weights
        rows, candidates, width = seen.features.shape
        absent = seen.legal == 0
        hidden = torch.relu(torch.addmm(w["encode_bias"], seen.features.reshape(-1, width), w["encode"]))
        table = hidden.view(rows, candidates, -1)
        pooled = attended(hidden @ w["attend"], table, absent)
        common = torch.addmm(w["mix_bias"], pooled, w["pool"])
        mixed = torch.relu((hidden @ w["mix"]).view(rows, candidates, -1) + common[:, None])
        logits = mixed @ w["logit"] + self.prior * nn.functional.one_hot(seen.preferred, candidates)
        chances = torch.log_softmax(logits.masked_fill(absent, -1e9), -1)
        if "drive" not in w:
            return chances, chances.new_zeros(rows, 2), table
        drives = torch.tanh(mixed @ w["drive"] + w["drive_bias"])
        return chances, (drives * chances.exp()[..., None]).sum(1), table

    def exported(self, head: str) -> PointerNetwork:
        """The same in NumPy."""
        weights = {name: value.detach().numpy().copy() for name, value in self.weights.items()}
        return PointerNetwork(head, weights | {"prior": np.float32(self.prior)})  # type: ignore[arg-type] # checked

    def take(self, network: PointerNetwork) -> None:
        """Begin from a network's weights.

        Raises:
            ValueError: for those of a network of another width.
        """
        hidden, given = len(self.weights["logit"]), len(network.weights["logit"])
        if hidden != given:
            raise ValueError(f"--hidden must be {given}, as in --start, got {hidden}")
        with torch.no_grad():
            for name, value in self.weights.items():
                if name in network.weights:
                    value.copy_(torch.from_numpy(network.weights[name].copy()))
        self.prior = float(network.weights["prior"])


class Critic(nn.Module):
    """What a hunter will gain from here on; it reads the actor's first layer, and shapes it too."""

    def __init__(self, hidden: int) -> None:
        super().__init__()
        self.attend = nn.Linear(hidden, QUERIES, bias=False)
        self.value = nn.Sequential(nn.Linear(QUERIES * hidden, hidden), nn.ReLU(), nn.Linear(hidden, 1))

    def forward(self, table: torch.Tensor, seen: "Seen") -> torch.Tensor:
        """(N, C, H) to (N,)."""
        pooled = attended(self.attend(table.flatten(0, 1)), table, seen.legal == 0)
        values: torch.Tensor = self.value(pooled)[:, 0]
        return values


def attended(said: torch.Tensor, table: torch.Tensor, absent: torch.Tensor) -> torch.Tensor:
    """All candidates as one, (N, QUERIES * H): their mean, weighted by a softmax of what the queries say."""
    weights = said.view(*absent.shape, QUERIES).masked_fill(absent[..., None], -1e9).softmax(1)
    return torch.bmm(weights.transpose(1, 2), table).flatten(1)


@dataclass
class Seen:
    """`Destinations` as the network takes them."""

    features: torch.Tensor
    legal: torch.Tensor
    preferred: torch.Tensor

    @classmethod
    def of(cls, seen: Destinations) -> "Seen":
        """The same numbers in torch."""
        return cls(
            torch.from_numpy(seen.features),
            torch.from_numpy(seen.legal.astype(np.float32)),
            torch.from_numpy(seen.preferred),
        )

    def at(self, rows: Any) -> "Seen":
        """Some of the rows."""
        return Seen(self.features[rows], self.legal[rows], self.preferred[rows])


# the arenas


class Arenas:
    """A batch of one scenario, in which a decision holds for some steps."""

    def __init__(self, name: str, settings: Settings, seed: int) -> None:
        config = arena_config(name, control=CONTROL_OF[settings.head])  # type: ignore[index] # checked
        rivals = config.hunters - (1 if config.teams is None else len(config.teams[0]))
        config = config.replace(rewards=RewardWeights(catch=1.0, rival_catch=-1 / max(1, rivals)))  # zero-sum
        if len({Limits.of(config, seat) for seat in range(config.hunters)}) > 1 or config.prey:
            raise ValueError(f"--scenarios must be such that all hunters are alike and no prey is played, got {name}")
        self.name, self.settings, self.limits = name, settings, Limits.of(config)
        self.batch = LearnerBatch(config, settings.arenas, opponents=settings.opponents.split(","), distinct=True)
        self.observations, self.masks = self.batch.reset(seed)
        self.results: list[tuple[np.ndarray, ...]] = []
        self.spread_out(np.random.default_rng(seed), config.max_steps)

    def spread_out(self, rng: np.random.Generator, steps: int) -> None:
        """Let the arenas be at different times of their matches, so that all of a match is learned from at once."""
        lead = rng.integers(0, steps, self.batch.num_envs)
        for moment in range(0, steps, self.settings.hold):
            seen = self.look()
            self.play(seen, seen.preferred, None)
            late = np.flatnonzero((lead >= moment) & (lead < moment + self.settings.hold))
            if len(late):
                self.observations, self.masks = self.batch.reset(arenas=late)
        self.results.clear()

    def look(self) -> Destinations:
        """The candidates of all learners."""
        return destinations(self.view)

    @property
    def view(self) -> BatchView:
        """What all learners see."""
        return BatchView(self.observations, self.masks.astype(np.int8), self.limits)

    def play(
        self, seen: Destinations, choice: np.ndarray, velocity: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """One decision: go to these candidates (N,), or drive so (N, 2).

        Returns:
            what it gained, and whether the match has ended meanwhile.
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
                action = choice if turn == 0 else self.rank_of(forward, left, choice > 0)
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

    def rank_of(self, forward: np.ndarray, left: np.ndarray, chased: np.ndarray) -> np.ndarray:
        """The rank at which the target of this place is now: it may have changed; 0 where it is gone."""
        targets = self.view.targets
        off = (targets.forward - forward[:, None]) ** 2 + (targets.left - left[:, None]) ** 2
        off = np.where((targets.present > 0) & self.masks[:, 1:], off, np.inf)
        return np.where(chased & (off.min(axis=1) < 0.5**2), off.argmin(axis=1) + 1, 0)


# a rollout


@dataclass
class Rollout:
    """T decisions of N learners."""

    seen: list[Seen]
    choices: torch.Tensor
    velocities: torch.Tensor
    chances: torch.Tensor
    values: torch.Tensor
    gained: torch.Tensor
    ended: torch.Tensor
    following: torch.Tensor


def how_likely(
    actor: Actor, chances: torch.Tensor, mean: torch.Tensor, choices: torch.Tensor, velocities: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """The log-probability of what was decided, and the entropy: (N,) each."""
    if "drive" in actor.weights:
        normal = torch.distributions.Normal(mean, actor.log_spread.exp(), validate_args=False)
        return normal.log_prob(velocities).sum(1), normal.entropy().sum(1)
    entropy = -(chances.exp() * chances.clamp(min=-20)).sum(1)
    return chances.gather(1, choices[:, None])[:, 0], entropy


def require_finite(name: str, value: torch.Tensor) -> None:
    """Raise the FloatingPointError for what has become infinite or no number."""
    if not bool(torch.isfinite(value)):
        raise FloatingPointError(f"the network's {name} is {float(value.detach())}: a lower --rate may help")


@torch.no_grad()
def rollout(arenas: Arenas, actor: Actor, critic: Critic, clock: "Clock") -> Rollout:
    """Play, and remember what was seen, decided and gained.

    Raises:
        FloatingPointError: where the network's output is not a number.
    """
    rows = (arenas.settings.horizon, arenas.batch.num_rows)
    seen_in_all, drives = [], "drive" in actor.weights
    choices, velocities = torch.zeros(rows, dtype=torch.int64), torch.zeros((*rows, 2))
    chances, values, gained, ended = (torch.zeros(rows) for _ in range(4))
    for moment in range(rows[0]):
        with clock.of("arena"):
            looked = arenas.look()
            seen = Seen.of(looked)
        with clock.of("network"):
            spoken, mean, table = actor(seen)
            require_finite("output", spoken.sum() + mean.sum())
            choices[moment] = spoken.argmax(1) if drives else torch.multinomial(spoken.exp(), 1)[:, 0]
            velocities[moment] = mean + actor.log_spread.exp() * torch.randn_like(mean)
            chances[moment], _ = how_likely(actor, spoken, mean, choices[moment], velocities[moment])
            values[moment] = critic(table, seen)
        with clock.of("arena"):
            won, over = arenas.play(looked, choices[moment].numpy(), velocities[moment].numpy() if drives else None)
            gained[moment], ended[moment] = torch.from_numpy(won), torch.from_numpy(over.astype(np.float32))
            seen_in_all.append(seen)
    last = Seen.of(arenas.look())
    following = critic(actor(last)[2], last)
    return Rollout(seen_in_all, choices, velocities, chances, values, gained, ended, following)


# the update


def advantages_of(played: Rollout, settings: Settings) -> torch.Tensor:
    """Generalised advantage estimation: (T, N). A match that is over is over: its time limit is in view all along."""
    gamma = settings.gamma**settings.hold
    result, running, following = torch.zeros_like(played.values), torch.zeros_like(played.following), played.following
    for moment in reversed(range(settings.horizon)):
        going_on = 1 - played.ended[moment]
        error = played.gained[moment] + gamma * going_on * following - played.values[moment]
        running = error + gamma * settings.trace * going_on * running
        result[moment], following = running, played.values[moment]
    return result


def learn(
    played: Rollout, actor: Actor, critic: Critic, optimiser: torch.optim.Optimizer, settings: Settings
) -> dict[str, float]:
    """Some epochs of PPO.

    Raises:
        FloatingPointError: where a loss or a gradient is not a number.
    """
    advantages = advantages_of(played, settings)
    returns = (advantages + played.values).flatten()
    advantages = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).flatten()
    seen = Seen(
        *(torch.cat([getattr(one, name) for one in played.seen]) for name in ("features", "legal", "preferred"))
    )
    choices, velocities = played.choices.flatten(), played.velocities.flatten(0, 1)
    before = played.chances.flatten()
    weights = [*actor.parameters(), *critic.parameters()]
    told: dict[str, float] = {}
    for _ in range(settings.epochs):
        for rows in torch.randperm(len(before)).split(settings.minibatch):
            some = seen.at(rows)
            spoken, mean, table = actor(some)
            chances, entropy = how_likely(actor, spoken, mean, choices[rows], velocities[rows])
            ratio = (chances - before[rows]).exp()
            clipped = ratio.clamp(1 - settings.clip, 1 + settings.clip)
            gain = torch.minimum(ratio * advantages[rows], clipped * advantages[rows]).mean()
            error = (critic(table, some) - returns[rows]).square().mean()
            loss = 0.5 * error - gain - settings.entropy * entropy.mean()
            require_finite("loss", loss)
            optimiser.zero_grad()
            loss.backward()
            require_finite("gradient", nn.utils.clip_grad_norm_(weights, 0.5))
            optimiser.step()
            told = {
                name: float(value.detach())
                for name, value in (("gain", gain), ("value_error", error), ("entropy", entropy.mean()))
            }
    told["explained"] = 1 - float((returns - played.values.flatten()).var() / (returns.var() + 1e-8))
    return told


def imitate(arenas: Arenas, actor: Actor, optimiser: torch.optim.Optimizer, settings: Settings, clock: "Clock") -> None:
    """Copy an agent where the network itself comes to (DAgger: Ross, Gordon and Bagnell, 2011)."""
    teacher = create_policy(resolve_spec(settings.imitate))
    if not hasattr(teacher, "act_batch"):
        raise ValueError(f"--imitate must name an agent with act_batch, got {settings.imitate}")
    if control_of(teacher) != CONTROL_OF[settings.head]:  # type: ignore[index] # checked
        raise ValueError(
            f"--imitate must name an agent under {CONTROL_OF[settings.head]} control for the head "  # type: ignore[index]
            f"{settings.head}, got {settings.imitate}, which is under {control_of(teacher)} control"
        )
    teacher.reset(settings.seed)
    kept: list[tuple[Seen, torch.Tensor]] = []
    rounds = -(-settings.imitate_decisions // arenas.batch.num_rows)
    for moment in range(rounds):
        with clock.of("arena"):
            looked = arenas.look()
            label = np.asarray(teacher.act_batch(arenas.view))
            kept.append((Seen.of(looked), torch.from_numpy(label.copy())))
            with torch.no_grad():
                spoken, mean, _ = actor(kept[-1][0])
            own = moment * 5 > rounds  # the teacher drives at first
            if settings.head == "velocity":
                velocity = mean.numpy() if own else label
                arenas.play(
                    looked,
                    spoken.argmax(1).numpy(),
                    velocity + np.random.default_rng(moment).normal(0, 0.1, velocity.shape),
                )
            else:
                arenas.play(looked, spoken.argmax(1).numpy() if own else label, None)
        kept = kept[-256:]
        with clock.of("network"):
            for place in np.random.default_rng(moment).integers(0, len(kept), 4):
                seen, wanted = kept[place]
                spoken, mean, _ = actor(seen)
                if settings.head == "velocity":
                    loss = (mean - wanted).square().mean()
                else:
                    loss = nn.functional.nll_loss(spoken, wanted.long())
                require_finite("loss", loss)
                optimiser.zero_grad()
                loss.backward()
                optimiser.step()
        if moment % 100 == 0:
            print(
                f"imitating {settings.imitate}: {(moment + 1) * arenas.batch.num_rows:,} decisions, "
                f"loss {float(loss.detach()):.4f}",
                flush=True,
            )


# the pool of opponents


class Pool:
    """Scripted agents and past selves, and how often each is met."""

    def __init__(self, arenas: list[Arenas], settings: Settings) -> None:
        self.arenas, self.settings = arenas, settings
        self.scripted = len(settings.opponents.split(","))
        self.selves: list[PointerNetwork] = []
        self.beaten = np.full(self.scripted, 0.5)
        """How often each was left behind, as a moving average."""
        self.alive = np.ones(self.scripted, np.bool_)

    def grow(self, network: PointerNetwork) -> None:
        """Take the present self in, and let the weakest go where they are too many."""
        self.selves.append(network)
        self.beaten, self.alive = np.append(self.beaten, 0.5), np.append(self.alive, True)
        for arenas in self.arenas:
            arenas.batch.opponents.add(PointerAgent(copy.deepcopy(network)))
        present = np.flatnonzero(self.alive[self.scripted :]) + self.scripted
        if len(present) > self.settings.most_selves:
            self.alive[present[self.beaten[present].argmax()]] = False
        self.weigh()

    def weigh(self) -> None:
        """The more often one wins, the more often it is met."""
        hard = np.where(self.alive, (1 - self.beaten) ** 2 + 0.05, 0)
        share = self.settings.self_play if len(self.selves) else 0.0
        hard[: self.scripted] *= (1 - share) / hard[: self.scripted].sum()
        if len(self.selves):
            hard[self.scripted :] *= share / hard[self.scripted :].sum()
        for arenas in self.arenas:
            arenas.batch.opponents.weigh(hard)

    def note(self, arenas: Arenas) -> tuple[float | None, float | None]:
        """Take the matches that have ended into account: the mean score, and the share of wins; None where none has."""
        scores, wins = [], []
        for who, own, theirs in arenas.results:
            beaten = np.where(own[:, None] == theirs, 0.5, own[:, None] > theirs)
            for number in np.unique(who):
                self.beaten[number] += 0.05 * (beaten[who == number].mean() - self.beaten[number])
            best = theirs.max(axis=1)
            scores.append(own.mean())
            wins.append(
                np.where(own > best, 1, np.where(own == best, 1 / (1 + (theirs == best[:, None]).sum(1)), 0)).mean()
            )
        arenas.results.clear()
        return (float(np.mean(scores)), float(np.mean(wins))) if scores else (None, None)


# evaluation

AGENT = '''"""Plays what scripts/train_ppo.py has learned: the weights lie beside it."""

from pathlib import Path

from catch_arena.training.pointer import PointerAgent


class Agent(PointerAgent):
    """See catch_arena/training/pointer.py."""

    control = "{control}"

    def __init__(self) -> None:
        super().__init__(Path(__file__).with_suffix(".npz"))
'''


def export(network: PointerNetwork, folder: Path, name: str = "agent") -> Path:
    """Write an agent that any tournament takes: its file, and its weights beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    network.save(folder / f"{name}.npz")
    path = folder / f"{name}.py"
    write_whole(path, AGENT.format(control=CONTROL_OF[network.head]).encode())
    return path


class Evaluation:
    """Tournaments against fixed agents, beside the training: a process of their own, one at a time.

    Raises:
        AgentError: for an agent that is not there.
    """

    COLUMNS = (
        "agent",
        "matches",
        "rating",
        "rating_low",
        "rating_high",
        "win_share",
        "win_share_low",
        "win_share_high",
    )
    """Of curve.csv, from standings.json."""

    def __init__(self, settings: Settings) -> None:
        self.settings, self.folder = settings, settings.out / "evaluation"
        self.latest = 0
        """After how many decisions the latest began."""
        self.running: tuple[int, float, subprocess.Popen[bytes]] | None = None
        for name in settings.evaluate_against.split(","):
            resolve_spec(name)

    def begin(self, network: PointerNetwork, decisions: int, seconds: float) -> None:
        """Let it play now; it has learned so long."""
        self.end()
        export(network, self.folder / str(decisions), "ppo")
        self.start(decisions, seconds)

    def start(self, decisions: int, seconds: float) -> None:
        """Begin the tournament of an agent that `begin` has exported."""
        settings, here = self.settings, self.folder / str(decisions)
        command = [sys.executable, "-m", "catch_arena", "tournament", str(here / "ppo.py")]
        command += [*settings.evaluate_against.split(","), "--scenario", settings.scenarios.split(",")[0]]
        command += ["--rounds", str(settings.evaluate_rounds), "--seed", str(1_000_000 + settings.seed)]
        command += ["--jobs", "1", "--trusted", "--force", "--out", str(here / "results")]
        with (here / "log.txt").open("wb") as log:
            process = subprocess.Popen(["nice", *command] if os.name == "posix" else command, stdout=log, stderr=log)
        self.latest, self.running = decisions, (decisions, seconds, process)

    def state(self) -> dict[str, Any]:
        """What a run goes on from."""
        return {"latest": self.latest, "running": None if self.running is None else self.running[:2]}

    def again(self, decisions: int, seconds: float) -> None:
        """Play the one again that was under way, unless its results are there."""
        if self.settings.evaluate and decisions not in decisions_in(self.settings.out / "curve.csv"):
            self.start(decisions, seconds)

    def end(self) -> None:
        """Wait for it, and write down what it found."""
        if self.running is None:
            return
        decisions, seconds, process = self.running
        if process.poll() is None:
            print(f"waiting for the tournament after {decisions:,} decisions", flush=True)
        failed = process.wait()
        self.running = None
        if failed:
            log = self.folder / str(decisions) / "log.txt"
            print(f"train_ppo: the tournament after {decisions:,} decisions failed; {log} says why", flush=True)
            return
        results = json.loads((self.folder / str(decisions) / "results" / "standings.json").read_text())
        done = {"decisions": decisions, "seconds": round(seconds, 1)}
        rows = [done | {name: row[name] for name in self.COLUMNS} for row in results["standings"]]
        append(self.settings.out / "curve.csv", rows)
        own = next(row for row in rows if row["agent"] == "ppo")
        ends = [own["win_share_low"], own["win_share_high"]]
        interval = "?" if None in ends else f"{100 * ends[0]:.0f}, {100 * ends[1]:.0f}"
        print(
            f"tournament after {decisions:,} decisions: rating {own['rating']:.0f}, "
            f"wins {100 * own['win_share']:.0f} % [{interval}]",
            flush=True,
        )

    def stop(self) -> None:
        """End one that is under way; --resume plays it again."""
        if self.running is not None:
            self.running[-1].terminate()
            self.running[-1].wait()


# what is written


class Clock:
    """How long each part takes."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = {}

    @contextlib.contextmanager
    def of(self, part: str) -> Iterator[None]:
        """Count what is done inside."""
        begun = time.perf_counter()
        yield
        self.spent[part] = self.spent.get(part, 0.0) + time.perf_counter() - begun


def append(path: Path, rows: list[dict[str, Any]]) -> None:
    """Add rows to a table with a line of names on top."""
    new = not path.exists()
    with path.open("a", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        if new:
            table.writeheader()
        table.writerows(rows)


def decisions_in(path: Path) -> list[int]:
    """The first column of a table, which may not be there yet.

    Raises:
        ValueError: for one that `append` did not write.
    """
    lines = path.read_text().splitlines() if path.exists() else []
    try:
        return [int(line.partition(",")[0]) for line in lines[1:]]
    except ValueError as error:
        raise ValueError(f"{path} must be what a run has written: {reason(error)}") from None


def drop_after(path: Path, decisions: int) -> None:
    """Take out of a table what a broken run wrote after its last snapshot: it is made again."""
    known = decisions_in(path)
    if not known:
        path.unlink(missing_ok=True)
        return
    head, *rows = path.read_text().splitlines(keepends=True)
    kept = [row for row, its in zip(rows, known, strict=True) if its <= decisions]
    write_whole(path, "".join((head, *kept)).encode())


def tensorboard(folder: Path) -> Any:
    """A writer for TensorBoard, or None where it is not installed."""
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ModuleNotFoundError:
        print("train_ppo: no TensorBoard here, so progress.csv alone is written: pip install tensorboard", flush=True)
        return None
    return SummaryWriter(str(folder))


def state_of(run: "Run") -> dict[str, Any]:
    """All that a run goes on from: numbers, words and tensors, so that to read it runs no code."""
    settings, pool = run.settings, run.pool
    return {
        "ruleset": RULESET,
        "features": VERSION,
        "settings": dataclasses.asdict(settings) | {"out": str(settings.out)},
        "decisions": run.decisions,
        "seconds": run.seconds,
        "evaluation": run.evaluation.state(),
        "prior": run.actor.prior,
        "parts": {name: part.state_dict() for name, part in run.parts.items()},
        "selves": [
            {name: torch.from_numpy(np.array(weights)) for name, weights in network.weights.items()}
            for network in pool.selves
        ],
        "beaten": pool.beaten.tolist(),
        "alive": pool.alive.tolist(),
        "random": torch.get_rng_state(),
    }


def read_state(path: Path) -> dict[str, Any]:
    """What `state_of` made.

    Raises:
        ValueError: for a file that is none, and for one of another ruleset or another version.
    """
    if not path.exists():
        raise ValueError(f"--resume needs a run to go on with, and there is no {path}")
    try:
        state: dict[str, Any] = torch.load(path, weights_only=True)
        known = {"ruleset": state["ruleset"], "features": state["features"], "settings": sorted(state["settings"])}
        if type(state["decisions"]) is not int or state["decisions"] < 0:
            raise ValueError(f"decisions must be a whole number of at least 0, got {state['decisions']}")
    except Exception as error:  # noqa: BLE001 - torch raises what it likes for a damaged file
        raise ValueError(f"{path} must be what a run has written: {reason(error)}") from None
    here = {"ruleset": RULESET, "features": VERSION, "settings": sorted(dataclasses.asdict(Settings()))}
    for name, value in known.items():
        if value != here[name]:
            raise ValueError(f"{path}: {name} must be {here[name]}, got {value}: begin a new run")
    try:
        Settings(**state["settings"])
    except (ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"{path} must be what a run has written: {reason(error)}") from None
    return state


def go_on_from(state: dict[str, Any], run: "Run") -> None:
    """Take up what `read_state` has read.

    Raises:
        ValueError: for what does not fit.
    """
    settings, pool = run.settings, run.pool
    try:
        for name, part in run.parts.items():
            part.load_state_dict(state["parts"][name])
        numbers = [*run.actor.parameters(), *run.critic.parameters(), torch.tensor(float(state["prior"]))]
        if not all(one.isfinite().all() for one in numbers):
            raise ValueError("its weights must be finite numbers")
        run.actor.prior = float(state["prior"])
        for weights in state["selves"]:
            pool.grow(PointerNetwork(settings.head, {name: one.numpy() for name, one in weights.items()}))  # type: ignore[arg-type] # checked
        pool.beaten = np.array(state["beaten"], np.float64).reshape(pool.beaten.shape)
        pool.alive = np.array(state["alive"], np.bool_).reshape(pool.alive.shape)
        pool.weigh()
        torch.set_rng_state(state["random"])
        run.evaluation.latest = int(state["evaluation"]["latest"])
        if (running := state["evaluation"]["running"]) is not None:
            running = int(running[0]), float(running[1])
    except Exception as error:  # noqa: BLE001 - torch raises what it likes for tables of another shape
        raise ValueError(f"{settings.out / 'state.pt'} must be what a run has written: {reason(error)}") from None
    for table in ("progress.csv", "curve.csv"):
        drop_after(settings.out / table, run.decisions)
    if running is not None:
        run.evaluation.again(*running)


# the loop


class Run:
    """All that changes while an agent learns.

    Args:
        settings: the run's.
        state: what `save` wrote, to go on from; None for a new run.

    Raises:
        ValueError: for a folder that another run has, and a run that has made all its decisions.
    """

    def __init__(self, settings: Settings, state: dict[str, Any] | None) -> None:
        if state is None and (settings.out / "state.pt").exists():
            raise ValueError(f"--out must be a new folder, or give --resume: a run is kept in {settings.out}")
        self.settings = settings
        self.decisions, self.earlier = (0, 0.0) if state is None else (int(state["decisions"]), float(state["seconds"]))
        if self.decisions >= settings.decisions:
            made = f"the {self.decisions:,} that the run has made"
            raise ValueError(f"--decisions must be above {made}, got {settings.decisions:,}")
        torch.set_num_threads(settings.threads)
        torch.manual_seed(settings.seed)
        prepare_folder(settings.out)
        names = settings.scenarios.split(",")
        self.arenas = [Arenas(name, settings, settings.seed + 1000 * place) for place, name in enumerate(names)]
        self.each = settings.horizon * self.arenas[0].batch.num_rows
        self.actor, self.critic = Actor(settings), Critic(settings.hidden)
        self.optimiser = self.new_optimiser()
        self.pool, self.clock, self.turn = Pool(self.arenas, settings), Clock(), 0
        self.evaluation, self.board = Evaluation(settings), tensorboard(settings.out)
        self.begun, self.agent_steps = time.perf_counter(), 0
        if state is None:
            self.begin()
        else:
            go_on_from(state, self)
        self.clock.spent.clear()

    @property
    def parts(self) -> dict[str, Any]:
        """What has a state of torch's."""
        return {"actor": self.actor, "critic": self.critic, "optimiser": self.optimiser}

    @property
    def seconds(self) -> float:
        """How long the run has taken, before it was broken off too."""
        return self.earlier + time.perf_counter() - self.begun

    def new_optimiser(self) -> torch.optim.Adam:
        """That has no memory."""
        return torch.optim.Adam([*self.actor.parameters(), *self.critic.parameters()], self.settings.rate, eps=1e-5)

    def begin(self) -> None:
        """Take another run's network, or copy an agent, where that was asked for."""
        if self.settings.start:
            self.actor.take(PointerNetwork.load(self.settings.start))
        if self.settings.imitate:
            imitate(self.arenas[0], self.actor, self.optimiser, self.settings, self.clock)
            self.optimiser = self.new_optimiser()
            interrupts.keep(self.save)

    def go_on(self) -> None:
        """To the last decision."""
        settings = self.settings
        interrupts.also_say(lambda: f"after {self.decisions:,} decisions; --resume goes on")
        try:
            while self.decisions < settings.decisions:
                self.evaluate()  # one may be due since before the run was broken off
                interrupts.keep(self.advance)  # what is written down is never the half of an update
            self.evaluate()
            interrupts.keep(self.save)
            self.evaluation.end()
        except KeyboardInterrupt:
            interrupts.keep(self.save)
            raise
        finally:
            self.evaluation.stop()

    def evaluate(self) -> None:
        """Begin a tournament, where one is due."""
        every = self.settings.evaluate
        if every and passed(every, self.evaluation.latest, self.decisions):
            self.evaluation.begin(self.actor.exported(self.settings.head), self.decisions, self.seconds)

    def advance(self) -> None:
        """Play, learn from it, and tell how it went."""
        settings, here = self.settings, self.arenas[self.turn % len(self.arenas)]
        self.optimiser.param_groups[0]["lr"] = settings.rate * max(0.05, 1 - self.decisions / settings.decisions)
        played = rollout(here, self.actor, self.critic, self.clock)
        with self.clock.of("network"):
            learned = learn(played, self.actor, self.critic, self.optimiser, settings)
        score, wins = self.pool.note(here)
        before, self.decisions, self.turn = self.decisions, self.decisions + self.each, self.turn + 1
        reward = float(played.gained.sum()) / self.each
        told: dict[str, float | None] = {**learned, "score": score, "wins": wins, "reward": reward}
        self.agent_steps += self.each * settings.hold * here.batch.config.hunters
        self.tell(here, told)
        if passed(settings.snapshot, before, self.decisions):
            if settings.self_play:
                self.pool.grow(self.actor.exported(settings.head))
            self.save()
        self.pool.weigh()

    def tell(self, here: Arenas, told: dict[str, float | None]) -> None:
        """To progress.csv, to TensorBoard, and every tenth time to people."""
        seconds, spent = self.seconds, time.perf_counter() - self.begun
        told |= {"agent_steps_per_s": self.agent_steps / spent, "network_share": self.clock.spent["network"] / spent}
        when = {"decisions": self.decisions, "seconds": round(seconds, 1), "scenario": here.name}
        append(self.settings.out / "progress.csv", [when | told])
        if self.board is not None:
            for name, value in told.items():
                if value is not None:
                    self.board.add_scalar(f"{here.name}/{name}", value, self.decisions)
        if self.turn % 10 == 0:
            no_match = told["score"] is None or told["wins"] is None
            result = "no match has ended" if no_match else f"score {told['score']:.1f}, wins {told['wins']:.0%}"
            print(
                f"{self.decisions:>10,} decisions, {seconds:6.0f} s, {here.name}: {result}, "
                f"entropy {told['entropy']:.2f}, explained {told['explained']:.2f}, "
                f"{told['agent_steps_per_s']:,.0f} agent-steps/s, network {told['network_share']:.0%}",
                flush=True,
            )

    def save(self) -> None:
        """Write down the run, and the agent that it has made so far; whole, or not at all."""
        with whole_file(self.settings.out / "state.pt") as file:
            torch.save(state_of(self), file)
        export(self.actor.exported(self.settings.head), self.settings.out)


def passed(every: int, before: int, now: int) -> bool:
    """Whether a multiple of so many lies between."""
    return now // every > before // every


def main() -> None:
    """Errors are a line."""
    try:
        settings, state = settings_of(sys.argv[1:])
        Run(settings, state).go_on()
        print(f"{settings.out / 'agent.py'}: catch-arena check-agent {settings.out / 'agent.py'}", flush=True)
    except (CatchArenaError, ValueError, OSError, FloatingPointError) as error:
        sys.exit(f"train_ppo: {error}")


if __name__ == "__main__":
    interrupts.run(main)

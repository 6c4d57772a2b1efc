"""Train the sides of a scenario by PPO, against each other too: `python examples/train_sides.py --scenario tag`.

A side is what one network plays: `seat`, one hunter; `team`, all hunters of one team; `hunters`, all hunters; `prey`,
all prey. In each episode one of the sides that learn is at home in each arena. Every other party of the match is played
by the present network of its side, by one of its past selves, or by a scripted agent. So prey and hunters can learn
against each other, and a hunter with team-mates that it has not met.

PPO is that of train_ppo.py. Fictitious play with past selves: Heinrich, Lanctot and Silver, "Fictitious self-play in
extensive-form games", 2015. The present network alone would forget how to beat the earlier ones.

Files in --out: `hunters.py`, `hunters.npz`, `prey.py`, `prey.npz`, agents for any tournament; `snapshots/`, the same of
earlier times; `curve.json`, the results against scripted agents, which training_curves.py draws.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before the imports below, which take seconds

import json
import os
import sys
import time
from argparse import ArgumentDefaultsHelpFormatter, ArgumentParser, Namespace
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads would wait for those of torch and of other runs

import numpy as np
import train_ppo as ppo  # which names torch if it is missing
from train_ppo import Tensor, nn, torch

from catch_arena.batch_policy import BatchView, PreyBatchView
from catch_arena.config import ArenaConfig, RewardWeights
from catch_arena.errors import ConfigError
from catch_arena.files import whole_file
from catch_arena.geometry import own_frame, world_frame
from catch_arena.layout import observation_size, prey_observation_size
from catch_arena.policy import Side
from catch_arena.scenarios import scenario
from catch_arena.steering import drive_each
from catch_arena.training.destinations import destinations
from catch_arena.training.flat import COMMANDS, FlatAgent
from catch_arena.training.networks import Mlp
from catch_arena.training.player_batch import PlayerBatch, play_matches
from catch_arena.training.players import LEARNER, Rows

SNAPSHOT = 500_000  # decisions between two past selves
MOST_SELVES = 12  # past selves of a side
SIDES = ("seat", "team", "hunters", "prey")


def settings_from(arguments: list[str]) -> tuple[Namespace, ArenaConfig]:
    """Return the options of a command line, and the arena."""
    parser = ArgumentParser(description=(__doc__ or "").splitlines()[0], formatter_class=ArgumentDefaultsHelpFormatter)
    add = parser.add_argument
    add("--out", type=Path, default=Path("runs/sides"), help="folder of the run")
    add("--scenario", default="tag", help="scenario to learn in")
    add("--learn", default="hunters,prey", help=f"sides that learn, separated by commas: {', '.join(SIDES)}")
    add("--network", choices=("flat", "pointer"), default="flat", help="network of hunters; prey has a flat one")
    add("--prior", type=float, default=0.0, help="of a pointer network: added to the logit of what a script would take")
    add("--entropy", type=float, default=0.002, help="weight of the entropy in the loss; more explores for longer")
    add("--opponents", default="intercept", help="scripted agents that play hunters, separated by commas")
    add("--prey-opponents", default="flee", help="scripted agents that play prey, separated by commas")
    add("--self-play", type=float, default=0.7, help="share of the other parties that present and past selves play")
    add("--share", type=float, default=0.0, help="with hunters: reward of a hunter for a catch of the others")
    add("--progress", type=float, default=0.1, help="reward of hunters per metre that they come nearer to a target")
    add("--decisions", type=int, default=20_000_000, help="number of decisions of the side that makes most")
    add("--seed", type=int, default=1, help="seed of the networks and the arenas")
    add("--hold", type=int, default=1, help="number of steps for which a decision holds")
    add("--hidden", type=int, default=64, help="units of each layer")
    add("--arenas", type=int, default=256, help="number of arenas that are stepped together")
    add("--evaluate", type=int, default=1_000_000, help="decisions between matches against scripted agents")
    add("--matches", type=int, default=64, help="number of these matches, for each scripted agent")
    settings = parser.parse_args(arguments)
    least = {"decisions": 1, "seed": 0, "hold": 1, "hidden": 1, "arenas": 16, "evaluate": 1, "matches": 2}
    for name, number in least.items():
        if getattr(settings, name) < number:
            parser.error(f"--{name} must be at least {number}, got {getattr(settings, name)}")
    for name in ("self_play", "entropy"):
        if not 0 <= getattr(settings, name) <= 1:
            parser.error(f"--{name.replace('_', '-')} must be from 0 to 1, got {getattr(settings, name)}")
    settings.learn = settings.learn.split(",")
    config = scenario(settings.scenario, control="velocity")
    here = dict.fromkeys(SIDES, config.prey > 0) | {"seat": config.hunters > 1, "team": config.teams is not None}
    for word in settings.learn:
        if not here.get(word):
            known = ", ".join(word for word in SIDES if here[word])
            parser.error(f"--learn must name sides of {settings.scenario} ({known}), got {word!r}")
    if len(set(settings.learn) - {"prey"}) > 1 or len(set(settings.learn)) < len(settings.learn):
        parser.error(f"--learn must name one side of hunters, prey, or both; got {','.join(settings.learn)}")
    rivals = config.hunters - (1 if config.teams is None else len(config.teams[0]))
    paid = settings.share if "hunters" in settings.learn else -1 / max(1, rivals)  # zero-sum among hunters that compete
    return settings, config.replace(rewards=RewardWeights(catch=1.0, rival_catch=paid, progress=settings.progress))


class Party(NamedTuple):
    """Agents of a match that one player plays."""

    side: Side
    agents: list[int]  # first hunters by seat, then prey


def parties_of(config: ArenaConfig, learn: list[str]) -> list[Party]:
    """Return the parties of a match: those of hunters are as large as the side that learns."""
    hunters = list(range(config.hunters))
    groups = [hunters]
    if "seat" in learn:
        groups = [[seat] for seat in hunters]
    if "team" in learn and config.teams is not None:
        groups = [list(team) for team in config.teams]
    prey = list(range(config.hunters, config.hunters + config.prey))
    return [Party("hunter", group) for group in groups] + ([Party("prey", prey)] if prey else [])


class Flat(nn.Module):
    """Actor, which chooses one of COMMANDS, and critic: perceptrons over an observation with standardised columns."""

    head = "commands"
    judge = ppo.Network.judge

    def __init__(self, inputs: int, hidden: int, scenario: str) -> None:
        super().__init__()
        self.actor, self.critic = perceptron(inputs, hidden, len(COMMANDS)), perceptron(inputs, hidden, 1)
        with torch.no_grad():
            self.actor[-1].weight.mul_(0.1)  # all commands are about equally likely at first
        self.middle, self.scale, self.scenario = torch.zeros(inputs), torch.ones(inputs), scenario

    def standardise(self, seen: Tensor) -> None:
        """Take the mean and the deviation of each column from observations (N, D); a constant one is not scaled."""
        self.middle, deviation = seen.mean(0), seen.std(0)
        self.scale = torch.where(deviation > 1e-6, deviation, torch.ones(()))

    def forward(self, seen: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Compute log-probabilities of the commands (N, 15), no velocities (N, 2), and values (N,)."""
        x = (seen - self.middle) / self.scale
        log_p = torch.log_softmax(self.actor(x), -1)
        if not log_p.isfinite().all():
            raise ConfigError("the network's output is not finite; lower RATE in train_ppo.py")
        return log_p, torch.zeros(len(seen), 2), self.critic(x)[:, 0]

    def look(self, view: BatchView | PreyBatchView) -> tuple[Tensor, ...]:
        """Return the inputs of the network for what these agents see."""
        return (torch.from_numpy(view.observations),)

    def begin(self, choices: np.ndarray) -> None:
        """Begin a decision of the agents that have looked."""
        self.chosen = COMMANDS[choices]

    def commands(self, observations: np.ndarray, rows: Rows) -> np.ndarray:  # noqa: ARG002 - a pointer network uses them
        """Return the commands (N, 2) that follow from the decision at the present observations (B, N, D)."""
        return self.chosen

    def agent(self) -> FlatAgent:
        """Return the actor in NumPy, for observations as they are."""
        network = Mlp.of_torch(self.actor, scale=self.scale)
        weights, biases = network.layers[0]
        network.layers[0] = weights, biases - weights @ self.middle.numpy()
        return FlatAgent(network, self.scenario)


def perceptron(inputs: int, hidden: int, outputs: int) -> nn.Sequential:
    """Return a network with two hidden layers."""
    middle = (nn.Linear(inputs, hidden), nn.Tanh(), nn.Linear(hidden, hidden), nn.Tanh())
    return nn.Sequential(*middle, nn.Linear(hidden, outputs))


class Pointer(ppo.Network):
    """The network of train_ppo.py, which chooses a destination, with the methods of `Flat`."""

    def look(self, view: BatchView) -> tuple[Tensor, ...]:
        self.view, self.seen = view, destinations(view)
        return ppo.tensors(self.seen)

    def begin(self, choices: np.ndarray) -> None:
        self.resting = choices < self.seen.places
        ahead, aside = (table[np.arange(len(choices)), choices] for table in (self.seen.forward, self.seen.left))
        x, y, cosine, sine = self.view.observations.T[:4].astype(np.float64)
        dx, dy = world_frame(cosine, sine, ahead, aside)
        self.place = x + dx, y + dy

    def commands(self, observations: np.ndarray, rows: Rows) -> np.ndarray:
        x, y, cosine, sine = observations[rows].T[:4].astype(np.float64)
        points = own_frame(cosine, sine, self.place[0] - x, self.place[1] - y)
        return drive_each(*points, self.resting, self.view.limits)


class Learner:
    """A side that learns: its network, and what its present network has played since the last update."""

    def __init__(self, word: str, settings: Namespace, batch: PlayerBatch) -> None:
        self.word, self.settings, self.batch = word, settings, batch
        self.side: Side = "prey" if word == "prey" else "hunter"
        if settings.network == "pointer" and self.side == "hunter":
            self.network: Flat | Pointer = Pointer("destination", settings.hidden, settings.prior)
        else:
            size = prey_observation_size if self.side == "prey" else observation_size
            self.network = Flat(size(batch.arena.config), settings.hidden, settings.scenario)
        self.optimiser = torch.optim.Adam(self.network.parameters(), ppo.RATE, eps=1e-5)
        self.decisions = 0
        self.kept: list[tuple[Tensor, ...]] = []  # of the agents that decide, by step
        self.tables: list[tuple[Tensor, ...]] = []  # of all agents of the side, by step

    def look(self) -> tuple[Tensor, ...]:
        """Return the inputs of the network for the agents that it plays."""
        self.rows = self.batch.rows(self.side)
        return self.network.look(self.batch.view(self.side, self.rows))

    def decide(self) -> None:
        """Decide for all agents that the present network plays."""
        inputs = self.look()
        every, velocities, value = self.network(*inputs)
        choices = torch.multinomial(every.exp(), 1)[:, 0]
        log_p, _ = self.network.judge(every, velocities, choices, velocities)
        self.kept.append((*inputs, choices, velocities, log_p))
        self.tables.append((self.spread(value), self.spread(torch.ones(len(value)))))
        self.network.begin(choices.numpy())

    def command(self, commands: np.ndarray, playing: np.ndarray) -> None:
        """Write the commands (B, N, 2) that follow from the last decision; zeros after the end of a match."""
        given = self.network.commands(self.batch.observations, self.rows)
        commands[self.rows] = np.where(playing[self.rows[0], None], given, 0)

    def spread(self, values: Tensor) -> Tensor:
        """Return values of the agents of the last look in a table of the side, with zeros for the others: (B, n)."""
        table = torch.zeros(self.batch.seated.shape)
        table[self.rows] = values
        return table[:, self.batch.players[self.side].agents]

    def reward(self, rewards: np.ndarray, over: np.ndarray) -> None:
        """Take the rewards (B, N) of a step, and the arenas (B,) whose match has ended."""
        gained = torch.from_numpy(rewards[:, self.batch.players[self.side].agents].copy())
        self.tables[-1] += gained, torch.from_numpy(over)[:, None].expand(gained.shape)

    def learn(self) -> dict[str, Any]:
        """Learn from all decisions since the last update."""
        with torch.no_grad():
            following = self.spread(self.network(*self.look())[2])
        values, decided, rewards, ended = map(torch.stack, zip(*self.tables, strict=True))  # (HORIZON, B, n)
        chosen = decided > 0
        advantages = ppo.advantages_of(rewards, ended, values, following, ppo.GAMMA**self.settings.hold)[chosen]
        values = values[chosen]
        played = [*map(torch.cat, zip(*self.kept, strict=True)), advantages, advantages + values]
        self.optimiser.param_groups[0]["lr"] = ppo.RATE * max(0.05, 1 - self.decisions / self.settings.decisions)
        self.decisions += len(values)
        self.kept.clear()
        self.tables.clear()
        return ppo.improve(self.network, self.optimiser, played, self.settings.entropy)


class Run:
    """The sides that learn, and the arenas in which they meet."""

    def __init__(self, settings: Namespace, config: ArenaConfig) -> None:
        self.settings, self.config = settings, config
        self.parties = parties_of(config, settings.learn)
        self.scripts: dict[Side, list[object]] = {"hunter": settings.opponents.split(",")}
        if config.prey:
            self.scripts["prey"] = settings.prey_opponents.split(",")
        self.draw = np.random.default_rng(settings.seed)
        self.batch = PlayerBatch.of(config, settings.arenas, self.scripts)
        self.learners = [Learner(word, settings, self.batch) for word in settings.learn]
        learning = [one.side for one in self.learners]
        self.homes = [place for place, party in enumerate(self.parties) if party.side in learning]
        self.turns = np.arange(settings.arenas)
        self.seconds = 0.0
        self.curve: list[dict[str, Any]] = []
        # the arenas start at different times of their matches, so that each rollout has all parts of a match
        self.batch.reset(settings.seed)
        self.begin(np.arange(settings.arenas))
        lead, looks = self.draw.integers(0, config.max_steps // settings.hold, settings.arenas), list[list[Tensor]]()
        for step in range(config.max_steps // settings.hold):
            if step % 20 == 0:
                looks.append([one.look()[0] for one in self.learners])
            self.play(learn=False)
            self.batch.reset(arenas=lead == step)
        for learner, seen in zip(self.learners, zip(*looks, strict=True), strict=True):
            if isinstance(learner.network, Flat):
                learner.network.standardise(torch.cat(seen))

    def begin(self, arenas: np.ndarray) -> None:
        """Draw the players of these arenas, (n,). One party is at home: a present network plays it."""
        home = np.array(self.homes)[self.turns[arenas] % len(self.homes)]
        numbers = np.zeros((len(arenas), self.batch.seated.shape[1]), np.int64)
        for place, party in enumerate(self.parties):
            numbers[:, party.agents] = np.where(home == place, LEARNER, self.drawn(party.side, len(arenas)))[:, None]
        self.turns[arenas] += 1
        self.batch.seat(arenas, numbers)

    def drawn(self, side: Side, count: int) -> np.ndarray:
        """Draw players that are not at home: half of the share of self-play is for the present network."""
        scripts, players = len(self.scripts[side]), len(self.batch.players[side].pool)
        scripted = self.draw.integers(0, scripts, count)
        if all(one.side != side for one in self.learners):
            return scripted
        past = self.draw.integers(scripts, players, count) if players > scripts else np.full(count, LEARNER)
        own = np.where(self.draw.random(count) < 0.5, LEARNER, past)
        return np.where(self.draw.random(count) < self.settings.self_play, own, scripted)

    @torch.no_grad()
    def play(self, *, learn: bool = True) -> None:
        """Play --hold steps with one decision; the present networks stand still if they do not learn from it."""
        learners = self.learners if learn else []
        for one in learners:
            one.decide()
        gained, playing = np.zeros(self.batch.seated.shape, np.float32), np.ones(len(self.turns), np.bool_)
        for _ in range(self.settings.hold):
            commands = np.zeros((*self.batch.seated.shape, 2), np.float32)
            for one in learners:
                one.command(commands, playing)
            rewards, terminations, truncations, _ = self.batch.step(commands)
            over = terminations | truncations
            gained[playing] += rewards[playing]
            playing &= ~over
            if over.any():
                self.begin(np.flatnonzero(over))
        for one in learners:
            one.reward(gained, ~playing)

    def update(self) -> None:
        """Play, learn, let the pools grow if it is time, and report."""
        begun, made, shown = time.perf_counter(), 0, []
        for _ in range(ppo.HORIZON):
            self.play()
        for one in self.learners:
            before = one.decisions
            figures = one.learn()
            made += one.decisions - before
            if self.settings.self_play and one.decisions // SNAPSHOT > before // SNAPSHOT:
                self.grow(one)
            shown.append(f"{one.word} {one.decisions:,}, entropy {figures['entropy']:.2f}")
        spent = time.perf_counter() - begun
        self.seconds += spent
        print(f"{'; '.join(shown)}; {self.seconds:.0f} s, {made / spent:,.0f} decisions/s", flush=True)

    def grow(self, learner: Learner) -> None:
        """Take the present network into its side's pool; it replaces one of the past selves if there are too many."""
        players, scripts = self.batch.players[learner.side], len(self.scripts[learner.side])
        players.add(learner.network.agent())
        if len(players.pool) > scripts + MOST_SELVES:  # the matches that run go on with it
            players.pool[scripts + int(self.draw.integers(MOST_SELVES))] = players.pool.pop()

    def evaluate(self) -> None:
        """Play each side against each scripted agent, and write curve.json and the agents."""
        for one in self.learners:
            agent = one.network.agent()
            for script in self.scripts[opposed(self.parties, one.side)]:
                row: dict[str, Any] = {"side": one.word, "against": script, "decisions": one.decisions}
                row["seconds"] = round(self.seconds)
                self.curve.append(row | measure(self.settings, self.config, one.side, agent, [script]))
                print(json.dumps(self.curve[-1]), flush=True)
            out = self.settings.out
            for folder, name in ((out, one.word), (out / "snapshots", f"{one.word}_{one.decisions}")):
                ppo.export(agent, folder, name, prey=one.side == "prey")
        settings = vars(self.settings) | {"out": str(self.settings.out)}
        with whole_file(self.settings.out / "curve.json") as file:
            file.write(json.dumps({"settings": settings, "curve": self.curve}, indent=1).encode())


def opposed(parties: list[Party], side: Side) -> Side:
    """Return the side that a side is measured against: hunters, or prey if all hunters are one party."""
    return "prey" if side == "hunter" and sum(party.side == "hunter" for party in parties) == 1 else "hunter"


def measure(
    settings: Namespace, config: ArenaConfig, side: Side, agent: object, opponents: list[Any]
) -> dict[str, list[float]]:
    """Return the catches of an agent (of prey: how often it is caught) and its share of wins, with intervals.

    The agent plays one party, and the opponents the others of the opposed side, one of them in each match.
    """
    parties = parties_of(config, settings.learn)
    against = opposed(parties, side)
    players: dict[Side, list[object]] = {"hunter": [], "prey": settings.prey_opponents.split(",")[: config.prey]}
    players[against] = [*opponents]
    players[side] = [*(opponents if side == against else []), agent]
    matches = np.arange(settings.matches)
    own = [party.agents for party in parties if party.side == side]
    home = np.array(own)[matches % len(own)]  # (M, agents of the party)
    seated = np.zeros((len(matches), config.hunters + config.prey), np.int64)
    for party in parties:
        if party.side == against:
            seated[:, party.agents] = (matches // len(own) % len(opponents))[:, None]
    seated[matches[:, None], home] = len(players[side]) - 1
    found = play_matches(config, players, seated, 10**6 + settings.seed)
    if side == "prey":
        return {"catches": interval(found["times_caught"].sum(axis=1))}
    catches = {"catches": interval(found["score"][matches[:, None], home].sum(axis=1))}
    if against == "prey":
        return catches
    first = found["rank"][:, : config.hunters] == 1
    team = 1 if config.teams is None else len(config.teams[0])  # team-mates share a win
    wins = interval(first[matches[:, None], home].all(axis=1) * team / first.sum(axis=1))
    return catches | {"wins": [min(1.0, figure) for figure in wins]}


def interval(numbers: np.ndarray) -> list[float]:
    """Return the mean of independent matches, and its interval of 95 % (normal approximation)."""
    mean, half = float(numbers.mean()), 1.96 * float(numbers.std(ddof=1)) / len(numbers) ** 0.5
    return [round(mean, 3), round(max(0.0, mean - half), 3), round(mean + half, 3)]


@ppo.errors_in_one_line("train_sides")
def main() -> None:
    """Train until the last decision."""
    settings, config = settings_from(sys.argv[1:])
    if (settings.out / "curve.json").exists():
        raise ConfigError(f"--out must be a new folder: {settings.out} has a run already")
    torch.set_num_threads(1)
    torch.manual_seed(settings.seed)
    run = Run(settings, config)
    interrupts.add_to_message(f"{settings.out} has the agents of the last evaluation")
    most = 0
    while True:
        before, most = most, max(one.decisions for one in run.learners)
        if before // settings.evaluate < most // settings.evaluate or most >= settings.decisions or not run.curve:
            run.evaluate()
        if most >= settings.decisions:
            break
        run.update()
    print(f"{settings.out}: curve.json, and agents {', '.join(f'{one.word}.py' for one in run.learners)}", flush=True)


if __name__ == "__main__":
    interrupts.run(main)

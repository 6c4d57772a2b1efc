"""What must change nothing, changed: the order of requests, the labels of hunters, the names of agents."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import Any, Final

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match_loop import play
from catch_arena.verdicts import Ruling, Verdict

_TARGETS: Final = 2
_TWICE: Final = 0.2
"""How many hunters make a second request in the same step."""
_REFUSED_BEFORE_A_CONTEST: Final = frozenset(Verdict) - {Verdict.GRANTED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED}

Rulings = dict[tuple[int, int], Ruling]
"""By seat, and by which of its requests in this step it is."""


@dataclass(frozen=True, slots=True)
class Step:
    """The requests of one step, made up so that they often meet, and often from equal distances."""

    config: ArenaConfig
    hunters: tuple[tuple[float, float], ...]
    targets: dict[str, tuple[float, float]]
    requests: tuple[tuple[int, str], ...]
    seed: int

    @classmethod
    def drawn(cls, config: ArenaConfig, random: Random) -> "Step":
        """All of it on a few points, a third of the reach apart."""
        reach = max(config.reaches)

        def point() -> tuple[float, float]:
            return random.randrange(4) * reach / 3.0, random.randrange(4) * reach / 3.0

        targets = {f"target_turtle_{number + 1}": point() for number in range(_TARGETS)}
        names = [*targets, "nobody"]
        requests = [
            (seat, random.choice(names))
            for seat in range(config.hunters)
            for _ in range(2 if random.random() < _TWICE else 1)
        ]
        hunters = tuple(point() for _ in range(config.hunters))
        return cls(config, hunters, targets, tuple(requests), random.getrandbits(48))

    def judged(self) -> Rulings:
        """The arbiter's answers."""
        rulings = arbitrate(
            hunters=self.hunters,
            targets=self.targets,
            requests=self.requests,
            reach_m=max(self.config.reaches),
            policy=self.config.policy,
            seed=self.seed,
        )
        asked: Counter[int] = Counter()
        answers = {}
        for ruling in rulings:
            answers[ruling.hunter, asked[ruling.hunter]] = ruling
            asked[ruling.hunter] += 1
        return answers

    def in_another_order(self, random: Random) -> "Step":
        """The same requests; only each hunter's own keep their order, as the first of them stands (R5.2)."""
        own = {seat: iter([name for asker, name in self.requests if asker == seat]) for seat, _ in self.requests}
        seats = [seat for seat, _ in self.requests]
        random.shuffle(seats)
        return replace(self, requests=tuple((seat, next(own[seat])) for seat in seats))

    def relabelled(self, labels: Sequence[int]) -> "Step":
        """The same hunters in other seats: the one of seat s in `labels[s]`."""
        hunters = list(self.hunters)
        for seat, label in enumerate(labels):
            hunters[label] = self.hunters[seat]
        return replace(
            self, hunters=tuple(hunters), requests=tuple((labels[seat], name) for seat, name in self.requests)
        )


def with_labels(rulings: Rulings, labels: Sequence[int]) -> Rulings:
    """The same answers to hunters of other labels."""
    return {
        (labels[seat], number): replace(
            ruling, hunter=labels[seat], winner=None if ruling.winner is None else labels[ruling.winner]
        )
        for (seat, number), ruling in rulings.items()
    }


def lots(rulings: Rulings, config: ArenaConfig) -> dict[object, tuple[list[int], int]]:
    """The targets that a lot decided on (R5.5): by name, who was tied, and who won."""
    contenders: dict[object, list[Ruling]] = {}
    for ruling in rulings.values():
        if ruling.verdict not in _REFUSED_BEFORE_A_CONTEST and config.policy != "capstone":
            contenders.setdefault(ruling.target, []).append(ruling)
    found = {}
    for target, those in contenders.items():
        shortest = min(one.distance_um or 0 for one in those)
        tied = [one for one in those if config.policy == "first_come" or one.distance_um == shortest]
        (winner,) = (one.hunter for one in those if one.verdict is not Verdict.LOST_CONTEST)
        if len(tied) > 1:
            found[target] = ([one.hunter for one in tied], winner)
    return found


def order_matters(config: ArenaConfig, seed: int) -> bool:
    """Whether a match ends otherwise if the actions of each step are handed over in another order."""
    random = Random(seed)
    one, other = (CatchArenaEnv(config.replace(control="target", mask_in_observation=False)) for _ in range(2))
    one.reset(seed=seed)
    other.reset(seed=seed)
    prey = set(config.prey_names)
    while one.agents:
        hunting = [agent for agent in one.agents if agent not in prey]
        actions: dict[str, Any] = {agent: min(random.choice((0, 1, 1, 1, 2)), config.targets_seen) for agent in hunting}
        actions |= {agent: (random.random(), random.uniform(-1.0, 1.0)) for agent in one.agents if agent in prey}
        one.step(actions)
        other.step({agent: actions[agent] for agent in random.sample(sorted(actions), len(actions))})
    return one.digest() != other.digest()


def names_matter(config: ArenaConfig, seed: int, agent: Entrant) -> bool:
    """Whether a match of one agent in all seats ends otherwise if its names, and its indices as entrants, go round.

    Args:
        config: the arena's settings.
        seed: a whole number in [0, 2^64).
        agent: which must draw nothing: each index is told as an agent's seed.
    """
    indices = list(range(config.hunters + config.prey))
    kinds = [agent] * config.hunters + [agent.on("prey")] * config.prey
    digests = {
        play(
            config,
            seed,
            [kind.create() for kind in kinds],
            [f"agent {index}" for index in turned],
            agent_seeds=turned,
        ).digest
        for turned in (indices, indices[1:] + indices[:1], indices[::-1])
    }
    return len(digests) > 1

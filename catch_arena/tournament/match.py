"""One match: as a plan has it, as it is played from the first observation to the last, and what came of it."""

import hashlib
import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from catch_arena.config import ArenaConfig, Control
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.errors import ActionError, ConfigError
from catch_arena.policy import Limits, Policy
from catch_arena.tournament.players import Fault, ForfeitCode, Observation, Players, TrustedPlayers
from catch_arena.verdicts import Verdict

_HOLD: Final[dict[Control, Any]] = {"target": 0, "velocity": (0.0, 0.0), "full": {"cmd_vel": (0.0, 0.0), "catch": 0}}
"""What is played for a seat that gives no action."""


@dataclass(frozen=True, slots=True, order=True)
class Match:
    """One match of a plan."""

    id: str
    """The same for the same plan, whenever it is made; ids sort in the order of the plan."""
    block: int
    """Its block, from 0: matches of one block share their seed, and so their targets (R3.3)."""
    seed: int
    seating: tuple[int, ...]
    """By seat: the index of its player among the entrants."""


Block = tuple[Match, ...]
"""One seed, played in every rotation of its players through the seats (docs/tournaments.md)."""


@dataclass(frozen=True, slots=True)
class MoveTimes:
    """How long one seat took over its moves, by the clock on the wall."""

    moves: int
    """The steps that it was asked in, the one that it failed in among them."""
    total_s: float
    longest_s: float


@dataclass(frozen=True, slots=True)
class Forfeit:
    """How one seat failed."""

    code: ForfeitCode
    step: int
    """The step that it gave no action for, from 1; 0 where it could not begin."""
    reason: str
    """One line for people."""
    observation: Observation | None = None
    """What it was shown in that step; a store does not keep it."""

    def __str__(self) -> str:
        """For people."""
        return f"{self.code} {f'in step {self.step}' if self.step else 'before the first step'}: {self.reason}"


@dataclass(frozen=True, slots=True)
class MatchResult:
    """What came out of one match; tuples are by seat."""

    scores: tuple[int, ...]
    ranks: tuple[int, ...]
    """R6.1: 1 is best; equal scores share a rank, and the ranks that they use up are left out (1, 1, 3). Those who
    forfeited come last, whatever their scores: the longer one lasted, the better.
    """
    verdicts: tuple[dict[str, int], ...]
    """How many of the seat's requests met each verdict, by its name; verdicts that it never met are left out."""
    contests_won: tuple[int, ...]
    """How many targets the seat got that others in reach requested in the same step (R5.4)."""
    steps: int
    digest: str
    """The final state's (A.8): matches that agree in it ended alike."""
    forfeits: tuple[str | None, ...]
    """FORFEIT_CRASH, FORFEIT_TIMEOUT, FORFEIT_ILLEGAL, FORFEIT_INIT or FORFEIT_OUT where a seat failed."""
    thinking: tuple[MoveTimes, ...] = field(compare=False)
    """Like all that follows, no part of what another run of the same match repeats. Stores and exports have this name.
    """
    details: tuple[Forfeit | None, ...] = field(default=(), compare=False)
    """More about each of `forfeits`."""
    logs: tuple[str, ...] = field(default=(), compare=False)
    """What isolated agents printed, tracebacks included, as far as it is kept; a store does not hold it."""


@dataclass(frozen=True, slots=True)
class PlayedMatch:
    """A match of the plan, and what came out of it."""

    match: Match
    result: MatchResult
    replay: str | None = None
    """The digest of its replay's file, where one was kept."""


def play(
    config: ArenaConfig,
    seed: int,
    players: Players | Sequence[Policy],
    names: Sequence[str],
    *,
    indices: Sequence[int] | None = None,
    title: str = "",
    record: Path | BytesIO | None = None,
    watch: Callable[[CatchArenaEnv], None] | None = None,
) -> MatchResult:
    """Play one match to its end. An agent that fails forfeits and is withdrawn (R1.6); the others play on.

    Args:
        config: whose `control` gives way to what the players ask for.
        seed: the match's.
        players: fresh for this match (policies are trusted, and play in this process), and their `names`, by seat.
        names: the agents' names by seat.
        indices: each one's index among the entrants (else its seat), from which its own seed is made.
        title: of the replay.
        record: whether the match is recorded.
        watch: called after the reset and after every step.

    Raises:
        OutputError: for a replay that cannot be written.
        NoContest: where isolated players could not be held.
    """
    if isinstance(players, Sequence):
        players = TrustedPlayers(players)
    controls = players.controls
    if not len(controls) == len(names) == config.hunters:
        raise ConfigError(f"players must be {config.hunters}, one for each hunter, got {len(controls)}")
    seats = range(config.hunters)
    control = tuple(controls[seat] for seat in seats)
    env = CatchArenaEnv(config.replace(control=control, mask_in_observation=False))
    if record is not None:
        env.record(names, title)
    observations, infos = env.reset(seed=seed)
    agents = env.possible_agents
    forfeits: list[Forfeit | None] = [None] * config.hunters
    tallies: dict[str, Counter[str]] = {agent: Counter() for agent in agents}
    total_s, longest_s = [0.0] * config.hunters, [0.0] * config.hunters
    won: Counter[int] = Counter()
    step = 0
    playing = dict(enumerate(agents))
    actions: dict[str, Any] = {}

    def forfeit(seat: int, fault: Fault, observation: Observation | None = None) -> None:
        forfeits[seat] = Forfeit(fault.code, step, fault.reason, observation)
        actions[agents[seat]] = _HOLD[controls[seat]]  # R1.6: it is among the env's agents for one more step
        del playing[seat]
        env.withdraw(agents[seat])
        players.drop(seat)

    seeds = [agent_seed(seed, index) for index in indices or seats]
    for seat, failed in players.reset(seeds, [Limits.of(env.config, seat) for seat in seats]).items():
        forfeit(seat, failed)
    if watch is not None:
        watch(env)
    while env.agents:
        step += 1
        made = dict(infos)  # they are made when they are first read, and an ordinary dict is read faster
        shown = {seat: _observation(observations[agent], made[agent]) for seat, agent in playing.items()}
        for seat, (action, seconds, fault) in players.act(shown).items():
            total_s[seat] += seconds
            if seconds > longest_s[seat]:  # noqa: PLR1730 - max() takes twice as long
                longest_s[seat] = seconds
            if fault is None:
                actions[agents[seat]] = action
            else:
                forfeit(seat, fault, shown[seat])
        try:
            observations, _, _, _, infos = env.step(actions)
        except ActionError:
            for seat, failed in _illegal(env, actions).items():
                forfeit(seat, failed, shown[seat])
            observations, _, _, _, infos = env.step(actions)
        actions.clear()
        winners = set()
        for agent, info in infos.items():
            verdict = info["verdict"]
            if verdict is not None:
                tallies[agent][verdict.name] += 1
                if verdict is Verdict.LOST_CONTEST:
                    winners.add(info["winner"])
        won.update(winners)
        if 0 < len(env.agents) < len(playing):  # R1.7: some have dropped out
            for seat in [seat for seat in playing if agents[seat] not in env.agents]:
                del playing[seat]
                players.drop(seat)
        if watch is not None:
            watch(env)
    logs = players.logs()
    moves = [step if one is None else one.step for one in forfeits]
    scores = tuple(hunter.score for hunter in env.world().hunters)
    if record is not None:
        env.replay().save(record)
    return MatchResult(
        scores=scores,
        ranks=ranks_of(scores, [None if one is None else one.step for one in forfeits]),
        verdicts=tuple(dict(sorted(tally.items())) for tally in tallies.values()),
        contests_won=tuple(won[seat] for seat in seats),
        steps=step,
        digest=env.digest().hex(),
        forfeits=tuple(None if one is None else one.code for one in forfeits),
        thinking=tuple(MoveTimes(*times) for times in zip(moves, total_s, longest_s, strict=True)),
        details=tuple(forfeits),
        logs=tuple(logs.get(seat, "") for seat in seats),
    )


def blocks_of(matches: Iterable[Match]) -> list[Block]:
    """The matches by block, in the order of the plan."""
    return [tuple(block) for _, block in groupby(matches, key=lambda match: match.block)]


def agent_seed(match_seed: int, index: int) -> int:
    """What an agent is told as its seed, in [0, 2^63): a digest, as the match's own seed would tell it every spawn."""
    digest = hashlib.blake2b(f"agent {index} of match {match_seed}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") >> 1


def ranks_of(scores: Sequence[int], lasted: Sequence[int | None] | None = None) -> tuple[int, ...]:
    """R6.1: each one's rank is 1 + how many did better.

    Args:
        scores: catches by seat.
        lasted: the step at which a seat forfeited, None for those that did not: they did better than all who did.
    """
    merits = [
        (math.inf, score) if end is None else (end, 0)
        for score, end in zip(scores, lasted or [None] * len(scores), strict=True)
    ]
    return tuple(1 + sum(other > merit for other in merits) for merit in merits)


def _observation(vector: Any, info: dict[str, Any]) -> Observation:
    mask = info.get("action_mask")
    if isinstance(mask, dict):  # full control: the mask of "catch"
        mask = mask["catch"]
    # plain numbers: a scripted agent reads them one by one, which is slow on arrays
    return vector.tolist(), [] if mask is None else mask.tolist()


def _illegal(env: CatchArenaEnv, actions: dict[str, Any]) -> dict[int, Fault]:
    """The seats whose actions the env refuses."""
    faults = {}
    for seat, agent in enumerate(env.possible_agents):
        try:
            if agent in actions:
                env.check_action(agent, actions[agent])
        except ActionError as refused:
            detail = str(refused).removeprefix(f"{agent}: ").replace("\n", " ")[:200]
            faults[seat] = Fault("FORFEIT_ILLEGAL", detail)
    return faults

"""One match: as a plan has it, as it is played from the first observation to the last, and what came of it."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from catch_arena.config import ArenaConfig, Control
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.errors import ActionError, ConfigError
from catch_arena.policy import Policy, PreyPolicy, player_limits
from catch_arena.text import one_line, printable_lines
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Fault, ForfeitCode, Observation, Players, TrustedPlayers
from catch_arena.tournament.secret import Secret
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
    seed: int = field(repr=False)
    """The arena's. Like `agent_seeds` no message shows it: other matches of its block may not have been played yet."""
    seating: tuple[int, ...]
    """By party (parties.py): the index of its player among the entrants."""
    agent_seeds: tuple[int, ...] = field(default=(), repr=False)
    """By party: what its player is told as its seed; where there are none they follow from the match's own."""

    def with_players(self, players: Sequence[int]) -> "Match":
        """The same match, where the numbers of its seating were roles: player `players[0]` in place of 0, and so on."""
        return replace(self, seating=tuple(players[role] for role in self.seating))


Block = tuple[Match, ...]
"""One seed, played in every rotation of its players through the parties (docs/tournaments.md)."""


@dataclass(frozen=True, slots=True)
class MoveTimes:
    """How long one party took over its moves, by the clock on the wall; all its seats together."""

    moves: int
    """How often it was asked, the step that it failed in among them."""
    total_s: float
    longest_s: float


@dataclass(frozen=True, slots=True)
class Forfeit:
    """How one party failed: that of one of its seats is that of all (R11.1)."""

    code: ForfeitCode
    step: int
    """The step that it gave no action for, from 1; 0 where it could not begin."""
    reason: str
    """One line for people, as `text.one_line` makes it."""
    observation: Observation | None = None
    """What it was shown in that step; a store does not keep it."""
    seat: int = -1
    """Which of its seats failed, likewise."""

    def __str__(self) -> str:
        """For people."""
        return f"{self.code} {f'in step {self.step}' if self.step else 'before the first step'}: {self.reason}"


@dataclass(frozen=True, slots=True)
class MatchResult:
    """What came out of one match; tuples are by party (parties.py), the hunting ones first."""

    scores: tuple[int, ...]
    """R11.1, R12.5: a team's catches; of prey, how often it was caught."""
    ranks: tuple[int, ...]
    """R6.1, R12.5: 1 is best, on either side by itself; equal scores share a rank, and the ranks that they use up are
    left out (1, 1, 3). Those who forfeited come last, whatever their scores: of hunters, the longer one lasted, the
    better; of prey, the less often it was caught.
    """
    verdicts: tuple[dict[str, int], ...]
    """How many of its requests met each verdict, by its name; verdicts that it never met are left out."""
    contests_won: tuple[int, ...]
    """How many contests it won (R5.4): targets, killed or not, that others in reach requested in the same step."""
    steps: int
    digest: str
    """The final state's (A.8): matches that agree in it ended alike."""
    forfeits: tuple[str | None, ...]
    """One of players.ForfeitCode where it failed, as FORFEIT_CRASH."""
    thinking: tuple[MoveTimes, ...] = field(compare=False)
    """Like all that follows, no part of what another run of the same match repeats. Stores and exports have this name.
    """
    details: tuple[Forfeit | None, ...] = field(default=(), compare=False)
    """More about each of `forfeits`."""
    logs: tuple[str, ...] = field(default=(), compare=False)
    """What isolated agents printed, tracebacks included, as far as it is kept; control characters are escapes in it.
    A store does not hold it.
    """
    catches: tuple[int, ...] = ()
    """By seat: each hunter's catches, then how often each prey was caught. It is left out where no team has several
    hunters, as `scores` says it; another run repeats it.
    """


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
    players: Players | Sequence[Policy | PreyPolicy],
    names: Sequence[str],
    *,
    agent_seeds: Sequence[int] = (),
    title: str = "",
    record: Path | BytesIO | None = None,
    watch: Callable[[CatchArenaEnv], None] | None = None,
    on_forfeit: Callable[[int, Forfeit], None] | None = None,
    most_steps: int | None = None,
) -> MatchResult:
    """Play one match to its end. An agent that fails forfeits and is withdrawn (R1.6), and so do the others of its team
    (R11.1); the others play on.

    Seats count the hunters first, and then the prey.

    Args:
        config: whose `control` gives way to what the players ask for.
        seed: the arena's, a whole number in [0, 2^64).
        players: fresh for this match (policies are trusted, and play in this process), by seat.
        names: the agents' names by seat.
        agent_seeds: what each is told as its own, by seat; where there are none they follow from `seed`.
        title: of the replay.
        record: whether the match is recorded.
        watch: called after the reset and after every step.
        on_forfeit: called with (seat, how) for each seat of a party that fails.
        most_steps: after how many steps it is broken off; None plays to the end.

    Raises:
        OutputError: for a replay that cannot be written.
        NoContest: where isolated players could not be held.
    """
    if isinstance(players, Sequence):
        players = TrustedPlayers(dict(enumerate(players)))
    controls = players.controls
    parties = Parties.of(config)
    party_of = parties.by_seat
    seats = range(len(party_of))
    if not len(controls) == len(names) == len(seats):
        each = "one for each hunter and each prey" if config.prey else "one for each hunter"
        raise ConfigError(f"players must be {len(seats)}, {each}, got {len(controls)}")
    control = tuple(controls[seat] for seat in range(config.hunters))
    held = [*(_HOLD[word] for word in control), *(_HOLD["velocity"] for _ in range(config.prey))]
    env = CatchArenaEnv(config.replace(control=control, mask_in_observation=False))
    if record is not None:
        env.record(names, title)
    observations, infos = env.reset(seed=seed)
    agents = env.possible_agents
    forfeits: list[Forfeit | None] = [None] * len(parties)
    tallies: list[Counter[str]] = [Counter() for _ in parties.seats]
    tally_of = {agent: tallies[party] for agent, party in zip(agents, party_of, strict=True)}
    moves, total_s, longest_s = [0] * len(seats), [0.0] * len(seats), [0.0] * len(seats)
    won: Counter[int] = Counter()
    step = 0
    playing = dict(enumerate(agents))
    actions: dict[str, Any] = {}

    def forfeit(faults: dict[int, Fault], observations: Mapping[int, Observation]) -> None:
        for seat, fault in sorted(faults.items()):
            party = party_of[seat]
            if forfeits[party] is not None:  # a team-mate has failed in the same step
                continue
            how = Forfeit(fault.code, step, one_line(fault.reason), observations.get(seat), seat)
            forfeits[party] = how
            for one in parties.seats[party]:
                if one not in playing:  # it has dropped out
                    continue
                if on_forfeit is not None:
                    on_forfeit(one, how)
                actions[agents[one]] = held[one]  # R1.6: it is among the env's agents for one more step
                del playing[one]
                env.withdraw(agents[one])
                players.drop(one)

    seeds = agent_seeds or [agent_seed(seed, seat) for seat in seats]
    forfeit(players.reset(seeds, [player_limits(env.config, seat) for seat in seats]), {})
    if watch is not None:
        watch(env)
    while env.agents and step != most_steps:
        step += 1
        made = dict(infos)  # they are made when they are first read, and an ordinary dict is read faster
        shown = {seat: _observation(observations[agent], made[agent]) for seat, agent in playing.items()}
        faults: dict[int, Fault] = {}
        for seat, (action, seconds, fault) in players.act(shown).items():
            moves[seat] += 1
            total_s[seat] += seconds
            if seconds > longest_s[seat]:  # noqa: PLR1730 - max() takes twice as long
                longest_s[seat] = seconds
            if fault is None:
                actions[agents[seat]] = action
            else:
                faults[seat] = fault
        if faults:
            forfeit(faults, shown)
        try:
            observations, _, _, _, infos = env.step(actions)
        except ActionError:
            forfeit(_illegal(env, actions), shown)
            observations, _, _, _, infos = env.step(actions)
        actions.clear()
        winners = set()
        for agent, info in infos.items():
            verdict = info.get("verdict")
            if verdict is not None:
                tally_of[agent][verdict.name] += 1
                if verdict is Verdict.LOST_CONTEST:
                    winners.add(info["winner"])
        won.update(winners)
        if 0 < len(env.agents) < len(playing):  # R1.7, R12.3: some have dropped out, or prey is out for good
            for seat in [seat for seat in playing if agents[seat] not in env.agents]:
                del playing[seat]
                players.drop(seat)
        if watch is not None:
            watch(env)
    logs = {agents[seat]: printable_lines(log) for seat, log in sorted(players.logs().items())}
    world = env.world()
    catches = [*(hunter.score for hunter in world.hunters), *(prey.times_caught for prey in world.prey)]
    scores = [sum(catches[seat] for seat in party) for party in parties.seats]
    if record is not None:
        env.replay().save(record)
    return MatchResult(
        scores=tuple(scores),
        ranks=ranks_of_sides(scores, [None if one is None else one.step for one in forfeits], parties.hunting),
        verdicts=tuple(dict(sorted(tally.items())) for tally in tallies),
        contests_won=tuple(sum(won[seat] for seat in party) for party in parties.seats),
        steps=step,
        digest=env.digest().hex(),
        forfeits=tuple(None if one is None else one.code for one in forfeits),
        thinking=tuple(
            MoveTimes(
                sum(moves[seat] for seat in party),
                sum(total_s[seat] for seat in party),
                max(longest_s[seat] for seat in party),
            )
            for party in parties.seats
        ),
        details=tuple(forfeits),
        logs=tuple(_log([agents[seat] for seat in party], logs) for party in parties.seats),
        catches=tuple(catches) if len(parties) < len(seats) else (),
    )


def players_of(block: Block) -> frozenset[int]:
    """Who plays in any of its matches, by index among the entrants."""
    return frozenset(index for match in block for index in match.seating)


def blocks_of(matches: Iterable[Match]) -> list[Block]:
    """The matches by block, in the order of the plan."""
    return [tuple(block) for _, block in groupby(matches, key=lambda match: match.block)]


def agent_seed(seed: int, seat: int) -> int:
    """What an agent is told as its seed, in [0, 2^63), in a match that is of no plan and has its seed from people."""
    return Secret.of(seed).seed("agent", 0, seat)


def ranks_of_sides(scores: Sequence[int], lasted: Sequence[int | None], hunting: int) -> tuple[int, ...]:
    """The ranks by party, on each side by itself: of `hunting` teams by R11.1, then of prey by R12.5.

    Args:
        scores: a team's catches, and how often prey was caught.
        lasted: as of `ranks_of`.
        hunting: how many of them hunt.
    """
    ranks = ranks_of(scores[:hunting], lasted[:hunting])
    return *ranks, *prey_ranks_of(scores[hunting:], [end is not None for end in lasted[hunting:]])


def prey_ranks_of(caught: Sequence[int], withdrawn: Sequence[bool]) -> tuple[int, ...]:
    """R12.5: the fewest first; withdrawn prey behind all other.

    Args:
        caught: how often each was.
        withdrawn: who was.
    """
    merits = list(zip(withdrawn, caught, strict=True))
    return tuple(1 + sum(other < merit for other in merits) for merit in merits)


def ranks_of(scores: Sequence[int], lasted: Sequence[int | None] | None = None) -> tuple[int, ...]:
    """R6.1, R11.1: each one's rank is 1 + how many did better.

    Args:
        scores: catches of each, a hunter or a team.
        lasted: the step at which one forfeited, None for those that did not: they did better than all who did.
    """
    merits = [
        (math.inf, score) if end is None else (end, 0)
        for score, end in zip(scores, lasted or [None] * len(scores), strict=True)
    ]
    return tuple(1 + sum(other > merit for other in merits) for merit in merits)


def _log(agents: Sequence[str], logs: Mapping[str, str]) -> str:
    """What a party's instances have printed; of several, each under its name."""
    if len(agents) == 1:
        return logs.get(agents[0], "")
    return "\n".join(f"{agent}:\n{logs[agent].rstrip()}" for agent in agents if logs.get(agent))


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
            faults[seat] = Fault("FORFEIT_ILLEGAL", str(refused).removeprefix(f"{agent}: "))
    return faults

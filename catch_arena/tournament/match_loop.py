"""One match: its players, and the loop from the first observation to the last."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from catch_arena.config import ArenaConfig, Control
from catch_arena.envs.actions import checked_action
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.errors import ActionError, ConfigError
from catch_arena.interrupts import was_interrupted
from catch_arena.policy import Policy, PreyPolicy, player_limits
from catch_arena.text import one_line, printable_lines
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import Fault, Forfeit, MatchResult, MoveTimes, Observation, ranks_of_sides
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.players import Players
from catch_arena.tournament.secret import agent_seed
from catch_arena.verdicts import NO_REQUEST, Verdict

_HOLD: Final[dict[Control, Any]] = {"target": 0, "velocity": (0.0, 0.0), "full": {"cmd_vel": (0.0, 0.0), "catch": 0}}
"""Action that is played for a seat without one, by control."""


class MatchStopped(Exception):  # noqa: N818 - no error: a request
    """Request to end a match before its end, raised by `watch`, or by the players while they act."""


def play_entrants(
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    sandbox: Sandbox | None,
    *,
    absent: Mapping[int, Fault] = MappingProxyType({}),
    agent_seeds: Sequence[int] = (),
    **options: Any,
) -> MatchResult:
    """Play one match of these entrants, by party (parties.py), and return its result.

    `absent` has the reasons for which parties are not started. Without a sandbox all agents are trusted. If there are
    no agent seeds, one for each party, they follow from `seed`. Further options are those of `play_match`. A match that
    failed on our side raises MatchFailedError.
    """
    parties = Parties.of(config)
    seated = in_seats(config, entrants)
    absent = {seat: absent[party] for seat, party in enumerate(parties.by_seat) if party in absent}
    seeds = []
    if agent_seeds:  # those of a party's further instances follow from the party's
        seeds = [agent_seed(agent_seeds[party], n) if n else agent_seeds[party] for party, n in parties.places]
    with Players(seated, sandbox, absent) as players:
        return play_match(config, seed, players, [one.name for one in seated], agent_seeds=seeds, **options)


def play_match(
    config: ArenaConfig,
    seed: int,
    players: Players | Sequence[Policy | PreyPolicy],
    names: Sequence[str],
    *,
    agent_seeds: Sequence[int] = (),
    title: str = "",
    record: Path | BytesIO | None = None,
    colors: Sequence[int] = (),
    watch: Callable[[CatchArenaEnv], None] = lambda _: None,
    on_forfeit: Callable[[int, Forfeit], None] = lambda *_: None,
    most_steps: int | None = None,
) -> MatchResult:
    """Play one match to its end, or for `most_steps` steps, and return its result.

    An agent that fails forfeits and is withdrawn (R1.6), with its team (R11.1); all others play on. `players`, new for
    this match, `names` and `agent_seeds` are by seat, the hunters first; policies are trusted, and play in this
    process. The players' controls replace that of `config`. Without agent seeds they follow from `seed`.

    The replay is written to `record`, with its `title` and the numbers of the hunters' colours, by default their seats.
    `watch` is called after the reset and after every step; if it raises MatchStopped, the result so far is returned.
    `on_forfeit` is called with (seat, forfeit) for each seat that a party that fails still has.
    """
    if isinstance(players, Sequence):
        players = Players(players)
    parties = Parties.of(config)
    seats = range(len(parties.by_seat))
    if not len(players.controls) == len(names) == len(seats):
        each = "one for each hunter and each prey" if config.prey else "one for each hunter"
        raise ConfigError(f"players must be {len(seats)}, {each}, got {len(players.controls)}")
    control = tuple(players.controls[seat] for seat in range(config.hunters))
    env = CatchArenaEnv(config.replace(control=control, mask_in_observation=False))
    if record is not None:
        env.record(names, title)
    observations, infos = env.reset(seed=seed)
    match = _RunningMatch(env, players, parties, on_forfeit)
    seeds = agent_seeds or [agent_seed(seed, seat) for seat in seats]
    match.forfeit(players.reset(seeds, [player_limits(env.config, seat) for seat in seats]), {})
    try:
        watch(env)
        while env.agents and match.step != most_steps:
            observations, infos = match.play_step(observations, infos)
            watch(env)
            if was_interrupted():  # a trusted agent may have caught the interrupt
                raise KeyboardInterrupt
    except MatchStopped:
        pass
    result = match.result()
    if record is not None:
        replay = env.replay()
        replay.colors = tuple(colors)
        replay.save(record)
    return result


def in_seats(config: ArenaConfig, entrants: Sequence[Entrant]) -> list[Entrant]:
    """Return the player of each seat: the party's entrant, or the one that plays prey for it.

    Only the first seat of a party has the log of a player that cannot begin.
    """
    parties = Parties.of(config)
    playing = [entrant.on(parties.side_of(party)) for party, entrant in enumerate(entrants)]
    return [replace(playing[party], log="") if number else playing[party] for party, number in parties.places]


@dataclass(slots=True, eq=False)
class _Party:
    """Party of a running match: its seats, its failure and its counts."""

    seats: tuple[int, ...]
    forfeit: Forfeit | None = None
    verdicts: Counter[str] = field(default_factory=Counter)
    contests_won: int = 0
    contests_lost: int = 0
    lost_to_mates: int = 0
    moves: int = 0
    total_s: float = 0.0
    longest_s: float = 0.0


class _RunningMatch:
    """State of a match while it is played: the remaining players, and the parties."""

    def __init__(
        self,
        env: CatchArenaEnv,
        players: Players,
        parties: Parties,
        on_forfeit: Callable[[int, Forfeit], None],
    ) -> None:
        self.step = 0
        self._env, self._players, self._hunting, self._on_forfeit = env, players, parties.hunting, on_forfeit
        self._agents = env.possible_agents
        prey: tuple[Control] = ("velocity",)
        self._controls = env.config.controls + prey * env.config.prey
        self._ranks = env.config.targets_seen
        self._playing = dict(enumerate(self._agents))
        self._actions: dict[str, Any] = {}
        self._parties = [_Party(seats) for seats in parties.seats]
        self._by_seat = [self._parties[party] for party in parties.by_seat]
        self._by_agent = dict(zip(self._agents, self._by_seat, strict=True))

    def forfeit(self, faults: Mapping[int, Fault], shown: Mapping[int, Observation]) -> None:
        """Withdraw the parties of the seats that failed in this step; `shown` has each seat's observation in it."""
        for seat, fault in sorted(faults.items()):
            party = self._by_seat[seat]
            if party.forfeit is not None:  # a team-mate has failed in the same step
                continue
            forfeit = Forfeit(fault.code, self.step, one_line(fault.reason), shown.get(seat), seat, fault.late)
            party.forfeit = forfeit
            for mate in party.seats:
                if mate not in self._playing:  # it has dropped out
                    continue
                self._on_forfeit(mate, forfeit)
                # R1.6: the env takes one more action of it
                self._actions[self._agents[mate]] = _HOLD[self._controls[mate]]
                del self._playing[mate]
                self._env.withdraw(self._agents[mate])
                self._players.drop(mate)

    def play_step(self, observations: dict[str, Any], infos: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Ask all remaining players for their actions, step the env, and return its observations and infos."""
        self.step += 1
        shown = {seat: _observation(observations[agent], infos[agent]) for seat, agent in self._playing.items()}
        self.forfeit(self._ask(shown), shown)
        observations, _, _, _, infos = self._env.step(self._actions)
        self._actions.clear()
        self._count(infos)
        if 0 < len(self._env.agents) < len(self._playing):  # R1.7, R12.3: some dropped out, or prey is out for good
            for seat in [seat for seat, agent in self._playing.items() if agent not in self._env.agents]:
                del self._playing[seat]
                self._players.drop(seat)
        return observations, infos

    def result(self) -> MatchResult:
        """Return the result of the steps so far."""
        world = self._env.world()
        catches = [*(hunter.score for hunter in world.hunters), *(prey.times_caught for prey in world.prey)]
        parties = self._parties
        teams = len(parties) < len(catches)
        scores = [sum(catches[seat] for seat in one.seats) for one in parties]
        lasted = [None if one.forfeit is None else one.forfeit.step for one in parties]
        logs = {self._agents[seat]: printable_lines(log) for seat, log in sorted(self._players.logs().items())}
        return MatchResult(
            scores=tuple(scores),
            ranks=ranks_of_sides(scores, lasted, self._hunting),
            verdicts=tuple(dict(sorted(one.verdicts.items())) for one in parties),
            contests_won=tuple(one.contests_won for one in parties),
            contests_lost=tuple(one.contests_lost for one in parties),
            steps=world.step,
            digest=self._env.digest().hex(),
            forfeits=tuple(one.forfeit for one in parties),
            thinking=tuple(MoveTimes(one.moves, round(one.total_s, 6), round(one.longest_s, 6)) for one in parties),
            logs=tuple(_log([self._agents[seat] for seat in one.seats], logs) for one in parties),
            lost_to_mates=tuple(one.lost_to_mates for one in parties) if teams else (),
            catches=tuple(catches) if teams else (),
        )

    def _ask(self, shown: Mapping[int, Observation]) -> dict[int, Fault]:
        """Ask the seats in `shown` for their actions, keep the legal ones, and return the faults of other seats."""
        faults: dict[int, Fault] = {}
        for seat, (action, seconds, fault) in self._players.act(shown).items():
            party = self._by_seat[seat]
            party.moves += 1
            party.total_s += seconds
            party.longest_s = max(party.longest_s, seconds)
            if fault is not None:
                faults[seat] = fault
                continue
            agent = self._agents[seat]
            try:  # velocities out of bounds are refused here, and would be clipped by the env
                checked_action(self._controls[seat], agent, action, self._ranks)
            except ActionError as refused:
                faults[seat] = Fault("FORFEIT_ILLEGAL", str(refused).removeprefix(f"{agent}: "))
            else:
                self._actions[agent] = action
        return faults

    def _count(self, infos: dict[str, Any]) -> None:
        """Count the verdicts and contests of a step: each contest has one winner, and a party wins or loses it once."""
        contests: dict[int, set[_Party]] = {}  # the parties that lost to each seat
        for agent, info in infos.items():
            verdict, party = info.get("verdict", NO_REQUEST), self._by_agent[agent]
            if verdict == NO_REQUEST:
                continue
            party.verdicts[Verdict(verdict).name] += 1
            if verdict == Verdict.LOST_CONTEST and self._by_seat[info["winner"]] is party:
                party.lost_to_mates += 1
            elif verdict == Verdict.LOST_CONTEST:
                contests.setdefault(info["winner"], set()).add(party)
        for seat, losers in contests.items():
            self._by_seat[seat].contests_won += 1
            for party in losers:
                party.contests_lost += 1


def _log(agents: Sequence[str], logs: Mapping[str, str]) -> str:
    """Return the output of a party's instances; if there are several, each under its name."""
    if len(agents) == 1:
        return logs.get(agents[0], "")
    return "\n".join(f"{agent}:\n{logs[agent].rstrip()}" for agent in agents if logs.get(agent))


def _observation(vector: Any, info: dict[str, Any]) -> Observation:
    mask = info.get("action_mask")
    # plain numbers: a scripted agent reads them one by one, which is slow on arrays
    return vector.tolist(), [] if mask is None else mask.tolist()

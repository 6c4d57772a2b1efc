"""One match: agents in their seats, from the first observation to the last."""

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from catch_arena.config import ArenaConfig
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.errors import ActionError, AgentError, ConfigError
from catch_arena.policy import Limits, Policy, View, control_of
from catch_arena.tournament.entrants import reason


@dataclass(frozen=True, slots=True)
class MatchResult:
    """What came out of one match; tuples are by seat."""

    scores: tuple[int, ...]
    ranks: tuple[int, ...]
    """R6.1: 1 is best; equal scores share a rank, and the ranks that they use up are left out (1, 1, 3)."""
    verdicts: tuple[dict[str, int], ...]
    """How many of the seat's requests met each verdict, by its name; verdicts that it never met are left out."""
    steps: int
    digest: str
    """The final state's (A.8): matches that agree in it ended alike."""


def play(
    config: ArenaConfig,
    seed: int,
    policies: Sequence[Policy],
    names: Sequence[str],
    *,
    places: Sequence[int] | None = None,
    title: str = "",
    record: Path | None = None,
    watch: Callable[[CatchArenaEnv], None] | None = None,
) -> MatchResult:
    """Play one match to its end.

    Args: `config`, whose `control` gives way to what the policies ask for; `seed`, the match's; `policies`, fresh for
    this match, and their `names`, by seat; `places`, each one's place among the entrants (else its seat), from which
    its own seed is made; `title` and `record`, the heading and the file of a replay; `watch`, called after the reset
    and after every step.
    Raises: AgentError that names the agent and the step; OutputError for a replay that cannot be written.
    """
    if not len(policies) == len(names) == config.hunters:
        raise ConfigError(f"policies must be {config.hunters}, one for each hunter, got {len(policies)}")
    controls = tuple(control_of(policy) for policy in policies)
    env = CatchArenaEnv(config.replace(control=controls, mask_in_observation=False))
    if record is not None:
        env.record(names, title)
    observations, infos = env.reset(seed=seed)
    agents = env.possible_agents
    limits = [Limits.of(env.config, seat) for seat in range(config.hunters)]
    tallies: list[Counter[str]] = [Counter() for _ in agents]
    for policy, name, place in zip(policies, names, places or range(config.hunters), strict=True):
        _asked(name, "reset", 0, policy.reset, agent_seed(seed, place))
    step = 0
    if watch is not None:
        watch(env)
    while env.agents:
        step += 1
        actions = {
            agent: _asked(name, "act", step, policy.act, _view(observations[agent], infos[agent], limit))
            for agent, name, policy, limit in zip(agents, names, policies, limits, strict=True)
        }
        try:
            observations, _, _, _, infos = env.step(actions)
        except ActionError as error:
            _blame(error, env, actions, names, step)
        for agent, tally in zip(agents, tallies, strict=True):
            verdict = infos[agent]["verdict"]
            if verdict is not None:
                tally[verdict.name] += 1
        if watch is not None:
            watch(env)
    scores = tuple(hunter.score for hunter in env.world().hunters)
    if record is not None:
        env.replay().save(record)
    return MatchResult(
        scores=scores,
        ranks=ranks_of(scores),
        verdicts=tuple(dict(sorted(tally.items())) for tally in tallies),
        steps=step,
        digest=env.digest().hex(),
    )


def agent_seed(match_seed: int, place: int) -> int:
    """What an agent is told as its seed, in [0, 2^63): a digest, as the match's own seed would tell it every spawn."""
    digest = hashlib.blake2b(f"agent {place} of match {match_seed}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") >> 1


def ranks_of(scores: Sequence[int]) -> tuple[int, ...]:
    """R6.1: each one's rank is 1 + how many have more."""
    return tuple(1 + sum(other > score for other in scores) for score in scores)


def _view(observation: Any, info: dict[str, Any], limits: Limits) -> View:
    mask = info.get("action_mask")
    if isinstance(mask, dict):  # full control: the mask of "catch"
        mask = mask["catch"]
    # plain numbers: a scripted agent reads them one by one, which is slow on arrays
    return View(observation.tolist(), () if mask is None else mask.tolist(), limits)


def _asked(name: str, what: str, step: int, method: Callable[[Any], Any], argument: object) -> Any:
    """What the agent answers; whatever it raises becomes an AgentError."""
    try:
        return method(argument)
    except (Exception, SystemExit) as error:  # a stranger's code may raise anything
        raise AgentError(f"{name}: {what} raised {reason(error)} (step {step})") from error


def _blame(
    error: ActionError, env: CatchArenaEnv, actions: dict[str, Any], names: Sequence[str], step: int
) -> NoReturn:
    """Say which agent gave the action that the env refused."""
    for agent, name in zip(env.possible_agents, names, strict=True):
        try:
            env.check_action(agent, actions[agent])
        except ActionError as refused:
            detail = str(refused).removeprefix(f"{agent}: ").replace("\n", " ")[:200]
            raise AgentError(f"{name}: {detail} (step {step})") from error
    raise error

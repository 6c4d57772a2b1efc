"""Store of a tournament with random results, for reports."""

from collections.abc import Sequence
from pathlib import Path
from random import Random

from tournament.seats import hunters

from catch_arena.config import ArenaConfig
from catch_arena.scenarios import scenario
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Forfeit, MatchResult, MoveTimes, PlayedMatch, ranks_of
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.store import Store, Tournament

NAMES = ("contested", "patrol", "nearest", "first", "idle", "random")


def tournament(
    folder: Path,
    rounds: int,
    names: Sequence[str] = NAMES,
    *,
    most: int | None = None,
    planned: int | None = None,
    forfeits: bool = False,
    terms: dict[str, bool] | None = None,
    specs: Sequence[str] = (),
    reason: str = "",
) -> int:
    """Fill a folder's store, or what is missing in it; how many matches it has. The first agents are the best.

    Args:
        folder: the store's.
        names: of the agents.
        rounds: of the plan.
        most: play no more matches than so many.
        planned: how many matches are planned, else those of the rounds.
        forfeits: whether the last agent crashes now and then.
        terms: what the store says of how it is played.
        specs: of the agents, else files.
        reason: for which the first one forfeits all.
    """
    config: ArenaConfig = scenario("standard")
    entrants = tuple(
        Entrant(name, spec, "target", f"{place:016x}")
        for place, (name, spec) in enumerate(zip(names, specs or [f"{name}.py" for name in names], strict=True))
    )
    secret = Secret.of(1)
    plan = round_robin(len(names), hunters(config.hunters), rounds, secret)
    folder.mkdir(parents=True, exist_ok=True)
    with Store.begin(
        Tournament(config, entrants, plan.parameters, secret.text, terms or {}), folder, resume=True
    ) as store:
        store.set_planned(planned or plan.size)
        played = []
        for number, match in enumerate(plan):
            if most is not None and number >= most:
                break
            random = Random(match.id)
            crashed = [forfeits and place == len(names) - 1 and random.random() < 0.1 for place in match.seating]
            scores = tuple(max(0, round(random.gauss(22 - 3 * place, 4))) for place in match.seating)
            wrong = [
                Forfeit("FORFEIT_CRASH", 7, "act raised ValueError: <b>no</b>") if bad else None for bad in crashed
            ]
            if reason:
                wrong[match.seating.index(0)] = Forfeit("FORFEIT_INIT", 0, reason)
            played.append(
                PlayedMatch(
                    match,
                    MatchResult(
                        scores=scores,
                        ranks=ranks_of(scores, [one and one.step for one in wrong]),
                        verdicts=tuple({"GRANTED": score, "LOST_CONTEST": 1, "OUT_OF_REACH": 2} for score in scores),
                        contests_won=tuple(random.randrange(3) for _ in scores),
                        contests_lost=(1,) * len(scores),
                        steps=600,
                        digest="0" * 16,
                        thinking=tuple(MoveTimes(600, 0.02, 0.001) for _ in scores),
                        forfeits=tuple(wrong),
                    ),
                )
            )
        store.add(played)
        if most is None:
            store.end()
        return store.count_played()

"""Requests by name are kept in a replay, judged again, and bounded in number."""

from collections import Counter
from itertools import pairwise
from math import hypot

import pytest
from recorded_matches import play_by_name

from catch_arena import ArenaService, Replay, Ruling, Verdict, explain
from catch_arena.errors import ActionError
from catch_arena.messages import CatchTurtleRequest
from catch_arena.replay.comparison import replay_differences, verify
from catch_arena.replay.named_requests import NamedRequest


def comparable(ruling: Ruling) -> str:
    """Names as a replay keeps them."""
    name = ruling.target[:256] if isinstance(ruling.target, str) else None
    return repr((ruling.hunter, ruling.verdict, name, ruling.distance_um, ruling.winner, ruling.step))


@pytest.mark.rule("R8.4", "R10.2", "R5.2")
@pytest.mark.parametrize("seed", range(6))
def test_r8_4_every_request_is_in_the_replay_with_the_ruling_that_it_had(seed, tmp_path):
    """Ranks and names together are what was answered, in every step, after saving and loading."""
    played, rulings_by_step = play_by_name(seed)
    played.save(tmp_path / "named.replay")
    replay = Replay.load(tmp_path / "named.replay")
    found = Counter()
    for (_, after, named), live in zip(replay.judged_steps(), rulings_by_step, strict=True):
        again = [*(one for one in after.rulings if one.hunter != 1), *named]
        assert sorted(map(comparable, again)) == sorted(map(comparable, live))
        found.update(one.verdict for one in named)
    assert verify(replay) == []
    assert {Verdict.DUPLICATE, Verdict.UNKNOWN_TARGET, Verdict.ALREADY_CAUGHT, Verdict.MALFORMED} <= found.keys()
    assert not found.keys() & {Verdict.GRANTED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED}


def test_a_catch_that_was_written_into_the_names_does_not_count(named):
    """A target in reach has a rank, so a forged request by name is a catch that never was."""
    forged = named.copy()
    for step, (before, after) in enumerate(pairwise(named.worlds())):
        silent = (
            {0, 2}
            - {one.hunter for one in after.rulings}
            - {one.seat for one in named.named_requests if one.step == step}
        )
        silent -= {seat for seat in silent if after.hunters[seat].withdrawn}
        near = [
            (seat, target.name)
            for seat in silent
            for target in before.targets
            if hypot(target.x - before.hunters[seat].x, target.y - before.hunters[seat].y) < 1.9
        ]
        if near:
            break
    seat, name = near[0]
    forged.named_requests.append(NamedRequest(step, seat, name))
    forged.named_requests.sort(key=lambda one: one.step)
    assert explain(forged) == explain(named)


def test_one_name_that_differs_is_told(named):
    """In the step in which it was asked for, with who asked."""
    other = named.copy()
    at = next(at for at, one in enumerate(other.named_requests) if one.name == "x")
    step, seat, _ = other.named_requests[at]
    other.named_requests[at] = other.named_requests[at]._replace(name="z")
    (line,) = [line for line in replay_differences(named, other) if "acts differently" in line]

    assert line.startswith(f"step {step + 1}: hunter_{seat} acts differently: ")
    assert '"x"' in line
    assert '"z"' in line


def test_a_flood_leaves_the_others_their_part_and_the_match_its_file(tmp_path):
    """Each hunter may have a half of the room here; the match is kept whole."""
    service = ArenaService("duel", control_period_ms=16, time_limit_s=0.1)
    service.record(("a", "b"))
    service.reset(1)
    flood = [("hunter_0", CatchTurtleRequest(f"{number:0256}")) for number in range(3000)]
    short = [("hunter_0", CatchTurtleRequest("")) for _ in range(40_000)]
    service.step(requests=flood)
    service.step(requests=short)
    service.step(requests=[("hunter_1", CatchTurtleRequest("x"))])
    kept = Counter((one.step, one.seat) for one in service.replay.named_requests)

    assert kept == {(0, 0): 2**19 // 272, (2, 1): 1}
    assert service.requests_left_out == 3000 - 2**19 // 272 + 40_000

    service.replay.save(tmp_path / "flood.replay")
    assert (tmp_path / "flood.replay").stat().st_size < 2**20
    assert verify(Replay.load(tmp_path / "flood.replay")) == []


def test_a_rank_is_a_request_also_in_a_step_with_a_request_by_name():
    service = ArenaService("duel", reach_m=5.0, max_cycles=1)
    service.record(("a", "b"))
    service.reset(3)
    first = service.world.targets[0].name
    service.step(requests=[("hunter_1", CatchTurtleRequest("x"))], active_targets={"hunter_0": first})
    assert [ruling.verdict for ruling in service.world.rulings] == [Verdict.GRANTED, Verdict.UNKNOWN_TARGET]
    assert verify(service.replay) == []


@pytest.mark.parametrize("control", ["target", "velocity"])
def test_a_hunter_whose_controller_asks_cannot_ask_by_name(control):
    service = ArenaService("duel", control=("full", control))
    service.reset(1)
    with pytest.raises(ActionError, match=f"hunter_1: a request must be of a hunter under full control.*{control}"):
        service.step(requests=[("hunter_1", CatchTurtleRequest("x"))])
    assert service.world.step == 0

"""One match of `ros serve` from its beginning to its end, in one process."""

from contextlib import nullcontext
from types import SimpleNamespace

import pytest
from ros.local import Hub, LocalBus

from catch_arena.cli.ros import _print_ranking
from catch_arena.errors import ConfigError
from catch_arena.replay import Replay
from catch_arena.replay.comparison import verify
from catch_arena.ros.middleware.bus import Endpoint
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces
from catch_arena.ros.nodes.rate import Rate
from catch_arena.ros.nodes.serving import Served, serve_match
from catch_arena.scenarios import SCENARIOS, scenario

REFUSED = {
    "tag": "prey must be 0 on a bus, got 1: no node can play it; use --set prey=0",
    "pack": "prey must be 0 on a bus, got 1: no node can play it; use --set prey=0",
    "herd": "prey must be 0 on a bus, got 4: no node can play it; use --set prey=0",
    "capstone": "a match under the policy capstone cannot be recorded, because its grants need no target; "
    "use the policy nearest or first_come",
}
LAST_TICK = 63
"""Of one second."""


SETTLE = 62
"""Spins of a second before the match, in which all seats are taken already."""


class TakenBus(LocalBus):
    """Each seat has a node from the beginning."""

    def __init__(self):
        super().__init__(Hub(), "arena")

    def publishers_of(self, topic):
        return int(topic.startswith("/hunter_"))


class InterruptedBus(TakenBus):
    """Ctrl-C comes in one of the spins of a match."""

    def __init__(self, when):
        super().__init__()
        self.left = SETTLE + when

    def spin(self, timeout_s=0.0):
        super().spin(timeout_s)
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt


def served(config, record=None, bus=None, log=lambda _: None):
    names = [f"p{seat}" for seat in range(config.hunters)]
    return serve_match(
        nullcontext(bus or TakenBus()),
        *(config, 5, {}, None),
        names=names,
        interfaces=Interfaces(),
        speed=100.0,
        record=record,
        log=log,
    )


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_is_played_and_recorded_or_refused_in_one_line(name, tmp_path):
    """Before anything is played."""
    record = tmp_path / "match.replay"
    config = scenario(name, time_limit_s=1)
    if name in REFUSED:
        with pytest.raises(ConfigError) as error:
            served(config, record)
        assert str(error.value) == REFUSED[name]
        return
    assert len(served(config, record).scores) == config.hunters
    played = Replay.load(record)
    assert played.steps == LAST_TICK
    assert verify(played) == []


def test_what_nodes_do_is_seen_before_the_match_begins():
    class Seen(LocalBus):
        def graph(self):
            return [Endpoint("/mine", "publisher", "/autobot/cmd_vel", TWIST.name)]

        def publishers_of(self, topic):
            return int(topic == "/turtle1/cmd_vel")

    log_lines = []
    served(scenario("exercise", hunters=1, time_limit_s=1), None, Seen(Hub(), "arena"), log_lines.append)
    assert log_lines[0].endswith("start it with --ros-args -r /autobot/cmd_vel:=/turtle1/cmd_vel")
    assert log_lines[1] == "all seats are taken: the match begins"


@pytest.mark.parametrize("after", [1, 10, 29])
def test_an_interrupt_after_the_match_is_its_normal_end(tmp_path, after):
    """The replay is saved, and the ranking is complete."""
    record = tmp_path / "match.replay"
    found = served(scenario("duel", time_limit_s=1), record, InterruptedBus(LAST_TICK + after))
    assert found.ranks == (1, 1)
    assert Replay.load(record).steps == LAST_TICK


def test_an_interrupt_in_the_match_ends_it_with_a_ranking(tmp_path):
    """The replay of the steps so far is saved."""
    record, log_lines = tmp_path / "match.replay", []
    found = served(scenario("duel", time_limit_s=1), record, InterruptedBus(LAST_TICK - 20), log_lines.append)
    assert found.ranks == (1, 1)
    assert Replay.load(record).steps == LAST_TICK - 21
    assert log_lines == [
        "all seats are taken: the match begins",
        "the match was stopped after 1 s; this is the ranking until then",
    ]


def test_teams_are_ranked_as_teams(capsys):
    """R11.1, with what each of their hunters caught."""
    config = SimpleNamespace(hunters=4, prey=0, team_seats=((0, 3), (1, 2)))
    _print_ranking(Served(("ann", "bob", "cat", "dan"), (2, 1, 1, 2), (5, 4, 3, 0), Rate(1.0), ()), config)
    assert capsys.readouterr().out.splitlines() == [
        "  1    7  bob (hunter_1) 4 + cat (hunter_2) 3",
        "  2    5  ann (hunter_0) 5 + dan (hunter_3) 0",
    ]


def test_ctrl_c_while_the_replay_is_saved_ends_the_command(tmp_path, monkeypatch):
    def interrupted(_replay, _path):
        raise KeyboardInterrupt

    monkeypatch.setattr(Replay, "save", interrupted)
    with pytest.raises(KeyboardInterrupt):
        served(scenario("duel", time_limit_s=1), tmp_path / "match.replay")

"""`play` and `watch` run whole sessions by scripted keys, on a machine without a screen."""

import itertools

import command_line
import pytest

from catch_arena import explain
from catch_arena.live import match_window
from catch_arena.render.optional_imports import pygame
from catch_arena.replay import Replay
from catch_arena.replay.comparison import verify
from catch_arena.scenarios import SCENARIOS

pytestmark = pytest.mark.usefixtures("without_a_screen")
QUICK = ["--set", "time_limit_s=1"]


def press(code: int, mod: int = 0):
    return pygame.event.Event(pygame.KEYDOWN, key=code, mod=mod, unicode="")


SAVE = [press(pygame.K_s, pygame.KMOD_LCTRL)]
"""Saves the replay as match.replay."""


class Script:
    """Gives the window its events: at each look as many as the script says, and at last Escape.

    A function in the script is a pause: there are no events until it says that the script goes on.
    """

    def __init__(self, *looks):
        self._looks = list(looks)

    def get(self):
        if not self._looks:
            return [press(pygame.K_ESCAPE)]
        if callable(self._looks[0]) and not self._looks[0]():
            return []
        look = self._looks.pop(0)
        if callable(look):
            return []
        return [press(look)] if isinstance(look, int) else list(look)


@pytest.fixture
def session(monkeypatch, tmp_path):
    """Runs a command with a script of keys."""
    monkeypatch.chdir(tmp_path)

    def run(words, *looks):
        script = Script(*looks)
        monkeypatch.setattr(pygame.event, "get", script.get)
        return command_line.run(*words, *QUICK)

    return run


@pytest.fixture
def over(monkeypatch):
    """A pause in the script until the match is over: nobody knows how many looks an agent's process takes."""
    ended = []
    show = match_window.MatchWindow.show_podium
    monkeypatch.setattr(match_window.MatchWindow, "show_podium", lambda window: (ended.append(1), show(window)))
    return lambda: bool(ended)


def nothing(looks: int) -> list[tuple[()]]:
    return [()] * looks


def played(session, *words):
    """What `play` prints to a person that drives ahead to the end, and the replay, which is true."""
    result = session(["play", *words, "--record", "mine.replay"], pygame.K_UP, *nothing(150))  # the key begins, too
    assert result.exit_code == 0, result.output
    replay = Replay.load("mine.replay")
    assert list(verify(replay)) == []
    return result.output, replay


def test_a_person_plays_to_the_end_and_is_recorded(session):
    printed, replay = played(session, "nearest", "patrol", "--seat", "1")
    assert replay.names == ("nearest", "you", "patrol", "nearest#2")
    assert replay.config.controls[:2] == ("target", "velocity")
    assert replay.steps == 10
    assert {float(commands[1][0]) for commands in replay.commands} == {1.0}
    assert "  you" in printed
    assert "replay: mine.replay" in printed


@pytest.mark.parametrize("name", ["wander", "evasive", "fog", "blinkers", "unequal", "dropout"])
def test_a_scenario_can_be_played_by_a_person(session, name):
    """To its end, even where the person's own hunter drops out."""
    dropout = ["--set", "dropout_rate=0.2"] if name == "dropout" else []
    _, replay = played(session, "--scenario", name, *dropout, "--seed", "3", "intercept")
    assert replay.config.target_motion == SCENARIOS[name].target_motion
    assert replay.steps == 10
    assert (explain(replay).records[0].withdrawn_ms is not None) == (name == "dropout")


def test_a_person_plays_prey(session):
    """Against hunters; what it drives is recorded as the prey's actions."""
    words = ["--scenario", "tag", "--seat", "prey_0", "--seed", "1", "nearest"]
    printed, replay = played(session, *words)
    assert replay.names[3:] == ("you",)
    assert set(replay.config.controls) == {"target"}
    assert {float(commands[3][0]) for commands in replay.commands} == {1.0}
    assert "prey, by number of times caught:\n  1    0  you" in printed


def test_a_person_plays_in_a_team_whose_other_hunters_the_first_agent_plays(session):
    words = ["--scenario", "pairs", "nearest", "patrol", "--seat", "hunter_1"]
    printed, replay = played(session, *words)
    assert replay.names == ("nearest", "you", "patrol", "patrol")
    assert replay.config.controls[1] == "velocity"
    assert " patrol (" in printed  # with the catches of its hunters


def test_pause_holds_the_match_and_a_step_is_one_step(session, tmp_path):
    result = session(
        ["play", "--record", "mine.replay"],
        pygame.K_x,
        pygame.K_p,
        *nothing(40),
        pygame.K_n,
        *nothing(15),
        pygame.K_w,  # drives in the next step, and asks for none
        *nothing(15),
        pygame.K_n,
        *nothing(15),
    )
    assert result.exit_code == 0, result.output
    replay = Replay.load(tmp_path / "mine.replay")
    assert replay.steps == 3
    assert [float(commands[0][0]) for commands in replay.commands] == [0.0, 0.0, 1.0]


def test_ctrl_s_replaces_nothing(session, tmp_path):
    """A match in a window cannot wait for an answer: the replay takes a name that is free."""
    (tmp_path / "match.replay").write_text("mine")
    result = session(["watch", "nearest"], *nothing(20), SAVE)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "match.replay").read_text() == "mine"
    assert Replay.load(tmp_path / "match-2.replay").steps > 0


def test_a_record_that_is_there_is_replaced_with_force_only(session, tmp_path):
    (tmp_path / "r.replay").write_text("mine")
    refused = session(["play", "--record", "r.replay"])
    assert (refused.exit_code, (tmp_path / "r.replay").read_text()) == (2, "mine")
    assert session(["play", "--record", "r.replay", "--force"], pygame.K_UP, *nothing(9)).exit_code == 0
    assert Replay.load(tmp_path / "r.replay").steps > 0


def test_r_begins_the_same_match_again(session, tmp_path):
    result = session(["watch", "nearest"], *nothing(30), pygame.K_r, *nothing(8), SAVE)
    assert result.exit_code == 0, result.output
    assert Replay.load(tmp_path / "match.replay").steps < 4


def test_speed_is_the_pace_of_the_window_and_changes_no_match(session, tmp_path):
    words = ["watch", "nearest", "--seed", "3"]
    plus = pygame.event.Event(pygame.KEYDOWN, key=pygame.K_PLUS, mod=0, unicode="+")
    session(words, [plus] * 9, *nothing(40), SAVE)
    session(words, *nothing(150), SAVE)
    fast, usual = Replay.load(tmp_path / "match.replay"), Replay.load(tmp_path / "match-2.replay")
    assert fast.steps == usual.steps == 10
    assert fast.digests == usual.digests


def test_the_window_may_be_resized_and_the_keys_shown(session, monkeypatch):
    sizes = iter([(320, 320)] * 20)
    drawn = []
    monkeypatch.setattr(match_window.Screen, "size", property(lambda _: next(sizes, (500, 400))))
    monkeypatch.setattr(match_window, "_SETTLED_S", 0.0)
    monkeypatch.setattr(match_window.Screen, "show", lambda _, pixels: drawn.append(pixels.shape[:2]))
    result = session(["watch", "nearest"], *nothing(10), pygame.K_h, *nothing(30), pygame.K_h, *nothing(9))
    assert result.exit_code == 0, result.output
    assert drawn[0] == (320, 320)
    assert drawn[-1] == (400, 500)


def test_v_shows_what_each_hunter_sees_ones_own_first_and_then_nobodys(session, monkeypatch):
    """In every picture of the match, also after the window got another size."""
    shown = []
    draw = match_window.MatchRenderer.draw

    def noted(renderer, time_ms, poses):
        shown.append(renderer.view_of)
        return draw(renderer, time_ms, poses)

    monkeypatch.setattr(match_window.MatchRenderer, "draw", noted)
    sizes = iter([(320, 320)] * 12)
    monkeypatch.setattr(match_window.Screen, "size", property(lambda _: next(sizes, (500, 400))))
    monkeypatch.setattr(match_window, "_SETTLED_S", 0.0)
    words = ["play", "--seat", "2", "--set", "view_radius_m=3"]
    result = session(words, pygame.K_x, *[look for _ in range(5) for look in ([press(pygame.K_v)], *nothing(9))])
    assert result.exit_code == 0, result.output
    assert [one for one, _ in itertools.groupby(shown)] == [None, 2, 3, 0, 1, None]


def test_v_says_where_there_is_nothing_to_show(session, monkeypatch):
    notes = []
    monkeypatch.setattr(match_window.MatchWindow, "notify", lambda _, text: notes.append(text))
    result = session(["watch", "nearest"], *nothing(3), pygame.K_v, *nothing(3))
    assert result.exit_code == 0, result.output
    assert "all hunters see the whole arena" in notes


def test_an_agent_that_fails_comes_last_and_the_others_play_on(session, over, tmp_path):
    (tmp_path / "bad.py").write_text("class Agent:\n def reset(self, seed): 0\n def act(self, view): return 1 / 0\n")
    result = session(["watch", "bad.py", "idle", "--scenario", "duel"], over)
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == [
        "  1    0  idle (hunter_1)",
        "  2    0  bad (hunter_0): FORFEIT_CRASH in step 1: act raised ZeroDivisionError: division by zero",
    ]
    assert "\nbad printed:\nTraceback" in result.stderr


HANGS = "import time\nclass Agent:\n def reset(self, seed): 0\n def act(self, view): time.sleep(600)\n"
SLOW = """import time
class Agent:
    def reset(self, seed):
        self.steps = 0
    def act(self, view):
        self.steps += 1
        time.sleep(0.4 * (self.steps == 2))
        return 1
"""


def test_while_an_agent_hangs_the_window_hears_its_user(session, tmp_path):
    """The limit is an hour: that the command ends shows that nobody waits for it."""
    (tmp_path / "hangs.py").write_text(HANGS)
    patient = ["--limit", "step_ms=1e6", "--limit", "bank_s=3600"]
    result = session(["watch", "hangs.py", "idle", "--scenario", "duel", *patient], *nothing(20))
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == ["  1    0  hangs (hunter_0)", "  1    0  idle (hunter_1)"]


def test_an_agent_that_hangs_is_out_when_its_time_is_up(session, tmp_path, monkeypatch):
    """The script waits for it, as it cannot know how many looks fit into the agent's time."""
    notes = []
    notify = match_window.MatchWindow.notify
    monkeypatch.setattr(
        match_window.MatchWindow, "notify", lambda window, text: (notes.append(text), notify(window, text))
    )

    def out() -> bool:
        return any(text.startswith("hangs has forfeited") for text in notes)

    (tmp_path / "hangs.py").write_text(HANGS)
    short = ["--limit", "init_s=120", "--limit", "step_ms=100", "--limit", "bank_s=0.1"]
    result = session(["watch", "hangs.py", "nearest", "--scenario", "duel", *short], out, *nothing(150), SAVE)
    assert result.exit_code == 0, result.output
    assert (
        "  2    0  hangs (hunter_0): FORFEIT_TIMEOUT in step 1: act took longer than step_ms (100 ms)" in result.stdout
    )
    assert Replay.load(tmp_path / "match.replay").withdrawals == [(0, 0)]


def test_a_slow_agent_plays_on_and_the_window_is_drawn_meanwhile(session, over, tmp_path, monkeypatch):
    waited = []
    drawn = match_window.MatchWindow.wait
    monkeypatch.setattr(match_window.MatchWindow, "wait", lambda window: (waited.append(1), drawn(window)))
    (tmp_path / "slow.py").write_text(SLOW)
    result = session(["watch", "slow.py", "idle", "--scenario", "duel"], over, SAVE)
    assert result.exit_code == 0, result.output
    assert "FORFEIT" not in result.output
    assert Replay.load(tmp_path / "match.replay").steps == 10
    assert waited


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["play", "--seat", "4"], "--seat must be a seat of standard, got 4; known: hunter_0, "),
        (["play", "--seat", "prey_0"], "--seat must be a seat of standard, got prey_0; known: "),
        (
            ["play", "--scenario", "tag", "--seat", "3"],
            "--seat must be a seat of tag, got 3; known: hunter_0, hunter_1, hunter_2, prey_0",
        ),
        (["play", "nearst"], "did you mean nearest"),
        (["play", "nearest", "patrol", "idle", "first"], "number of agents must be at most 3"),
        (["watch", "nearest", "--scenario", "dual"], "did you mean duel"),
        (["play", "nearest", "--record", "."], "the name must end in .replay, got no ending"),
    ],
)
def test_bad_words_are_one_line(session, words, error):
    result = session(words)
    assert result.exit_code == 2
    assert error in result.output
    assert len(result.output.splitlines()) == 1


def test_without_a_display_it_says_so(session, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "no_such_driver")
    result = session(["watch", "nearest"])
    assert result.exit_code == 2
    assert "needs a display" in result.output


def test_a_window_that_nobody_can_see_does_not_wait_for_keys(session, monkeypatch):
    """SDL's last resort draws into memory, where no key will ever come from."""
    monkeypatch.setattr(pygame.display, "get_driver", lambda: "offscreen")
    result = session(["play"])
    assert result.exit_code == 2
    assert "needs a display" in result.output
    assert not pygame.display.get_init()

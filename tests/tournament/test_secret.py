"""The seed of a tournament determines all others, and nobody sees it before the end."""

import json
import re
import sqlite3
from pathlib import Path
from typing import get_args

import pytest
from command_line import run
from tournament.seats import blocks_of, hunters

from catch_arena import scenario
from catch_arena.errors import ConfigError
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.execution.runner import REPLAYS, play_plan
from catch_arena.tournament.plans.schedule import FORMATS, plan_of, round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.secret import Purpose, Secret
from catch_arena.tournament.store import STORE, Store, Tournament

pytestmark = pytest.mark.usefixtures("catch_arena")  # in a folder of its own
PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "seeds.md").read_text()
QUICK = ["-s", "duel", "--set", "time_limit_s=3", "--jobs", "1", "--out", "o"]
PURPOSES = get_args(Purpose)
DRAWN = Secret.parse("5bd1e995c0ffee0123456789abcdef07")
CONFIG = scenario("duel", time_limit_s=3)


def test_the_page_lists_every_purpose_and_its_example_is_right():
    section = PAGE.partition("## How seeds follow")[2]
    assert set(re.findall(r"^\| `([a-z ]+)` \|", section, re.MULTILINE)) == set(PURPOSES)
    assert all(len(words.encode()) <= 16 for words in PURPOSES)
    digits, seed, agent_seed = re.search(
        r"`--seed ([0-9a-f]{32})`.*?block 3.*?(\d{15,}).*?agent 1.*?(\d{15,})", section, re.DOTALL
    ).groups()
    assert Secret.parse(digits).seed("match", 3) == int(seed) < 2**63
    assert Secret.parse(digits).seed("agent", 3, 1) == int(agent_seed)


def test_other_commands_draw_from_a_part_and_a_number_makes_a_secret():
    """These values never change, or no earlier tournament could be played again."""
    assert DRAWN.seed("groups", 1, 2, 3) == 2626483978231115388
    assert DRAWN.part("grade", 1).digits == "e1d94e2fc4daa791ee73ae98a4b08a2b"
    assert Secret.of(7).digits == "7fe7fbbf7ce6ce63a5ed1d4170934dbf"


@pytest.mark.parametrize("form", FORMATS)
def test_a_plan_has_the_seeds_of_its_blocks(form):
    secret = Secret.of(9)
    for number, block in enumerate(plan_of(form, 6, hunters(3), 2, secret).blocks()):
        assert {(match.block, match.seed) for match in block} == {(number, secret.seed("match", number))}
        for match in block:
            assert match.agent_seeds == tuple(secret.seed("agent", number, one) for one in match.seating)
        lots = [secret.seed("seating", number, one) for one in block[0].seating]
        assert lots == sorted(lots)


def test_exactly_32_hexadecimal_digits_are_a_secret_and_all_else_is_a_number():
    digits = "00112233445566778899aAbBcCdDeEfF"
    assert Secret.parse(digits).digits == Secret.parse(digits).text == digits.lower()
    assert Secret.parse("0" * 31 + "7").key == bytes(15) + b"\7"
    assert Secret.parse("7") == Secret.of(7) == Secret.parse(Secret.of(7).digits) != Secret.parse("0" * 31 + "7")
    assert (Secret.parse("007").text, Secret.parse("007").number, Secret.parse(digits).number) == ("7", 7, None)
    assert Secret.of(None) != Secret.of(None)
    assert len(Secret.of(None).key) == 16


@pytest.mark.parametrize(
    "text", ["", "-1", "7.0", "0x7", "1e3", " 7", "٣", "f" * 31, "f" * 33, "g" * 32, str(2**64), "9" * 5000]
)
def test_a_text_that_is_neither_is_one_line(text):
    with pytest.raises(
        ConfigError, match="seed must be 32 hexadecimal digits, or a whole number from 0 to 2\\^64 - 1"
    ) as raised:
        Secret.parse(text)
    assert len(str(raised.value)) < 200


def test_neither_a_secret_nor_a_match_shows_its_seeds_where_it_is_printed():
    secret = DRAWN
    match = next(iter(round_robin(2, hunters(2), 1, secret)))
    plan = plan_of("round-robin", 4, hunters(2), 1, secret)
    for text in (repr(secret), str(secret), f"{secret}", repr(match), repr(plan)):
        assert secret.digits not in text
        assert repr(secret.key) not in text
        assert not re.search(r"\d{10}", text)


def test_the_seed_is_told_in_the_end_and_repeats_all_of_it():
    words = ["tournament", "random", "nearest", "--rounds", "1", *QUICK[:-1]]
    first = run(*words, "a")
    digits = json.loads(Path("a/standings.json").read_text())["seed"]
    assert re.fullmatch("[0-9a-f]{32}", digits)
    assert f"seed: {digits}\n" in first.output
    assert f"<code>{digits}</code>" in Path("a/report.html").read_text()
    assert run(*words, "b", "--seed", digits.upper()).exit_code == 0
    assert run(*words, "c").exit_code == 0
    for out in "abc":
        run("export", out, "--no-timing", "-o", f"{out}.csv")
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes() != Path("c.csv").read_bytes()
    assert digits in Path("a.csv").read_text()


def test_a_number_can_be_guessed_and_the_results_say_so():
    done = run("tournament", "random", "idle", "--rounds", "1", *QUICK, "--seed", "7")
    digits = Secret.of(7).digits
    assert f"seed: {digits} (from 7, which agents can guess)" in done.output
    assert "it was set as a number (7), which can be guessed" in Path("o/report.html").read_text()
    assert json.loads(Path("o/standings.json").read_text())["seed"] == digits


def test_resume_keeps_the_secret():
    """Drawn, given as digits or as a number; and a command with another one does not show it."""
    words = ["tournament", "random", "idle", *QUICK, "--rounds", "2"]
    assert run(*words).exit_code == 0
    secret = Store.tournament_in(Path("o")).secret
    with sqlite3.connect(f"o/{STORE}") as db:  # as where it was broken off
        db.execute("DELETE FROM match WHERE id LIKE 'r00002%'")
    db.close()
    refused = run(*words, "--resume", "--seed", "7")
    assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
    assert "its seed is another one; without --seed it keeps its own" in refused.stderr
    assert secret.digits not in refused.output
    assert run(*words, "--resume").exit_code == 0
    assert json.loads(Path("o/standings.json").read_text())["seed"] == secret.digits
    assert run(*words, "--resume", "--seed", secret.digits).exit_code == 0


class Breaks(Executor):
    """Executor that is interrupted in the second match of a block."""

    def run(self, work, matches, excluded):
        if matches[0].block == 1:
            super().run(work, matches[:1], excluded)
            raise KeyboardInterrupt
        return super().run(work, matches, excluded)


def test_no_replay_of_a_block_lies_there_before_it_has_ended(tmp_path):
    """Not where it broke off within the block."""
    entrants, secret = enter(["random", "idle"]), DRAWN
    plan, worker = round_robin(2, hunters(2), 3, secret), Worker(CONFIG, entrants, record=True)
    first, *_ = blocks_of(plan)

    def replays():
        return {path.stem for path in (tmp_path / REPLAYS).glob("*.replay")}

    with Store.begin(Tournament(CONFIG, entrants, plan.parameters, seed=secret.text), tmp_path) as store:
        with pytest.raises(KeyboardInterrupt):
            play_plan(store, plan, Breaks(worker))
        assert replays() == {match.id for match in first}
        assert not store.ended
        play_plan(store, plan, Executor(worker))
        assert replays() == {match.id for match in plan}
        assert store.ended

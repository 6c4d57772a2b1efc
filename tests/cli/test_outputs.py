"""A command that writes a file replaces none without --force, and checks the ending of its name."""

import os
import pkgutil
import stat
from pathlib import Path

import pytest
from command_line import run

from catch_arena.tournament import match_loop

pytestmark = pytest.mark.usefixtures("catch_arena")  # in a folder of its own
QUICK = ["--scenario", "duel", "--set", "time_limit_s=3"]
SMALL = ["--size", "320x320", "--fps", "10"]


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A folder with a tournament, its replays, a match in which something happens, and a spec."""
    folder = tmp_path_factory.mktemp("played")
    words = ["tournament", "nearest", "contested", "--rounds", "1", *QUICK, "--jobs", "1", "--record"]
    assert run(*words, "--out", str(folder / "o")).exit_code == 0
    words = ["match", "nearest", "contested", "-s", "duel", "--set", "time_limit_s=20", "--seed", "1"]
    assert run(*words, "-o", str(folder / "eventful" / "m.replay")).exit_code == 0
    (folder / "spec.toml").write_text(
        'seed = 1\nmatches = 1\n[[test]]\nname = "t"\nscenario = "capstone"\nsettings = { time_limit_s = 1 }\n'
    )
    return folder


def words_of(words, played):
    replay = played / "o/replays/r00001-g000001-s00.replay"
    return [word.replace("{r}", str(replay)).replace("{o}", str(played / "o")) for word in words]


WRITERS = {
    "mine.replay": ["match", "nearest", "idle", *QUICK, "-o", "mine.replay"],
    "v.mp4": ["render", "{r}", "-o", "v.mp4", *SMALL],
    "v.gif": ["render", "{r}", "-o", "v.gif", *SMALL],
    "g.mp4": ["mosaic", "{o}/replays", "-o", "g.mp4", "--count", "1", "--speed", "8"],
    "e.csv": ["export", "{o}", "-o", "e.csv"],
    "grades.json": ["grade", "idle", "--spec", "{o}/../spec.toml", "--json", "grades.json"],
    "grades.xml": ["grade", "idle", "--spec", "{o}/../spec.toml", "--junit", "grades.xml"],
    "seeds.json": ["grade", "idle", "--spec", "{o}/../spec.toml", "--seeds", "seeds.json"],
    "c.xml": ["conformance", "catch_arena:arbitrate", "--only", "reach", "--junit", "c.xml"],
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_that_is_there_stays_unless_force_is_given(played, tmp_path, name):
    words = words_of(WRITERS[name], played)
    Path(name).write_text("mine")
    refused = run(*words)
    assert refused.exit_code == 2
    assert refused.stderr == f"error: {name}: already exists; use --force to replace it, or choose another name\n"
    assert not refused.stdout
    assert Path(name).read_text() == "mine"
    run(*words, "--force")
    assert Path(name).read_bytes() != b"mine"
    assert [path.name for path in tmp_path.iterdir()] == [name]


UNNAMED = {
    "match.replay": ["match", "nearest", "idle", *QUICK],
    "highlights.mp4": ["highlights", "{o}/../eventful", "--count", "1", *SMALL],
}


@pytest.mark.parametrize("name", UNNAMED)
def test_a_command_without_a_name_for_its_file_takes_the_first_free_one(played, name):
    """The output names the file; with --force the usual name is taken."""
    words = words_of(UNNAMED[name], played)
    Path(name).write_text("mine")
    second = Path(name).with_stem(f"{Path(name).stem}-2")
    done = run(*words)
    assert done.exit_code == 0, done.output
    assert second.name in done.stdout
    assert Path(name).read_text() == "mine"
    written = second.read_bytes()
    assert run(*words, "--force").exit_code == 0
    assert Path(name).read_bytes() != b"mine"
    assert second.read_bytes() == written


def test_what_a_tournament_writes_from_its_store_is_made_anew(played):
    report, other = played / "o" / "report.html", played / "other.html"
    before = report.read_bytes()
    report.write_text("old")
    for words, path in (([], report), (["-o", str(other)], other)):
        done = run("report", str(played / "o"), *words)
        assert (done.exit_code, done.stdout) == (0, f"report: {path}\n")
        assert path.read_bytes() == before


def test_a_tournament_does_not_write_into_the_folder_of_an_agent():
    """The agent would see the store, and its digest would change."""
    Path("mine").mkdir()
    Path("mine/agent.py").write_text("from catch_arena.agents.idle import Agent\n")
    refused = run("tournament", "mine", "idle", "--rounds", "1", *QUICK, "--out", "mine/out")
    assert refused.exit_code == 2
    assert refused.stderr.endswith(
        "error: mine/out: lies in the folder of agent mine, which sees all files there; choose another folder\n"
    )
    assert not Path("mine/out").exists()


def test_a_tournament_writes_into_a_folder_of_another_origin_only_if_force_is_given():
    """A folder without a store has nothing that was made from one, so that it would be lost."""
    words = ["tournament", "nearest", "idle", "--rounds", "1", *QUICK, "--jobs", "1", "--record", "--out", "other"]
    Path("other/replays").mkdir(parents=True)
    names = ["report.html", "standings.csv", "standings.json", "replays/mine.replay"]
    for name in names:
        Path("other", name).write_text("mine")
    for more in ([], ["--resume"]):
        refused = run(*words, *more)
        assert (refused.exit_code, refused.stdout) == (2, "")
        assert refused.stderr == (
            "error: other: has other files; use --force to write into it, or choose another folder\n"
        )
        assert {Path("other", name).read_text() for name in names} == {"mine"}
        assert not Path("other/tournament.sqlite").exists()
    assert run(*words, "--force").exit_code == 0
    assert [name for name in names if Path("other", name).read_bytes() == b"mine"] == ["replays/mine.replay"]
    again = run(*words, "--resume")
    assert again.exit_code == 0, again.output
    refused = run(*words, "--force")
    assert "holds a tournament already" in refused.stderr  # what was played is never replaced


@pytest.mark.parametrize(
    ("words", "start"),
    [
        (["-o", "m.jsonl"], b'{"match":'),
        (["-o", "m.CSV"], b"match,block,seed,"),
        (["-o", "m.parquet"], b"PAR1"),
    ],
)
def test_an_export_has_the_format_that_its_name_says(played, words, start):
    assert run("export", str(played / "o"), *words).exit_code == 0
    assert Path(words[1]).read_bytes().startswith(start)


def test_the_tilde_of_an_option_with_an_equals_sign_is_the_home_folder(tmp_path, monkeypatch):
    """The shell leaves it as it is."""
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    assert run("match", "nearest", "idle", *QUICK, "--output=~/m.replay").exit_code == 0
    assert (tmp_path / "home" / "m.replay").stat().st_size > 0


@pytest.mark.parametrize(
    ("name", "work"),
    [
        ("mine.replay", "catch_arena.tournament.match_loop.play_entrants"),
        ("v.mp4", "catch_arena.render.video.render_replay"),
        ("grades.json", "catch_arena.tournament.grading.grade_agent"),
        ("e.csv", "catch_arena.tournament.export.export"),
    ],
)
def test_of_two_commands_at_the_same_time_the_second_does_not_get_the_name_of_the_first(
    played, tmp_path, monkeypatch, name, work
):
    """The second command begins and ends while the first one works."""
    words = words_of(WRITERS[name], played)
    do, seconds = pkgutil.resolve_name(work), []

    def meanwhile(*arguments, **options):
        seconds.append(run(*words))
        return do(*arguments, **options)

    monkeypatch.setattr(work, meanwhile)
    first = run(*words)
    assert first.exit_code in {0, 1}
    assert [second.exit_code for second in seconds] == [2]
    assert seconds[0].stderr == f"error: {name}: already exists; use --force to replace it, or choose another name\n"
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert Path(name).stat().st_size


def test_an_interrupted_command_leaves_no_name_reserved(tmp_path, monkeypatch):

    def interrupted(*_, **__):
        assert Path("m.replay").exists()
        raise KeyboardInterrupt

    monkeypatch.setattr(match_loop, "play_entrants", interrupted)
    run("match", "nearest", "idle", *QUICK, "-o", "m.replay")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["match", "nearest", "idle", *QUICK, "-o", "m.mp4"], "must end in .replay, got .mp4"),
        (["match", "nearest", "idle", *QUICK, "-o", "m.mkv"], "must end in .replay, got .mkv"),
        (["match", "nearest", "idle", *QUICK, "-o", "m"], "must end in .replay, got no ending"),
        (["play", "nearest", "--record", "m.gif"], ".replay, got .gif"),
        (["render", "{r}", "-o", "v.png"], ".mp4, .webm, .gif, .webp or .html, got .png"),
        (["mosaic", "{o}/replays", "-o", "g.html"], ".webp, got .html"),
        (["highlights", "{o}/replays", "-o", "g.json"], ".webp, got .json"),
        (["export", "{o}", "-o", "e.replay"], ".parquet, got .replay"),
        (["report", "{o}", "-o", "r.CSV"], ".html, got .csv"),
        (["grade", "idle", "--spec", "{o}/../spec.toml", "--junit", "g.json"], ".xml, got .json"),
        (["grade", "idle", "--spec", "{o}/../spec.toml", "--seeds", "g.toml"], "must end in .json, got .toml"),
        (["conformance", "catch_arena:arbitrate", "--only", "reach", "--junit", "c.json"], ".xml, got .json"),
    ],
)
def test_the_name_of_another_format_is_refused(played, tmp_path, words, why):
    refused = run(*words_of(words, played))
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert len(refused.stderr.splitlines()) == 1
    assert f"error: {words[-1]}: the name must end in " in refused.stderr
    assert why in refused.stderr
    assert not list(tmp_path.iterdir())


def test_seeds_are_for_their_owner_alone(played, tmp_path):
    """Others may read grades, if the umask allows it."""
    spec, grades, seeds = played / "spec.toml", tmp_path / "grades.json", tmp_path / "seeds.json"
    seeds.touch(0o644)
    words = ["grade", "idle", "--spec", str(spec), "--json", str(grades), "--seeds", str(seeds), "--force"]
    umask = os.umask(0o027)
    try:
        assert run(*words).exit_code == 0
    finally:
        os.umask(umask)
    assert [stat.S_IMODE(path.stat().st_mode) for path in (grades, seeds)] == [0o640, 0o600]

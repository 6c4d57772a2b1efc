"""`catch-arena mosaic` and `highlights` print, write and exit as documented."""

import re
import signal
import subprocess
import sys
import time

import pytest
from command_line import run

SMALL = ["--size", "480x320", "--fps", "10"]


@pytest.fixture(scope="module")
def matches(play):
    return [play("duel", seed=seed, time_limit_s=6.0, names=("ann", "bob")) for seed in range(3)]


@pytest.fixture(autouse=True)
def folder(matches, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    where = tmp_path / "replays"
    where.mkdir()
    for seed, match in enumerate(matches):
        match.save(where / f"m{seed}.replay")
    return where


def test_a_mosaic_of_a_folder(tmp_path):
    result = run("mosaic", "replays", "-o", "out/grid.mp4", "--speed", "4", "--count", "9")
    assert result.exit_code == 0, result.output
    assert "matches: 3 of 3\n" in result.output
    assert (tmp_path / "out" / "grid.mp4").is_file()


def test_the_list_says_file_time_kind_and_caption_and_writes_nothing(tmp_path):
    result = run("highlights", "replays", "--list", "--count", "2")
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert len(lines) == 2
    assert all(re.match(r"m\w*\.replay  \d+\.\d s  \w[\w ]*: .*\(R[0-9.]+\)$", line) for line in lines)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["replays"]


def test_fewer_highlights_than_asked_for_are_not_passed_over_in_silence():
    """On stderr, so that the list stays a list."""
    result = run("highlights", "replays", "--list", "--count", "99")
    count = len(result.stdout.splitlines())
    assert f"moments: {count}, not 99: there are no more that do not overlap\n" in result.stderr
    assert count < 8
    for words in (("--count", str(count)), ()):  # without --count no number was asked for
        assert "moments:" not in run("highlights", "replays", "--list", *words).output


def test_a_broken_replay_is_told_and_the_others_are_shown(folder, matches):
    content = (folder / "m0.replay").read_bytes()
    (folder / "m0.replay").write_bytes(content[:100])
    other = matches[1].__class__.load(folder / "m1.replay")
    other.digests[30] = b"12345678"
    other.save(folder / "m1.replay")
    result = run("highlights", "replays", "--list")
    assert result.exit_code == 0, result.output
    assert "left out: replays/m0.replay: " in result.output
    assert "left out: replays/m1.replay: " in result.output
    assert "m2.replay" in result.output


def test_folders_without_anything_to_show_are_one_line(folder, play):
    empty, quiet = folder.parent / "empty", folder.parent / "quiet"
    empty.mkdir()
    quiet.mkdir()
    play("duel", time_limit_s=0.2).save(quiet / "q.replay")
    (folder.parent / "best.mp4").write_bytes(b"as it was")
    for where, error in (("empty", "contains no replays"), ("nowhere", "is not a folder"), ("quiet", "no highlights")):
        result = run("highlights", where, "-o", "best.mp4", "--force")
        assert result.exit_code == 2
        assert error in result.output
        assert len(result.stderr.splitlines()) == 1
    assert (folder.parent / "best.mp4").read_bytes() == b"as it was"
    (quiet / "q.replay").write_bytes(b"nothing")
    assert "none of 1 replays" in run("mosaic", "quiet", "-o", "grid.mp4").output


def test_ctrl_c_leaves_no_half_written_video(tmp_path):
    words = [sys.executable, "-m", "catch_arena", "mosaic", "replays", "-o", "grid.mp4", "--speed", "0.02"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 240
        while not list(tmp_path.glob(".catch-arena-*.mp4")) and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        assert "interrupted" in process.communicate(timeout=240)[1]
        assert process.returncode == 130
    assert sorted(path.name for path in tmp_path.iterdir()) == ["replays"]

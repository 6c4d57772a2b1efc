"""Commands can be read in full on a narrow terminal, in a file, and under LANG=C."""

import os
import pty
import re
import struct
import subprocess
import sys
import termios
from fcntl import ioctl
from pathlib import Path

import pytest

PROGRAM = str(Path(sys.executable).parent / "catch-arena")
ESCAPES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
PLAIN = {"LC_ALL": "C", "TERM": "xterm-256color"}
LEFT_OUT = {"LANG", "LC_ALL", "LC_CTYPE", "PYTHONUTF8", "PYTHONIOENCODING", "COLUMNS", "LINES"}


def environment(**more: str) -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in LEFT_OUT} | more


def in_a_file(*words: str, **more: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([PROGRAM, *words], capture_output=True, check=False, env=environment(**more))


def on_a_terminal(*words: str, columns: int, **more: str) -> str:
    """All that is shown, without what moves and colours it."""
    return shown_on_a_terminal([PROGRAM, *words], columns=columns, **more)


def shown_on_a_terminal(command: list[str], *, columns: int, **more: str) -> str:
    """Return what any command shows on a terminal."""
    ours, theirs = pty.openpty()
    ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    shown = b""
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment(**more)):
        os.close(theirs)
        try:
            while part := os.read(ours, 65536):
                shown += part
        except OSError:  # the other end is closed
            os.close(ours)
    return ESCAPES.sub("", shown.decode()).replace("\r\n", "\n")


def test_the_help_is_narrow_through_a_pipe_as_well():
    """The terminal is that of the input and of the errors."""
    shell = ["sh", "-c", 'exec "$0" match --help | cat', PROGRAM]
    text = shown_on_a_terminal(shell, columns=40)
    assert "…" not in text
    assert max(map(len, text.splitlines())) <= 44
    assert "--trusted" in text
    assert 40 < max(map(len, shown_on_a_terminal(shell, columns=100).splitlines())) <= 80


def test_the_tables_fit_forty_columns():
    for words in (["agents"], ["scenarios"]):
        text = on_a_terminal(*words, columns=40)
        assert "…" not in text
        assert max(len(line.rstrip()) for line in text.splitlines()) <= 40


def test_a_tournament_fits_forty_columns(tmp_path):
    """The bar, and the standings in the end."""
    words = ["nearest", "first", "--trusted", "--rounds", "1", "--jobs", "1", "-s", "duel", "--set", "time_limit_s=3"]
    text = on_a_terminal("tournament", *words, "--out", str(tmp_path / "out"), columns=40, **PLAIN)
    assert "…" not in text
    assert "2/2" in text
    unfolded = re.sub(r"\s+", " ", text)
    assert "grp: members of a group do not differ significantly" in unfolded


@pytest.mark.parametrize(
    ("words", "letters"),
    [
        (["agents"], "─"),
        (["tournament", "--help"], "--trusted"),
        (["conformance", "--list", "--only", "names"], "žółw"),
    ],
)
def test_under_lang_c_letters_are_no_reason_to_stop(words, letters):
    """They come as UTF-8, and a file gets no escape codes."""
    for plain in (PLAIN, PLAIN | {"COLUMNS": "40"}):
        run = in_a_file(*words, **plain)
        assert run.returncode == 0, run.stderr
        assert not run.stderr
        assert b"\x1b" not in run.stdout
        assert run.stdout.decode().count("…") == 0 or "COLUMNS" not in plain
        assert letters in run.stdout.decode() or "COLUMNS" in plain


def test_an_error_under_lang_c_is_a_line():
    run = in_a_file("verify", "größe.replay", **PLAIN)
    assert run.returncode == 2
    assert b"Traceback" not in run.stderr
    assert "größe.replay: " in run.stderr.decode()


def test_a_terminal_that_lacks_a_letter_gets_a_question_mark():
    run = in_a_file("conformance", "--list", "--only", "names", PYTHONIOENCODING="latin-1")
    assert run.returncode == 0, run.stderr
    text = run.stdout.decode("latin-1")
    assert "stra\xdfe is alive" in text
    assert "?\xf3?w" in text  # żółw

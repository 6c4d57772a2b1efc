"""The hook that checks the subjects of commits."""

import subprocess
from pathlib import Path

import pytest

HOOK = Path(__file__).parents[2] / ".githooks" / "commit-msg"


@pytest.mark.parametrize(
    ("subject", "why"),
    [
        ("Add a column", ""),
        ("Pass the seed on", ""),
        ("Merge branch 'a branch with a very long name that git has written by itself, which is fine'", ""),
        ("x" * 73, "at most 72 characters, got 73"),
        ("Added a column", "imperative"),
        ("Adds a column", "imperative"),
        ("Adding a column", "imperative"),
        ("add a column", "imperative"),
    ],
)
def test_a_subject_is_short_and_imperative(tmp_path, subject, why):
    message = tmp_path / "message"
    message.write_text(f"{subject}\n\nThe body says why.\n")
    ended = subprocess.run([HOOK, message], capture_output=True, text=True, check=False)
    assert (ended.returncode, why in ended.stderr) == (int(bool(why)), True)

"""Text from agents is only text in a report, and no path of the teacher's machine stands in it."""

import base64
import csv
import hashlib
import re
import urllib.request
from html import unescape

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from report.synthetic import tournament

from catch_arena.report import write_report
from catch_arena.report.data import ReportData
from catch_arena.report.watch import LiveReport, serve
from catch_arena.text import spreadsheet_cell, without_folders
from catch_arena.tournament.export import TABLES, write_standings


def policy_of(text):
    return re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', text).group(1)


def scripts_of(text):
    """Return the scripts that run; blocks of data have another type."""
    return re.findall(r"<script>(.*?)</script>", text, re.DOTALL)


def test_the_policy_lets_the_pages_own_scripts_run_and_no_other(tmp_path):
    tournament(tmp_path, 1, ["<script>alert(1)</script>", "b", "c", "d"])
    text = write_report(tmp_path).read_text(encoding="utf-8")
    policy = policy_of(text).replace("&#39;", "'")
    digests = {
        f"'sha256-{base64.b64encode(hashlib.sha256(one.encode()).digest()).decode()}'" for one in scripts_of(text)
    }
    parts = dict(part.split(" ", 1) for part in policy.split("; "))
    assert set(parts["script-src"].split()) == digests
    assert len(digests) == 2
    assert {parts[name] for name in ("default-src", "connect-src", "base-uri", "form-action")} == {"'none'"}
    assert text.index("Content-Security-Policy") < text.index("<style>")  # it holds for what follows it


def test_the_served_page_has_it_too_and_stands_in_no_frame(tmp_path):
    tournament(tmp_path, 1)
    with serve(LiveReport(tmp_path)) as address:
        for path in ("", "state"):
            with urllib.request.urlopen(address + path, timeout=30) as answer:  # noqa: S310 - ours
                policy = answer.headers["Content-Security-Policy"]
                assert "connect-src 'self'" in policy
                assert "frame-ancestors 'none'" in policy
                assert policy_of(answer.read().decode()).replace("&#39;", "'") in policy if not path else True


def test_a_report_has_no_whole_path_and_no_whole_command(tmp_path):
    folder = tmp_path / "home of ann"
    specs = [
        f"{folder}/hand ins/mine.py",
        f"cmd:/usr/bin/python3 {folder}/bot.py --token hunter2",
        "package.module:Agent",
        "catch_arena.agents.nearest:Agent",
    ]
    reason = f"{specs[0]}: importing it raised FileNotFoundError: No such file: '{folder}/weights of mine.npz'"
    tournament(folder, 1, ["mine", "bot", "theirs", "nearest"], specs=specs, reason=reason)
    text = write_report(folder).read_text(encoding="utf-8")
    for secret in (str(tmp_path), "home of ann", "hunter2", "/usr/bin", "--token"):
        assert secret not in text
    for spec in ("mine.py", "a command: python3", "package.module:Agent", "catch_arena.agents.nearest:Agent"):
        assert f"<td>{spec}</td>" in text
    assert "mine.py: importing it raised FileNotFoundError: No such file: &#39;weights of mine.npz&#39;" in text


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("/home/ann/hw/agent.py: importing it raised", "agent.py: importing it raised"),
        ("'/home/ann smith/x.npz'", "'x.npz'"),
        ("in ~/x/y.py", "in y.py"),
        (r"C:\Users\ann\x.py", "x.py"),
        ("path=/tmp/x/y", "path=y"),
        ("https://example.com/a/b", "https://example.com/a/b"),
        ("<b>no</b></i>", "<b>no</b></i>"),
        ("3/4 of a/b/c", "3/4 of a/b/c"),
        (r"\ud800\x1b[2J", r"\ud800\x1b[2J"),
    ],
)
def test_a_whole_path_is_told_by_its_last_part(text, short):
    assert without_folders(text) == short


@settings(max_examples=15, deadline=None)
@given(st.lists(st.text(min_size=1, max_size=100).filter(str.isprintable), min_size=4, max_size=4, unique=True))
def test_any_name_that_may_be_entered_stands_in_the_report_as_it_is(tmp_path_factory, names):
    folder = tmp_path_factory.mktemp("names")
    tournament(folder, 1, names, specs=[f"{place}.py" for place in range(4)])
    text = write_report(folder).read_text(encoding="utf-8")
    shown = [unescape(name) for name in re.findall(r'<th scope="row">([^<]*)</th>', text)]
    assert {name for name in shown if name in names} == set(names)
    assert len(scripts_of(text)) == 2
    data = ReportData.of(folder)
    write_standings(folder, data.tournament, len(data.played), {"hunter": data.standings})
    with (folder / TABLES["hunter"]).open(newline="", encoding="utf-8") as file:
        assert {row["agent"] for row in csv.DictReader(file)} == set(map(spreadsheet_cell, names))

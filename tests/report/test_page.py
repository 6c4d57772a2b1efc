"""The page itself, as text."""

import json
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser

import pytest
from report.synthetic import tournament

from catch_arena.errors import ReplayError, StoreError
from catch_arena.report import REPORT, write_report
from catch_arena.report.data import ReportData
from catch_arena.report.selection import select_matches

WICKED = ['<script>alert("x")</script>', '"><img src=x onerror=alert(1)>', "{{ 7 * 7 }}", "O'Brien & sons"]

VOID = {"meta", "link", "br", "input", "path", "circle"}


class Outline(HTMLParser):
    """The elements of a page; fails where they are not nested."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


def report_of(folder):
    return write_report(folder).read_text(encoding="utf-8")


def test_a_report_tells_of_every_agent_and_asks_nothing_of_any_other_place(tmp_path):
    tournament(tmp_path, 1)
    text = report_of(tmp_path)
    for tag, attributes in Outline(text).elements:
        assert tag != "iframe"
        for name in ("src", "href"):
            assert attributes.get(name, "#").startswith(("#", "data:,"))
    assert not re.search(r"@import|url\(|https?:", text)
    for name in ("contested", "patrol", "nearest", "first", "idle", "random"):
        assert f'<th scope="row">{name}</th>' in text


def test_names_are_escaped_wherever_they_stand(tmp_path):
    tournament(tmp_path, 1, WICKED, forfeits=True)
    text = report_of(tmp_path)
    scripts = [attributes for tag, attributes in Outline(text).elements if tag == "script"]
    assert len(scripts) == 4
    assert not any(tag == "img" for tag, _ in Outline(text).elements)
    assert "<script>alert" not in text
    assert ">{{ 7 * 7 }}<" in text
    assert "<b>no</b>" not in text  # what an agent raised


def test_the_same_matches_make_the_same_bytes_in_every_process_and_at_any_time(tmp_path):
    tournament(tmp_path, 1)
    text = report_of(tmp_path)
    write = (
        "import sys, time; from pathlib import Path; time.time = lambda: 2e9; "
        "from catch_arena.report import write_report; write_report(Path(sys.argv[1]))"
    )
    for order in ("1", "2"):  # of sets
        environment = os.environ | {"PYTHONHASHSEED": order}
        subprocess.run([sys.executable, "-c", write, tmp_path], check=True, env=environment)
        assert (tmp_path / REPORT).read_text(encoding="utf-8") == text


def test_forfeits_are_told_with_code_reason_and_place(tmp_path):
    tournament(tmp_path, 3, forfeits=True)
    text = report_of(tmp_path)
    count = sum(any(one.result.forfeits) for one in ReportData.of(tmp_path).played)
    assert count > 3
    line = re.search(r"<li><strong>random</strong>.*?</li>", text).group()
    assert f"{count} ×, first in match r0000" in line
    assert "step 7" in line
    assert "act raised ValueError: &lt;b&gt;no&lt;/b&gt;" in line


def test_a_tournament_under_way_says_so(tmp_path):
    tournament(tmp_path, 1, most=24)
    text = report_of(tmp_path)
    assert "24 <small>of 60</small>" in text
    assert "comes first" not in text


def test_a_tournament_without_matches_has_no_report(tmp_path):
    with pytest.raises(StoreError, match="holds no tournament"):
        write_report(tmp_path)
    tournament(tmp_path, 1, most=0)
    with pytest.raises(StoreError, match="no match has been played yet"):
        write_report(tmp_path)


def test_recorded_matches_play_in_the_page_within_the_budget(played):
    data = ReportData.of(played)
    every = select_matches(data, 10**6)
    assert set(every) == data.recorded == {one.match.id for one in data.played}
    size = max(len(one.bundle) for one in every.values())
    some = select_matches(data, 2 * size)
    assert 1 <= len(some) < len(every)
    assert sum(len(one.bundle) for one in some.values()) <= 2 * size
    assert select_matches(data, 0) == {}


def test_a_match_that_is_asked_for_is_there_whatever_the_budget(played):
    data = ReportData.of(played)
    last = max(data.recorded)
    assert list(select_matches(data, 0, [last])) == [last]
    with pytest.raises(
        ReplayError, match="match nothing: cannot be shown; it must be a match that was played and recorded"
    ):
        select_matches(data, 0, ["nothing"])


def test_the_page_does_without_a_recorded_match_that_cannot_be_read(played, tmp_path):
    """It is told of it where just this match was asked for."""
    folder = shutil.copytree(played, tmp_path / "damaged")
    data = ReportData.of(folder)
    damaged, *others = sorted(data.recorded)
    (folder / "replays" / f"{damaged}.replay").write_bytes(b"no replay")
    assert sorted(select_matches(data, 10**6)) == others
    with pytest.raises(ReplayError, match="is not a Catch Arena replay"):
        select_matches(data, 10**6, [damaged])


def test_a_tournament_leaves_its_report(played):
    text = (played / REPORT).read_text(encoding="utf-8")
    selected = json.loads(re.search(r'id="bundles">(.*?)</script>', text).group(1))
    assert set(selected) == ReportData.of(played).recorded

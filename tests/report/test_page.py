"""The page of a report is complete, and the same matches give the same bytes."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from report.synthetic import tournament

from catch_arena.errors import ReplayError, StoreError
from catch_arena.report import REPORT, write_report
from catch_arena.report.data import ReportData
from catch_arena.report.selection import select_matches


def report_of(folder):
    return write_report(folder).read_text(encoding="utf-8")


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
    assert f"{count} ×, first in round 1, match " in line
    assert "step 7" in line
    assert "act raised ValueError: &lt;b&gt;no&lt;/b&gt;" in line


def test_a_tournament_without_matches_has_no_report(tmp_path):
    tournament(tmp_path, 1, most=0)
    with pytest.raises(StoreError, match="no match has been played yet"):
        write_report(tmp_path)


def test_a_match_that_is_asked_for_is_there_whatever_the_budget(played):
    data = ReportData.of(played)
    last = max(data.recorded)
    assert list(select_matches(data, 0, [last])) == [last]


def test_the_page_does_without_a_recorded_match_that_cannot_be_read(played, tmp_path):
    """Asking for this match by its name is an error."""
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

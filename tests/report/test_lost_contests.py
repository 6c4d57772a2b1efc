"""The report has for each agent the closest contest that it lost, with what would have won it."""

import base64
import gzip
import json
import re
from dataclasses import replace

import pytest

from catch_arena.explanation import explain
from catch_arena.explanation.highlights import best_highlights
from catch_arena.report import write_report
from catch_arena.report.data import ReportData
from catch_arena.report.lost_contests import answer_to, find_lost_contests
from catch_arena.verdicts import Verdict


@pytest.fixture(scope="module")
def data(played):
    return ReportData.of(played)


@pytest.fixture(scope="module")
def events(data):
    return {match: explain(data.replay(match)) for match in sorted(data.recorded)}


@pytest.fixture(scope="module")
def lost(data, events):
    return find_lost_contests(data, events)


def test_each_agent_has_the_closest_contest_that_it_lost_as_the_nearest_loser(data, lost):
    margins = {}
    for match in data.recorded:
        replay = data.replay(match)
        for contest in explain(replay).contests:
            loser = replay.names[contest.claims[1].seat]
            margins.setdefault(loser, []).append(contest.margin_um)
    assert {one.agent: one.answer.contest.margin_um for one in lost} == {name: min(of) for name, of in margins.items()}
    assert len(lost) > 1
    ordered = [one.answer.contest.margin_um for one in lost]
    assert ordered == sorted(ordered)
    for one in lost:
        replay, claims = data.replay(one.match), one.answer.contest.claims
        assert one.answer.contest in explain(replay).contests
        assert [replay.names[claim.seat] for claim in claims[:2]] == [one.winner, one.agent]
        assert claims[1].verdict is Verdict.LOST_CONTEST
        assert one.answer.seat == claims[1].seat


def test_the_best_moment_has_the_answer_to_its_contest(events, lost):
    ((_, moment),) = best_highlights(events, 1)
    contest = lost[0].answer.contest
    for kind, answer in (("contest", lost[0].answer), ("finish", None)):
        highlight = replace(moment, kind=kind, decisive_ms=contest.judged_ms)
        assert answer_to((lost[0].match, highlight), lost) == answer
    assert answer_to(None, lost) is None


def test_the_page_has_the_answers_and_its_replays_show_them(played, lost, tmp_path):
    text = write_report(played, output=tmp_path / "report.html").read_text(encoding="utf-8")
    section = re.search(r'<section id="what-if".*?</section>', text, re.DOTALL).group()
    for one in lost:
        at = one.answer.contest.judged_ms / 1000
        assert one.answer.sentence.replace("'", "&#39;") in section
        assert f'href="#match={one.match}&amp;t={at}&amp;what-if"' in section
    bundles = json.loads(re.search(r'id="bundles">(.*?)</script>', text, re.DOTALL).group(1))
    plain = {match for match, (bundle, _) in bundles.items() if '"answers":[]' in _facts(bundle)}
    assert set(bundles) - plain == {one.match for one in lost}


def _facts(bundle):
    return gzip.decompress(base64.b64decode(bundle)).split(b"\n")[0].decode()

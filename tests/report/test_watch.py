"""A running tournament is served to this machine alone, and the page follows it."""

import socket
import urllib.error
import urllib.request
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest
from report.synthetic import tournament

from catch_arena.player.bundle import bundle_text
from catch_arena.report import watch
from catch_arena.report.data import ReportData
from catch_arena.report.watch import LiveReport, serve
from catch_arena.tournament.secret import Secret


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(watch, "_PAUSE_S", 0.0)
    monkeypatch.setattr(watch, "_PAUSE_FACTOR", 0.0)


def fetched(address):
    with urllib.request.urlopen(address, timeout=30) as answer:  # noqa: S310 - ours
        return answer.read().decode()


def refused(address):
    with pytest.raises(urllib.error.HTTPError) as caught:
        fetched(address)
    with caught.value as answer:
        return answer.code, answer.read().decode()


def test_the_page_follows_the_tournament(tmp_path):
    tournament(tmp_path, 1, most=0)
    with serve(LiveReport(tmp_path)) as address:
        assert "No match has been played yet" in fetched(address)
        tournament(tmp_path, 1, most=8)
        assert fetched(f"{address}state") == "8"
        assert "8 <small>of 60</small>" in fetched(address)
        tournament(tmp_path, 1)
        assert fetched(f"{address}state") == "60 ended"
        assert "data-watched" in fetched(address)


def test_the_seed_is_served_when_play_has_ended_and_not_before(tmp_path):
    digits = Secret.of(1).digits
    with serve(LiveReport(tmp_path)) as address:
        tournament(tmp_path, 1, most=60, planned=120)  # --until-separated stands like this between two looks
        assert digits not in fetched(address)
        assert "shown when the tournament has ended" in fetched(address)
        tournament(tmp_path, 1)
        assert f"<code>{digits}</code>" in fetched(address)


def test_any_recorded_match_can_be_fetched_and_nothing_else(played):
    with serve(LiveReport(played)) as address:
        data = ReportData.of(played)
        match = min(data.recorded)
        fetched(address)
        assert fetched(f"{address}bundles/{match}") == bundle_text(data.replay(match))
        assert refused(f"{address}bundles/..%2F..%2Fsecret")[0] == 404
        assert refused(f"{address}tournament.sqlite") == (404, "there is no page at this address")


def test_only_this_machine_is_answered_under_its_own_name(tmp_path):
    tournament(tmp_path, 1, most=4)
    with serve(LiveReport(tmp_path)) as address:
        port = urlsplit(address).port
        connection = HTTPConnection("127.0.0.1", port, timeout=30)
        connection.request("GET", "/", headers={"Host": f"evil.example:{port}"})
        assert connection.getresponse().status == 403
        connection.close()
        others = {one[4][0] for one in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)} - {"127.0.0.1"}
        for host in (*others, "127.0.0.2"):
            with pytest.raises(OSError, match=r"refused|unreachable|timed out"):
                socket.create_connection((host, port), timeout=5).close()


def test_a_reader_that_says_nothing_keeps_nobody_waiting(tmp_path):
    tournament(tmp_path, 1, most=4)
    with serve(LiveReport(tmp_path)) as address, socket.create_connection(("127.0.0.1", urlsplit(address).port)):
        assert fetched(f"{address}state") == "4"


def test_two_reports_are_served_at_two_addresses(tmp_path):
    tournament(tmp_path, 1, most=4)
    with serve(LiveReport(tmp_path)) as one, serve(LiveReport(tmp_path)) as other:
        assert one != other
        assert fetched(f"{one}state") == fetched(f"{other}state") == "4"

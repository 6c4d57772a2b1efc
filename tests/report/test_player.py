"""The HTML of a replay loads nothing from elsewhere, and names in it are never markup."""

import re

import pytest
from render.matches import played

from catch_arena.player import player_html, player_page
from catch_arena.player.element import script_json


@pytest.fixture(scope="module")
def replay():
    names = ["</script><script>alert(1)</script>", "<img src=x onerror=alert(2)>"]
    return played("duel", names=names, title="<h1>title</h1>", time_limit_s=1.0)


@pytest.fixture(scope="module")
def html(replay):
    return player_html(replay)


def test_names_and_titles_never_stand_in_the_markup(html):
    for word in ("alert", "onerror", "<h1>"):
        assert word not in html
    assert html.count("<script>") == html.count("</script>") == 1


def test_it_asks_nothing_of_any_other_place(html):
    assert not re.search(r"https?:|//[a-z]+\.|@import|url\(|src=|href=", html)


def test_a_page_shows_its_title_as_text_and_lets_only_its_own_script_run(replay, html):
    page = player_page(replay)
    assert html in page
    assert page.count("&lt;h1&gt;title&lt;/h1&gt;") == 2
    assert "alert" not in page
    assert re.search(r"default-src &#39;none&#39;; script-src &#39;sha256-[^;]+&#39;;", page)
    assert page.count("<script>") == 1


def test_json_in_a_script_cannot_end_the_script():
    assert script_json(["</script>", "<!--"]) == '["\\u003c/script>","\\u003c!--"]'

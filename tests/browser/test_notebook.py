"""A replay plays in a notebook cell, and an env shows a picture."""

import pytest

import catch_arena


@pytest.fixture(scope="module")
def env():
    env = catch_arena.parallel_env("duel", time_limit_s=3.0)
    env.record(("ann", "bob"), "A lesson")
    _, infos = env.reset(seed=3)
    while env.agents:
        _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
    return env


def opened(page, serve, tmp_path, *outputs: str) -> None:
    (tmp_path / "index.html").write_text("".join(f"<div>{output}</div>" for output in outputs), encoding="utf-8")
    page.goto(f"{serve(tmp_path)}/index.html")


def test_a_replay_plays_in_a_cell_and_so_does_an_env_that_recorded_it(page, serve, tmp_path, env):
    opened(page, serve, tmp_path, env.replay()._repr_html_(), env._repr_html_())
    assert page.locator("catch-replay").count() == 2
    canvas = page.locator("catch-replay").first.locator("canvas").first
    canvas.wait_for()
    before = canvas.screenshot()
    page.locator("catch-replay").first.locator("button").first.click()
    page.wait_for_timeout(700)
    assert canvas.screenshot() != before


def test_an_env_that_records_nothing_shows_its_present(page, serve, tmp_path):
    env = catch_arena.env("duel")
    env.reset(seed=1)
    opened(page, serve, tmp_path, env._repr_html_())
    page.wait_for_function("document.querySelector('img').complete")
    assert page.eval_on_selector("img", "img => [img.naturalWidth, img.naturalHeight]") == [800, 450]

"""Replays as parts of web pages: a canvas plays a replay and loads nothing from elsewhere.

- bundle: the data of a replay that a page plays. element: the HTML element `<catch-replay>`, as one script.
- moments: a moment of a match on a page. page_template: templates of pages with that element, and their policy.
- page/: the JavaScript.
"""

from catch_arena.player.element import player_html, player_page
from catch_arena.replay import Replay

__all__ = ["player_html", "player_page"]

Replay.html_formatter = player_html

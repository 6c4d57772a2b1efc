"""Replays as parts of web pages: a canvas plays a replay and loads nothing from elsewhere.

- bundle: the data of a replay that a page plays. element: the HTML element `<catch-replay>`, as one script.
- page_template: templates of pages with that element, and their policy.
- page/: the JavaScript.
"""

from catch_arena.player.bundle import bundle_text, css, packed_text
from catch_arena.player.element import element_script, moment_scripts, player_html, player_page, script_json
from catch_arena.player.page_template import page_file
from catch_arena.replay import Replay

__all__ = [
    "Replay",
    "bundle_text",
    "css",
    "element_script",
    "moment_scripts",
    "packed_text",
    "page_file",
    "player_html",
    "player_page",
    "script_json",
]

Replay.html_formatter = player_html

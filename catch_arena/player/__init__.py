"""A replay as a piece of a web page: a canvas that plays it, with nothing to load from anywhere."""

from catch_arena.player.element import element_script, page_file, player_html, script_json
from catch_arena.player.film import film_text, packed_text

__all__ = ["element_script", "film_text", "packed_text", "page_file", "player_html", "script_json"]

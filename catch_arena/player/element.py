"""Element `<catch-replay>`, which plays a replay bundle, as one script; a page may hold any number of them."""

import json
import re
from functools import cache
from typing import Any, Final

from catch_arena.explanation import highlights
from catch_arena.explanation.what_if import WhatIf
from catch_arena.player.bundle import bundle_text, css
from catch_arena.player.page_template import page_file, page_policy, page_style, page_template
from catch_arena.render import annotations, cards, hud, lens, scene, shapes, viewport
from catch_arena.replay import Replay

_SCRIPTS: Final = ("replay.js", "shapes.js", "overlays.js", "arena.js", "player.js")
_MODULE: Final = re.compile(r"^(import [^;]*;\n|export )", re.MULTILINE)
"""Pattern of the statements that make a file a module, as checkers and tests need; in a page all are one script."""


def player_html(replay: Replay, what_if: WhatIf | None = None) -> str:
    """Return HTML that plays a replay, for a page or a notebook's output; several may stand on one page.

    Args:
        replay: the recorded match.
        what_if: answer to a lost contest; the page begins at this contest, and shows the answer.

    Raises:
        ConfigError: for an answer about another match.
        ReplayError: if the match does not play as recorded.
    """
    bundle = bundle_text(replay, () if what_if is None else (what_if,))
    shown = ""
    if what_if is not None:
        shown = f' what-if start="{max(0, what_if.contest.judged_ms - highlights.BEFORE_MS)}"'
    return f'{element_script()}<catch-replay bundle="{bundle}"{shown}>Allow scripts to see this replay.</catch-replay>'


def player_page(replay: Replay, what_if: WhatIf | None = None) -> str:
    """Return a page that plays a replay, as one file that loads nothing.

    It takes the arguments and raises the errors of `player_html`.
    """
    return page_template("catch_arena.player", "replay.html", {}).render(
        title=replay.title or "Match",
        what_if=what_if,
        policy=page_policy(element_script()),
        style=page_style("catch_arena.player", "replay.css"),
        player=player_html(replay, what_if),
    )


@cache
def element_script() -> str:
    """Return the script that a page needs once; more than once does no harm."""
    parts = "\n".join(_MODULE.sub("", page_file("catch_arena.player", name)) for name in _SCRIPTS)
    return (
        '<script>if (!customElements.get("catch-replay")) {\n'
        f'(() => {{"use strict";\n{parts}\n'
        f"CatchReplay.look = {script_json(player_look())};\n"
        f"CatchReplay.style = {script_json(page_file('catch_arena.player', 'player.css'))};\n"
        'customElements.define("catch-replay", CatchReplay);\n})();\n}</script>'
    )


def script_json(value: object) -> str:
    """Return JSON that may stand inside a script: nothing in it ends the script."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")


def player_look() -> dict[str, Any]:
    """Return the colours, shapes and sizes of render/ for the player."""
    return {
        "ground": css(viewport.GROUND),
        "outside": css(viewport.OUTSIDE),
        "grid": css(scene.GRID),
        "wall": css(scene.WALL),
        "target": css(viewport.TARGET),
        "targetTrail": css(viewport.TARGET_TRAIL),
        "ink": css(shapes.INK),
        "panel": css(hud.PANEL),
        "bright": css(hud.BRIGHT),
        "gold": css(cards.GOLD),
        "gridSteps": scene.GRID_STEPS_M,
        "gridGap": scene.GRID_GAP,
        "hunterLength": viewport.HUNTER_LENGTH_M,
        "targetLength": viewport.TARGET_LENGTH_M,
        "preyLength": viewport.PREY_LENGTH_M,
        "preyPieces": scene.PREY_PIECES,
        "margin": viewport.MARGIN,
        "lens": lens.SIZE,
        "caption": hud.CAPTION,
        "captionMs": lens.LENS_MS,
        "answerMs": [highlights.BEFORE_MS, highlights.AFTER_MS],
        "leastArena": lens.LEAST_ARENA,
        "lensGrowsMs": lens.GROWS_MS,
        "mostNames": annotations.MOST_NAMES,
        "leastNamed": annotations.LEAST_NAMED,
        "longestName": annotations.LONGEST_NAME,
        "podiumHeights": cards.HEIGHTS,
        "podiumPlaces": cards.PLACES,
        "dimmed": cards.DIMMED,
        # every second point of an outline is enough for a canvas
        "turtle": [[own, white, points[::2].round(3).tolist()] for points, own, white in shapes.TURTLE_PARTS],
    }

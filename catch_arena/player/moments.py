"""Moment of a match as pages play it: page/moment.html shows it, and page/moment.js plays it."""

from itertools import islice

import msgspec

from catch_arena.player.bundle import encode_bundle, packed_text
from catch_arena.player.element import element_script
from catch_arena.player.page_template import page_file, page_policy
from catch_arena.render.captions import Caption
from catch_arena.render.match_info import MatchInfo
from catch_arena.replay import Replay


class Moment(msgspec.Struct, frozen=True):
    """Moment of a match that the page plays."""

    title: str
    """Test and match."""
    text: str
    at_ms: int
    """Time of the moment, from the reset [ms]."""
    seat: int | None
    """The agent's seat; None for prey, which the player cannot select."""
    stopped: bool
    """True if the agent failed in that moment."""
    bundle: str
    """Replay bundle of the match, without its seed."""


def moment_of(replay: Replay, seat: int, at_ms: int, text: str, failed: str = "") -> Moment:
    """Return a moment of a match, whose bundle has no seed.

    Args:
        replay: the match.
        seat: the agent's seat; prey come after the hunters.
        at_ms: time of the moment [ms since reset].
        text: text about the moment.
        failed: caption for the picture if the agent failed.
    """
    hunter = seat if seat < replay.config.hunters else None
    notes = []
    if failed and hunter is not None:
        world = next(islice(replay.worlds(), at_ms // replay.config.control_period_ms, None))
        low = world.hunters[hunter].y < replay.config.side_m / 2  # the caption must not cover the hunter
        notes.append(Caption(at_ms, hunter, f"{MatchInfo.of_replay(replay).label(hunter)} {failed}", "", at_top=low))
    bundle = packed_text(encode_bundle(replay, notes=notes, hides_seed=True))
    return Moment(replay.title, text, at_ms, hunter, bool(failed), bundle)


def moment_scripts(*, plays: bool) -> dict[str, str]:
    """Return the variables `policy`, `element` and `script` of a page that plays moments (page/moment.html), if any."""
    element, script = element_script() if plays else "", page_file("catch_arena.player", "moment.js")
    return {"policy": page_policy(element, script), "element": element, "script": script}

"""A ruling of the arbiter as a message, for a bus and for bags."""

from collections.abc import Sequence
from typing import Final

from catch_arena.ros.middleware.interfaces import RulingMessage
from catch_arena.verdicts import CLAUSES, Ruling

_LONGEST_TOLD: Final = 255


def ruling_message(ruling: Ruling, time_ms: int, hunters: Sequence[str]) -> RulingMessage:
    """Return the message of one ruling.

    Args:
        ruling: the ruling.
        time_ms: beginning of the step in which it was judged [ms].
        hunters: their names, by seat.
    """
    return RulingMessage(
        time=time_ms / 1000.0,
        step=ruling.step,
        hunter=hunters[ruling.hunter],
        target="" if ruling.target is None else str(ruling.target)[:_LONGEST_TOLD],
        verdict=ruling.verdict.name,
        success=ruling.success,
        distance=-1.0 if ruling.distance_um is None else ruling.distance_um / 1e6,
        winner="" if ruling.winner is None else hunters[ruling.winner],
        clause=CLAUSES[ruling.verdict],
        reason=ruling.reason,
    )

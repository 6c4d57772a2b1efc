"""The map of the arena memory: no two things share a row, and the digest reads what A.8 lists."""

from catch_arena.core import state
from catch_arena.core.state import LANES
from catch_arena.layout import RIVAL_COLUMNS, SELF_COLUMNS, TARGET_COLUMNS, columns, state_columns, width
from catch_arena.scenarios import SCENARIOS
from catch_arena.verdicts import Verdict

ARENA = [
    "TIME",
    "STEP",
    "SPAWNED",
    "NUMBERS",
    "FIRINGS",
    "SKIPPED_FULL",
    "SKIPPED_DOWN",
    "SPAWNS_REFUSED",
    "ALIVE",
    "ENDED",
    "SEED_HIGH",
    "SEED_LOW",
]
HUNTER = [
    "X",
    "Y",
    "THETA",
    "SPEED",
    "TURN_RATE",
    "DISTANCE_INTEGRAL",
    "BEARING_INTEGRAL",
    "ACTIVE",
    "SCORE",
    "AT_WALL",
    "WITHDRAWN",
    "SINE",
    "COSINE",
    "SEEN",
    "REQUESTED_SLOT",
    "REQUESTED_NUMBER",
    "VERDICT",
    "DISTANCE_UM",
    "WINNER",
    "RETURN",
    "CONTESTS_WON",
]


def test_every_row_has_one_owner():
    """Rows are numbered without gap or overlap, and the digest's come first, in A.8's order."""
    assert [getattr(state, name) // LANES for name in ARENA] == list(range(state.ARENA_ROWS))
    assert [getattr(state, name) // LANES for name in HUNTER] == list(range(state.TALLIES // LANES))
    assert state.TALLIES // LANES + len(Verdict) == state.HUNTER_ROWS
    assert ARENA[state.ARENA_DIGEST_ROWS] == "ALIVE"
    assert HUNTER[state.HUNTER_DIGEST_ROWS] == "SINE"


def test_the_layout_has_as_many_columns_as_the_writer_writes():
    """In every scenario; names are unique, and every bound is an interval."""
    for config in SCENARIOS.values():
        table = columns(config)
        seen = len(SELF_COLUMNS) + len(TARGET_COLUMNS) * config.targets_seen + len(RIVAL_COLUMNS) * config.hunters_seen
        assert len(table) == width(config) == seen
        for columns_of in (table, state_columns(config)):
            assert len({column.name for column in columns_of}) == len(columns_of)
            assert all(column.low < column.high for column in columns_of)

"""An engine's memory is laid out with the types that compiled code reads, and its copies share nothing."""

import pytest

from catch_arena.config import ArenaConfig
from catch_arena.core.memory import CACHE_LINE, DTYPES, copy_of, lay_out, sections_of
from catch_arena.core.state import MOST, PART_NAMES
from catch_arena.core.vectors import LANES
from catch_arena.engine.core_settings import settings_of, sizes_of


def some_sizes(arenas=3):
    """Sizes of a small engine that has everything."""
    config = ArenaConfig(hunters=5, prey=2, initial_targets=2, teams=((0, 1), (2, 3, 4)))
    return sizes_of(config, settings_of(config), arenas, 7, with_infos=True, auto_reset=True)


def test_every_section_is_a_view_of_the_memory_with_its_own_type_and_shape():
    memory, sections = lay_out(some_sizes())
    expected = {"keys": ("i4", (MOST * LANES,)), "parts": ("f8", (3, 5, len(PART_NAMES))), "rewards": ("f8", (3, 7))}
    expected |= {"requested_slots": ("f8", (5, LANES)), "masks": ("i1", (3, 5, 9)), "lengths": ("f4", (3,))}
    for name, (dtype, shape) in expected.items():
        section = getattr(sections, name)
        assert (section.dtype, section.shape) == (dtype, shape)
    for number, name in enumerate(DTYPES):
        section = getattr(sections, name)
        assert not section.any()
        section[:] = number  # a section that overlapped would change another one
    again = sections_of(memory)
    assert all((getattr(again, name) == number).all() for number, name in enumerate(DTYPES))


@pytest.mark.parametrize("rows", [1, 1 << 12])
def test_a_copy_shares_no_memory_whatever_its_size(rows):
    """Large pieces have pages of their own, which nothing else may write to, a child process included."""
    memory, sections = lay_out(some_sizes(rows))
    copied = copy_of(memory)
    assert copied.tobytes() == memory.tobytes()
    assert copied.ctypes.data % CACHE_LINE == 0
    sections.rewards[-1, -1] = 5.0
    assert not sections_of(copied).rewards.any()
    assert memory.flags.writeable
    assert copied.flags.writeable

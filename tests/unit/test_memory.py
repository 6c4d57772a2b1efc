"""An engine's memory is laid out only with the types that compiled code reads, and its copies share nothing."""

import numpy as np
import pytest

from catch_arena.core.memory import (
    CACHE_LINE,
    DTYPES,
    NDIMS,
    Sections,
    copy_of,
    lay_out,
    sections_of,
    zeros,
)


def some_sections() -> Sections:
    """Each of another size, with other numbers."""
    made = {}
    for place, ((name, dtype), ndim) in enumerate(zip(DTYPES.items(), NDIMS, strict=True)):
        shape = (2 + place % 4, 3, 5)[:ndim]
        made[name] = (np.arange(np.prod(shape)) + place).astype(dtype).reshape(shape)
    return Sections(**made)


def test_a_section_of_another_type_is_refused():
    """The directory holds shapes, not types."""
    wanted = some_sections()
    with pytest.raises(TypeError, match="masks must be of int8 and 3 dimensions, got int64 and 3 dimensions"):
        lay_out(wanted._replace(masks=zeros(1, 2, 3, dtype=np.int64)))
    with pytest.raises(TypeError, match="ends must be of int8 and 1 dimensions, got int8 and 2 dimensions"):
        lay_out(wanted._replace(ends=zeros(1, 2, dtype=np.int8)))


@pytest.mark.parametrize("rows", [1, 1 << 18])
def test_a_copy_shares_no_memory_whatever_its_size(rows):
    """Large pieces have pages of their own, which nothing else may write to, a child process included."""
    memory, sections = lay_out(some_sections()._replace(rewards=zeros(rows, 3)))
    copied = copy_of(memory)
    assert copied.tobytes() == memory.tobytes()
    assert copied.ctypes.data % CACHE_LINE == 0
    sections.rewards[-1, -1] = 5.0
    assert not sections_of(copied).rewards.any()
    assert memory.flags.writeable
    assert copied.flags.writeable

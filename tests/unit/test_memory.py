"""An engine's memory is laid out with the types that compiled code reads, and its copies share nothing."""

import pytest

from catch_arena.core.memory import CACHE_LINE, DTYPES, NDIMS, copy_of, lay_out, sections_of


def some_shapes() -> dict[str, tuple[int, ...]]:
    """Each of another size."""
    return {name: (2 + place % 4, 3, 5)[:ndim] for place, (name, ndim) in enumerate(zip(DTYPES, NDIMS, strict=True))}


def test_every_section_is_a_view_of_the_memory_with_its_own_type_and_shape():
    shapes = some_shapes()
    memory, sections = lay_out(shapes)
    for number, (name, dtype) in enumerate(DTYPES.items()):
        section = getattr(sections, name)
        assert (section.dtype, section.shape) == (dtype, shapes[name][-section.ndim :])  # without the threads
        assert not section.any()
        section[:] = number  # a section that overlapped would change another one
    again = sections_of(memory)
    assert all((getattr(again, name) == number).all() for number, name in enumerate(DTYPES))


@pytest.mark.parametrize("rows", [1, 1 << 18])
def test_a_copy_shares_no_memory_whatever_its_size(rows):
    """Large pieces have pages of their own, which nothing else may write to, a child process included."""
    memory, sections = lay_out(some_shapes() | {"rewards": (rows, 3)})
    copied = copy_of(memory)
    assert copied.tobytes() == memory.tobytes()
    assert copied.ctypes.data % CACHE_LINE == 0
    sections.rewards[-1, -1] = 5.0
    assert not sections_of(copied).rewards.any()
    assert memory.flags.writeable
    assert copied.flags.writeable

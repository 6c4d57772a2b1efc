"""An engine's memory: what Python lays out and what compiled code finds there are the same arrays."""

import itertools

import numpy as np
import pytest

from catch_arena.core.addresses import by_address
from catch_arena.core.jit import unkept_entry
from catch_arena.core.memory import (
    CACHE_LINE,
    DTYPES,
    NDIMS,
    Sections,
    copy_of,
    lay_out,
    sections_of,
    settings_in,
    zeros,
)
from catch_arena.core.state import ALL_OPTIONS, NO_OPTIONS, PlainSettings, Settings


def some_sections() -> Sections:
    """Each of another size, with other numbers."""
    made = {}
    for place, ((name, dtype), ndim) in enumerate(zip(DTYPES.items(), NDIMS, strict=True)):
        shape = (2 + place % 4, 3, 5)[:ndim]
        made[name] = (np.arange(np.prod(shape)) + place).astype(dtype).reshape(shape)
    return Sections(**made)


def test_sections_lie_where_the_directory_says():
    """Each from a cache line on, none over another, and all of their own values."""
    wanted = some_sections()
    memory, sections = lay_out(wanted)

    for name, section, stored in zip(Sections._fields, sections, wanted, strict=True):
        array = stored[0] if section.ndim < stored.ndim else stored  # of scratch the first thread's
        assert section.tobytes() == array.tobytes(), name
        assert section.shape == array.shape, name
        assert section.ctypes.data % CACHE_LINE == 0, name
    places = sorted((section.ctypes.data, section.nbytes) for section in sections)
    assert all(begin + size <= after for (begin, size), (after, _) in itertools.pairwise(places))
    assert memory.ctypes.data <= places[0][0]
    assert places[-1][0] + places[-1][1] <= memory.ctypes.data + memory.nbytes


@pytest.mark.parametrize("thread", [0, 1])
def test_compiled_code_finds_the_same_sections(thread):
    """Compiled code reads the last number of each, and writes the first; each thread has its own scratch."""
    wanted = some_sections()._replace(requests=np.arange(30).reshape(2, 3, 5))
    memory, _ = lay_out(wanted)

    @unkept_entry
    def look(memory, thread, shapes):
        found = sections_of(memory, thread)
        shapes[0, 0], shapes[0, 1] = found.requests.shape
        shapes[1, 0], shapes[1, 1] = found.chunks.shape
        (seats, numbers), (rows, columns) = found.requests.shape, found.rewards.shape
        total = found.requests[seats - 1, numbers - 1] + found.chunks[shapes[1, 0] - 1, shapes[1, 1] - 1]
        total += found.masks[len(found.masks) - 1, 2, 4] + found.rewards[rows - 1, columns - 1]
        found.requests[0, 0] = 55
        found.rewards[0, 1] = 77.0
        found.masks[0, 2, 1] = 7
        return total

    shapes = np.zeros((2, 2), dtype=np.int64)
    total = look(memory, thread, shapes)

    of_thread = wanted.requests[thread]
    assert total == of_thread[-1, -1] + sum(
        float(getattr(wanted, name).flat[-1]) for name in ("chunks", "masks", "rewards")
    )
    assert shapes.tolist() == [list(of_thread.shape), list(wanted.chunks.shape)]
    sections = sections_of(memory, thread)
    assert sections.rewards[0, 1] == 77.0
    assert sections.masks[0, 2, 1] == 7
    assert sections.requests[0, 0] == 55
    assert sections_of(memory, 1 - thread).requests[0, 0] == wanted.requests[1 - thread, 0, 0]


@pytest.mark.parametrize("options", [NO_OPTIONS, ALL_OPTIONS])
def test_settings_come_back_as_they_were_whatever_their_order(options):
    """Whole numbers as whole numbers, compiled and interpreted; what is left out without options was 0."""
    plain = options == NO_OPTIONS
    numbers = np.arange(len(Settings._fields)) + 0.5
    if plain:
        numbers[[Settings._fields.index(name) for name in PlainSettings.ZERO]] = 0.0
    source = "\n".join(f"    found[{place}] = s.{name}" for place, name in enumerate(Settings._fields))
    made = {"settings_in": settings_in, "by_address": by_address}
    whole = f"def read(given, options, found):\n    s = settings_in(by_address(given), options)\n{source}\n"
    exec(whole, made)  # noqa: S102 - compiled code asks for a setting by its name, written out
    found = np.full(len(numbers), -1.0)
    unkept_entry(made["read"])(numbers, options, found)

    settings = settings_in(numbers, options)
    assert isinstance(settings, Settings)
    assert found.tolist() == list(settings)
    for kind, number, setting in zip(Settings.__annotations__.values(), numbers, settings, strict=True):
        assert type(setting) is kind
        assert setting == kind(number)


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

"""An engine's memory: one piece of bytes, which compiled code gets by one address. An array for each of its sections
would cost a microsecond a call to hand over.

It begins with its directory: for each field of `Sections` where the section begins and its shape.
`Settings` are a section, and have no numbering either: names, order and types stand in these two classes alone.
Each thread has scratch sections of its own; nothing in them outlives a step.
"""

import contextlib
import itertools
import mmap
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from llvmlite import ir
from numba import from_dtype, types
from numba.extending import models, register_model
from numpy.typing import NDArray

from catch_arena.core.addresses import ArrayAt, product
from catch_arena.core.arbiter import REQUEST_COLUMNS
from catch_arena.core.extending import INT64, compiled_as, constant_at, fields_as, packed, unpacked
from catch_arena.core.state import (
    LANES,
    MOST,
    PART_NAMES,
    RANKS_PER_WORD,
    WITHDRAWN,
    Options,
    PlainSettings,
    Settings,
)
from catch_arena.core.transfers import STREAMED, TILE
from catch_arena.core.vectors import WIDE

Bytes = NDArray[np.uint8]

CACHE_LINE: Final = 64
"""[bytes] Each section begins where a cache line begins. Else many SIMD accesses would need two lines."""
_HUGE_PAGE: Final = 1 << 21
"""[bytes]"""


class Section(NamedTuple):
    """Element type and number of dimensions of a section's array."""

    dtype: type[np.generic]
    ndim: int
    by_thread: bool = False
    """Whether the first dimension is that of the threads, each of which sees its own part alone."""


# What a section holds stands beside its type, since NumPy's own annotations are for type checkers only.
Floats1 = Annotated[NDArray[np.float32], Section(np.float32, 1)]
Floats2 = Annotated[NDArray[np.float32], Section(np.float32, 2)]
Floats3 = Annotated[NDArray[np.float32], Section(np.float32, 3)]
ScratchFloats1 = Annotated[NDArray[np.float32], Section(np.float32, 2, by_thread=True)]
Doubles1 = Annotated[NDArray[np.float64], Section(np.float64, 1)]
Doubles2 = Annotated[NDArray[np.float64], Section(np.float64, 2)]
Doubles3 = Annotated[NDArray[np.float64], Section(np.float64, 3)]
ScratchDoubles1 = Annotated[NDArray[np.float64], Section(np.float64, 2, by_thread=True)]
ScratchDoubles2 = Annotated[NDArray[np.float64], Section(np.float64, 3, by_thread=True)]
ScratchKeys1 = Annotated[NDArray[np.int32], Section(np.int32, 2, by_thread=True)]
Integers1 = Annotated[NDArray[np.int64], Section(np.int64, 1)]
ScratchIntegers2 = Annotated[NDArray[np.int64], Section(np.int64, 3, by_thread=True)]
Flags1 = Annotated[NDArray[np.int8], Section(np.int8, 1)]
Flags2 = Annotated[NDArray[np.int8], Section(np.int8, 2)]
Flags3 = Annotated[NDArray[np.int8], Section(np.int8, 3)]


class Sections(NamedTuple):
    """B arenas in blocks; N agents, H hunters and then P prey; K targets seen.

    Each field's type names its elements and the number of dimensions. What a scenario or a batch does not need has no
    numbers. The order matters where a line says so: sections are saved and copied together with their neighbours.
    """

    # ---- tables and scratch: not saved ----

    settings: Doubles1
    """`Settings`, in the order of its fields."""
    start_poses: Doubles2
    """(H, 3), or (0, 3) for the fair circle (R2.6)."""
    controls: Flags2
    """R4.1, R4.4: control of each hunter, a number of `controllers.CONTROLS`: (B, H). A caller that changes it has to
    pass matching `choices` and `commands`.
    """
    limits: Doubles2
    """(H, 5): `SeatLimits`, in the order of its fields."""
    teams: Integers1
    """(H,): the lowest seat of each seat's team, which stands for that (R11.1)."""
    team_seats: Integers1
    """(teams,): and those seats, in the order of the teams; none where there are no teams."""
    keys: ScratchKeys1
    """Sorting keys, by slot or seat: rows of LANES."""
    positions: ScratchDoubles1
    """Where the hunters are, in one group of lanes: see `ranking.note_positions`."""
    target_tiles: ScratchDoubles1
    """What is known of the targets in one group of lanes, by slot and lane: see `tiles.tile_index`."""
    body_tiles: ScratchDoubles1
    """The same of the hunters, or of all prey."""
    staging: ScratchFloats1
    """The observations of one group of lanes, as they lie in memory."""
    requests: ScratchIntegers2
    """The open requests of one lane: see `arbiter`."""
    scratch_rows: ScratchDoubles1
    """A few rows of LANES for whatever a phase counts."""
    requested_slots: ScratchDoubles2
    """(H, LANES): what each seat asks for in this step: a slot, NO_TARGET or MALFORMED_REQUEST."""
    rival_orders: ScratchDoubles2
    """R7.1, by seat: the rivals, nearest first, as `state.slot_at_rank` reads them."""
    progress_references: ScratchDoubles2
    """R6.2's progress, by seat, three rows: where the target is that was nearest after the commit, x and y [m], and how
    far it was [m], -1 for none.
    """
    team_rows: ScratchDoubles1
    """R11.2, of as many as there are hunters, or none: the catches of each team, by the seat that stands for it; and
    then what each seat has earned by itself.
    """
    prey_references: ScratchDoubles2
    """R12.5's gain, by index, four rows: see `prey.IN_PLAY` and those that follow."""
    gathered_prey: ScratchDoubles2
    """R12.4, by index: the body of one prey, with the rows of a seat up to WITHDRAWN, which is 1 while it is out."""
    snapshot: ScratchDoubles1
    """The block as it was, if some of its arenas have ended."""
    # ---- saved, from here to the end; all but the blocks have a row for each arena ----
    blocks: Doubles2
    """(blocks, rows * LANES): see `state`."""
    rewards: Doubles2
    """R6.2, R12.5: (B, N)."""
    parts: Doubles3
    """R6.2: (B, H, parts), in the order of `state.PART_NAMES`; or none."""
    prey_parts: Doubles3
    """R12.5: (B, P, parts), in the order of `state.PREY_PART_NAMES`; or none."""
    observations: Floats3
    """R7.1, R12.4: (B, N, columns); those of the side that sees less are followed by zeros."""
    masks: Flags3
    """R7.2: (B, H, K + 1)."""
    ends: Flags1
    """R1.5: how the last step ended each episode: RUNNING, TERMINATED or TRUNCATED, (B,)."""
    active: Flags2
    """R1.7, R12.3: 1 for hunters that take part and prey that is in play, (B, N); or none where nobody drops out and
    there is no prey.
    """
    team_scores: Doubles2
    """R11.1: (B, teams)."""
    # ---- what only auto_reset keeps: last, since engines without it take a saved state up to here ----
    final_observations: Floats3
    """(B, N, columns): of the latest episode that ended; or none, and then arenas that have ended stand still."""
    final_masks: Flags3
    """(B, H, K + 1): the masks that belong to them."""
    lengths: Floats1
    """(B,): that episode's steps."""
    records: Floats3
    """(B, N, figures): that episode in figures, see FINAL_SCORE and what follows it in state.py."""


_KINDS_OF_SECTIONS: Final[dict[str, Section]] = {
    name: kind.__metadata__[0] for name, kind in Sections.__annotations__.items()
}
DTYPES: Final = {name: np.dtype(kind.dtype) for name, kind in _KINDS_OF_SECTIONS.items()}
NDIMS: Final = tuple(kind.ndim for kind in _KINDS_OF_SECTIONS.values())
_DIRECTORY: Final = sum(1 + ndim for ndim in NDIMS)
"""How many numbers of int64: where each section begins, and its shape."""


_INDICES: Final = dict(zip(DTYPES, itertools.accumulate((1 + ndim for ndim in NDIMS), initial=0), strict=False))
"""Where in the directory a section has its numbers."""


_ROWS: Final = 2 + len(PART_NAMES)
"""Rows that `rewards.reward_hunters` needs, which needs the most."""


def scratch_shapes(hunters: int, prey: int, rows: int, columns: int, *, team_play: bool) -> dict[str, tuple[int, ...]]:
    """Return the shapes of one thread's scratch sections.

    Args:
        hunters: H.
        prey: P.
        rows: number of rows of a block.
        columns: number of columns of an arena's observations, of all agents together.
        team_play: whether there are teams.
    """
    staging = len(WIDE) * columns + STREAMED  # with room for what is written too much
    return {
        "keys": (MOST * LANES,),
        "positions": (MOST * 2 * len(WIDE),),
        "target_tiles": ((MOST + 1) * len(WIDE) * TILE,),
        "body_tiles": ((MOST + 1) * len(WIDE) * TILE,),
        "staging": (-(-staging // LANES) * LANES,),  # whole cache lines: no two threads write to the same one
        "requests": (hunters, REQUEST_COLUMNS),
        "scratch_rows": (_ROWS * LANES,),
        "requested_slots": (hunters, LANES),
        "rival_orders": (hunters, MOST // RANKS_PER_WORD * LANES),
        "progress_references": (hunters, 3 * LANES),
        "team_rows": (2 * hunters * LANES if team_play else 0,),
        "prey_references": (prey, 4 * LANES),
        "gathered_prey": (prey, WITHDRAWN + LANES),
        "snapshot": (rows * LANES,),
    }


def zeros(*shape: int, dtype: Any = np.float64) -> NDArray[Any]:
    """For `lay_out`: a section that takes no memory yet."""
    return np.broadcast_to(np.zeros((), dtype=dtype), shape)


def lay_out(wanted: Sections) -> tuple[Bytes, Sections]:
    """The bytes with sections of these shapes and values, and the sections as they lie there.

    Raises:
        TypeError: for a section that is not of its field's type.
    """
    arrays: tuple[NDArray[Any], ...] = wanted
    for (name, dtype), ndim, array in zip(DTYPES.items(), NDIMS, arrays, strict=True):
        if array.dtype != dtype or array.ndim != ndim:
            raise TypeError(
                f"{name} must be of {dtype} and {ndim} dimensions, got {array.dtype} and {array.ndim} dimensions"
            )
    size = whole_lines(8 * _DIRECTORY)
    directory: list[int] = []
    for array in arrays:
        directory += [size, *array.shape]
        size += whole_lines(array.nbytes)
    memory = _new_bytes(size)
    memory[: 8 * _DIRECTORY].view(np.int64)[:] = directory
    for section, array in zip(_arrays_in(memory), arrays, strict=True):
        if any(array.strides):  # the others are zeros, as all is
            section[:] = array
    return memory, sections_of(memory)


def offset_of(section: str, memory: Bytes) -> int:
    """Where in the memory a section begins [bytes]."""
    return int(memory[: 8 * _DIRECTORY].view(np.int64)[_INDICES[section]])


def copy_of(memory: Bytes) -> Bytes:
    """A memory of its own that holds the same."""
    copied = _new_bytes(len(memory))
    copied[:] = memory
    return copied


def _new_bytes(size: int) -> Bytes:
    """Zeros, from a cache line on. Many have pages of their own, huge ones where the system has them: from NumPy they
    could be those that the process has used before, and a step in such memory takes a tenth longer.
    """
    if size >= _HUGE_PAGE and hasattr(mmap, "MADV_HUGEPAGE"):
        with contextlib.suppress(OSError, OverflowError):  # there is no room, which NumPy says better
            pages = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
            pages.madvise(mmap.MADV_HUGEPAGE)
            return np.frombuffer(pages, dtype=np.uint8)
    raw = np.zeros(size + CACHE_LINE, dtype=np.uint8)
    return raw[-raw.ctypes.data % CACHE_LINE :][:size]


def whole_lines(size: int) -> int:
    """What a section of that size takes [bytes]."""
    return -(-size // CACHE_LINE) * CACHE_LINE


def sections_of(memory: Bytes, thread: int = 0) -> Sections:
    """Return the sections of a memory, those of scratch as one thread sees them."""
    arrays = _arrays_in(memory)
    kinds = _KINDS_OF_SECTIONS.values()
    return Sections(*(array[thread] if kind.by_thread else array for array, kind in zip(arrays, kinds, strict=True)))


def _arrays_in(memory: Bytes) -> list[NDArray[Any]]:
    directory = iter(memory[: 8 * _DIRECTORY].view(np.int64).tolist())
    sections = []
    for dtype, ndim in zip(DTYPES.values(), NDIMS, strict=True):
        begin, *shape = (next(directory) for _ in range(1 + ndim))
        sections.append(np.ndarray(shape, dtype, memory, begin))  # three times as fast as a slice, a view and a shape
    return sections


def settings_in(numbers: NDArray[np.float64], options: Options) -> Settings:
    """The settings from their section; the options are for the compiler: see `state.Options`."""
    del options
    kinds = Settings.__annotations__.values()
    return Settings(*(kind(number) for kind, number in zip(kinds, numbers.tolist(), strict=True)))


# ---- for the compiler: settings and sections are where their memory is, and each is read where it is asked for ----

_NUMBERS: Final = ir.DoubleType().as_pointer()
_DIRECTORY_AT: Final = INT64.as_pointer()


class SettingsAt(types.Type):
    """`Settings`, or `PlainSettings`."""

    def __init__(self, fields: type[Settings]) -> None:
        known = PlainSettings.ZERO if fields is PlainSettings else ()
        self.zero = {name: Settings.__annotations__[name]() for name in known}
        """What is 0, or 0.0: see `compiler`."""
        super().__init__(fields.__name__)


class SectionsAt(types.Type):
    """`Sections`: the memory, and which thread looks."""


SECTIONS: Final = SectionsAt("Sections")


@register_model(SettingsAt)
class _SettingsModel(models.PrimitiveModel):
    def __init__(self, manager: Any, of: SettingsAt) -> None:
        super().__init__(manager, of, _NUMBERS)


@register_model(SectionsAt)
class _SectionsModel(models.StructModel):
    def __init__(self, manager: Any, of: SectionsAt) -> None:
        super().__init__(manager, of, (("memory", types.CPointer(types.uint8)), ("thread", types.int64)))


_KINDS: Final = {int: types.int64, float: types.float64}
for _name, _kind in Settings.__annotations__.items():
    if _kind not in _KINDS:
        raise TypeError(f"Settings.{_name} must be an int or a float, got {_kind}")


def _type_of_setting(_settings: Any, name: str) -> Any:
    return _KINDS[Settings.__annotations__[name]] if name in Settings._fields else None


@fields_as(SettingsAt, _type_of_setting)
def _(_context: Any, builder: Any, _of: Any, settings: Any, name: str) -> Any:
    number = constant_at(builder, builder.gep(settings, [INT64(Settings._fields.index(name))]))
    return builder.fptosi(number, INT64) if Settings.__annotations__[name] is int else number


def _type_of_settings(numbers: Any, options: Any) -> Any:
    return SettingsAt(Settings if len(options) else PlainSettings)(numbers, options)


@compiled_as(settings_in, _type_of_settings, 2)
def _(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return builder.extract_value(arguments[0], 0)


def _type_of_sections(memory: Any, _thread: Any) -> Any:
    return SECTIONS(memory, types.int64)


@compiled_as(sections_of, _type_of_sections, 2)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    memory, thread = arguments
    return packed(
        context, builder, SECTIONS, [context.make_array(signature.args[0])(context, builder, memory).data, thread]
    )


def _type_of_section(_sections: Any, name: str) -> Any:
    if name not in DTYPES:
        return None
    kind = _KINDS_OF_SECTIONS[name]
    return ArrayAt(from_dtype(DTYPES[name]), kind.ndim - kind.by_thread)


@fields_as(SectionsAt, _type_of_section)
def _(context: Any, builder: Any, of: Any, sections: Any, name: str) -> Any:
    memory, thread = unpacked(builder, sections)
    one, by_thread = _type_of_section(of, name), _KINDS_OF_SECTIONS[name].by_thread
    directory = builder.bitcast(memory, _DIRECTORY_AT)
    places = range(_INDICES[name], _INDICES[name] + 1 + one.ndim + by_thread)
    begin, *shape = (constant_at(builder, builder.gep(directory, [INT64(place)])) for place in places)
    if by_thread:
        shape = shape[1:]
        size = builder.mul(product(builder, shape), INT64(one.dtype.bitwidth // 8))
        begin = builder.add(begin, builder.mul(thread, size))
    numbers = context.get_value_type(types.CPointer(one.dtype))
    return packed(context, builder, one, [builder.bitcast(builder.gep(memory, [begin]), numbers), *shape])

"""Memory of an engine: one array of bytes, which compiled code gets by one address. Passing an array for each of its
sections would cost a microsecond a call.

It begins with a directory: for each field of `Sections` the offset of the section, and its shape. `Settings` are a
section, and have no numbering either: only these two classes define names, order, types and shapes. Each thread has
scratch sections of its own, whose content is not kept after a step.
"""

import contextlib
import math
import mmap
from collections.abc import Mapping
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_getattr_generic, models, register_model
from numpy.typing import NDArray

from catch_arena.core import rows, state
from catch_arena.core.addresses import ArrayAt, array_at, product
from catch_arena.core.arbiter import REQUEST_COLUMNS
from catch_arena.core.extending import INT64, compiled_as
from catch_arena.core.state import MOST, PART_NAMES, PREY_PART_NAMES, Options, PlainSettings, SeatLimits, Settings
from catch_arena.core.transfers import TILE
from catch_arena.core.vectors import LANES, WIDE

Bytes = NDArray[np.uint8]

CACHE_LINE: Final = 64
"""Alignment of the sections [bytes], a cache line. Without it, many SIMD accesses would need two lines."""
_HUGE_PAGE: Final = 1 << 21
"""Size of a huge page [bytes]."""


# A program cannot read the element type out of an array's type in NumPy 2.5, so it stands here twice.
Float32s = Annotated[NDArray[np.float32], np.float32]
Float64s = Annotated[NDArray[np.float64], np.float64]
Int8s = Annotated[NDArray[np.int8], np.int8]
Int32s = Annotated[NDArray[np.int32], np.int32]
Int64s = Annotated[NDArray[np.int64], np.int64]


class Sections(NamedTuple):
    """Sections of an engine's memory: B arenas in chunks; N agents, H hunters and then P prey; K targets seen.

    Each field's type gives its element type and its shape. In a shape, a name stands for a size that differs by engine:
    see `core_settings.sizes_of`. If it begins with "threads", each thread uses only its own part. A section that a
    scenario or a batch does not need is empty.

    The order matters where a line says so: adjacent sections are saved and copied together.
    """

    # ---- tables and scratch: not saved ----

    settings: Annotated[Float64s, len(Settings._fields)]
    """Values of `Settings`, in the order of its fields."""
    start_poses: Annotated[Float64s, "start_poses", 3]
    """Start poses of the hunters, x, y [m] and heading [rad]: (H, 3), or (0, 3) for the fair circle (R2.6)."""
    controls: Annotated[Int8s, "arenas", "hunters"]
    """R4.1, R4.4: control of each hunter, a number of `controllers.CONTROLS`: (B, H). A caller that changes it must
    pass matching `choices` and `commands`.
    """
    limits: Annotated[Float64s, "hunters", len(SeatLimits._fields)]
    """Limits of the hunters, `SeatLimits` in the order of its fields: (H, 4)."""
    teams: Annotated[Int64s, "hunters"]
    """R11.1: lowest seat of each seat's team, which stands for the team: (H,)."""
    team_seats: Annotated[Int64s, "teams"]
    """R11.1: lowest seat of each team, in the order of the teams: (teams,); empty without teams."""
    keys: Annotated[Int32s, "threads", MOST * LANES]
    """Sorting keys, by slot or seat: rows of LANES. `ranking.key_of` makes a key of a distance and that number."""
    target_tiles: Annotated[Float64s, "threads", (MOST + 1) * len(WIDE) * TILE]
    """Tiles of the targets in one group of lanes, by slot and lane: see features.py."""
    body_tiles: Annotated[Float64s, "threads", (MOST + 1) * len(WIDE) * TILE]
    """Tiles of the hunters, or of all prey, in one group of lanes, by index and lane: see features.py."""
    staging: Annotated[Float32s, "threads", "staging"]
    """Observations of one group of lanes, in the order of the memory."""
    requests: Annotated[Int64s, "threads", "hunters", REQUEST_COLUMNS]
    """Open requests of one lane: see `arbiter`."""
    scratch_rows: Annotated[Float64s, "threads", (2 + len(PART_NAMES)) * LANES]
    """Rows of LANES, for counts and other temporary numbers of a phase."""
    requested_slots: Annotated[Float64s, "threads", "hunters", LANES]
    """Request of each seat in this step: a slot, NO_TARGET or MALFORMED_REQUEST: (H, LANES)."""
    rival_orders: Annotated[Int8s, "threads", "hunters", "rival_ranks"]
    """R7.1: rivals of each seat, nearest first, a `state.Order` each: (H, ranks * LANES)."""
    references: Annotated[Float64s, "threads", "hunters", state.REFERENCE_ROWS * LANES]
    """R6.2: references of the hunters' rewards, by seat: see `state.NEAREST_X` and the constants after it."""
    team_rows: Annotated[Float64s, "threads", "team_rows"]
    """R11.2: two groups of rows, one row for each hunter; empty without teams. The first has the catches of each team,
    under the seat that stands for it; the second has the earnings of each seat before they are shared.
    """
    prey_references: Annotated[Float64s, "threads", "prey", state.PREY_REFERENCE_ROWS * LANES]
    """R12.5: references of prey's rewards, by index: see `state.IN_PLAY` and the constants after it."""
    gathered_prey: Annotated[Float64s, "threads", "prey", rows.WITHDRAWN + LANES]
    """R12.4: body of each prey, by index, with the rows of a seat up to WITHDRAWN, which is 1 while it is out."""
    snapshot: Annotated[Float64s, "threads", "chunk"]
    """Copy of the chunk before the step, if some of its arenas had ended."""
    # ---- saved, from here to the end; all but chunks and target_orders have a row for each arena ----
    chunks: Annotated[Float64s, "chunks", "chunk"]
    """Arena memory, (chunks, rows * LANES): see `rows`."""
    target_orders: Annotated[Int8s, "chunks", "hunters", "target_ranks"]
    """R7.1: targets of each seat, nearest first, a `state.Order` each: (chunks, H, K * LANES)."""
    rewards: Annotated[Float64s, "arenas", "agents"]
    """R6.2, R12.5: rewards of the last step, (B, N)."""
    parts: Annotated[Float64s, "arenas_with_parts", "hunters", len(PART_NAMES)]
    """R6.2: parts of the hunters' rewards, (B, H, parts), in the order of `state.PART_NAMES`; or empty."""
    prey_parts: Annotated[Float64s, "arenas_with_parts", "prey", len(PREY_PART_NAMES)]
    """R12.5: parts of prey's rewards, (B, P, parts), in the order of `state.PREY_PART_NAMES`; or empty."""
    observations: Annotated[Float32s, "arenas", "agents", "columns"]
    """R7.1, R12.4: observations, (B, N, columns); zeros fill those of the side that sees less."""
    masks: Annotated[Int8s, "arenas", "hunters", "choices"]
    """R7.2: masks of ranks, 0 or 1, (B, H, K + 1)."""
    ends: Annotated[Int8s, "arenas"]
    """R1.5: state of each episode after the last step: RUNNING, TERMINATED or TRUNCATED, (B,)."""
    active: Annotated[Int8s, "arenas_with_active", "agents"]
    """R1.7, R12.3: 1 for hunters that take part and prey that is in play, else 0, (B, N); empty if hunters cannot drop
    out and there is no prey.
    """
    team_scores: Annotated[Float64s, "arenas", "teams"]
    """R11.1: scores of the teams, (B, teams)."""
    # ---- kept by auto_reset only: last, since engines without it take a saved state up to here ----
    final_observations: Annotated[Float32s, "arenas_with_records", "agents", "columns"]
    """Last observations of each arena's latest ended episode, (B, N, columns); empty without auto_reset."""
    final_masks: Annotated[Int8s, "arenas_with_records", "hunters", "choices"]
    """Masks that belong to `final_observations`, (B, H, K + 1)."""
    lengths: Annotated[Float32s, "arenas_with_records"]
    """Length of that episode [steps], (B,)."""
    records: Annotated[Float32s, "arenas_with_records", "agents", "figures"]
    """Records of that episode, (B, N, figures): see `rows.FINAL_SCORE` and the constants after it."""


_METADATA: Final = {name: kind.__metadata__ for name, kind in Sections.__annotations__.items()}
DTYPES: Final = {name: np.dtype(element) for name, (element, *_) in _METADATA.items()}
_SHAPES: Final = {name: shape for name, (_, *shape) in _METADATA.items()}
_ENTRY: Final = 4
"""Number of int64 in the directory for each section: its offset and its shape, of at most three sizes."""


def lay_out(sizes: Mapping[str, int]) -> tuple[Bytes, Sections]:
    """Return zeros with all sections, and these as views; `sizes` are those that their shapes name."""
    directory = np.zeros((len(_SHAPES), _ENTRY), np.int64)
    size = whole_lines(directory.nbytes)
    for entry, (name, shape) in zip(directory, _SHAPES.items(), strict=True):
        numbers = [sizes[of] if isinstance(of, str) else of for of in shape]
        entry[: 1 + len(numbers)] = size, *numbers
        size += whole_lines(math.prod(numbers) * DTYPES[name].itemsize)
    memory = _new_bytes(size)
    memory[: directory.nbytes].view(np.int64)[:] = directory.reshape(-1)
    return memory, sections_of(memory)


def copy_of(memory: Bytes) -> Bytes:
    """Return an independent copy of a memory."""
    copied = _new_bytes(len(memory))
    copied[:] = memory
    return copied


def _new_bytes(size: int) -> Bytes:
    """Return zeros that begin at a cache line. Large sizes get new pages, huge ones if the system has them. NumPy could
    reuse pages of this process, and a step in such memory takes a tenth longer.
    """
    if size >= _HUGE_PAGE and hasattr(mmap, "MADV_HUGEPAGE"):
        with contextlib.suppress(OSError, OverflowError):  # if there is no room, NumPy gives the better error
            pages = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
            pages.madvise(mmap.MADV_HUGEPAGE)
            return np.frombuffer(pages, dtype=np.uint8)
    raw = np.zeros(size + CACHE_LINE, dtype=np.uint8)
    return raw[-raw.ctypes.data % CACHE_LINE :][:size]


def whole_lines(size: int) -> int:
    """Return the size of a section, rounded up to whole cache lines [bytes]."""
    return -(-size // CACHE_LINE) * CACHE_LINE


def sections_of(memory: Bytes, thread: int = 0) -> Sections:
    """Return the sections of a memory, with the scratch sections of one thread."""
    directory = memory[: 8 * _ENTRY * len(_SHAPES)].view(np.int64).reshape(-1, _ENTRY).tolist()
    sections = []
    for (begin, *numbers), dtype, shape in zip(directory, DTYPES.values(), _SHAPES.values(), strict=True):
        size = numbers[: len(shape)]
        array: NDArray[Any] = np.ndarray(size, dtype, memory, begin)  # three times as fast as a slice and a view
        sections.append(array[thread] if shape[0] == "threads" else array)
    return Sections(*sections)


def settings_in(numbers: NDArray[np.float64], options: Options) -> Settings:
    """Return the settings from their section; the options are for the compiler: see `state.Options`."""
    del options
    kinds = Settings.__annotations__.values()
    return Settings(*(kind(number) for kind, number in zip(kinds, numbers.tolist(), strict=True)))


# ---- for the compiler: settings and sections are addresses, and a field is read where code uses it ----


class _FieldsAt(types.NamedTuple):
    """Compiler type of a named tuple whose fields are in memory."""

    def __init__(self, kinds: list[Any], of: type[NamedTuple]) -> None:
        super().__init__(kinds, of)
        self.name = of.__name__  # short, since it is part of many symbols

    @property
    def key(self) -> str:
        """Name by which Numba compares types: the kinds of all fields would take long."""
        return self.name


class SettingsAt(_FieldsAt):
    """Compiler type of `Settings` or `PlainSettings`: the address of their numbers."""

    def __init__(self, of: type[Settings]) -> None:
        known = PlainSettings.ZERO if of is PlainSettings else ()
        self.zero = {name: Settings.__annotations__[name]() for name in known}
        """Fields that are 0 or 0.0, with that value: see `compiler`."""
        kinds = {int: types.int64, float: types.float64}
        super().__init__([kinds[kind] for kind in Settings.__annotations__.values()], of)


class SectionsAt(_FieldsAt):
    """Compiler type of `Sections`: the memory, and the number of the thread."""


_KINDS: Final = [
    ArrayAt(getattr(types, dtype.name), len(shape) - (shape[0] == "threads"))
    for dtype, shape in zip(DTYPES.values(), _SHAPES.values(), strict=True)
]
SECTIONS: Final = SectionsAt(_KINDS, Sections)


@register_model(SettingsAt)
class _SettingsModel(models.PrimitiveModel):
    def __init__(self, manager: Any, of: SettingsAt) -> None:
        super().__init__(manager, of, ir.DoubleType().as_pointer())


@register_model(SectionsAt)
class _SectionsModel(models.StructModel):
    def __init__(self, manager: Any, of: SectionsAt) -> None:
        super().__init__(manager, of, (("memory", types.CPointer(types.uint8)), ("thread", types.int64)))


def _number_at(builder: Any, numbers: Any, index: int) -> Any:
    """Return a number that no code compiled together with this writes, so that LLVM reads it once."""
    number = builder.load(builder.gep(numbers, [INT64(index)]))
    number.set_metadata("invariant.load", builder.module.add_metadata([]))
    return number


@lower_getattr_generic(SettingsAt)
def _(_context: Any, builder: Any, of: Any, settings: Any, name: str) -> Any:
    number = _number_at(builder, settings, of.fields.index(name))
    return builder.fptosi(number, INT64) if Settings.__annotations__[name] is int else number


@lower_getattr_generic(SectionsAt)
def _(context: Any, builder: Any, of: Any, sections: Any, name: str) -> Any:
    memory, thread = cgutils.unpack_tuple(builder, sections)
    index = of.fields.index(name)
    directory = builder.bitcast(memory, INT64.as_pointer())
    places = range(_ENTRY * index, _ENTRY * index + 1 + len(_SHAPES[name]))
    begin, *shape = (_number_at(builder, directory, place) for place in places)
    if _SHAPES[name][0] == "threads":
        shape = shape[1:]
        size = builder.mul(product(builder, shape), INT64(DTYPES[name].itemsize))
        begin = builder.add(begin, builder.mul(thread, size))
    numbers = context.get_value_type(types.CPointer(of[index].dtype))
    return array_at(builder, builder.bitcast(builder.gep(memory, [begin]), numbers), shape)


def _type_of_settings(numbers: Any, options: Any) -> Any:
    return SettingsAt(Settings if len(options) else PlainSettings)(numbers, options)


@compiled_as(settings_in, _type_of_settings, 2)
def _(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return cgutils.unpack_tuple(builder, arguments[0])[0]


@compiled_as(sections_of, lambda memory, _thread: SECTIONS(memory, types.int64), 2)
def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    memory, thread = arguments
    return cgutils.pack_struct(builder, [context.make_array(signature.args[0])(context, builder, memory).data, thread])

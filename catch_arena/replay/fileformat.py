"""Conversion of a replay to the bytes of a file, and back (docs/reference/replays.md).

Files are untrusted: every size is checked before memory is allocated for it, and a file that is not a whole replay of
this ruleset is refused.
"""

import hashlib
import struct
import zlib
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any, Final

import msgspec
import numpy as np
from msgspec.structs import asdict
from numpy.typing import NDArray

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import CatchArenaError, ConfigError, ReplayError
from catch_arena.plain import plain_setting
from catch_arena.replay.codec import Reader, pack_columns, pack_json
from catch_arena.replay.named_requests import pack_requests, read_requests
from catch_arena.replay.recording import Replay
from catch_arena.replay.states import driven_seats, pack_states, state_length, unpack_states
from catch_arena.seeding import checked_seed

LARGEST_FILE: Final = 1 << 26
"""Largest length of a file, and of an unpacked body [bytes]."""
_MAGIC: Final = b"\x89CATCH\r\n"  # as in PNG, it reveals transfers that change line ends or drop a bit
_FORMAT: Final = 2
_PREY, _NAMED_REQUESTS = 1, 2
"""Optional parts of a file; each one that is present raises the format number by its value."""
_NEWEST: Final = _FORMAT + _PREY + _NAMED_REQUESTS
_PREFIX: Final = struct.Struct("<8sIQ")
_CHECKSUM_BYTES: Final = 32
_DIGEST_BYTES: Final = 8
_LONGEST_HEADER: Final = 1 << 16
_MOST_NUMBERS: Final = 1 << 23
_MOST_SPANS: Final = 1 << 18
_LONGEST_MS: Final = 24 * 3_600_000
_LONGEST_TEXT: Final = 200
_LONGEST_REASON: Final = 300

_Count = Annotated[int, msgspec.Meta(ge=0, lt=2**31)]


class _Header(msgspec.Struct, forbid_unknown_fields=True):
    """JSON object at the beginning of a body; `colors` is left out if there are none."""

    ruleset: str
    package: str
    config: dict[str, Any]
    seed: Any
    names: Any
    title: Any
    steps: _Count
    withdrawals: list[tuple[_Count, _Count]]
    spans: _Count
    """Number of spans of targets in the states, at least one for each target."""
    colors: list[_Count] = []
    """Number of each hunter's colour, by seat; empty if colours go by seat."""


def encode_replay(match: Replay) -> bytes:
    """Return the content of a match's file.

    Raises:
        ReplayError: if the match is too long for a file.
    """
    config, steps = match.config, match.steps
    choices = np.array(match.choices, dtype=np.int64).reshape(-1, config.hunters)
    commands = np.array(match.commands, dtype=np.float32).reshape(-1, config.hunters, 2)
    prey_commands = np.array(match.prey_commands, dtype=np.float32).reshape(steps, config.prey, 2)
    _require_sizes(config, steps)
    states, spans = pack_states(config, commands, prey_commands, match.states)
    _require_sizes(config, steps, spans)
    header = _Header(
        RULESET,
        _package_version(),
        config.to_dict(),
        match.seed,
        match.names,
        match.title,
        steps,
        match.withdrawals,
        spans,
        list(match.colors),
    )
    parts = [
        pack_json({name: value for name, value in asdict(header).items() if name != "colors" or value}),
        pack_columns(choices.T),
        _pack_commands(commands[:, driven_seats(config)]),
        _pack_commands(prey_commands),
        pack_requests(match.named_requests) if match.named_requests else b"",
        *match.digests,
        states,
    ]
    body = b"".join(parts)
    if len(parts[0]) > _LONGEST_HEADER or len(body) > LARGEST_FILE:
        raise ReplayError(f"is too long for a file: {len(body)} bytes, of which {len(parts[0])} are its header")
    shrunk = zlib.compress(body, 9)
    form = _FORMAT + _PREY * bool(config.prey) + _NAMED_REQUESTS * bool(match.named_requests)
    content = _PREFIX.pack(_MAGIC, form, len(shrunk)) + shrunk
    return content + _checksum(content)


def decode_replay(content: bytes) -> Replay:
    """Return the match in a file's content.

    Raises:
        ReplayError: if the content is not a whole replay of this ruleset.
    """
    form, body = _checked_body(content)
    reader = Reader(body)
    match, steps, spans = _read_header(reader)
    config = match.config
    parts = form - _FORMAT
    if bool(parts & _PREY) != bool(config.prey):
        raise ReplayError(f"has format {form}, which does not fit a match with {config.prey} prey")
    choices = reader.columns(config.hunters, steps)
    for seat, control in enumerate(config.controls):
        highest = 0 if control == "velocity" else config.targets_seen
        if steps and not 0 <= choices[:, seat].min() <= choices[:, seat].max() <= highest:
            raise ReplayError(f"contains actions of hunter_{seat} that no arena would accept")
    driven = driven_seats(config)
    commands = np.zeros((steps, config.hunters, 2), dtype=np.float32)
    commands[:, driven] = _read_commands(reader, steps, len(driven))
    prey_commands = _read_commands(reader, steps, config.prey)
    match.choices, match.commands, match.prey_commands = list(choices), list(commands), list(prey_commands)
    match.named_requests = read_requests(reader, config, steps) if parts & _NAMED_REQUESTS else []
    match.digests = [reader.take(_DIGEST_BYTES) for _ in range(steps + 1)]
    match.states = unpack_states(config, commands, prey_commands, reader, spans)
    reader.end()
    return match


def _pack_commands(commands: NDArray[np.float32]) -> bytes:
    """Return velocity commands, (steps, n, 2), as columns."""
    steps, bodies, _ = commands.shape
    bits = commands.reshape(steps, 2 * bodies).view(np.uint32)
    turned = (bits << np.uint32(1)) | (bits >> np.uint32(31))  # the noisy sign bit joins the noisy lowest bits
    return pack_columns(turned.astype(np.int64).T)


def _read_commands(reader: Reader, steps: int, bodies: int) -> NDArray[np.float32]:
    """Return the velocity commands that `_pack_commands` wrote: (steps, bodies, 2)."""
    turned = reader.columns(2 * bodies, steps)
    if turned.size and not 0 <= turned.min() <= turned.max() < 2**32:
        raise ReplayError("is damaged: a velocity command is not a float32")
    bits = (turned >> 1) | ((turned & 1) << 31)
    commands = bits.astype(np.uint32).view(np.float32).reshape(steps, bodies, 2)
    if not np.all(np.abs(commands) <= 1.0):  # NaN too
        raise ReplayError("contains velocity commands that no arena would accept")
    return commands


def checked_text(field: str, text: object) -> str:
    """Return a name or a title that can be shown in one line.

    Raises:
        ConfigError: for a text that is too long or cannot be printed.
    """
    if not isinstance(text, str) or len(text) > _LONGEST_TEXT or not text.isprintable():
        shown = repr(text)[: _LONGEST_TEXT + 10]
        raise ConfigError(f"{field} must be at most {_LONGEST_TEXT} printable characters, got {shown}")
    return text


def checked_names(names: object, config: ArenaConfig) -> tuple[str, ...]:
    """Return the agents' names: of the hunters by seat, and then of the prey by index.

    Raises:
        ConfigError: if there is not one name for each agent, or a name is too long or cannot be printed.
    """
    plain, wanted = plain_setting(names), config.hunters + config.prey
    if not isinstance(plain, tuple) or len(plain) != wanted:
        agent_kinds = "hunter and each prey" if config.prey else "hunter"
        raise ConfigError(
            f"names must have {wanted} entries, one for each {agent_kinds}, got {repr(names)[: _LONGEST_TEXT + 10]}"
        )
    return tuple(checked_text(f"names[{agent}]", name) for agent, name in enumerate(plain))


def _checksum(content: bytes | memoryview) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKSUM_BYTES).digest()


def _checked_body(content: bytes) -> tuple[int, bytes]:
    """Return the format number and the unpacked body of a file, after all checks."""
    if not content.startswith(_MAGIC):
        raise ReplayError("is not a Catch Arena replay")
    if len(content) < _PREFIX.size + _CHECKSUM_BYTES:
        raise ReplayError("is truncated")
    if len(content) > LARGEST_FILE:
        raise ReplayError(f"is longer than {LARGEST_FILE} bytes")
    _, form, length = _PREFIX.unpack_from(content)
    if not _FORMAT <= form <= _NEWEST:
        raise ReplayError(f"has format {form}, but this version reads formats {_FORMAT} to {_NEWEST}")
    whole = _PREFIX.size + length + _CHECKSUM_BYTES
    if len(content) != whole:
        raise ReplayError(f"is incomplete or damaged: it must be {whole} bytes long, got {len(content)}")
    checked = memoryview(content)[:-_CHECKSUM_BYTES]
    if _checksum(checked) != content[-_CHECKSUM_BYTES:]:
        raise ReplayError("is damaged: its checksum does not match")
    unpacker = zlib.decompressobj()
    try:
        body = unpacker.decompress(checked[_PREFIX.size :], LARGEST_FILE)
    except zlib.error:
        raise ReplayError("is damaged: its body does not unpack") from None
    if not unpacker.eof:
        raise ReplayError(f"is damaged, or longer than {LARGEST_FILE} bytes when unpacked")
    if unpacker.unused_data:
        raise ReplayError(f"is damaged: {len(unpacker.unused_data)} bytes follow its body")
    return form, body


def _read_header(reader: Reader) -> tuple[Replay, int, int]:
    """Return a match without its steps, the number of its steps, and the number of its spans."""
    found = reader.json("header", _LONGEST_HEADER)
    if not isinstance(found, dict):
        raise ReplayError("is damaged: its header is not a table")
    if found.get("ruleset") != RULESET:
        ruleset = repr(found.get("ruleset"))[:_LONGEST_TEXT]
        raise ReplayError(f"was recorded under ruleset {ruleset}, but this version plays {RULESET!r}")
    try:
        header = msgspec.convert(found, _Header)
        config = ArenaConfig.from_dict(header.config)
        checked_text("name_prefix", config.name_prefix)
        names, title = checked_names(header.names, config), checked_text("title", header.title)
        match = Replay(config, checked_seed(header.seed), names, title, withdrawals=header.withdrawals)
        match.colors = tuple(header.colors)
        if match.colors and len(match.colors) != config.hunters:
            raise ConfigError(f"colors must have {config.hunters} entries, one for each hunter")
        agents = {agent for _, agent in header.withdrawals}
        in_order = header.withdrawals == sorted(header.withdrawals) and len(agents) == len(header.withdrawals)
        if not in_order or any(step > header.steps or agent >= len(names) for step, agent in header.withdrawals):
            raise ConfigError("withdrawals must name agents, each once, in the order of the steps")
    except (CatchArenaError, TypeError, ValueError, AttributeError) as error:  # ValueError: msgspec's, too
        raise ReplayError(f"has a header that cannot be used: {ascii(str(error))[1:-1][:_LONGEST_REASON]}") from None
    _require_sizes(config, header.steps, header.spans)
    if header.steps > config.max_steps:
        raise ReplayError(
            f"has a header that cannot be used: {header.steps} steps, but a match has at most {config.max_steps}"
        )
    return match, header.steps, header.spans


def _require_sizes(config: ArenaConfig, steps: int, spans: int = 0) -> None:
    """Raise ReplayError for a match that is too large for memory, or longer than a day."""
    if (steps + 1) * state_length(config) > _MOST_NUMBERS:
        max_steps = _MOST_NUMBERS // state_length(config) - 1
        raise ReplayError(f"is too long for a file: {steps} steps, but at most {max_steps} fit for this arena")
    if steps * config.control_period_ms > _LONGEST_MS:
        raise ReplayError(f"is too long for a file: {steps} steps of {config.control_period_ms} ms are more than a day")
    if spans > _MOST_SPANS:
        raise ReplayError(f"is too long for a file: {spans} targets, but at most {_MOST_SPANS} fit")


def _package_version() -> str:
    try:
        return version("catch-arena")
    except PackageNotFoundError:
        return "unknown"

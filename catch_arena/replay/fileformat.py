"""A replay as the bytes of a file, and back (docs/replays.md).

What is read may have been written by anybody: every size is checked before memory is taken for it, and whatever is not
a whole replay of this ruleset is refused.
"""

import hashlib
import json
import struct
import zlib
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.equality import equal_fields
from catch_arena.errors import CatchArenaError, ConfigError, ReplayError
from catch_arena.plain import plain_setting
from catch_arena.replay.codec import LENGTH, Reader, pack_columns
from catch_arena.replay.named_requests import NamedRequest, pack_requests, read_requests
from catch_arena.replay.quantisation import QuantisedState, driven_seats, pack_states, state_length, unpack_states
from catch_arena.seeding import checked_seed

LARGEST_FILE: Final = 1 << 26
"""No file is longer than this, and no body when it is unpacked [bytes]."""
_MAGIC: Final = b"\x89CATCH\r\n"  # as PNG does it: a transfer that mangles bytes is noticed at once
_FORMAT: Final = 2
_WITH_PREY: Final = 1
_WITH_NAMED_REQUESTS: Final = 2
"""Added to the format of a match that has them: one without needs nothing that is new in it."""
_NEWEST: Final = _FORMAT + _WITH_PREY + _WITH_NAMED_REQUESTS
_PREFIX: Final = struct.Struct("<8sIQ")
_CHECKSUM_BYTES: Final = 32
_DIGEST_BYTES: Final = 8
_LONGEST_HEADER: Final = 1 << 16
_MOST_NUMBERS: Final = 1 << 23
_MOST_SPANS: Final = 1 << 18
_LONGEST_MS: Final = 24 * 3_600_000
_LONGEST_TEXT: Final = 200
_LONGEST_REASON: Final = 300
_KEYS: Final = {"ruleset", "package", "config", "seed", "names", "title", "steps", "withdrawals", "spans"}


@dataclass(slots=True, eq=False)
class ReplayContent:
    """What a file holds. Two are equal if they hold the same match, in every bit."""

    __eq__ = equal_fields
    __hash__ = None  # type: ignore[assignment]

    config: ArenaConfig
    seed: int
    names: tuple[str, ...]
    """The agents', of the hunters by seat and then of the prey by index."""
    title: str = ""
    choices: list[NDArray[np.int64]] = field(default_factory=list)
    """The ranks of each step: (H,)."""
    commands: list[NDArray[np.float32]] = field(default_factory=list)
    """The velocity commands of each step: (H, 2)."""
    prey_commands: list[NDArray[np.float32]] = field(default_factory=list)
    """Prey's velocity commands of each step: (P, 2), also where there is none."""
    digests: list[bytes] = field(default_factory=list)
    """A.8, after the reset and after each step."""
    states: list[QuantisedState] = field(default_factory=list)
    """The states that the digests stand for, in whole millionths: they say in what two of them differ."""
    withdrawals: list[tuple[int, int]] = field(default_factory=list)
    """(steps played before it, agent): R1.6, R12.5. Agents count as in `names`."""
    named_requests: list[NamedRequest] = field(default_factory=list)
    """What was asked for by name and no rank stands for, in the order in which it was asked: R8.4."""


def encode_replay(match: ReplayContent) -> bytes:
    """The file's content.

    Raises:
        ReplayError: for a match that is too long to be kept.
    """
    config, steps = match.config, len(match.choices)
    _require_sizes(config, steps)
    driven = driven_seats(config)
    choices = np.array(match.choices, dtype=np.int64).reshape(-1, config.hunters)
    commands = np.array(match.commands, dtype=np.float32).reshape(-1, config.hunters, 2)
    prey_commands = np.array(match.prey_commands, dtype=np.float32).reshape(steps, config.prey, 2)
    states, spans = pack_states(config, commands, prey_commands, match.states)
    _require_few_spans(spans)
    header = {
        "ruleset": RULESET,
        "package": _package_version(),
        "config": config.to_dict(),
        "seed": match.seed,
        "names": match.names,
        "title": match.title,
        "steps": steps,
        "withdrawals": match.withdrawals,
        "spans": spans,
    }
    text = json.dumps(header, separators=(",", ":")).encode()
    body = b"".join(
        (
            LENGTH.pack(len(text)),
            text,
            pack_columns(choices.T),
            _pack_commands(commands[:, driven]),
            _pack_commands(prey_commands),
            pack_requests(match.named_requests) if match.named_requests else b"",
            *match.digests,
            states,
        )
    )
    if len(text) > _LONGEST_HEADER or len(body) > LARGEST_FILE:
        raise ReplayError(f"is too long to be kept: {len(body)} bytes, {len(text)} of them its header")
    shrunk = zlib.compress(body, 9)
    content = _PREFIX.pack(_MAGIC, _format_of(match), len(shrunk)) + shrunk
    return content + _checksum(content)


def decode_replay(content: bytes) -> ReplayContent:
    """The match in a file's content.

    Raises:
        ReplayError: for whatever is not a whole replay of this ruleset.
    """
    form, body = _checked_body(content)
    reader = Reader(body)
    header = _checked_header(_header_of(reader))
    config, steps = header.config, header.steps
    named = (form - _FORMAT) & _WITH_NAMED_REQUESTS
    if (form - _FORMAT) & _WITH_PREY != (_WITH_PREY if config.prey else 0):
        raise ReplayError(f"is of format {form}, which is not that of a match with {config.prey} prey")
    choices = reader.columns(config.hunters, steps)
    for seat, control in enumerate(config.controls):
        highest = 0 if control == "velocity" else config.targets_seen
        if steps and not 0 <= choices[:, seat].min() <= choices[:, seat].max() <= highest:
            raise ReplayError(f"holds actions of hunter_{seat} that no arena would have taken")
    driven = driven_seats(config)
    commands = np.zeros((steps, config.hunters, 2), dtype=np.float32)
    commands[:, driven] = _read_commands(reader, steps, len(driven))
    prey_commands = _read_commands(reader, steps, config.prey)
    named_requests = read_requests(reader, config, steps) if named else []
    digests = [reader.take(_DIGEST_BYTES) for _ in range(steps + 1)]
    states = unpack_states(config, commands, prey_commands, reader, header.spans)
    reader.end()
    return ReplayContent(
        config=config,
        seed=header.seed,
        names=header.names,
        title=header.title,
        choices=list(choices),
        commands=list(commands),
        prey_commands=list(prey_commands),
        digests=digests,
        states=states,
        withdrawals=header.withdrawals,
        named_requests=named_requests,
    )


def _format_of(match: ReplayContent) -> int:
    prey, named = bool(match.config.prey), bool(match.named_requests)
    return _FORMAT + _WITH_PREY * prey + _WITH_NAMED_REQUESTS * named


def _pack_commands(commands: NDArray[np.float32]) -> bytes:
    """Velocity commands, (steps, n, 2), as columns."""
    steps, bodies, _ = commands.shape
    bits = commands.reshape(steps, 2 * bodies).view(np.uint32)
    turned = (bits << np.uint32(1)) | (bits >> np.uint32(31))  # the sign, which is noise, goes to the other noise
    return pack_columns(turned.astype(np.int64).T)


def _read_commands(reader: Reader, steps: int, bodies: int) -> NDArray[np.float32]:
    """What `_pack_commands` wrote."""
    turned = reader.columns(2 * bodies, steps)
    if turned.size and not 0 <= turned.min() <= turned.max() < 2**32:
        raise ReplayError("is damaged: a velocity command is not a float32")
    bits = (turned >> 1) | ((turned & 1) << 31)
    commands = bits.astype(np.uint32).view(np.float32).reshape(steps, bodies, 2)
    if not np.all(np.abs(commands) <= 1.0):  # NaN too
        raise ReplayError("holds velocity commands that no arena would have taken")
    return commands


def checked_text(what: str, text: object) -> str:
    """A name or a title that can be shown in one line.

    Raises:
        ConfigError: for a text that is too long or cannot be printed.
    """
    if not isinstance(text, str) or len(text) > _LONGEST_TEXT or not text.isprintable():
        shown = repr(text)[: _LONGEST_TEXT + 10]
        raise ConfigError(f"{what} must be at most {_LONGEST_TEXT} printable characters, got {shown}")
    return text


def checked_names(names: object, config: ArenaConfig) -> tuple[str, ...]:
    """The agents' names, of the hunters by seat and of the prey by index, each of which can be shown in one line.

    Raises:
        ConfigError: for a number of names that is not that of the agents, and one that cannot be shown.
    """
    plain, wanted = plain_setting(names), config.hunters + config.prey
    if not isinstance(plain, tuple) or len(plain) != wanted:
        each = "hunter and each prey" if config.prey else "hunter"
        raise ConfigError(f"names must be {wanted}, one for each {each}, got {repr(names)[: _LONGEST_TEXT + 10]}")
    return tuple(checked_text(f"names[{agent}]", name) for agent, name in enumerate(plain))


def _checksum(content: bytes | memoryview) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKSUM_BYTES).digest()


def _checked_body(content: bytes) -> tuple[int, bytes]:
    """The format, and the body as it is unpacked."""
    if not content.startswith(_MAGIC):
        raise ReplayError("is not a Catch Arena replay")
    if len(content) < _PREFIX.size + _CHECKSUM_BYTES:
        raise ReplayError("is truncated")
    if len(content) > LARGEST_FILE:
        raise ReplayError(f"is longer than {LARGEST_FILE} bytes")
    _, form, length = _PREFIX.unpack_from(content)
    if not _FORMAT <= form <= _NEWEST:
        raise ReplayError(f"is of format {form}, and this version reads formats {_FORMAT} to {_NEWEST}")
    whole = _PREFIX.size + length + _CHECKSUM_BYTES
    if len(content) != whole:
        raise ReplayError(f"should be {whole} bytes long, got {len(content)}")
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


def _header_of(reader: Reader) -> dict[str, Any]:
    header = reader.json("header", _LONGEST_HEADER)
    if not isinstance(header, dict):
        raise ReplayError("is damaged: its header is not a table")
    if header.get("ruleset") != RULESET:
        ruleset = repr(header.get("ruleset"))[:_LONGEST_TEXT]
        raise ReplayError(f"was recorded under ruleset {ruleset}, and this is {RULESET!r}")
    if header.keys() != _KEYS:
        odd = ", ".join(sorted(header.keys() ^ _KEYS))
        raise ReplayError(f"has a header that cannot be used: {ascii(odd)[1:-1][:_LONGEST_REASON]} too many or missing")
    return header


@dataclass(frozen=True, slots=True, kw_only=True)
class _Header:
    """What a file's header says of the match; the ruleset and the package stand in it too."""

    config: ArenaConfig
    seed: int
    names: tuple[str, ...]
    title: str
    steps: int
    withdrawals: list[tuple[int, int]]
    spans: int
    """How many targets there were."""


def _checked_header(header: dict[str, Any]) -> _Header:
    try:
        config = ArenaConfig.from_dict(header["config"])
        seed, title = checked_seed(header["seed"]), checked_text("title", header["title"])
        checked_text("name_prefix", config.name_prefix)
        names = checked_names(header["names"], config)
        steps, spans = (_count(name, header[name]) for name in ("steps", "spans"))
        withdrawals = [
            (_count("withdrawals", step), _count("withdrawals", place)) for step, place in header["withdrawals"]
        ]
        places, agents = {place for _, place in withdrawals}, len(names)
        in_order = withdrawals == sorted(withdrawals) and len(places) == len(withdrawals)
        if not in_order or any(step > steps or place >= agents for step, place in withdrawals):
            raise ConfigError("withdrawals must name agents, each once, in the order of the steps")
    except (CatchArenaError, TypeError, ValueError, AttributeError) as error:
        raise ReplayError(f"has a header that cannot be used: {ascii(str(error))[1:-1][:_LONGEST_REASON]}") from None
    _require_sizes(config, steps)
    if steps > config.max_steps:
        raise ReplayError(f"has a header that cannot be used: {steps} steps, and a match has {config.max_steps}")
    _require_few_spans(spans)
    return _Header(
        config=config, seed=seed, names=names, title=title, steps=steps, withdrawals=withdrawals, spans=spans
    )


def _count(name: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise ConfigError(f"{name} must be whole numbers from 0")
    return value


def _require_sizes(config: ArenaConfig, steps: int) -> None:
    """What is read must fit in memory, and be played in a time that somebody will wait for."""
    if (steps + 1) * state_length(config) > _MOST_NUMBERS:
        most = _MOST_NUMBERS // state_length(config) - 1
        raise ReplayError(f"is too long to be kept: {steps} steps, and {most} are the most in such an arena")
    if steps * config.control_period_ms > _LONGEST_MS:
        raise ReplayError(f"is too long to be kept: {steps} steps of {config.control_period_ms} ms are more than a day")


def _require_few_spans(spans: int) -> None:
    if spans > _MOST_SPANS:
        raise ReplayError(f"is too long to be kept: {spans} targets, and {_MOST_SPANS} are the most")


def _package_version() -> str:
    try:
        return version("catch-arena")
    except PackageNotFoundError:
        return "unknown"

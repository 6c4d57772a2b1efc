"""Conversion of a replay to the bytes of a file, and back (docs/reference/replays.md).

Files are untrusted: every size is checked before memory is allocated for it, actions and agents must be those of the
arena, and a file that is not a whole replay of this ruleset is refused. `verify` checks all other numbers.
"""

import hashlib
import struct
import zlib
from importlib.metadata import version
from io import BytesIO
from typing import Annotated, Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import ConfigError, ReplayError
from catch_arena.plain import plain_setting
from catch_arena.replay.codec import pack_columns, pack_json, read_columns, read_json
from catch_arena.replay.named_requests import pack_requests, read_requests
from catch_arena.replay.recording import Replay
from catch_arena.seeding import checked_seed

LARGEST_FILE: Final = 1 << 26
"""Largest length of a file, and of an unpacked body [bytes]."""
_MAGIC: Final = b"\x89CATCH\r\n"  # as in PNG, it reveals transfers that change line ends or drop a bit
_FORMAT: Final = 6
_OLDEST: Final = 2
_PREFIX: Final = struct.Struct("<8sIQ")
_CHECKSUM_BYTES: Final = 32
_DIGEST_BYTES: Final = 8
_LONGEST_HEADER: Final = 1 << 16
_LONGEST_TEXT: Final = 200

_Count = Annotated[int, msgspec.Meta(ge=0, lt=2**31)]


class _Header(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """JSON object at the beginning of a body; `colors` is left out if there are none."""

    ruleset: str
    package: str
    config: dict[str, Any]
    seed: Any
    names: Any
    title: Any
    steps: _Count
    withdrawals: list[tuple[_Count, _Count]]
    spans: int | msgspec.UnsetType = msgspec.UNSET
    """Entry of formats 2 to 5; not used."""
    colors: list[_Count] = []
    """Number of each hunter's colour, by seat; empty if colours go by seat."""


def encode_replay(match: Replay) -> bytes:
    """Return the content of a match's file; raise ReplayError if the match is too long for one."""
    config, steps = match.config, match.steps
    choices = np.array(match.choices, dtype=np.int64).reshape(-1, config.hunters)
    commands = np.array(match.commands, dtype=np.float32).reshape(-1, config.hunters + config.prey, 2)
    _require_size(config, steps)
    header = _Header(
        RULESET,
        version("catch-arena"),
        config.to_dict(),
        match.seed,
        match.names,
        match.title,
        steps,
        match.withdrawals,
        colors=list(match.colors),
    )
    parts = [
        pack_json(msgspec.to_builtins(header)),
        pack_columns(choices.T),
        _pack_commands(commands[:, _driven_agents(config)]),
        pack_requests(match.named_requests),
        *match.digests,
    ]
    body = b"".join(parts)
    if len(parts[0]) > _LONGEST_HEADER or len(body) > LARGEST_FILE:
        raise ReplayError(f"is too long for a file: {len(body)} bytes, of which {len(parts[0])} are its header")
    shrunk = zlib.compress(body, 9)
    content = _PREFIX.pack(_MAGIC, _FORMAT, len(shrunk)) + shrunk
    return content + _checksum(content)


def decode_replay(content: bytes) -> Replay:
    """Return the match in a file's content; raise ReplayError if it is not a whole replay of this ruleset."""
    try:
        return _decode_body(*_checked_body(content))
    except (ConfigError, msgspec.ValidationError) as error:
        raise ReplayError(f"cannot be used: {ascii(str(error))[1:-1][:300]}") from None
    except (AttributeError, LookupError, RecursionError, TypeError, ValueError, zlib.error):
        raise ReplayError("is damaged: its parts do not fit together") from None


def _decode_body(form: int, body: BytesIO) -> Replay:
    header = read_json(body, _LONGEST_HEADER, _Header)
    if header.ruleset != RULESET:
        ruleset = repr(header.ruleset)[:_LONGEST_TEXT]
        raise ReplayError(f"was recorded under ruleset {ruleset}, but this version plays {RULESET!r}")
    config, steps = ArenaConfig.from_dict(header.config), header.steps
    names, title = checked_names(header.names, config), checked_text("title", header.title)
    if any(agent >= len(names) for _, agent in header.withdrawals) or len(header.colors) not in (0, config.hunters):
        raise ReplayError("is damaged: its header has withdrawals or colors of agents that it does not have")
    _require_size(config, steps)
    choices = read_columns(body, config.hunters, steps)
    highest = [0 if control == "velocity" else config.targets_seen for control in config.controls]
    if np.any((choices < 0) | (choices > highest)):
        raise ReplayError("contains ranks that no arena would accept")
    driven = _driven_agents(config)
    commands = np.zeros((steps, config.hunters + config.prey, 2), dtype=np.float32)
    commands[:, driven] = _read_commands(body, steps, len(driven))
    requests = [] if form < 4 else read_requests(body, config)  # formats 2 and 3 lack them
    digests = [body.read(_DIGEST_BYTES) for _ in range(steps + 1)]
    if len(digests[-1]) < _DIGEST_BYTES:
        raise ReplayError("is damaged: its digests are not complete")
    if form == _FORMAT and body.read(1):  # in formats 2 to 5 other bytes follow, which have no meaning here
        raise ReplayError("is damaged: more bytes follow its end")
    return Replay(
        config,
        checked_seed(header.seed),
        names,
        title,
        choices=list(choices),
        commands=list(commands),
        digests=digests,
        withdrawals=header.withdrawals,
        named_requests=requests,
        colors=tuple(header.colors),
    )


def _pack_commands(commands: NDArray[np.float32]) -> bytes:
    """Return velocity commands, (steps, n, 2), as columns."""
    steps, bodies, _ = commands.shape
    bits = commands.reshape(steps, 2 * bodies).view(np.uint32)
    turned = (bits << np.uint32(1)) | (bits >> np.uint32(31))  # the noisy sign bit joins the noisy lowest bits
    return pack_columns(turned.astype(np.int64).T)


def _read_commands(body: BytesIO, steps: int, bodies: int) -> NDArray[np.float32]:
    """Return the velocity commands that `_pack_commands` wrote: (steps, bodies, 2)."""
    turned = read_columns(body, 2 * bodies, steps).astype(np.uint32)
    commands = ((turned >> np.uint32(1)) | (turned << np.uint32(31))).view(np.float32).reshape(steps, bodies, 2)
    if not np.all(np.abs(commands) <= 1.0):  # NaN too
        raise ReplayError("contains velocity commands that no arena would accept")
    return commands


def checked_text(field: str, text: object) -> str:
    """Return a name or a title, if it can be shown in one line; raise ConfigError for others."""
    if not isinstance(text, str) or len(text) > _LONGEST_TEXT or not text.isprintable():
        shown = repr(text)[: _LONGEST_TEXT + 10]
        raise ConfigError(f"{field} must be at most {_LONGEST_TEXT} printable characters, got {shown}")
    return text


def checked_names(names: object, config: ArenaConfig) -> tuple[str, ...]:
    """Return the agents' names, of the hunters by seat and then of the prey; raise ConfigError for unusable ones."""
    plain, wanted = plain_setting(names), config.hunters + config.prey
    if not isinstance(plain, tuple) or len(plain) != wanted:
        shown = repr(names)[: _LONGEST_TEXT + 10]
        raise ConfigError(f"names must have {wanted} entries, one for each hunter and each prey, got {shown}")
    return tuple(checked_text(f"names[{agent}]", name) for agent, name in enumerate(plain))


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKSUM_BYTES).digest()


def _checked_body(content: bytes) -> tuple[int, BytesIO]:
    """Return the format number and the unpacked body of a file."""
    if not content.startswith(_MAGIC):
        raise ReplayError("is not a Catch Arena replay")
    if len(content) > LARGEST_FILE:
        raise ReplayError(f"is longer than {LARGEST_FILE} bytes")
    stored = content[:-_CHECKSUM_BYTES]
    if len(stored) < _PREFIX.size or _checksum(stored) != content[-_CHECKSUM_BYTES:]:
        raise ReplayError("is incomplete or damaged: its checksum does not match")
    _, form, _ = _PREFIX.unpack_from(stored)
    if not _OLDEST <= form <= _FORMAT:
        raise ReplayError(f"has format {form}, but this version reads formats {_OLDEST} to {_FORMAT}")
    unpacker = zlib.decompressobj()
    body = unpacker.decompress(stored[_PREFIX.size :], LARGEST_FILE)
    if not unpacker.eof:
        raise ReplayError(f"is damaged, or longer than {LARGEST_FILE} bytes when unpacked")
    return form, BytesIO(body)


def _require_size(config: ArenaConfig, steps: int) -> None:
    """Raise ReplayError for a match that is too large for memory."""
    # besides its actions, a step takes as much memory as eight of them
    most_steps = (1 << 23) // (8 + config.hunters + config.prey)
    if steps > most_steps:
        raise ReplayError(f"is too long for a file: {steps} steps, but at most {most_steps} fit")


def _driven_agents(config: ArenaConfig) -> list[int]:
    """Return the agents whose commands have a meaning: hunters under velocity or full control, and prey."""
    hunters = [seat for seat, control in enumerate(config.controls) if control != "target"]
    return [*hunters, *range(config.hunters, config.hunters + config.prey)]

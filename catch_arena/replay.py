"""Rulebook R10.2: a match as its header, its seed and its actions, with a digest of the state per step.

The file (docs/replays.md): an eight-byte mark, the format's version, the length of the body, the body, and a checksum
over all of it. The body is compressed: a JSON header, then the actions and the digests as plain arrays.
"""

import hashlib
import json
import os
import struct
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.engine import Engine
from catch_arena.errors import CatchArenaError, OutputError, ReplayError
from catch_arena.world import World

_MARK: Final = b"\x89CATCH\r\n"  # as PNG does it: a transfer that mangles bytes is noticed at once
_FORMAT: Final = 1
_PREFIX: Final = struct.Struct("<8sIQ")
_CHECKSUM_BYTES: Final = 32
_DIGEST_BYTES: Final = 8
_LARGEST_BODY: Final = 1 << 28


@dataclass(slots=True)
class Replay:
    """One recorded match, or the part of it that has been played."""

    config: ArenaConfig
    seed: int
    names: tuple[str, ...]
    """The agents' names by seat."""
    title: str = ""
    choices: list[NDArray[np.int64]] = field(default_factory=list)
    """The ranks of each step: (H,)."""
    commands: list[NDArray[np.float32]] = field(default_factory=list)
    """The velocity commands of each step: (H, 2)."""
    digests: list[bytes] = field(default_factory=list)
    """A.8, after the reset and after each step."""
    withdrawals: list[tuple[int, int]] = field(default_factory=list)
    """(steps played before it, seat): R1.6."""

    @property
    def steps(self) -> int:
        """How many steps were played."""
        return len(self.choices)

    def append(self, choices: NDArray[np.int64], commands: NDArray[np.float32], digest: bytes) -> None:
        """One more step: its actions, which are copied, and the digest of the state that it led to."""
        self.choices.append(choices.copy())
        self.commands.append(commands.copy())
        self.digests.append(digest)

    def worlds(self) -> Iterator[World]:
        """The match again: the world at every step's boundary, steps + 1 of them, each checked against its digest.

        Raises: ReplayError that names the first step that differs.
        """
        engine = Engine(self.config)
        engine.reset([self.seed])
        self._verify(engine, 0)
        yield engine.world()
        for step in range(self.steps):
            for before, seat in self.withdrawals:
                if before == step:
                    engine.withdraw(0, seat)
            engine.step(self.choices[step][None], self.commands[step][None])
            self._verify(engine, step + 1)
            yield engine.world()

    def _verify(self, engine: Engine, step: int) -> None:
        if engine.digest() != self.digests[step]:
            when = "the initial state" if step == 0 else f"step {step}"
            raise ReplayError(f"the replay does not play as it was recorded: {when} is the first that differs")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the replay; under its name appears a whole file or none. Raises: OutputError."""
        header = {
            "ruleset": RULESET,
            "package": _package_version(),
            "config": self.config.to_dict(),
            "seed": self.seed,
            "names": list(self.names),
            "title": self.title,
            "steps": self.steps,
            "withdrawals": self.withdrawals,
        }
        text = json.dumps(header, separators=(",", ":")).encode()
        hunters, driven = self.config.hunters, self._driven_seats(self.config)
        choices = np.array(self.choices, dtype="<i2").reshape(self.steps, hunters)
        commands = np.array(self.commands, dtype="<f4").reshape(self.steps, hunters, 2)[:, driven]
        body = zlib.compress(
            b"".join(
                (
                    struct.pack("<I", len(text)),
                    text,
                    choices.tobytes(),
                    commands.tobytes(),
                    b"".join(self.digests),
                )
            ),
            9,
        )
        content = _PREFIX.pack(_MARK, _FORMAT, len(body)) + body
        write_whole(Path(path), content + hashlib.blake2b(content, digest_size=_CHECKSUM_BYTES).digest())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Replay":
        """The replay in a file. Raises: ReplayError for whatever is not a whole replay of this ruleset."""
        try:
            with Path(path).open("rb") as file:
                content = file.read(_LARGEST_BODY)
        except OSError as error:
            raise ReplayError(f"{path}: cannot be read: {error.strerror or error}") from None
        try:
            return cls._parse(content)
        except ReplayError as error:
            raise ReplayError(f"{path}: {error}") from None

    @classmethod
    def _parse(cls, content: bytes) -> "Replay":
        body = _checked_body(content)
        header, at = _header_of(body)
        if header.get("ruleset") != RULESET:
            raise ReplayError(f"was recorded under ruleset {header.get('ruleset')!r}, and this is {RULESET}")
        try:
            config = ArenaConfig.from_dict(header["config"])
            seed, steps, title = header["seed"], header["steps"], header["title"]
            names = tuple(header["names"])
            withdrawals = [(int(step), int(seat)) for step, seat in header["withdrawals"]]
            whole = all(isinstance(number, int) and number >= 0 for number in (seed, steps))
            seated = len(names) == config.hunters and all(isinstance(name, str) for name in names)
            if not (whole and seed < 2**64 and seated and isinstance(title, str)):
                raise ReplayError("its header contradicts itself")
            if any(not 0 <= seat < config.hunters for _, seat in withdrawals):
                raise ReplayError("its header withdraws a hunter that does not exist")
        except (CatchArenaError, KeyError, TypeError, ValueError, AttributeError) as error:
            raise ReplayError(f"its header cannot be used: {error}") from None
        hunters, driven = config.hunters, cls._driven_seats(config)
        sizes = (2 * hunters * steps, 8 * len(driven) * steps, _DIGEST_BYTES * (steps + 1))
        if len(body) - at != sum(sizes):
            raise ReplayError(f"should hold {sum(sizes)} bytes of actions and digests, got {len(body) - at}")
        choices = np.frombuffer(body, dtype="<i2", count=hunters * steps, offset=at).reshape(steps, hunters)
        commands = np.zeros((steps, hunters, 2), dtype=np.float32)
        commands[:, driven] = np.frombuffer(
            body, dtype="<f4", count=2 * len(driven) * steps, offset=at + sizes[0]
        ).reshape(steps, len(driven), 2)
        if steps and (choices.min() < 0 or choices.max() > config.targets_seen or not _within_unit(commands)):
            raise ReplayError("holds actions that no arena would have taken")
        first = at + sizes[0] + sizes[1]
        digests = [body[i : i + _DIGEST_BYTES] for i in range(first, len(body), _DIGEST_BYTES)]
        return cls(
            config=config,
            seed=seed,
            names=names,
            title=title,
            choices=list(choices.astype(np.int64)),
            commands=list(commands),
            digests=digests,
            withdrawals=withdrawals,
        )

    @staticmethod
    def _driven_seats(config: ArenaConfig) -> list[int]:
        """The seats whose velocity commands mean something."""
        return [seat for seat, control in enumerate(config.controls) if control != "target"]


def _within_unit(commands: NDArray[np.float32]) -> bool:
    return bool(np.all(np.abs(commands) <= 1.0))  # False for NaN too


def _checked_body(content: bytes) -> bytes:
    if not content.startswith(_MARK):
        raise ReplayError("is not a Catch Arena replay")
    if len(content) < _PREFIX.size + _CHECKSUM_BYTES:
        raise ReplayError("is truncated")
    _, form, length = _PREFIX.unpack_from(content)
    if form != _FORMAT:
        raise ReplayError(f"is of format {form}, and this version reads format {_FORMAT}")
    if len(content) != _PREFIX.size + length + _CHECKSUM_BYTES:
        raise ReplayError(f"should be {_PREFIX.size + length + _CHECKSUM_BYTES} bytes long, got {len(content)}")
    checked, checksum = content[:-_CHECKSUM_BYTES], content[-_CHECKSUM_BYTES:]
    if hashlib.blake2b(checked, digest_size=_CHECKSUM_BYTES).digest() != checksum:
        raise ReplayError("is damaged: its checksum does not match")
    try:
        unpacker = zlib.decompressobj()
        body = unpacker.decompress(content[_PREFIX.size : -_CHECKSUM_BYTES], _LARGEST_BODY)
    except zlib.error:
        raise ReplayError("is damaged: its body does not unpack") from None
    if not unpacker.eof:
        raise ReplayError(f"is damaged, or longer than {_LARGEST_BODY} bytes when unpacked")
    return body


def _header_of(body: bytes) -> tuple[dict[str, Any], int]:
    try:
        (length,) = struct.unpack_from("<I", body)
        header = json.loads(body[4 : 4 + length])
    except (struct.error, ValueError, RecursionError):
        raise ReplayError("is damaged: it has no readable header") from None
    if not isinstance(header, dict):
        raise ReplayError("is damaged: its header is not a table")
    return header, 4 + length


def regular_file(path: Path) -> Path:
    """Where a file of that name is or would be, links followed. Raises: OutputError for a device or a folder."""
    target = path.resolve()
    if target.exists() and not target.is_file():
        raise OutputError(f"{path}: cannot be written: is not a regular file")
    return target


def write_whole(path: Path, content: bytes) -> None:
    """Write a file under a temporary name and rename it: whoever looks finds it whole or not at all. Raises:
    OutputError.
    """
    target = regular_file(path)
    try:
        with tempfile.NamedTemporaryFile(dir=target.parent, prefix=f".{target.name}.", delete=False) as file:
            try:
                file.write(content)
                file.flush()
                Path(file.name).chmod(0o644)
                Path(file.name).replace(target)
            except BaseException:
                Path(file.name).unlink(missing_ok=True)
                raise
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None


def _package_version() -> str:
    try:
        return version("catch-arena")
    except PackageNotFoundError:
        return "unknown"

"""What a match and an isolated agent say to each other, in lines of JSON (docs/isolation.md), and how our own processes
pass messages with open files.

To Python agents, whose side is ours too, a view is not written as a line but as a record of bytes: it is as exact, and
costs both sides a tenth.
"""

import json
import socket
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from io import BufferedReader
from struct import Struct
from typing import Any, Final

from catch_arena.plain import as_python, plain_action
from catch_arena.policy import AnyLimits, Limits, PreyLimits

VERSION: Final = 1
HELLO: Final = b'{"hello":%d}\n' % VERSION
_HEAD: Final = Struct("<HH")
_MOST_FILES: Final = 4
_PART: Final = 65536

_encoded: Final = json.JSONEncoder(separators=(",", ":")).encode


def line(**message: Any) -> bytes:
    """A message as one line."""
    return _encoded(message).encode() + b"\n"


def reset_line(seed: int, limits: AnyLimits) -> bytes:
    """What begins a match."""
    return line(reset={"seed": seed, "side": limits.side, "limits": asdict(limits)})


def limits_in(reset: dict[str, Any]) -> AnyLimits:
    """The limits in that line."""
    return (PreyLimits if reset["side"] == "prey" else Limits)(**reset["limits"])


def view_line(observation: Sequence[float], mask: Sequence[int]) -> bytes:
    """What an agent is shown in a step.

    Nine digits tell every float32 apart, and are written three times as fast as all digits of the same double.
    """
    return (_view_form(len(observation)) % (*observation, mask)).encode()


def view_record(observation: Sequence[float], mask: Sequence[int]) -> bytes:
    """The same for our own runner of Python agents: how many numbers and choices, the numbers, the choices."""
    shape = len(observation), len(mask)
    return _record_form(*shape).pack(*shape, *observation, *mask)


def read_record(stream: BufferedReader) -> tuple[list[float], list[int]] | None:
    """The next view of that form; None at the end."""
    head = stream.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    width, choices = _HEAD.unpack(head)
    form = _record_form(width, choices)
    numbers = form.unpack(head + stream.read(form.size - _HEAD.size))
    return [*numbers[2 : 2 + width]], [*numbers[2 + width :]]


@cache
def _record_form(width: int, choices: int) -> Struct:
    return Struct(f"{_HEAD.format}{width}f{choices}B")


@cache
def _view_form(width: int) -> str:
    return '{"view":[' + ",".join(["%.9g"] * width) + '],"mask":%s}\n'


def action_line(action: object) -> bytes:
    """An agent's action; what JSON cannot say is sent as its text, which no control takes for an action."""
    try:
        return b'{"action":%s}\n' % json.dumps(plain_action(action), default=_plain).encode()
    except (TypeError, ValueError, RecursionError):
        return line(action=repr(type(action)))


def _plain(value: Any) -> Any:
    plain = as_python(value)
    return repr(value) if plain is value else plain


def send(channel: socket.socket, files: Sequence[int] = (), **message: Any) -> None:
    """Pass a message, with open files, to another process of ours."""
    content = line(**message)
    sent = socket.send_fds(channel, [content], list(files))
    channel.sendall(content[sent:])


def receive(channel: socket.socket) -> tuple[dict[str, Any], list[int]] | None:
    """The next message and its open files; None where the other side has gone. One is under way at a time."""
    content, files, _, _ = socket.recv_fds(channel, _PART, _MOST_FILES)
    while content and not content.endswith(b"\n"):
        part = channel.recv(_PART)
        if not part:
            return None
        content += part
    return (json.loads(content), files) if content else None

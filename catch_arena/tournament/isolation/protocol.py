"""Messages between a match and an isolated agent: lines of JSON (docs/howto/isolation.md).

Our own program speaks for Python agents. To it a view is written as a record of bytes, which is as exact, and takes
both sides a tenth of the time.
"""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from struct import Struct
from typing import Any, Final

from catch_arena.plain import as_python, plain_action
from catch_arena.policy import AnyLimits, Limits, PreyLimits, Side

VERSION: Final = 1
STARTED: Final = b'{"started":true}\n'
"""First line from each program, sent before it runs any code of an agent."""
_HEAD: Final = Struct("<HH")
PART: Final = 65536
"""Number of bytes that are read from a pipe at a time."""
END: Final = _HEAD.pack(0, 0)
"""Record that ends a match."""

_encoded: Final = json.JSONEncoder(separators=(",", ":")).encode


def line(**message: Any) -> bytes:
    """Return a message as one line."""
    return _encoded(message).encode() + b"\n"


def hello_line(side: Side) -> bytes:
    """Return the greeting, which asks an agent for its control and other facts."""
    return line(hello=VERSION, side=side)


def reset_line(seed: int, limits: AnyLimits) -> bytes:
    """Return the line that begins a match."""
    return line(reset={"seed": seed, "side": limits.side, "limits": asdict(limits)})


def limits_in(reset: dict[str, Any]) -> AnyLimits:
    """Return the limits in the message of `reset_line`."""
    return (PreyLimits if reset["side"] == "prey" else Limits)(**reset["limits"])


def view_line(observation: Sequence[float], mask: Sequence[int]) -> bytes:
    """Return a view as a line.

    Nine digits distinguish all float32 numbers, and are written three times as fast as all digits of the same double.
    """
    return (_view_form(len(observation)) % (*observation, mask)).encode()


def view_record(observation: Sequence[float], mask: Sequence[int]) -> bytes:
    """Return a view as a record: the two lengths, the numbers, the choices."""
    shape = len(observation), len(mask)
    return _record_form(*shape).pack(*shape, *observation, *mask)


def read_record(file: int) -> tuple[list[float], list[int]] | None:
    """Read the next view from a descriptor and return it; None at the end of a match or of the pipe.

    The other side writes one record and waits, so nothing follows the record.
    """
    record = os.read(file, PART)
    if len(record) < _HEAD.size or record == END:
        return None
    width, choices = _HEAD.unpack_from(record)
    form = _record_form(width, choices)
    while len(record) < form.size:
        record += os.read(file, PART)
    _, _, *numbers = form.unpack(record)
    return numbers[:width], numbers[width:]


@cache
def _record_form(width: int, choices: int) -> Struct:
    return Struct(f"{_HEAD.format}{width}f{choices}B")


@cache
def _view_form(width: int) -> str:
    return '{"view":[' + ",".join(["%.9g"] * width) + '],"mask":%s}\n'


def action_line(action: object) -> bytes:
    """Return an agent's action as a line; a value that JSON cannot express becomes text, which no control accepts."""
    try:
        return b'{"action":%s}\n' % json.dumps(plain_action(action), default=_plain).encode()
    except (TypeError, ValueError, RecursionError):
        return line(action=repr(type(action)))


def _plain(value: Any) -> Any:
    plain = as_python(value)
    return repr(value) if plain is value else plain

"""Messages between a match and an isolated agent: lines of JSON (docs/howto/isolation.md)."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Final

import msgspec

from catch_arena.plain import as_python, plain_action
from catch_arena.policy import AnyLimits, Limits, PreyLimits

VERSION: Final = 1
STARTED: Final = b'{"started":true}\n'
"""First line from each program, sent before it runs any code of an agent."""
END: Final = b'{"end":true}\n'
"""Line that ends a match, for our own program (agent_program.py); a command is ended instead."""
PART: Final = 65536
"""Number of bytes that are read from a pipe at a time."""


def line(**message: Any) -> bytes:
    """Return a message as one line."""
    return json.dumps(message, separators=(",", ":")).encode() + b"\n"


def reset_line(seed: int, limits: AnyLimits) -> bytes:
    """Return the line that begins a match."""
    return line(reset={"seed": seed, "side": limits.side, "limits": asdict(limits)})


def limits_in(reset: dict[str, Any]) -> AnyLimits:
    """Return the limits in the message of `reset_line`."""
    return (PreyLimits if reset["side"] == "prey" else Limits)(**reset["limits"])


def view_line(observation: Sequence[float], mask: Sequence[int]) -> bytes:
    """Return a view as a line."""
    return b'{"view":%b,"mask":%b}\n' % (msgspec.json.encode(observation), str(mask).encode())


def action_line(action: object) -> bytes:
    """Return an agent's action as a line; a value that JSON cannot express becomes text, which no control accepts."""
    try:
        if type(action) is int:  # usual actions need fewer calls
            return b'{"action":%d}\n' % action
        plain = action if type(action) is tuple else plain_action(action)
        return b'{"action":%s}\n' % _ENCODER.encode(plain).encode()
    except (TypeError, ValueError, RecursionError):
        return line(action=repr(type(action)))


def read_json(content: bytes) -> Any:
    """Return the value in a line; NaN, infinities and lone surrogates are read as Python writes them.

    A line that is not JSON raises ValueError or RecursionError.
    """
    try:
        return msgspec.json.decode(content)
    except ValueError:
        return json.loads(content)


def _plain(value: Any) -> Any:
    plain = as_python(value)
    return repr(value) if plain is value else plain


_ENCODER: Final = json.JSONEncoder(default=_plain)

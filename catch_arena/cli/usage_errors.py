"""Mistakes on the command line, in the words of our own errors."""

import re
from typing import Any

_NOT_ONE_OF = re.compile(r"(?:Value error, )?(?P<given>'.*') is not one of (?P<known>'.*')\.?", re.DOTALL)


def usage_error(error: Any) -> tuple[str, str | None]:
    """Return what is wrong with the command line, in one line, and the command whose help has the rest.

    Args:
        error: what typer has raised.
    """
    parameter, cause = getattr(error, "param", None), error.__cause__
    if parameter is None or not error.message:
        text = error.format_message()
        text = text[:1].lower() + text[1:].rstrip(".")
    else:
        name = max(parameter.opts, key=len) if parameter.param_type_name == "option" else parameter.metavar
        text = f"{name} {_wanted(error.message, cause)}"
    path = None if error.ctx is None else error.ctx.command_path
    return " ".join(text.split()), path


def _wanted(message: str, cause: Any) -> str:
    """Return the requirement and the value. Newer versions of typer check values by Pydantic, and quote its words."""
    if (choice := _NOT_ONE_OF.fullmatch(message)) is not None:
        return f"must be one of {choice['known'].replace(chr(39), '')}, got {choice['given']}"
    if cause is None or not hasattr(cause, "errors"):
        return f"cannot be read: {message.rstrip('.')}"
    (found, *_) = cause.errors()
    bounds = found.get("ctx", {})
    if "ge" in bounds or "le" in bounds:
        bound = f"at least {bounds['ge']}" if "ge" in bounds else f"at most {bounds['le']}"
        return f"must be {bound}, got {found['input']}"
    wanted = {"int": "a whole number", "float": "a number"}.get(found["type"].partition("_")[0], "another value")
    return f"must be {wanted}, got {found['input']!r}"

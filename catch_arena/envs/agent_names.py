"""Names of an env's agents."""

from collections.abc import Sequence
from contextlib import suppress

from catch_arena.errors import ConfigError
from catch_arena.plain import as_python
from catch_arena.text import shortened


def checked_agent_names(given: str | Sequence[str] | None, usual: list[str]) -> list[str]:
    """Return the names of an env's agents.

    Args:
        given: a pattern with {seat}, a list, or None.
        usual: the names if `given` is None.

    Raises:
        ConfigError: if the names are not different, or are not one for each agent.
    """
    if given is None:
        return usual
    names = as_python(given)
    if isinstance(given, str) and "{seat" in given:
        with suppress(ValueError, LookupError, AttributeError, TypeError):  # it is no pattern
            names = [given.format(seat=seat) for seat in range(len(usual))]
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) and name for name in names):
        pattern = 'a pattern such as "agent_{seat}" or "agent_{seat:02d}"'
        raise ConfigError(f"agent_names must be {pattern}, or a list of names, got {shortened(given)}")
    if not len(set(names)) == len(names) == len(usual):
        raise ConfigError(f"agent_names must be {len(usual)} different names, got {shortened(given)}")
    return list(names)

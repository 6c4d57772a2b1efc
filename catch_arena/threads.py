"""Threads that share the chunks of a batch; compiled code releases Python's global lock, so they run in parallel."""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache


def run_in_threads(num_threads: int, num_parts: int, work: Callable[[int, int], None]) -> None:
    """Call `work(thread, part)` for every part, in the caller's thread and in helpers that the whole process shares.

    There are at least two threads. Each free one takes the next part: a slow one then delays one part, and not a whole
    share. An error in any thread is raised here when all have ended.
    """
    numbers = itertools.count()

    def take_parts(thread: int) -> None:
        while (part := next(numbers)) < num_parts:
            work(thread, part)

    pool = _helpers(os.getpid(), num_threads - 1)
    helping = [pool.submit(take_parts, thread) for thread in range(1, num_threads)]
    try:
        take_parts(0)
    finally:
        wait(helping)
    for future in helping:
        future.result()


@cache
def _helpers(process: int, number: int) -> ThreadPoolExecutor:
    """Return this number of helpers for a process; a forked process has no threads of its parent."""
    del process
    return ThreadPoolExecutor(number, thread_name_prefix="catch-arena")

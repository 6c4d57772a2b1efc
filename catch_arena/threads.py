"""Threads that share the chunks of a batch; compiled code releases Python's global lock, so they run in parallel."""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait

Work = Callable[[int, int], None]
"""Function that does one part of the work; its arguments are the thread's index and the part's index."""


class Threads:
    """A team of threads, including the caller's, in which each free thread takes the next part of the work. A slow
    thread then delays one part, and not a whole share.

    Args:
        size: the number of threads, from 1; with 1, no thread is started.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self._pool: ThreadPoolExecutor | None = None
        self._process = 0

    def run(self, parts: int, work: Work) -> None:
        """Do `work` for every part from 0 to parts - 1; an error in any thread is raised here when all have ended."""
        helpers = min(self.size, parts) - 1
        if helpers < 1:
            for part in range(parts):
                work(0, part)
            return
        numbers = itertools.count()

        def take_parts(thread: int) -> None:
            while (part := next(numbers)) < parts:
                work(thread, part)

        pool = self._helpers()
        helping = [pool.submit(take_parts, thread) for thread in range(1, helpers + 1)]
        try:
            take_parts(0)
        finally:
            wait(helping)
        for future in helping:
            future.result()

    def close(self) -> None:
        """End the threads; the next `run` starts them again."""
        if self._pool is not None and self._process == os.getpid():
            self._pool.shutdown()
        self._pool = None

    def __reduce__(self) -> tuple[type["Threads"], tuple[int]]:
        """Copy and pickle the team without its running threads."""
        return Threads, (self.size,)

    def _helpers(self) -> ThreadPoolExecutor:
        if self._pool is None or self._process != os.getpid():  # a forked process has no threads of its parent
            self._pool = ThreadPoolExecutor(self.size - 1, thread_name_prefix="catch-arena")
            self._process = os.getpid()
        return self._pool

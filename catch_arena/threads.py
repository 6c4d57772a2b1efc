"""Threads that share the blocks of a batch; compiled code lets go of Python's lock, so that they run side by side."""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait

Work = Callable[[int, int], None]
"""What is done with one part: (which thread does it, which part)."""


class Threads:
    """A team of threads, this one among them, that take parts of the work as they come free: a thread that the
    machine holds up delays one part, not a whole share.

    Args:
        size: from 1 up; 1 starts no thread.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self._pool: ThreadPoolExecutor | None = None
        self._process = 0

    def run(self, parts: int, work: Work) -> None:
        """Do `work` for every part from 0 to parts - 1; what it raises in any thread is raised here, after all."""
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
        others = [pool.submit(take_parts, thread) for thread in range(1, helpers + 1)]
        try:
            take_parts(0)
        finally:
            wait(others)
        for other in others:
            other.result()

    def close(self) -> None:
        """End the threads that were started; the next `run` would start them again."""
        if self._pool is not None and self._process == os.getpid():
            self._pool.shutdown()
        self._pool = None

    def __reduce__(self) -> tuple[type["Threads"], tuple[int]]:
        """Copied and pickled without what runs."""
        return Threads, (self.size,)

    def _helpers(self) -> ThreadPoolExecutor:
        if self._pool is None or self._process != os.getpid():  # threads do not live on in a forked process
            self._pool = ThreadPoolExecutor(self.size - 1, thread_name_prefix="catch-arena")
            self._process = os.getpid()
        return self._pool

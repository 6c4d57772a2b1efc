"""Executor that uses Ray, with workers on this machine or on all machines of a cluster."""

import os
import platform
import signal
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import cache
from typing import Any, TypeVar

from catch_arena.engine import Engine
from catch_arena.errors import AgentError, CatchArenaError, ConfigError, MatchFailedError, install_hint, reason
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import versions

_Result = TypeVar("_Result")


class RayExecutor(Executor):
    """Executor with Ray's workers, one core each: `jobs` workers on this machine, or all cores of a cluster.

    The address of a running cluster is as `ray start --head` prints it, or "auto" on one of its machines.
    """

    def __init__(self, worker: Worker, jobs: int, address: str | None = None) -> None:
        super().__init__(worker)
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # the user has not agreed to them
        try:
            import ray
        except ImportError:
            raise ConfigError(f"executor ray needs Ray: {install_hint('ray')}") from None
        if address is None:
            Engine(worker.config)  # compiled once here, and read from the cache there
        before = signal.getsignal(signal.SIGTERM)
        try:
            ray.init(
                address=address or "local",
                num_cpus=jobs if address is None else None,
                include_dashboard=False if address is None else None,
                log_to_driver=False,
                logging_level="ERROR",
            )
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise ConfigError(
                f"address must be that of a running Ray cluster, got {address!r}: {reason(error)}"
            ) from None
        finally:
            with suppress(ValueError):  # Ray has installed its own handler, unless this is not the main thread
                signal.signal(signal.SIGTERM, before)
        self._ray = ray
        self.max_pending = 4 * int(ray.cluster_resources().get("CPU", 1))
        self._versions = tuple(versions().items())
        self._task = ray.remote(max_retries=0)(_run_there)  # block_queue plays lost blocks again

    def run(self, work: Callable[..., _Result], *arguments: Any) -> Future[_Result]:
        """Begin to call a function on one of the machines."""
        future: Future[_Result] = self._task.remote(self.worker, self._versions, work, *arguments).future()
        return future

    def result(self, future: Future[_Result]) -> _Result:
        """Return the result of submitted work; raise MatchFailedError if it failed on our side, or a worker was lost.

        Other agents or versions on the worker's machine raise another CatchArenaError.
        """
        try:
            return future.result()
        except self._ray.exceptions.RayTaskError as error:  # raised by our function
            raise (error.cause if isinstance(error.cause, CatchArenaError) else error) from None
        except self._ray.exceptions.RayError as error:
            raise MatchFailedError(f"a Ray worker was lost: {reason(error)}") from None

    def close(self) -> None:
        """End the Ray processes that were started here, and leave a cluster."""
        self._ray.shutdown()


def _run_there(
    worker: Worker, expected: tuple[tuple[str, str], ...], work: Callable[..., _Result], *arguments: Any
) -> _Result:
    require_same(worker, expected)
    return work(*arguments)


@cache
def require_same(worker: Worker, expected: tuple[tuple[str, str], ...]) -> None:
    """Raise an error unless agents and versions are those of the machine that began; each Ray process checks once."""
    here = versions()
    for name, wanted in expected:
        if here[name] != wanted:
            raise ConfigError(f"{name} must be {wanted} on every machine, got {here[name]} on {platform.node()}")
    for entrant in (one for one in worker.entrants if one.fault is None):
        (there,) = enter([entrant.spec], worker.sandbox)
        if there.fault is not None:
            raise AgentError(f"{entrant.name}: cannot begin on {platform.node()}: {there.fault}")
        if there.digest != entrant.digest:
            raise AgentError(
                f"{entrant.name}: digest must be {entrant.digest} on every machine, "
                f"got {there.digest} on {platform.node()}"
            )

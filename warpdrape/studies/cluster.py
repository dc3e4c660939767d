"""Who does the runs: processes of this machine, or the workers of a Dask scheduler somewhere."""

from __future__ import annotations

import asyncio
import logging
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from warpdrape.dynamics.cores import physical_cores
from warpdrape.errors import InputError, RunFailed
from warpdrape.optional import needed
from warpdrape.studies.forked import keepers, may_fork

if TYPE_CHECKING:
    from distributed import Client

CONNECT_S = 20
"""Longest wait for a scheduler's answer [s]."""
WORKERS_S = 120
"""Longest wait for workers that are made here: for all at first, for any later on [s]."""
LOOK_S = 5.0
"""How often it is looked whether any is there [s]."""
KEEPER_LOST = (
    "A process that kept a worker has died, and its worker with it: another is begun in its place, "
    "and goes on with what that was at."
)

_TALKERS = ("distributed", "tornado", "asyncio")
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.tick.cycle": "5s",
}
"""Dask's watching of its own processes, made rarer for those that are made here: by default it took
2.5 % of a core in each while it did nothing else, with these 0.3 %."""


@contextmanager
def connected(
    scheduler: str | None, workers: int | None, say: Callable[[str], None] = lambda _: None
) -> Iterator[Client]:
    """A client of a scheduler, or of one made here with its workers for the time being.

    Workers made here are processes that do one run each at a time, and end when this process does,
    even if that is killed.

    Args:
        scheduler: address, such as ``tcp://head:8786``; None to make one.
        workers: processes to make, None for one a core.
        say: takes a line of what has happened to workers made here; from another thread.

    Raises:
        InputError: if the extra is not installed, or nobody answers at the address.
        RunFailed: if workers made here do not come up, or are gone and no other does.
    """
    distributed = needed("distributed", "studies")
    for name in [*_TALKERS, *logging.root.manager.loggerDict]:
        if name.partition(".")[0] in _TALKERS:
            logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters is said here
    if scheduler is None:
        with _local(distributed, workers or physical_cores(), say) as client:
            yield client
        return
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        words = " ".join(str(error).split())
        raise InputError(
            f"--scheduler {scheduler}: no Dask scheduler answers there ({words}): start one with "
            "dask scheduler, and give the address that it shows"
        ) from error
    with client:
        yield client


@contextmanager
def _local(distributed: Any, workers: int, say: Callable[[str], None]) -> Iterator[Client]:
    import dask

    temporary = tempfile.TemporaryDirectory(prefix="warpdrape-study-", ignore_cleanup_errors=True)
    with dask.config.set(QUIET), temporary as place:
        if not may_fork():
            with (
                _cluster(distributed, workers, place) as cluster,
                distributed.Client(cluster, set_as_default=False) as client,
                _attended(cluster),
            ):
                yield client
            return

        def begin_another() -> None:
            say(KEEPER_LOST)
            cluster.scale(len(cluster.worker_spec) + 1)

        with (
            keepers(distributed, workers, place) as kept,
            _cluster(distributed, 0, place) as cluster,
            distributed.Client(cluster, set_as_default=False) as client,
            kept.watched(cluster.loop.asyncio_loop, begin_another),
            _attended(cluster),
        ):
            kept.tell(cluster.scheduler_address)
            _wait(client, workers)
            yield client


@contextmanager
def _attended(cluster: Any) -> Iterator[None]:
    """End the block when the cluster has had no worker for too long, where it would wait for ever.

    Raises:
        RunFailed: then, as its client waits in vain.
    """

    async def look() -> None:
        alone = 0.0
        while alone < WORKERS_S:
            await asyncio.sleep(LOOK_S)
            alone = 0.0 if cluster.scheduler.workers else alone + LOOK_S
        await cluster.scheduler.close()

    looking = asyncio.run_coroutine_threadsafe(look(), cluster.loop.asyncio_loop)
    try:
        yield
    except RunFailed as error:
        if not looking.done():
            raise
        raise RunFailed(
            f"all workers have died, and no other came up within {WORKERS_S:g} s: the machine may "
            "be short of memory; take fewer --workers"
        ) from error
    finally:
        looking.cancel()


def _wait(client: Client, workers: int) -> None:
    """Wait until workers that were forked answer."""
    try:
        client.wait_for_workers(workers, timeout=WORKERS_S)
    except TimeoutError as error:
        raise RunFailed(
            f"not all of {workers} workers answer within {WORKERS_S} s: the machine may be short "
            "of memory; take fewer --workers"
        ) from error


def _cluster(distributed: Any, workers: int, place: str) -> Any:
    return distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        dashboard_address="127.0.0.1:0",
        local_directory=place,
        silence_logs=logging.CRITICAL,
    )

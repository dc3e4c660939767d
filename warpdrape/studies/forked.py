"""Workers forked from this process: what it has loaded, libraries and kernels' sources, they have.

A worker that is started anew loads Python, Dask, Warp and warpdrape first, 1.5 s of processor time
in each. A fork has them, in some hundredths of a second. It is safe only beside no thread that
holds a lock: so each worker's keeper is forked before the scheduler's threads are made, and does
nothing but to fork its worker, again after each death, as Dask's nanny. Keepers and workers end
with this process, however that ends: they wait at a pipe whose other end it alone holds.
"""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

import warp as wp

GRACE_S = 5.0
"""What a run has to come to its end when the study ends before it, as Dask counts it [s]."""
PATIENCE_S = 20.0
"""How long after that a keeper may take before it is killed [s]."""


def may_fork() -> bool:
    """Whether a fork of this process is as good as a new one.

    Not beside other threads, which may hold locks that nobody in the fork would open; not once Warp
    has begun, whose hold on a graphics card no fork can use; not where the system's own libraries
    do not take it, as on macOS.
    """
    begun = wp._src.context.runtime is not None
    return sys.platform == "linux" and threading.active_count() == 1 and not begun


@contextmanager
def keepers(distributed: Any, count: int, place: str) -> Iterator[Any]:
    """Fork keepers, which wait; gives what tells them the scheduler's address.

    Args:
        distributed: the package.
        count: of workers, each with a keeper.
        place: folder for Dask's own files.
    """
    fork = multiprocessing.get_context("fork")
    lines: list[Connection] = []
    kept: list[Any] = []
    memory = int(distributed.system.MEMORY_LIMIT / count)

    def call(address: str) -> None:
        for line in lines:
            line.send(address)

    try:
        for number in range(count):
            ear, line = fork.Pipe(duplex=False)
            lines.append(line)
            known = (distributed, ear, tuple(lines), place, memory)
            keeper = fork.Process(target=_keep, args=known, name=f"warpdrape-keeper-{number}")
            keeper.start()
            kept.append(keeper)
            ear.close()
        yield call
    finally:
        for line in lines:
            try:
                line.send("")
            except OSError:  # it is gone already
                pass
            line.close()
        for keeper in kept:
            keeper.join(GRACE_S + PATIENCE_S)
            if keeper.is_alive():
                keeper.kill()
                keeper.join()


def _keep(
    distributed: Any, ear: Connection, lines: Sequence[Connection], place: str, memory: int
) -> None:
    """Keep a worker alive until told to end it, or the study's process is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C goes to all; the study says what ends
    for line in lines:  # else none would hear that the study's process is gone
        line.close()
    try:
        address = ear.recv()
    except EOFError:
        os._exit(1)
    if address:
        asyncio.run(_kept(distributed, ear, address, place, memory))


async def _kept(distributed: Any, ear: Connection, address: str, place: str, memory: int) -> None:
    import dask

    told = asyncio.Event()
    asyncio.get_running_loop().add_reader(ear.fileno(), told.set)
    with dask.config.set({"distributed.worker.multiprocessing-method": "fork"}):
        nanny = await distributed.Nanny(
            address,
            nthreads=1,
            local_directory=place,
            memory_limit=memory,
            silence_logs=logging.CRITICAL,
        )
        await told.wait()
        try:
            ear.recv()
        except EOFError:
            os._exit(1)  # and with this process its worker
        await nanny.close(timeout=GRACE_S)

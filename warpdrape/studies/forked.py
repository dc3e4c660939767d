"""Workers forked from this process: what it has loaded, libraries and kernels' sources, they have.

A worker that is started anew loads Python, Dask, Warp and warpdrape first, 1.5 s of processor time
in each. A fork has them, in some hundredths of a second. It is safe only beside no thread that
holds a lock: so each worker's keeper is forked before the scheduler's threads are made, and does
nothing but to fork its worker, again after each death, as Dask's nanny. Keepers and workers end
with this process, however that ends: they wait at a pipe whose other end it alone holds. A worker
whose keeper has died ends too; this process notices, and another has to be begun anew then, as
threads are there.
"""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import os
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import warp as wp

GRACE_S = 5.0
"""What a run has to come to its end when the study ends before it, as Dask counts it [s]."""
PATIENCE_S = 20.0
"""How long after that a keeper may take before it is killed [s]."""


MAPPED = Path("/proc/self/maps")
"""What this process has loaded, as Linux tells."""


def may_fork() -> bool:
    """Whether a fork of this process is as good as a new one.

    Not beside other threads, which may hold locks that nobody in the fork would open; not once Warp
    has begun, or anything else that holds a graphics card, as no fork can use such a hold; not
    where the system's own libraries do not take it, as on macOS.
    """
    return sys.platform == "linux" and threading.active_count() == 1 and not _begun()


def _begun() -> bool:
    """Whether Warp or a graphics card's driver is loaded; yes where that is not known.

    Warp loads its own library as it begins. Which libraries are loaded the system tells, whatever
    the version of Warp: one that loads it at once has workers begun anew, as on other systems.
    """
    try:
        mapped = MAPPED.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return True
    own = os.path.join(os.path.dirname(os.path.realpath(wp.__file__)), "")
    return own in mapped or "/libcuda.so" in mapped


@dataclass(frozen=True, eq=False)
class Keepers:
    """Processes that each keep a worker, once they know where its scheduler is.

    Attributes:
        lines: to each, what it is told.
        processes: themselves.
    """

    lines: list[Connection] = field(default_factory=list)
    processes: list[Any] = field(default_factory=list)

    def tell(self, words: str) -> None:
        """Tell the scheduler's address, or that it is over; who is gone already hears nothing."""
        for line in self.lines:
            with suppress(OSError):
                line.send(words)

    @contextmanager
    def watched(self, loop: asyncio.AbstractEventLoop, lost: Callable[[], None]) -> Iterator[None]:
        """Have ``lost`` called for each that ends within the block, by a loop of another thread."""

        def begin() -> None:
            for keeper in self.processes:
                loop.add_reader(keeper.sentinel, ended, keeper.sentinel)

        def ended(sentinel: int) -> None:
            loop.remove_reader(sentinel)
            lost()

        def end() -> None:
            for keeper in self.processes:
                loop.remove_reader(keeper.sentinel)

        loop.call_soon_threadsafe(begin)
        try:
            yield
        finally:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(end)


@contextmanager
def keepers(distributed: Any, count: int, place: str) -> Iterator[Keepers]:
    """Fork keepers, which wait until they are told the scheduler's address.

    Args:
        distributed: the package.
        count: of workers, each with a keeper.
        place: folder for Dask's own files.
    """
    fork = multiprocessing.get_context("fork")
    made = Keepers()
    memory = int(distributed.system.MEMORY_LIMIT / count)
    try:
        for number in range(count):
            ear, line = fork.Pipe(duplex=False)
            made.lines.append(line)
            known = (distributed, ear, tuple(made.lines), place, memory)
            keeper = fork.Process(target=_keep, args=known, name=f"warpdrape-keeper-{number}")
            keeper.start()
            made.processes.append(keeper)
            ear.close()
        yield made
    finally:
        made.tell("")
        for line in made.lines:
            line.close()
        for keeper in made.processes:
            keeper.join(GRACE_S + PATIENCE_S)
            if keeper.is_alive():
                keeper.kill()
                keeper.join()


def _keep(
    distributed: Any, ear: Connection, lines: Sequence[Connection], place: str, memory: int
) -> None:
    """Keep a worker alive until told to end it, or the study's process is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C goes to all; the study says what ends
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)  # what the study does then is not for its forks
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
        waits = {asyncio.ensure_future(told.wait()), asyncio.ensure_future(nanny.finished())}
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        if not told.is_set():
            os._exit(1)  # its worker is gone for good, and the study is to notice
        try:
            ear.recv()
        except EOFError:
            shutil.rmtree(place, ignore_errors=True)  # who made it cannot
            os._exit(1)  # and with this process its worker
        await nanny.close(timeout=GRACE_S)

"""Threads that compute the parts of a model together.

Replaying a captured graph releases the interpreter's lock, and the parts wait for each other inside
their graphs. Where the system has given a part's core to another process all others wait, so that
`warpdrape.dynamics.pace` chooses; the parts one after another give the same results to the bit.
"""

from __future__ import annotations

import ctypes
import sys
import threading
from collections.abc import Callable, Sequence
from queue import SimpleQueue

import warp as wp

from warpdrape.dynamics.cores import physical_cores
from warpdrape.errors import InputError, said
from warpdrape.kernels.dynamics.parts import LINE, await_parts
from warpdrape.state import MOST_PARTS

SPINS = 1000
"""Looks at a counter before the core is offered to others at each: some 20 µs."""
LEAST_TRIANGLES = 5000
"""Triangles that each thread has at least, by default: below, waiting eats what it gains."""
MOST_THREADS = 8
"""Threads at most, by default: every vertex adds up what all of them have scattered."""


class Barrier:
    """Where the parts wait for each other, by launches inside their graphs."""

    def __init__(self, parts: int) -> None:
        """Make the counters of so many parts."""
        self._parts = parts
        self._arrived = wp.zeros((parts + 1) * LINE, dtype=wp.int32, device="cpu")
        self._give_way = _address_of_yield()

    def launch(self, part: int) -> None:
        """Launch, or capture, the waiting of one part for all others."""
        inputs = [part, self._parts, SPINS, self._give_way]
        wp.launch(await_parts, 1, inputs=inputs, outputs=[self._arrived], device="cpu")

    def reset(self) -> None:
        """Count from zero again; for a time when no part is at work."""
        self._arrived.zero_()

    def release(self) -> None:
        """Let nobody wait any more: one of the parts will not come."""
        self._arrived.numpy()[self._parts * LINE] = 1


def _address_of_yield() -> int:
    """Address of the system's function by which a thread offers its core to others; 0 if none."""
    try:
        if sys.platform == "win32":
            give_way = ctypes.windll.kernel32.SwitchToThread
        else:
            give_way = ctypes.CDLL(None).sched_yield
        return ctypes.cast(give_way, ctypes.c_void_p).value or 0
    except (OSError, AttributeError):
        return 0


class Crew:
    """Threads that each have one job, done again and again; the first is the caller's own."""

    def __init__(self, jobs: Sequence[Callable[[], None]], release: Callable[[], None]) -> None:
        """Start a thread for every job but the first.

        Args:
            jobs: what each does.
            release: makes jobs that wait for each other go on, should one of them fail.
        """
        self._jobs, self._release = jobs, release
        self._orders: list[SimpleQueue[bool]] = [SimpleQueue() for _ in jobs[1:]]
        self._reports: SimpleQueue[BaseException | None] = SimpleQueue()
        self._threads = [
            threading.Thread(target=self._work, args=work, daemon=True)
            for work in zip(jobs[1:], self._orders, strict=True)
        ]
        for thread in self._threads:
            thread.start()

    def run(self) -> None:
        """Do every job once, all at the same time; raise what one of them raised."""
        ordered = 0
        try:
            for orders in self._orders:
                orders.put(True)
                ordered += 1
            self._jobs[0]()
        except BaseException:
            self._release()
            raise
        finally:
            reports = [self._reports.get() for _ in range(ordered)]
        for error in reports:
            if error is not None:
                raise error

    def close(self) -> None:
        """End the threads."""
        self._release()
        for orders in self._orders:
            orders.put(False)
        for thread in self._threads:
            thread.join()

    def _work(self, job: Callable[[], None], orders: SimpleQueue[bool]) -> None:
        while orders.get():
            error: BaseException | None = None
            try:
                job()
            except BaseException as fault:  # raised anew where the run is
                error = fault
                self._release()
            self._reports.put(error)


def choose_threads(threads: int | None, device: str, triangles: int) -> int:
    """Threads of a run: those asked for, or one per physical core where the model is large.

    Raises:
        InputError: if they are no whole number above zero, or the device has none.
    """
    if threads is None:
        if device != "cpu":
            return 1
        return max(1, min(physical_cores(), MOST_THREADS, triangles // LEAST_TRIANGLES))
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise InputError(f"threads = {said(threads)} must be a whole number, 1 or more")
    if threads > MOST_PARTS:  # up to them, more than cores compute the same, one after another
        raise InputError(
            f"threads = {threads} must not exceed {MOST_PARTS}: give the number of cores"
        )
    if threads > 1 and device != "cpu":
        raise InputError(f"threads = {threads} are for device 'cpu'; leave them out for {device!r}")
    return threads

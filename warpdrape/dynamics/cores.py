"""The cores that a run may use, and whether other programs leave enough of them for its threads."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import psutil

WINDOW = 0.25
"""Time over which idleness is measured [s]: systems count it in ticks of some 10 ms."""
ENOUGH = 0.6
"""Share of the cores that further threads need which others must leave [-]: two threads beside less
compute no faster than one."""
PLAUSIBLE = 0.5
"""Share of the time that has passed which the system must account for, to be believed [-]."""


class Look(NamedTuple):
    """What counters of processor time show at a moment [s]."""

    now: float
    idle: float
    """Summed over the logical cores that this process may use."""
    counted: float
    """Whatever they did, likewise."""
    own: float
    """Of this process."""


class SpareCores:
    """Whether other programs leave cores for more than one thread, in windows of time.

    Enough is no proof that threads will pay: a container may be granted less time than its cores
    have, and other programs come and go.
    """

    def __init__(
        self,
        threads: int,
        look: Callable[[], Look | None] | None = None,
        clock: Callable[[], float] = time.perf_counter,
        counts: tuple[int, int] | None = None,
    ) -> None:
        """Begin the first window.

        Args:
            threads: that are to have a core each, as far as there are cores.
            look: reads the counters, or gives None where the system has none; by default those of
                this machine.
            clock: time [s], that of ``look``.
            counts: physical and logical cores; by default those that this process may use.
        """
        allowed = allowed_cores()
        self._look, self._clock = look or partial(look_at, allowed), clock
        self._cores, self._logical = counts or (cores_there(), len(allowed))
        self._needed = ENOUGH * (min(threads, self._cores) - 1)
        self.restart()

    def restart(self) -> None:
        """Begin a window anew, and forget what was seen before."""
        self._start = self._look()
        self._enough: bool | None = None if self._start is None else False

    def enough(self) -> bool | None:
        """Whether there were cores to spare over the last whole window, or None if none can know.

        While a first window lasts there are none; short blocks do not look each time.
        """
        if self._start is None or self._clock() - self._start.now < WINDOW:
            return self._enough
        start, end = self._start, self._look()
        self._start = end
        spare = None if end is None else self._spare(start, end)
        self._enough = None if spare is None else spare >= self._needed
        return self._enough

    def _spare(self, start: Look, end: Look) -> float | None:
        """Cores that neither others nor one thread of ours need, on average; None if not known."""
        passed = end.now - start.now
        if end.counted - start.counted < PLAUSIBLE * self._logical * passed:
            return None
        busy = self._logical - (end.idle - start.idle) / passed
        others = busy - (end.own - start.own) / passed
        return self._cores - 1 - max(others, 0.0)


def look_at(allowed: list[int]) -> Look | None:
    """Read the counters of some logical cores; None where the system does not give them."""
    now, own = time.perf_counter(), time.process_time()
    try:
        cores = psutil.cpu_times(percpu=True)
        those = [cores[number] for number in allowed]
        idle = sum(core.idle + getattr(core, "iowait", 0.0) for core in those)
    except (psutil.Error, OSError, RuntimeError, LookupError, AttributeError):
        return None
    return Look(now, idle, sum(map(sum, those)), own)


def allowed_cores() -> list[int]:
    """Numbers of the logical cores that this process may use."""
    try:
        return sorted(psutil.Process().cpu_affinity())
    except (psutil.Error, OSError, AttributeError):  # not every system has it
        return list(range(os.cpu_count() or 1))


def physical_cores() -> int:
    """Cores that this process may use, those that share their hardware counted once."""
    known = _by_siblings()
    if known is not None:
        return known
    return max(1, (os.cpu_count() or 1) // 2)  # not Linux: count on two threads a core


def cores_there() -> int:
    """Likewise, where slow cores beside fast ones count too, though a run shall not use them."""
    return _by_siblings() or psutil.cpu_count(logical=False) or physical_cores()


def _by_siblings() -> int | None:
    """Likewise, as Linux tells; None elsewhere."""
    try:
        logical = os.sched_getaffinity(0)
    except AttributeError:
        return None
    folder = "/sys/devices/system/cpu/cpu{}/topology/thread_siblings_list"
    try:
        return len({Path(folder.format(k)).read_text() for k in logical})
    except OSError:
        return len(logical)

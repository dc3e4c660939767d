"""When the parts of a model are computed on threads, and when one after another on one thread."""

from __future__ import annotations

import math
from collections import deque
from typing import Protocol

RECENT = 4
"""Blocks of each way over whose times a mean is taken."""
FIRST = 2
"""Blocks alone before threads are tried."""
GAIN = 0.95
"""Time with threads over the time with one from which threads are worth their cores [-]."""
CHECKS = ((1.2, 8), (1.5, 24), (math.inf, 60))
"""Up to which ratio of the times alone and with threads, while threads pay, a block is computed
alone again after how many: an even choice costs little to check, and a clear one rarely changes."""
WAIT, LONGEST = 8, 64
"""Blocks alone after a trial that failed, twice as many after each further one, and at most."""


class Spare(Protocol):
    """What `Pace` asks about cores: see `warpdrape.dynamics.cores.SpareCores`."""

    def enough(self) -> bool | None:
        """Whether others leave cores for threads; None if none can know."""

    def restart(self) -> None:
        """Forget what was seen."""


class Pace:
    """Chooses block by block: threads are tried where cores stand idle, and judged by the clock.

    A trial beside a program that has taken a core is slow, so that it looks first. What it sees is
    no proof, so that trials that fail all the same become rare. Where the system tells nothing,
    trials alone decide.
    """

    def __init__(self, spare: Spare) -> None:
        """Begin with one block alone that does not count, as it is the first to touch memory."""
        self.together = False
        self._spare = spare
        self._warm = self._pays = False
        self._alone: deque[float] = deque(maxlen=RECENT)
        self._threads: deque[float] = deque(maxlen=RECENT)
        self._row = self._failed = 0

    def took(self, seconds: float) -> None:
        """Note the wall time of the block just done, and choose for the next one."""
        if not self._warm:
            self._warm = True
            return
        (self._threads if self.together else self._alone).append(seconds)
        self._row += 1
        paid = self._pays
        if self.together or paid:
            self._pays = self._ratio() * GAIN > 1.0
        if self.together:
            self._count_failures()
        if paid and not self._pays:
            self._spare.restart()
        chosen = not self._check_is_due() if self._pays else self._trial_is_due()
        if chosen != self.together:
            self._row = 0
            if chosen and not self._pays:
                self._threads.clear()
        self.together = chosen

    def _ratio(self) -> float:
        """Time of recent blocks alone over that of those with threads; 0 before there are both."""
        if not self._alone or not self._threads:
            return 0.0
        alone, threads = (math.fsum(t) / len(t) for t in (self._alone, self._threads))
        return alone / max(threads, 1e-12)

    def _count_failures(self) -> None:
        """Count trials in a row that ended before a few blocks were done."""
        if len(self._threads) == RECENT:
            self._failed = 0
        elif not self._pays:
            self._failed += 1

    def _check_is_due(self) -> bool:
        """Whether to compute a block alone though threads pay."""
        ratio = self._ratio()
        return self._row >= next(blocks for most, blocks in CHECKS if ratio < most)

    def _trial_is_due(self) -> bool:
        """Whether to compute a block with threads though they do not pay, as far as is known."""
        if len(self._alone) < FIRST or self.together:
            return False
        wait = min(WAIT * 2 ** (self._failed - 1), LONGEST) if self._failed else 0
        return self._spare.enough() is not False and self._row >= wait

"""How far a run is: a bar on a terminal, a plain line every few seconds elsewhere."""

from __future__ import annotations

import shutil
import sys
import time
from collections import deque
from collections.abc import Callable
from typing import TextIO

LINE_EVERY_S = 5.0
"""Seconds between plain lines, where the stream is no terminal."""
DRAW_EVERY_S = 0.1
"""Seconds between drawings of the bar."""
WINDOW_S = 30.0
"""Seconds of the past from which the speed is taken: contact makes a run slower as it goes."""
NOTE_EVERY_S = 0.05
"""Least seconds between two notes of the time reached, from which the speed is taken."""
_BAR_CELLS = 24


class Progress:
    """Report the progress of one run; a context manager.

    Args:
        total_s: simulated time of the whole run [s].
        stream: where to write; standard error when None.
        quiet: write nothing.
        begun: simulated time [s] and steps from which a run goes on.
        clock: the wall clock [s].
    """

    def __init__(
        self,
        total_s: float,
        stream: TextIO | None = None,
        quiet: bool = False,
        *,
        begun: tuple[float, int] = (0.0, 0),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._total_s = total_s
        self._stream = sys.stderr if stream is None else stream
        self._quiet = quiet
        self._clock = clock
        self._bar = self._stream.isatty()
        self._start = self._shown = clock()
        self._simulated_s = begun[0]
        self._steps: int | None = None
        self._text = ""
        self._drawn = 0
        self._past = deque([(self._start, *begun)])

    def say(self, text: str) -> None:
        """Write a line of its own, before the first update."""
        if not self._quiet:
            self._stream.write(text + "\n")
            self._stream.flush()

    def update(self, simulated_s: float, text: str = "", *, steps: int | None = None) -> None:
        """Take note of the time reached, and show it when it is due.

        Args:
            simulated_s: simulated time so far [s].
            text: a few words to add, such as the largest shear angle.
            steps: time steps so far; shown as a rate.
        """
        if self._quiet:
            return
        now = self._clock()
        self._simulated_s, self._text, self._steps = simulated_s, text, steps
        if len(self._past) < 2 or now - self._past[-1][0] >= NOTE_EVERY_S:
            self._past.append((now, simulated_s, steps or 0))
        while len(self._past) > 2 and self._past[1][0] <= now - WINDOW_S:
            self._past.popleft()
        if now - self._shown >= (DRAW_EVERY_S if self._bar else LINE_EVERY_S):
            self._shown = now
            self._show(self._line(now))

    def close(self) -> None:
        """Write the last line: time reached and time taken."""
        if self._quiet:
            return
        taken = in_words(self._clock() - self._start)
        self._show(f"{self._percent()} {self._simulated()} in {taken}{self._suffix()}")
        if self._bar:
            self._stream.write("\n")
            self._stream.flush()
        self._quiet = True

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _line(self, now: float) -> str:
        then, simulated_s, steps = self._past[0]
        seconds, gained = now - then, self._simulated_s - simulated_s
        parts = [f"{self._percent()} {self._simulated()}"]
        if self._steps is not None and seconds > 0.0:
            parts.append(f"{(self._steps - steps) / seconds:,.0f} steps/s")
        if gained > 0.0:
            left = max(self._total_s - self._simulated_s, 0.0) * seconds / gained
            parts.append(f"{in_words(left)} left")
        return ", ".join(parts) + self._suffix()

    def _show(self, line: str) -> None:
        if not self._bar:
            self._stream.write(line + "\n")
        else:
            done = round(self._fraction() * _BAR_CELLS)
            line = f"[{'#' * done}{'.' * (_BAR_CELLS - done)}] {line}"
            line = line[: shutil.get_terminal_size().columns - 1]
            self._stream.write("\r" + line.ljust(self._drawn))
            self._drawn = len(line)
        self._stream.flush()

    def _fraction(self) -> float:
        return min(self._simulated_s / self._total_s, 1.0) if self._total_s > 0.0 else 1.0

    def _percent(self) -> str:
        return f"{int(100.0 * self._fraction() + 1e-9):3d} %"

    def _simulated(self) -> str:
        return f"{1e3 * self._simulated_s:.1f} of {1e3 * self._total_s:.1f} ms"

    def _suffix(self) -> str:
        return f", {self._text}" if self._text else ""


def in_words(seconds: float) -> str:
    """Return ``seconds`` as a person says it: 8 s, 3 min 05 s, 2 h 10 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"

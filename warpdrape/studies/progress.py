"""How far a study is: runs done and failed, and the time left."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable
from typing import TextIO

from warpdrape.results.progress import LINE_EVERY_S, in_words


class StudyProgress:
    """Reports runs as they end: a line that changes on a terminal, plain lines elsewhere.

    Args:
        total: runs of the study.
        done: of those, how many had ended before.
        failed: of those, how many not well.
        quiet: write nothing.
        stream: where to write; standard error when None.
        clock: the wall clock [s].
    """

    def __init__(
        self,
        total: int,
        done: int,
        failed: int = 0,
        *,
        quiet: bool = False,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._total, self._before, self._quiet = total, done, quiet
        self._stream = sys.stderr if stream is None else stream
        self._clock = clock
        self._bar = self._stream.isatty()
        self._start = self._shown = clock()
        self._done, self._failed, self._drawn = done, failed, 0

    def say(self, text: str) -> None:
        """Write a line of its own."""
        if not self._quiet:
            self._clear()
            self._stream.write(text + "\n")
            self._stream.flush()

    def ended(self, *, well: bool, why: str = "") -> None:
        """Take note of a run that has ended.

        Args:
            well: whether it completed.
            why: a line to show if not.
        """
        self._done += 1
        self._failed += not well
        if why:
            self.say(why)
        now = self._clock()
        if self._bar or now - self._shown >= LINE_EVERY_S or self._done == self._total:
            self._shown = now
            self._show(self.line())

    def line(self) -> str:
        """Runs that have ended, and the time left."""
        words = f"{self._done} of {self._total} runs"
        if self._failed:
            words += f", {self._failed} failed"
        taken, here = self._clock() - self._start, self._done - self._before
        if self._done == self._total:
            return f"{words}, in {in_words(taken)}"
        if here:
            words += f", {in_words(taken * (self._total - self._done) / here)} left"
        return words

    def close(self) -> None:
        """End the line that changes."""
        if self._bar and self._drawn and not self._quiet:
            self._stream.write("\n")
            self._stream.flush()

    def _show(self, line: str) -> None:
        if self._quiet:
            return
        if self._bar:
            line = line[: shutil.get_terminal_size().columns - 1]
            self._stream.write("\r" + line.ljust(self._drawn))
            self._drawn = len(line)
        else:
            self._stream.write(line + "\n")
        self._stream.flush()

    def _clear(self) -> None:
        if self._bar and self._drawn:
            self._stream.write("\r" + " " * self._drawn + "\r")
            self._drawn = 0

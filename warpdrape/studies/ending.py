"""SIGTERM and SIGHUP end a study as Ctrl-C does: with a report of what there is."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from warpdrape.stops import WORDS

_SIGNALS = ("SIGTERM", "SIGHUP")
"""Of a queue of jobs that takes its machine back, and of a terminal that is closed."""


@contextmanager
def ends_as_interrupted() -> Iterator[None]:
    """Raise `KeyboardInterrupt` with the reason when asked to end within the block.

    What another handler has, or nohup has switched off, is left alone, as it all is outside the
    main thread.
    """

    def interrupt(number: int, _: FrameType | None) -> None:
        raise KeyboardInterrupt(WORDS[signal.Signals(number).name])

    taken = []
    for name in _SIGNALS:
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is None or signal.getsignal(number) is not signal.SIG_DFL:
            continue
        try:
            signal.signal(number, interrupt)
        except ValueError:  # not the main thread
            break
        taken.append(number)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)

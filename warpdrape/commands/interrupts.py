"""Ctrl-C while libraries are imported: kept until they are there, as some of them swallow it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interrupt_kept() -> Iterator[None]:
    """Keep a Ctrl-C to the end of the block; a second one does not wait.

    trimesh catches KeyboardInterrupt round its optional imports, and usd-core drops it in native
    code; a run that is told to stop while it imports them would go on.
    """
    came: list[int] = []

    def keep(number: int, _: FrameType | None) -> None:
        if came:
            raise KeyboardInterrupt
        came.append(number)

    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield  # someone else's business, or none's, as under nohup
        return
    try:
        signal.signal(signal.SIGINT, keep)
    except ValueError:  # not the main thread: none comes here
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if came:
        raise KeyboardInterrupt

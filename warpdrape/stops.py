"""Signals that ask a run to end: it ends between two blocks of steps, with all it has."""

from __future__ import annotations

import signal
from collections.abc import Callable
from types import FrameType
from typing import Any

from warpdrape.errors import RunFailed

WORDS = {
    "SIGINT": "interrupted by the user",
    "SIGTERM": "asked to end by SIGTERM",
    "SIGHUP": "asked to end by SIGHUP, as its terminal was closed",
}
"""Why a run ends, by the signal."""


def asked_to_end(message: str) -> bool:
    """Whether a run ended as a signal asked it to, by the message of its summary."""
    return message in WORDS.values()


class Stops:
    """Takes note of SIGINT, SIGTERM and SIGHUP; a context manager.

    A second one does not wait. What another handler has, or nohup has switched off, is left alone,
    as it all is outside the main thread.
    """

    def __init__(self) -> None:
        """Nothing asked."""
        self._asked = ""
        self._before: dict[int, Callable[[int, FrameType | None], Any] | int | None] = {}

    @property
    def asked(self) -> bool:
        """Whether the run is to end."""
        return bool(self._asked)

    def check(self) -> None:
        """Raise `RunFailed` if the run is to end."""
        if self._asked:
            raise RunFailed(WORDS[self._asked])

    def __enter__(self) -> Stops:
        for name in WORDS:
            number = getattr(signal, name, None)  # Windows has no SIGHUP
            if number is None:
                continue
            default = signal.SIG_DFL if name != "SIGINT" else signal.default_int_handler
            if signal.getsignal(number) is not default:
                continue
            try:
                self._before[number] = signal.signal(number, self._note)
            except ValueError:  # not the main thread
                break
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()

    def _note(self, number: int, _: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = signal.Signals(number).name

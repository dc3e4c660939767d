"""How often a run keeps a checkpoint: every so many frames or seconds, or whenever it is cheap."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from warpdrape.errors import InputError, said

SHARE = 0.01
"""Share of a run's time that its checkpoints take at most, where nothing is asked [-]."""
_ASKED = re.compile(r"(\d+(?:\.\d*)?) ?(s|min|h|frames?)?")
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}


@dataclass(frozen=True)
class Cadence:
    """When a checkpoint is due, at a frame or between two blocks of steps.

    Attributes:
        frames: from one to the next, all of them at frames; None for any.
        seconds: likewise [s].
        share: most of the time that they may take [-], None for any.
    """

    frames: int | None = None
    seconds: float | None = None
    share: float | None = None

    def due(self, frame: int | None, since: float, cost: float) -> bool:
        """Whether one is due.

        Args:
            frame: number of the one just recorded, None between frames.
            since: time since the last one [s], infinite before the first.
            cost: what that took [s].
        """
        if self.frames is not None:
            return frame is not None and (frame % self.frames == 0 or math.isinf(since))
        if self.seconds is not None:
            return since >= self.seconds
        return self.share is not None and since * self.share >= cost


def read_cadence(asked: str | int) -> Cadence | None:
    """Read "auto", "none", a number of frames such as "5", or a time such as "60s"; None for none.

    Raises:
        InputError: if it is none of these.
    """
    text = str(asked).strip()
    if text == "none":
        return None
    if text == "auto":
        return Cadence(share=SHARE)
    found = None if isinstance(asked, bool | float) else _ASKED.fullmatch(text)
    if found and found[2] in _SECONDS:
        return Cadence(seconds=float(found[1]) * _SECONDS[found[2]])
    if found and "." not in found[1] and int(found[1]) > 0:
        return Cadence(frames=int(found[1]))
    raise InputError(
        f"checkpoint = {said(asked)} must be frames such as 5, a time such as 60s, auto, or none"
    )

"""Slopes as differences of runs: by which steps, and when two of them agree."""

from __future__ import annotations

from typing import Any

import numpy as np

STEP = 0.05
"""Of the central difference, over the axis [-]; the other one is half of it."""
AGREE = 0.25
"""Share of the larger slope by which both may differ to be trusted [-]."""


def agree(wide: Any, narrow: Any, least: Any = 0.0) -> Any:
    """Whether slopes by both steps are one, number by number; not where one is missing.

    Args:
        wide: by the larger step.
        narrow: by half of it, in the same unit.
        least: slope that matters: smaller ones count as this large.
    """
    larger = np.maximum(np.maximum(np.abs(wide), np.abs(narrow)), least)
    return np.abs(np.subtract(wide, narrow)) <= AGREE * larger

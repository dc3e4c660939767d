"""A matplotlib figure that shows itself in a notebook, whether or not pyplot is in use there."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as PlainFigure

NOTEBOOK_DPI = 80
"""Pixels per inch of a figure in a notebook."""


class Figure(PlainFigure):
    """A figure that no window or global state holds."""

    def __init__(self, **options: Any) -> None:
        """Options as those of matplotlib's figure."""
        super().__init__(**options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=NOTEBOOK_DPI, facecolor="white")
        return file.getvalue()

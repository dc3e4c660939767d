"""What every kind of tool takes besides its shape."""

from __future__ import annotations

from typing import TypedDict

from warpdrape.materials.friction import Friction
from warpdrape.tools.floating import Motion
from warpdrape.tools.turn import Turn


class ToolOptions(TypedDict, total=False):
    """Fields of `warpdrape.Tool` that its shapes leave to whoever makes one; described there."""

    motion: Motion
    friction: float | Friction | None
    turn: Turn | None
    temperature: float | None

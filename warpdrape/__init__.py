"""Forming simulation of woven composite reinforcements on NVIDIA Warp."""

from pathlib import Path as _FilePath

import warp as _wp

_wp.config.log_level = _wp.LOG_ERROR
_here = _FilePath(__file__).resolve().parent
if not (_here / "kernels").is_dir():  # a checkout: kernels/ and scenes/ lie beside warpdrape/
    __path__.append(str(_here.parent))

from warpdrape import units  # noqa: E402
from warpdrape.errors import InputError, RunFailed  # noqa: E402
from warpdrape.fabric import Fabric  # noqa: E402
from warpdrape.motion import Float, Path, Still, Stroke  # noqa: E402
from warpdrape.ply import Ply, lay_up, stack_top  # noqa: E402
from warpdrape.result import Result  # noqa: E402
from warpdrape.scene import Clamp, Numerics, Scene  # noqa: E402
from warpdrape.tool import Tool  # noqa: E402

__all__ = [
    "Clamp",
    "Fabric",
    "Float",
    "InputError",
    "Numerics",
    "Path",
    "Ply",
    "Result",
    "RunFailed",
    "Scene",
    "Still",
    "Stroke",
    "Tool",
    "lay_up",
    "stack_top",
    "units",
]

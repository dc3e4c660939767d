"""Forming simulation of woven composite reinforcements on NVIDIA Warp."""

from importlib import import_module as _import_module
from pathlib import Path as _FilePath
from typing import TYPE_CHECKING

_here = _FilePath(__file__).resolve().parent
if not (_here / "kernels").is_dir():  # a checkout: kernels/ and scenes/ lie beside warpdrape/
    __path__.append(str(_here.parent))

from warpdrape import units  # noqa: E402

if TYPE_CHECKING:
    from warpdrape.blanks.ply import Ply, lay_up, stack_top
    from warpdrape.defects.alignment import WantedDirection
    from warpdrape.defects.limits import Limits
    from warpdrape.defects.thresholds import DefectThresholds
    from warpdrape.errors import InputError, RunFailed
    from warpdrape.fishnet.darts import suggest_darts
    from warpdrape.fishnet.drape import drape_fishnet
    from warpdrape.fishnet.search import best_fishnet
    from warpdrape.fishnet.several import drape_fishnets
    from warpdrape.materials.bending import Bending, BendingCurve
    from warpdrape.materials.compaction import Compaction
    from warpdrape.materials.crossover import Crossover
    from warpdrape.materials.fabric import Fabric
    from warpdrape.materials.friction import Friction
    from warpdrape.materials.friction_file import load_friction
    from warpdrape.materials.matrix import Heat, Matrix
    from warpdrape.numerics import Numerics
    from warpdrape.results.net_picture import net_picture
    from warpdrape.results.read_run import read_run
    from warpdrape.results.remeasure import remeasure
    from warpdrape.results.result import Result
    from warpdrape.scene import Scene
    from warpdrape.setup import Clamp
    from warpdrape.tools.air import Air
    from warpdrape.tools.floating import Float
    from warpdrape.tools.motion import Path, Stages, Still, Stroke
    from warpdrape.tools.mould import Mould
    from warpdrape.tools.pressure import Pressure
    from warpdrape.tools.spring import Spring
    from warpdrape.tools.tool import Tool
    from warpdrape.tools.turn import Turn

__all__ = [
    "Air",
    "Bending",
    "BendingCurve",
    "Clamp",
    "Compaction",
    "Crossover",
    "DefectThresholds",
    "Fabric",
    "Float",
    "Friction",
    "Heat",
    "InputError",
    "Limits",
    "Matrix",
    "Mould",
    "Numerics",
    "Path",
    "Ply",
    "Pressure",
    "Result",
    "RunFailed",
    "Scene",
    "Spring",
    "Stages",
    "Still",
    "Stroke",
    "Tool",
    "Turn",
    "WantedDirection",
    "best_fishnet",
    "drape_fishnet",
    "drape_fishnets",
    "lay_up",
    "load_friction",
    "net_picture",
    "read_run",
    "remeasure",
    "stack_top",
    "suggest_darts",
    "units",
]

_HOME = {
    "Air": "tools.air",
    "Bending": "materials.bending",
    "BendingCurve": "materials.bending",
    "Compaction": "materials.compaction",
    "Clamp": "setup",
    "Crossover": "materials.crossover",
    "DefectThresholds": "defects.thresholds",
    "Fabric": "materials.fabric",
    "Float": "tools.floating",
    "Friction": "materials.friction",
    "Heat": "materials.matrix",
    "InputError": "errors",
    "Matrix": "materials.matrix",
    "Limits": "defects.limits",
    "Mould": "tools.mould",
    "Numerics": "numerics",
    "Path": "tools.motion",
    "Ply": "blanks.ply",
    "Pressure": "tools.pressure",
    "Result": "results.result",
    "RunFailed": "errors",
    "Scene": "scene",
    "Spring": "tools.spring",
    "Stages": "tools.motion",
    "Still": "tools.motion",
    "Stroke": "tools.motion",
    "Tool": "tools.tool",
    "Turn": "tools.turn",
    "WantedDirection": "defects.alignment",
    "best_fishnet": "fishnet.search",
    "drape_fishnet": "fishnet.drape",
    "drape_fishnets": "fishnet.several",
    "lay_up": "blanks.ply",
    "net_picture": "results.net_picture",
    "load_friction": "materials.friction_file",
    "read_run": "results.read_run",
    "remeasure": "results.remeasure",
    "stack_top": "blanks.ply",
    "suggest_darts": "fishnet.darts",
}
"""Module of each public name: imported on first use, so that ``warpdrape --help`` is quick."""


def __getattr__(name: str) -> object:
    """Import a public name on first use."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(_import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

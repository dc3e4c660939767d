"""Extensions of a run from the command line: a longer stroke, more time, more frames."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.errors import InputError
from warpdrape.tools.floating import Float
from warpdrape.tools.motion import Path, Stages, Still, Stroke

if TYPE_CHECKING:
    from warpdrape.commands.resuming import Begun
    from warpdrape.scene import Scene
    from warpdrape.setup import Clamp
    from warpdrape.tools.tool import Tool

_ASKED = re.compile(r"(\d+(?:\.\d*)?(?:e[-+]?\d+)?) ?(m|cm|mm|s|ms|frames?)")
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_TIMES = {"s": 1.0, "ms": 1e-3}
FAR = 1e9
"""A time by which every motion has come to its end [s]."""
AT_REST = 1e-6
"""Way that a motion has left, over all of its way, with which it counts as ended [-]."""
PEAK = 1.5
"""Largest speed of a path from rest to rest over its mean [-]."""
HARDEST = 6.0
"""Its largest acceleration over way/time² [-]."""
SAMPLES = 2001
"""Times at which a motion's acceleration is sampled."""


@dataclass(frozen=True)
class Extension:
    """What a run is extended by; one of the three.

    Attributes:
        text: as given.
        way: of strokes [m].
        time: [s].
        frames: how many.
    """

    text: str
    way: float = 0.0
    time: float = 0.0
    frames: int = 0


def read_extension(text: str) -> Extension:
    """Read a way such as "10mm", a time such as "8ms", or frames such as "12frames".

    Raises:
        InputError: if it is none of these.
    """
    found = _ASKED.fullmatch(text.strip())
    number = float(found[1]) if found else 0.0
    if found is None or not 0.0 < number < math.inf:
        raise InputError(
            f"--extend {text}: give the way by which strokes go on, such as 10mm; or a time, such "
            "as 8ms; or 12frames"
        )
    if found[2] in _LENGTHS:
        return Extension(text, way=number * _LENGTHS[found[2]])
    if found[2] in _TIMES:
        return Extension(text, time=number * _TIMES[found[2]])
    if number != int(number):
        raise InputError(f"--extend {text}: frames are whole")
    return Extension(text, frames=int(number))


def extended(scene: Scene, run: Begun, more: Extension | None) -> Scene:
    """A scene with the extensions that its run has had, and one more.

    Args:
        scene: as it began.
        run: what its folder says.
        more: the one to come, None for none.

    Raises:
        InputError: if the run is not at its end, or has nothing to extend.
    """
    if more is not None and not run.at_end:
        raise InputError(
            "the run has not come to its end: go on without --extend first, then extend it"
        )
    each = run.duration / run.frames  # of a frame, the same whatever the extensions
    for extension in [*map(read_extension, run.extensions), *([more] if more else [])]:
        scene = _extended(scene, extension, each)
    texts = [*run.extensions, *([more.text] if more else [])]
    return replace(scene, call={**scene.call, "extensions": texts})


def _extended(scene: Scene, extension: Extension, each: float) -> Scene:
    longer = extension.time + extension.frames * each
    if extension.way:
        scene, longer = _further(scene, extension.way)
    frames = math.ceil((scene.duration + longer) / each - 1e-6)
    return replace(scene, duration=frames * each)


def _further(scene: Scene, way: float) -> tuple[Scene, float]:
    """A scene whose strokes go on by a way [m], and how much longer it is [s].

    They go no faster than they went, speed up and brake no harder, and stand as long at the end as
    they did.
    """
    now = scene.duration
    for clamp in scene.clamps:
        if clamp.matrix is not None:
            raise InputError(
                f"clamp {clamp.name!r} moves by a function of time: extend by a time, or from "
                "Python by a scene with a longer one"
            )
    movers = _strokes((*scene.tools, *scene.clamps))
    if not movers:
        raise InputError("--extend by a way needs a tool or clamp that travels; none does")
    time = max(_time(motion, way) for motion in movers.values())
    motions = {name: _path(name, motion, now, way, time) for name, motion in movers.items()}
    held = now - max(motion.end for motion in movers.values())
    tools = [replace(t, motion=motions.get(t.name, t.motion)) for t in scene.tools]
    clamps = [replace(c, motion=motions.get(c.name, c.motion)) for c in scene.clamps]
    return replace(scene, tools=tools, clamps=clamps), time + max(held, 0.0)


def _strokes(things: Sequence[Tool | Clamp]) -> dict[str, Stroke | Path]:
    """Motions of those that travel, by name."""
    found: dict[str, Stroke | Path] = {}
    for thing in things:
        motion = thing.motion
        if isinstance(motion, Float | Still) or motion.peak_speed == 0.0:
            continue
        if isinstance(motion, Stages):
            raise InputError(
                f"{thing.name!r} moves in stages, of which none is the one to go on: extend by a "
                "time, or from Python by a scene with one more stroke"
            )
        found[thing.name] = motion
    return found


def _time(motion: Stroke | Path, way: float) -> float:
    """Time of a smooth path of some way [m] with a motion's largest speed and acceleration [s]."""
    fine = np.linspace(motion.start, motion.end, SAMPLES)
    step = fine[1] - fine[0]
    speeds = np.diff(motion.displacement(fine), axis=0) / step
    hardest = float(np.linalg.norm(np.diff(speeds, axis=0), axis=1).max() / step)
    return max(PEAK * way / motion.peak_speed, math.sqrt(HARDEST * way / hardest))


def _path(name: str, motion: Stroke | Path, now: float, way: float, time: float) -> Path:
    start, here, end = motion.displacement(np.array([0.0, now, FAR]))
    travel = end - start
    whole = float(np.linalg.norm(travel))
    if np.linalg.norm(end - here) > AT_REST * whole or whole == 0.0:
        raise InputError(
            f"{name!r} is still on its way at the end of the run: extend by a time, in which it "
            "comes to rest"
        )
    return Path(times=[now, now + time], positions=[here, here + way / whole * travel])

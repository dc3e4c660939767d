"""Time from starting Python to the first step of the default scene, kernels cached or not."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

FIRST_STEP = """
import os, sys
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.dynamics.stepping import Stepper
block = Stepper.block
def first_block(stepper):
    block(stepper)
    os._exit(0)
Stepper.block = first_block
three_ply_hemisphere.build().run(sys.argv[1])
"""


def start_up() -> dict[str, float]:
    """Wall time to the end of the first block of steps [s], "cold" and "warm", a frame written."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "WARP_CACHE_PATH": cache}
        seconds = {}
        for name in ("cold", "warm"):
            start = time.perf_counter()
            subprocess.run(
                [sys.executable, "-c", FIRST_STEP, os.path.join(cache, f"run_{name}")],
                check=True,
                env=environment,
                stderr=subprocess.DEVNULL,
            )
            seconds[name] = time.perf_counter() - start
        return seconds

"""Time from starting Python to the first step of the default scene, kernels cached or not."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

FIRST_STEP = """
import sys
from warpdrape.model import build_model, initial_state
from warpdrape.run_folder import RunFolder
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.simulation import Recorder
from warpdrape.stepping import Stepper
model = build_model(three_ply_hemisphere.build(), "cpu", 60)
state = initial_state(model)
Recorder(model, RunFolder(sys.argv[1], overwrite=False)).record(state, 0, 0)
stepper = Stepper(model, state)
stepper.begin_frame(1)
stepper.block()
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

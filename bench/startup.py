"""Time from starting Python to the first step of the default scene, kernels cached or not."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

FIRST_STEP = """
from warpdrape.model import build_model, initial_state
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.stepping import Stepper
model = build_model(three_ply_hemisphere.build(), "cpu", 60)
stepper = Stepper(model, initial_state(model))
stepper.begin_frame(1)
stepper.block()
"""


def start_up() -> dict[str, float]:
    """Wall time to the end of the first block of steps [s], "cold" and "warm"."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "WARP_CACHE_PATH": cache}
        seconds = {}
        for name in ("cold", "warm"):
            start = time.perf_counter()
            subprocess.run(
                [sys.executable, "-c", FIRST_STEP],
                check=True,
                env=environment,
                stderr=subprocess.DEVNULL,
            )
            seconds[name] = time.perf_counter() - start
        return seconds

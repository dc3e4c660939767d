"""A blank holder that keeps its distance instead of pressing: what the flange can do under it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.scenes import hemisphere
from warpdrape.units import mm

GAP = 0.3 * mm
PAGE = Path(__file__).parents[1] / "docs" / "devices.md"


@pytest.fixture(scope="module")
def scene():
    settings = {"cells": 12, "accuracy": "draft", "travel": 65 * mm, "duration": 0.02}
    return hemisphere.build(**settings, holder_force=1.0, bending="0.0005")


@pytest.fixture(scope="module")
def pressed(scene):
    return scene.run(frames=5, threads=1, quiet=True)


@pytest.fixture(scope="module")
def spaced(scene):
    punch, die, holder = scene.tools
    ring = replace(holder.moved((0.0, 0.0, GAP)), motion=wd.Still())
    return replace(scene, tools=[punch, die, ring]).run(frames=5, threads=1, quiet=True)


def height_of_flange(result):
    """Highest point of the ply's middle under the holder, above the die's flat [m]."""
    (ply,) = result.plies
    out = np.linalg.norm(ply.points[:, :2], axis=1) > 0.095
    return float(ply.points[out, 2].max())


def test_the_flange_stays_under_a_holder_that_keeps_its_distance(scene, pressed, spaced):
    half = 0.5 * scene.plies[0].fabric.thickness
    assert pressed.summary["status"] == spaced.summary["status"] == "completed"
    assert height_of_flange(spaced) <= half + GAP + 0.02 * mm
    assert height_of_flange(pressed) > half + 2.0 * GAP  # a force gives way
    assert np.abs(spaced.history["holder_displacement_m"]).max() == 0.0
    assert spaced.history["holder_force_n"].max() > 1.0  # its reaction, which the force was not


def test_the_lines_of_the_page(scene):
    (text,) = [
        block
        for block in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
        if "spaced" in block
    ]
    names = {"wd": wd, "mm": mm, "replace": replace, "stack_top": wd.stack_top}
    names["plies"] = scene.plies
    exec(text, names)
    high = [names[name].vertices[:, 2].min() for name in ("pressed", "spaced")]
    assert high[1] - high[0] == pytest.approx(GAP)
    assert isinstance(names["pressed"].motion, wd.Float)
    assert isinstance(names["spaced"].motion, wd.Still)

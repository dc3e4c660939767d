"""The diaphragm scene, run coarse: vacuum lays ply and rubber on the mould, energy is kept."""

import numpy as np
import pytest

from warpdrape.errors import InputError
from warpdrape.scenes import diaphragm


def coarse(**given):
    options = {"layup": "0", "edge": 0.024, "duration": 0.02, "facet": 8e-3, "vacuum": 30e3}
    return diaphragm.build(**options | given)


@pytest.mark.parametrize("diaphragms", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_vacuum_lays_the_ply_on_the_mould(diaphragms):
    scene = coarse(diaphragms=diaphragms)
    result = scene.run(frames=12, quiet=True)
    assert result.completed and result.summary["energy_error"] < 0.01, result.summary["message"]
    plies = {ply.name: ply for ply in result.plies}
    ply, upper = plies["ply_0"], plies["upper"]
    radius = np.hypot(*ply.points[:, :2].T)
    # The ply has come down round the dome, 35 mm high, and lies on the base outside.
    half = 0.5 * scene.plies[0].fabric.thickness
    beneath = 0.0 if diaphragms == 1 else diaphragm.RUBBER["thickness"]
    assert abs(ply.points[radius < 0.012, 2].max() - half - beneath) < 1.5e-3
    outside = ply.points[(radius > 0.085)]
    assert len(outside) > 10
    off = np.abs(outside[:, 2] + diaphragm.DOME_HEIGHT - half - beneath)
    assert np.median(off) < 1.5e-3 and off.max() < 8e-3  # triangles of 24 mm leave the fillet
    # What the rubber has grown in area it has lost in thickness.
    a, b, c = (upper.points[upper.triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    flat = np.asarray(scene.plies[-1].mesh.areas)
    volume = (upper.thickness * areas).sum()
    assert volume == pytest.approx(diaphragm.RUBBER["thickness"] * flat.sum(), rel=1e-9)
    assert areas.sum() > 1.05 * flat.sum()
    # The mould bears the atmosphere's push, but for what the frame takes of it.
    force = result.history["mould_force_n"][-1]
    assert 0.5 < force / (30e3 * np.pi * diaphragm.FRAME_RADIUS**2) < 1.1


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"diaphragms": 3}, "diaphragms = 3 must be 1 or 2"),
        ({"blank_size": 0.3}, r"blank_size = 0.3 m reaches the frame: give 0.209 m or less"),
        ({"layup": "0;90"}, "layup = '0;90' must be angles"),
        ({"vacuum": -1.0}, "vacuum = -1"),
    ],
)
def test_what_does_not_fit_the_box_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        coarse(**given)

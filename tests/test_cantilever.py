"""Peirce's cantilever test as a scene: the stiffness that goes in comes out."""

from dataclasses import replace

import pytest

from warpdrape import Bending
from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.scenes import cantilever


@pytest.mark.parametrize("family", [pytest.param("warp", marks=pytest.mark.slow), "weft"])
def test_flexural_length_is_recovered(family):
    """At the overhang of 41.5°; within 1 % of the length, three times that of the stiffness."""
    result = cantilever.build(cells=16, family=family).run(frames=2, threads=1)
    assert result.completed
    found, stiffness = result.summary["cantilever"], load_fabric("carbon_interlock").bending
    assert found["chord_angle_deg"] == pytest.approx(41.5, abs=0.5)
    assert found["flexural_length_m"] == pytest.approx(0.5 * found["overhang_m"], rel=0.01)
    assert found["bending_stiffness_n_m"] == pytest.approx(getattr(stiffness, family), rel=0.03)


def test_a_strip_one_square_wide_hangs_too():
    found = cantilever.build(cells=8, mesh="diagonal").run(frames=2, threads=1)
    assert found.completed, found.summary["message"]
    assert found.summary["cantilever"]["chord_angle_deg"] == pytest.approx(41.5, abs=3.0)  # h = L/8


def test_a_strip_of_no_stiffness_is_refused(monkeypatch):
    cloth = replace(load_fabric("carbon_interlock"), bending=Bending(warp=1e-3, weft=0.0))
    monkeypatch.setattr(cantilever, "with_bending", lambda fabric, bending: cloth)
    assert cantilever.build(family="warp").plies
    with pytest.raises(InputError, match=r"bending\.weft of 'carbon_interlock' is 0 N·m"):
        cantilever.build(family="weft")
    monkeypatch.setattr(
        cantilever, "with_bending", lambda fabric, bending: replace(cloth, bending=None)
    )
    with pytest.raises(InputError, match="give bending"):
        cantilever.build()

"""A yarn pulled out of a patch beside its closed form."""

import dataclasses
import math

import numpy as np
import pytest

from warpdrape.blanks.yarn_chains import chain_yarns
from warpdrape.coupons.pull_out import PullOut
from warpdrape.errors import InputError
from warpdrape.forces.ply_net import net_of
from warpdrape.scenes import yarn_pull_out


def pulled(frames=40, **changes):
    """A pull-out: history, mean forces by the end's work and by the closed form, and its peak."""
    small = {"length": 0.04, "edge": 0.01, "sides": 1, "slip_force": 1.0, "stiffness": 2e5}
    scene = yarn_pull_out.build(**small | {"travel": 5e-5, "duration": 0.003} | changes)
    result = scene.run(frames=frames)
    assert result.completed and result.summary["energy_error"] < 1e-3
    parameters = scene.parameters
    exact = yarn_pull_out.closed_form(
        scene.plies[0].fabric, parameters["length"], parameters["edge"]
    )
    u = result.history["end_displacement_m"]
    force = np.diff(result.history["end_work_j"]) / np.diff(u)
    return result, u, force, exact


def test_the_rise_of_a_pull_out_converges_to_its_shear_lag():
    """Second order: the worst error over the largest force falls fourfold with half the edge."""
    worst = []
    for edge in (0.01, 0.005):
        result, u, force, exact = pulled(edge=edge)
        peak = exact.curve[1].max()
        assert exact.slips_from == pytest.approx(5e-6)
        assert u[8] < exact.slips_from and exact.force(u[8]) < 0.5 * peak < exact.force(u[-1])
        worst.append(np.abs(force - exact.mean_force(u)).max() / peak)
        held, lost = (result.history[n][8] for n in ("crossover_j", "yarn_slip_j"))
        assert held > 0.1 * result.history["end_work_j"][8] and abs(lost) < 0.02 * held
    assert worst[0] < 0.025 and worst[0] / worst[1] > 3.0


def test_a_yarn_pulled_out_gives_way_as_its_end_goes_by_its_crossings():
    """Within 1 %, as asked, and all of the work but what is stored is slip."""
    result, u, force, exact = pulled(
        slip_force=0.1, stiffness=2e4, travel=0.033, duration=0.02, sides=2
    )
    closed = exact.mean_force(u)
    assert closed[-1] < 0.3 * closed.max()
    far = u[1:] > 1e-4  # past the rise, which takes one frame
    assert np.abs(force / closed - 1.0)[far].max() < 0.01
    slide = result.plies[0].yarn_slide
    middle = np.abs(result.plies[0].rest_points[:, 1]) < 1e-9
    mouth = middle & np.isclose(result.plies[0].rest_points[:, 0], 0.04)
    assert slide[mouth, 0] == pytest.approx(-0.033, rel=1e-3)  # towards +x: against s
    assert np.abs(slide[~middle]).max() < 1e-5
    history, summary = result.history, result.summary
    assert history["yarn_slip_j"][-1] == pytest.approx(history["end_work_j"][-1], rel=1e-3)
    assert summary["plies"][0]["max_slide_warp_m"] == pytest.approx(0.033, rel=1e-3)
    assert summary["plies"][0]["max_slide_weft_m"] == np.abs(slide[:, 1]).max()
    assert summary["coupon"]["force_error"] == pytest.approx(force[-1] / closed[-1] - 1.0)
    chains = chain_yarns(net_of(wd_scene().plies[0]))
    left = chains.left(slide[chains.vertices])
    assert (left[:, 0] == 0.0).sum() == 3  # crossovers that the bundle's end has gone by


def wd_scene():
    return yarn_pull_out.build(length=0.04, edge=0.01, sides=2, travel=0.033, duration=0.02)


def test_with_the_weft_gripped_at_its_ends_the_largest_force_is_the_same():
    _, _, force, exact = pulled(
        slip_force=0.1, stiffness=2e4, travel=0.004, duration=0.01, held="sides", length=0.03
    )
    assert force.max() == pytest.approx(exact.curve[1].max(), rel=0.02)


def test_the_closed_form_of_a_pull_out():
    """Its branches join, its slope at first is that of a shear lag, and its means are means."""
    exact = PullOut(length=0.05, stiffness=1e5, hold=1e7, limit=100.0)
    at, force = exact.curve
    assert (np.diff(at) >= 0.0).all() and np.abs(np.diff(force)).max() < 0.01 * force.max()
    assert force.max() == pytest.approx(100.0 * 0.05) and force[-1] == 0.0
    beta = math.sqrt(1e7 / 1e5)
    slope = 1e5 * beta * math.tanh(beta * 0.05)
    assert exact.force(1e-6) == pytest.approx(slope * 1e-6, rel=1e-9)
    assert exact.force(np.array([0.06])) == 0.0
    ends = np.linspace(0.0, 0.05, 14)
    for a, b, mean in zip(ends[:-1], ends[1:], exact.mean_force(ends), strict=True):
        fine = np.linspace(a, b, 20_001)
        assert mean == pytest.approx(np.trapezoid(exact.force(fine), fine) / (b - a), rel=1e-5)
    with pytest.raises(InputError, match="hold"):
        dataclasses.replace(exact, hold=0.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"travel": 0.06}, r"travel = 0\.06 m draws the bundle out of a patch of 0\.05 m"),
        ({"edge": 0.007}, r"length = 0\.05 m must be a multiple of edge = 0\.007 m"),
        ({"sides": 0}, r"sides = 0 must be a whole number, 1 or more"),
        ({"slip_force": 0.0}, r"slip_force = 0 takes that of the fabric, and 'carbon_interlock'"),
        ({"held": "glue"}, r"unknown held 'glue'"),
        ({"fabric": "synthetic_plain_crimp"}, r"couples warp and weft"),
    ],
)
def test_a_pull_out_that_cannot_be_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        yarn_pull_out.build(**changes).run(frames=1)

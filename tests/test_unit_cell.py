"""The unit cell at rest: energies against differences, geometry in space, invariance."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cell_checks import balanced, cell_of, shaken, weaves

from warpdrape.unit_cell import sides
from warpdrape.unit_cell.crossings import contact
from warpdrape.unit_cell.equilibrium import derivatives, energy, settle, strain_forces
from warpdrape.unit_cell.model import build_model, patch_places
from warpdrape.unit_cell.splines import spline_value
from warpdrape.unit_cell.weave import twill


@weaves()
@pytest.mark.parametrize("slack", [False, True])
def test_forces_are_the_slopes_of_the_energy(weave, slack):
    model = build_model(cell_of(weave, height=(0.6e-3, 0.58e-3)), elements=4, points=5)
    state = shaken(model)
    strain = np.array([0.004, 0.009, 0.75, 0.03, 0.01])
    if slack:
        strain[:2] = -0.012
    touching = [sides.side_energy(model, k, model.parts(state)[k], strain) for k in (0, 1)]
    assert min(touching) > 0.0  # neighbours touch, and sections are squeezed
    assert 0.05 < contact(model, state, strain).squeeze.max() < 0.9
    gradient, hessian = derivatives(model, state, strain)
    step = 1e-9
    for k, unit in enumerate(np.eye(len(state))):
        rise = (
            energy(model, state + step * unit, strain) - energy(model, state - step * unit, strain)
        ) / (2 * step)
        assert rise == pytest.approx(gradient[k], abs=2e-6 * np.abs(gradient).max())
        ends = [derivatives(model, state + way * step * unit, strain, False)[0] for way in (1, -1)]
        np.testing.assert_allclose(
            (ends[0] - ends[1]) / (2 * step), hessian[k], atol=2e-6 * np.abs(hessian).max()
        )
    forces = strain_forces(model, state, strain)
    assert np.abs(forces).min() > 1e-7
    for k, unit in enumerate(np.eye(5)):
        ends = [energy(model, state, strain + way * 1e-6 * unit) for way in (1, -1)]
        assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(forces[k], rel=1e-6, abs=1e-9)


@weaves()
def test_held_strains_are_answered_by_the_slopes_of_the_energy_at_rest(weave):
    """Virtual work: ∂W/∂ε1 = L1 T1, ∂W/∂ε2 = L2 T2, ∂W/∂γ = C_s of a cell, everything at rest."""
    model = build_model(cell_of(weave), elements=6, points=7)
    at = np.array([0.008, 0.007, 0.5])
    rest = settle(model, at)
    found = np.array([*(rest.tension * model.cell.cell), rest.couple])
    assert rest.tension.min() > 1.0 and rest.couple > 1e-5
    for k, (unit, step) in enumerate(zip(np.eye(3), (1e-5, 1e-5, 1e-3), strict=True)):
        ends = [settle(model, at + way * step * unit, rest).energy for way in (1, -1)]
        assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(found[k], rel=2e-4)


@weaves()
@pytest.mark.parametrize("section", ["lens", "ellipse"])
def test_a_cell_as_woven_is_at_rest(weave, section):
    model = build_model(cell_of(weave, section=section, width=(4.7e-3, 4.4e-3)))
    rest = settle(model, np.zeros(3))
    assert rest.iterations == 1
    assert np.abs(rest.tension).max() < 1e-9 and abs(rest.couple) < 1e-12
    assert rest.squeeze < 1e-12


@weaves()
def test_neighbours_and_patches_are_where_points_in_space_say(weave):
    """In any frame: the foot of a perpendicular to a neighbour, and distances to both axes."""
    model = build_model(cell_of(weave))
    strain = np.array([0.01, -0.02, 0.6, 0.04, 0.02])
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    angle = 0.5 * math.pi - strain[2]
    ways = turn @ np.array([[1, math.cos(angle)], [0, math.sin(angle)], [0, 0]])
    stretch = 1.0 + strain[:2]
    moved = (weave.move, weave.weft_offset(1))
    for k in (0, 1):
        own, other = ways[:, k], ways[:, 1 - k]
        yarn, length = model.yarns[k], model.cell.cell[k]
        points = np.outer(yarn.places * stretch[k], own)
        origin = model.cell.spacing[k] * stretch[1 - k] * other
        foot = (points - origin) @ own
        apart = np.linalg.norm(points - origin - np.outer(foot, own), axis=1)
        np.testing.assert_allclose(apart, float(sides.distance(model, k, strain)))
        beside = sides.neighbour_places(model, k, strain)
        np.testing.assert_allclose(foot / stretch[k] - moved[k] * length, beside, atol=1e-12)
    assert float(sides.width(model, 0, strain)) == pytest.approx(0.96 * 4.1e-3)
    assert float(sides.width(model, 1, strain)) == pytest.approx(0.98 * 3.9e-3)
    at = contact(model, model.woven, strain)
    x = at.half_warp * model.grid * stretch[0]
    y = at.half_weft * model.grid * stretch[1]
    for point, xi, eta in ((p, i, j) for p in [None] for i in range(9) for j in range(9)):
        point = x[xi] * ways[:, 0] + y[eta] * ways[:, 1]
        for along, width, share in (
            (ways[:, 1], 3.9e-3 * 0.98, model.grid[xi]),
            (ways[:, 0], 4.1e-3 * 0.96, model.grid[eta]),
        ):
            off = np.linalg.norm(point - (point @ along) * along)
            assert off == pytest.approx(0.5 * width * abs(share), abs=1e-12)
    # the patch's area as woven points carry it
    area = 3.9e-3 * 4.1e-3 / math.cos(strain[2])
    assert at.weight.sum() == pytest.approx(area)
    warp, weft = patch_places(model, 0.0, 0.0)
    assert warp.shape == weft.shape == (weave.repeat, 9)


@weaves()
def test_a_weft_lies_beside_the_neighbour_that_the_matrix_says(weave):
    """Without shear, neighbours' heights at their crossovers are those of the weave's matrix."""
    model = build_model(cell_of(weave))
    over = np.where(np.array(weave.matrix()), 1, -1)
    n = weave.repeat
    for k, signs in ((0, over), (1, -over.T)):
        yarn, length = model.yarns[k], model.cell.cell[k]
        shift = sides.neighbour_places(model, k, np.zeros(5)) - yarn.places
        path = model.parts(model.woven)[k]
        own = spline_value(path, length * np.arange(n), yarn.step)
        beside = spline_value(path, length * np.arange(n) + shift[0], yarn.step)
        a = model.cell.amplitudes[k]
        np.testing.assert_allclose(own, a * signs[0], atol=1e-12)
        np.testing.assert_allclose(beside, a * signs[1], atol=1e-12)


def test_a_balanced_weave_pulls_alike_both_ways():
    model = build_model(balanced(weave=twill()))
    one = settle(model, np.array([0.009, 0.004, 0.0]))
    other = settle(model, np.array([0.004, 0.009, 0.0]))
    assert one.tension[0] > 2.0 * one.tension[1] > 1.0
    np.testing.assert_allclose(one.tension, other.tension[::-1], rtol=1e-7)
    even = settle(model, np.array([0.007, 0.007, 0.0]))
    assert even.tension[0] == pytest.approx(even.tension[1], rel=1e-8)


def test_warp_and_weft_may_change_names():
    cell = cell_of()
    names = ("spacing", "width", "height", "stiffness", "bending")
    turned = replace(cell, **{name: getattr(cell, name)[::-1] for name in names})
    one = settle(build_model(cell), np.array([0.009, 0.004, 0.3]))
    other = settle(build_model(turned), np.array([0.004, 0.009, 0.3]))
    np.testing.assert_allclose(one.tension, other.tension[::-1], rtol=1e-7)
    assert one.couple == pytest.approx(other.couple, rel=1e-6)


@weaves()
def test_a_ply_may_be_turned_over(weave):
    other = replace(weave, over=tuple(not up for up in weave.over))
    at = np.array([0.008, 0.006, 0.6])
    one, two = (settle(build_model(cell_of(w)), at) for w in (weave, other))
    np.testing.assert_allclose(one.tension, two.tension, rtol=1e-7)
    assert one.couple == pytest.approx(two.couple, rel=1e-6)


def test_a_plain_weave_shears_alike_both_ways():
    model = build_model(cell_of())
    ahead, back = (settle(model, np.array([0.006, 0.006, way * 0.6])) for way in (1, -1))
    assert ahead.couple > 1e-5
    assert ahead.couple == pytest.approx(-back.couple, rel=1e-9)


def test_more_elements_change_little():
    at = np.array([0.008, 0.006, 0.6])
    coarse, fine = (
        settle(build_model(cell_of(), elements, points), at)
        for elements, points in ((8, 9), (16, 17))
    )
    np.testing.assert_allclose(coarse.tension, fine.tension, rtol=0.01)
    assert coarse.couple == pytest.approx(fine.couple, rel=0.02)
    assert coarse.friction == pytest.approx(fine.friction, rel=0.02)

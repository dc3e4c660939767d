"""The unit cell against closed forms: saw teeth, balance, friction, neighbours that lock."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from cell_checks import SOFT, balanced, cell_of, weaves

from warpdrape.coupons.closed_forms import crimp_tensions
from warpdrape.materials.laws import CrimpInterchange
from warpdrape.unit_cell import sides
from warpdrape.unit_cell.cell import UnitCell
from warpdrape.unit_cell.compaction import YarnCompaction
from warpdrape.unit_cell.crossings import contact, crossing_friction
from warpdrape.unit_cell.equilibrium import settle
from warpdrape.unit_cell.model import build_model
from warpdrape.unit_cell.splines import spline_value
from warpdrape.unit_cell.weave import plain, twill

SPACING, EA, CRIMP = 5.2e-3, 34e3, 0.004


SAW_TOOTH = CrimpInterchange(SPACING, SPACING, CRIMP, CRIMP, EA, EA)


def thin_model(elements, width=0.02):
    """Stiff yarns, thin beside their spacing, that hardly resist bending."""
    cell = UnitCell(
        weave=plain(),
        spacing=(SPACING,) * 2,
        width=(width * SPACING,) * 2,
        height=(SAW_TOOTH.heights[0],) * 2,
        stiffness=(EA,) * 2,
        bending=(1e-9,) * 2,
        compaction=YarnCompaction(1e15, 2.0),
        friction=0.2,
    )
    return build_model(cell, elements, points=5)


@pytest.mark.parametrize("ratio", [1.0, 0.5, 0.0])
def test_thin_stiff_yarns_are_saw_teeth(ratio):
    """First order in the element, which rounds the teeth's corners; 0.2 % at 32 elements."""
    errors = []
    for elements in (8, 16, 32):
        model = thin_model(elements)
        found = settle(model, np.array([0.004, ratio * 0.004, 0.0])).tension
        exact = crimp_tensions(SAW_TOOTH, 0.004, ratio * 0.004)
        errors.append(abs(found[0] / exact[0] - 1.0))
    assert errors[-1] < 0.0022
    assert all(fine < 0.6 * coarse for coarse, fine in pairwise(errors))


def test_a_thin_cell_pulled_one_way_gives_its_crimp_away():
    """Tensions held, the weft's small: the ply shrinks across, as saw teeth do."""
    model = thin_model(32)
    strain = (0.006, -0.008)
    exact = crimp_tensions(SAW_TOOTH, *strain)
    assert exact[0] > 5.0 * exact[1] > 5.0
    found = settle(model, np.array([*strain, 0.0]), tension=tuple(exact)).strain
    np.testing.assert_allclose(found[:2], strain, rtol=0.02)


@weaves()
def test_contact_carries_what_the_yarns_slopes_ask_for(weave):
    """Vertical balance of a crossover between two points where the yarn is straight."""
    model = build_model(cell_of(weave, width=(2e-3, 2e-3)), elements=12, points=15)
    rest = settle(model, np.array([0.006, 0.006, 0.0]))
    at = contact(model, rest.state, rest.strain)
    pressed = (at.weight * SOFT.stress(at.squeeze)).sum(axis=(1, 2))
    path, yarn, n = model.parts(rest.state)[0], model.yarns[0], weave.repeat
    middles = model.cell.cell[0] * (np.arange(n + 1) - 0.5)
    slope = spline_value(path, middles, yarn.step, 1)
    pull = yarn.stiffness * rest.yarn_strain[0]
    lift = pull * slope / np.sqrt((1.0 + 0.006) ** 2 + slope**2)
    down = lift[:-1] - lift[1:]
    changing = [k for k in range(n) if weave.signs[k - 1] != weave.signs[k]]
    for k in changing:
        if weave.signs[(k + 1) % n] != weave.signs[k]:
            expected = abs(down[k])
            assert pressed[k] == pytest.approx(expected, rel=0.03)
    assert changing and pull > 1.0


def test_friction_is_the_couple_of_what_presses():
    """Σ μ N r over the patch; of flat yarns nothing else resists shear before they touch."""
    stiff = YarnCompaction(1e6, 3.0)
    model = build_model(
        cell_of(
            width=(1e-3,) * 2,
            height=(0.05e-3,) * 2,
            bending=(1e-9,) * 2,
            compaction=stiff,
        )
    )
    loads = (5.0, 5.0)
    for degrees in (0.0, 25.0, 50.0):
        rest = settle(model, np.array([0.0, 0.0, math.radians(degrees)]), tension=loads)
        at = contact(model, rest.state, rest.strain)
        force = at.weight * stiff.stress(at.squeeze)
        arm = 0.0
        sine = math.cos(math.radians(degrees))  # between the yarns
        for i, xi in enumerate(model.grid):
            for j, eta in enumerate(model.grid):
                # ξ, η are shares of half a width off the weft's, the warp's axis
                a, b = 0.5e-3 * xi * (1 - rest.strain[4]), 0.5e-3 * eta * (1 - rest.strain[3])
                square = (a * a + b * b + 2 * a * b * math.sin(rest.strain[2])) / sine**2
                arm += force[:, i, j].sum() * math.sqrt(square)
        couple = 0.25 * arm / model.cell.weave.repeat
        assert rest.friction == pytest.approx(couple, rel=1e-9)
        assert couple > 1e-7
        assert abs(rest.couple) < 0.1 * couple
        doubled = replace(model, cell=replace(model.cell, friction=0.5))
        assert crossing_friction(doubled, rest.state, rest.strain) == pytest.approx(
            2.0 * model.cell.weave.repeat * rest.friction
        )


def test_straight_neighbours_lock_where_the_spacing_is_their_width():
    """cos γ = w/s; beyond it W = A L ψ(e), e = 1 − s cos γ/w, and C_s = A L p(e) s sin γ/w."""
    model = build_model(balanced(crimp=(0.0, None)), elements=4, points=5)
    cell, path = model.cell, model.parts(model.woven)[0]
    locking = math.acos(4.1 / 5.2)
    assert cell.locking == pytest.approx(locking) and np.abs(path).max() < 1e-15
    for angle in (locking - 1e-6, locking + 1e-6, locking + 0.1, locking + 0.2):
        strain = np.array([0.0, 0.0, angle, 0.0, 0.0])
        squeeze = max(1.0 - 5.2 * math.cos(angle) / 4.1, 0.0)
        volume = 2.0 / 3.0 * 4.1e-3 * 0.6e-3 * cell.cell[0]
        found = sides.side_energy(model, 0, path, strain) / cell.weave.repeat
        assert found == pytest.approx(volume * float(SOFT.energy(np.array(squeeze))), rel=1e-9)
        assert (found > 0.0) == (angle > locking)
        turned = sides.side_energy(model, 0, path, strain + np.array([0, 0, 1e-30j, 0, 0]))
        couple = volume * float(SOFT.stress(squeeze)) * 5.2 * math.sin(angle) / 4.1
        assert np.imag(turned) / 1e-30 / cell.weave.repeat == pytest.approx(couple, rel=1e-9)


def test_sides_press_with_the_slope_of_their_energy_and_rub():
    model = build_model(balanced(weave=twill()))
    strain = np.array([0.0, 0.0, 0.8, 0.02, 0.03])
    path = model.parts(model.woven)[0]
    step = 1e-7
    ends = [
        sides.side_energy(model, 0, path, strain + np.array([0, way * step, 0, 0, 0]))
        for way in (1, -1)
    ]
    # D = s (1 + ε2) cos γ, and which part is beside moves with ε2, too: taken out here
    still = [
        _moved_only(model, path, strain, np.array([0, way * step, 0, 0, 0])) for way in (1, -1)
    ]
    by_distance = (ends[0] - ends[1] - still[0] + still[1]) / (2 * step)
    per_strain = model.cell.spacing[0] * math.cos(0.8)
    force = sides.side_force(model, 0, path, strain)
    assert force > 1e-3
    assert force == pytest.approx(-by_distance / per_strain, rel=1e-5)
    arm = float(sides.distance(model, 0, strain))
    assert sides.side_friction(model, 0, path, strain) == pytest.approx(0.25 * force * arm)


def _moved_only(model, path, strain, moved):
    """Energy with the neighbour moved along, the distance kept."""
    beside = sides.neighbour_places(model, 0, strain + moved)
    yarn = model.yarns[0]
    above = spline_value(path, yarn.places, yarn.step) - spline_value(path, beside, yarn.step)
    apart = float(sides.distance(model, 0, strain) / sides.width(model, 0, strain))
    rho = np.sqrt(apart**2 + (above / model.cell.height[0]) ** 2)
    return model.cell.sections[0] * (yarn.weights @ SOFT.energy(1.0 - rho))

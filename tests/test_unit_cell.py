"""The unit cell's mechanics: weaves, energies against differences, closed forms, invariance."""

import math
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from warpdrape.coupons.closed_forms import crimp_tensions
from warpdrape.errors import InputError, RunFailed
from warpdrape.materials.laws import CrimpInterchange
from warpdrape.unit_cell import sides
from warpdrape.unit_cell.cell import UnitCell, fibre_shares
from warpdrape.unit_cell.compaction import YarnCompaction
from warpdrape.unit_cell.crossings import contact, crossing_friction
from warpdrape.unit_cell.equilibrium import derivatives, energy, settle, strain_forces
from warpdrape.unit_cell.loading import Loads, _curve, shear, shear_angles, strain_axes
from warpdrape.unit_cell.model import build_model, patch_places
from warpdrape.unit_cell.path import amplitude_of, crimp_of, woven_height
from warpdrape.unit_cell.splines import spline_basis, spline_value, through
from warpdrape.unit_cell.weave import Weave, plain, satin, twill, weave_of

SOFT = YarnCompaction(5e3, 8.0)
WEAVES = {"plain": plain(), "twill": twill(2, 1), "satin": satin(5, 3)}


def cell_of(weave=WEAVES["plain"], **changes):
    """Yarns that differ between the families."""
    values = {
        "weave": weave,
        "spacing": (5.2e-3, 4.8e-3),
        "width": (4.1e-3, 3.9e-3),
        "height": (0.6e-3, 0.5e-3),
        "stiffness": (44e3, 38e3),
        "bending": (1e-7, 2e-7),
        "compaction": SOFT,
        "friction": 0.25,
    }
    return UnitCell(**{**values, **changes})


def balanced(**changes):
    both = {"spacing": (5.2e-3,) * 2, "width": (4.1e-3,) * 2, "height": (0.6e-3,) * 2}
    return cell_of(**{**both, "stiffness": (44e3,) * 2, "bending": (1e-7,) * 2, **changes})


def weaves():
    return pytest.mark.parametrize("weave", WEAVES.values(), ids=WEAVES.keys())


# weaves


def test_weaves_are_those_of_the_textbook():
    assert plain().matrix() == [[1, 0], [0, 1]]
    assert twill(2, 2).matrix() == [[1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1], [1, 0, 0, 1]]
    five = np.array(satin(5, 2).matrix())
    assert (five.sum(axis=0) == 1).all() and (five.sum(axis=1) == 1).all()
    bound = {(i, int(np.argmax(row))) for i, row in enumerate(five)}
    beside = {(i, (j + d) % 5) for i, j in bound for d in (-1, 1)}
    beside |= {((i + d) % 5, j) for i, j in bound for d in (-1, 1)}
    assert not bound & beside


@weaves()
def test_weft_yarns_are_moved_on_from_the_first_one(weave):
    over, n = weave.matrix(), weave.repeat
    for j in range(n):
        own = weave.weft_signs()
        for i in range(n):
            seen = own[(i - weave.weft_offset(j)) % n]
            assert seen == (-1 if over[i][j] else 1)


@pytest.mark.parametrize(
    ("make", "words", "mended"),
    [
        (lambda: satin(4), "twill 1/3", lambda: twill(1, 3)),
        (lambda: satin(5, 4), "2 … 3", lambda: satin(5, 3)),
        (lambda: satin(6, 2), "common factor", lambda: satin(7, 2)),
        (lambda: Weave((True, True), 1), "not woven in", lambda: Weave((True, False), 1)),
        (lambda: weave_of("plain", over=2), "leave it out", lambda: weave_of("plain")),
        (lambda: weave_of("twil"), "did you mean 'twill'", lambda: weave_of("twill")),
        (lambda: weave_of("twill", over=0), "1 … 16", lambda: weave_of("twill", over=1)),
        (lambda: twill(20, 1), "2 to 16", lambda: twill(15, 1)),
    ],
)
def test_what_is_no_weave_is_refused(make, words, mended):
    with pytest.raises(InputError, match=words):
        make()
    assert mended()


# laws and paths


def test_a_yarns_pressure_is_the_slope_of_its_energy():
    e, step = np.array([0.02, 0.2, 0.6]), 1e-6
    rise = (SOFT.energy(e + step) - SOFT.energy(e - step)) / (2 * step)
    np.testing.assert_allclose(SOFT.stress(e), rise, rtol=1e-7)
    bend = (SOFT.stress(e + step) - SOFT.stress(e - step)) / (2 * step)
    np.testing.assert_allclose(SOFT.stiffness(e), bend, rtol=1e-7)
    assert SOFT.stress(np.array([0.5]))[0] == pytest.approx(5e3 * (2.0**8 - 1.0))
    for law in (SOFT.energy, SOFT.stress, SOFT.stiffness):
        assert not law(np.array([-0.3, -1e-9])).any()
    assert np.isinf(SOFT.energy(np.array([1.0, 1.5]))).all()


@pytest.mark.parametrize(("name", "value"), [("pressure", 0.0), ("exponent", 1.0)])
def test_compaction_laws_that_are_none_are_refused(name, value):
    with pytest.raises(InputError, match=f"compaction_{name}"):
        replace(SOFT, **{name: value})


def test_splines_are_periodic_and_their_slopes_are_slopes():
    rng = np.random.default_rng(1)
    coefficients, step = rng.normal(size=10), 0.3
    at = rng.uniform(-5.0, 8.0, 40)
    for order in (0, 1):
        here, there = (spline_value(coefficients, at + d, step, order) for d in (-1e-6, 1e-6))
        slope = spline_value(coefficients, at, step, order + 1)
        np.testing.assert_allclose((there - here) / 2e-6, slope, atol=2e-5)
    value = spline_value(coefficients, at, step)
    np.testing.assert_allclose(spline_value(coefficients, at + 3.0, step), value)
    np.testing.assert_allclose(spline_basis(at, 10, step) @ coefficients, value)
    turned = spline_value(coefficients, at + 1e-30j, step).imag / 1e-30
    np.testing.assert_allclose(turned, spline_value(coefficients, at, step, 1))
    heights = rng.normal(size=10)
    np.testing.assert_allclose(
        spline_value(through(heights, step), step * np.arange(10), step), heights
    )


def test_the_woven_path_climbs_from_side_to_side():
    signs, a, s, w = (1, 1, -1), 0.3e-3, 5e-3, 3e-3
    x = np.linspace(-1.0, 1.0, 200_001) * s * 3
    z = woven_height(x, signs, a, s, w)
    at = woven_height(np.arange(-3, 4) * s, signs, a, s, w)
    np.testing.assert_allclose(at, a * np.array([1, 1, -1, 1, 1, -1, 1]))
    slope = np.diff(z) / np.diff(x)
    assert np.abs(np.diff(slope)).max() < 1e-4  # no kink
    long = np.sqrt(np.diff(x) ** 2 + np.diff(z) ** 2).sum()
    crimp = crimp_of(a, s, w, 2.0 / 3.0)
    assert long / np.ptp(x) - 1.0 == pytest.approx(crimp, rel=1e-6)
    assert crimp > 0.005
    assert amplitude_of(crimp, s, w, 2.0 / 3.0) == pytest.approx(a, rel=1e-9)


# the cell's record


def test_crimps_and_heights_must_fit():
    assert cell_of().amplitudes == (0.25e-3, 0.3e-3)  # half of what they cross
    # the warp fills more of its spacing than the weft does, and comes to it first or last
    assert cell_of().locking == min(math.acos(4.1 / 5.2), math.acos(3.9 / 4.8))
    assert cell_of().locking < math.acos(4.1 / 5.2) - 0.01
    wanted = cell_of().crimps
    both = cell_of(crimp=wanted)
    np.testing.assert_allclose(both.amplitudes, (0.25e-3, 0.3e-3), rtol=1e-9)
    flat = cell_of(crimp=(0.0, None))  # the weft waves round a straight warp
    np.testing.assert_allclose(flat.amplitudes, (0.0, 0.55e-3))
    assert flat.crimps[1] > 3.0 * wanted[1]
    with pytest.raises(InputError, match="correct one, or leave one crimp out"):
        cell_of(crimp=(2.0 * wanted[0], wanted[1]))
    assert cell_of(crimp=(2.0 * wanted[0], None)).crimps[0] == pytest.approx(2.0 * wanted[0])
    with pytest.raises(InputError, match=r"more than the .* % that heights"):
        cell_of(crimp=(0.2, None))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"width": (5.3e-3, 3.9e-3)}, "width_warp = 5.3 mm must be below spacing_warp = 5.2 mm"),
        ({"height": (0.0, 0.5e-3)}, "height_warp"),
        ({"stiffness": (44e3, -1.0)}, "stiffness_weft"),
        ({"bending": (0.0, 1e-7)}, "bending_warp"),
        ({"section": "disc"}, "unknown section 'disc'"),
        ({"friction": -0.1}, "friction"),
        ({"sticking_angle": 0.7}, "below 29°"),
        ({"crimp": (0.9, None)}, "above 0.5"),
        ({"slack": 0.0}, "slack"),
    ],
)
def test_cells_that_cannot_be_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        cell_of(**change)


def test_more_fibres_than_a_section_holds_are_refused():
    area = 2.0 / 3.0 * 4e-3 * 0.5e-3
    shares = fibre_shares("lens", (4e-3,) * 2, (0.5e-3,) * 2, (0.6 * area, 0.8 * area))
    np.testing.assert_allclose(shares, (0.6, 0.8))
    with pytest.raises(InputError, match="fibres fill 95 % of a weft yarn's section"):
        fibre_shares("lens", (4e-3,) * 2, (0.5e-3,) * 2, (0.6 * area, 0.95 * area))


# energies against differences


def shaken(model, seed=0):
    """Paths near the woven ones, all contacts in play."""
    rng = np.random.default_rng(seed)
    return 0.93 * model.woven * (1.0 + 0.01 * rng.normal(size=model.woven.size))


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


# geometry against points in space


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


# invariance


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


# closed forms

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


def test_a_curve_says_where_it_locks_and_where_neighbours_touch(monkeypatch):
    monkeypatch.setattr("warpdrape.unit_cell.loading.ANGLE_STEP", math.radians(6.0))
    model = build_model(balanced(weave=satin(), friction=0.0), elements=4, points=5)
    curve = shear(model, Loads((1.0, 1.0), largest_angle=math.radians(54.0)))
    strain = np.array([np.interp(curve.locking, curve.angles, e) for e in curve.strains.T])
    exact = math.acos(4.1 / (5.2 * (1.0 + strain.max())))
    assert math.degrees(abs(curve.locking - exact)) < 0.2
    narrower = [max(state.strain[3:]) for state in curve.states]
    at = np.interp(curve.touching, curve.angles, narrower)
    assert math.degrees(abs(curve.touching - math.acos(4.1 * (1.0 - at) / 5.2))) < 0.5
    assert curve.touching > curve.locking + math.radians(0.5)
    couples = np.interp(np.radians([0.0, 12.0, 40.0, 52.0]), curve.angles, curve.couples)
    assert couples[3] - couples[2] > 10.0 * (couples[1] - couples[0])


def test_the_mean_of_both_ways_of_shear_is_given():
    """States made up, harder to shear ahead than back."""
    model = build_model(cell_of(), elements=4, points=5)
    angles = np.radians([0.0, 20.0, 30.0])

    def state(angle, couple, friction):
        strain = np.array([0.0, 0.0, angle, 0.0, 0.0])
        return SimpleNamespace(strain=strain, couple=couple, friction=friction)

    both = [
        (state(0.0, 0.0, 1.0), state(-0.0, 0.0, 1.0)),
        (state(angles[1], 2.0, 3.0), state(-angles[1], -1.0, 1.0)),
        (state(angles[2], 5.0, 4.0), state(-angles[2], -3.0, 2.0)),
    ]
    curve = _curve(model, angles, both, "made up")
    np.testing.assert_allclose(curve.elastic, [0.0, 1.5, 4.0])
    np.testing.assert_allclose(curve.friction, [0.0, 2.0, 3.0], rtol=1e-6)
    np.testing.assert_allclose(curve.couples, [0.0, 3.5, 7.0], rtol=1e-6)
    assert curve.skew == pytest.approx(1.0 / 7.0)
    assert curve.end == "made up" and curve.locking is None


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


# loading


def test_held_tensions_are_held_and_friction_builds_up():
    model = build_model(cell_of(), elements=4, points=5)
    loads = Loads((2.0, 3.0), largest_angle=math.radians(20.0))
    curve = shear(model, loads)
    for state in curve.states:
        np.testing.assert_allclose(state.tension, (2.0, 3.0), rtol=1e-6)
    assert curve.angles[0] == 0.0 and curve.couples[0] == 0.0
    assert curve.angles[-1] == pytest.approx(math.radians(20.0))
    assert (np.diff(curve.couples) > 0.0).all()
    sliding = np.array([state.friction for state in curve.states])
    built = curve.friction / sliding
    np.testing.assert_allclose(built, 1.0 - np.exp(-np.degrees(curve.angles)), atol=1e-3)
    assert curve.end == "as asked for" and curve.locking is None and curve.touching is None


def test_more_elements_change_little():
    at = np.array([0.008, 0.006, 0.6])
    coarse, fine = (
        settle(build_model(cell_of(), elements, points), at)
        for elements, points in ((8, 9), (16, 17))
    )
    np.testing.assert_allclose(coarse.tension, fine.tension, rtol=0.01)
    assert coarse.couple == pytest.approx(fine.couple, rel=0.02)
    assert coarse.friction == pytest.approx(fine.friction, rel=0.02)


def test_axes_of_a_table_hold_no_strain_and_the_crimp():
    model = build_model(cell_of())
    warp, weft = strain_axes(model, Loads((1.0, 1.0)))
    for axis, crimp in ((warp, model.cell.crimps[0]), (weft, model.cell.crimps[1])):
        assert np.abs(axis).min() < 1e-15
        assert axis[0] <= -crimp < axis[1]
        assert axis[-1] == pytest.approx(max(model.cell.crimps) + 0.003, rel=0.01)
        assert np.ptp(np.diff(axis)) < 1e-15
    angles = shear_angles(model, Loads((1.0, 1.0)))
    assert angles[-1] == pytest.approx(model.cell.locking + math.radians(8.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"shear_tension": (0.0, 1.0)}, "shear_tension_warp"),
        ({"largest_strain": 0.5}, "20 %"),
        ({"largest_angle": 1.5}, "10 … 80°"),
        ({"points": 2}, "5 … 41"),
    ],
)
def test_loads_that_say_nothing_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        Loads(**{"shear_tension": (1.0, 1.0), **change})


def test_a_cell_that_finds_no_rest_says_where_and_what_to_try():
    model = build_model(cell_of(), elements=4, points=5)
    with pytest.raises(RunFailed, match=r"γ = 85\.94°: give a smaller largest_angle"):
        settle(model, np.array([0.0, 0.0, 1.5]), tension=(5.0, 5.0))


@pytest.mark.slow
def test_a_curve_ends_where_no_rest_is_found(monkeypatch):
    monkeypatch.setattr("warpdrape.unit_cell.loading.ANGLE_STEP", math.radians(8.0))
    model = build_model(cell_of(), elements=4, points=5)
    far = shear(model, Loads((2.0, 2.0), largest_angle=math.radians(72.0)))
    assert far.end.startswith("beyond it no rest was found")
    assert 40.0 < math.degrees(far.angles[-1]) < 72.0

"""Bars of yarns that slide: forces and pulls are slopes of one energy, for every tension law."""

import math
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from law_checks import PLAIN, SPACING, UNEQUAL, crimp_table
from sliding_checks import FREE, YARNS, Led, blank, cloth, saw_tooth_yarns
from test_yarn_net import Led as Pinned
from test_yarn_net import shaken, turned

from warpdrape.blanks.yarn_chains import NONE
from warpdrape.forces.ply_net import net_of
from warpdrape.forces.sliding_chains import mates_of
from warpdrape.materials.law_data import tension_stiffness
from warpdrape.materials.laws import TabulatedTension
from warpdrape.numerics import Numerics

LAWS = {"linear": YARNS, "crimp": UNEQUAL, "tabulated": crimp_table()}
MESHES = [("diagonal", 0.0, 3), ("aligned", 0.0, 3), ("aligned", math.pi / 4, 4)]


def laws():
    return pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def slope_of(energy, step):
    """Fourth-order central difference of ``energy(k step)``."""
    w = [energy(k * step) for k in (-2, -1, 1, 2)]
    return (8.0 * (w[2] - w[1]) - (w[3] - w[0])) / (12.0 * step)


def assert_loads_are_slopes(led, x, s, rng, step=1e-8, tolerance=1e-6):
    """F = −∂W/∂x and Q = −∂W/∂s in a few directions; returns the pulls."""
    slides = led.slides(s=s)
    forces, pulls = led.step(x, slides)[0], led.pulls(x, slides)
    for _ in range(4):
        way, through = rng.uniform(-1, 1, x.shape), rng.uniform(-1, 1, s.shape)
        for dx, ds, slope in (
            (way, 0 * s, (forces * way).sum()),
            (0 * x, through, (pulls * through).sum()),
        ):

            def energy(k, dx=dx, ds=ds):
                return led.energy(x + k * dx, led.slides(s=s + k * ds))

            found = -slope_of(energy, step)
            assert abs(found) > 1.0
            assert slope == pytest.approx(found, rel=tolerance)
    return pulls


@pytest.mark.parametrize(("mesh", "angle", "cells"), MESHES)
@pytest.mark.parametrize("factor", [1.0, 0.3])
def test_forces_and_pulls_are_the_slopes_of_the_energy(mesh, angle, cells, factor, device):
    """With slides of a third of a bar."""
    rng = np.random.default_rng(5)
    ply = blank(cloth(factor=factor, **FREE), cells, mesh, angle)
    led = Led(ply, device)
    spacing = led.of.chains.lengths.min()
    s = spacing * rng.uniform(-0.12, 0.12, (led.count, 2))
    assert led.of.chains.left(s)[led.of.chains.span > 0.0].min() > 0.5
    x = 1.01 * shaken(ply, rng, 0.05 * spacing, 0.2)
    assert_loads_are_slopes(led, x, s, rng)


@pytest.mark.parametrize(("mesh", "angle", "cells"), MESHES)
@pytest.mark.parametrize("law", [UNEQUAL, LAWS["tabulated"]], ids=["crimp", "tabulated"])
def test_so_are_those_of_families_that_pull_each_other(law, mesh, angle, cells, device):
    """Ends of yarns that go by their crossovers, too, where the coupling goes with them."""
    rng = np.random.default_rng(5)
    ply = blank(cloth(law, factor=0.3, **FREE), cells, mesh, angle)
    led = Led(ply, device)
    spacing = led.of.chains.lengths.min()
    s = spacing * rng.uniform(-0.12, 0.12, (led.count, 2))
    end = led.of.chains.bars[:, 0] == NONE
    s[end, 0] = -0.3 * spacing  # drawn into the ply
    left = led.of.chains.left(s)
    assert (left[end, 0] < 0.8).all() and left[led.of.chains.span > 0.0].min() > 0.2
    x = 1.02 * shaken(ply, rng, 0.01 * spacing, 0.2)
    assert_loads_are_slopes(led, x, s, rng, tolerance=2e-6)


@laws()
def test_without_slides_they_are_the_pinned_yarns(law):
    rng = np.random.default_rng(2)
    for mesh, angle in (("diagonal", 0.0), ("aligned", math.pi / 4)):
        ply = blank(cloth(law), mesh=mesh, warp_angle=angle, cells=4)
        led, pinned = Led(ply), Pinned(ply)
        x = shaken(ply, rng)
        one, other = led.step(x, led.slides())[0], pinned.forces(x)
        assert np.abs(other).max() > 1.0
        np.testing.assert_allclose(one, other, atol=1e-11 * np.abs(other).max())
        stored, lost, fields = led.measure(x, led.slides())
        energies = pinned.energy(x)
        names = ("yarn", "shear", "stabiliser")
        rest = pinned.energy(ply.rest_points)[0]  # a table's energy has a constant
        energies[0] -= rest
        np.testing.assert_allclose([stored[n] for n in names], energies, rtol=1e-11, atol=1e-16)
        assert set(lost.values()) == {0.0} and not fields["yarn_slide"].any()


def test_without_slides_strains_and_tensions_shown_are_those_of_pinned_yarns():
    rng, ply = np.random.default_rng(2), blank(mesh="aligned", warp_angle=math.pi / 4, cells=4)
    led, pinned, x = Led(ply), Pinned(ply), shaken(ply, rng)
    fields = led.measure(x, led.slides())[2]
    strain, tension, _ = pinned.of.measure(wp.array(x, dtype=wp.vec3d, device="cpu"))
    np.testing.assert_allclose(fields["strain"], strain, atol=1e-14)
    np.testing.assert_allclose(fields["line_tension"], tension, atol=1e-8)


def saw_tooth(law, stretched, longer):
    """Tensions of warp and weft along the sheet [N], as of `saw_tooth_yarns`."""
    yarns, heights = saw_tooth_yarns(law, stretched, longer)
    spacing = np.array([law.spacing_warp, law.spacing_weft]) * stretched
    return yarns * spacing / np.hypot(spacing, heights)


def tensions_with_more_yarn(material, more, strain):
    """Of warp and weft [N per yarn] inside a ply whose every bar has so much more warp in it."""
    ply = blank(material, cells=5)
    led, rest = Led(ply), ply.rest_points
    s = np.zeros((led.count, 2))
    s[:, 0] = more * rest[led.of.chains.vertices, 0]
    x = rest * (*(1.0 + strain) * (1.0 + more, 1.0), 1.0)  # yarns are strained alike
    tension = led.measure(x, led.slides(s=s))[2]["line_tension"]
    inner = np.abs(rest[np.asarray(ply.mesh.triangles)].mean(axis=1)[:, :2]).max(axis=1) < 0.003
    return tension[inner].mean(axis=0) * ply.fabric.yarn_width


@pytest.mark.parametrize("more", [0.0, 0.02, 0.1])
def test_a_cell_with_more_yarn_pulls_as_its_saw_teeth_do(more):
    """Crimp interchange exactly; its table, which knows no heights, within a few per cent."""
    strain, longer = np.array([0.006, 0.005]), np.array([1.0 + more, 1.0])
    exact = saw_tooth(PLAIN, longer * (1.0 + strain), longer)
    assert exact.min() > 50.0
    found = tensions_with_more_yarn(cloth(PLAIN, factor=0.01, **FREE), more, strain)
    np.testing.assert_allclose(found, exact, rtol=1e-6)
    table = replace(cloth(crimp_table(), **FREE), cell_warp=SPACING, cell_weft=SPACING)
    off = np.abs(tensions_with_more_yarn(table, more, strain) / exact - 1.0).max()
    assert 0.7 * more < off + 1e-3 and off < 0.75 * more + 1e-3  # figures of docs/approaches.md


def test_the_quadrants_of_a_bar_are_those_of_the_net():
    ply = blank(mesh="aligned", warp_angle=0.4, cells=11)
    led, net = Led(ply), net_of(ply)
    chains = led.of.chains
    mates, areas = mates_of(chains, net.areas)
    pairs = {}
    for (warp, weft), area in zip(chains.quadrants, net.areas, strict=True):
        for own, other in ((warp, weft), (weft, warp)):
            pairs.setdefault(own, []).append((other, area))
    for b, (row, shared) in enumerate(zip(mates, areas, strict=True)):
        found = [(m, a) for m, a in zip(row, shared, strict=True) if m != NONE]
        assert sorted(found) == sorted(pairs[b])
        assert shared[row == NONE].sum() == 0.0
    assert (mates != NONE).sum() == 2 * len(net.areas)


@laws()
def test_rigid_motion_pulls_at_nothing_and_no_motion_gives_a_net_force(law):
    ply = blank(cloth(law), mesh="aligned", warp_angle=0.4, cells=11)
    led, rng = Led(ply), np.random.default_rng(8)
    x = ply.rest_points @ turned(rng).T + 0.1
    moved, flat = (led.pulls(at, led.slides()) for at in (x, ply.rest_points))
    scale = 0.01 * max(tension_stiffness(ply.fabric))  # a bar's width
    assert np.abs(moved - flat).max() < 1e-10 * scale
    assert np.abs(flat).max() < (1e-4 if isinstance(law, TabulatedTension) else 1e-14) * scale
    slides = led.slides(s=1e-4 * rng.uniform(-1, 1, (led.count, 2)))
    x = shaken(ply, rng)
    f = led.step(x, slides)[0]
    scale = np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < 1e-13 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-12 * scale * np.abs(x).max()


@pytest.mark.parametrize(("law", "angle", "cells"), [(YARNS, 0.4, 11), (PLAIN, 0.0, 4)])
def test_a_taut_chain_does_not_slide_by_itself(law, angle, cells):
    """A yarn's tension is alike on both sides of a crossover in a uniform stretch.

    Of uneven width, too, where families do not pull each other; else where widths are even.
    """
    ply = blank(cloth(law), mesh="aligned", warp_angle=angle, cells=cells)
    led = Led(ply)
    x = 1.001 * ply.rest_points
    pulls, bars = led.pulls(x, led.slides()), led.of.chains.bars.reshape(-1, 2, 2)
    inner = (bars != NONE).all(axis=2)
    assert inner.any() and np.abs(pulls[~inner]).max() > 0.01
    assert np.abs(pulls[inner]).max() < 1e-9 * np.abs(pulls).max()


def test_chains_of_uneven_width_that_pull_each_other_even_it_out_by_hundredths_of_a_millimetre():
    """Beside a slanting border the coupling is that of fewer crossings: not nothing, but little."""
    weak = {"slip_force_warp": 1e-6, "slip_force_weft": 1e-6}
    led = Led(blank(cloth(PLAIN, **weak), mesh="aligned", warp_angle=0.4, cells=11))
    inner = (led.of.chains.bars != NONE).all(axis=1)
    ends = wp.array(np.where(inner, 0, 1), dtype=wp.int32, device="cpu")
    led.of.crossovers.held = ends
    x, slides = 1.004 * led.scene.plies[0].rest_points, led.slides()
    before = np.abs(led.pulls(x, slides)[inner]).max()
    for _ in range(600):
        slides = led.step(x, slides)[1]
        slides["rate"] *= 0.9
    assert inner.sum() > 50 and before > 30.0
    assert np.abs(led.pulls(x, slides)[inner]).max() < 1e-3 * before
    assert 5e-6 < np.abs(slides["s"]).max() < 1.2e-5


def test_viscosity_resists_what_changes_and_loses_energy_by_it():
    """After a step of strain it is η times that, then nothing; its work is half of the product."""
    ply = blank(cloth(factor=0.01, **FREE))
    led, plain = Led(ply, numerics=Numerics(yarn_viscosity=0.1)), Led(ply)
    x, memory = 1.001 * ply.rest_points, led.of.start()
    first = led.step(x, led.slides(), memory)[0]
    again = led.step(x, led.slides(), memory)[0]
    expected = plain.step(x, led.slides())[0]
    scale = np.abs(expected).max()
    np.testing.assert_allclose(first, 1.1 * expected, atol=1e-9 * scale)
    np.testing.assert_allclose(again, expected, atol=1e-9 * scale)
    stored = plain.measure(x, led.slides())[0]["yarn"]
    assert memory.bars.numpy()["lost"].sum() == pytest.approx(0.1 * stored, rel=1e-9)

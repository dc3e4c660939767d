"""Yarns that slide through their crossovers: chains, pulls, springs that slip, pull-out, runs."""

import dataclasses
import math

import numpy as np
import pytest
import warp as wp
from law_checks import PLAIN, fabric
from sliding_checks import COUPLE, HOLD, YARNS, Led, blank, cloth, scene_of
from test_engine import small_press
from test_threads import assert_same_bits, state_after
from test_yarn_net import Led as Pinned
from test_yarn_net import shaken, turned

import warpdrape as wd
from warpdrape.blanks.yarn_chains import NONE, chain_yarns
from warpdrape.coupons.pull_out import PullOut
from warpdrape.errors import InputError
from warpdrape.forces.sliding_yarns import CLOSEST, frequencies, slides_share
from warpdrape.forces.yarns import net_of
from warpdrape.kernels.forces.sliding_yarns import (
    SLIDES_SHARE,
    Crossovers,
    gripped,
    share_left,
    yarn_left,
)
from warpdrape.materials.fabric_card import card
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import CrimpInterchange, LinearTension, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.scenes import bias_extension, yarn_pull_out
from warpdrape.setup import Clamp

FREE = {"slip_force_warp": 100.0, "slip_force_weft": 100.0, "stiffness_warp": 1e5}
FREE["stiffness_weft"] = 1e5
"""Crossovers that do not slip where they are only led a little."""


@pytest.mark.parametrize(
    ("mesh", "angle", "cells"),
    [("diagonal", 0.0, 4), ("aligned", 0.0, 4), ("aligned", math.pi / 4, 4), ("aligned", 0.4, 11)],
)
def test_chains_hold_every_yarn_of_the_ply_from_end_to_end(mesh, angle, cells):
    ply = blank(mesh=mesh, warp_angle=angle, cells=cells)
    chains, net = chain_yarns(net_of(ply)), net_of(ply)
    for family in (0, 1):
        own = chains.family == family
        covered = (chains.widths * chains.lengths)[own].sum()
        assert covered == pytest.approx(ply.mesh.areas.sum(), rel=1e-12)
        before, after = chains.bars[:, 2 * family], chains.bars[:, 2 * family + 1]
        inner = (before != NONE) & (after != NONE)
        np.testing.assert_allclose(
            chains.widths[before[inner]], chains.widths[after[inner]], rtol=1e-12
        )
        # the flat coordinate along the yarn tells the same lengths
        along = ply.mesh.vertices[chains.vertices] @ ply.yarn_directions[family]
        upper = chains.numbers[own]
        way = along[upper[:, 1]] - along[upper[:, 0]]
        np.testing.assert_allclose(way, chains.lengths[own], rtol=1e-9)
        moved = chains.below[upper[:, 1], family] - chains.below[upper[:, 0], family]
        np.testing.assert_allclose(moved, way, rtol=1e-9)
        whole = chains.below[:, family] + chains.above[:, family]
        np.testing.assert_allclose(whole[upper[:, 0]], whole[upper[:, 1]], rtol=1e-12)
        assert chains.below[before == NONE, family].max() == 0.0
        assert np.abs(chains.above[after == NONE, family]).max() < 1e-12
        for k, b in enumerate(net.quadrants[:9]):
            ends = set(chains.ends[chains.quadrants[k, family]])
            assert ends == {b[0], b[1 + family]}
    assert chains.areas.sum() == pytest.approx(ply.mesh.areas.sum(), rel=1e-12)


def test_what_is_left_of_a_yarn_in_a_crossover():
    """Whole until its end comes into the crossover's length, none when it has gone by."""
    cases = [
        ((0.5, 0.5, 0.2), 0.0, 1.0),
        ((0.2, 0.9, 0.2), 0.0, 1.0),
        ((0.2, 0.9, 0.2), -0.05, 0.75),
        ((0.2, 0.9, 0.2), -0.25, 0.0),
        ((0.9, 0.2, 0.2), 0.15, 0.25),
        ((0.9, 0.2, 0.2), -0.15, 1.0),
        ((0.0, 0.0, 0.0), 0.0, 0.0),
    ]
    for (below, above, span), s, left in cases:
        assert _on_device(share_left, below, above, span, s) == pytest.approx(left, abs=1e-12)
    led, rng = Led(blank()), np.random.default_rng(3)
    slides = rng.uniform(-0.03, 0.03, (led.count, 2))
    on_host = led.of.chains.left(slides)
    assert 0.1 < (on_host > 0.0).mean() < 0.9
    found = wp.zeros(led.count, dtype=wp.vec2d, device="cpu")
    given = wp.array(slides, dtype=wp.vec2d, device="cpu")
    inputs = [led.of.crossovers, given]
    wp.launch(_shares, led.count, inputs=inputs, outputs=[found], device="cpu")
    np.testing.assert_allclose(found.numpy(), on_host, atol=1e-12)


@wp.kernel
def _shares(crossovers: Crossovers, s: wp.array(dtype=wp.vec2d), left: wp.array(dtype=wp.vec2d)):
    v = wp.tid()
    left[v] = wp.vec2d(yarn_left(crossovers, v, 0, s[v][0]), yarn_left(crossovers, v, 1, s[v][1]))


@wp.kernel
def _share(a: wp.vec4d, out: wp.array(dtype=wp.float64)):
    out[0] = share_left(a[0], a[1], a[2], a[3])


@wp.kernel
def _grip(a: wp.vec3d, b: wp.vec3d, out: wp.array(dtype=wp.float64)):
    found = gripped(a[0], a[1], a[2], b[0], b[1], b[2])
    out[0] = found.rate
    out[1] = found.elongation


def _on_device(_, *numbers):
    out = wp.zeros(1, dtype=wp.float64, device="cpu")
    wp.launch(_share, 1, inputs=[wp.vec4d(*numbers)], outputs=[out], device="cpu")
    return float(out.numpy()[0])


def grip(pull, rate, elongation, inertia, spring, limit):
    out = wp.zeros(2, dtype=wp.float64, device="cpu")
    both = [wp.vec3d(pull, rate, elongation), wp.vec3d(inertia, spring, limit)]
    wp.launch(_grip, 1, inputs=both, outputs=[out], device="cpu")
    return map(float, out.numpy())


def test_a_crossing_holds_and_slips_as_coulomb_says():
    """M Δr = Q − k e with the new e, and |k e| ≤ F."""
    rng = np.random.default_rng(1)
    held = slipped = 0
    for _ in range(200):
        inertia, spring, limit = 10.0 ** rng.uniform(3, 6, 3) * (1.0, 1.0, 1e-5)
        most = limit / spring
        e, rate = most * rng.uniform(-1, 1), most * rng.uniform(-3, 3)
        pull = limit * rng.uniform(-3, 3)
        after, elongation = grip(pull, rate, e, inertia, spring, limit)
        force = spring * elongation
        assert abs(force) <= limit * (1.0 + 1e-12)
        balance = inertia * (after - rate) + force - pull
        assert abs(balance) < 1e-9 * (abs(pull) + inertia * abs(rate) + limit)
        slip = after - (elongation - e)
        if abs(slip) < 1e-12 * most:
            held += 1
        else:
            slipped += 1
            assert abs(force) == pytest.approx(limit, rel=1e-12) and slip * force > 0.0
    assert held > 20 and slipped > 20
    _, elongation = grip(0.0, 0.0, 1.0, 1e5, 1e4, 1.0)  # a limit that has fallen
    assert 0.5e-4 < elongation < 1e-4


@pytest.mark.parametrize(
    ("mesh", "angle", "cells"),
    [("diagonal", 0.0, 3), ("aligned", 0.0, 3), ("aligned", math.pi / 4, 4)],
)
@pytest.mark.parametrize("factor", [1.0, 0.3])
def test_forces_and_pulls_are_the_slopes_of_the_energy(mesh, angle, cells, factor, device):
    """F = −∂W/∂x and Q = −∂W/∂s, with slides of a third of a bar."""
    rng = np.random.default_rng(5)
    ply = blank(cloth(factor=factor, **FREE), cells, mesh, angle)
    led = Led(ply, device)
    spacing = led.of.chains.lengths.min()
    s = spacing * rng.uniform(-0.12, 0.12, (led.count, 2))
    slides = led.slides(s=s)
    assert led.of.chains.left(s)[led.of.chains.span > 0.0].min() > 0.5
    x = 1.01 * shaken(ply, rng, 0.05 * spacing, 0.2)
    forces, pulls = led.step(x, slides)[0], led.pulls(x, slides)
    for _ in range(4):
        way, through = rng.uniform(-1, 1, x.shape), rng.uniform(-1, 1, s.shape)
        for dx, ds, slope in (
            (way, 0 * s, (forces * way).sum()),
            (0 * x, through, (pulls * through).sum()),
        ):
            step = 1e-8
            w = [
                led.energy(x + k * step * dx, led.slides(s=s + k * step * ds))
                for k in (-2, -1, 1, 2)
            ]
            found = -(8.0 * (w[2] - w[1]) - (w[3] - w[0])) / (12.0 * step)
            assert abs(found) > 1.0
            assert slope == pytest.approx(found, rel=1e-6)


def test_without_slides_they_are_the_pinned_yarns():
    rng = np.random.default_rng(2)
    for mesh, angle in (("diagonal", 0.0), ("aligned", math.pi / 4)):
        ply = blank(mesh=mesh, warp_angle=angle, cells=4)
        led, pinned = Led(ply), Pinned(ply)
        x = shaken(ply, rng)
        one, other = led.step(x, led.slides())[0], pinned.forces(x)
        assert np.abs(other).max() > 1.0
        np.testing.assert_allclose(one, other, atol=1e-11 * np.abs(other).max())
        stored, lost, fields = led.measure(x, led.slides())
        energies = pinned.energy(x)
        names = ("yarn", "shear", "stabiliser")
        np.testing.assert_allclose([stored[n] for n in names], energies, rtol=1e-11, atol=1e-18)
        assert set(lost.values()) == {0.0} and not fields["yarn_slide"].any()
        strain, tension, _ = pinned.of.measure(wp.array(x, dtype=wp.vec3d, device="cpu"))
        np.testing.assert_allclose(fields["strain"], strain, atol=1e-14)
        np.testing.assert_allclose(fields["line_tension"], tension, atol=1e-8)


def test_springs_store_half_of_force_times_elongation_on_what_is_left():
    led, rng = Led(blank()), np.random.default_rng(6)
    s, e = (size * rng.uniform(-1, 1, (led.count, 2)) for size in (4e-3, 1e-6))
    left, chains = led.of.chains.left(s), led.of.chains
    assert left.min() < 0.5
    crossings = (chains.areas / cloth().cell_area)[:, None]
    stored = led.measure(led.scene.plies[0].rest_points, led.slides(s=s, grip=e))[0]["crossover"]
    assert stored == pytest.approx((0.5 * left * crossings * (2e4, 3e4) * e**2).sum(), rel=1e-12)


def test_rigid_motion_pulls_at_nothing_and_no_motion_gives_a_net_force():
    ply, rng = blank(mesh="aligned", warp_angle=0.4, cells=11), np.random.default_rng(8)
    led = Led(ply)
    at_rest = led.slides()
    x = ply.rest_points @ turned(rng).T + 0.1
    assert np.abs(led.pulls(x, at_rest)).max() < 1e-8 * YARNS.warp
    slides = led.slides(s=1e-4 * rng.uniform(-1, 1, (led.count, 2)))
    x = shaken(ply, rng)
    f = led.step(x, slides)[0]
    scale = np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < 1e-13 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-12 * scale * np.abs(x).max()


def test_a_taut_chain_of_uneven_width_does_not_slide_by_itself():
    """A yarn's tension is alike on both sides of a crossover in a uniform stretch."""
    ply = blank(mesh="aligned", warp_angle=0.4, cells=11)
    led = Led(ply)
    x = 1.001 * ply.rest_points
    pulls, bars = led.pulls(x, led.slides()), led.of.chains.bars.reshape(-1, 2, 2)
    inner = (bars != NONE).all(axis=2)
    assert inner.any() and np.abs(pulls[~inner]).max() > 1.0
    assert np.abs(pulls[inner]).max() < 1e-9 * np.abs(pulls).max()


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


def test_the_crossed_yarns_tension_holds_a_yarn():
    """Slip force = F + μ T of the crossed yarn, T in N, for every crossing of single yarns."""
    material = cloth(friction=0.25, stiffness_warp=1e7, stiffness_weft=1e7)
    ply = blank(material, cells=3)
    led = Led(ply)
    strain = 2e-3
    x = ply.rest_points * (1.0, 1.0 + strain, 1.0)  # the weft is taut
    after = led.step(x, led.slides(rate=1e-3))[1]["grip"]
    crossings = led.of.chains.areas / material.cell_area
    force = after * led.of.crossovers.stiffness.numpy()
    tension = YARNS.weft * strain
    np.testing.assert_allclose(force[:, 0], crossings * (0.1 + 0.25 * tension), rtol=1e-9)
    np.testing.assert_allclose(force[:, 1], crossings * 0.2, rtol=1e-9)
    inner = crossings.max()
    assert inner == pytest.approx(1e-4 / material.cell_area, rel=1e-9)


def test_no_more_yarn_leaves_a_bar_than_its_crossing_yarns_leave_room_for():
    border = Clamp(name="border", ply="p", where=lambda p: np.abs(p[:, :2]).max(axis=1) > 0.0149)
    led = Led(blank(cloth(slip_force_warp=1e-6, slip_force_weft=1e-6)), clamps=[border])
    rng = np.random.default_rng(4)
    chains, x = led.of.chains, led.scene.plies[0].rest_points
    slides = led.slides()
    closest = 1.0
    for _ in range(400):
        slides["rate"] += 1e-3 * rng.uniform(-1, 1, (led.count, 2))
        slides = led.step(x, slides)[1]
        at = slides["s"][chains.numbers, chains.family[:, None]]
        there = chains.left(slides["s"])[chains.numbers, chains.family[:, None]].min(axis=1) > 0
        length = 1.0 + (at[:, 1] - at[:, 0]) / chains.lengths
        closest = min(closest, length[there].min())
    assert CLOSEST * (1.0 - 1e-9) <= closest < CLOSEST + 0.02


def amplification(led, step):
    """Matrix of a step of vertices, their velocities, slides, springs and rates, by differences."""
    x0, count = led.scene.plies[0].rest_points, led.count
    sizes = [x0.size, *[2 * count] * 3]
    mass = led.scene.plies[0].fabric.areal_density * led.scene.plies[0].mesh.vertex_areas
    mass = np.repeat(mass, 3)

    def after(z):
        x, v, s, e, r = np.split(z, np.cumsum([x0.size, *sizes])[:-1])
        slides = led.slides(
            **{n: a.reshape(-1, 2) for n, a in zip(("s", "grip", "rate"), (s, e, r), strict=True)}
        )
        f, now = led.step(x0 + x.reshape(x0.shape), slides)
        v = v + step * f.ravel() / mass
        return np.concatenate([x + step * v, v, *(now[n].ravel() for n in ("s", "grip", "rate"))])

    total = sum(sizes) + x0.size
    scale = np.ones(total)
    scale[x0.size : 2 * x0.size] = 1.0 / step
    columns = []
    for k in range(total):
        way = np.zeros(total)
        way[k] = 1e-9 * scale[k]
        columns.append((after(way) - after(-way)) / (2e-9 * scale[k]))
    return np.array(columns).T


@pytest.mark.parametrize(("mesh", "hold"), [("diagonal", 1e-3), ("aligned", 1e5)])
def test_a_step_is_stable_with_what_slides_take_of_it_and_not_without(mesh, hold):
    """(Δt ω)² = 4 − q_s of the pinned net is the limit; the scene's own step is well below."""
    weak = {name: value if "slip" in name else hold for name, value in FREE.items()}
    weak |= {"slip_force_warp": 5e-4 * hold, "slip_force_weft": 5e-4 * hold}
    led = Led(blank(cloth(shear=ShearPolynomial((4e-4,)), **weak), cells=2, mesh=mesh))
    x0 = led.scene.plies[0].rest_points
    mass = np.repeat(
        led.scene.plies[0].fabric.areal_density * led.scene.plies[0].mesh.vertex_areas, 3
    )
    rows = []
    for k in range(x0.size):
        way = np.zeros(x0.size)
        way[k] = 1e-9
        way = way.reshape(x0.shape)
        f = [led.step(x0 + sign * way, led.slides())[0] for sign in (1, -1)]
        rows.append((f[0] - f[1]).ravel() / 2e-9)
    highest = np.abs(np.linalg.eigvals(np.array(rows) / mass)).max()
    bound = frequencies(led.scene, 0).max()
    assert 0.1 * bound < highest < bound
    for taken, stable in ((SLIDES_SHARE, True), (0.0, False)):
        step = math.sqrt((4.0 - taken) / highest)
        radius = np.abs(np.linalg.eigvals(amplification(led, step))).max()
        assert (radius < 1.0 + 1e-6) == stable, radius
        assert stable or radius > 1.2


def test_slides_take_of_the_step_and_say_when_too_little_is_left():
    scene = scene_of(blank())
    assert slides_share(scene, 0.0) == SLIDES_SHARE
    assert slides_share(dataclasses.replace(scene, approach="yarns"), 0.0) == 0.0
    greedy = Numerics(contact_share=0.2, contact_damping=0.6)
    scene = dataclasses.replace(small_press(numerics=greedy, clamps=[]), approach="sliding_yarns")
    with pytest.raises(InputError, match=r"contact_share = 0\.2 .*beside yarns that slide: lower"):
        slides_share(scene, 2.9)


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


def test_clamps_grip_yarns_unless_they_are_told_not_to():
    ply = blank(cloth(slip_force_warp=1e-6, slip_force_weft=1e-6))

    def side(name, yarns):
        sign = -1.0 if name == "left" else 1.0
        return Clamp(name=name, ply="p", where=lambda p: sign * p[:, 0] > 0.0149, yarns=yarns)

    led = Led(ply, clamps=[side("left", "held"), side("right", "free")])
    x = 1.001 * ply.rest_points
    rate = led.step(x, led.slides())[1]["rate"]
    at = ply.rest_points[led.of.chains.vertices]
    assert not rate[at[:, 0] < -0.0149].any()
    assert (np.abs(rate[at[:, 0] > 0.0149, 0]) > 1e-9).all()
    with pytest.raises(InputError, match=r"yarns of clamp 'left'.*'loose'"):
        side("left", "loose")


def test_bias_extension_with_strong_crossovers_is_that_of_pinned_ones():
    material = dataclasses.replace(
        load_fabric("carbon_interlock"),
        bending=None,
        compressive_factor=1.0,
        crossover=wd.Crossover(**HOLD | FREE | {"stiffness_warp": 1e7, "stiffness_weft": 1e7}),
    )
    small = {"edge": 0.025, "shear_angle_deg": 30.0, "duration": 0.03}
    result = bias_extension.build(fabric=material, approach="sliding_yarns", **small).run(frames=40)
    assert abs(result.summary["coupon"]["force_error"]) < 0.01  # as asked at 30°
    assert result.summary["energy_error"] < 1e-3
    assert 0.0 < np.abs(result.plies[0].yarn_slide).max() < 1e-5


def test_what_a_fabric_lacks_is_said():
    ply = blank(fabric(YARNS, COUPLE))
    scene = scene_of(ply)
    with pytest.raises(InputError, match=r"needs the \[crossover\] of fabric 'test' of ply 'p'"):
        scene.run()
    assert dataclasses.replace(scene, approach="yarns", duration=1e-4).run(frames=1).completed
    coupled = dataclasses.replace(fabric(PLAIN), crossover=wd.Crossover(**HOLD))
    ply = blank(coupled)
    with pytest.raises(InputError, match=r"'test' of ply 'p' couples warp and weft.*'linear'"):
        scene_of(ply).run()
    assert isinstance(coupled.tension, CrimpInterchange)
    linear = dataclasses.replace(coupled, tension=LinearTension(1e3, 1e3))
    scene = scene_of(blank(linear))
    assert dataclasses.replace(scene, duration=1e-4).run(frames=1).completed


CROSSOVER = """
[crossover]
[crossover.slip_force_warp]
value = 12
unit = "cN"
status = "assumed"
source = "made up"
[crossover.slip_force_weft]
value = 0.2
unit = "N"
status = "assumed"
source = "made up"
[crossover.stiffness_warp]
value = 20
unit = "N/mm"
status = "measured"
source = "slope of a pull-out"
[crossover.stiffness_weft]
value = 3e4
unit = "N/m"
status = "assumed"
source = "made up"
"""


def fabric_file(tmp_path, text):
    from importlib import resources

    given = resources.files("warpdrape.fabrics").joinpath("carbon_interlock.toml")
    file = tmp_path / "mine.toml"
    file.write_text(given.read_text(encoding="utf-8") + text, encoding="utf-8")
    return file


def test_a_fabric_file_gives_its_crossover(tmp_path):
    cloth = load_fabric(fabric_file(tmp_path, CROSSOVER))
    assert cloth.crossover == wd.Crossover(
        slip_force_warp=0.12, slip_force_weft=0.2, stiffness_warp=2e4, stiffness_weft=3e4
    )
    shown = card(cloth)
    assert "crossover.slip_force_warp  12 cN" in shown and "slope of a pull-out" in shown
    assert "crossover.friction" not in shown
    friction = '[crossover.friction]\nvalue = 20\nunit = "%"\nstatus = "assumed"\nsource = "s"\n'
    cloth = load_fabric(fabric_file(tmp_path, CROSSOVER + friction))
    assert cloth.crossover.friction == 0.2 and "crossover.friction" in card(cloth)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"N/m"', '"N"'), r"line \d+: key 'crossover.stiffness_weft.unit': 'N' is no unit of"),
        (("value = 3e4", "value = 0"), r"stiffness_weft.value'.*must be above zero"),
        (("[crossover.slip_force_weft]", "[crossover.slip_weft]"), r"'crossover.slip_weft': unk"),
        (("value = 3e4", "value = 30"), r"gives way by 6\.67 mm before the yarn slips at 0\.2 N"),
    ],
)
def test_a_fault_in_it_is_named_with_its_line(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_fabric(fabric_file(tmp_path, CROSSOVER.replace(*change)))


def test_a_crossover_is_one():
    with pytest.raises(InputError, match=r"crossover = 0\.3 is no warpdrape.Crossover"):
        dataclasses.replace(fabric(YARNS), crossover=0.3)
    with pytest.raises(InputError, match=r"friction = 20 is above 2"):
        wd.Crossover(**HOLD, friction=20.0)


def sliding_press(aligned=True, **changes):
    """Two plies on a table, whose crossovers slip early."""
    hold = {"slip_force_warp": 2e-3, "slip_force_weft": 2e-3}
    hold |= {"stiffness_warp": 100.0, "stiffness_weft": 100.0, "friction": 0.1}
    plies, square = [], small_press().plies[0].mesh
    for ply in small_press().plies:
        angle = ply.warp_angle if aligned else 0.0
        mesh = blank(cells=12, mesh="aligned", warp_angle=angle).mesh if aligned else square
        material = dataclasses.replace(ply.fabric, crossover=wd.Crossover(**hold))
        plies.append(dataclasses.replace(ply, mesh=mesh, fabric=material, warp_angle=angle))
    return small_press(plies=plies, clamps=[], approach="sliding_yarns", **changes)


def test_threads_compute_what_one_part_after_another_does():
    scene = sliding_press()
    together, _ = state_after(2, True, scene, blocks=40)
    alone, _ = state_after(2, False, scene, blocks=40)
    assert_same_bits(together, alone)
    slides = [values for name, values in together.items() if name.endswith(".slides")]
    assert len(slides) == 2 and all(values["s"].any() for values in slides)


def test_a_press_balances_its_energy_and_shows_its_slides():
    result = sliding_press().run(frames=3)
    assert result.completed and result.summary["energy_error"] < 0.01
    history = result.history
    assert history["yarn_slip_j"][-1] > 1e-4 * history["external_work_j"][-1]
    assert (np.diff(history["yarn_slip_j"]) > 0.0).all() and history["crossover_j"][-1] > 0.0
    assert history["yarn_motion_j"][-1] < 0.01 * history["external_work_j"][-1]
    for ply in result.plies:
        assert ply.yarn_slide.shape == (len(ply.points), 2)
        frame = ply.frame()
        np.testing.assert_array_equal(frame.weft_slide, ply.yarn_slide[:, 1])


def test_selective_mass_scaling_keeps_its_step():
    numerics = Numerics(mass_scaling="selective", minimum_time_step=1.2e-5)
    result = sliding_press(aligned=False, numerics=numerics).run(frames=3)
    assert result.completed and result.summary["energy_error"] < 0.02
    assert result.summary["stable_time_step_s"] >= 1.2e-5


def test_crossovers_that_crowd_are_warned_of():
    material = cloth(slip_force_warp=1e-6, slip_force_weft=1e-6)
    led = Led(blank(material))
    chains = led.of.chains
    slide = np.zeros((len(led.scene.plies[0].mesh.vertices), 2))
    assert led.of.warnings(slide) == []
    first = np.flatnonzero(chains.family == 0)[0]
    slide[chains.ends[first, 1], 0] = -0.25 * chains.lengths[first]
    (words,) = led.of.warnings(slide)
    assert words.startswith(
        f"1 of {len(chains.ends)} bars of ply 'p' have let so much yarn out, 25 %"
    )
    slide[chains.ends[first, 1], 0] = -10.0 * chains.lengths[first]  # its end has gone by
    assert led.of.warnings(slide) == []

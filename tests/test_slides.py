"""Slides of yarns: springs that slip, what presses them, room between crossings, their step."""

import dataclasses
import math

import numpy as np
import pytest
import warp as wp
from law_checks import PLAIN, SPACING, crimp_table
from sliding_checks import FREE, YARNS, Led, blank, cloth, saw_tooth_yarns, scene_of
from test_engine import small_press

from warpdrape.contact import law
from warpdrape.dynamics.interactions import step_share
from warpdrape.errors import InputError
from warpdrape.forces.sliding_chains import CLOSEST
from warpdrape.forces.sliding_yarns import frequencies, slides_share
from warpdrape.kernels.forces.slides import SLIDES_SHARE, gripped
from warpdrape.materials.laws import ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.setup import Clamp


@wp.kernel
def _grip(a: wp.vec3d, b: wp.vec3d, out: wp.array(dtype=wp.float64)):
    found = gripped(a[0], a[1], a[2], b[0], b[1], b[2])
    out[0] = found.rate
    out[1] = found.elongation


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
    assert list(grip(1.0, 2.0, 0.0, 4.0, 0.0, 0.0)) == [2.25, 2.25]  # no crossing: nothing holds
    _, elongation = grip(0.0, 0.0, 1.0, 1e5, 1e4, 1.0)  # a limit that has fallen
    assert 0.5e-4 < elongation < 1e-4


def test_springs_store_half_of_force_times_elongation_on_what_is_left():
    led, rng = Led(blank()), np.random.default_rng(6)
    s, e = (size * rng.uniform(-1, 1, (led.count, 2)) for size in (4e-3, 1e-6))
    left, chains = led.of.chains.left(s), led.of.chains
    assert left.min() < 0.5
    crossings = (chains.areas / cloth().cell_area)[:, None]
    stored = led.measure(led.scene.plies[0].rest_points, led.slides(s=s, grip=e))[0]["crossover"]
    assert stored == pytest.approx((0.5 * left * crossings * (2e4, 3e4) * e**2).sum(), rel=1e-12)


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


def amplification(led, step, x0):
    """Matrix of a step of vertices, their velocities, slides, springs and rates, by differences."""
    count = led.count
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


def held_by(hold, law=YARNS, mesh="diagonal"):
    """A small ply whose crossovers are as stiff as asked."""
    weak = {name: value if "slip" in name else hold for name, value in FREE.items()}
    weak |= {"slip_force_warp": 5e-4 * hold, "slip_force_weft": 5e-4 * hold}
    return Led(blank(cloth(law, ShearPolynomial((4e-4,)), **weak), cells=2, mesh=mesh))


def highest_frequency(led, x0):
    """Largest ω² [1/s²] of the pinned net about a state."""
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
    return np.abs(np.linalg.eigvals(np.array(rows) / mass)).max()


@pytest.mark.parametrize(("mesh", "hold"), [("diagonal", 1e-3), ("aligned", 1e5)])
def test_a_step_is_stable_with_what_slides_take_of_it_and_not_without(mesh, hold):
    """(Δt ω)² = 4 − q_s of the pinned net is the limit; the scene's own step is well below."""
    led = held_by(hold, mesh=mesh)
    x0 = led.scene.plies[0].rest_points
    highest, bound = highest_frequency(led, x0), frequencies(led.scene, 0).max()
    assert 0.1 * bound < highest < bound
    for taken, stable in ((SLIDES_SHARE, True), (0.0, False)):
        step = math.sqrt((4.0 - taken) / highest)
        radius = np.abs(np.linalg.eigvals(amplification(led, step, x0))).max()
        assert (radius < 1.0 + 1e-6) == stable, radius
        assert stable or radius > 1.2


@pytest.mark.parametrize("law", [PLAIN, crimp_table()], ids=["crimp", "tabulated"])
def test_so_is_one_of_families_that_pull_each_other(law):
    """About a taut state, which their crossovers hold."""
    led = held_by(1e5, law)
    x0 = led.scene.plies[0].rest_points * (1.002, 1.0015, 1.0)
    after = led.step(x0, led.slides())[1]
    stiff = led.of.crossovers.stiffness.numpy()
    assert (np.abs(after["grip"] * stiff) < 0.9 * led.of.crossovers.slip.numpy()).all()
    highest, bound = highest_frequency(led, x0), frequencies(led.scene, 0).max()
    assert 0.05 * bound < highest < bound
    step = math.sqrt((4.0 - SLIDES_SHARE) / highest)
    radius = np.abs(np.linalg.eigvals(amplification(led, step, x0))).max()
    assert radius < 1.0 + 1e-4  # rigid motion's double 1, to the root of the differences' error


def test_slides_take_of_the_step_and_say_when_too_little_is_left():
    scene = scene_of(blank())
    assert slides_share(scene, 0.0) == SLIDES_SHARE
    assert step_share(scene) == law.step_share(scene) + SLIDES_SHARE
    assert slides_share(dataclasses.replace(scene, approach="yarns"), 0.0) == 0.0
    greedy = Numerics(contact_share=0.2, contact_damping=0.6)
    scene = dataclasses.replace(small_press(numerics=greedy, clamps=[]), approach="sliding_yarns")
    with pytest.raises(InputError, match=r"contact_share = 0\.2 .*beside yarns that slide: lower"):
        slides_share(scene, 2.9)


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


def test_yarns_rub_with_the_force_that_their_crimp_presses_with():
    """F + μ 2 t h/L at every crossing, the same from warp and weft by brute force."""
    hold = {"slip_force_warp": 1e-3, "slip_force_weft": 1e-3}
    hold |= {"stiffness_warp": 1e7, "stiffness_weft": 1e7}
    material = cloth(PLAIN, factor=0.01, yarn_friction=0.3, **hold)
    led, stretched = Led(blank(material, cells=3)), np.array([1.006, 1.004])
    x = led.scene.plies[0].rest_points * (*stretched, 1.0)
    drawn = np.tile([-1e-3, 0.0], (led.count, 1))  # ends of the warp are going by: less of it there
    assert 0.7 < led.of.chains.left(drawn).min() < 0.9
    after = led.step(x, led.slides(s=drawn, rate=1e-3))[1]["grip"]
    crossings = (led.of.chains.areas / material.cell_area)[:, None]
    force = after * led.of.crossovers.stiffness.numpy() / crossings
    yarns, heights = saw_tooth_yarns(PLAIN, stretched, np.ones(2))
    lengths = np.hypot(SPACING * stretched, heights)
    press = 2.0 * yarns * heights / lengths
    assert press[0] == pytest.approx(press[1], rel=1e-5) and press[0] > 5.0
    np.testing.assert_allclose(force, 1e-3 + 0.3 * press[0], rtol=1e-5)
    with pytest.raises(InputError, match=r"yarn_friction = 0\.3 of fabric 'test'.*friction beside"):
        Led(blank(cloth(yarn_friction=0.3)))
    for advised in ({}, {"yarn_friction": 0.3}):
        assert Led(blank(cloth(friction=0.3, **advised))).count

"""Yarns as chains of bars: the net in a mesh, bars and couples, forces, bound, whole runs."""

import dataclasses
import math

import numpy as np
import pytest
import warp as wp
from element_checks import whole
from law_checks import PLAIN, crimp_table, fabric
from test_engine import small_press
from test_threads import assert_same_bits, state_after

import warpdrape as wd
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline, squares
from warpdrape.blanks.outlines import Disc, Polygon
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_net import lay_yarns
from warpdrape.errors import InputError
from warpdrape.forces.membrane import without_rates
from warpdrape.forces.ply_net import net_of, yarns_per_bar
from warpdrape.forces.yarns import build_ply_yarns, frequencies
from warpdrape.interaction import Run
from warpdrape.kernels.forces.recovery import Recovery
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import LinearTension, ShearPolynomial, ShearTable
from warpdrape.numerics import Numerics
from warpdrape.scenes import bias_extension, biaxial_tension, hemisphere, picture_frame

STIFF = LinearTension(46e3, 48e3)
COUPLE = ShearPolynomial((4e-4, -8e-4, 1e-3))
LAWS = {"linear": STIFF, "crimp": PLAIN, "tabulated": crimp_table()}
SHEARS = (COUPLE, ShearTable((0.0, 0.5, 1.0), (0.0, 1e-4, 5e-4)))


def blank(cloth=None, pattern="aligned", warp_angle=0.0, cells=3):
    cloth = cloth or fabric(STIFF, COUPLE, factor=1.0)
    return Ply.rectangle("p", cloth, 0.03, cells=cells, mesh=pattern, warp_angle=warp_angle)


class Led:
    """A ply's net by itself, without viscosity."""

    def __init__(self, ply, device="cpu", **numerics):
        self.of = build_ply_yarns(ply, Numerics(**numerics), whole(ply), without_rates(), device)
        self.device, self.memory = device, self.of.start()
        self.recovered = wp.empty(0, Recovery, device=device)

    def forces(self, x):
        at = wp.array(x, dtype=wp.vec3d, device=self.device)
        f = wp.zeros(len(x), dtype=wp.vec3d, device=self.device)
        quadrants, ties = Run(0, len(self.of.net.quadrants)), Run(0, len(self.of.net.carried))
        for launch in self.of.launches(quadrants, ties, at, self.memory, self.recovered, f):
            launch(self.device)
        return f.numpy()

    def energy(self, x):
        return self.of.measure(wp.array(x, dtype=wp.vec3d, device=self.device))[2]


def turned(rng):
    """A random rotation."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0.0 else -q


def shaken(ply, rng, size=2e-4, shear=0.3):
    x = ply.rest_points + size * rng.uniform(-1.0, 1.0, ply.rest_points.shape)
    x[:, 0] += shear * x[:, 1]
    return x @ turned(rng).T


@pytest.mark.parametrize("pattern", ["aligned", "diagonal"])
def test_the_net_of_squares_is_their_sides(pattern):
    ply = blank(pattern=pattern)
    net = net_of(ply)
    assert len(net.quadrants) == 4 * 9 and net.rim == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.abs(net.lengths), 0.01, rtol=1e-12)
    np.testing.assert_allclose(net.areas, 0.25e-4, rtol=1e-12)
    assert len(net.carried) == (9 if pattern == "aligned" else 0)
    assert np.isin(np.unique(net.ties.toarray().round(12)), [-0.25, 0.0, 1.0]).all()


def test_across_the_squares_of_a_strip_at_45_every_vertex_is_a_crossover():
    ply = blank(warp_angle=math.pi / 4)
    net = net_of(ply)
    assert len(net.carried) == 0 and net.rim == pytest.approx(0.0, abs=1e-12)
    # 9 squares share 12 inner sides, each the diagonal of a cell; 12 half cells at the border
    assert len(net.quadrants) == 4 * 12 + 12
    assert net.areas.sum() == pytest.approx(9e-4, rel=1e-12)
    half = net.areas[48:]
    np.testing.assert_allclose(half, 0.25e-4, rtol=1e-12)


@pytest.mark.parametrize("degrees", [0.0, 17.0, 45.0, -70.0])
@pytest.mark.parametrize("angle", [90.0, 70.0])
def test_any_outline_keeps_its_area_and_carries_the_rest_exactly(degrees, angle):
    """Ties vanish in every uniform deformation; the rim's area goes to the nearest quadrants."""
    if angle != 90.0:  # a lattice of rhombs, by hand
        grid = np.stack(np.meshgrid(np.arange(7.0), np.arange(7.0)), -1).reshape(-1, 2)
        turn = np.radians([degrees, degrees + angle])
        points = 0.01 * grid @ np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        corner = (np.arange(7)[:, None] * 7 + np.arange(6))[:6].ravel()
        rows = np.stack([corner, corner + 1, corner + 8, corner, corner + 8, corner + 7], axis=1)
        mesh = FlatMesh(points, rows.reshape(-1, 3))
    else:
        square = [(-0.1, -0.08), (0.1, -0.1), (0.09, 0.1), (-0.1, 0.1)]
        hole = [(-0.03, -0.02), (0.03, -0.03), (0.02, 0.03)]
        outline = Polygon(square, [hole]) if degrees else Disc(0.1)
        mesh = mesh_outline(outline, edge=0.01, warp_angle=math.radians(degrees))
    cloth = fabric(STIFF, COUPLE, angle=math.radians(angle))
    ply = Ply(name="p", fabric=cloth, mesh=mesh, warp_angle=math.radians(degrees))
    net = net_of(ply)
    assert net.areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-12)
    np.testing.assert_allclose(net.home.sum(axis=1), 1.0, rtol=1e-12)
    field = np.column_stack([np.ones(len(mesh.vertices)), mesh.vertices])
    assert np.abs(net.ties @ field).max(initial=0.0) < 1e-12
    assert np.abs(net.ties.data).max(initial=0.0) <= 2.25  # two edges from a cell's middle
    everyone = np.union1d(net.quadrants, net.carried)
    np.testing.assert_array_equal(everyone, np.arange(len(mesh.vertices)))
    assert net.rim < 0.4


def test_a_cell_that_is_a_hole_has_no_yarn():
    mesh = blank(pattern="diagonal").mesh
    centre = np.abs(mesh.vertices[mesh.triangles].mean(axis=1)).max(axis=1) < 0.005
    assert centre.sum() == 2
    net = lay_yarns(FlatMesh(mesh.vertices, mesh.triangles[~centre]), np.eye(2))
    assert len(net.quadrants) == 4 * 8 and net.areas.sum() == pytest.approx(8e-4)


@pytest.mark.parametrize("family", [0, 1])
def test_a_single_bar_has_the_tension_of_its_width(family, device):
    """n ε times 10 mm for a bar inside, half of it at the border; nothing across."""
    ply = blank(pattern="diagonal")
    x = ply.rest_points
    x[:, family] *= 1.002
    f = Led(ply, device).forces(x)
    n = (STIFF.warp, STIFF.weft)[family] / ply.fabric.yarn_width[family]
    ends = ply.rest_points[:, family] > 0.0149
    along = ply.rest_points[ends, 1 - family]
    width = np.where(np.abs(along) > 0.0149, 0.005, 0.01)
    np.testing.assert_allclose(f[ends, family], -n * 0.002 * width, rtol=1e-9)
    inner = np.abs(ply.rest_points[:, family]) < 0.0149
    np.testing.assert_allclose(f[inner], 0.0, atol=1e-9 * n * 2e-5)


@pytest.mark.parametrize("degrees", [-50.0, 10.0, 30.0, 60.0])
def test_a_cell_turns_with_its_couple(degrees, device):
    """Power of the forces in a trellis of rigid bars: −A C(γ) dγ, with or without carried ones."""
    for pattern in ("aligned", "diagonal"):
        ply = blank(pattern=pattern, cells=1)
        y = ply.rest_points[:, 1:2] + 0.015

        def at(angle, y=y, flat=ply.rest_points):
            way = np.array([[math.sin(angle), math.cos(angle) - 1.0, 0.0]])
            return flat + y * way

        gamma = math.radians(degrees)
        f = Led(ply, device).forces(at(gamma))
        rate = (at(gamma + 1e-6) - at(gamma - 1e-6)) / 2e-6
        couple = ply.fabric.shear.couple(gamma) / ply.fabric.cell_area
        assert (f * rate).sum() == pytest.approx(-9e-4 * couple, rel=1e-6)


def test_energy_is_that_of_bars_and_hinges_counted_one_by_one():
    """Brute force: bars between neighbours of the lattice, angles at every corner of a cell."""
    ply = blank(pattern="diagonal", cells=4)
    rng = np.random.default_rng(3)
    x = shaken(ply, rng)
    size, grid = 0.0075, x.reshape(5, 5, 3)
    n = np.array([STIFF.warp, STIFF.weft]) / ply.fabric.yarn_width
    bars, hinges = 0.0, 0.0
    for i in range(5):
        for j in range(4):
            width = size * (0.5 if i in (0, 4) else 1.0)
            for k, (p, q) in enumerate(
                ((grid[i, j], grid[i, j + 1]), (grid[j, i], grid[j + 1, i]))
            ):
                strain = np.linalg.norm(q - p) / size - 1.0
                bars += 0.5 * n[k] * strain**2 * width * size
    c = np.array([4e-4, -8e-4, 1e-3]) / ply.fabric.cell_area
    for i in range(4):
        for j in range(4):
            for o, a, b in ((0, 1, 2), (1, 0, 3), (2, 3, 0), (3, 2, 1)):
                corners = grid[[i, i, i + 1, i + 1], [j, j + 1, j, j + 1]]
                sense = 1.0 if o in (0, 3) else -1.0
                u, v = corners[a] - corners[o], corners[b] - corners[o]
                cosine = sense * (u @ v) / np.linalg.norm(u) / np.linalg.norm(v)
                g = math.pi / 2 - math.acos(cosine)
                energy = g**2 * (c[0] / 2 + c[1] * g**2 / 4 + c[2] * g**4 / 6)
                hinges += 0.25 * size**2 * energy
    found = Led(ply).energy(x)
    assert bars > 1e-3 and hinges > 1e-6
    np.testing.assert_allclose(found, [bars, hinges, 0.0], rtol=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("shear", SHEARS)
def test_force_is_the_slope_of_the_energy(law, shear, device):
    """Fourth-order central differences; positions away from the laws' kinks, all factors 1."""
    rng = np.random.default_rng(5)
    cloth = fabric(LAWS[law], shear, factor=1.0)
    for angle in (0.0, 0.4):
        ply = blank(cloth, warp_angle=angle, cells=3 if angle == 0.0 else 11)
        led = Led(ply, device)
        x = 1.004 * shaken(ply, rng, 1e-6, 0.05)  # within the table, taut
        x += 1e-6 * rng.uniform(-1.0, 1.0, x.shape)
        f = led.forces(x)
        for _ in range(6):
            way = rng.uniform(-1.0, 1.0, x.shape)
            step = 1e-8
            w = [led.energy(x + k * step * way).sum() for k in (-2, -1, 1, 2)]
            slope = (8.0 * (w[2] - w[1]) - (w[3] - w[0])) / (12.0 * step)
            assert abs(slope) > 1e-2
            assert (f * way).sum() == pytest.approx(-slope, rel=1e-5)


def test_rigid_motion_gives_no_force_and_no_motion_a_net_one(device):
    ply = blank(warp_angle=0.4, cells=11)
    led, rng = Led(ply, device), np.random.default_rng(8)
    x = shaken(ply, rng)
    f = led.forces(x)
    scale = np.abs(f).sum()
    assert scale > 10.0
    assert np.abs(f.sum(axis=0)).max() < 1e-13 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-12 * scale * np.abs(x).max()
    rigid = led.forces(ply.rest_points @ turned(rng).T + 0.1)
    assert np.abs(rigid).max() < 1e-8 * scale


@pytest.mark.parametrize(
    ("degrees", "warp_angle"),
    [(0.0, 0.0), (70.0, 0.0), (40.0, 0.4), (0.0, math.pi / 4), (70.0, math.pi / 4)],
)
def test_the_bound_on_the_frequency_holds(degrees, warp_angle, cloth=None, least=0.1, **numerics):
    """Eigenvalues of differences of the forces of a sheared net on its lumped mass."""
    ply = blank(cloth, warp_angle=warp_angle, cells=11 if warp_angle == 0.4 else 4)
    scene = wd.Scene(
        name="p", plies=[ply], duration=1.0, approach="yarns", numerics=Numerics(**numerics)
    )
    bound = frequencies(scene, 0).max()
    led = Led(ply, **numerics)
    yarns = np.stack(ply.yarn_directions, axis=-1)
    g = math.radians(degrees)
    shear = np.array([[1.0, math.sin(g)], [0.0, math.cos(g)]])
    x = ply.rest_points
    x[:, :2] = x[:, :2] @ (yarns @ shear @ np.linalg.inv(yarns)).T
    n, step = x.size, 1e-9
    rows = np.zeros((n, n))
    for k in range(n):
        move = np.zeros(n)
        move[k] = step
        move = move.reshape(x.shape)
        rows[:, k] = -(led.forces(x + move) - led.forces(x - move)).ravel() / (2.0 * step)
    mass = np.repeat(ply.fabric.areal_density * np.asarray(ply.mesh.vertex_areas), 3)
    highest = np.abs(np.linalg.eigvals(rows / mass[:, None])).max()
    assert least * bound < highest < bound


def test_the_bound_holds_where_shear_is_what_resists():
    cloth = fabric(LinearTension(1.0, 1.0), ShearPolynomial((4e-3,)), factor=1.0)
    # the couple's part is for shear up to 75°, 1/cos² 75° = 15 times what a flat ply needs
    test_the_bound_on_the_frequency_holds(0.0, 0.0, cloth, least=0.1 / 15.0, stabiliser=1e-6)


def test_yarns_per_bar_are_counted_across_the_bars():
    """Warp yarns 1.33 mm apart, bars of the warp as far apart as cells are high."""
    x, y = np.linspace(0.0, 0.06, 4), np.linspace(0.0, 0.02, 3)
    ply = Ply(name="p", fabric=fabric(STIFF), mesh=FlatMesh(*squares(x, y, crossed=False)))
    apart = np.array([0.01, 0.02]) / ply.fabric.yarn_width
    np.testing.assert_allclose(yarns_per_bar(ply, net_of(ply)), apart, rtol=1e-12)
    assert ply.fabric.yarn_width == pytest.approx((1.33e-3, 1.35e-3))


def test_meshes_that_do_not_follow_the_yarns_are_refused_with_those_that_do():
    for pattern, angle in (("random", 0.0), ("grid", 0.3)):
        ply = blank(pattern=pattern, warp_angle=angle, cells=6)
        scene = wd.Scene(name="p", plies=[ply], duration=1e-4, approach="yarns")
        with pytest.raises(InputError, match=r"'p' does not follow its yarns: .*mesh = 'aligned'"):
            scene.run()
        ply = blank(warp_angle=angle, cells=11)
        assert dataclasses.replace(scene, plies=[ply]).run(frames=1).completed


def test_a_blank_of_little_but_rim_is_refused():
    ply = blank(warp_angle=0.3, cells=4)
    scene = wd.Scene(name="p", plies=[ply], duration=1e-4, approach="yarns")
    with pytest.raises(InputError, match=r"% of ply 'p' lie outside .*: give a shorter edge"):
        scene.run()


def test_a_sheet_without_yarns_is_refused():
    cloth = wd.Fabric.rubber("bag", thickness=1e-3, density=1150.0, c10=1e5)
    with pytest.raises(InputError, match=r"'bag' of ply 'p' has none: take .*'semi_discrete'"):
        net_of(Ply.rectangle("p", cloth, 0.03, cells=3))


@pytest.mark.parametrize("mesh", ["aligned", "diagonal"])
def test_the_picture_frame_meets_its_closed_form(mesh):
    """1 % at 30°, as asked; a uniform shear, so what is left is inertia and the slope's spline."""
    small = {"edge": 0.05, "mesh": mesh, "shear_angle_deg": 30.0, "duration": 0.08}
    coupon = picture_frame.build(approach="yarns", **small).run(frames=40).summary["coupon"]
    assert abs(coupon["force_error"]) < 0.01
    assert coupon["measured_shear_angle_deg"] == pytest.approx(30.0, abs=0.01)


@pytest.mark.parametrize("weft", [0.0, 0.004])
def test_biaxial_tension_with_crimp_interchange(weft):
    """A uniform state: what is off is the inertia of carried vertices, on their soft ties."""
    scene = biaxial_tension.build(approach="yarns", weft_strain=weft, edge=0.025, duration=0.01)
    result = scene.run()
    for family in ("warp", "weft"):
        assert abs(result.summary["coupon"][f"{family}_force_error"]) < 1e-4
    assert result.summary["energy_error"] < 0.01
    np.testing.assert_allclose(result.plies[0].strain, [[0.01, weft]] * 64, atol=1e-6)


def test_bias_extension_meets_its_closed_form():
    """1 % at 30°, for yarns that do not shorten either, as those of the closed form."""
    cloth = dataclasses.replace(
        load_fabric("carbon_interlock"), compressive_factor=1.0, bending=None
    )
    small = {"edge": 0.025, "shear_angle_deg": 30.0, "duration": 0.03}
    result = bias_extension.build(fabric=cloth, approach="yarns", **small).run(frames=40)
    coupon = result.summary["coupon"]
    assert abs(coupon["force_error"]) < 0.01
    assert coupon["measured_shear_angle_deg"] == pytest.approx(30.0, abs=0.3)
    assert result.summary["energy_error"] < 0.01


def formed(approach, cells, angle_deg):
    small = {"travel": 0.05, "duration": 0.02, "fast": True}
    return hemisphere.build(approach=approach, cells=cells, angle_deg=angle_deg, **small).run(
        frames=5
    )


@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
def test_a_hemisphere_of_yarns_comes_nearer_to_the_semi_discrete_one(angle_deg):
    """Bars are chords of the punch and of the die's rounding: off by at least the first order."""
    off = []
    for cells in (8, 12):
        pair = [formed(approach, cells, angle_deg) for approach in ("semi_discrete", "yarns")]
        for result in pair:
            assert result.completed and result.summary["energy_error"] < 0.01
            assert result.plies[0].points[:, 2].max() < 1e-3  # nothing lifts the holder
        mean = [result.summary["plies"][0]["mean_abs_shear_deg"] for result in pair]
        assert mean[0] > 5.0 and abs(mean[1] - mean[0]) < 1.0
        draw = [result.summary["plies"][0]["draw_in_m"]["warp"] for result in pair]
        off.append(abs(draw[1] - draw[0]))
    assert off[1] < off[0] * 8 / 12 or max(off) < 3e-4  # m, half of a ply
    width = 0.025 * (1.0 if angle_deg == 0.0 else math.sqrt(0.5))
    per_bar = pair[1].summary["yarns_per_bar"]["ply_0"]
    yarns = load_fabric("carbon_interlock").yarn_width
    np.testing.assert_allclose(per_bar, width / np.array(yarns), rtol=1e-6)


def test_threads_compute_what_one_part_after_another_does():
    plies = [
        dataclasses.replace(ply, mesh=blank(warp_angle=ply.warp_angle, cells=12).mesh)
        for ply in small_press().plies
    ]
    scene = small_press(plies=plies, clamps=[], approach="yarns")
    together, _ = state_after(2, True, scene, blocks=40)
    alone, _ = state_after(2, False, scene, blocks=40)
    assert_same_bits(together, alone)
    assert any(
        values["strain"].any()
        for values in together.values()
        if "strain" in (values.dtype.names or ())
    )


def test_selective_mass_scaling_keeps_its_step():
    numerics = Numerics(mass_scaling="selective", minimum_time_step=1.2e-5)
    plies = [dataclasses.replace(ply, warp_angle=0.0) for ply in small_press().plies]
    plies = [dataclasses.replace(ply, mesh=plies[0].mesh) for ply in plies]
    scene = small_press(plies=plies, numerics=numerics, clamps=[], approach="yarns")
    result = scene.run(frames=3)
    assert result.completed and result.summary["energy_error"] < 0.02
    assert result.summary["stable_time_step_s"] >= 1.2e-5

"""Temperatures of prepregs: tools, other plies and the air, and the friction that follows them."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from test_threads import assert_same_bits, state_after

from warpdrape import Air, Friction, Heat, InputError, Matrix, Ply, Tool, lay_up
from warpdrape.contact.ply_heat import conductance
from warpdrape.kernels.contact.heat import covered, open_faces
from warpdrape.laws import Arrhenius, Newtonian
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.run_folder import as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.same_scene import scene_difference
from warpdrape.scene import Scene
from warpdrape.verification import heat

STILL = Air(temperature=300.0, convection=20.0)


def heat_of(plies, result):
    """Heat that formed plies hold over 0 K, and that they held at first [J]."""
    held = [ply.mesh.vertex_areas * ply.fabric.matrix.heat.capacity for ply in plies]
    after = sum(float(of @ ply.temperature) for of, ply in zip(held, result.plies, strict=True))
    return after, sum(float(of.sum()) * ply.warmth for of, ply in zip(held, plies, strict=True))


# --- plies on each other ------------------------------------------------------------------------


@pytest.mark.parametrize("cells", [(4, 4), (3, 7), (8, 3)])
def test_two_plies_on_each_other_go_to_one_temperature_and_keep_their_heat(cells):
    found, exact, plies, result = heat.on_each_other(cells=cells)
    assert exact[-1] < 0.05 * exact[0]
    if cells[0] == cells[1]:  # else vertices hold areas that triangles do not lie even on
        np.testing.assert_allclose(found[:6], exact[:6], rtol=0.01)
    np.testing.assert_allclose(found, exact, atol=0.005 * exact[0])
    after, before = heat_of(plies, result)
    assert after == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("cells", [(4, 4), (3, 5), (2, 8)])
def test_no_conductance_is_too_much_for_a_step(cells):
    hot, cold = (heat.warm_fabric(name, between=1e9) for name in ("hot", "cold"))
    plies = [
        heat.plate("hot", hot, cells=cells[0]),
        heat.plate("cold", cold, 400.0, cells=cells[1]),
    ]
    result = heat.pressed(plies, 1e5, tools=(None, None))
    warmth = np.concatenate([ply.temperature for ply in result.plies])
    assert warmth.min() > 400.0 and warmth.max() < heat.HOT  # nothing was colder or hotter
    if cells[0] == cells[1]:
        np.testing.assert_allclose(warmth, 460.0, rtol=1e-6)
    after, before = heat_of(plies, result)
    assert after == pytest.approx(before, rel=1e-12)


def test_plies_of_two_fabrics_meet_with_half_of_the_way_each():
    one, other = (Heat(capacity=1.0, conductance=1.0, between=h) for h in (500.0, 1000.0))
    assert conductance(one, other) == pytest.approx(1.0 / (0.5 / 500.0 + 0.5 / 1000.0))
    assert conductance(one, one) == pytest.approx(500.0)
    assert conductance(one, Heat(capacity=1.0, conductance=1.0)) == 0.0


def test_without_a_conductance_plies_keep_their_temperatures():
    plain, open_one = heat.warm_fabric("plain"), heat.warm_fabric("open", between=500.0)
    plies = lay_up([heat.plate("low", plain), heat.plate("high", open_one, 400.0)])
    scene = Scene(name="two", plies=plies, duration=0.01, process_duration=1.0)
    assert not any(map(scene.cools, plies))
    result = heat.pressed([plies[0], plies[1]], 1.0, tools=(420.0, None))
    means = [ply.temperature.mean() for ply in result.plies]
    assert means[0] < heat.HOT - 20.0 and means[1] == 400.0


def test_heat_goes_through_a_stack_to_the_tool():
    """The lowest ply cools on the plate, and the ones above through it."""
    fabric = heat.warm_fabric("warm", between=800.0)
    plies = [heat.plate(f"ply_{k}", fabric) for k in range(3)]
    result = heat.pressed(plies, 2.0, tools=(360.0, None))
    means = np.array([ply.temperature.mean() for ply in result.plies])
    assert 360.0 < means[0] < means[1] < means[2] < heat.HOT - 1.0
    rates, between = 300.0 / 900.0, 800.0 / 900.0
    chain = np.array([[-rates - between, between, 0.0], [between, -2 * between, between],
                      [0.0, between, -between]])  # fmt: skip
    values, vectors = np.linalg.eigh(chain)
    exact = vectors @ (np.exp(2.0 * values) * (vectors.T @ np.full(3, heat.HOT - 360.0)))
    np.testing.assert_allclose(means - 360.0, exact, rtol=0.01)


# --- the air ------------------------------------------------------------------------------------


@wp.kernel
def face_count(normals: wp.array(dtype=wp.vec3d), count: wp.array(dtype=wp.float64)):
    """Open faces after each of several things; one thread in all."""
    cover = wp.vec4d()
    count[0] = open_faces(cover)
    for k in range(normals.shape[0]):
        cover = covered(cover, normals[k])
        count[k + 1] = open_faces(cover)


@pytest.mark.parametrize(
    ("normals", "faces"),
    [
        ([(0, 0, 1), (0.3, 0, 1), (0, 0, -1), (0, 0, 1)], [2, 1, 1, 0, 0]),
        ([(1, 0, 0), (-0.6, 0.8, 0)], [2, 1, 0]),
        ([(1, 0, 0), (0.6, 0.8, 0)], [2, 1, 1]),
    ],
)
def test_things_on_one_side_cover_one_face(normals, faces, device):
    given = wp.array(normals, dtype=wp.vec3d, device=device)
    found = wp.full(len(normals) + 1, np.nan, dtype=wp.float64, device=device)
    wp.launch(face_count, 1, inputs=[given], outputs=[found], device=device)
    assert found.numpy().tolist() == faces


@pytest.mark.parametrize("emissivity", [0.0, 0.9])
@pytest.mark.parametrize("tools", [(), (None,), (420.0,), (None, None)])
def test_open_faces_cool_in_the_air(tools, emissivity):
    found, exact = heat.in_the_air(STILL, 15.0, emissivity=emissivity, tools=tools)
    if len(tools) == 2:
        assert (found == heat.HOT).all()
        return
    assert exact[0] - exact[-1] > 25.0
    np.testing.assert_allclose(exact[0] - found[1:], exact[0] - exact[1:], rtol=0.01)
    if not tools and not emissivity:
        fall = (heat.HOT - 300.0) * np.exp(-2.0 * 20.0 / 900.0 * 15.0)
        assert found[-1] == pytest.approx(300.0 + fall, rel=1e-5)


def test_the_plies_of_a_stack_cover_each_other():
    fabric = heat.warm_fabric("warm")
    plies = [heat.plate(f"ply_{k}", fabric) for k in range(3)]
    result = heat.pressed(plies, 10.0, tools=(None,), air=STILL)
    fallen = [heat.HOT - ply.temperature for ply in result.plies]
    one_face = (heat.HOT - 300.0) * (1.0 - np.exp(-20.0 / 900.0 * 10.0))
    assert fallen[0].max() == fallen[1].max() == 0.0
    np.testing.assert_allclose(fallen[2], one_face, rtol=0.01)


# --- friction -----------------------------------------------------------------------------------

HERSEY = ((0.0, 0.05), (2e-5, 0.15), (2e-4, 0.6))
SHIFT = {"coefficient": 0.3, "by_hersey": HERSEY}


def sliding(friction, temperature, *, plate=None, fabric=None, ply_friction=0.3, plies=1):
    """A ply, or one on another that is not moved, that slides down a slope; ways of the top."""
    cloth = fabric or heat.warm_fabric("warm", conductance=1e8, capacity=900.0)
    stack = lay_up(
        [
            Ply.rectangle(f"p{k}", cloth, 0.02, cells=2, temperature=temperature)
            for k in range(plies)
        ]
    )
    scene = Scene(
        name="slope",
        plies=stack,
        tools=[Tool.plate(width=0.5, height=0.5, temperature=plate)],
        friction=friction,
        ply_friction=ply_friction,
        duration=0.02,
        process_duration=2.0,
        gravity=(5.0, 0.0, -9.81),
        self_contact=False,
    )
    return [ply.points[:, 0].mean() for ply in scene.run(frames=1).plies]


def test_viscosity_of_friction_is_that_at_the_plys_temperature():
    shift = heat.warm_fabric("any").matrix.shift
    law = Friction(**SHIFT, viscosity=0.2, shifted=True)
    for kelvin in (500.0, 540.0):
        plain = Friction(**SHIFT, viscosity=0.2 * shift.factor(kelvin))
        assert sliding(law, kelvin) == pytest.approx(sliding(plain, kelvin), rel=1e-9)
    warm, cold = (sliding(law, kelvin)[0] for kelvin in (540.0, 500.0))
    assert warm > 1.05 * cold > 0.0
    as_given = Friction(**SHIFT, viscosity=0.2)
    assert sliding(as_given, 540.0) == pytest.approx(sliding(as_given, 500.0), rel=1e-9)


def test_viscosity_of_friction_follows_a_ply_that_cools():
    shift = heat.warm_fabric("any").matrix.shift
    law = Friction(**SHIFT, viscosity=0.2, shifted=True)
    plain = Friction(**SHIFT, viscosity=0.2 * shift.factor(490.0))
    cooled = sliding(law, 540.0, plate=490.0)  # within microseconds of the process
    assert cooled == pytest.approx(sliding(plain, 490.0), rel=0.01)
    assert sliding(law, 540.0) > [1.1 * way for way in cooled]


def test_viscosity_between_plies_is_that_of_their_mean():
    shift = heat.warm_fabric("any").matrix.shift
    law = Friction(**SHIFT, viscosity=0.2, shifted=True)
    plain = Friction(**SHIFT, viscosity=0.2 * shift.factor(500.0))
    for plate in (None, 500.0):
        given = sliding(2.0, 500.0, ply_friction=law, plies=2, plate=plate)
        expected = sliding(2.0, 500.0, ply_friction=plain, plies=2)
        assert given[1] - given[0] == pytest.approx(expected[1] - expected[0], rel=1e-6)
        assert given[1] > 1e-5


def test_the_record_of_a_law_shifts_too():
    law = Friction(**SHIFT, viscosity=0.2, shifted=True)
    assert law(pressure=1e3, speed=0.1, shift=3.0) == pytest.approx(law(pressure=1e3, speed=0.3))
    assert law(pressure=1e3, speed=0.1) < law(pressure=1e3, speed=0.3)
    fixed = replace(law, shifted=False)
    assert fixed(pressure=1e3, speed=0.1, shift=3.0) == fixed(pressure=1e3, speed=0.1)


def test_a_run_in_other_air_is_another():
    """What a comparison, and defects measured again, take for a run of the same scene."""
    scene = stack_in_air()
    record = as_json(run_record(scene, None, 1, 1), "run")
    assert scene_difference(record, scene) == ""
    warmer = replace(scene, air=Air(temperature=310.0, convection=20.0))
    assert scene_difference(record, warmer) == "a run with other air"


# --- as a run -----------------------------------------------------------------------------------


def stack_in_air(**options):
    fabric = heat.warm_fabric("warm", between=800.0, emissivity=0.9)
    plies = [heat.plate(f"ply_{k}", fabric, 500.0 + 20.0 * k, cells=6) for k in range(2)]
    tools = [Tool.plate(width=0.03, height=0.1, temperature=400.0).moved((-0.01, 0.0, 0.0))]
    given = {"duration": 4e-3, "process_duration": 2.0, "gravity": (0.0, 0.0, -50.0)}
    law = Friction(**SHIFT, viscosity=0.2, shifted=True)
    return Scene(
        name="stack", plies=lay_up(plies), tools=tools, air=STILL, friction=law, **given, **options
    )


def test_threads_compute_what_one_part_after_another_does():
    together, _ = state_after(2, True, stack_in_air(), blocks=30)
    alone, _ = state_after(2, False, stack_in_air(), blocks=30)
    assert_same_bits(together, alone)
    one, _ = state_after(1, False, stack_in_air(), blocks=30)
    np.testing.assert_allclose(alone["heat.temperature"], one["heat.temperature"], rtol=1e-9)
    assert np.ptp(one["heat.temperature"]) > 1.0
    assert not one["heat.power"].any() and not one["heat.cover"].any()


def test_what_is_of_no_use_is_refused_and_advice_works():
    dry = load_fabric("carbon_interlock")
    plies = lay_up([Ply.rectangle("ply", dry, 0.1, cells=2)])
    given = {"name": "air", "plies": plies, "duration": 0.01}
    with pytest.raises(InputError, match="air: temperature = 300 K is of no use: no ply's fabric"):
        Scene(**given, air=STILL)
    assert Scene(**given).air is None
    with pytest.raises(InputError, match=r"air = 300.0 must be a warpdrape.Air"):
        Scene(**given, air=300.0)
    with pytest.raises(InputError, match=r"air.temperature = 20 K must lie in"):
        Air(temperature=20.0)
    with pytest.raises(InputError, match=r"air.convection"):
        Air(temperature=300.0, convection=-1.0)
    with pytest.raises(InputError, match=r"emissivity = 1.5 must lie in 0"):
        heat.warm_fabric("x", emissivity=1.5)
    with pytest.raises(InputError, match="between"):
        heat.warm_fabric("x", between=0.0)
    with pytest.raises(InputError, match="give by_hersey and viscosity, or leave it out"):
        Friction(coefficient=0.3, shifted=True)
    with pytest.raises(InputError, match=r"friction.shifted"):
        Friction(**SHIFT, viscosity=1.0, shifted=2)
    law = Friction(**SHIFT, viscosity=1.0, shifted=True)
    tools = [Tool.plate(width=0.5, height=0.5)]
    with pytest.raises(InputError, match=r"no ply's fabric has matrix.shift"):
        Scene(**given, tools=tools, friction=law, process_duration=1.0)
    unshifted = replace(law, shifted=False)
    assert Scene(**given, tools=tools, friction=unshifted, process_duration=1.0).tools


def test_a_matrix_without_heat_shifts_friction_too():
    """A ply that keeps its temperature has one all the same."""
    shift = Arrhenius(activation_energy=5e4, reference_temperature=520.0, lowest_temperature=450.0)
    cloth = replace(heat.warm_fabric("x"), matrix=Matrix(viscosity=Newtonian(1e4), shift=shift))
    law = Friction(**SHIFT, viscosity=0.2, shifted=True)
    plain = Friction(**SHIFT, viscosity=0.2 * shift.factor(500.0))
    found = sliding(law, 500.0, fabric=cloth)
    assert found == pytest.approx(sliding(plain, 500.0, fabric=cloth), rel=1e-9)

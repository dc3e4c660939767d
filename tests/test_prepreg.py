"""Runs of prepregs: closed forms by rate and temperature, the process's clock, cooling, resume."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from resume_checks import assert_same_folder, cut_off, timeless
from test_threads import assert_same_bits, state_after

from warpdrape import (
    Fabric,
    Friction,
    Heat,
    InputError,
    Matrix,
    Numerics,
    Ply,
    Tool,
    lay_up,
    read_run,
    simulation,
)
from warpdrape.cli import main
from warpdrape.coupons.closed_forms import bias_force
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper, search_contacts
from warpdrape.forces.matrix import LAG_WARNING
from warpdrape.laws import Arrhenius, Newtonian, PowerLaw
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.quantities import quantity_named
from warpdrape.results.quasi_static import taken
from warpdrape.scene import Scene
from warpdrape.scenes import bias_extension, hemisphere, picture_frame, prepreg_hemisphere
from warpdrape.units import celsius
from warpdrape.verification import heat, prepreg

CARD = "synthetic_prepreg"


def frame(process=5.0, degrees=260.0, **options):
    given = {"edge": 0.05, "duration": 0.05, "damping": 5.0, "shear_angle_deg": 45.0}
    return picture_frame.build(
        fabric=options.pop("fabric", CARD),
        process_duration=process,
        temperature=celsius(degrees) if degrees else 0.0,
        **(given | options),
    )


def curve_of(scene, result):
    """Columns of the coupon's curve from 10° on."""
    (make,) = (
        cell.cell_contents
        for name, cell in zip(
            scene.write.__code__.co_freevars, scene.write.__closure__, strict=True
        )
        if name == "curve_of"
    )
    columns = make(result).columns
    wanted = columns["shear_angle_deg"] >= 10.0
    assert wanted.sum() > 10
    return {name: values[wanted] for name, values in columns.items()}


@pytest.mark.parametrize("degrees", [260.0, 220.0])
@pytest.mark.parametrize("process", [0.5, 5.0, 50.0])
def test_a_picture_frame_follows_the_closed_form_by_rate_and_temperature(process, degrees):
    scene = frame(process, degrees)
    result = scene.run(frames=40)
    curve = curve_of(scene, result)
    elastic = curve_of(frame(1e9, degrees), result)["closed_form_force_n"]
    assert (curve["closed_form_force_n"] > 1.02 * elastic)[:10].all()  # there is something viscous
    np.testing.assert_allclose(curve["force_n"], curve["closed_form_force_n"], rtol=0.01)
    assert result.summary["energy_error"] < 1e-3
    assert result.summary["matrix_lag_deg"] < 0.03


def test_bias_extension_follows_its_closed_form_by_rate():
    """Half of the rate acts in the zones beside the middle one; the mesh leaves some per cent."""
    scene = bias_extension.build(
        fabric=replace(load_fabric(CARD), compressive_factor=1.0),
        edge=0.025,
        duration=0.03,
        process_duration=1.0,
        shear_angle_deg=35.0,
        damping=5.0,
    )
    curve = curve_of(scene, scene.run(frames=24))
    elastic = bias_force(scene.plies[0].fabric, 0.1, 0.2, np.radians(curve["shear_angle_deg"]))
    assert (curve["closed_form_force_n"] > 2.0 * elastic).all()
    np.testing.assert_allclose(curve["force_n"], curve["closed_form_force_n"], rtol=0.05)


@pytest.mark.parametrize("approach", ["green_naghdi", "fibre_frame"])
def test_other_membranes_have_the_same_matrix(approach):
    ours, theirs = (
        frame(1.0, approach=name, duration=0.02).run(frames=10).history["matrix_viscosity_j"]
        for name in ("semi_discrete", approach)
    )
    assert ours[-1] > 0.1
    np.testing.assert_allclose(theirs, ours, rtol=2e-3, atol=1e-5)


def test_when_motion_stops_the_elastic_part_is_left():
    for case in prepreg.stopped():
        assert case.passed, case


def test_with_a_spring_in_series_the_couple_relaxes():
    case = prepreg.relaxing()
    assert case.passed, case


def test_neither_simulated_time_nor_added_mass_is_the_materials():
    cloth = load_fabric(CARD)
    one = prepreg.turn_frame(cloth, 6.0, duration=0.02)
    fast = prepreg.turn_frame(cloth, 6.0, duration=0.01)
    np.testing.assert_allclose(fast.couple[prepreg.GOING], one.couple[prepreg.GOING], rtol=2e-3)
    heavy = prepreg.turn_frame(cloth, 6.0, duration=0.02, minimum_time_step=3e-6)
    np.testing.assert_allclose(heavy.couple[prepreg.GOING], one.couple[prepreg.GOING], rtol=5e-3)
    slow = prepreg.turn_frame(cloth, 60.0, duration=0.02)
    assert slow.couple[prepreg.GOING] < 0.7 * one.couple[prepreg.GOING]


def test_the_summary_tells_the_clocks_apart():
    scene = frame(5.0, duration=0.01)
    plain = scene.run(frames=4).summary
    assert plain["process_clock"] == {
        "process_s": pytest.approx(5.0),
        "speed_up": pytest.approx(500.0),
        "mass_scaling": 1.0,
        "inertia": pytest.approx(250e3),
    }
    heavier = replace(scene, numerics=replace(scene.numerics, minimum_time_step=2e-5))
    clock = heavier.run(frames=4).summary["process_clock"]
    assert clock["mass_scaling"] > 2.0
    assert clock["inertia"] == pytest.approx(250e3 * clock["mass_scaling"])


def test_the_clock_of_a_run_that_was_cut_off_is_that_of_its_last_frame(monkeypatch):
    scene = frame(5.0, duration=0.01)
    done, block = [], Stepper.block

    def cut(self):
        done.append(1)
        if len(done) > 4:
            raise KeyboardInterrupt
        block(self)

    monkeypatch.setattr(Stepper, "block", cut)
    result = scene.run(frames=2)
    assert result.summary["message"].startswith("interrupted")
    shown = result.summary["simulated_s"]
    assert result.summary["process_clock"]["process_s"] == pytest.approx(shown / scene.pace)
    assert shown < scene.duration


def test_motions_that_are_held_back_keep_the_processs_time():
    scene = frame(5.0, duration=0.01)
    scene = replace(scene, numerics=replace(scene.numerics, kinetic_limit=0.002))
    result = scene.run(frames=20)
    clock = result.summary["process_clock"]
    assert clock["process_s"] == pytest.approx(5.0, rel=0.02)
    assert result.summary["simulated_s"] > 0.012 and clock["speed_up"] < 420.0
    curve = curve_of(scene, result)
    np.testing.assert_allclose(curve["force_n"], curve["closed_form_force_n"], rtol=0.06)


def test_energy_is_stored_in_the_springs_and_lost_by_the_matrix():
    matrix = Matrix(viscosity=Newtonian(2e6), modulus=4e6)
    cloth = replace(load_fabric(CARD), matrix=matrix)
    result = frame(1.0, 0.0, fabric=cloth, duration=0.02).run(frames=10)
    history = result.history
    assert history["matrix_j"][-1] > 0.02 * history["external_work_j"][-1]
    assert history["matrix_viscosity_j"][-1] > 0.2 * history["external_work_j"][-1]
    stored = sum(history[f"{name}_j"] for name in ("yarn", "shear", "stabiliser", "matrix"))
    np.testing.assert_allclose(history["internal_j"], stored, atol=1e-12)
    assert result.summary["energy_error"] < 1e-3
    assert "matrix_lag_deg" in result.summary and result.summary["matrix_lag_deg"] == 0.0
    np.testing.assert_array_equal(
        taken(history), history["internal_j"] + history["matrix_viscosity_j"]
    )


@pytest.mark.parametrize("viscosity", [1e-6, 1e14])
def test_no_viscosity_is_too_little_or_too_much_for_the_step(viscosity):
    cloth = replace(load_fabric(CARD), matrix=Matrix(viscosity=Newtonian(viscosity)))
    scene = frame(1.0, 0.0, fabric=cloth, mesh="random", edge=0.03, duration=0.01)
    scene = replace(scene, numerics=replace(scene.numerics, safety=0.98, damping=0.0))
    result = scene.run(frames=5)
    assert result.completed and result.summary["energy_error"] < 0.01
    lag = result.summary["matrix_lag_deg"]
    if viscosity < 1.0:
        assert lag < 1e-6
    else:
        assert lag == pytest.approx(45.0, abs=1.0)  # a solid: all of it is in the spring
        assert any("lags" in words for words in result.summary["warnings"])
        assert lag > LAG_WARNING


def test_a_dry_fabric_has_nothing_of_it(tmp_path):
    result = hemisphere.build(cells=4, travel=0.005, duration=1e-3).run(tmp_path / "run", frames=1)
    assert not [name for name in result.history if "matrix" in name or "temperature" in name]
    assert not {"matrix_lag_deg", "process_clock"} & set(result.summary)
    assert result.plies[0].temperature is None


# --- cooling ------------------------------------------------------------------------------------


def test_a_ply_between_plates_cools_as_its_closed_form():
    found, exact = heat.between_plates()
    assert exact[0] - exact[-1] > 0.8 * (520.0 - 380.0)
    np.testing.assert_allclose(found, exact, rtol=0.002)
    np.testing.assert_allclose((found - 380.0)[:6], (exact - 380.0)[:6], rtol=0.01)
    slow, _ = heat.between_plates(0.3)
    assert slow[-1] > found[3]


def on_a_plate(**settings):
    """A ply that lies on a plate which warms one half of it less, and does not move."""
    cloth = replace(load_fabric(CARD), bending=None)
    plies = lay_up([Ply.rectangle("ply", cloth, 0.04, cells=4, mesh="grid")])
    plate = Tool.plate("plate", width=0.02, height=0.1, temperature=400.0)
    return Scene(
        name="plate",
        plies=plies,
        tools=[replace(plate, **settings).moved((-0.0151, 0.0, 0.0))],
        duration=4e-3,
        process_duration=1.0,
        gravity=(0.0, 0.0, -50.0),
    )


def test_only_what_presses_on_a_tool_cools_on_it():
    result = on_a_plate().run(frames=2)
    warmth, x = result.plies[0].temperature, result.plies[0].rest_points[:, 0]
    assert (warmth[x > -0.004] == celsius(260.0)).all()
    rate = 500.0 / 920.0
    least = 400.0 + (celsius(260.0) - 400.0) * math.exp(-rate)
    assert warmth[x < -0.011].max() < celsius(260.0) - 20.0
    assert warmth.min() > least - 0.5
    entry = result.summary["plies"][0]
    assert entry["min_temperature_k"] == warmth.min()
    assert entry["mean_temperature_k"] == pytest.approx(warmth.mean())
    history = result.history["ply_mean_temperature_k"]
    assert (
        history[0] == pytest.approx(celsius(260.0)) and history[-1] == entry["mean_temperature_k"]
    )


def test_a_tool_that_is_near_and_does_not_press_takes_no_heat():
    scene = on_a_plate()
    tools = [tool.moved((0.0, 0.0, -2e-6)) for tool in scene.tools]
    scene = replace(scene, tools=tools, gravity=(0.0, 0.0, 0.0))
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)
    search_contacts(model, state)
    tool_memory = next(m for m in state.memory if hasattr(m, "touching"))
    assert tool_memory.touching.numpy().any()  # it is near
    result = scene.run(frames=1)
    assert (result.plies[0].temperature == celsius(260.0)).all()


def test_without_a_tools_temperature_a_ply_keeps_its_own():
    result = on_a_plate(temperature=None).run(frames=1)
    assert result.plies[0].temperature is None
    assert "min_temperature_k" not in result.summary["plies"][0]


def test_a_ply_that_becomes_solid_is_told_of():
    scene = on_a_plate()
    result = replace(scene, process_duration=20.0).run(frames=1)
    (words,) = (w for w in result.summary["warnings"] if "cools to" in w)
    assert "below the lowest of its matrix's data, 463.1 K" in words
    assert not [w for w in scene.run(frames=1).summary["warnings"] if "cools to" in w]


def test_the_animation_and_pictures_show_the_temperature(tmp_path):
    result = on_a_plate().run(tmp_path / "run", frames=2)
    read = read_run(tmp_path / "run")
    np.testing.assert_allclose(read.plies[0].temperature, result.plies[0].temperature, rtol=1e-6)
    assert main(["picture", str(tmp_path / "run"), "--field", "temperature"]) == 0
    record = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))
    assert record["plies"][0]["temperature_k"] == celsius(260.0)
    assert record["tools"][0]["temperature_k"] == 400.0
    assert record["fabrics"][CARD]["matrix"]["heat"]["conductance"] == 500.0


# --- a press ------------------------------------------------------------------------------------


def coarse(**options):
    given = {"cells": 8, "duration": 0.02, "fast": True, "bending": "none", "facet": 0.01}
    return prepreg_hemisphere.build(**(given | options))


def test_a_faster_press_needs_more_force_and_shears_less():
    slow, fast = (coarse(closing_time=t, tool_celsius=0.0).run(frames=12) for t in (20.0, 0.5))
    force = [max(r.history["punch_force_n"]) for r in (slow, fast)]
    assert force[1] > 1.5 * force[0] > 10.0
    # A melt that thins with rate shears where it shears already; locking spreads it.
    spread = [r.summary["plies"][0]["mean_abs_shear_deg"] for r in (slow, fast)]
    peaks = [r.summary["plies"][0]["p95_shear_deg"] for r in (slow, fast)]
    assert spread[1] < spread[0] - 0.05 and peaks[1] > peaks[0] + 0.1
    for result in (slow, fast):
        assert result.completed and result.summary["energy_error"] < 0.02
        assert result.history["ply_0_max_shear_deg"][-1] > 20.0


def test_cold_tools_make_a_press_work_harder():
    warm, cold = (coarse(closing_time=5.0, tool_celsius=t).run(frames=6) for t in (0.0, 195.0))
    assert cold.plies[0].temperature.min() < celsius(215.0)
    lost = [r.history["matrix_viscosity_j"][-1] for r in (warm, cold)]
    assert lost[1] > 1.1 * lost[0]


def test_the_air_cools_what_no_tool_covers():
    still, windy = (
        coarse(closing_time=5.0, tool_celsius=0.0, air_celsius=t).run(frames=3) for t in (0.0, 25.0)
    )
    assert still.plies[0].temperature is None
    warmth = windy.plies[0].temperature
    assert warmth.min() < celsius(259.0) and warmth.max() == celsius(260.0)  # under the holder


def test_kinetic_energy_is_held_against_what_the_matrix_has_lost_too(monkeypatch):
    seen = []

    class Watched(simulation.Loading):
        def adapt(self, kinetic, internal):
            seen.append((self.time, internal))
            super().adapt(kinetic, internal)

    monkeypatch.setattr(simulation, "Loading", Watched)
    scene = frame(0.5, duration=0.01)
    scene = replace(scene, numerics=replace(scene.numerics, kinetic_limit=0.05))
    history = scene.run(frames=5).history
    at_frames = dict(look for look in seen if look[0] in history["loading_time_s"])
    took = dict(zip(history["loading_time_s"], taken(history), strict=True))
    assert len(at_frames) > 3
    for time, internal in at_frames.items():
        assert internal == pytest.approx(took[time], rel=1e-12)
    assert history["matrix_viscosity_j"][-1] > 0.5 * history["internal_j"][-1]


def test_a_press_resumes_to_the_bit(tmp_path, monkeypatch):
    scene = coarse(closing_time=1.0, duration=0.004, travel=0.02)
    whole = scene.run(tmp_path / "whole", frames=8)
    cut_off(scene, tmp_path / "cut", 4, monkeypatch, every=3)
    again = coarse(closing_time=1.0, duration=0.004, travel=0.02).run(resume=tmp_path / "cut")
    assert timeless(again.summary) == timeless(whole.summary)
    for name in ("points", "temperature"):
        np.testing.assert_array_equal(
            getattr(again.plies[0], name), getattr(whole.plies[0], name), err_msg=name
        )
    assert_same_folder(tmp_path / "whole", tmp_path / "cut")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"tool_celsius": 199.0}, "temperature of tool"),
        ({"blank_celsius": 259.0}, "temperature of ply"),
        ({"closing_time": 1.1}, "process_duration over duration"),
    ],
)
def test_a_press_of_another_process_cannot_go_on(tmp_path, monkeypatch, changes, words):
    given = {"closing_time": 1.0, "duration": 0.002, "travel": 0.005}
    cut_off(coarse(**given), tmp_path / "cut", 2, monkeypatch, every=1)
    with pytest.raises(InputError, match=words):
        coarse(**(given | changes)).run(resume=tmp_path / "cut")


def test_a_matrix_of_other_values_cannot_go_on(tmp_path, monkeypatch):
    cloth = load_fabric(CARD)
    cut_off(frame(fabric=cloth, duration=0.004), tmp_path / "cut", 2, monkeypatch, every=1)
    thicker = replace(cloth.matrix, viscosity=replace(cloth.matrix.viscosity, viscosity=1.1e6))
    other = frame(fabric=replace(cloth, matrix=thicker), duration=0.004)
    with pytest.raises(InputError, match="matrix of the fabric"):
        other.run(resume=tmp_path / "cut")


def test_threads_compute_what_one_part_after_another_does():
    scene = coarse(closing_time=1.0, duration=0.01, travel=0.02)
    together, _ = state_after(2, True, scene, blocks=40)
    alone, _ = state_after(2, False, scene, blocks=40)
    assert_same_bits(together, alone)
    assert "heat.temperature" in together
    assert np.ptp(together["heat.temperature"]) > 1e-3


# --- what is refused, and advice that works -----------------------------------------------------


def test_a_scene_without_the_processs_time_is_refused_and_advice_works():
    with pytest.raises(InputError, match="needs process_duration"):
        picture_frame.build(fabric=CARD)
    assert picture_frame.build(fabric=CARD, process_duration=5.0).pace == pytest.approx(0.02)
    for bars in ("yarns", "sliding_yarns"):
        words = rf"approach = '{bars}' does not know: take 'semi_discrete'"
        with pytest.raises(InputError, match=words):
            frame(approach=bars)
    assert frame(approach="semi_discrete").approach == "semi_discrete"
    scene, selective = frame(), Numerics(mass_scaling="selective", minimum_time_step=1e-5)
    with pytest.raises(InputError, match=r"mass_scaling = 'selective' does not know: take 'plain'"):
        replace(scene, numerics=selective)
    assert replace(scene, numerics=replace(selective, mass_scaling="plain")).plies


def test_a_net_does_not_ask_for_the_processs_time():
    scene = coarse(approach="fishnet")
    assert replace(scene, process_duration=None, friction=0.2).approach == "fishnet"


def test_temperatures_that_nothing_asks_for_are_refused():
    dry = load_fabric("carbon_interlock")
    wet = load_fabric(CARD)
    flat = Ply.rectangle("ply", dry, 0.1, cells=2)
    with pytest.raises(InputError, match=r"temperature = 500.0 is of no use: fabric 'carbon_inter"):
        replace(flat, temperature=500.0)
    ply = Ply.rectangle("ply", wet, 0.1, cells=2)
    with pytest.raises(InputError, match=r"below the lowest of its matrix's data, 463.15 K"):
        replace(ply, temperature=celsius(180.0))
    with pytest.raises(InputError, match=r"give kelvin, as units.celsius"):
        replace(ply, temperature=2600.0)
    assert replace(ply, temperature=celsius(250.0)).warmth == celsius(250.0)
    assert ply.warmth == celsius(260.0) and flat.warmth is None
    disc = Ply.disc("ply", wet, 0.1, cells=2, temperature=celsius(240.0))
    assert disc.warmth == celsius(240.0)
    with pytest.raises(InputError, match=r"tool 'plate': temperature = 80 K must lie in"):
        Tool.plate("plate", width=0.1, height=0.1, temperature=80.0)
    cold = replace(wet, matrix=replace(wet.matrix, heat=None))
    with pytest.raises(InputError, match="of no use: no ply's fabric has a matrix with heat"):
        replace(on_a_plate(), plies=lay_up([replace(ply, fabric=cold)]))


def test_a_sheet_without_yarns_has_no_matrix():
    rubber = {"thickness": 1e-3, "density": 1100.0, "c10": 2e5}
    with pytest.raises(InputError, match="leave matrix out"):
        Fabric.rubber("sheet", matrix=Matrix(viscosity=Newtonian(1e5)), **rubber)
    with pytest.raises(InputError, match=r"is no warpdrape.Matrix"):
        replace(load_fabric("carbon_interlock"), matrix=Newtonian(1e5))


def test_the_scene_of_a_prepreg_refuses_a_dry_fabric():
    with pytest.raises(InputError, match="take the scene 'hemisphere' for a dry one"):
        coarse(fabric="carbon_interlock")
    assert hemisphere.build(cells=4).plies


def test_heat_is_of_use_with_a_shift_only():
    shift = Arrhenius(activation_energy=5e4, reference_temperature=500.0, lowest_temperature=450.0)
    heat = Heat(capacity=900.0, conductance=300.0)
    law = PowerLaw(1e6, 0.5, 0.1, 0.01)
    assert Matrix(viscosity=law, shift=shift, heat=heat).heat.rate == pytest.approx(1.0 / 3.0)


def test_a_pictures_scale_of_temperature_is_in_celsius():
    quantity = quantity_named("temperature")
    shown = quantity.of(np.array([celsius(212.0), celsius(247.0)]))
    np.testing.assert_allclose(shown, [212.0, 247.0])
    assert quantity.scale(shown) == (210.0, 250.0)
    assert quantity.text(shown[0]) == "212 °C"


def test_friction_of_the_scene_is_by_hersey_number():
    scene = coarse()
    assert isinstance(scene.friction, Friction) and scene.friction.by_hersey
    assert scene.process_duration == pytest.approx(2.4)

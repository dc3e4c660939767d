"""Runs of prepregs against closed forms, by rate, temperature and the process's clock."""

from dataclasses import replace

import numpy as np
import pytest
from prepreg_checks import CARD, coarse, frame

from warpdrape import Matrix, simulation
from warpdrape.coupons.closed_forms import bias_force
from warpdrape.dynamics.stepping import Stepper
from warpdrape.forces.matrix import LAG_WARNING
from warpdrape.laws import Newtonian
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.quasi_static import taken
from warpdrape.scenes import bias_extension, hemisphere
from warpdrape.verification import prepreg


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


def test_a_faster_press_needs_more_force_and_shears_more_where_it_shears_most():
    slow, fast = (coarse(closing_time=t, tool_celsius=0.0).run(frames=12) for t in (20.0, 0.5))
    force = [max(r.history["punch_force_n"]) for r in (slow, fast)]
    assert force[1] > 1.5 * force[0] > 10.0
    # A melt that thins with rate shears where it shears already: 1.7° at full stiffness.
    spread = [r.summary["plies"][0]["mean_abs_shear_deg"] for r in (slow, fast)]
    peaks = [r.summary["plies"][0]["p95_shear_deg"] for r in (slow, fast)]
    assert spread[1] == pytest.approx(spread[0], abs=0.3) and peaks[1] > peaks[0] + 0.8
    for result in (slow, fast):
        assert result.completed and result.summary["energy_error"] < 0.02
        assert result.history["ply_0_max_shear_deg"][-1] > 20.0


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

"""Plies that cool on tools and in the air: closed forms, what presses, what is told and shown."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from prepreg_checks import CARD, coarse, on_a_plate

from warpdrape import read_run
from warpdrape.cli import main
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import search_contacts
from warpdrape.results.quantities import quantity_named
from warpdrape.units import celsius
from warpdrape.verification import heat


def test_a_ply_between_plates_cools_as_its_closed_form():
    found, exact = heat.between_plates()
    assert exact[0] - exact[-1] > 0.8 * (520.0 - 380.0)
    np.testing.assert_allclose(found, exact, rtol=0.002)
    np.testing.assert_allclose((found - 380.0)[:6], (exact - 380.0)[:6], rtol=0.01)
    slow, _ = heat.between_plates(0.3)
    assert slow[-1] > found[3]


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


def test_a_pictures_scale_of_temperature_is_in_celsius():
    quantity = quantity_named("temperature")
    shown = quantity.of(np.array([celsius(212.0), celsius(247.0)]))
    np.testing.assert_allclose(shown, [212.0, 247.0])
    assert quantity.scale(shown) == (210.0, 250.0)
    assert quantity.text(shown[0]) == "212 °C"

"""Friction that depends on pressure, slip speed, the Hersey number or the yarns' angle."""

import math
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from test_friction import STIFF, G, travel

from warpdrape import Clamp, Friction, InputError, Numerics, Ply, Scene, Tool, lay_up
from warpdrape.contact.friction import friction_laws, rub
from warpdrape.kernels.contact.friction import FrictionLaws, Rub, bearable, friction_coefficient

PRESSURE = ((0.0, 0.5), (10.0, 0.3), (1e4, 0.1))
SPEED = ((0.0, 0.3), (1e-3, 0.1), (1e-2, 0.4))
HERSEY = ((0.0, 0.25), (1e-6, 0.05), (1e-4, 0.6))
ANGLE = ((0.0, 0.2), (45.0, 0.3), (90.0, 0.6))
SLOPE = 0.4


@wp.kernel(enable_backward=False)
def ask(
    laws: FrictionLaws,
    rub: Rub,
    pressure: wp.array(dtype=wp.float64),
    speed: wp.array(dtype=wp.float64),
    depth: wp.float64,
    length: wp.float64,
    time_step: wp.float64,
    coefficient: wp.array(dtype=wp.float64),
    held: wp.array(dtype=wp.float64),
):
    i = wp.tid()
    coefficient[i] = friction_coefficient(laws, rub, pressure[i], speed[i])
    held[i] = bearable(laws, rub, pressure[i], depth, length, time_step)


def slope(friction, angle=SLOPE, duration=0.02, **settings):
    """A stiff patch on a plate, gravity tilted in place of the plate."""
    return Scene(
        name="slope",
        plies=lay_up([Ply.rectangle("block", STIFF, 0.02, cells=2)]),
        tools=[Tool.plate(width=0.5, height=0.5)],
        duration=duration,
        friction=friction,
        gravity=(G * math.sin(angle), 0.0, -G * math.cos(angle)),
        **settings,
    )


def answers(law, pressure, speed, *, depth=1e-6, length=1e-5, time_step=1e-5, device="cpu"):
    """Coefficients of a law, and the lengths its springs keep, as the kernels compute them."""
    scene = slope(law, process_duration=1.0)
    pressure, speed = np.broadcast_arrays(np.asarray(pressure, float), np.asarray(speed, float))
    size = pressure.size
    given = [wp.array(each.ravel(), dtype=wp.float64, device=device) for each in (pressure, speed)]
    found = [wp.full(size, np.nan, dtype=wp.float64, device=device) for _ in range(2)]
    laws = friction_laws(scene, device)
    inputs = [laws, rub(scene, law), *given, depth, length, time_step]
    wp.launch(ask, size, inputs=inputs, outputs=found, device=device)
    return (each.numpy().reshape(pressure.shape) for each in found), laws.pace


@pytest.mark.parametrize(
    "law",
    [
        Friction(coefficient=0.3, by_pressure=PRESSURE, by_speed=SPEED),
        Friction(coefficient=0.2, by_hersey=HERSEY, viscosity=500.0),
        Friction(coefficient=0.2, by_speed=SPEED),
    ],
)
def test_kernels_and_record_give_the_same_coefficient(law, device):
    pressure, speed = np.meshgrid([1e-3, 5.0, 10.0, 300.0, 1e6], [0.0, 0.02, 0.05, 0.3, 9.0])
    (found, _), pace = answers(law, pressure, speed, device=device)
    assert pace == 0.02
    expected = [
        law(pressure=p, speed=pace * v)
        for p, v in zip(pressure.ravel(), speed.ravel(), strict=True)
    ]
    assert len(np.unique(np.round(expected, 6))) > 3
    np.testing.assert_allclose(found.ravel(), expected, rtol=1e-12)


def test_record_answers_from_its_tables():
    law = Friction(coefficient=0.3, by_pressure=PRESSURE, by_angle=ANGLE)
    assert law(pressure=5.0) == pytest.approx(0.4 * 0.2 / 0.3)
    assert law(pressure=1e9, angle_deg=67.5) == pytest.approx(0.1 * 0.45 / 0.3)
    stribeck = Friction(coefficient=0.25, by_hersey=HERSEY, viscosity=100.0)
    assert stribeck() == 0.25
    assert stribeck(pressure=1e4, speed=1e-4) == pytest.approx(0.05)
    assert stribeck(pressure=0.0, speed=1e-4) == pytest.approx(0.6)


@pytest.mark.parametrize("speeds", [SPEED, ((0.0, 0.1), (1e-9, 0.5)), ((0.0, 0.5), (1e-9, 0.1))])
def test_slip_decides_its_own_friction(speeds, device):
    """The spring keeps what friction at the speed of the slip bears, however steep the law is."""
    law = Friction(coefficient=0.3, by_speed=speeds)
    depth, length, step = 1e-5, 1e-4, 1e-5
    (_, held), pace = answers(
        law, 1.0, 0.0, depth=depth, length=length, time_step=step, device=device
    )
    slip = length - float(held.ravel()[0])
    assert slip > 0.0
    assert length - slip == pytest.approx(law(speed=pace * slip / step) * depth, rel=1e-4)


def test_a_spring_that_friction_can_hold_does_not_slip(device):
    law = Friction(coefficient=0.3, by_speed=((0.0, 0.3), (1e-3, 0.01)))
    (_, held), _ = answers(law, 1.0, 0.0, depth=1e-5, length=2.9e-6, device=device)
    assert held == pytest.approx(3e-6)


def test_block_slides_with_the_friction_of_its_own_pressure(device):
    pressure = STIFF.areal_density * G * math.cos(SLOPE)
    assert 1.0 < pressure < 9.0
    law = Friction(coefficient=0.3, by_pressure=((0.0, 0.5), (10.0, 0.05)))
    mu = law(pressure=pressure)
    result = slope(law).run(device=device, frames=5)
    expected = 0.5 * G * (math.sin(SLOPE) - mu * math.cos(SLOPE)) * 0.02**2
    assert abs(mu - 0.3) > 0.02
    assert travel(result)[0] == pytest.approx(expected, rel=0.01)
    assert result.summary["energy_error"] < 0.02


@pytest.mark.parametrize("table", ["by_speed", "by_hersey"])
def test_block_slides_as_viscous_friction_lets_it(table, device):
    """μ = c v̂ at the process's speed v̂ = v T/T̂: v = (a/b)(1 − e^(−bt)), a = g sin α."""
    duration, slower, rise = 0.02, 50.0, 0.1  # μ = rise · v / (1 mm/s in the process)
    b = rise / (1e-3 * slower) * G * math.cos(SLOPE)
    pressure = STIFF.areal_density * G * math.cos(SLOPE)
    law = Friction(coefficient=1.0, by_speed=((0.0, 0.0), (1.0, rise * 1e3)))
    if table == "by_hersey":
        viscosity = 2.0
        steep = rise * 1e3 * pressure / viscosity
        law = Friction(coefficient=1.0, by_hersey=((0.0, 0.0), (1.0, steep)), viscosity=viscosity)
    scene = slope(law, duration=duration, process_duration=slower * duration)
    result = scene.run(device=device, frames=5)
    a = G * math.sin(SLOPE)
    free = 0.5 * a * duration**2
    expected = a / b * (duration - (1.0 - math.exp(-b * duration)) / b)
    assert expected < 0.9 * free
    assert travel(result)[0] == pytest.approx(expected, rel=0.01)
    assert result.summary["energy_error"] < 0.02


@pytest.mark.parametrize(
    ("turned", "mu"), [(0.0, 0.2), (45.0, 0.3), (-60.0, 0.4), (90.0, 0.6), (120.0, 0.4)]
)
def test_plies_rub_by_the_angle_between_their_warps(turned, mu, device):
    skew = replace(STIFF, yarn_angle=math.radians(75.0))  # the weft has no say
    low = Ply.rectangle("low", skew, 0.06, cells=3)
    high = Ply.rectangle("high", STIFF, 0.02, cells=2, warp_angle=math.radians(turned))
    angle, duration = 0.7, 0.02
    scene = Scene(
        name="rub",
        plies=lay_up([low, high]),
        clamps=[Clamp(name="held", ply="low", where=lambda p: p[:, 0] < 1.0)],
        duration=duration,
        tools=[Tool.plate(width=0.5, height=0.5).moved((0.0, 0.0, -0.1))],
        friction=Friction(coefficient=0.3, by_pressure=PRESSURE),  # another law, of nothing here
        ply_friction=Friction(coefficient=0.2, by_angle=ANGLE),
        gravity=(G * math.sin(angle), 0.0, -G * math.cos(angle)),
    )
    result = scene.run(device=device, frames=5)
    expected = 0.5 * G * (math.sin(angle) - mu * math.cos(angle)) * duration**2
    moved = (result.plies[1].points - result.plies[1].rest_points)[:, 0].mean()
    assert moved == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"coefficient": 0.0, "by_speed": SPEED}, "above zero"),
        ({"coefficient": 0.3, "by_speed": ((1.0, 0.3),)}, "by_speed has one point"),
        ({"coefficient": 0.3, "by_speed": ((1.0, 0.3), (0.0, 0.2))}, "sort it"),
        ({"coefficient": 0.3, "by_pressure": ((0.0, 0.3), (1.0, -0.2))}, "below zero"),
        ({"coefficient": 0.3, "by_pressure": "much"}, "must be finite numbers"),
        ({"coefficient": 0.3, "by_pressure": ((0.0, 0.3), (1.0, math.nan))}, "finite"),
        ({"coefficient": 0.3, "by_hersey": HERSEY}, "go together"),
        ({"coefficient": 0.3, "viscosity": 1.0}, "go together"),
        (
            {"coefficient": 0.3, "by_hersey": HERSEY, "viscosity": 1.0, "by_speed": SPEED},
            "holds pressure and speed already",
        ),
        ({"coefficient": 0.3, "by_angle": ((0.0, 0.3), (1.6e2, 0.2))}, "0 to 90"),
    ],
)
def test_a_law_that_cannot_be_meant_is_refused(settings, match):
    with pytest.raises(InputError, match=match):
        Friction(**settings)


def test_a_scene_refuses_laws_that_it_cannot_follow():
    by_speed = Friction(coefficient=0.3, by_speed=SPEED)
    with pytest.raises(InputError, match="needs process_duration"):
        slope(by_speed)
    with pytest.raises(InputError, match="leave out kinetic_limit"):
        slope(by_speed, process_duration=1.0, numerics=Numerics(kinetic_limit=0.05))
    with pytest.raises(InputError, match="a tool has no yarns"):
        slope(Friction(coefficient=0.3, by_angle=ANGLE))
    with pytest.raises(InputError, match="process_duration"):
        slope(0.3, process_duration=-1.0)


def test_the_record_of_a_run_holds_its_friction(tmp_path):
    import json

    law = Friction(coefficient=0.3, by_pressure=PRESSURE, source="measured in our laboratory")
    slope(law, duration=1e-3).run(tmp_path / "run", frames=1)
    record = json.loads((tmp_path / "run" / "run.json").read_text())
    assert record["friction"]["by_pressure"] == [list(pair) for pair in PRESSURE]
    assert record["tools"][0]["friction"]["source"] == "measured in our laboratory"

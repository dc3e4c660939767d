"""Coulomb friction that sticks: a block on an incline, a strip over a drum."""

import math
from dataclasses import replace

import numpy as np
import pytest
from law_checks import fabric

from warpdrape.blanks.ply import Ply, lay_up
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import InputError
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.setup import Clamp
from warpdrape.tools.motion import Path
from warpdrape.tools.tool import Tool

G = 9.81
STIFF = fabric(LinearTension(1e3, 1e3), ShearPolynomial((1e-3,)), factor=1.0)
DRUM = 0.05
EDGE = 5e-3


def incline(friction, angle, duration):
    """A stiff patch on a level plate, gravity tilted instead of the plate."""
    ply = Ply.rectangle("block", STIFF, 0.02, cells=2)
    return Scene(
        name="incline",
        plies=lay_up([ply]),
        tools=[Tool.plate(width=0.5, height=0.5)],
        duration=duration,
        friction=friction,
        gravity=(G * math.sin(angle), 0.0, -G * math.cos(angle)),
    )


def travel(result):
    """Mean displacement of the block [m], shape [3]."""
    return (result.plies[0].points - result.plies[0].rest_points).mean(axis=0)


@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_block_sticks_below_the_angle_of_friction_without_creep(friction, device):
    angle = 0.95 * math.atan(friction)
    short, long = (incline(friction, angle, t).run(device=device, frames=5) for t in (0.02, 0.2))
    # At rest on its springs of stiffness share · m/Δt²; it swings in to them while it settles.
    step = long.summary["time_step_s"]
    spring = G * math.sin(angle) * step**2 / Numerics().contact_share
    assert 0.9 * spring < travel(long)[0] < 4.0 * spring
    crept = travel(long)[0] - travel(short)[0] * (step / short.summary["time_step_s"]) ** 2
    # In 180 ms, where it would slide 7 mm if free; what is left is a tremble on a 2 nm spring.
    assert abs(crept) < 0.1 * spring
    assert abs(travel(long)[1]) < 1e-6 * spring
    speed = np.sqrt(2 * long.history["kinetic_j"][-1] / long.summary["mass_kg"])
    assert speed < 1e-5
    assert long.summary["energy_error"] < 0.02


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5])
def test_block_slides_above_the_angle_of_friction(friction, device):
    angle, duration = 1.2 * math.atan(friction) + 0.05, 0.03
    result = incline(friction, angle, duration).run(device=device, frames=5)
    expected = 0.5 * G * (math.sin(angle) - friction * math.cos(angle)) * duration**2
    moved = travel(result)
    assert expected > 1e-4
    assert moved[0] == pytest.approx(expected, rel=0.005)
    assert abs(moved[1]) < 1e-9
    # What friction took is μ N times the way.
    weight = result.summary["mass_kg"] * G * math.cos(angle)
    assert result.history["friction_j"][-1] == pytest.approx(friction * weight * moved[0], rel=0.01)
    assert result.summary["energy_error"] < 0.02


def test_plies_rub_with_a_coefficient_of_their_own(device):
    """The lower ply is held, the upper one slides on it as a block does on an incline."""
    angle, friction, duration = 0.4, 0.3, 0.02
    low = Ply.rectangle("low", STIFF, 0.06, cells=3)
    high = Ply.rectangle("high", STIFF, 0.02, cells=2)
    scene = Scene(
        name="rub",
        plies=lay_up([low, high]),
        clamps=[Clamp(name="held", ply="low", where=lambda p: p[:, 0] < 1.0)],
        duration=duration,
        friction=0.9,
        ply_friction=friction,
        gravity=(G * math.sin(angle), 0.0, -G * math.cos(angle)),
    )
    result = scene.run(device=device, frames=5)
    expected = 0.5 * G * (math.sin(angle) - friction * math.cos(angle)) * duration**2
    moved = (result.plies[1].points - result.plies[1].rest_points)[:, 0].mean()
    assert moved == pytest.approx(expected, rel=0.02)
    assert result.summary["interfaces"][1]["max_slip_m"] == pytest.approx(expected, rel=0.05)


def three_fabrics():
    """Two narrow plies on a held one, each fabric with a name of its own, under a slope."""
    angle = 0.4
    names = ("a", "b", "c")
    plies = lay_up(
        [
            Ply.rectangle(name, replace(STIFF, name=name), width, cells=cells)
            for name, width, cells in zip(names, (0.06, 0.03, 0.015), (3, 3, 2), strict=True)
        ]
    )
    held = Clamp(name="held", ply="a", where=lambda p: p[:, 0] < 1.0)
    gravity = (G * math.sin(angle), 0.0, -G * math.cos(angle))
    return {"name": "rub", "plies": plies, "clamps": [held], "duration": 0.02, "gravity": gravity}


def test_each_pair_of_fabrics_rubs_with_a_coefficient_of_its_own(device):
    pairs = {("b", "a"): 0.3, ("b", "c"): 0.1, ("a", "c"): 9.0}
    result = Scene(**three_fabrics(), ply_friction=pairs).run(device=device, frames=5)
    moved = [(ply.points - ply.rest_points)[:, 0].mean() for ply in result.plies]
    along, down = G * math.sin(0.4), G * math.cos(0.4)
    mass = [np.prod((0.03, 0.03)), np.prod((0.015, 0.015))]
    top = along - 0.1 * down  # slides on b, and b on a: with c's weight and its rubbing
    middle = along - (0.3 * (mass[0] + mass[1]) - 0.1 * mass[1]) / mass[0] * down
    assert moved[2] == pytest.approx(0.5 * top * 0.02**2, rel=0.02)
    assert moved[1] == pytest.approx(0.5 * middle * 0.02**2, rel=0.02)


@pytest.mark.parametrize(
    ("pairs", "match"),
    [
        ({("a", "b"): 0.3, ("b", "c"): 0.1}, "lacks the fabrics of plies 'a' and 'c': add "),
        ({("a", "b"): 0.3, ("b", "c"): -0.1, ("a", "c"): 0.2}, "must be zero or more"),
        ({("a", "b"): "much", ("b", "c"): 0.1, ("a", "c"): 0.2}, "must be a number"),
        ("much", "must be a number"),
    ],
)
def test_friction_that_says_too_little_is_refused(pairs, match):
    with pytest.raises(InputError, match=match):
        Scene(**three_fabrics(), ply_friction=pairs)


def test_plate_may_be_tilted_instead_of_gravity(device):
    friction, angle, duration = 0.3, 0.4, 0.02
    level = incline(friction, angle, duration)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    tilted = Scene(
        name="tilted",
        plies=level.plies,
        tools=[Tool.plate(width=0.5, height=0.5).turned((0.0, 1.0, 0.0), angle)],
        duration=duration,
        friction=friction,
        gravity=turn @ level.gravity,
    )
    np.testing.assert_allclose(tilted.gravity, (0.0, 0.0, -G), atol=1e-12)
    ends = []
    for scene, start in ((level, np.eye(3)), (tilted, turn)):
        model = build_model(scene, device, 1)
        state = initial_state(model)
        state.plies.x.assign(state.plies.x.numpy() @ start.T)
        stepper = Stepper(model, state)
        stepper.begin_frame(1)
        for _ in range(model.timing.steps_per_frame // model.timing.search_every):
            stepper.block()
        ends.append(state.plies.x.numpy() @ start)
    way = (ends[0] - level.plies[0].rest_points).mean(axis=0)
    assert way[0] == pytest.approx(0.5 * G * (s - friction * c) * duration**2, rel=0.005)
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-3 * way[0])


def strip_over_drum(friction, wrap, *, half=0.11, strain=0.03, duration=0.04):
    """A strip laid round a drum along involutes, then pulled at one end; the other is held."""
    cloth = fabric(LinearTension(300.0, 300.0), ShearPolynomial((1e-3,)))
    ply = Ply.rectangle("strip", cloth, 2 * half, EDGE, edge=EDGE, mesh="grid", z=0.0)
    radius = DRUM + 0.5 * cloth.thickness
    drum = Tool.drum(radius=DRUM, length=3 * EDGE, facet=EDGE).moved((0.0, 0.0, -radius))
    wound = 0.6  # share of the run in which the strip is laid round the drum
    u = np.linspace(0.0, 1.0, 61)
    angle = 0.5 * wrap * (3 * u**2 - 2 * u**3)
    free = half - radius * angle
    x = radius * np.sin(angle) + free * np.cos(angle)
    z = radius * (np.cos(angle) - 1.0) - free * np.sin(angle)
    end = np.array([math.cos(0.5 * wrap), 0.0, -math.sin(0.5 * wrap)])
    pull = np.linspace(0.0, 1.0, 31)[1:]
    times = np.concatenate([wound * u, wound + (1 - wound) * pull]) * duration
    stretch = 2 * half * strain * (3 * pull**2 - 2 * pull**3)
    clamps = []
    for name, side in (("held", -1.0), ("pulled", 1.0)):
        moved = np.stack([side * (x - half), 0 * x, z], 1)
        more = stretch if name == "pulled" else 0.0 * pull
        outward = end * (side, 1.0, 1.0)
        path = np.concatenate([moved, moved[-1] + more[:, None] * outward])
        clamps.append(
            Clamp(
                name=name,
                ply="strip",
                motion=Path(times=times, positions=path),
                follow=outward,
                where=lambda p, side=side: side * p[:, 0] > half - 1e-9,
            )
        )
    return Scene(
        name="capstan",
        plies=[ply],
        tools=[drum],
        clamps=clamps,
        duration=duration,
        friction=friction,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=300.0),
    )


@pytest.mark.parametrize(("friction", "wrap_deg"), [(0.1, 90), (0.3, 180), (0.5, 120)])
def test_strip_over_a_drum_obeys_the_capstan_formula(friction, wrap_deg, device):
    wrap = math.radians(wrap_deg)
    result = strip_over_drum(friction, wrap).run(device=device, frames=20)
    assert result.summary["status"] == "completed", result.summary["message"]
    held, pulled = (result.history[f"{name}_force_n"] for name in ("held", "pulled"))
    assert held[-1] > 10.0
    # Without damping the strip's vibrations carry it along: up to 1.5 % less.
    np.testing.assert_allclose(pulled[-4:] / held[-4:], math.exp(friction * wrap), rtol=0.01)
    assert result.summary["energy_error"] < 0.02

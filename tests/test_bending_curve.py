"""Bending by curves: gradient of the energy, the curve followed, loops of fibre friction."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from test_bending import CLOTH, MESHES, SIZE, bent_model, blank, rolled

from warpdrape import BendingCurve, Clamp, Ply
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.partition import launches_of, shares
from warpdrape.errors import InputError
from warpdrape.forces.bending_curve import BendingCurves

# Broberg et al.: binder-stabilised fabric, moments per metre of width over curvature.
CURVATURES = [0, 2.294, 2.582, 2.929, 3.424, 4.466, 5.403, 6.582, 8.040, 10.757, 14.046, 17.665]
MOMENTS = [
    0,
    0.2735,
    0.2891,
    0.2969,
    0.3047,
    0.3165,
    0.3243,
    0.3321,
    0.3399,
    0.3516,
    0.3633,
    0.3751,
]


def curve(**changes):
    values = {
        "curvatures": CURVATURES,
        "moments_warp": MOMENTS,
        "moments_weft": 0.4 * np.array(MOMENTS),
        "in_plane": (0.01, 0.02),
        "twist": 0.003,
    }
    return BendingCurve(**(values | changes))


def ply_of(mesh, bending, cells=4, warp_angle=0.4):
    cloth = replace(CLOTH, bending=bending, yarn_angle=math.radians(80.0))
    return Ply(name="ply", fabric=cloth, mesh=blank(mesh, cells), warp_angle=warp_angle)


def number_of(model):
    return [isinstance(force, BendingCurves) for force in model.forces].index(True)


def force_at(model, state, x):
    state.plies.x.assign(x)
    state.plies.f.zero_()
    (share,) = shares(model, 1)
    for launch in launches_of(model, share, state)[number_of(model)].scatter:
        launch(model.device)
    return state.plies.f.numpy().copy()


def stored(model, state, x):
    state.plies.x.assign(x)
    return measure(model, state)[number_of(model)].stored["bending_curves"]


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("held", [False, True])
def test_force_is_minus_the_gradient_of_the_energy(mesh, held, device):
    ply = ply_of(mesh, curve())
    clamps = [Clamp(name="left", ply="ply", where=lambda p: p[:, 0] < -0.049)] if held else []
    model, state = bent_model(ply, device, clamps)
    rng = np.random.default_rng(3)
    x = rolled(ply, 0.15, 0.7) + 1e-3 * rng.standard_normal(ply.rest_points.shape)
    force = force_at(model, state, x)
    step, found = 1e-7, np.zeros_like(force)
    for i in np.ndindex(*x.shape):
        ends = []
        for sign in (1.0, -1.0):
            moved = x.copy()
            moved[i] += sign * step
            ends.append(stored(model, state, moved))
        found[i] = -(ends[0] - ends[1]) / (2.0 * step)
    # Rounding of an energy of 1e-3 J over the step: 1e-12 of it is 1e-8 N.
    np.testing.assert_allclose(force, found, atol=1e-6 * np.abs(force).max())


@pytest.mark.parametrize("mesh", ["aligned", "random"])
def test_the_curve_is_followed(mesh, device):
    """Energy of cylinders of several radii, whose slope over 1/R is the moment."""
    ply = ply_of(mesh, curve(), cells=12, warp_angle=0.0)
    model, state = bent_model(ply, device)
    through = PchipInterpolator(CURVATURES, MOMENTS)
    for curvature in (1.0, 2.4, 4.0, 9.0):
        low, high = (stored(model, state, rolled(ply, 1 / (curvature * s))) for s in (0.999, 1.001))
        moment = (high - low) / (0.002 * curvature * SIZE**2)
        share = math.cos(math.radians(80.0)) ** 2  # of the curvature along the weft at 80°
        weft = 0.4 * share * through(share * curvature)
        twist = 4 * 0.003 * share * curvature
        expected = through(curvature) + weft + twist
        assert moment == pytest.approx(expected, rel=0.01)


def test_a_loop_of_friction_loses_what_dahl_s_law_says(device):
    """Bent to and fro between ±κ: the loop of the friction's moment, integrated finely."""
    yields, onset, largest = (0.05, 0.02), 1.0, 8.0
    bending = curve(friction=yields, friction_curvature=onset)
    ply = ply_of("aligned", bending, cells=8, warp_angle=0.0)
    ply = replace(ply, fabric=replace(ply.fabric, yarn_angle=0.5 * math.pi))
    model, state = bent_model(ply, device)
    path = largest * np.sin(np.linspace(0.0, 4.5 * math.pi, 1801))
    losses = []
    for curvature in path:
        force_at(model, state, rolled(ply, 1.0 / curvature if curvature else 1e9))
        losses.append(measure(model, state)[number_of(model)].lost["fibre_friction"])
    loop = (losses[1800] - losses[1000]) / SIZE**2  # a whole turn
    # Saturated at ±M_y: 4 M_y κ, less what builds up anew after each turning.
    s = np.linspace(0.0, 2.0 * largest, 200_001)
    moment = yields[0] * (1.0 - 2.0 * np.exp(-s / onset))
    exact = 2.0 * float(np.trapezoid(moment, s))
    assert loop == pytest.approx(exact, rel=0.01)
    # The work of a moment counts half a step later than the spring's energy.
    assert (np.diff(losses) > -1e-3 * losses[-1]).all()


def test_rigid_motions_cost_nothing(device):
    ply = ply_of("random", curve(friction=(0.05, 0.02)))
    model, state = bent_model(ply, device)
    bent = np.abs(force_at(model, state, rolled(ply, 0.2))).max()
    state.memory[number_of(model)][0].zero_()
    c, s = math.cos(0.7), math.sin(0.7)
    turned = ply.rest_points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) + 0.1
    assert np.abs(force_at(model, state, turned)).max() < 1e-9 * bent


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"curvatures": [0, 1]}, "three or more"),
        ({"curvatures": CURVATURES[::-1]}, "must rise from 0"),
        ({"moments_warp": [0, *MOMENTS[:-1][::-1]]}, "moments_warp must start at 0 and not fall"),
        ({"moments_weft": MOMENTS[:-1]}, "moments_weft needs a finite moment for each"),
        ({"friction_curvature": 0.0}, "friction_curvature = 0.0 1/m must be above zero"),
    ],
)
def test_curves_that_make_no_sense_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        curve(**changes)


def test_a_clamp_that_turns_such_a_ply_is_refused():
    turning = Clamp(
        name="grip",
        ply="ply",
        where=[0, 1],
        matrix=lambda t: np.broadcast_to(np.eye(3), (len(t), 3, 3)),
    )
    with pytest.raises(InputError, match="clamp 'grip' turns the slope of ply 'ply'"):
        bent_model(ply_of("aligned", curve()), clamps=[turning])
    free = replace(turning, slope="free")
    bent_model(ply_of("aligned", curve()), clamps=[free])

"""Viscosity of a matrix and its shift with temperature: kernels, records, limits, refusals."""

import math

import numpy as np
import pytest
import warp as wp
from matrix_checks import LAWS, SHIFTS

from warpdrape import Heat, InputError, Matrix
from warpdrape.forces.matrix import shift_struct, viscosity_struct
from warpdrape.kernels.materials.viscosity import (
    Shift,
    Viscosity,
    flow_rate,
    flow_stress,
    shift_factor,
)
from warpdrape.laws import WLF, Arrhenius, Cross, Newtonian, PowerLaw


@wp.kernel(enable_backward=False)
def ask_flow(
    law: Viscosity,
    rate: wp.array(dtype=wp.float64),
    stress: wp.array(dtype=wp.vec2d),
):
    i = wp.tid()
    stress[i] = flow_stress(law, rate[i])


@wp.kernel(enable_backward=False)
def ask_rate(
    law: Viscosity,
    scale: wp.float64,
    drag: wp.float64,
    load: wp.array(dtype=wp.float64),
    guess: wp.array(dtype=wp.float64),
    rate: wp.array(dtype=wp.float64),
):
    i = wp.tid()
    rate[i] = flow_rate(law, scale, drag, load[i], guess[i])


@wp.kernel(enable_backward=False)
def ask_shift(
    shift: Shift, temperature: wp.array(dtype=wp.float64), factor: wp.array(dtype=wp.float64)
):
    i = wp.tid()
    factor[i] = shift_factor(shift, temperature[i])


def launched(kernel, inputs, given, kind, device):
    arrays = [wp.array(each, dtype=wp.float64, device=device) for each in given]
    found = wp.array(np.full((len(given[0]), wp.types.type_size(kind)), np.nan).squeeze(), kind)
    found = found.to(device)
    wp.launch(kernel, len(given[0]), inputs=[*inputs, *arrays], outputs=[found], device=device)
    return found.numpy()


@pytest.mark.parametrize("name", LAWS)
def test_kernel_and_record_give_the_same_stress_and_its_slope(name, device):
    law = LAWS[name]
    rates = np.concatenate([[0.0], np.logspace(-6, 3, 40)])
    found = launched(ask_flow, [viscosity_struct(law)], [rates], wp.vec2d, device)
    np.testing.assert_allclose(found[:, 0], law.stress(rates), rtol=1e-12)
    step = 1e-5 * rates[1:]
    slope = (law.stress(rates[1:] + step) - law.stress(rates[1:] - step)) / (2.0 * step)
    rounding = 1e-10 * found[1:, 0] / rates[1:]  # of stresses that hardly rise any more
    assert (np.abs(found[1:, 1] - slope) < 1e-8 * slope + rounding).all()
    assert (np.diff(found[:, 1]) <= 1e-9 * found[0, 1]).all() and (found[:, 1] > 0.0).all()
    np.testing.assert_array_equal(law.stress(-rates), -law.stress(rates))


def test_laws_are_what_they_are_called():
    power = LAWS["power"]
    assert float(power.stress(0.1)) == pytest.approx(1e5)
    far = power.stress(np.array([1e3, 1e4]))
    assert math.log10(far[1] / far[0]) == pytest.approx(0.45, abs=1e-6)
    assert float(power.stress(1e-9)) == pytest.approx(power.at_rest * 1e-9)
    cross = LAWS["cross"]
    assert float(cross.stress(1.0 / 30.0)) * 30.0 == pytest.approx(0.5 * (4e6 + 2e4))
    assert float(cross.stress(1e-12)) == pytest.approx(4e6 * 1e-12, rel=1e-6)
    assert float(cross.stress(1e12)) == pytest.approx(2e4 * 1e12, rel=1e-4)


@pytest.mark.parametrize("name", SHIFTS)
def test_shift_is_one_at_the_reference_and_ends_at_the_lowest(name, device):
    law = SHIFTS[name]
    warmth = np.array([300.0, 463.0, 500.0, 533.0, 600.0])
    found = launched(ask_shift, [shift_struct(law)], [warmth], wp.float64, device)
    np.testing.assert_allclose(found, [law.factor(t) for t in warmth], rtol=1e-12)
    assert found[3] == pytest.approx(1.0) and found[0] == found[1]
    assert found[1] > 3.0 and (np.diff(found[1:]) < 0.0).all()
    exact = {
        "arrhenius": math.exp(6e4 / 8.314462618 * (1 / 500 - 1 / 533)),
        "wlf": 10 ** (4.0 * 33.0 / (150.0 - 33.0)),
    }
    assert found[2] == pytest.approx(exact[name], rel=1e-9)
    assert shift_factor(shift_struct(None), wp.float64(500.0)) == 1.0


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("drag", [1e-6, 1e-3, 1e4])
def test_rate_bears_the_load_whatever_it_begins_with(name, drag, device):
    rng = np.random.default_rng(4)
    load = np.concatenate([[0.0, 1e-30, 1e-8], 10 ** rng.uniform(-6, 5, 60)])
    guess = np.concatenate([[0.0, 0.0, 1e6], 10 ** rng.uniform(-9, 6, 30), np.zeros(30)])
    inputs = [viscosity_struct(LAWS[name]), 5e-4, drag]
    rate = launched(ask_rate, inputs, [load, guess], wp.float64, device)
    assert (rate >= 0.0).all() and rate[0] == 0.0
    borne = 5e-4 * LAWS[name].stress(rate) + drag * rate
    np.testing.assert_allclose(borne, load, rtol=1.01e-8)  # as exact as it asks for


MELT = {"activation_energy": 6e4, "reference_temperature": 533.0, "lowest_temperature": 463.0}
SLOW = {"c1": 8.0, "c2": 50.0, "reference_temperature": 533.0, "lowest_temperature": 500.0}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Newtonian(0.0), "viscosity = 0.0 Pa·s must be above zero"),
        (lambda: PowerLaw(1e6, 1.2, 0.1, 0.01), "exponent = 1.2 must be above 0"),
        (lambda: PowerLaw(1e6, 0.0, 0.1, 0.01), "exponent = 0 must be above 0"),
        (lambda: PowerLaw(1e6, 0.5, 0.1, 0.0), "lowest_rate = 0.0 1/s must be above zero"),
        (lambda: Cross(1e4, 2e4, 1.0, 0.5), "at_last = 20000 Pa·s must be below at_rest"),
        (lambda: Arrhenius(**{**MELT, "activation_energy": 60.0}), "give J/mol"),
        (lambda: Arrhenius(**{**MELT, "reference_temperature": 260.0}), "must not exceed"),
        (lambda: Arrhenius(**{**MELT, "lowest_temperature": 100.0}), "give kelvin"),
        (lambda: Arrhenius(**{**MELT, "activation_energy": 1e6}), "times as viscous"),
        (lambda: WLF(**{**SLOW, "lowest_temperature": 480.0}), "must be above"),
        (lambda: WLF(**{**SLOW, "lowest_temperature": 484.0}), "times as viscous"),
        (lambda: Heat(capacity=0.0, conductance=1.0), "capacity = 0.0"),
        (lambda: Matrix(viscosity=1e6), "is no laws.Newtonian"),
        (lambda: Matrix(viscosity=Newtonian(1.0), shift=1.0), "is no laws.Arrhenius"),
        (lambda: Matrix(viscosity=Newtonian(1.0), heat=1.0), "is no warpdrape.Heat"),
        (lambda: Matrix(viscosity=Newtonian(1.0), rise=1.0), "must be two numbers"),
        (lambda: Matrix(viscosity=Newtonian(1.0), rise=(1.0, -1.0)), "must be zero or more"),
        (lambda: Matrix(viscosity=Newtonian(1.0), modulus=-1.0), "modulus = -1.0"),
        (
            lambda: Matrix(viscosity=Newtonian(1.0), heat=Heat(capacity=900.0, conductance=300.0)),
            "give shift too",
        ),
    ],
)
def test_values_that_cannot_be_meant_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()

"""Laws of cells with more yarn in them, or less: slopes of their energy, and how stiff they get."""

import functools

import numpy as np
import pytest
import warp as wp
from law_checks import SPACING, UNEQUAL, crimp_table, fabric

from warpdrape.forces.sliding_chains import CLOSEST
from warpdrape.kernels.forces.slid_laws import (
    make_slid_law,
    slid_crimp_energy,
    slid_crimp_loads,
)
from warpdrape.kernels.materials.crimp import CrimpInterchange as CrimpStruct
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.law_data import membrane_functions, tension_stiffness, tension_struct
from warpdrape.materials.laws import LinearTension

CLOTHS = {
    "linear": fabric(LinearTension(46e3, 48e3), factor=0.3),
    "crimp": fabric(UNEQUAL, factor=0.3),
    "tabulated": fabric(crimp_table(), cell=(SPACING, SPACING), factor=0.3),
}


@functools.cache
def sampler(name):
    """A kernel: w, then ∂w/∂ρ and −∂w/∂λ, of rows (ρ1, ρ2, λ1, λ2)."""
    pull, energy, _, _, Tension, _ = membrane_functions(CLOTHS[name])
    if Tension is CrimpStruct:
        slid_loads, slid_energy = slid_crimp_loads, slid_crimp_energy
    else:
        slid_loads, slid_energy = make_slid_law(pull, energy, Tension)

    @wp.kernel(module="unique", enable_backward=False)
    def sample(law: Tension, at: wp.array(dtype=wp.vec4d), out: wp.array2d(dtype=wp.float64)):
        i = wp.tid()
        distance = wp.vec2d(at[i][0], at[i][1])
        yarn = wp.vec2d(at[i][2], at[i][3])
        loads = slid_loads(law, distance, yarn)
        out[i, 0] = slid_energy(law, distance, yarn)
        for f in range(2):
            out[i, 1 + f] = loads.pull[f]
            out[i, 3 + f] = loads.draw[f]

    return sample


def sampled(name, at):
    """Energies [J/m²], shape [n], and (∂w/∂ρ, −∂w/∂λ) [N/m], shape [n, 4]."""
    out = wp.zeros((len(at), 5), dtype=wp.float64, device="cpu")
    inputs = [tension_struct(CLOTHS[name], "cpu"), wp.array(at, dtype=wp.vec4d, device="cpu")]
    wp.launch(sampler(name), len(at), inputs=inputs, outputs=[out], device="cpu")
    return out.numpy()[:, 0], out.numpy()[:, 1:]


def states(rng, n=60, taut=0.002):
    """Rows (ρ, λ) of yarns that are strained by up to a per cent, some of them slack."""
    yarn = rng.uniform(CLOSEST, 1.2, (n, 2))
    strain = rng.uniform(taut, 0.009, (n, 2))
    strain[: n // 6, 0] *= -1.0
    return np.column_stack([yarn * (1.0 + strain), yarn])


@pytest.mark.parametrize("name", CLOTHS)
def test_loads_are_the_slopes_of_the_energy(name):
    at = states(np.random.default_rng(1))
    loads, step = sampled(name, at)[1], 1e-6
    assert np.abs(loads).max(axis=0).min() > 1e4
    for k, sign in enumerate((1.0, 1.0, -1.0, -1.0)):
        move = step * np.eye(4)[k]
        w = [sampled(name, at + way * move)[0] for way in (-2, -1, 1, 2)]
        slope = sign * (8.0 * (w[2] - w[1]) - (w[3] - w[0])) / (12.0 * step)
        np.testing.assert_allclose(loads[:, k], slope, atol=1e-7 * np.abs(loads).max())


@pytest.mark.parametrize("name", CLOTHS)
def test_without_slides_it_is_the_card(name):
    strain = np.random.default_rng(2).uniform(-0.002, 0.009, (40, 2))
    at = np.column_stack([1.0 + strain, np.ones_like(strain)])
    energies, loads = sampled(name, at)
    tensions, card = sample_tensions(CLOTHS[name], strain)
    np.testing.assert_allclose(loads[:, :2], tensions, rtol=1e-9, atol=1e-6)
    flat = sample_tensions(CLOTHS[name], np.zeros((1, 2)))[1]
    np.testing.assert_allclose(energies, card - flat, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", CLOTHS)
def test_no_bar_is_stiffer_than_the_step_allows(name):
    """Second slopes by distances, and by yarns, over the card's bound: at most 1/closest²."""
    at = states(np.random.default_rng(3), taut=0.0)
    bound = np.sqrt(tension_stiffness(CLOTHS[name]))
    largest = 0.0
    for first, sign in ((0, 1.0), (2, -1.0)):
        rows = []
        for k in (0, 1):
            move = 1e-7 * np.eye(4)[first + k]
            up, down = (sampled(name, at + way * move)[1] for way in (1.0, -1.0))
            rows.append(sign * (up - down)[:, first : first + 2] / 2e-7)
        matrix = np.stack(rows, axis=1) / (bound[:, None] * bound)
        highest = np.linalg.eigvalsh(0.5 * (matrix + np.swapaxes(matrix, 1, 2)))[:, -1].max()
        assert 0.2 < highest
        largest = max(largest, highest)
    coupled = name != "linear"
    assert largest < 1.03 / (CLOSEST**2 if coupled else CLOSEST)  # (1 + ε)² on a slide

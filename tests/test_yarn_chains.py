"""Chains of a net's yarns: their bars from end to end, and what is left of a yarn."""

import math

import numpy as np
import pytest
import warp as wp
from sliding_checks import Led, blank

from warpdrape.blanks.yarn_chains import NONE, chain_yarns
from warpdrape.forces.ply_net import net_of
from warpdrape.kernels.forces.yarn_chains import Crossovers, share_left, share_slope, yarn_left


@pytest.mark.parametrize(
    ("mesh", "angle", "cells"),
    [("diagonal", 0.0, 4), ("aligned", 0.0, 4), ("aligned", math.pi / 4, 4), ("aligned", 0.4, 11)],
)
def test_chains_hold_every_yarn_of_the_ply_from_end_to_end(mesh, angle, cells):
    ply = blank(mesh=mesh, warp_angle=angle, cells=cells)
    chains, net = chain_yarns(net_of(ply)), net_of(ply)
    for family in (0, 1):
        own = chains.family == family
        covered = (chains.widths * chains.lengths)[own].sum()
        assert covered == pytest.approx(ply.mesh.areas.sum(), rel=1e-12)
        before, after = chains.bars[:, 2 * family], chains.bars[:, 2 * family + 1]
        inner = (before != NONE) & (after != NONE)
        np.testing.assert_allclose(
            chains.widths[before[inner]], chains.widths[after[inner]], rtol=1e-12
        )
        # the flat coordinate along the yarn tells the same lengths
        along = ply.mesh.vertices[chains.vertices] @ ply.yarn_directions[family]
        upper = chains.numbers[own]
        way = along[upper[:, 1]] - along[upper[:, 0]]
        np.testing.assert_allclose(way, chains.lengths[own], rtol=1e-9)
        moved = chains.below[upper[:, 1], family] - chains.below[upper[:, 0], family]
        np.testing.assert_allclose(moved, way, rtol=1e-9)
        whole = chains.below[:, family] + chains.above[:, family]
        np.testing.assert_allclose(whole[upper[:, 0]], whole[upper[:, 1]], rtol=1e-12)
        assert chains.below[before == NONE, family].max() == 0.0
        assert np.abs(chains.above[after == NONE, family]).max() < 1e-12
        for k, b in enumerate(net.quadrants[:9]):
            ends = set(chains.ends[chains.quadrants[k, family]])
            assert ends == {b[0], b[1 + family]}
    assert chains.areas.sum() == pytest.approx(ply.mesh.areas.sum(), rel=1e-12)


def test_what_is_left_of_a_yarn_in_a_crossover():
    """Whole until its end comes into the crossover's length, none when it has gone by."""
    cases = [
        ((0.5, 0.5, 0.2), 0.0, 1.0),
        ((0.2, 0.9, 0.2), 0.0, 1.0),
        ((0.2, 0.9, 0.2), -0.05, 0.75),
        ((0.2, 0.9, 0.2), -0.25, 0.0),
        ((0.9, 0.2, 0.2), 0.15, 0.25),
        ((0.9, 0.2, 0.2), -0.15, 1.0),
        ((0.0, 0.0, 0.0), 0.0, 0.0),
    ]
    for (below, above, span), s, left in cases:
        assert _on_device(share_left, below, above, span, s) == pytest.approx(left, abs=1e-12)
        for step in (1e-7, -1e-7):  # the slope on either side of a corner may differ
            rise = _on_device(share_left, below, above, span, s + step) - left
            away = _slope_on_device(below, above, span, s + 0.5 * step)
            assert rise / step == pytest.approx(away, abs=1e-6)
    led, rng = Led(blank()), np.random.default_rng(3)
    slides = rng.uniform(-0.03, 0.03, (led.count, 2))
    on_host = led.of.chains.left(slides)
    assert 0.1 < (on_host > 0.0).mean() < 0.9
    found = wp.zeros(led.count, dtype=wp.vec2d, device="cpu")
    given = wp.array(slides, dtype=wp.vec2d, device="cpu")
    inputs = [led.of.crossovers, given]
    wp.launch(_shares, led.count, inputs=inputs, outputs=[found], device="cpu")
    np.testing.assert_allclose(found.numpy(), on_host, atol=1e-12)


@wp.kernel
def _shares(crossovers: Crossovers, s: wp.array(dtype=wp.vec2d), left: wp.array(dtype=wp.vec2d)):
    v = wp.tid()
    left[v] = wp.vec2d(yarn_left(crossovers, v, 0, s[v][0]), yarn_left(crossovers, v, 1, s[v][1]))


@wp.kernel
def _share(a: wp.vec4d, out: wp.array(dtype=wp.float64)):
    out[0] = share_left(a[0], a[1], a[2], a[3])


@wp.kernel
def _slope(a: wp.vec4d, out: wp.array(dtype=wp.float64)):
    out[0] = share_slope(a[0], a[1], a[2], a[3])


def _slope_on_device(*numbers):
    out = wp.zeros(1, dtype=wp.float64, device="cpu")
    wp.launch(_slope, 1, inputs=[wp.vec4d(*numbers)], outputs=[out], device="cpu")
    return float(out.numpy()[0])


def _on_device(_, *numbers):
    out = wp.zeros(1, dtype=wp.float64, device="cpu")
    wp.launch(_share, 1, inputs=[wp.vec4d(*numbers)], outputs=[out], device="cpu")
    return float(out.numpy()[0])

"""Accuracy as a choice: what it sets in each press, and what counts more."""

import inspect
import math
from dataclasses import replace

import numpy as np
import pytest
from law_checks import fabric

from warpdrape.blanks.ply import Ply
from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import IsotropicMembrane, LinearTension, TabulatedTension
from warpdrape.numerics import ACCURACIES, Numerics
from warpdrape.scenes import (
    double_dome,
    hemisphere,
    prism,
    square_box,
    stacked_hemisphere,
    tetrahedron,
    three_ply_hemisphere,
)
from warpdrape.scenes.press import SOFTEST, most_softening, press_numerics

PRESSES = (
    double_dome,
    hemisphere,
    prism,
    square_box,
    stacked_hemisphere,
    tetrahedron,
    three_ply_hemisphere,
)
STANDARD = Numerics(yarn_softening=100.0, yarn_recovery=0.4, contact_share=0.15, search_slide=1e-4)


def test_an_accuracy_is_a_set_of_numerics():
    assert Numerics.for_accuracy("reference") == Numerics()
    assert Numerics.for_accuracy("standard") == STANDARD
    draft = Numerics.for_accuracy("draft")
    assert draft == replace(STANDARD, contact_share=0.1)  # and a shorter stroke
    changed = Numerics.for_accuracy("standard", contact_share=0.15, damping=3.0)
    assert (changed.contact_share, changed.damping, changed.yarn_softening) == (0.15, 3.0, 100.0)
    with pytest.raises(InputError, match="unknown accuracy 'standart'; did you mean 'standard'"):
        Numerics.for_accuracy("standart")
    with pytest.raises(TypeError):
        ACCURACIES["draft"] = {}


@pytest.mark.parametrize("scene", PRESSES, ids=lambda module: module.__name__.split(".")[-1])
def test_every_press_takes_an_accuracy(scene):
    build = scene.build
    standard, fast = build(cells=4), build(cells=4, fast=True)
    assert standard.numerics == STANDARD == fast.numerics
    exact = build(cells=4, accuracy="reference")
    assert exact.numerics == Numerics()
    draft = build(cells=4, accuracy="draft")
    assert draft.numerics == Numerics.for_accuracy("draft")
    strokes = [stroke(each) for each in (draft, standard, fast, exact)]
    assert strokes == [(0.04, 0.85), (0.08, 0.85), (0.08, 0.85), (0.16, 0.85)]
    assert draft.duration == pytest.approx(1.2 * 0.04)
    assert "accuracy:" in inspect.getdoc(build)


def test_what_a_press_is_told_besides_counts_more():
    paced = hemisphere.build(cells=4, kinetic_limit=0.02, minimum_time_step=9e-6).numerics
    assert (paced.kinetic_limit, paced.minimum_time_step) == (0.02, 9e-6)
    assert paced.yarn_softening == 100.0
    shares = {
        (accuracy, share): hemisphere.build(
            cells=4, accuracy=accuracy, contact_share=share
        ).numerics.contact_share
        for accuracy in ("standard", "reference")
        for share in (0.02, 0.18)
    }
    # Contacts soften with the step: where that is longer, a press keeps the larger share.
    assert shares["standard", 0.02] == 0.15 and shares["standard", 0.18] == 0.18
    assert shares["reference", 0.02] == 0.02 and shares["reference", 0.18] == 0.18


def stroke(scene):
    """Duration and brake of a press's punch."""
    (punch,) = (tool for tool in scene.tools if tool.name == "punch")
    return punch.motion.duration, punch.motion.brake


def test_a_stroke_that_is_given_is_kept():
    assert stroke(hemisphere.build(cells=4, accuracy="draft", duration=0.1)) == (0.1, 0.85)
    assert stroke(hemisphere.build(cells=4, accuracy="reference", brake=0.3)) == (0.16, 0.3)


def weaker(by, factor=0.01):
    """The carbon's card with yarns that are weaker, and their resistance to compression."""
    card = load_fabric("carbon_interlock")
    tension = LinearTension(card.tension.warp / by, card.tension.weft / by)
    return replace(card, name="weaker", tension=tension, compressive_factor=factor)


def test_yarns_that_are_weak_already_are_softened_less():
    """Never more than to a hundredth of the carbon's 34.5 MN/m, nor below their compression."""
    ply = [Ply.rectangle("ply", weaker(10.0), 0.3, cells=4)]
    assert most_softening(ply[0]) == pytest.approx(34.5e6 / 10.0 / SOFTEST)
    parameters = hemisphere.build(cells=4).parameters
    assert press_numerics(parameters, ply).yarn_softening == most_softening(ply[0]) < 36.0
    exact = press_numerics({**parameters, "accuracy": "reference"}, ply)
    assert exact == Numerics()
    stiff_in_compression = Ply.rectangle("ply", weaker(1.0, 0.1), 0.3, cells=4)
    assert most_softening(stiff_in_compression) == pytest.approx(10.0)
    assert most_softening(Ply.rectangle("ply", weaker(1e3), 0.3, cells=4)) == 1.0
    sheet = fabric(IsotropicMembrane(2e4, 0.3))
    assert most_softening(Ply.rectangle("ply", sheet, 0.3, cells=4)) == math.inf


def test_a_table_is_softened_by_what_its_toe_can_bear():
    """Where crimp goes little tension is much strain: softened, the whole toe would be gone."""
    card = load_fabric("carbon_interlock")
    strains = np.linspace(-0.01, 0.01, 21)
    straight = 46e3 * np.maximum(strains, 0.01 * strains)
    toe = 46e3 * np.maximum(strains - 0.005, 0.01 * (strains - 0.005)) + 2.3

    def most(tensions, strains=strains):
        table = np.tile(tensions, (len(strains), 1))
        law = TabulatedTension(strains, strains, table.T, table)
        cloth = replace(card, name="table", tension=law)
        return most_softening(Ply.rectangle("ply", cloth, 0.3, cells=4))

    assert most(straight) > 50.0
    short = np.linspace(-0.01, 5e-4, 11)  # all that it has of taut yarns is within one step
    assert 1.0 < most(46e3 * np.maximum(short, 0.01 * short), short) < math.inf
    assert most(toe) < 2.0


def test_two_accuracies_at_once_are_refused_and_the_advice_helps():
    with pytest.raises(
        InputError, match=r"fast = true is accuracy = standard, and .*leave one out"
    ):
        hemisphere.build(cells=4, fast=True, accuracy="draft")
    assert hemisphere.build(cells=4, accuracy="draft").numerics.yarn_softening > 36.0
    with pytest.raises(InputError, match="unknown accuracy 'fine'; known: draft"):
        hemisphere.build(cells=4, accuracy="fine")

"""Scenes of prepregs that cannot be meant, and advice that works."""

from dataclasses import replace

import pytest
from prepreg_checks import CARD, coarse, frame, on_a_plate

from warpdrape import Fabric, Friction, Heat, InputError, Matrix, Numerics, Ply, Tool, lay_up
from warpdrape.laws import Arrhenius, Newtonian, PowerLaw
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.scenes import hemisphere, picture_frame
from warpdrape.units import celsius


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


def test_friction_of_the_scene_is_by_hersey_number():
    scene = coarse()
    assert isinstance(scene.friction, Friction) and scene.friction.by_hersey
    assert scene.process_duration == pytest.approx(2.4)

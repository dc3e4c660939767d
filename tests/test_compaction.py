"""Compaction: laws against closed forms, plates that press plies against their own law."""

import re
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from warpdrape import Compaction, Float, InputError, Numerics, Ply, Scene, Stroke, Tool, lay_up
from warpdrape.contact.compaction import SAMPLES, build_pads, sample
from warpdrape.dynamics.model import build_model
from warpdrape.materials.fabric_card import card
from warpdrape.materials.fabric_library import load_fabric, with_bending

THICKNESS, SIDE, START = 6e-4, 0.04, 1e-5
POWER = {
    "areal_density": 0.63,
    "fibre_density": 1760.0,
    "thickness": THICKNESS,
    "coefficient": 0.28,
    "exponent": 0.08,
    "largest_pressure": 2e5,
}


def law():
    return Compaction.power_law(**POWER)


def cloth(compaction=None):
    plain = with_bending("carbon_interlock", "none")
    return replace(plain, compaction=law() if compaction is None else compaction)


def test_a_power_law_is_v_f_equals_a_p_to_the_b():
    found = law()
    pressures = np.array([2e4, 1e5, 2e5])
    solid = POWER["areal_density"] / POWER["fibre_density"]
    offset = (solid / THICKNESS / POWER["coefficient"]) ** (1.0 / POWER["exponent"])
    thickness = solid / (POWER["coefficient"] * pressures ** POWER["exponent"])
    np.testing.assert_allclose(found.pressure(thickness), pressures - offset, rtol=2e-3)
    np.testing.assert_allclose(found.thickness_at(pressures - offset), thickness, rtol=1e-4)
    assert found.thickness == THICKNESS and found.pressure(THICKNESS) == 0.0
    assert found.pressure(2.0 * THICKNESS) == 0.0


def test_beyond_its_points_a_law_rises_with_its_last_slope():
    found = Compaction(thicknesses=(6e-4, 5e-4, 4e-4), pressures=(0.0, 1e4, 4e4))
    two = found.pressure(np.array([3e-4, 2e-4]))
    assert two[0] > 4e4
    assert two[1] - two[0] == pytest.approx(two[0] - 4e4)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"thicknesses": (6e-4, 5e-4), "pressures": (0, 1)}, "three or more"),
        ({"thicknesses": (5e-4, 6e-4, 7e-4), "pressures": (0, 1, 2)}, "must fall"),
        ({"thicknesses": (6e-4, 5e-4, 4e-4), "pressures": (0, 1)}, "pressure for each thickness"),
        ({"thicknesses": (6e-4, 5e-4, 4e-4), "pressures": (5, 6, 7)}, "must rise from 0: take off"),
        ({"thicknesses": (6e-4, 5e-4, 4e-4), "pressures": (0, 2, 1)}, "must rise"),
        ({"thicknesses": (6e-4, np.nan, 4e-4), "pressures": (0, 1, 2)}, "finite"),
    ],
)
def test_odd_tables_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        Compaction(**given)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"exponent": 0.5}, "V_f = .* at the largest_pressure: check coefficient and exponent"),
        ({"thickness": 4e-4}, "no less than the fabric's thickness of 0.4 mm"),
        ({"fibre_density": -1.0}, "fibre_density"),
    ],
)
def test_odd_power_laws_are_refused(changed, words):
    with pytest.raises(InputError, match=words):
        Compaction.power_law(**{**POWER, **changed})


def test_a_fabric_of_another_thickness_is_refused():
    with pytest.raises(InputError, match=r"start at 0.0006 m, the fabric's thickness is 0.0007 m"):
        replace(cloth(), thickness=7e-4)


@pytest.mark.parametrize("faces", [1, 2])
def test_samples_tell_the_law_and_its_energy(faces):
    found = law()
    found_sampled = sample([found] * faces, np.inf)
    spacing, pressures = found_sampled.spacing, found_sampled.pressures
    depth = spacing * np.arange(SAMPLES)
    closed = 2.0 * depth / faces  # of the ply
    np.testing.assert_allclose(
        pressures, found.pressure(THICKNESS - closed), rtol=1e-3, atol=1e-3 * pressures[-1]
    )
    energy = float((0.5 * (pressures[1:] + pressures[:-1])).sum() * spacing)
    assert found_sampled.energies[-1] == pytest.approx(energy)
    limited = sample([found] * faces, 1e8)
    assert limited.steepest == 1e8
    assert np.diff(limited.pressures).max() <= 1e8 * spacing * (1.0 + 1e-12)


def scene(motion, *, count=1, fabric=None, duration=0.02, edge=8):
    """Plies on a plate, pressed by another that starts a little above them."""
    plies = lay_up(
        [
            Ply.rectangle(f"ply_{n}", fabric or cloth(), SIDE, cells=edge - n, mesh=mesh)
            for n, mesh in zip(range(count), ("grid", "random", "diagonal"), strict=False)
        ]
    )
    top = Tool.plate("top", width=0.1, height=0.1, facing="down", motion=motion)
    return Scene(
        name="plates",
        plies=plies,
        tools=[
            Tool.plate("bottom", width=0.1, height=0.1),
            top.moved((0, 0, count * THICKNESS + START)),
        ],
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(yarn_softening=36.0),
    )


def closing(to, count=1):
    """Down to a thickness of each ply, slow at the end."""
    way = count * (THICKNESS - to) + START
    return Stroke(travel=(0.0, 0.0, -way), duration=0.018, ramp=0.5)


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("thickness", [5.5e-4, 4.9e-4])
def test_closed_plates_feel_the_law(count, thickness):
    result = scene(closing(thickness, count), count=count).run(frames=10)
    summary = result.summary
    expected = float(law().pressure(thickness)) * SIDE**2
    forces = {tool["name"]: tool["force_n"] for tool in summary["tools"]}
    assert forces["top"] == pytest.approx(expected, rel=0.02 if count == 1 else 0.05)
    assert forces["bottom"] == pytest.approx(forces["top"], rel=0.01)
    assert summary["energy_error"] < 0.005
    if count == 1:  # a flat ply stays as it is in its plane
        assert "pressed but not stretched, sheared or bent" in summary["message"]
    assert summary["warnings"] == [] or "quasi-static" in summary["message"]


def test_a_plate_of_a_force_comes_to_rest_at_its_thickness():
    force = 5e4 * SIDE**2
    motion = Float(force=force, mass=0.02, damping=200.0, ramp=5e-3)
    result = scene(motion, duration=0.04).run(frames=4)
    closed = -result.history["top_displacement_m"][-1] - START
    shown = abs(result.history["top_displacement_m"][-1]) - START
    assert max(closed, shown) == pytest.approx(THICKNESS - float(law().thickness_at(5e4)), rel=0.02)


def test_a_fast_press_feels_little_of_the_dashpot():
    way = THICKNESS - 4.9e-4 + START
    down = Stroke(travel=(0.0, 0.0, -way), duration=0.004)
    history = scene(down, duration=0.0044).run(frames=44).history
    at = np.abs(history["top_displacement_m"])
    thickness = THICKNESS + START - 0.5 * (at[1:] + at[:-1])  # forces are means over frames
    exact, closing_fast = law().pressure(thickness) * SIDE**2, slice(16, 40)
    np.testing.assert_allclose(
        history["top_force_n"][1:][closing_fast], exact[closing_fast], rtol=0.03
    )


@pytest.mark.parametrize("step", [2.5e-6, 1e-5])
def test_added_mass_does_not_soften_the_law(step):
    slow = scene(closing(4.9e-4))
    numerics = replace(slow.numerics, minimum_time_step=step)
    summary = replace(slow, numerics=numerics).run(frames=4).summary
    expected = float(law().pressure(4.9e-4)) * SIDE**2
    assert summary["tools"][1]["force_n"] == pytest.approx(expected, rel=0.05)
    assert not any("too softly" in words for words in summary["warnings"])


def test_a_law_too_hard_for_the_step_is_said_to_be():
    slow = scene(closing(4.9e-4))
    numerics = replace(slow.numerics, minimum_time_step=1e-5, mass_scaling="selective")
    summary = replace(slow, numerics=numerics).run(frames=4).summary
    assert summary["tools"][1]["force_n"] < 0.5 * float(law().pressure(4.9e-4)) * SIDE**2
    assert any("ply 'ply_0': its compaction law rises more" in w for w in summary["warnings"])


def test_meshes_of_other_sizes_bear_the_law_too():
    soft = Compaction(thicknesses=(6e-4, 5e-4, 3e-4), pressures=(0.0, 1e4, 3e4))
    coarse = Ply.rectangle("coarse", cloth(soft), SIDE, cells=4, mesh="grid")
    fine = Ply.rectangle("fine", cloth(soft), SIDE, cells=8, mesh="grid")
    two = replace(scene(closing(4e-4, 2), count=2), plies=lay_up([coarse, fine]))
    force = two.run(frames=4).summary["tools"][1]["force_n"]
    assert force == pytest.approx(float(soft.pressure(4e-4)) * SIDE**2, rel=0.1)


def test_a_stack_pressed_within_its_law_has_not_passed():
    soft = Compaction(thicknesses=(6e-4, 4e-4, 2e-4), pressures=(0.0, 1e4, 1e5))
    summary = scene(closing(2.5e-4, 2), count=2, fabric=cloth(soft)).run(frames=4).summary
    assert summary["max_penetration_m"] > 0.3e-3
    assert not any("may have passed" in words for words in summary["warnings"])


def test_beyond_the_last_point_plates_feel_the_last_slope():
    found = Compaction(thicknesses=(6e-4, 5e-4, 4e-4), pressures=(0.0, 1e4, 4e4))
    result = scene(closing(3.7e-4), fabric=cloth(found)).run(frames=4)
    expected = float(found.pressure(3.7e-4)) * SIDE**2
    assert result.summary["tools"][1]["force_n"] == pytest.approx(expected, rel=0.02)
    np.testing.assert_allclose(found.pressure(found.thickness_at([5e4, 9e4])), [5e4, 9e4])


def test_no_more_than_the_penalty_however_hard_the_law():
    hard = Compaction(thicknesses=(6e-4, 5.999e-4, 5.998e-4), pressures=(0.0, 1e9, 3e9))
    result = scene(closing(5.99e-4), fabric=cloth(hard)).run(frames=4)
    assert result.completed and result.summary["energy_error"] < 0.01


def test_tools_that_press_a_ply_within_its_law_are_not_said_to_squeeze_it():
    within = scene(closing(4.9e-4)).run(frames=4)
    assert "squeeze" not in within.summary["message"]
    beyond = scene(closing(4.0e-4)).run(frames=4)
    thinnest = 1e3 * law().thinnest
    assert (
        f"below {thinnest:.3g} mm, the least thickness of its compaction law"
        in (beyond.summary["message"])
    )


def test_each_face_and_pair_of_faces_has_its_law():
    soft, rigid = cloth(), with_bending("carbon_interlock", "none")
    plies = lay_up(
        [
            Ply.rectangle("a", soft, SIDE, cells=2),
            Ply.rectangle("b", rigid, SIDE, cells=2),
            Ply.rectangle("c", rigid, SIDE, cells=2),
        ]
    )
    model = build_model(Scene(name="s", plies=plies, duration=1e-3), "cpu", 1)
    pads = build_pads(model.scene, model.spans, model.timing, model.mass, "cpu")
    assert pads.of_tools[0] > 0 and pads.of_tools[1:] == (0, 0)
    assert pads.of_plies[0, 0] != pads.of_plies[0, 1] == pads.of_plies[1, 0] > 0
    assert pads.of_plies[1, 2] == 0
    assert pads.areas.sum() == pytest.approx(3 * SIDE**2)


TABLE = """
[compaction]
law = "table"

[compaction.thicknesses]
value = [0.6, 0.55, 0.5]
unit = "mm"
status = "assumed"
source = "a test"

[compaction.pressures]
value = [0, 10, 60]
unit = "kPa"
status = "assumed"
source = "a test"
"""


def quantity(name, value, unit):
    head = f'[compaction.{name}]\nvalue = {value}\nunit = "{unit}"\n'
    return head + 'status = "assumed"\nsource = "a test"\n'


POWER_TEXT = '\n[compaction]\nlaw = "power"\n' + "".join(
    (
        quantity("coefficient", 0.28, "-"),
        quantity("exponent", 0.08, "-"),
        quantity("fibre_density", 1.76, "g/cm^3"),
        quantity("largest_pressure", 2, "bar"),
    )
)


def written(folder, text):
    known = resources.files("warpdrape.fabrics").joinpath("carbon_interlock.toml")
    path = folder / "mine.toml"
    path.write_text(known.read_text(encoding="utf-8") + text, encoding="utf-8")
    return path


def test_files_hold_a_law_and_the_card_shows_it(tmp_path):
    fabric = load_fabric(written(tmp_path, TABLE))
    np.testing.assert_allclose(fabric.compaction.pressures, [0.0, 1e4, 6e4])
    shown = card(fabric)
    assert "compaction.pressures" in shown
    assert re.search(r"thickness under 10 kPa +0\.55 mm", shown)
    power = load_fabric(written(tmp_path, POWER_TEXT))
    np.testing.assert_allclose(power.compaction.pressures, law().pressures)
    shown = card(power)
    assert re.search(r"compaction\.largest_pressure +2 bar", shown)
    assert re.search(r"thickness under 100 kPa +0\.\d+ mm", shown)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TABLE.replace("0.55, 0.5]", "0.65, 0.5]"), "compaction.thicknesses must fall"),
        (TABLE.replace('"kPa"', '"psi"'), "'psi' is no unit of pressure; known: Pa, kPa"),
        (TABLE.replace("[0.6,", "[0.7,"), "the fabric's thickness is 0.0006 m"),
        (TABLE.replace('"table"', '"cubic"'), "cubic"),
        (POWER_TEXT.replace("0.28", "[0.28, 0.3]"), "coefficient"),
        (POWER_TEXT.replace("0.08", "0.5"), "check coefficient and exponent"),
    ],
)
def test_faults_in_files_are_named_with_their_line(tmp_path, text, words):
    with pytest.raises(InputError, match=words) as caught:
        load_fabric(written(tmp_path, text))
    assert "mine.toml, line " in str(caught.value)


def test_the_density_of_the_fibres_may_stand_in_the_law_alone(tmp_path):
    path = written(tmp_path, POWER_TEXT)
    text = path.read_text(encoding="utf-8")
    start = text.index("[fibre_density]")
    path.write_text(text[:start] + text[text.index("[yarns_warp]") :], encoding="utf-8")
    fabric = load_fabric(path)
    assert fabric.fibre_density == pytest.approx(1760.0)
    assert fabric.sources["fibre_density"].text == "a test"
    path.write_text(text.replace("1.76\nunit", "1.9\nunit", 1), encoding="utf-8")
    with pytest.raises(InputError, match="the fabric's fibre_density is 1900: give both the same"):
        load_fabric(path)

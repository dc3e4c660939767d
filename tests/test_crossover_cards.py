"""Crossovers on fabrics' cards."""

import dataclasses

import pytest
from law_checks import fabric
from sliding_checks import HOLD, YARNS

import warpdrape as wd
from warpdrape.errors import InputError
from warpdrape.materials.fabric_card import card
from warpdrape.materials.fabric_library import load_fabric

CROSSOVER = """
[crossover]
[crossover.slip_force_warp]
value = 12
unit = "cN"
status = "assumed"
source = "made up"
[crossover.slip_force_weft]
value = 0.2
unit = "N"
status = "assumed"
source = "made up"
[crossover.stiffness_warp]
value = 20
unit = "N/mm"
status = "measured"
source = "slope of a pull-out"
[crossover.stiffness_weft]
value = 3e4
unit = "N/m"
status = "assumed"
source = "made up"
"""


def fabric_file(tmp_path, text):
    from importlib import resources

    given = resources.files("warpdrape.fabrics").joinpath("carbon_interlock.toml")
    file = tmp_path / "mine.toml"
    file.write_text(given.read_text(encoding="utf-8") + text, encoding="utf-8")
    return file


def test_a_fabric_file_gives_its_crossover(tmp_path):
    cloth = load_fabric(fabric_file(tmp_path, CROSSOVER))
    assert cloth.crossover == wd.Crossover(
        slip_force_warp=0.12, slip_force_weft=0.2, stiffness_warp=2e4, stiffness_weft=3e4
    )
    shown = card(cloth)
    assert "crossover.slip_force_warp  12 cN" in shown and "slope of a pull-out" in shown
    assert "crossover.friction" not in shown
    friction = '[crossover.friction]\nvalue = 20\nunit = "%"\nstatus = "assumed"\nsource = "s"\n'
    cloth = load_fabric(fabric_file(tmp_path, CROSSOVER + friction))
    assert cloth.crossover.friction == 0.2 and "crossover.friction" in card(cloth)
    cloth = load_fabric(fabric_file(tmp_path, CROSSOVER + friction.replace(".f", ".yarn_f")))
    assert cloth.crossover.yarn_friction == 0.2 and "crossover.yarn_friction" in card(cloth)
    assert cloth.crossover.friction == 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"N/m"', '"N"'), r"line \d+: key 'crossover.stiffness_weft.unit': 'N' is no unit of"),
        (("value = 3e4", "value = 0"), r"stiffness_weft.value'.*must be above zero"),
        (("[crossover.slip_force_weft]", "[crossover.slip_weft]"), r"'crossover.slip_weft': unk"),
        (("value = 3e4", "value = 30"), r"gives way by 6\.67 mm before the yarn slips at 0\.2 N"),
    ],
)
def test_a_fault_in_it_is_named_with_its_line(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_fabric(fabric_file(tmp_path, CROSSOVER.replace(*change)))


def test_a_crossover_is_one():
    with pytest.raises(InputError, match=r"crossover = 0\.3 is no warpdrape.Crossover"):
        dataclasses.replace(fabric(YARNS), crossover=0.3)
    with pytest.raises(InputError, match=r"friction = 20 is above 2"):
        wd.Crossover(**HOLD, friction=20.0)
    with pytest.raises(InputError, match=r"yarn_friction = 20 is above 2.*presses the yarns"):
        wd.Crossover(**HOLD, yarn_friction=20.0)

"""Values that are wrong in any way are refused in one line, and no run ends well on nonsense."""

import itertools
import math
import random
import warnings

import numpy as np
import pytest
import trimesh
from fuzz_checks import CALLS, WRONG
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from resume_checks import press

import warpdrape as wd
from warpdrape import cli
from warpdrape.errors import LONGEST, InputError
from warpdrape.materials.fabric_library import load_fabric

REAL = st.floats() | st.integers() | st.sampled_from([10**400, -(10**400), 2**63])
PLAIN = REAL | st.none() | st.booleans() | st.text(max_size=5) | st.complex_numbers()
ANYTHING = st.recursive(PLAIN, lambda inner: st.lists(inner, max_size=4), max_leaves=12)
ARGUMENTS = [(name, argument) for name, (_, right) in CALLS.items() for argument in right]
LARGE = {"die", "holder", "table", "sphere", "drum", "punch", "plate"}
"""Tools of any size are made: one of metres, in facets of millimetres, takes its time."""


def refused_or_made(name, argument, value) -> None:
    """Call with one wrong value: it is taken, or refused in one line."""
    call, right = CALLS[name]
    sized = {"facet": 0.5} if name in LARGE and argument != "facet" else {}
    try:
        call(**{**right, **sized, argument: value})
    except InputError as error:
        assert 0 < len(str(error)) <= LONGEST + 3 and "\n" not in str(error)


def few(pairs, count):
    return random.Random(5).sample(list(pairs), count)


def test_a_thousand_wrong_values():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for (name, argument), value in few(itertools.product(ARGUMENTS, WRONG), 1000):
            refused_or_made(name, argument, value)


@pytest.mark.slow
def test_every_wrong_value_everywhere():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for (name, argument), value in itertools.product(ARGUMENTS, WRONG):
            refused_or_made(name, argument, value)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@settings(max_examples=80_000, deadline=None, suppress_health_check=list(HealthCheck))
@given(where=st.sampled_from(ARGUMENTS), value=ANYTHING)
def test_anything_anywhere(where, value):
    refused_or_made(*where, value)


@pytest.mark.filterwarnings("ignore")
@settings(max_examples=60, deadline=None, derandomize=True)
@given(where=st.sampled_from(ARGUMENTS), value=ANYTHING)
def test_some_things_anywhere(where, value):
    refused_or_made(*where, value)


BOX = trimesh.creation.box((0.05, 0.05, 0.05))
FLAT = trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
MESHES = [(m, form) for m in ("tool", "ply") for form in ("stl", "stl_ascii", "obj", "ply", "off")]


def damaged(content: bytes, chance: random.Random) -> bytes:
    """A file cut off, with bytes changed, gone, moved, or new ones that look like numbers."""
    data, at, what = bytearray(content), chance.randrange(len(content)), chance.randrange(5)
    if what == 0:
        return bytes(data[:at])
    if what == 1:
        for _ in range(chance.randrange(1, 4)):
            data[chance.randrange(len(data))] = chance.randrange(256)
    elif what == 2:
        del data[at : at + chance.randrange(1, 30)]
    elif what == 3:
        new = (chance.choice(b'0123456789eE+-.,nanif[]{}"\n\0 ') for _ in range(8))
        data[at:at] = bytes(new)[: chance.randrange(1, 9)]
    else:
        other = chance.randrange(len(data))
        data[at : at + 20] = data[other : other + 20]
    return bytes(data)


def read_damaged_files(folder, count) -> int:
    """Read so many damaged meshes and fabrics; return how many were refused."""
    chance, refused = random.Random(9), 0
    cloth = load_fabric("carbon_interlock")
    card = wd.__path__[0] + "/fabrics/carbon_interlock.toml"
    with open(card, "rb") as file:
        sources = {("fabric", "toml"): file.read()}
    for kind, form in MESHES:
        content = (BOX if kind == "tool" else FLAT).export(file_type=form)
        sources[kind, form] = content.encode() if isinstance(content, str) else content
    for _ in range(count):
        kind, form = chance.choice(list(sources))
        path = folder / f"damaged.{form.removesuffix('_ascii')}"
        path.write_bytes(damaged(sources[kind, form], chance))
        try:
            if kind == "fabric":
                load_fabric(path)
            elif kind == "tool":
                wd.Tool.from_mesh("tool", path)
            else:
                wd.Ply.from_file("ply_0", cloth, path)
        except InputError as error:
            assert "\n" not in str(error)
            refused += 1
    return refused


@pytest.mark.filterwarnings("ignore")
def test_damaged_meshes_and_fabrics(tmp_path):
    assert 100 < read_damaged_files(tmp_path, 300) < 300


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_many_damaged_meshes_and_fabrics(tmp_path):
    read_damaged_files(tmp_path, 20_000)


EXTREME = {
    "friction": (0.0, 5.0, 1e6, 1e300),
    "ply_friction": (0.0, 5.0, 1e300),
    "gravity": ((0, 0, -1e4), (0, 0, 1e9), (1e300, 0, 0), (0, 0, 0)),
    "duration": (1e-5, 1e-4, 1e-3),
}
NUMERICS = {
    "damping": (0.0, 1e3, 1e9, 1e300),
    "contact_damping": (0.0, 1.0),
    "contact_share": (1e-300, 1e-6, 0.2),
    "stabiliser": (0.0, 1e3, 1e300),
    "stabiliser_floor": (0.0, 1e300),
    "yarn_viscosity": (0.0, 0.5),
    "yarn_softening": (1.0, 1e6, 1e300),
    "safety": (1e-2, 1.0),
    "kinetic_limit": (None, 1e-300, 0.99),
    "minimum_time_step": (None, 1e-5, 1.0),
}


def run_of_extremes(chance: random.Random) -> str:
    """Run a press with a few settings at their limits; how that ended."""
    picked = {k: chance.choice(v) for k, v in EXTREME.items() if chance.random() < 0.4}
    numerics = {k: chance.choice(v) for k, v in NUMERICS.items() if chance.random() < 0.3}
    picked.setdefault("duration", 1e-4)
    try:
        scene = press()
        scene = wd.Scene(
            **{
                "name": "press",
                "plies": scene.plies,
                "tools": scene.tools,
                "numerics": wd.Numerics(**numerics),
                **picked,
            }
        )
        with np.errstate(all="ignore"):
            result = scene.run(frames=2)
    except (InputError, wd.RunFailed):
        return "refused"
    if result.completed:
        assert all(np.isfinite(column).all() for column in result.history.values())
        assert all(np.isfinite(ply.points).all() for ply in result.plies)
        assert all(math.isfinite(v) for v in result.summary.values() if isinstance(v, float))
    return result.summary["status"]


@pytest.mark.filterwarnings("ignore")
def test_no_nonsense_ends_as_completed():
    chance = random.Random(3)
    ends = {run_of_extremes(chance) for _ in range(6)}
    assert ends >= {"completed", "failed"} or ends >= {"completed", "refused"}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_none_of_many_nonsenses_either():
    chance = random.Random(4)
    for _ in range(300):
        run_of_extremes(chance)


SETTINGS = ["nan", "inf", "-1", "0", "1e400", "9" * 400, "text", "", "none", "1e-320", "1e308"]


@pytest.mark.parametrize("scene", ["hemisphere", "bias_extension"])
def test_settings_of_bundled_scenes(scene, tmp_path, capsys, monkeypatch):
    """No value of any parameter brings more than a line."""
    from warpdrape.commands.scene_library import find_script

    monkeypatch.setattr("warpdrape.scene.Scene.run", lambda *_, **__: pytest.skip())
    script = find_script(scene)
    pairs = list(itertools.product(script.parameters, SETTINGS))
    for name, value in few(pairs, 25):
        try:
            script.make([f"{name}={value}"])
        except InputError as error:
            assert "\n" not in str(error) and "raised" not in str(error), (name, value)
    assert cli.main(["run", scene, "--set", "travel", "--out", str(tmp_path)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1

"""What a type checker makes of the public API: a user's scene, and the modules behind it."""

import importlib
from pathlib import Path

import pytest

import warpdrape

SCENE = Path(__file__).parent / "typed_scene.py"
APART = ("kernels", "scenes")
"""Folders of the package that are not looked at: Warp's kernels are not Python to mypy."""
FAULTS = (
    ("duration=0.06", 'duration="60 ms"'),
    ("ply.points", "ply.point"),
    ("motion=wd.Float(", "motoin=wd.Float("),
)
"""What is made wrong in the scene."""
SETTINGS = """
[mypy]
follow_imports = silent
ignore_missing_imports = True
check_untyped_defs = True
strict_equality = True
warn_redundant_casts = True
warn_unused_ignores = True
[mypy-warpdrape.dynamics.*,warpdrape.forces.*,warpdrape.contact.*,warpdrape.tools.*]
disallow_untyped_defs = True
[mypy-typed_scene,typed_fault]
disallow_untyped_defs = True
disallow_incomplete_defs = True
disallow_untyped_calls = True
disallow_any_generics = True
disallow_subclassing_any = True
warn_return_any = True
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What mypy says, by file: one run, as most of it is reading numpy's types."""
    api = pytest.importorskip("mypy.api")
    folder = tmp_path_factory.mktemp("mypy")
    (folder / "mypy.ini").write_text(SETTINGS, encoding="utf-8")
    fault = folder / "typed_fault.py"
    text = SCENE.read_text("utf-8")
    for right, wrong in FAULTS:
        assert right in text
        text = text.replace(right, wrong)
    fault.write_text(text, encoding="utf-8")
    files = [SCENE, fault, *sorted(checked_modules())]
    settings = [f"--config-file={folder / 'mypy.ini'}", f"--cache-dir={folder / 'cache'}"]
    lines, errors, _ = api.run([*settings, "--no-error-summary", *map(str, files)])
    assert errors == ""
    found = {"scene": [], "fault": [], "modules": []}
    for line in lines.splitlines():
        name = line.split(":")[0]
        kind = {SCENE.name: "scene", fault.name: "fault"}.get(Path(name).name, "modules")
        found[kind].append(line)
    return found


def checked_modules():
    """Files of all rooms and of the modules beside them, those of public names among them."""
    package = Path(warpdrape.__file__).parent
    files = {*package.glob("*.py"), *package.glob("*/*.py")}
    files = {file for file in files if file.parent.name not in APART}
    homes = {warpdrape._HOME[name] for name in warpdrape.__all__ if name in warpdrape._HOME}
    modules = [importlib.import_module(f"warpdrape.{home}") for home in {*homes, "laws", "units"}]
    assert len(modules) > 15 and {Path(module.__file__) for module in modules} <= files
    return files


def test_a_typed_scene_of_a_user_is_clean(said):
    assert said["scene"] == []


def test_faults_in_it_are_found(said):
    words = "\n".join(said["fault"])
    assert 'expected "float"' in words and '"FormedPly" has no attribute "point"' in words
    assert 'Unexpected keyword argument "motoin" for "blank_holder" of "Tool"' in words


def test_all_of_the_package_but_its_kernels_is_clean(said):
    assert said["modules"] == []


def test_the_package_says_that_it_is_typed():
    assert (Path(warpdrape.__file__).parent / "py.typed").is_file()

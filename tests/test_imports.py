import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "warpdrape"


def modules():
    """File of every module of the package by its dotted name."""
    files = (file.relative_to(PACKAGE.parent) for file in PACKAGE.rglob("*.py"))
    return {".".join(file.with_suffix("").parts): PACKAGE.parent / file for file in files}


def imported(file, known):
    """Modules that a file imports anywhere but for type checking only."""
    found, left = set(), [ast.parse(file.read_text(encoding="utf-8"))]
    while left:
        node = left.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            for name in [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]:
                found |= {name} & known
        left += ast.iter_child_nodes(node)
    return found


def graph():
    files = modules()
    return {name: imported(file, set(files)) for name, file in files.items()}


def room(name):
    """Folder of a module, or the module itself at the top of the package."""
    return ".".join(name.split(".")[:2])


def test_modules_import_each_other_in_no_circle():
    edges = graph()
    assert sum(map(len, edges.values())) > 150  # they were found
    TopologicalSorter(edges).prepare()


def test_rooms_import_each_other_in_no_circle():
    rooms = {}
    for name, needed in graph().items():
        others = {room(other) for other in needed} - {room(name)}
        rooms.setdefault(room(name), set()).update(others)
    assert "warpdrape.materials" in rooms["warpdrape.blanks"]
    TopologicalSorter(rooms).prepare()


def test_a_circle_would_be_seen(tmp_path):
    (tmp_path / "a.py").write_text("def f():\n    from pack import b\n")
    (tmp_path / "b.py").write_text("from pack.a import f\n")
    known = {"pack.a", "pack.b"}
    edges = {f"pack.{n}": imported(tmp_path / f"{n}.py", known) for n in "ab"}
    with pytest.raises(CycleError):
        TopologicalSorter(edges).prepare()


def test_the_step_loop_the_balance_and_the_summary_know_no_force_by_name():
    """They ask a tuple of them; a list of names stands in `interactions` alone."""
    edges = graph()
    forces = {name for name in edges if room(name) == "warpdrape.forces"}
    blind = [
        f"warpdrape.dynamics.{name}"
        for name in ("stepping", "integration", "partition", "crew", "energy", "moving_arrays")
    ]
    blind += ["warpdrape.interaction", "warpdrape.state", "warpdrape.recorder"]
    blind += ["warpdrape.results.summary", "warpdrape.results.history", "warpdrape.restart"]
    for name in blind:
        assert not edges[name] & forces, name
    assert len(edges["warpdrape.dynamics.interactions"] & forces) > 8

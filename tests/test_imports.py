import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "warpdrape"
KERNELS = PACKAGE.parent / "kernels"


def modules():
    """File of every module of the package by its dotted name."""
    found = {}
    for root, head in ((PACKAGE, "warpdrape"), (KERNELS, "warpdrape.kernels")):
        for file in root.rglob("*.py"):
            found[".".join((head, *file.relative_to(root).with_suffix("").parts))] = file
    return found


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


def named_by(edges, names):
    """Forces, contacts and kernels of theirs that modules import."""
    rooms = ("forces", "contact")
    inner = {f"warpdrape.{r}" for r in rooms} | {f"warpdrape.kernels.{r}" for r in rooms}
    return {
        (name, other)
        for name in names
        for other in edges[name]
        if any(other == each or other.startswith(f"{each}.") for each in inner)
    }


LISTED = "warpdrape.dynamics.interactions"
"""Where forces and contacts are listed."""


def test_steps_balance_time_step_and_summary_know_no_force_or_contact_by_name():
    """They ask a tuple of them; a list of names stands in `interactions` alone."""
    edges = graph()
    blind = [name for name in edges if room(name) == "warpdrape.dynamics" and name != LISTED]
    assert len(blind) > 15
    blind += ["warpdrape.interaction", "warpdrape.recorder"]
    blind += ["warpdrape.results.summary", "warpdrape.results.history", "warpdrape.growth"]
    assert named_by(edges, blind) == set()
    for name, other in named_by(edges, ["warpdrape.state", "warpdrape.restart"]):
        assert ".forces" not in other, name
    assert len(named_by(edges, [LISTED])) > 15


@pytest.mark.parametrize(
    "line",
    [
        "from warpdrape.contact.law import step_share",
        "from warpdrape.contact import law",
        "from warpdrape.forces import bending",
        "from warpdrape.kernels.forces.bending import Rows",
    ],
)
def test_a_force_or_contact_named_in_the_step_loop_would_be_seen(line, tmp_path):
    step = tmp_path / "stepping.py"
    step.write_text(f"def f():\n    {line}\n")
    edges = {"stepping": imported(step, set(modules()))}
    assert named_by(edges, ["stepping"])

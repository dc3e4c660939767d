"""Run folders whose files still read well, but hold values that no run would have left."""

import csv
import json
import random
from pathlib import Path

import numpy as np
from pxr import Sdf, Vt

ODD = [
    None, True, -1, 0, 3, 10**400, 2**70, 0.5, 1e300, -1e-320, "", "x", "../x", "a\nb", [], {},
    [1, 2], ["x"], [None], [[1.0]], {"a": 1}, {"name": "ply_0"}, float("nan"), float("inf"),
]  # fmt: skip
"""Values that fit few places; the last two are not JSON, and Python reads them all the same."""
ARRAYS = (Vt.Vec3fArray, Vt.FloatArray, Vt.IntArray)
"""What the animation's values are."""
CELLS = ["", "nan", "inf", "-1", "1e400", "x", "1e300", "\0", "0"]


def places(value, at=()):
    """Ways to every entry of nested lists and mappings."""
    inside = value.items() if isinstance(value, dict) else enumerate(value)
    for key, entry in inside:
        yield (*at, key)
        if isinstance(entry, dict | list):
            yield from places(entry, (*at, key))


def spoil_json(path: Path, chance: random.Random) -> str:
    """Give an entry another value, or take it away."""
    data = json.loads(path.read_text("utf-8"))
    way = chance.choice(list(places(data)))
    owner = data
    for key in way[:-1]:
        owner = owner[key]
    if chance.random() < 0.2:
        del owner[way[-1]]
        said = "gone"
    else:
        owner[way[-1]] = said = chance.choice(ODD)
    path.write_text(json.dumps(data), encoding="utf-8")
    return f"{path.name}: {way} = {str(said)[:40]!r}"


def spoil_table(path: Path, chance: random.Random) -> str:
    """Give a cell another text, or take a row or a column away."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    row, column = chance.randrange(len(rows)), chance.randrange(len(rows[0]))
    what = chance.random()
    if what < 0.1:
        del rows[row]
    elif what < 0.2:
        rows = [cells[:column] + cells[column + 1 :] for cells in rows]
    else:
        rows[row][column] = chance.choice(CELLS)
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
    return f"{path.name}: row {row}, column {column}, {what:.2f}"


def spoil_scene(path: Path, chance: random.Random) -> str:
    """Give an attribute of plies or tools odd values, fewer or none, or take it away."""
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    found = []
    layer.Traverse(Sdf.Path.absoluteRootPath, found.append)
    attributes = [at for at in found if isinstance(layer.GetObjectAtPath(at), Sdf.AttributeSpec)]
    at = chance.choice(attributes)
    spec = layer.GetObjectAtPath(at)
    times = layer.ListTimeSamplesForPath(at)
    time = chance.choice(times) if times and chance.random() < 0.8 else None
    value = spec.default if time is None else layer.QueryTimeSample(at, time)
    what = chance.choice(["gone", "less", "none", "odd", "prim"])
    if what == "prim":
        owner = layer.GetPrimAtPath(at.GetPrimPath())
        del owner.nameParent.nameChildren[owner.name]
    elif what == "gone" or not isinstance(value, ARRAYS):
        owner = layer.GetPrimAtPath(at.GetPrimPath())
        owner.RemoveProperty(spec)
    else:
        array = np.array(value)
        kind = type(value)
        array = array[: 0 if what == "none" else len(array) // 2] if what != "odd" else array
        if what == "odd" and array.size:
            odd = [999_999, -5] if array.dtype.kind == "i" else [np.nan, np.inf, 1e38, 0.0]
            array.reshape(-1)[chance.randrange(array.size)] = chance.choice(odd)
        value = kind.FromNumpy(array) if len(array) else kind()
        if time is None:
            spec.default = value
        else:
            layer.SetTimeSample(at, time, value)
    layer.Export(str(path))
    return f"{path.name}: {at} at {time} {what}"


SPOIL = {
    "summary.json": spoil_json,
    "run.json": spoil_json,
    "history.csv": spoil_table,
    "scene.usdc": spoil_scene,
}


def spoil(folder: Path, chance: random.Random) -> str:
    """Spoil a value of a run folder's file; say which."""
    name = chance.choice(list(SPOIL))
    return SPOIL[name](folder / name, chance)

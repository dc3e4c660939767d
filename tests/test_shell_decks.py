"""Decks for LS-DYNA and Nastran, read back by other hands than wrote them."""

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.exports.export import export
from warpdrape.exports.layup import DENSITY, LAYERS, MATERIAL, angles_deg

SINGLE = {"rtol": 1e-6, "atol": 1e-9}
COUNT = 144


def turned(nodes, corners, degrees):
    """Directions at an angle from side 1-2 about the normal, by Rodrigues' formula."""
    a, b, c = (nodes[corners[:, k]] for k in range(3))
    side = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    angle = np.radians(degrees)[:, None]
    return np.cos(angle) * side + np.sin(angle) * np.cross(normal, side)


def check(plies, nodes, corners, thick, angles):
    """Hold nodes, corners (from 0), layers' thicknesses and angles against the run's plies."""
    np.testing.assert_allclose(nodes, np.concatenate([ply.points for ply in plies]), **SINGLE)
    first = 0
    for k, ply in enumerate(plies):
        rows = slice(COUNT * k, COUNT * (k + 1))
        np.testing.assert_array_equal(corners[rows], ply.triangles + first)
        for layer, (family, share) in enumerate(LAYERS):
            np.testing.assert_allclose(thick[rows, layer], share * ply.thickness, rtol=1e-4)
            along = turned(nodes, corners[rows], angles[rows, layer])
            wanted = ply.warp if family == "WARP" else ply.weft
            np.testing.assert_allclose(along, wanted, atol=3e-6)  # 0.0001 degrees
        first += len(ply.points)


@pytest.mark.parametrize("reader", ["dynakw", "columns"])
def test_keyword_file_has_every_elements_layers(reader, pressed, tmp_path):
    out = export(pressed[1], "dyna", tmp_path / "d.k")
    read = by_dynakw if reader == "dynakw" else by_columns
    nodes, corners, thick, angles, parts = read(out)
    check(wd.read_run(pressed[1]).plies, nodes, corners - 1, thick, angles)
    np.testing.assert_array_equal(parts, np.repeat([1, 2, 3], COUNT))


def by_dynakw(path):
    dynakw = pytest.importorskip("dynakw")
    nodes, corners, thick, angles, parts = [], [], [], [], []
    with dynakw.DynaKeywordReader(str(path)) as file:
        for keyword in file.keywords():
            cards = keyword.cards
            if keyword.full_keyword == "*NODE":
                nodes.append(np.stack([cards["Card 1"][axis] for axis in "XYZ"], axis=1))
            if keyword.full_keyword == "*ELEMENT_SHELL_COMPOSITE":
                corner = cards["Card 1"]
                assert (corner["N4"] == corner["N3"]).all()
                corners.append(np.stack([corner[f"N{k}"] for k in (1, 2, 3)], axis=1))
                parts.append(corner["PID"])
                assert (cards["Card 6"]["MID"] == 1).all()
                thick.append(cards["Card 6"]["THICK"])
                angles.append(cards["Card 6"]["B"])
    return tuple(map(np.concatenate, (nodes, corners, thick, angles, parts)))


def by_columns(path):
    """The manual's fixed columns: 8 + 3 × 16 for nodes, 8s for elements, 10s for layers."""
    nodes, rows, layers, keyword = [], [], [], ""
    for line in path.read_text("ascii").splitlines():
        if line.startswith(("*", "$")):
            keyword = line if line.startswith("*") else keyword
            fresh = True
        elif keyword == "*NODE":
            nodes.append([float(line[8 + 16 * k : 24 + 16 * k]) for k in range(3)])
        elif keyword == "*ELEMENT_SHELL_COMPOSITE":
            if fresh or len(layers[-1]) == len(LAYERS):
                rows.append([int(line[8 * k : 8 * k + 8]) for k in range(6)])
                layers.append([])
                fresh = False
                continue
            for start in range(0, len(line), 40):
                layers[-1].append(
                    (float(line[start + 10 : start + 20]), float(line[start + 20 : start + 30]))
                )
    rows, layers = np.array(rows), np.array(layers)
    np.testing.assert_array_equal(rows[:, 0], 1 + np.arange(len(rows)))
    return np.array(nodes), rows[:, 2:5], layers[..., 0], layers[..., 1], rows[:, 1]


def test_the_example_material_of_the_keyword_file_is_the_same_stiffness(pressed, tmp_path):
    lines = export(pressed[1], "dyna", tmp_path / "d.k").read_text("ascii").splitlines()
    at = lines.index("*MAT_ORTHOTROPIC_ELASTIC")
    one, two = (
        [float(row[k : k + 10]) for k in range(0, len(row), 10)] for row in lines[at + 1 : at + 3]
    )
    e1, e2, e3, nu12, nu13, nu23, g12, g13, g23 = MATERIAL
    assert one[1:5] == [DENSITY, e1, e2, e3]
    # both Poisson's ratios of a pair give one compliance: ν_ba / E_b = ν_ab / E_a
    assert [one[5] / e2, one[6] / e3, one[7] / e3] == pytest.approx(
        [nu12 / e1, nu13 / e1, nu23 / e2]
    )
    assert two == [g12, g23, g13, 0.0]


def cards(path):
    """Large-field cards of a bulk data file: name and fields of 16 characters."""
    found, bulk = [], False
    for line in path.read_text("ascii").splitlines():
        bulk |= line == "BEGIN BULK"
        if not bulk or line.startswith(("$", "BEGIN", "ENDDATA", "SPC1")):
            continue
        fields = [line[8 + 16 * k : 24 + 16 * k].strip() for k in range(4)]
        if line.startswith("*"):
            found[-1][1].extend(fields)
        else:
            assert line[:8].rstrip().endswith("*")
            found.append((line[:8].rstrip(" *"), fields))
    return found


def test_bulk_data_file_has_every_elements_layers(pressed, tmp_path):
    out = export(pressed[1], "nastran", tmp_path / "d.bdf")
    of = {}
    for name, fields in cards(out):
        of.setdefault(name, []).append(fields)
    nodes = np.array([[float(x) for x in row[2:5]] for row in of["GRID"]])
    shells = np.array([[int(x) for x in row[:5]] for row in of["CTRIA3"]])
    np.testing.assert_array_equal(shells[:, 0], shells[:, 1])
    lays = [row[8:] for row in of["PCOMP"]]
    assert [int(row[0]) for row in of["PCOMP"]] == shells[:, 1].tolist()
    assert all(row[1:8] == [""] * 7 for row in of["PCOMP"])
    thick = np.array([[float(x) for x in row[1::4]] for row in lays])
    theta = np.array([float(row[5]) for row in of["CTRIA3"]])
    angles = theta[:, None] + np.array([[float(x) for x in row[2::4]] for row in lays])
    check(wd.read_run(pressed[1]).plies, nodes, shells[:, 2:5] - 1, thick, angles)
    assert max(len(line) for line in out.read_text("ascii").splitlines()) <= 80


def test_bulk_data_file_is_read_by_another_library(pressed, tmp_path):
    """pyNastran 1.4.1 wants numpy 1: it is not among the tools that tests install."""
    bdf = pytest.importorskip("pyNastran.bdf.bdf")
    model = bdf.read_bdf(str(export(pressed[1], "nastran", tmp_path / "d.bdf")), debug=None)
    plies = wd.read_run(pressed[1]).plies
    warp = np.array(
        [model.elements[k + 1].material_coordinate_system()[2] for k in range(3 * COUNT)]
    )
    np.testing.assert_allclose(warp, np.concatenate([ply.warp for ply in plies]), atol=1e-6)


def test_angles_are_between_both_ends_of_a_turn(pressed):
    for ply in pressed[0].plies:
        for angles in angles_deg(ply).values():
            assert (np.abs(angles) <= 180.0).all() and np.ptp(angles) > 90.0

"""Decks for CalculiX and Abaqus, read by other libraries and solved against laminate theory."""

import io
import re
import shutil
import subprocess

import numpy as np
import pytest
import trimesh
from flat_plies import flat_ply

import warpdrape as wd
from warpdrape.exports.export import export
from warpdrape.exports.inp import LAYERS, MATERIAL, shell_of, write_model

SINGLE = {"rtol": 1e-6, "atol": 1e-12}


def keywords(deck):
    """Lines below each keyword line of a deck."""
    found, lines = [], None
    for line in deck.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            lines = []
            found.append((line, lines))
        else:
            lines.append([entry.strip() for entry in line.split(",")])
    return found


def test_deck_has_the_plies_with_their_own_yarns(pressed, tmp_path):
    deck = export(pressed[1], "inp", tmp_path / "d.inp").read_text("ascii")
    found = keywords(deck)
    elements = [
        [[int(number) for number in row] for row in rows]
        for line, rows in found
        if line.startswith("*ELEMENT,")
    ]
    nodes = {
        int(row[0]): np.array(row[1:], float)
        for line, rows in found
        if line == "*NODE"
        for row in rows
    }
    given = {line.partition("NAME=")[2].split(",")[0]: rows for line, rows in found}
    sections = {
        line.split("ELSET=E_")[1].split(",")[0]: rows for line, rows in found if "SECTION" in line
    }
    plies = wd.read_run(pressed[1]).plies
    assert [line.split("ELSET=")[1] for line, _ in found if line.startswith("*ELEMENT,")] == [
        "PLY_0", "PLY_1", "PLY_2",
    ]  # fmt: skip
    for ply, rows in zip(plies, elements, strict=True):
        volume = 0.0
        for k, (number, *corners) in enumerate(rows):
            places = np.array([nodes[corner] for corner in corners])
            np.testing.assert_allclose(places[:3], ply.points[ply.triangles[k]], **SINGLE)
            middles = 0.5 * (places[:3] + places[[1, 2, 0]])
            np.testing.assert_allclose(places[3:], middles, rtol=1e-6, atol=1e-9)
            for family, along in (("WARP", ply.warp[k]), ("WEFT", ply.weft[k])):
                (axes,) = given[f"{family}_{number}"]
                np.testing.assert_allclose(np.array(axes[:3], float), along, **SINGLE)
            layers = sections[str(number)]
            assert [layer[3] for layer in layers] == [f"{f}_{number}" for f, _ in LAYERS]
            normal = np.cross(places[1] - places[0], places[2] - places[0])
            volume += 0.5 * np.linalg.norm(normal) * sum(float(layer[0]) for layer in layers)
        area = trimesh.Trimesh(ply.points, ply.triangles, process=False).area_faces
        assert volume == pytest.approx(ply.thickness @ area, rel=1e-6)
    assert len(nodes) == sum(len(shell_of(ply, 6e-4).nodes) for ply in plies)


def test_deck_is_read_by_another_library(pressed, tmp_path):
    meshio = pytest.importorskip("meshio")
    deck = export(pressed[1], "inp", tmp_path / "d.inp").read_text("ascii")
    (tmp_path / "e.inp").write_text(deck.replace("TYPE=S6", "TYPE=STRI65"))
    mesh = meshio.read(tmp_path / "e.inp")
    assert [(block.type, len(block.data)) for block in mesh.cells] == 3 * [("triangle6", 144)]
    np.testing.assert_allclose(mesh.points[:85], wd.read_run(pressed[1]).plies[0].points, **SINGLE)


def solve(deck, folder):
    """Reactions [N] by node that CalculiX finds."""
    (folder / "job.inp").write_text(deck, encoding="ascii")
    done = subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, text=True, check=False)
    assert "ERROR" not in done.stdout, done.stdout
    rows = [line.split() for line in (folder / "job.dat").read_text().splitlines()]
    return {int(row[0]): np.array(row[1:], float) for row in rows if len(row) == 4}


def stiffness_in_plane(angle):
    """Plane-stress stiffness [Pa] of a layer with its fibres at an angle [rad] to x."""
    e1, e2, _, nu12, _, _, g12, _, _ = MATERIAL
    nu21 = nu12 * e2 / e1
    own = np.array([[e1, nu12 * e2, 0.0], [nu12 * e2, e2, 0.0], [0.0, 0.0, g12]])
    own[:2] /= 1.0 - nu12 * nu21
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, 1]])
    turn[2, 2] = c * c - s * s
    return turn.T @ own @ turn


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
@pytest.mark.parametrize("angles", [(0.0, 90.0), (20.0, 80.0), (45.0, -15.0)])
def test_calculix_sees_both_yarn_families_where_they_lie(angles, tmp_path):
    """Line forces of a strained sheet against laminate theory, yarns at any angle.

    The sheet's border is moved as a uniform strain says; the mean line force is Σ F ⊗ x over the
    area. Nodes are held in z, which the middle layer's Poisson contraction hardly feels: 5·10⁻⁴ of
    the largest.
    """
    thickness, area = 6e-4, 0.1 * 0.08
    flat = wd.Ply.rectangle("p", "carbon_interlock", 0.1, 0.08, cells=3, mesh="random")
    shell = shell_of(flat_ply(flat.rest_points, flat.mesh.triangles, *angles), thickness)
    strain = np.array([1e-3, -4e-4, 6e-4])
    gradient = np.array([[strain[0], 0.5 * strain[2]], [0.5 * strain[2], strain[1]]])
    file = io.StringIO()
    write_model(file, [shell])
    file.write("*BOUNDARY\nN_P, 3, 3\n")
    for node in shell.edge:
        for axis, moved in enumerate(gradient @ shell.nodes[node, :2], 1):
            file.write(f"{node + 1}, {axis}, {axis}, {moved:.9g}\n")
    file.write("*STEP\n*STATIC\n*NODE PRINT, NSET=EDGE_P\nRF\n*END STEP\n")
    reactions = solve("*HEADING\nsheet\n" + file.getvalue(), tmp_path)
    forces = sum(np.outer(f[:2], shell.nodes[n - 1, :2]) for n, f in reactions.items()) / area
    turned = dict(zip(("WARP", "WEFT"), np.radians(angles), strict=True))
    exact = thickness * sum(share * stiffness_in_plane(turned[f]) for f, share in LAYERS) @ strain
    found = np.array([forces[0, 0], forces[1, 1], forces[0, 1]])
    np.testing.assert_allclose(found, exact, atol=5e-4 * np.abs(exact).max())
    assert np.abs(exact).min() > 0.02 * np.abs(exact).max()


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_the_example_in_the_deck_runs_and_the_plies_have_their_volume(pressed, tmp_path):
    """Volumes are areas times the run's thickness, less what lies in the folds between triangles.

    CalculiX thickens a shell along mean normals: where two triangles meet at an angle of 2α their
    solid is cos α as thick there.
    """
    deck = export(pressed[1], "inp", tmp_path / "d.inp").read_text("ascii")
    wanted = "*EL PRINT, ELSET=PLY_{}, TOTALS=ONLY\nEVOL\n"
    wanted = "".join(wanted.format(k) for k in range(3)) + "*NODE PRINT, NSET=N_PLY_1\nU\n"
    moved = solve(deck.replace("*END STEP", wanted + "*END STEP"), tmp_path)
    said = (tmp_path / "job.dat").read_text()
    volumes = [float(x) for x in re.findall(r"total volume[^\n]*\n\s*([\d.E+-]+)\s*\n", said)]
    expected = [
        ply.thickness @ trimesh.Trimesh(ply.points, ply.triangles, process=False).area_faces
        for ply in wd.read_run(pressed[1]).plies
    ]
    np.testing.assert_allclose(volumes, expected, rtol=5e-3)
    assert (np.array(volumes) < expected).all()
    sag = -min(way[2] for way in moved.values())
    assert 1e-8 < sag < 1e-3

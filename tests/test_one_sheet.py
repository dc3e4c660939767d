"""Meshes that are not one sheet: torn along an edge or a seam, lying on themselves; and slivers."""

import numpy as np
import pytest

from warpdrape import InputError, Numerics, Ply, Scene
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.dynamics.start_check import check_sheets

SHEET = Ply.rectangle("sheet", "carbon_interlock", 0.1, cells=4, mesh="grid").mesh
POINTS, TRIANGLES = np.array(SHEET.vertices), np.array(SHEET.triangles)
MIDDLES = POINTS[TRIANGLES].mean(axis=1)
LEFT = MIDDLES[:, 0] < 0.0


def sheet(points, rows):
    """A mesh that a run would take."""
    mesh = FlatMesh(points, rows)
    ply = Ply(name="mine", fabric="carbon_interlock", mesh=mesh)
    check_sheets(Scene(name="mine", plies=[ply], duration=1e-3))
    return mesh


def halves(shift=(0.0, 0.0)):
    """The sheet as two, the right half moved; their common border has its vertices twice."""
    right = POINTS + np.asarray(shift)
    rows = np.concatenate([TRIANGLES[LEFT], TRIANGLES[~LEFT] + len(POINTS)])
    used, rows = np.unique(rows, return_inverse=True)
    return np.concatenate([POINTS, right])[used], rows.reshape(-1, 3)


def test_a_hanging_vertex_is_refused_with_its_place_and_the_advice_cures_it():
    edges = SHEET.edges
    inner = np.flatnonzero(edges.triangles[:, 1] >= 0)[10]
    (a, b), (one, other) = edges.vertices[inner], edges.triangles[inner]
    middle = 0.5 * (POINTS[a] + POINTS[b])
    points = np.vstack([POINTS, middle])

    def divided(triangle):
        rows = []
        for end in (a, b):
            row = TRIANGLES[triangle].copy()
            row[row == end] = len(POINTS)
            rows.append(row)
        return rows

    rest = np.delete(TRIANGLES, [one, other], axis=0)
    where = rf"vertex {len(POINTS)} at .* lies on edge ({a}-{b}|{b}-{a}).*T-junction; 1 such"
    with pytest.raises(InputError, match=where):
        sheet(points, np.vstack([rest, divided(one), TRIANGLES[other]]))
    cured = sheet(points, np.vstack([rest, divided(one), divided(other)]))
    assert cured.areas.sum() == pytest.approx(SHEET.areas.sum())


def test_a_seam_that_only_looks_joined_is_refused_and_an_open_cut_is_not():
    for gap in (0.0, 1e-6):
        with pytest.raises(InputError, match=r"vertices \d+ and \d+ lie .* are not joined \(10 s"):
            sheet(*halves((gap, 0.0)))
    assert len(sheet(*halves((1e-4, 0.0))).areas) == len(TRIANGLES)
    with pytest.raises(InputError, match=r"lies on edge .* T-junction"):
        sheet(*halves((0.0, 0.0051)))


@pytest.mark.parametrize("shift", [(-0.03, 0.001), (-0.003, 0.002), (-0.05, 0.0)])
def test_a_sheet_on_itself_is_refused(shift):
    with pytest.raises(InputError, match=r"'mine': the mesh lies on itself at .* one sheet"):
        sheet(*halves(shift))


def test_separate_sheets_and_holes_are_none_of_these():
    points, rows = halves((0.02, 0.0))
    assert len(sheet(points, rows).areas) == len(rows)
    ring = np.linalg.norm(MIDDLES, axis=1) > 0.02
    assert len(sheet(*without_strays(TRIANGLES[ring])).areas) == ring.sum()


def without_strays(rows):
    used, rows = np.unique(rows, return_inverse=True)
    return POINTS[used], rows.reshape(-1, 3)


def test_a_sliver_is_named_with_what_it_costs_and_the_advice_cures_it():
    inner = np.flatnonzero(np.abs(POINTS).max(axis=1) < 0.02)[0]
    row = TRIANGLES[np.flatnonzero((TRIANGLES == inner).any(axis=1))[0]]
    a, b = row[row != inner]
    points = POINTS.copy()
    points[inner] = 0.5 * (POINTS[a] + POINTS[b]) + 1e-3 * (POINTS[inner] - POINTS[a])
    ply = Ply(name="cut", fabric="carbon_interlock", mesh=FlatMesh(points, TRIANGLES))

    def run(**numerics):
        scene = Scene(name="sliver", plies=[ply], duration=1e-4, numerics=Numerics(**numerics))
        return scene.run(frames=1, quiet=True)

    with pytest.raises(
        InputError, match=r"'cut': triangle \d+ at .* times shorter than half"
    ) as it:
        run()
    assert f"triangle {np.argmin(ply.mesh.heights)} at" in str(it.value)
    advised = float(str(it.value).rpartition("minimum_time_step = ")[2].removesuffix(" s"))
    assert run(minimum_time_step=advised).completed

"""Tools as files come: facets of mixed sense, inside out, twice; and in another unit."""

import warnings

import numpy as np
import pytest
import trimesh

from warpdrape import Float, InputError, Ply, Scene, Still, Stroke, Tool
from warpdrape.tools.mould_face import borders
from warpdrape.tools.orientation import oriented, without_doubles

PUNCH = Tool.punch(radius=0.03, facet=5e-3)
SHEET = Ply.rectangle("sheet", "carbon_interlock", 0.1, cells=4, mesh="grid")
OUTSIDE = (0.0, 0.0, 0.001)


def mesh_of(tool):
    return np.array(tool.vertices), np.array(tool.triangles)


def some_turned(facets, share=0.3):
    turned = np.random.default_rng(0).random(len(facets)) < share
    return np.where(turned[:, None], facets[:, ::-1], facets), turned


def run(tool, **changes):
    motion = Stroke(travel=(0, 0, -0.001), duration=1e-3)
    changes = {"plies": [SHEET], "duration": 1e-3, "gravity": (0, 0, 0)} | changes
    tool = Tool(name="punch", surface=tool.surface, motion=motion)
    return Scene(name="file", tools=[tool.moved(OUTSIDE)], **changes).run(frames=1, quiet=True)


def test_facets_of_mixed_sense_are_turned_like_the_most():
    points, facets = mesh_of(PUNCH)
    mixed, turned = some_turned(facets)
    with pytest.warns(UserWarning, match=rf"{turned.sum()} of {len(facets)} facets faced the oth"):
        tool = Tool.from_mesh("punch", trimesh.Trimesh(points, mixed, process=False))
    plain = Tool.from_mesh("punch", trimesh.Trimesh(points, facets, process=False))
    np.testing.assert_array_equal(np.sort(tool.triangles), np.sort(plain.triangles))
    np.testing.assert_allclose(tool.surface.mesh.face_normals, plain.surface.mesh.face_normals)


@pytest.mark.parametrize("share", [0.0, 0.4, 0.9, 1.0])
def test_closed_solids_are_turned_outward(share):
    ball, box = trimesh.creation.icosphere(2, 0.02), trimesh.creation.box((0.01, 0.02, 0.03))
    box.apply_translation((0.1, 0.0, 0.0))
    both = trimesh.util.concatenate([ball, box])
    mixed, turned = some_turned(np.asarray(both.faces), share)
    found, back = oriented(np.asarray(both.vertices), mixed)
    np.testing.assert_array_equal(back, turned)
    np.testing.assert_array_equal(found, both.faces)


def test_a_surface_with_each_facet_twice_is_made_one():
    points, facets = mesh_of(PUNCH)
    double = np.concatenate([facets, facets[:, ::-1]])
    np.testing.assert_array_equal(without_doubles(double), facets)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tool = Tool.from_mesh("punch", trimesh.Trimesh(points, double, process=False))
    assert len(tool.triangles) == len(facets)


def strip(twist):
    """A closed strip of 40 squares that turns over so many times by 180° on its way round."""
    turn, width = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False), 4e-3 * np.array([-1.0, 1.0])
    about, across = np.meshgrid(0.5 * twist * turn, width, indexing="ij")
    radius, angle = 0.015 + across * np.cos(about), np.repeat(turn[:, None], 2, axis=1)
    places = radius * np.cos(angle), radius * np.sin(angle), across * np.sin(about)
    here = np.arange(80).reshape(40, 2)
    beyond = np.roll(here, -1, axis=0)
    if twist % 2:
        beyond[-1] = beyond[-1, ::-1]
    (a, b), (c, d) = here.T, beyond.T
    facets = np.vstack([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    return trimesh.Trimesh(np.stack(places, axis=2).reshape(-1, 3), facets, process=False)


def test_a_surface_with_one_side_only_is_refused():
    for twist in (0, 2):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert len(Tool.from_mesh("ring", strip(twist)).triangles) == 80
    with pytest.raises(InputError, match=r"tool 'ring': its facets cannot all face one way: .*mm"):
        Tool.from_mesh("ring", strip(1))


def test_a_fin_that_stands_on_the_edge_of_a_solid_is_a_tool_all_the_same():
    """Three facets share the edge: they have no common way round, and need none."""
    box = trimesh.creation.box(extents=(0.04, 0.04, 0.04))
    low = np.flatnonzero((box.vertices[:, 1] < 0.0) & (box.vertices[:, 2] < 0.0))
    tips = box.vertices[low] - (0.0, 0.0, 0.01)
    fin = [[low[0], low[1], 8], [low[1], 9, 8]]
    mesh = trimesh.Trimesh(
        np.vstack([box.vertices, tips]), np.vstack([box.faces, fin]), process=False
    )
    assert len(Tool.from_mesh("fin", mesh).triangles) == 14


def test_borders_close_whatever_the_facets():
    """Also where three facets meet at an edge; plain holes are gone round once."""
    ball = trimesh.creation.icosphere(2, 0.02)
    facets, rng = np.asarray(ball.faces), np.random.default_rng(0)
    fins = np.column_stack([facets[:40, :2], np.arange(40) + len(ball.vertices)])
    for share in (0.02, 0.5):
        kept = facets[rng.random(len(facets)) > share]
        for these in (kept, np.vstack([kept, fins]), some_turned(kept)[0]):
            ends = np.concatenate([np.stack([k, np.roll(k, -1)], axis=1) for k in borders(these)])
            of_facets = these[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
            count = np.zeros((242, 242), dtype=int)
            for sign, edges in ((1, of_facets), (-1, ends)):
                np.add.at(count, tuple(edges.T), sign)
            np.testing.assert_array_equal(count, count.T)  # what is left runs both ways


def test_an_open_surface_inside_out_is_refused_and_flipping_it_cures_it():
    points, facets = mesh_of(PUNCH)
    inverted = Tool.from_mesh("punch", trimesh.Trimesh(points, facets[:, ::-1], process=False))
    with pytest.raises(InputError, match=r"face away from ply 'sheet': take tool.flipped()"):
        run(inverted)
    assert run(inverted.flipped()).completed
    again = inverted.flipped().flipped()
    np.testing.assert_array_equal(again.surface.normals, inverted.surface.normals)
    np.testing.assert_array_equal(again.triangles, inverted.triangles)


@pytest.mark.parametrize(("scale", "across"), [(1e3, "60 m"), (1e-4, "6e-06 m")])
def test_a_tool_in_another_unit_is_refused(scale, across):
    points, facets = mesh_of(PUNCH)
    mesh = trimesh.Trimesh(points * scale, facets, process=False)
    with pytest.raises(InputError, match=f"'punch' is {across} across.*scale=1e-3 for milli"):
        run(Tool.from_mesh("punch", mesh))
    assert run(Tool.from_mesh("punch", mesh, scale=1.0 / scale)).completed


def test_a_still_holder_presses_as_a_floating_one_does():
    def force(motion):
        holder = Tool.plate("holder", width=0.2, height=0.2, facing="down", motion=motion)
        lower = Tool.plate("table", width=0.2, height=0.2)
        half = 0.5 * SHEET.fabric.thickness
        gap = half - 2e-6  # pressed by contact's own softness
        tools = [holder.moved((0, 0, gap)), lower.moved((0, 0, -half))]
        scene = Scene(name="held", plies=[SHEET], tools=tools, duration=0.02)
        history = scene.run(frames=4, quiet=True).history
        return history["holder_force_n"][-1], history["table_force_n"][-1]

    floating, table = force(Float(force=50.0))
    assert floating == pytest.approx(50.0, rel=0.05) and table > 45.0
    still, table = force(Still())
    assert still > 0.1 and table > 0.1


def test_tools_and_plies_that_met_nothing_are_named():
    half = 0.5 * SHEET.fabric.thickness
    table = Tool.plate("table", width=0.2, height=0.2).moved((0.0, 0.0, -half))
    away = Stroke(travel=(0, 0, -0.01), duration=0.01)
    punch = Tool.punch(radius=0.03, motion=away).moved((0.5, 0.0, 0.02))
    astray = Ply.rectangle("astray", "carbon_interlock", 0.05, cells=2, mesh="grid", z=-0.1)
    scene = Scene(name="met", plies=[astray, SHEET], tools=[table, punch], duration=0.01)
    result = scene.run(frames=2, quiet=True)
    named = [text for text in result.summary["warnings"] if "touched" in text]
    assert len(named) == 2
    assert named[0].startswith("tool 'punch' never touched a ply: look at where it stands")
    assert named[1].startswith("ply 'astray' was neither held nor touched")
    assert not any("lengthen the duration" in text for text in result.summary["warnings"])

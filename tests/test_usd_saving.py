"""The animation on the disk: saved as it goes, after kills, failures and full disks."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pxr import Sdf, Tf, Usd, UsdGeom
from synthetic_run import blank, frames_at, shapes, writer_in
from test_engine import small_press

from warpdrape.errors import InputError, RunFailed
from warpdrape.results import usd
from warpdrape.results.fields import FIELDS
from warpdrape.results.usd import PlyFrame, PlyShape, UsdWriter
from warpdrape.results.usd_layer import check_space


def test_a_frame_takes_no_more_than_its_numbers(tmp_path):
    """Nor does the layer keep copies of what stays."""
    sizes = []
    for frames in (2, 22):
        with UsdWriter(tmp_path / f"{frames}.usdc", *shapes()) as writer:
            for k in range(frames):
                writer.write(k, 0.01 * k, frames_at((k + 1) / 23), [[0, 0, 0]])
        sizes.append((tmp_path / f"{frames}.usdc").stat().st_size)
    vertices, triangles = (len(a) for a in (shapes()[0][0].rest_points, shapes()[0][0].triangles))
    # positions, normals; directions, colours and 5 scalars; a tenth for the layer's own tables
    numbers = 3 * (24 * vertices + 56 * triangles)
    assert (sizes[1] - sizes[0]) / 20 < 1.1 * numbers


def test_a_frame_of_every_quantity_takes_no_more_than_its_numbers(tmp_path):
    """As in a stack of plies that bend: some 90 bytes a triangle and frame."""
    rng, rest, triangles = np.random.default_rng(0), *blank(20)
    at = {name: [f for f in FIELDS if f.at_vertices == name] for name in (True, False)}
    dry = [f.name for f in at[True] if "slide" not in f.name and f.name != "temperature"]
    plies = [PlyShape("ply", rest, triangles, dry, [f.name for f in at[False][7:]])]

    def values(field):
        if field.vector:
            return rng.standard_normal(field.shape(len(rest), len(triangles)))
        return rng.random(field.shape(len(rest), len(triangles)))

    sizes = []
    for frames in (2, 22):
        with UsdWriter(tmp_path / f"{frames}.usdc", plies) as writer:
            for k in range(frames):
                some = {f.name: values(f) for f in FIELDS if f in at[False] or f.name in dry}
                writer.write(k, 0.01 * k, [PlyFrame(rng.random(rest.shape), **some)])
        sizes.append((tmp_path / f"{frames}.usdc").stat().st_size)
    numbers = sum(np.size(each) for each in some.values()) + 6 * len(rest) + 3 * len(triangles)
    frame = (sizes[1] - sizes[0]) / 20
    assert 0.95 * 4 * numbers < frame < 1.05 * 4 * numbers
    assert 88 < frame / len(triangles) < 105  # more vertices a triangle than in a large mesh


def test_killed_run_leaves_its_frames(tmp_path):
    code = (
        "import os, sys; sys.path.insert(0, 'tests')\n"
        "from test_usd_saving import *\n"
        "from warpdrape.results import usd; usd.SAVE_EVERY = 0.0\n"
        "writer = writer_in(Path(sys.argv[1]))\n"
        "for k in range(3): writer.write(k, 0.01 * k, frames_at(k / 3), [[0, 0, -k]])\n"
        "os._exit(9)"
    )
    root = Path(__file__).parent.parent
    path = os.pathsep.join([str(root), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], cwd=root, env=os.environ | {"PYTHONPATH": path}
    )
    assert done.returncode == 9
    assert [f.name for f in tmp_path.iterdir()] == [".scene.partial.usdc"]
    stage = Usd.Stage.Open(str(tmp_path / ".scene.partial.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_2")).GetPointsAttr()
    assert points.GetTimeSamples() == [0.0, 1.0, 2.0]
    np.testing.assert_allclose(np.array(points.Get(2)), frames_at(2 / 3)[2].points, atol=1e-7)
    assert stage.GetEndTimeCode() == 2.0


def test_frames_that_come_fast_are_saved_together(tmp_path, monkeypatch):
    now, save, saved = [100.0], Sdf.Layer.Save, []
    monkeypatch.setattr(usd.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(Sdf.Layer, "Save", lambda layer: saved.append(now[0]) or save(layer))
    with writer_in(tmp_path) as writer:
        for k in range(8):
            now[0] += 0.4 * usd.SAVE_EVERY
            writer.write(k, 0.01 * k, frames_at(k / 8), [[0, 0, 0]])
    # Opened, the third and the sixth frame, and the last two when it is closed.
    assert (np.round((np.array(saved) - 100.0) / usd.SAVE_EVERY, 1) == [0.0, 1.2, 2.4, 3.2]).all()
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_1")).GetPointsAttr()
    assert points.GetTimeSamples() == list(range(8))


def test_saving_as_it_goes_takes_little_room(tmp_path, monkeypatch):
    """Each save leaves an index of all frames so far behind: all saved, 2.5 times the file."""
    chance, sizes, saves, save = np.random.default_rng(0), [], [], Sdf.Layer.Save
    monkeypatch.setattr(Sdf.Layer, "Save", lambda layer: saves.append(1) or save(layer))
    points, triangles = chance.random((60, 3)), chance.integers(0, 60, (100, 3))
    monkeypatch.setattr(usd, "_PAGE_BYTES", 0)
    for every in (0.0, 1e9):
        monkeypatch.setattr(usd, "SAVE_EVERY", every)
        path = tmp_path / f"{every:.0f}.usdc"
        with UsdWriter(path, [PlyShape("ply_0", points, triangles)]) as writer:
            for k in range(200):
                values = chance.random((5, 100))
                directions = chance.random((2, 100, 3))
                writer.write(k, 0.01 * k, [PlyFrame(chance.random((60, 3)), *directions, *values)])
        sizes.append(path.stat().st_size)
    assert len(saves) > 15 and sizes[1] < sizes[0] < 1.06 * sizes[1]


def test_a_disk_that_fills_at_the_end_is_a_failed_run(tmp_path, monkeypatch):
    save, calls = Sdf.Layer.Save, []

    def full(layer):
        calls.append(layer)
        return save(layer) if len(calls) == 1 else Tf.RaiseRuntimeError("no space left")

    monkeypatch.setattr(Sdf.Layer, "Save", full)
    monkeypatch.setattr(usd, "SAVE_EVERY", 1e9)
    out = tmp_path / "run"
    result = small_press(duration=4e-4).run(out, frames=2)
    assert not result.completed and "is lost: is the disk full" in result.summary["message"]
    assert sorted(f.name for f in out.iterdir()) == ["history.csv", "run.json", "summary.json"]


def test_failing_run_keeps_its_frames_under_the_final_name(tmp_path):
    with pytest.raises(RuntimeError, match="blew up"), writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        raise RuntimeError("blew up")
    assert [f.name for f in tmp_path.iterdir()] == ["scene.usdc"]
    assert not Sdf.Layer.Find(str(tmp_path / ".scene.partial.usdc"))  # Windows could not rename
    with pytest.raises(ValueError, match="closed"):
        writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])


def test_no_frame_no_file(tmp_path):
    writer = writer_in(tmp_path)
    writer.close()
    writer.close()
    assert list(tmp_path.iterdir()) == []


def test_rewritten_file_is_seen_by_those_who_hold_it(tmp_path):
    def run(part):
        with writer_in(tmp_path) as writer:
            writer.write(0, 0.0, frames_at(part), [[0, 0, 0]])

    run(0.0)
    held = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    (tmp_path / "scene.usdc").unlink()
    run(1.0)
    points = UsdGeom.Mesh(held.GetPrimAtPath("/World/plies/ply_0")).GetPointsAttr()
    np.testing.assert_allclose(np.array(points.Get(0)), frames_at(1.0)[0].points, atol=1e-7)


def test_file_in_the_way_and_missing_folder(tmp_path):
    (tmp_path / "scene.usdc").write_text("precious")
    with pytest.raises(InputError, match="exists already"):
        writer_in(tmp_path)
    assert (tmp_path / "scene.usdc").read_text() == "precious"
    with pytest.raises(InputError, match="cannot be created"):
        writer_in(tmp_path / "scene.usdc")


def test_nearly_full_disk_stops_the_run_and_keeps_its_frames(tmp_path, monkeypatch):
    with writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=1000))
        with pytest.raises(RunFailed, match=r"0 MB left.* the frames up to 0 are kept"):
            writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_0")).GetPointsAttr()
    assert points.GetTimeSamples() == [0.0]


def test_folder_removed_during_the_run_is_a_failed_run(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    writer = writer_in(folder)
    writer.write(np.int64(0), np.float64(0.0), frames_at(0.0), [[0, 0, 0]])
    shutil.rmtree(folder)
    with pytest.raises(RunFailed, match="the folder is gone"):
        writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])
    with pytest.raises(RunFailed, match=r"could not be saved at frame 0.*the folder gone"):
        writer.close()


def test_spoilt_file_never_gets_the_final_name(tmp_path, monkeypatch):
    monkeypatch.setattr(usd, "SAVE_EVERY", 0.0)
    with writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        monkeypatch.setattr(Sdf.Layer, "Save", lambda _: Tf.RaiseRuntimeError("no space left"))
        with pytest.raises(RunFailed, match="at frame 1 and is lost: is the disk full"):
            writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])
    assert list(tmp_path.iterdir()) == []


def test_a_save_needs_room_for_its_frames_twice(tmp_path, monkeypatch):
    """Frames, the index and small files: one byte too few and nothing is begun."""
    room = SimpleNamespace(free=3_000_000)
    monkeypatch.setattr("shutil.disk_usage", lambda _: room)
    check_space(tmp_path, 1_000_000, 4)
    room.free -= 1
    with pytest.raises(RunFailed, match=r"has 3 MB left, .* up to 4 are kept"):
        check_space(tmp_path, 1_000_000, 4)

"""The benchmarks run: a case against the C loop, and the start-up."""

import importlib.util
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

BENCH = Path(__file__).parents[1] / "bench"


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler for the yardstick")
def test_a_case_gives_a_ratio_and_shares(tmp_path):
    out = tmp_path / "bench.json"
    command = [sys.executable, str(BENCH), "hemisphere_1600", "--repeat", "1", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (row,) = json.loads(out.read_text(encoding="utf-8"))["rows"]
    assert row["triangles"] == 1600 and "hemisphere_1600" in done.stdout
    assert 0.01 < row["ratio"] < 10.0 and row["peak_mb"] > 10.0
    assert {"membrane", "tool contact", "integration"} <= set(row["phases"])
    assert 0.0 < row["output"] < 1.0


def loaded(name):
    """A module of the benchmark."""
    spec = importlib.util.spec_from_file_location(name, BENCH / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # for its dataclasses
    spec.loader.exec_module(module)
    return module


def test_the_start_is_timed_to_the_first_block(tmp_path):
    startup = loaded("startup")
    folder = tmp_path / "run"
    subprocess.run([sys.executable, "-c", startup.FIRST_STEP, str(folder)], check=True)
    assert (folder / "run.json").exists() and not (folder / "summary.json").exists()


def test_meshes_are_as_fine_as_the_grid_and_a_zigzag_is_seen():
    meshes = loaded("meshes")
    for kind in meshes.MESHES:
        assert len(meshes.mesh(kind, 20).triangles) == pytest.approx(1600, rel=0.07)
    flat = np.asarray(meshes.mesh("random, seed 0", 10).vertices)
    flat = np.column_stack([flat, np.zeros(len(flat))])
    assert meshes.zigzag(flat, 0.9 * flat + (0.01, 0.02, 0.03)) < 1e-12
    moved, side = flat.copy(), np.flatnonzero(np.isclose(flat[:, 0], 0.15))
    side = side[np.argsort(flat[side, 1])]
    moved[side[len(side) // 2], 0] -= 2e-3  # one tooth: it, and half of it at both neighbours
    others = [np.isclose(np.abs(flat[:, axis]), 0.15).sum() for axis in (0, 1)]
    count = sum(others) - 8  # the ends of four sides have no two neighbours
    lengths = np.diff(flat[side, 1])
    before, after = lengths[len(side) // 2 - 2 : len(side) // 2 + 2].reshape(2, 2)
    shares = (before[0] / before.sum(), after[1] / after.sum())
    expected = 2.0 * math.sqrt((1.0 + shares[0] ** 2 + shares[1] ** 2) / count)
    assert meshes.zigzag(flat, moved) == pytest.approx(expected)


def test_the_table_of_meshes_comes_from_runs_that_are_kept(tmp_path, capsys, monkeypatch):
    meshes = loaded("meshes")
    words = "meshes.py --angles 0 --cells 4 --meshes grid diagonal --set duration=0.004"
    monkeypatch.setattr(sys, "argv", [*words.split(), "--runs", str(tmp_path)])
    assert meshes.main() == 0
    first = capsys.readouterr().out
    assert "| 0° | 4 cells |" in first and "| diagonal |" in first and "| range |" in first
    assert len(list(tmp_path.glob("*.json"))) == len(list(tmp_path.glob("*.npz"))) == 2
    monkeypatch.setattr(meshes, "run_here", None)  # what is there is not done again
    assert meshes.main() == 0
    assert capsys.readouterr().out == first


def test_noise_in_the_vertices_is_as_small_as_said():
    sensitivity = loaded("sensitivity")
    scene = sensitivity.three_ply_hemisphere.build(cells=4)
    noisy = sensitivity.shaken(scene, 1)
    for ply, other in zip(scene.plies, noisy.plies, strict=True):
        off = np.abs(np.asarray(other.mesh.vertices) - np.asarray(ply.mesh.vertices)).max()
        assert 1e-11 < off < 0.15 * 1.01e-9


def test_a_larger_press_is_the_reference_press_scaled():
    loaded("meshes")  # which it imports, as a neighbour
    scene_of = loaded("press_sizes").scene_of
    small, large = (scene_of(scale, 0.3, 6, "grid", 5.0) for scale in (1.0, 2.0))
    assert large.numerics.stabiliser == small.numerics.stabiliser == 5.0
    for one, other in zip(small.tools, large.tools, strict=True):
        assert np.ptp(other.vertices) == pytest.approx(2.0 * np.ptp(one.vertices), rel=0.01)
    blanks = [np.ptp(scene.plies[0].mesh.vertices) for scene in (small, large)]
    assert blanks == pytest.approx([0.3, 0.6])
    holder, larger = (scene.tools[-1].motion for scene in (small, large))
    assert larger.force == pytest.approx(2.0 * holder.force) and larger.mass is None


def test_shares_that_do_not_scale_follow_from_the_times():
    """Work of 1.04 of which 0.02 is one part's, cut 10 % unevenly, and 0.03 of waiting."""
    scaling = loaded("scaling")
    together = (1.04 - 0.02) / 2 * 1.1 + 0.02 + 0.03
    times = [(2.0, 2.08, 2.0 * together)] * 3 + [(9.0, 1.0, 50.0)]  # one block that was disturbed
    shares = scaling.shares_of(times, 0.04, triangles=100, threads=2, uneven=0.1)
    assert shares.doubled == pytest.approx(0.04) and shares.alone == pytest.approx(0.02)
    assert shares.waiting == pytest.approx(0.03) and shares.time == pytest.approx(together)
    assert shares.serial == pytest.approx(2.0 * together - 1.0)  # f + (1 - f)/2 is the time
    assert shares.faster(2) == pytest.approx(1.0 / together)
    ideal = scaling.shares_of([(1.0, 1.0, 0.25)], 0.0, triangles=100, threads=4, uneven=0.0)
    assert ideal.serial == pytest.approx(0.0) and ideal.faster(16) == pytest.approx(16.0)
    assert ideal.waiting == pytest.approx(0.0)


def test_the_shares_of_a_scene_are_measured(capsys):
    assert loaded("scaling").main(["--cells", "6", "--blocks", "2"]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert "doubled" in head and row.split()[:2] == ["432", "2"]
    assert float(row.split()[2]) > 0.0


def test_frames_are_carried_over_to_finer_meshes_in_their_shape():
    measuring = loaded("measuring")
    coarse, fine = (measuring.three_ply_hemisphere.build(cells=cells) for cells in (12, 16))
    model = measuring.build_model(fine, "cpu", frames=1)

    def domed(scene):
        flat = np.concatenate([ply.rest_points for ply in scene.plies])
        return flat + np.c_[0.1 * flat[:, :2], 2.0 * (flat[:, 0] ** 2 + 0.5 * flat[:, 1] ** 2)]

    poses = [measuring.Pose(np.eye(3), np.array([0.0, 0.0, -0.5 * k])) for k in range(3)]
    carried = measuring.Frame(domed(coarse), poses).on(coarse, fine)
    assert len(carried.x) == model.spans[-1].vertices.stop
    assert np.abs(carried.x - domed(fine)).max() < 0.5e-3  # of a dome of 67 mm
    spent = measuring.spent_on(fine, model.spans, 2 * [carried])
    assert set(spent) == {"depths", "wrinkles"} and min(spent.values()) > 0.0

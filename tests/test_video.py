import subprocess
import sys

import numpy as np
import pytest
from synthetic_run import FRAMES, STROKE_S, write_run

from warpdrape import cli
from warpdrape.blanks.places import locate
from warpdrape.errors import InputError
from warpdrape.results import picture, video
from warpdrape.results.picture_layout import SCALE_BAR, Frame, scale_bar
from warpdrape.results.raster import Camera
from warpdrape.results.rendering import SAMPLES
from warpdrape.results.usd_reader import read_scene
from warpdrape.results.video import FRAMES_PER_SECOND, HOLD_S, draw_video
from warpdrape.results.yarn_arrows import yarn_arrows

HELD = round(HOLD_S * FRAMES_PER_SECOND)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("video") / "run").path


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(picture, "WIDTH", 400)
    monkeypatch.setattr(video, "WIDTH", 400)


def frames_of_gif(path):
    from PIL import Image, ImageSequence

    with Image.open(path) as film:
        return [
            np.asarray(each.convert("RGB"), float) / 255 for each in ImageSequence.Iterator(film)
        ]


def frames_of_mp4(path):
    """By FFmpeg's decoder, as raw bytes."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    reader = ffmpeg.read_frames(str(path))
    width, height = next(reader)["size"]
    return [np.frombuffer(raw, np.uint8).reshape(height, width, 3) / 255 for raw in reader]


def test_both_kinds_of_film_show_every_frame_and_hold_the_last(run, tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    path = draw_video(run)
    assert path == run / "ply_1.mp4" and not list(run.glob(".*partial*"))
    mp4 = frames_of_mp4(path)
    assert len(mp4) == FRAMES + HELD
    gif = frames_of_gif(draw_video(run, out=tmp_path / "a.gif"))
    assert FRAMES <= len(gif) <= FRAMES + HELD  # frames that are alike are kept once
    assert mp4[0].shape == gif[0].shape and mp4[0].shape[1] == int(0.7 * 400)
    for k in range(FRAMES):
        assert np.abs(mp4[k] - gif[k]).mean() < 0.02, k  # both are compressed with loss
        assert k == 0 or (np.abs(mp4[k] - mp4[k - 1]).max(axis=2) > 0.2).mean() > 0.01
    assert np.abs(mp4[FRAMES - 1] - mp4[-1]).mean() < 5e-3


def test_a_film_has_one_camera_and_one_scale(run, monkeypatch):
    seen = []
    monkeypatch.setattr(video, "drawn", lambda *given: seen.append(given) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        draw_video(run, stack=True, tools=True, out=run / "b.gif")
    ((moment, plies, tools, camera, paint, _),) = seen
    assert moment.time_s == 0.0 and len(plies) == 3 and len(tools) == 1
    last = read_scene(run / "scene.usdc", None, -1)
    assert last.time_s == pytest.approx(STROKE_S)
    assert paint.top >= max(ply.values.max() for ply in last.plies) > 10.0  # though flat at first
    for scene in (moment, last):
        for points in [ply.points for ply in scene.plies] + [points for points, _ in scene.tools]:
            column, row, _ = camera.project(points).T
            assert column.min() >= -1e-6 and column.max() <= camera.size[0] + 1e-6
            assert row.min() >= -1e-6 and row.max() <= camera.size[1] + 1e-6


def test_what_cannot_be_filmed_is_refused(run, tmp_path, monkeypatch, capsys):
    def refuse(words, **options):
        with pytest.raises(InputError, match=words):
            draw_video(run, **options)

    refuse("must end in .mp4 or .gif", out=tmp_path / "a.avi")
    refuse("unknown ply 'ply1'; did you mean", ply="ply1")
    refuse("has no slip in this run", field="slip")
    refuse("cannot be written", out=run / "summary.json" / "a.gif")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    refuse(r"needs imageio_ffmpeg, .*pip install 'warpdrape\[video\]'", out=tmp_path / "a.mp4")
    assert cli.main(["picture", str(run), "--video", "--frame", "1"]) == 2
    assert "--frame K for one moment or --video for all" in capsys.readouterr().err
    gif = tmp_path / "c.gif"
    argv = ["picture", str(run), "--video", "--stack", "--arrows", "--out", str(gif)]
    assert cli.main(argv) == 0
    assert capsys.readouterr().out.strip() == str(gif) and len(frames_of_gif(gif)) >= FRAMES


def test_a_scale_bar_is_as_long_as_it_says():
    corners = np.array([[x, y, z] for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (0.0, 0.1)])
    for size, expected in ((1.0, 0.05), (0.3, 0.02), (10.0, 0.5)):
        camera = Camera.around(size * corners, 32.0, -62.0, 1344 * SAMPLES)
        length, pixels = scale_bar(Frame(1600, 1.0, camera, ""))
        assert length == pytest.approx(expected)
        ends = camera.target + np.outer([-0.5, 0.5], camera.axes[0]) * length
        across = np.diff(camera.project(ends)[:, 0]) / SAMPLES
        assert pixels == pytest.approx(across[0]) and 0.4 < pixels / (SCALE_BAR * 1600) <= 1.0
        half = scale_bar(Frame(1600, 0.5, Camera.around(size * corners, 32.0, -62.0, 1344), ""))
        assert half == pytest.approx((length, pixels), rel=5e-3)  # whole pixels of the image


def test_arrows_lie_along_the_yarns_where_they_are_seen(run):
    ply = read_scene(run / "scene.usdc", ["ply_0"], -1).plies[0]
    camera = Camera.around(ply.points, 60.0, -62.0, 800)
    arrows = yarn_arrows(ply, camera)
    assert 50 < len(arrows.starts) < 110  # nine by nine, cut by the blank at 45°
    flat = camera.project(ply.points)[:, :2]  # the ply seen from above hides nothing of itself
    places = locate(arrows.starts, flat, ply.triangles)
    assert (places.triangles >= 0).all()
    corners = ply.triangles[places.triangles]
    for ways, directions in zip(arrows.ways, (ply.warp, ply.weft), strict=True):
        at = np.einsum("kw,kwx->kx", places.weights, ply.points[corners])
        ahead = at + 1e-5 * directions[places.triangles]
        toward = (camera.project(ahead) - camera.project(at))[:, :2]
        cosine = (ways * toward).sum(axis=1)
        cosine /= np.linalg.norm(ways, axis=1) * np.linalg.norm(toward, axis=1)
        assert cosine.min() > 0.99  # but for the perspective along an arrow


def test_arrows_behind_the_ply_are_not_drawn(run):
    ply = read_scene(run / "scene.usdc", ["ply_0"], -1).plies[0]
    steep = yarn_arrows(ply, Camera.around(ply.points, 80.0, -45.0, 800))
    low = yarn_arrows(ply, Camera.around(ply.points, 3.0, 45.0, 800))
    assert len(low.starts) < 0.8 * len(steep.starts)


def test_ffmpeg_is_not_needed_to_import(run):
    code = "import sys, warpdrape.results.video; print('imageio_ffmpeg' in sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ended.stdout.split() == ["False"], ended.stderr

"""What the animation's writer refuses, and that nothing is written then."""

from dataclasses import replace

import numpy as np
import pytest
from pxr import Usd, UsdGeom
from synthetic_run import frames_at, writer_in

from warpdrape.errors import InputError
from warpdrape.results.usd import PlyShape, UsdWriter


@pytest.mark.parametrize("quantity", ["points", "weft", "shear_angle_deg", "warp_tension"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
def test_non_finite_value_is_refused_and_nothing_written(tmp_path, quantity, bad):
    frames = frames_at(0.5)
    values = np.array(getattr(frames[1], quantity))
    values[7] = bad  # 1e300 is infinite in the file's float32
    with writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        frames[1] = replace(frames[1], **{quantity: values})
        with pytest.raises(ValueError, match=rf"'ply_1': {quantity} .* first at 7"):
            writer.write(1, 0.1, frames, [[0, 0, 0]])
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    for name in ("ply_0", "ply_1"):
        points = UsdGeom.Mesh(stage.GetPrimAtPath(f"/World/plies/{name}")).GetPointsAttr()
        assert points.GetTimeSamples() == [0.0]


def test_misuse_says_what_is_wrong(tmp_path):
    with writer_in(tmp_path) as writer:
        writer.write(3, 0.0, frames_at(0.0), [[0, 0, 0]])
        with pytest.raises(ValueError, match="must be above the last, 3"):
            writer.write(3, 0.1, frames_at(0.0), [[0, 0, 0]])
        with pytest.raises(ValueError, match="2 ply frames for 3 plies"):
            writer.write(4, 0.1, frames_at(0.0)[:2], [[0, 0, 0]])
        with pytest.raises(ValueError, match=r"translation has shape \(2, 3\), must be \(1, 3\)"):
            writer.write(4, 0.1, frames_at(0.0), np.zeros((2, 3)))
        with pytest.raises(ValueError, match="translation has 1 non-finite"):
            writer.write(4, 0.1, frames_at(0.0), [[0, 0, np.nan]])
        with pytest.raises(ValueError, match="time_s = nan"):
            writer.write(4, float("nan"), frames_at(0.0), [[0, 0, 0]])
        short = replace(frames_at(0.0)[0], weft_strain=np.zeros(3))
        with pytest.raises(ValueError, match=r"'ply_0': weft_strain has shape \(3,\)"):
            writer.write(4, 0.1, [short, *frames_at(0.0)[1:]], [[0, 0, 0]])


def test_unusable_shapes_are_refused_before_a_file_appears(tmp_path):
    points, triangles = np.eye(3), np.array([[0, 1, 2]])

    def refuse(message, *plies):
        with pytest.raises(InputError, match=message):
            UsdWriter(tmp_path / "scene.usdc", plies)
        assert list(tmp_path.iterdir()) == []

    ply = PlyShape("a b", points, triangles)
    refuse("'a_b' and ply 'a b' would both be 'a_b'", ply, PlyShape("a_b", points, triangles))
    refuse("ply name = ''", PlyShape("", points, triangles))
    refuse("vertices 0 to 2", PlyShape("a", points, triangles + 1))
    refuse("integers", PlyShape("a", points, triangles * 1.0))
    refuse("finite", PlyShape("a", points * np.nan, triangles))

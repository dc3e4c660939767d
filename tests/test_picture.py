import numpy as np
import pytest
from pxr import Sdf, Usd, Vt
from synthetic_run import ANGLES_DEG, blank, frame_of, frames_at, saddle, write_run

from warpdrape.errors import InputError
from warpdrape.results import picture, rendering
from warpdrape.results.picture import draw_ply, draw_stack
from warpdrape.results.quantities import QUANTITIES, rounded_up
from warpdrape.results.usd_reader import PlyView, read_scene
from warpdrape.results.yarn_lines import on_blank, round_spacing


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("picture") / "run").path


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(picture, "WIDTH", 400)


def pixels(path) -> np.ndarray:
    from matplotlib.image import imread

    return imread(path)[..., :3]


def view_of(angle_deg: float, amount: float) -> PlyView:
    rest, triangles = blank()
    f = frame_of(rest, triangles, saddle(rest, amount), angle_deg)
    return PlyView("a", f.points, rest, triangles, f.warp, f.weft, abs(f.shear_angle_deg))


def test_reads_back_what_was_written(run):
    scene = read_scene(run / "scene.usdc", None, -1)
    assert scene.time_s == pytest.approx(0.08)
    assert [p.name for p in scene.plies] == ["ply_0", "ply_1", "ply_2"]
    for ply, frame in zip(scene.plies, frames_at(1.0), strict=True):
        np.testing.assert_allclose(ply.points, frame.points, atol=1e-7)
        np.testing.assert_allclose(ply.values, abs(frame.shear_angle_deg), atol=1e-5)
    ((points, triangles),) = scene.tools
    assert triangles.shape == (4, 3)
    np.testing.assert_allclose(points[0], [0.0, 0.0, -0.03], atol=1e-9)
    assert read_scene(run / "scene.usdc", ["ply_2"], 0).time_s == 0.0


def test_draws_the_middle_ply_by_default(run, tmp_path, monkeypatch):
    monkeypatch.setattr(picture, "WIDTH", 1600)
    path = draw_ply(run)
    assert path == run / "ply_1.png"
    image = pixels(path)
    assert image.shape[1] == 1600
    assert (image[:, [0, -1]] == 1.0).all() and (image[[0, -1]] == 1.0).all()  # white all round
    assert (image.min(axis=2) < 0.9).mean() > 0.2  # and something in the middle
    named = pixels(draw_ply(run, "ply_1", out=tmp_path / "new" / "a.png"))
    np.testing.assert_array_equal(named, image)


def test_every_option_changes_the_picture(run, tmp_path):
    options = [
        {},
        {"frame": 1},
        {"view": (60.0, 10.0)},
        {"top": 60.0},
        {"yarns": False},
        {"smooth": False},
        {"tools": True},
        {"arrows": True},
    ]
    drawn = [pixels(draw_ply(run, out=tmp_path / "a.png", **o)) for o in options]
    for image, option in zip(drawn[1:], options[1:], strict=True):
        assert image.shape != drawn[0].shape or (image != drawn[0]).mean() > 1e-4, option


def test_flat_colours_are_those_of_the_scale(run):
    from matplotlib import colormaps

    ply = view_of(0.0, 1.0)
    paint = picture.paint_of(QUANTITIES["shear"], [ply], None, False, False)
    assert ply.values.max() <= paint.top < ply.values.max() + 5.0
    corners = paint.colors_at_corners(ply)
    np.testing.assert_array_equal(
        corners[:, 0], colormaps["viridis"](ply.values / paint.top)[:, :3]
    )
    np.testing.assert_array_equal(corners[:, 0], corners[:, 2])


@pytest.mark.parametrize("angle", [0.0, 22.5, 45.0, 130.0])
def test_yarn_lines_lie_along_the_yarns(angle):
    ply = view_of(angle, 1.0)
    t = np.radians(angle)
    warp, weft = (on_blank(ply.rest, ply.points, ply.triangles, d) for d in (ply.warp, ply.weft))
    np.testing.assert_allclose(warp, [np.cos(t), np.sin(t)], atol=1e-9)
    np.testing.assert_allclose(weft, [-np.sin(t), np.cos(t)], atol=1e-9)
    along = np.outer(np.linspace(0, 0.1, 9), warp)
    on = rendering._line_share(along + 0.01 * weft, [warp], 0.01, 1e-5)
    off = rendering._line_share(along + 0.015 * weft, [warp], 0.01, 1e-5)
    assert on.min() == 1.0 and off.max() == 0.0


def test_hanging_ply_is_turned_over():
    rest, triangles = blank()
    bowl = rest + [0.0, 0.0, 1.0] * (rest**2).sum(axis=1, keepdims=True)
    for z, expected in ((1.0, True), (-1.0, False), (0.0, False)):
        f = frame_of(rest, triangles, bowl * [1.0, 1.0, z], 0.0)
        ply = PlyView("a", f.points, rest, triangles, f.warp, f.weft, f.shear_angle_deg)
        assert picture.hangs_down(ply) is expected


@pytest.mark.parametrize(("size", "expected"), [(0.3, 0.01), (0.5, 0.02), (3e-3, 1e-4)])
def test_line_spacing_is_round(size, expected):
    assert round_spacing(blank(size=size)[0]) == pytest.approx(expected)


def test_stack_shows_every_ply(run):
    path = draw_stack(run)
    assert path == run / "stack.png"
    image = pixels(path)
    assert image.shape[1] == picture.WIDTH
    panel = int(0.84 * picture.WIDTH / len(ANGLES_DEG))
    for i in range(len(ANGLES_DEG)):
        assert (image[150:, 20 + i * panel :][:, :panel].min(axis=2) < 0.9).mean() > 0.1


def test_vector_file(run, tmp_path):
    assert draw_ply(run, out=tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


def test_clear_errors(run, tmp_path):
    def refuse(message, *args, **kwargs):
        with pytest.raises(InputError, match=message):
            draw_ply(*args, **kwargs)

    refuse("does not exist: give the folder of a finished run", tmp_path / "none")
    refuse("holds no scene.usdc: give the folder", tmp_path)
    (tmp_path / ".scene.partial.usdc").write_bytes(b"")
    refuse("was cut off; if it was, draw .*partial.usdc", tmp_path)
    (tmp_path / "scene.usdc").write_text("nonsense")
    refuse("not a readable USD file", tmp_path)
    refuse("unknown ply 'ply1'; did you mean 'ply_1'", run, "ply1")
    refuse("frame = 4 is out of range: .* has frames 0 to 3", run, frame=4)
    refuse("frame = -5 is out of range", run, frame=-5)
    refuse("top = 0 ° must be above zero", run, top=0)
    refuse("cannot be written .* ending in .png", run, out=tmp_path / "a.docx")
    assert draw_ply(run / "scene.usdc", out=tmp_path / "b.png").is_file()


def spoil(path, change):
    """Change a prim's attributes in a USD file."""
    layer = Sdf.Layer.FindOrOpen(str(path))
    change(Usd.Stage.Open(layer))
    layer.Save()


def set_at(prim, name, value, time=None):
    def change(stage):
        attribute = stage.GetPrimAtPath(f"/World/{prim}").GetAttribute(name)
        time is None or attribute.Set(value, time)
        time is not None or attribute.Set(value)

    return change


def spoil_point(stage):
    attribute = stage.GetPrimAtPath("/World/plies/ply_1").GetAttribute("points")
    values = np.array(attribute.Get(3))
    values[5, 2] = np.nan
    attribute.Set(Vt.Vec3fArray.FromNumpy(values), 3)


def refer(stage):
    stage.GetRootLayer().subLayerPaths.append("other.usda")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (spoil_point, "ply_1: points has shape (49, 3), not finite"),
        (set_at("plies/ply_1", "faceVertexIndices", [0, 1, 99] * 72), "of vertices that it lacks"),
        (set_at("plies/ply_1", "faceVertexIndices", [0, 1, 2] * 7), "has shape (72,), not"),
        (set_at("plies/ply_1", "primvars:warp", [(1, 0, 0)] * 3, 3), "warp has shape (3, 3), not"),
        (set_at("plies/ply_1", "primvars:restPoints", [(1, 0, 0)]), "of vertices that it lacks"),
        (set_at("plies/ply_1", "primvars:shearAngle", [1.0], 3), "shearAngle has shape (1,)"),
        (set_at("tools/punch_no__1", "points", []), "punch_no__1: points is empty"),
        (
            set_at("plies/ply_1", "primvars:restPoints", [(9, 0, 0)] * 50),
            "points has shape (49, 3)",
        ),
        (set_at("tools/punch_no__1", "faceVertexIndices", [0, 1, 4]), "vertices that it lacks"),
        (refer, "refers to another file, other.usda"),
    ],
)
def test_a_damaged_file_is_told_and_nothing_drawn(change, words, tmp_path):
    run = write_run(tmp_path / "run").path
    (tmp_path / "run" / "other.usda").write_text('#usda 1.0\ndef "World" {}\n')
    spoil(run / "scene.usdc", change)
    with pytest.raises(InputError) as refused:
        draw_ply(run, tools=True)
    assert words in str(refused.value) and str(run / "scene.usdc") in str(refused.value)
    assert "\n" not in str(refused.value) and not list(run.glob("*.png"))


def test_other_fields_are_drawn_under_their_own_names(run, tmp_path):
    shear = pixels(draw_ply(run, out=tmp_path / "a.png"))
    path = draw_ply(run, field="warp-strain")
    assert path == run / "ply_1_warp-strain.png"
    assert (pixels(path) != shear).mean() > 1e-2
    assert draw_stack(run, field="weft-tension") == run / "stack_weft-tension.png"


def test_a_field_that_is_not_there_is_refused_with_those_that_are(run):
    with pytest.raises(InputError, match="'ply_0' has no slip in this run; it has: shear, warp-s"):
        draw_ply(run, "ply_0", field="slip")
    with pytest.raises(InputError, match="unknown field 'sheer'; did you mean 'shear'"):
        draw_ply(run, field="sheer")


def test_scales_end_at_round_numbers_and_hold_what_is_shown():
    assert [rounded_up(v) for v in (0.0, -1.0, 0.1, 28.9, 31.0, 1e5)] == [0, 0, 0.1, 30, 40, 1e5]
    strain, slip = QUANTITIES["warp-strain"], QUANTITIES["slip"]
    assert strain.scale(strain.of(np.array([-0.002, 0.011]))) == (-0.2, 1.5)
    assert slip.scale(slip.of(np.array([[0.003, 0.004, 0.0]]))) == (0.0, 5.0)
    pressure = QUANTITIES["contact-pressure"]
    values = pressure.of(np.r_[np.full(999, 5e3), 1e9])
    assert pressure.scale(values) == (0.0, 5.0)
    assert pressure.scale(np.zeros(4)) == (0.0, 1.0)
    assert pressure.scale(np.r_[np.zeros(999), 3.0]) == (0.0, 3.0)


def test_a_caption_tells_the_largest_value_at_vertices():
    triangles = np.array([[0, 1, 2], [1, 3, 2]])
    text = QUANTITIES["tool-pressure"].caption(
        np.array([0.0, 0.0, 0.0, 9.0]), triangles, np.ones(2), short=False
    )
    assert text == "tool pressure up to 9 kPa, 95 % of the area below 3 kPa"

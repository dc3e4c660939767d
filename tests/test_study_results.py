"""What a study makes of its runs: effects, indices, maps with known answers; tables, measures."""

import csv
from argparse import Namespace

import numpy as np
import pytest
import scipy.stats
from optimise_checks import STUDY, MadeUp, made_up_tool, write_formulas
from study_checks import made_up

from warpdrape.defects.limits import Limits, limits_entry
from warpdrape.errors import InputError
from warpdrape.studies.command import cost_text
from warpdrape.studies.design import Design
from warpdrape.studies.effects import effects
from warpdrape.studies.fields import PlyFields
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.indices import indices
from warpdrape.studies.map_files import draw_map, write_map
from warpdrape.studies.maps import map_runs, triangles_at
from warpdrape.studies.measures import Measure, read_measures
from warpdrape.studies.pictures import draw_effects, draw_indices, draw_pairs
from warpdrape.studies.progress import StudyProgress
from warpdrape.studies.running import Cost
from warpdrape.studies.study import MapOptions
from warpdrape.studies.study_file import read_study
from warpdrape.studies.table import gather, write_table

SUMMARY = {
    "steps": 7,
    "plies": [
        {"name": "low", "shear": 3.0, "defects": {"wrinkles": {"list": []}, "locking": None}},
        {"name": "high", "shear": 5.0, "defects": {"wrinkles": {"list": []}, "locking": None}},
    ],
}
ROWS = {"time_s": np.array([0.0, 1.0, 2.0]), "punch_force_n": np.array([0.0, 9.0, 6.0])}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("steps", 7.0),
        ("plies.low.shear", 3.0),
        ("plies.*.shear", 5.0),
        ("plies.low.defects.locking", None),
        ("history.punch_force_n.last", 6.0),
        ("history.punch_force_n.max", 9.0),
        ("history.punch_force_n.min", 0.0),
        ("history.punch_force_n.mean", 5.0),
    ],
)
def test_measures(path, value):
    (measure,) = read_measures({"m": path})
    assert measure.of(SUMMARY, ROWS) == value


@pytest.mark.parametrize("own", [False, True])
def test_the_verdict_is_by_the_studys_limits_or_the_scenes(tmp_path, own):
    text = STUDY.partition("[optimise]")[0] + '[design]\nkind = "grid"\nsteps = 2\n'
    if not own:
        (tmp_path / "limits.toml").write_text("coverage = { punch = 0.5 }\n", encoding="utf-8")
        text = f'limits = "limits.toml"\n{text}'
    study, folder = read_study(write_formulas(tmp_path, text)), StudyFolder(tmp_path / "o")
    rows = study.rows()
    jobs = [Namespace(number=k, settings=study.settings(row)) for k, row in enumerate(rows)]

    def gathered(limits):
        def formula(values):
            tools = [made_up_tool(float(values["x"]))]
            return {"f": 1.0, "g": 1.0, "tools": tools, "limits": limits_entry(limits)}

        (tmp_path / "o" / "outcomes").mkdir(parents=True, exist_ok=True)
        outcomes = {outcome["run"]: outcome for outcome in MadeUp(folder, formula)(jobs)}
        return gather(study, folder, rows, outcomes)

    table = gathered(Limits(coverage={"punch": 0.5 if own else 0.0}))
    assert [row["x"] for row in rows] == [0.0, 0.0, 1.0, 1.0]
    assert table.columns["fit"] == [0, 0, 1, 1] and "fit" in table.measures
    bare = gathered(None)
    assert ("fit" in bare.columns) is not own


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("plies.lwo.shear", "plies has no 'lwo'; did you mean 'low'"),
        ("stps", "the summary has no 'stps'; did you mean 'steps'"),
        ("plies.low", "plies.low is no number; go on with one of name, shear, defects"),
        ("plies", "go on with a name"),
        ("history.punch_frce_n.max", "did you mean 'punch_force_n'"),
    ],
)
def test_measures_that_are_not_there(path, words):
    with pytest.raises(InputError, match="measure m: ") as caught:
        Measure("m", path).of(SUMMARY, ROWS)
    assert words in str(caught.value)


def test_effects_against_means_taken_by_hand():
    a, b = np.meshgrid([1.0, 2.0, 3.0], [10.0, 20.0])
    columns = {"a": a.ravel().tolist(), "b": b.ravel().tolist(), "word": list("xyxyxy")}
    y = (5.0 * a + 0.1 * b).ravel()
    found = {e.parameter: e for e in effects(made_up(columns, {"y": y.tolist()}))}
    assert found["a"].means == pytest.approx([6.5, 11.5, 16.5])
    assert found["b"].means == pytest.approx([11.0, 12.0]) and found["b"].span == pytest.approx(1.0)
    assert found["a"].errors == pytest.approx([0.5] * 3)  # two values 1 apart: half of it
    assert found["word"].words == ("x", "y") and np.isnan(found["word"].rank)
    x = [y[k] for k in (0, 2, 4)]
    assert found["word"].means[0] == pytest.approx(np.mean(x))
    ranks = [scipy.stats.rankdata(v) for v in (a.ravel(), y)]
    assert found["a"].rank == pytest.approx(np.corrcoef(*ranks)[0, 1])


def test_effects_leave_out_runs_that_failed_and_cut_many_values_into_parts():
    x = np.random.default_rng(1).permutation(60).astype(float)
    y, status = (2.0 * x).tolist(), ["completed"] * 60
    y[0], status[0] = 1e9, "failed"
    (found,) = effects(made_up({"x": x.tolist()}, {"y": y}, status))
    assert found.counts.sum() == 59 and len(found.levels) == 6
    assert found.means == pytest.approx(2.0 * found.levels) and found.rank == pytest.approx(1.0)
    assert (np.diff(found.levels) > 0).all() and set(found.counts) <= {9, 10}


def ishigami(shares):
    """A test function of three variables whose indices are known in closed form (a 7, b 0.1)."""
    x = np.pi * (2.0 * shares - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def of_shares(shares, values):
    columns = {f"x{k + 1}": shares[:, k].tolist() for k in range(shares.shape[1])}
    return made_up(columns, {"y": list(values)})


def test_sobol_indices_of_the_ishigami_function():
    """Variance 13.8446: V1 = (1 + 0.1 π⁴/5)²/2, V2 = 49/8, V13 = 8 · 0.01 π⁸/225."""
    pytest.importorskip("SALib")
    design = Design("indices", runs=1024)
    shares = design.shares(3)
    found, remark = indices(of_shares(shares, ishigami(shares)), design)
    first = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2
    both = 8.0 * 0.01 * np.pi**8 / 225.0
    whole = first + 49.0 / 8.0 + both
    assert [i.first for i in found] == pytest.approx(
        [first / whole, 49.0 / 8.0 / whole, 0.0],
        abs=0.05,  # some 1/√1024 and a half
    )
    totals = [(first + both) / whole, 49.0 / 8.0 / whole, both / whole]
    assert [i.total for i in found] == pytest.approx(totals, abs=0.05)
    assert remark == "" and {i.method for i in found} == {"Saltelli"}
    assert all(0.0 < i.total_95 < 0.1 for i in found)


def test_a_run_that_failed_takes_its_sample_with_it():
    pytest.importorskip("SALib")
    design = Design("indices", runs=512)
    shares = design.shares(3)
    values = ishigami(shares)
    whole, _ = indices(of_shares(shares, values), design)
    broken = values.tolist()
    broken[12] = None  # of the third sample, of five runs
    found, remark = indices(of_shares(shares, broken), design)
    assert found[0].runs == whole[0].runs - 5
    assert "1 of 512 samples are left out" in remark
    assert [i.first for i in found] == pytest.approx([i.first for i in whole], abs=0.02)


def test_first_order_indices_of_a_latin_hypercube():
    """Of y = 3 x1 + x2 they are 9/10 and 1/10, of any number of idle parameters 0."""
    pytest.importorskip("SALib")
    design = Design("latin", runs=500)
    shares = design.shares(3)
    found, _ = indices(of_shares(shares, 3.0 * shares[:, 0] + shares[:, 1]), design)
    assert [i.first for i in found] == pytest.approx([0.9, 0.1, 0.0], abs=0.06)
    assert all(np.isnan(i.total) for i in found)
    few = Design("latin", runs=16)
    none, remark = indices(of_shares(few.shares(2), few.shares(2)[:, 0]), few)
    assert none == [] and "need 200 runs" in remark


def blank(cells, width=0.3, name="ply_0", shear=None, wrinkle=None, locking=np.nan):
    """A square blank about the origin, two triangles a cell."""
    axis = np.linspace(-0.5 * width, 0.5 * width, cells + 1)
    rest = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    i, j = (k.ravel() for k in np.meshgrid(range(cells), range(cells), indexing="ij"))
    a, b, c, d = ((i + p) * (cells + 1) + j + q for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    m = len(triangles)
    shear = np.zeros(m) if shear is None else shear(rest[triangles].mean(axis=1))
    wrinkle = np.zeros(m) if wrinkle is None else wrinkle(rest[triangles].mean(axis=1))
    return PlyFields(name, rest, triangles, shear, wrinkle, locking)


def test_maps_against_numpy():
    random = np.random.default_rng(2)
    runs = [
        [
            blank(
                4,
                shear=lambda p: random.normal(20.0, 15.0, len(p)),
                wrinkle=lambda p: random.choice([0.0, 2e-4, 1e-3], len(p)),
                locking=40.0,
            )
        ]
        for _ in range(17)
    ]
    (found,) = map_runs(runs, MapOptions(wrinkle=5e-4))
    shear = np.array([plies[0].shear_deg for plies in runs])
    wrinkle = np.array([plies[0].wrinkle for plies in runs])
    values = found.values()
    assert values["mean_shear_deg"] == pytest.approx(shear.mean(axis=0), abs=1e-12)
    assert values["sd_shear_deg"] == pytest.approx(shear.std(axis=0, ddof=1), abs=1e-12)
    assert values["wrinkle_chance"] == pytest.approx((wrinkle > 5e-4).mean(axis=0))
    assert values["locking_chance"] == pytest.approx((np.abs(shear) > 40.0).mean(axis=0))
    (own,) = map_runs(runs, MapOptions(locking_deg=10.0))
    assert own.values()["locking_chance"] == pytest.approx((np.abs(shear) > 10.0).mean(axis=0))


def test_maps_of_blanks_that_differ():
    """A linear field on meshes of another fineness and size: its mean, and no run off its blank."""

    def slope(points):
        return 100.0 * points[:, 0]

    runs = [[blank(20, shear=slope)], [blank(30, shear=slope)], [blank(20, 0.2, shear=slope)]]
    (found,) = map_runs(runs, MapOptions())
    centres = found.points[found.places].mean(axis=1)
    inner = np.abs(centres).max(axis=1) < 0.1
    assert set(found.runs[inner]) == {3} and set(found.runs[~inner]) == {2}
    values = found.values()
    edge = 0.3 / 20  # a triangle's value is that of its own centre, at most so far away
    assert values["mean_shear_deg"] == pytest.approx(slope(centres), abs=100.0 * edge)
    assert np.isnan(values["locking_chance"]).all()


def test_triangles_by_brute_force():
    ply = blank(5)
    points = np.random.default_rng(3).uniform(-0.2, 0.2, (200, 2))
    found = triangles_at(points, ply.rest, ply.triangles)
    for point, got in zip(points, found, strict=True):
        inside = []
        for k, (a, b, c) in enumerate(ply.rest[ply.triangles]):
            weights = np.linalg.solve(np.column_stack([b - a, c - a]), point - a)
            if weights.min() >= 0.0 and weights.sum() <= 1.0:
                inside.append(k)
        assert (got in inside) if inside else got == -1
    on_edge = triangles_at(ply.rest[:3] * 0.99 + ply.rest[1:4] * 0.01, ply.rest, ply.triangles)
    assert (on_edge >= 0).all()


def test_the_table_by_another_reader(tmp_path):
    duckdb = pytest.importorskip("duckdb")
    words = ["grid", "a, 'b'", "c"]
    table = made_up(
        {"mesh": words, "x": [0.1 + 0.2, 1.0 / 3.0, 1e-17], "n": [1, 2, 3]},
        {"y": [1.5, None, 2.5]},
        ["completed", "failed", "completed"],
    )
    files = write_table(table, tmp_path)
    rows = duckdb.sql(f"select mesh, x, n, y, status from '{files[1]}'").fetchall()
    assert rows[0] == ("grid", 0.1 + 0.2, 1, 1.5, "completed")
    assert rows[1] == ("a, 'b'", 1.0 / 3.0, 2, None, "failed")
    with files[0].open(newline="") as file:
        text = list(csv.DictReader(file))
    assert [float(row["x"]) for row in text] == table.columns["x"]  # to the last bit
    assert [row["mesh"] for row in text] == words and text[1]["y"] == ""


def test_pictures_are_drawn(tmp_path):
    """Whatever a table holds: words, a measure that is the same everywhere, one that is nowhere."""
    random = np.random.default_rng(4)
    columns = {"x": random.random(20).tolist(), "mesh": ["a", "b"] * 10}
    measures = {"y": random.random(20).tolist(), "same": [0.0] * 20, "none": [None] * 20}
    table = made_up(columns, measures)
    figure = draw_effects(table, effects(table))
    assert len(figure.axes) == 2  # one measure that varies, two parameters
    pairs, left = draw_pairs(table)
    assert left == [] and sum(axes.get_visible() for axes in pairs.axes) == 3
    (found,) = map_runs([[blank(3)], [blank(3)]], MapOptions())
    draw_map(found, 2).savefig(tmp_path / "map.png")
    write_map(found, tmp_path / "map.csv")
    with (tmp_path / "map.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 18 and {row["locking_chance"] for row in rows} == {""}
    pytest.importorskip("SALib")
    design = Design("indices", runs=32)
    shares = design.shares(2)
    found, _ = indices(of_shares(shares, shares[:, 0]), design)
    draw_indices(found).savefig(tmp_path / "indices.png")


def test_progress(capsys):
    times = iter([0.0, 10.0, 10.0, 20.0, 20.0, 30.0, 30.0])
    progress = StudyProgress(5, 2, clock=lambda: next(times))
    progress.ended(well=True)
    progress.ended(well=False, why="run 3 failed: so")
    progress.ended(well=True)
    said = capsys.readouterr().err.splitlines()
    assert said == [
        "3 of 5 runs, 20 s left",
        "run 3 failed: so",
        "4 of 5 runs, 1 failed, 10 s left",
        "5 of 5 runs, 1 failed, in 30 s",
    ]


def test_cost_is_told_as_runs_start_and_order():
    cost = Cost(own_start_s=1.0, own_s=1.5)
    runs = (("a", 3.0, 0.9, 0.1), ("b", 3.5, 1.0, 0.0), ("a", 4.2, 1.1, 0.0), ("a", 6.2, 1.9, 0.1))
    for host, ended, run, watch in runs:
        found = {"worker_cpu_s": ended, "cpu_s": run, "watch_s": watch}
        cost.add({"host": host, "process": 1, **found})
    cost.add({"host": "a", "process": 1})  # a run that was done before
    assert cost.runs_s == pytest.approx(4.9)
    assert cost.start_s == pytest.approx(2.0 + 2.5 + 1.0)
    assert cost.order_s == pytest.approx((6.2 - 2.0 - 3.9) + 0.0 + 0.5)  # watch is order
    words = cost_text(cost, 1.25)
    beyond = "5.5 s (112.2 %) to start, 0.8 s (16.3 %) for order and 1.2 s (25.5 %) for the report"
    assert words == f"processor time: 5 s in runs, {beyond}"

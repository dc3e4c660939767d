"""Exports with a row a triangle, read back by csv, DuckDB, numpy and pandas."""

import csv
from dataclasses import replace

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.exports.export import export
from warpdrape.exports.table import _joined, _rows, _text, _write_csv, _write_parquet
from warpdrape.results.fields import fields_of


def expected(ply, frame):
    """Some columns of a ply, computed anew."""
    a, b, c = (ply.points[ply.triangles[:, k]] for k in range(3))
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))]
    half = 0.5 * sum(sides)  # Heron
    area = np.sqrt(half * np.prod([half - side for side in sides], axis=0))
    return {
        "frame": np.full(len(a), frame),
        "triangle": np.arange(len(a)),
        "centre_z_m": (a + b + c)[:, 2] / 3.0,
        "rest_centre_x_m": ply.rest_points[ply.triangles, 0].mean(axis=1),
        "area_m2": area,
        "warp_y": ply.warp[:, 1],
        "shear_angle_deg": ply.shear_angle_deg,
        "weft_strain": ply.strain[:, 1],
        "warp_tension_n_per_m": ply.line_tension[:, 0],
        "weft_curvature_per_m": ply.curvature[ply.triangles, 1].mean(axis=1),
        "slip_x_m": ply.slip[ply.triangles, 0].mean(axis=1),
        "tool_pressure_pa": ply.tool_pressure[ply.triangles].mean(axis=1),
    }


def check_table(columns, folder, frames):
    """Hold a table, its columns as lists, against the run."""
    start = 0
    for frame in frames:
        for ply in wd.read_run(folder, frame=frame).plies:
            rows = slice(start, start + len(ply.triangles))
            assert set(columns["ply"][rows]) == {ply.name}
            for name, values in expected(ply, frame).items():
                read = np.array(columns[name][rows], float)
                np.testing.assert_allclose(read, values, rtol=1e-8, atol=1e-12, err_msg=name)
            start = rows.stop
    assert len(columns["ply"]) == start
    count = sum(3 if field.vector else 1 for field in fields_of(ply))
    assert len(list(columns)) == 11 + count


def test_csv_has_a_row_a_triangle(pressed, tmp_path):
    folder = pressed[1]
    for frame, frames in ((None, [4]), ("all", range(5)), (-4, [1])):
        out = export(folder, "csv", tmp_path / "t.csv", frame=frame, overwrite=True)
        with out.open(encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        check_table(dict(zip(names, zip(*rows, strict=True), strict=True)), folder, frames)


def test_parquet_is_read_by_another_library(pressed, tmp_path):
    pytest.importorskip("pyarrow")
    duckdb = pytest.importorskip("duckdb")
    out = export(pressed[1], "parquet", tmp_path / "t.parquet")
    table = duckdb.read_parquet(str(out)).fetchnumpy()
    check_table({name: list(values) for name, values in table.items()}, pressed[1], [4])


def test_npz_needs_no_pickle(pressed, tmp_path):
    out = export(pressed[1], "npz", tmp_path / "t.npz", frame=2)
    with np.load(out, allow_pickle=False) as table:
        check_table(dict(table), pressed[1], [2])


def test_what_a_ply_lacks_is_left_empty(pressed):
    low, high = pressed[0].plies[:2]
    columns = _joined([_rows(replace(low, curvature=None)), _rows(high)])
    assert list(columns) == list(_rows(high))
    assert _text(columns["warp_curvature_per_m"].tolist()[0]) == ""
    assert _text(columns["warp_curvature_per_m"].tolist()[-1]) != ""


def read_with_pandas(path):
    """A table with words for plies and numbers for all else: in CSV no type is written down."""
    pandas = pytest.importorskip("pandas")
    types = pandas.api.types
    read = {".csv": pandas.read_csv, ".parquet": pandas.read_parquet}[path.suffix](path)
    number = types.is_float_dtype if path.suffix == ".parquet" else types.is_numeric_dtype
    kinds = {"ply": types.is_string_dtype}
    kinds |= dict.fromkeys(("frame", "triangle"), types.is_integer_dtype)
    for name, values in read.items():
        assert kinds.get(name, number)(values.dtype), (name, values.dtype)
    return read


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_pandas_reads_all_frames_with_numbers_as_numbers(kind, pressed, tmp_path):
    out = export(pressed[1], kind, tmp_path / f"t.{kind}", frame="all")
    read = read_with_pandas(out)
    check_table(read, pressed[1], range(5))
    assert read.notna().all(axis=None)
    last = read[read["frame"] == 4].groupby("ply")
    for ply in pressed[0].plies:  # as one works with it
        assert last["shear_angle_deg"].apply(lambda angles: angles.abs().max())[
            ply.name
        ] == pytest.approx(ply.max_shear_deg, rel=1e-6)
        flat = np.prod(np.ptp(ply.rest_points, axis=0)[:2])
        assert last["area_m2"].sum()[ply.name] == pytest.approx(flat, rel=0.1)


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_pandas_sees_what_a_ply_lacks_as_missing(kind, pressed, tmp_path):
    """And still as numbers: one text among them would make a column of texts."""
    low, high = pressed[0].plies[:2]
    parts = []
    for ply in (replace(low, curvature=None), high):
        rows = _rows(ply)
        count = len(rows["triangle"])
        parts.append({"frame": np.full(count, 4), "ply": np.full(count, ply.name)} | rows)
    path = tmp_path / f"t.{kind}"
    {"csv": _write_csv, "parquet": _write_parquet}[kind](path, _joined(parts))
    read = read_with_pandas(path)
    missing = read["weft_curvature_per_m"].isna().to_numpy()
    np.testing.assert_array_equal(missing, (read["ply"] == low.name).to_numpy())
    assert (
        read.drop(columns=["warp_curvature_per_m", "weft_curvature_per_m"]).notna().all(axis=None)
    )

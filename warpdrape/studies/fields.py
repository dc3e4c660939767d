"""What maps need of a run: shear and wrinkles of every triangle on the flat blank."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.results.read_run import RunReader
from warpdrape.results.run_folder import write_whole


@dataclass(frozen=True, eq=False)
class PlyFields:
    """A ply at the end of a run, on its flat blank.

    Attributes:
        name: of the ply.
        rest: the flat blank [m], shape [n, 2].
        triangles: vertices, shape [m, 3].
        shear_deg: signed shear angle [deg], shape [m].
        wrinkle: local amplitude of wrinkles [m], shape [m].
        locking_deg: the fabric's locking angle [deg]; NaN where its card has none.
    """

    name: str
    rest: np.ndarray
    triangles: np.ndarray
    shear_deg: np.ndarray
    wrinkle: np.ndarray
    locking_deg: float


def keep_fields(folder: Path, path: Path, *, wanted: bool = True) -> None:
    """Write what maps need of a run folder, in single precision as the animation has it.

    Args:
        folder: the run folder.
        path: file to write, in one move.
        wanted: whether at all.
    """
    if not wanted or path.exists():
        return
    reader = RunReader(folder)
    result = reader.result()
    arrays: dict[str, Any] = {"plies": np.array([ply.name for ply in result.plies])}
    for k, (ply, entry) in enumerate(zip(result.plies, reader.summary["plies"], strict=True)):
        locking = entry.get("defects", {}).get("shear", {}).get("locking_angle_deg")
        wrinkle = np.zeros(len(ply.triangles)) if ply.wrinkle is None else ply.wrinkle
        arrays |= {
            f"{k}_rest": ply.rest_points[:, :2].astype(np.float32),
            f"{k}_triangles": ply.triangles.astype(np.int32),
            f"{k}_shear_deg": ply.shear_angle_deg.astype(np.float32),
            f"{k}_wrinkle": np.asarray(wrinkle, np.float32),
            f"{k}_locking_deg": np.array(np.nan if locking is None else locking),
        }

    def write(partial: Path) -> None:
        with partial.open("wb") as file:
            np.savez_compressed(file, **arrays)

    write_whole(path, write)


def read_fields(path: Path) -> list[PlyFields]:
    """Read them back; raise `InputError` where the file is damaged."""
    try:
        with np.load(path, allow_pickle=False) as held:
            return [
                PlyFields(
                    name=str(name),
                    rest=held[f"{k}_rest"].astype(float),
                    triangles=held[f"{k}_triangles"],
                    shear_deg=held[f"{k}_shear_deg"].astype(float),
                    wrinkle=held[f"{k}_wrinkle"].astype(float),
                    locking_deg=float(held[f"{k}_locking_deg"]),
                )
                for k, name in enumerate(held["plies"])
            ]
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise InputError(
            f"{path} is damaged ({error}): remove it and start the study again"
        ) from error

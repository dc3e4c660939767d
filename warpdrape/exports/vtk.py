"""VTK for ParaView: a ``.pvd`` that lists a ``.vtp`` a ply, and a tool, at every frame.

The pieces lie in a folder beside the file, ``scene_vtp`` for ``scene.pvd``. A tool that stands
still, or has not moved since the frame before, is written once.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from warpdrape.results.pyvista_mesh import needed, ply_mesh, tool_mesh
from warpdrape.results.read_run import RunReader
from warpdrape.results.run_folder import give_final_name, partial_path

HEAD = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
TAIL = "</Collection>\n</VTKFile>\n"


def write(reader: RunReader, out: Path, frames: Sequence[int]) -> None:
    """Write frames.

    Args:
        reader: the run.
        out: the ``.pvd`` to write.
        frames: their numbers.
    """
    needed("pyvista", "vtk")
    stem = out.name.removeprefix(".").split(".")[0]
    folder = out.parent / f"{stem}_vtp"
    folder.mkdir(exist_ok=True)
    lines: list[str] = []
    standing: dict[str, tuple[np.ndarray, str]] = {}
    for frame in frames:
        result = reader.result(frame)
        parts = []
        for ply in result.plies:
            mesh = ply_mesh(ply)
            mesh.field_data["time_s"] = [result.time_s]
            parts.append((ply.name, _save(mesh, folder / f"{ply.name}_{frame:04d}.vtp")))
        for tool in result.tools:
            before, file = standing.get(tool.name, (np.empty(0), ""))
            if before.shape != tool.vertices.shape or (before != tool.vertices).any():
                file = _save(tool_mesh(tool), folder / f"{tool.name}_{frame:04d}.vtp")
                standing[tool.name] = tool.vertices, file
            parts.append((tool.name, file))
        lines += [_entry(result.time_s, k, name, file) for k, (name, file) in enumerate(parts)]
    out.write_text(HEAD + "".join(lines) + TAIL, encoding="utf-8")


def _save(mesh, path: Path) -> str:
    """Write a piece whole or not at all; return its path as the list has it."""
    partial = partial_path(path)
    mesh.save(partial)
    give_final_name(partial, path)
    return f"{path.parent.name}/{path.name}"


def _entry(time: float, part: int, name: str, file: str) -> str:
    return (
        f'<DataSet timestep="{time!r}" group="" part="{part}" name={quoteattr(name)} '
        f"file={quoteattr(file)}/>\n"
    )

"""VTK for ParaView: a ``.pvd`` that lists a ``.vtp`` for each ply at every frame; tools likewise.

For ``scene.pvd`` the tools' list is ``scene_tools.pvd``, so that they can be hidden, and the pieces
lie in ``scene_vtp``. A tool that has not moved since the frame before is written once.
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
    plies: list[str] = []
    tools: list[str] = []
    standing: dict[str, tuple[np.ndarray, str]] = {}
    for frame in frames:
        result = reader.result(frame)
        for part, ply in enumerate(result.plies):
            mesh = ply_mesh(ply)
            mesh.field_data["TimeValue"] = [result.time_s]
            file = _save(mesh, folder / f"{ply.name}_{frame:04d}.vtp")
            plies.append(_entry(result.time_s, part, ply.name, file))
        for part, tool in enumerate(result.tools):
            before, file = standing.get(tool.name, (np.empty(0), ""))
            if not np.array_equal(before, tool.vertices):
                file = _save(tool_mesh(tool), folder / f"{tool.name}_{frame:04d}.vtp")
                standing[tool.name] = tool.vertices, file
            tools.append(_entry(result.time_s, part, tool.name, file))
    if tools:
        _write_list(out.with_name(f"{stem}_tools.pvd"), tools)
    out.write_text(HEAD + "".join(plies) + TAIL, encoding="utf-8")


def _write_list(path: Path, entries: Sequence[str]) -> None:
    partial = partial_path(path)
    partial.write_text(HEAD + "".join(entries) + TAIL, encoding="utf-8")
    give_final_name(partial, path)


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

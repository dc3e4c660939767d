"""Digests, in place of what is too long to write down: meshes, surfaces, tables, sources."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.tools.tool import Tool


def plain(value: Any) -> Any:
    """Records as JSON takes them."""
    if dataclasses.is_dataclass(value):
        record = {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return {"type": type(value).__name__, **record}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return value


def digest(*values: Any) -> str:
    """Of arrays by type, shape and bytes; of all else by its JSON."""
    found = hashlib.blake2b(digest_size=12)
    for value in values:
        if isinstance(value, np.ndarray):
            array = np.ascontiguousarray(value)
            found.update(f"{array.dtype.str}{array.shape}".encode())
            found.update(array.tobytes())
        else:
            found.update(json.dumps(plain(value), sort_keys=True, default=repr).encode())
    return f"#{found.hexdigest()}"


def is_digest(value: Any) -> bool:
    """Whether an entry is one."""
    return isinstance(value, str) and value.startswith("#")


def mesh_digest(ply: Ply) -> str:
    """Of a ply's flat mesh."""
    return digest(ply.mesh.vertices, ply.mesh.triangles)


def surface_digest(tool: Tool) -> str:
    """Of a tool's facets and their normals, as contact knows them."""
    return digest(tool.vertices, tool.triangles, np.asarray(tool.surface.normals))

"""The tables by name: each with its page and what makes it."""

from __future__ import annotations

from collections.abc import Callable

import dimensions
from approaches import continua, continua_45, yarns_hemisphere, yarns_per_bar
from bending import bending_drape, bending_hemisphere
from hemisphere import hemisphere_diagonal, hemisphere_outline
from press import (
    double_dome_fabrics,
    double_dome_part,
    shapes,
    tetrahedron_force,
    two_plies,
    two_plies_drag,
    two_plies_fine,
)
from runs import Runs
from wrinkled_meshes import wrinkle_meshes, wrinkle_runs

TABLES: dict[str, tuple[str, Callable[[Runs], str]]] = {
    **dimensions.tables(),
    "shapes": ("benchmarks.md", shapes),
    "hemisphere_diagonal": ("benchmarks/hemisphere.md", hemisphere_diagonal),
    "hemisphere_outline": ("benchmarks/hemisphere.md", hemisphere_outline),
    "tetrahedron_force": ("benchmarks/tetrahedron.md", tetrahedron_force),
    "double_dome_fabrics": ("benchmarks/double_dome.md", double_dome_fabrics),
    "double_dome_part": ("benchmarks/double_dome.md", double_dome_part),
    "two_plies": ("benchmarks/two_plies.md", two_plies),
    "two_plies_drag": ("benchmarks/two_plies.md", two_plies_drag),
    "two_plies_fine": ("benchmarks/two_plies.md", two_plies_fine),
    "bending_hemisphere": ("benchmarks/bending.md", bending_hemisphere),
    "bending_drape": ("benchmarks/bending.md", bending_drape),
    "continua": ("approaches.md", continua),
    "continua_45": ("approaches.md", continua_45),
    "yarns_hemisphere": ("approaches.md", yarns_hemisphere),
    "yarns_per_bar": ("approaches.md", yarns_per_bar),
    "wrinkle_meshes": ("defects.md", wrinkle_meshes),
    "wrinkle_runs": ("defects.md", wrinkle_runs),
}

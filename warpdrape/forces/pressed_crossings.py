"""What contacts press the crossings of sliding yarns with: data and launches."""

from __future__ import annotations

import numpy as np
import warp as wp
from scipy import sparse

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_chains import YarnChains
from warpdrape.forces.ply_net import net_of
from warpdrape.interaction import Bodies, Launch, Run, Span
from warpdrape.kernels.forces.pressed_crossings import Bearers, compute_pressed
from warpdrape.kernels.forces.yarn_chains import Crossovers
from warpdrape.materials.crossover import Crossover


def bearing(ply: Ply, chains: YarnChains) -> sparse.csr_matrix:
    """Forces on crossings [N] from those through vertices [N], shape [crossover, vertex].

    Whatever goes through the ply goes through its crossings: columns times crossings sum to 1, but
    where a yarn ends on a vertex beside which no cell has a crossing.
    """
    ties, carried = net_of(ply).ties, net_of(ply).carried
    n = len(ply.mesh.vertices)
    ones = sparse.csr_matrix(
        (np.ones(len(carried)), (np.arange(len(carried)), carried)), ties.shape
    )
    by_vertex = (sparse.identity(n, format="csr") + (ones - ties).T @ ones).tocsr()
    crossings = chains.areas / ply.fabric.cell_area
    per_crossing = np.divide(1.0, crossings, where=crossings > 0.0, out=np.zeros(len(crossings)))
    return (sparse.diags(per_crossing) @ by_vertex[chains.vertices]).tocsr()


def bearers_on(
    ply: Ply, law: Crossover, chains: YarnChains, span: Span, device: str
) -> Bearers | None:
    """Put them on a device; None where yarns do not rub where they cross."""
    if law.yarn_friction == 0.0:
        return None
    rows = bearing(ply, chains)
    out = Bearers()
    out.first = wp.array(rows.indptr, dtype=wp.int32, device=device)
    out.vertex = wp.array(rows.indices + span.first_vertex, dtype=wp.int32, device=device)
    out.weight = wp.array(rows.data, dtype=wp.float64, device=device)
    return out


def press_crossings(
    bearers: Bearers | None, crossovers: Crossovers, run: Run, bodies: Bodies
) -> list[Launch]:
    """What comes before the slides of a run of crossovers."""
    if bearers is None or bodies.pressing is None:
        return []
    inputs = [run.first, bearers, bodies.pressing.through]
    return [Launch(compute_pressed, run.count, inputs, [crossovers.pressed])]

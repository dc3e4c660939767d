"""How far a tool reaches through a ply."""

import warp as wp


@wp.kernel(enable_backward=False)
def find_depths(
    points: wp.array(dtype=wp.vec3f),
    tool: wp.uint64,
    shift: wp.vec3f,
    ply: wp.uint64,
    reach: float,
    depth: wp.array(dtype=wp.float32),
    facet: wp.array(dtype=wp.int32),
):
    """How far points of a solid lie beyond a ply that runs inside it; one thread a point.

    Args:
        points: on the tool's surface, in its frame [m].
        tool: its mesh, in its frame, that supports winding numbers.
        shift: its translation [m].
        ply: the ply's mesh where it is now.
        reach: how far to look for the ply [m].
        depth: from the nearest place of the ply, if that lies in the tool [m]; else 0; overwritten.
        facet: the ply's triangle there, else 0; overwritten.
    """
    i = wp.tid()
    depth[i] = 0.0
    facet[i] = 0
    point = points[i] + shift
    near = wp.mesh_query_point_no_sign(ply, point, reach)
    if not near.result:
        return
    place = wp.mesh_eval_position(ply, near.face, near.u, near.v)
    side = wp.mesh_query_point_sign_winding_number(tool, place - shift, 1e6)
    if side.result and side.sign < 0.0:
        depth[i] = wp.length(point - place)
        facet[i] = near.face

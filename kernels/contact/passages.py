"""How far a tool reaches through a ply."""

import warp as wp


@wp.kernel(enable_backward=False)
def find_depths(
    points: wp.array(dtype=wp.vec3f),
    tool: wp.uint64,
    turned: wp.mat33f,
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
        turned: its rotation.
        shift: its translation [m].
        ply: the ply's mesh where it is now.
        reach: how far to look for the ply [m].
        depth: across the ply from its nearest place, if that lies in the tool [m]; else 0;
            overwritten.
        facet: the ply's triangle there, else 0; overwritten.
    """
    i = wp.tid()
    depth[i] = 0.0
    facet[i] = 0
    point = turned * points[i] + shift
    near = wp.mesh_query_point_no_sign(ply, point, reach)
    if not near.result:
        return
    place = wp.mesh_eval_position(ply, near.face, near.u, near.v)
    inside = wp.transpose(turned) * (place - shift)
    side = wp.mesh_query_point_sign_winding_number(tool, inside, 1e6)
    if side.result and side.sign < 0.0:
        # Across the ply alone: what lies aside of its border has not passed through it.
        depth[i] = wp.abs(wp.dot(wp.mesh_eval_face_normal(ply, near.face), point - place))
        facet[i] = near.face


@wp.kernel(enable_backward=False)
def find_gaps(
    points: wp.array(dtype=wp.vec3f),
    normals: wp.array(dtype=wp.vec3f),
    tool: wp.uint64,
    turned: wp.mat33f,
    shift: wp.vec3f,
    reach: float,
    gaps: wp.array(dtype=wp.float32),
):
    """Distance of points of a tool from another that faces them; one thread a point.

    Args:
        points: on a tool's surface [m].
        normals: outward, unit, at the points.
        tool: mesh of the other.
        turned: rotation from the first tool's frame to that of the other, as they are now.
        shift: from the other tool to the first, in the other's frame [m].
        reach: how far to look [m].
        gaps: distance where the surfaces face each other, negative where they overlap [m], else
            ``reach``; overwritten.
    """
    i = wp.tid()
    gaps[i] = reach
    point = turned * points[i] + shift
    near = wp.mesh_query_point_no_sign(tool, point, reach)
    if not near.result:
        return
    facing = wp.mesh_eval_face_normal(tool, near.face)
    if wp.dot(facing, turned * normals[i]) > -0.5:
        return
    offset = point - wp.mesh_eval_position(tool, near.face, near.u, near.v)
    gaps[i] = wp.where(wp.dot(offset, facing) < 0.0, -wp.length(offset), wp.length(offset))

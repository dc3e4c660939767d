"""How far contact searches look ahead: by the speed of what moves fastest now.

A search must see whatever may touch before the next one. The speeds of tools and clamps are known
before the run, and give a least reach; a ply that snaps, or that a pressure throws, is faster. So
every search measures the largest speed of all vertices. What it cannot foresee is speed gained
until the next one: `Pace.outrun` tells whether that was too much.
"""

import warp as wp

from ..sweep import Sweep

ASK_EVERY = wp.constant(16)
"""Contact searches from one in which every point asks for the nearest facet of a ply to the next
such one; between, it walks from the facet that it remembers."""
LOOK_AHEAD = wp.constant(wp.float64(4.0))
"""Way that a search allows for over what the fastest vertex goes until the next one [-]: two may
come towards each other, and a sheet that snaps may double its speed."""


@wp.struct
class Pace:
    """How far searches look for what is fast; zero at first."""

    asks: wp.int32  # 1 if points ask in the coming search
    reach: wp.float64  # distance beyond the thickness that counts as near [m]
    seen: wp.float64  # how far points saw when they last asked [m]
    closed: wp.float64  # how far the fastest vertices have gone since then [m]
    blind: wp.float64  # what they saw at the asking before, if they went farther; else 0 [m]
    outrun: wp.float64  # largest of such a way over what was seen [-]


@wp.func
def sight(thickness: wp.float64, reach: wp.float64) -> wp.float64:
    """How far beyond the thickness a point that asks looks for a ply [m].

    What it does not see must not come near before it asks again.
    """
    until_asked = wp.float64(1 + ASK_EVERY) * reach
    return wp.max(wp.float64(3.0) * thickness + wp.float64(2.0) * reach, until_asked)


@wp.kernel(enable_backward=False)
def forget_speed(part: int, speeds: wp.array(dtype=wp.float64)):
    """Begin to measure the speed of a part's vertices; one thread.

    Args:
        part: of the model.
        speeds: shape [part]; the part's own is cleared.
    """
    speeds[part] = wp.float64(0.0)


@wp.kernel(enable_backward=False)
def find_speed(
    sweep: Sweep, part: int, v: wp.array(dtype=wp.vec3d), speeds: wp.array(dtype=wp.float64)
):
    """Find the largest speed of a part's vertices; a sweep over these.

    Args:
        sweep: numbers of the vertices.
        part: of the model.
        v: velocities [m/s], shape [vertex].
        speeds: shape [part]; the part's own is raised.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        wp.atomic_max(speeds, part, wp.length(v[i]))


@wp.kernel(enable_backward=False)
def say_asking(part: int, paces: wp.array(dtype=Pace)):
    """Say that points ask in this search; one thread.

    Args:
        part: of the model.
        paces: shape [part]; the part's own is told.
    """
    paces[part].asks = 1


@wp.kernel(enable_backward=False)
def set_pace(
    part: int,
    least: wp.float64,
    interval: wp.float64,
    thickness: wp.float64,
    speeds: wp.array(dtype=wp.float64),
    paces: wp.array(dtype=Pace),
):
    """Set how far a part's searches look from now on; one thread.

    Searches allow for two plies that come towards each other. What is told as outrun is the way of
    one towards another at rest, the usual case: plies that are formed go together.

    Args:
        part: of the model.
        least: reach for the speeds of tools and clamps [m].
        interval: time until the next search [s].
        thickness: smallest of mid-surfaces in contact [m].
        speeds: of all parts [m/s], shape [part].
        paces: shape [part]; the part's own is overwritten.
    """
    pace = paces[part]
    speed = wp.float64(0.0)
    for other in range(speeds.shape[0]):
        speed = wp.max(speed, speeds[other])
    way = speed * interval
    pace.closed += way
    if pace.seen > wp.float64(0.0):
        pace.outrun = wp.max(pace.outrun, wp.max(way / pace.reach, pace.closed / pace.seen))
    pace.reach = wp.max(least, LOOK_AHEAD * way)
    if pace.asks == 1:
        pace.asks = 0
        pace.blind = wp.where(pace.closed > pace.seen, pace.seen, wp.float64(0.0))
        pace.closed = wp.float64(0.0)
        pace.seen = sight(thickness, pace.reach)
    paces[part] = pace

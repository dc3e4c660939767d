"""The double dome by two punches, one for each dome: their order and stroke profile are parameters.

One punch may go before the other, by as much as is asked, and each may stand for a while half-way:
it goes to a depth, waits, and goes on. The saddle between the domes has no punch.
"""

from dataclasses import replace

from warpdrape import InputError, Scene, Stages, Stroke, Tool
from warpdrape.scenes.double_dome import build as double_dome

ORDERS = ("together", "left_first", "right_first")


def build(
    *,
    order: str = "together",
    overlap: float = 0.0,
    first_depth: float = 1.0,
    wait: float = 0.1,
    ramp: float = 0.3,
    brake: float = 0.5,
    layup: str = "0",
    cells: int = 24,
    holder_force: float = 100.0,
    friction: float = 0.2,
    fabric: str = "carbon_interlock",
    travel: float = 0.062,
    duration: float = 0.08,
    facet: float = 0.006,
    accuracy: str = "standard",
) -> Scene:
    """Build the double dome with two punches.

    Args:
        order: "together", "left_first" or "right_first", the left punch being that at -x.
        overlap: share of its time that the second punch goes beside the first, below 1 [-].
        first_depth: share of the travel after which a punch waits; 1 for none [-].
        wait: time that it waits there, as a share of its strokes' [-].
        ramp: share of each stroke in which its speed rises [-].
        brake: share of each stroke in which it falls [-].
        layup: warp angle, from x [deg].
        cells: of the mesh along the blank's length.
        holder_force: on the blank holder [N].
        friction: Coulomb coefficient of tools on the ply [-].
        fabric: name or file of a fabric.
        travel: of each punch [m].
        duration: of both punches' strokes, one after the other or not [s].
        facet: size of the tools' facets [m].
        accuracy: "draft", "standard" or "reference": the summary says what it costs.
    """
    parameters = dict(locals())
    if order not in ORDERS:
        raise InputError(f"order = {order!r} must be one of {', '.join(ORDERS)}")
    for name, value, low in (("overlap", overlap, 0.0), ("first_depth", first_depth, 0.05)):
        if not low <= value <= 1.0:
            raise InputError(f"{name} = {value:g} must lie from {low:g} to 1")
    whole = double_dome(
        layup=layup,
        cells=cells,
        holder_force=holder_force,
        friction=friction,
        fabric=fabric,
        travel=travel,
        duration=duration,
        facet=facet,
        accuracy=accuracy,
    )
    shape = whole.parameters
    punch, die, holder = whole.tools
    own = duration if order == "together" else duration / (2.0 - overlap)
    later = duration - own
    punches = []
    for name, side in (("left", -1.0), ("right", 1.0)):
        start = later if order == f"{'right' if name == 'left' else 'left'}_first" else 0.0
        dome = Tool.punch(name, radius=shape["dome_radius"], facet=facet)
        at = (0.5 * side * shape["dome_distance"], 0.0, float(punch.vertices[:, 2].min()))
        motion = profile(travel, start, own, first_depth, wait, ramp, brake)
        punches.append(replace(dome.moved(at), motion=motion))
    return replace(
        whole,
        name="double_dome_stages",
        tools=[*punches, die, holder],
        parameters=parameters,
    )


def profile(
    travel: float,
    start: float,
    duration: float,
    first_depth: float,
    wait: float,
    ramp: float,
    brake: float,
) -> Stroke | Stages:
    """A stroke, or one to a depth, a wait, and the rest: its mean speed is the same in both.

    Args:
        travel: downwards [m].
        start: when it begins [s].
        duration: of all [s].
        first_depth: share of the travel after which it waits; 1 for none [-].
        wait: share of the duration that it waits [-].
        ramp: share of a stroke in which its speed rises [-].
        brake: share of a stroke in which it falls [-].
    """
    shape = {"ramp": ramp, "brake": brake}
    if first_depth == 1.0:
        return Stroke(travel=(0.0, 0.0, -travel), start=start, duration=duration, **shape)
    moving = duration * (1.0 - wait)
    first, second = first_depth * moving, (1.0 - first_depth) * moving
    depth = first_depth * travel
    return Stages(
        strokes=[
            Stroke(travel=(0.0, 0.0, -depth), start=start, duration=first, **shape),
            Stroke(
                travel=(0.0, 0.0, depth - travel),
                start=start + duration - second,
                duration=second,
                **shape,
            ),
        ]
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)

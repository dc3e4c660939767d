"""Coefficients of friction that depend on pressure, slip speed, or the angle between yarns."""

import warp as wp

PRESSURE = wp.constant(0)
SPEED = wp.constant(1)
HERSEY = wp.constant(2)
ANGLE = wp.constant(3)
TABLES = 4
"""Tables of a law, in this order."""
HALVINGS = wp.constant(20)
"""Of the interval that holds a slip, when that decides its own friction: to a millionth."""


@wp.struct
class FrictionLaws:
    """Factors on the coefficients of interfaces, piecewise linear, constant beyond the ends."""

    points: wp.array(dtype=wp.vec2d)  # (pressure [Pa], speed [m/s], η v/p [m] or angle [°], factor)
    first: wp.array(dtype=wp.int32)  # where tables begin, shape [law · TABLES + 1]
    shifted: wp.array(dtype=wp.int32)  # 1 where viscosity shifts with temperature, shape [law]
    shifts: wp.array(dtype=wp.float64)  # by which it grows at vertices [-], shape [vertex]
    warps: wp.array(dtype=wp.vec2d)  # warp yarn by two sides of a triangle [1/m], shape [triangle]
    pace: wp.float64  # slip speed in the process over that of the simulation [-]


@wp.struct
class Rub:
    """Friction of one contact."""

    coefficient: wp.float64  # μ, what depends on the angle included
    law: wp.int32  # number of its law plus one; 0 where the coefficient is all
    viscosity: wp.float64  # η at the temperature of now, 0 where no law has one [Pa·s]


@wp.func
def table_factor(laws: FrictionLaws, law: int, table: int, at: wp.float64) -> wp.float64:
    """Factor of a table of a law; 1 where the law has none.

    Args:
        laws: all laws.
        law: its number.
        table: `PRESSURE`, `SPEED`, `HERSEY` or `ANGLE`.
        at: where.
    """
    first = laws.first[law * TABLES + table]
    last = laws.first[law * TABLES + table + 1] - 1
    if last < first:
        return wp.float64(1.0)
    if at <= laws.points[first][0]:
        return laws.points[first][1]
    k = first
    while k < last and laws.points[k + 1][0] <= at:
        k += 1
    if k == last:
        return laws.points[last][1]
    low = laws.points[k]
    high = laws.points[k + 1]
    return low[1] + (high[1] - low[1]) * (at - low[0]) / (high[0] - low[0])


@wp.func
def friction_coefficient(
    laws: FrictionLaws, rub: Rub, pressure: wp.float64, speed: wp.float64
) -> wp.float64:
    """μ of a contact under a pressure [Pa] at a slip speed of the simulation [m/s].

    Where nothing tells the area of a contact its pressure is below zero and counts for nothing.
    """
    if rub.law == 0:
        return rub.coefficient
    law = rub.law - 1
    in_process = laws.pace * speed
    mu = rub.coefficient * table_factor(laws, law, SPEED, in_process)
    if pressure >= wp.float64(0.0):
        mu *= table_factor(laws, law, PRESSURE, pressure)
        at = wp.float64(0.0)
        if in_process > wp.float64(0.0):
            at = rub.viscosity * in_process / wp.max(pressure, wp.float64(1.0e-30))
        mu *= table_factor(laws, law, HERSEY, at)
    return mu


@wp.func
def shifts_with_heat(laws: FrictionLaws, rub: Rub) -> bool:
    """Whether the viscosity of an interface follows the plies' temperature."""
    if rub.law == 0:
        return False
    return laws.shifted[rub.law - 1] == 1


@wp.func
def at_vertex(laws: FrictionLaws, rub: Rub, i: int) -> Rub:
    """Friction of vertex i on a tool, by the ply's temperature of now."""
    now = Rub()
    now.coefficient = rub.coefficient
    now.law = rub.law
    now.viscosity = rub.viscosity
    if shifts_with_heat(laws, rub):
        now.viscosity *= laws.shifts[i]
    return now


@wp.func
def depends_on_speed(laws: FrictionLaws, law: int) -> bool:
    """Whether a law has a table of speed or Hersey number."""
    first = law * TABLES
    return laws.first[first + SPEED] < laws.first[first + HERSEY + 1]


@wp.func
def bearable(
    laws: FrictionLaws,
    rub: Rub,
    pressure: wp.float64,
    depth: wp.float64,
    length: wp.float64,
    time_step: wp.float64,
) -> wp.float64:
    """Length to which friction can hold a contact's spring in a step [m]; beyond that it slips.

    Where it slips by s the spring keeps what friction at that slip's own speed bears,
    length − s = μ(s/Δt) d: solved for s, so that no law is too steep for the step.

    Args:
        laws: all laws.
        rub: of the contact.
        pressure: on it [Pa], below zero where unknown.
        depth: d, normal force over the spring's stiffness [m].
        length: of the spring if nothing slipped [m].
        time_step: [s].
    """
    holds = friction_coefficient(laws, rub, pressure, wp.float64(0.0)) * depth
    if rub.law == 0 or length <= holds:
        return holds
    if depends_on_speed(laws, rub.law - 1):
        low = wp.float64(0.0)
        high = length
        for _ in range(HALVINGS):
            slip = wp.float64(0.5) * (low + high)
            holds = friction_coefficient(laws, rub, pressure, slip / time_step) * depth
            if length - slip > holds:
                low = slip
            else:
                high = slip
        holds = length - wp.float64(0.5) * (low + high)
    return holds

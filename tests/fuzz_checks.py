"""Public constructors with arguments that are right, and values that are wrong in every way."""

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import trimesh
from law_checks import fabric
from resume_checks import press

import warpdrape as wd
from warpdrape import laws
from warpdrape.blanks.flat_mesh import FlatMesh

CLOTH = fabric(laws.LinearTension(300.0, 350.0), laws.ShearPolynomial((2e-4,)))
SQUARE = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)]
FLAT = {"vertices": SQUARE, "triangles": [(0, 1, 2), (0, 2, 3)]}
PLY = wd.Ply.rectangle("ply_0", CLOTH, 0.1, cells=2)
BOX = trimesh.creation.box((0.05, 0.05, 0.05))
PRESS = press()
SCENE = {
    "name": "scene",
    "plies": PRESS.plies,
    "tools": PRESS.tools,
    "clamps": [wd.Clamp(name="edge", ply="low", where=[0, 1])],
    "duration": 1e-3,
    "friction": 0.2,
    "ply_friction": 0.3,
    "process_duration": 10.0,
    "pressures": [wd.Pressure(name="air", ply="low", pressure=10.0)],
    "springs": [],
    "defects": wd.DefectThresholds(),
    "wanted": [wd.WantedDirection(name="rib", ply="low", direction=(1.0, 0.0, 0.0))],
    "self_contact": True,
    "gravity": (0.0, 0.0, -9.81),
    "numerics": wd.Numerics(),
}
ON = {"mesh": "aligned", "warp_angle": 0.1, "z": 0.0, "fabric": CLOTH, "name": "ply_0"}
MOVING = {"motion": wd.Still(), "friction": 0.2, "name": "tool", "facet": 5e-3}
CALLS = {
    "rectangle": (wd.Ply.rectangle, {**ON, "width": 0.1, "height": 0.1, "cells": 3}),
    "rectangle by edge": (wd.Ply.rectangle, {**ON, "width": 0.1, "edge": 0.03}),
    "disc": (wd.Ply.disc, {**ON, "radius": 0.1, "edge": 0.04}),
    "polygon": (wd.Ply.polygon, {**ON, "points": SQUARE, "holes": [], "edge": 0.04}),
    "random": (wd.Ply.polygon, {**ON, "points": SQUARE, "edge": 0.04, "mesh": "random"}),
    "mesh": (FlatMesh.from_arrays, FLAT),
    "ply": (wd.Ply, {k: ON[k] for k in ("name", "fabric", "z", "warp_angle")} | {"mesh": PLY.mesh}),
    "lay_up": (wd.lay_up, {"plies": [PLY], "z": 0.0}),
    "stack_top": (wd.stack_top, {"plies": [PLY]}),
    "punch": (wd.Tool.punch, {**MOVING, "radius": 0.05, "height": 0.08}),
    "die": (
        wd.Tool.die,
        {**MOVING, "hole_radius": 0.05, "edge_radius": 5e-3, "outer_radius": 0.1, "depth": 0.03},
    ),
    "holder": (
        wd.Tool.blank_holder,
        {
            **MOVING,
            "hole_radius": 0.05,
            "outer_radius": 0.1,
            "edge_radius": 2e-3,
            "sector": (0.0, 1.0),
        },
    ),
    "table": (wd.Tool.table, {**MOVING, "radius": 0.05, "edge_radius": 5e-3, "depth": 0.05}),
    "sphere": (wd.Tool.sphere, {**MOVING, "radius": 0.05}),
    "plate": (wd.Tool.plate, {**MOVING, "width": 0.1, "height": 0.1, "facing": "up"}),
    "drum": (wd.Tool.drum, {**MOVING, "radius": 0.05, "length": 0.1}),
    "from_mesh": (
        wd.Tool.from_mesh,
        {"name": "tool", "source": BOX, "scale": 1.0, "motion": wd.Still(), "friction": 0.2},
    ),
    "moved": (PRESS.tools[1].moved, {"offset": (0.0, 0.0, 0.1)}),
    "turned": (PRESS.tools[1].turned, {"axis": (0.0, 0.0, 1.0), "angle": 0.3}),
    "stroke": (
        wd.Stroke,
        {"travel": (0.0, 0.0, -0.1), "duration": 0.1, "start": 0.0, "ramp": 0.3, "brake": 0.5},
    ),
    "path": (
        wd.Path,
        {"times": [0.0, 0.1, 0.2], "positions": [(0, 0, 0), (0, 0, -0.1), (0, 0.1, -0.1)]},
    ),
    "float": (
        wd.Float,
        {"force": 10.0, "axis": (0, 0, -1), "mass": 0.5, "ramp": 1e-3, "damping": 1.0},
    ),
    "clamp": (
        wd.Clamp,
        {
            "name": "edge",
            "ply": "ply_0",
            "where": [0, 1],
            "motion": wd.Still(),
            "follow": (0.0, 0.0, 1.0),
            "slope": "held",
            "matrix": None,
            "travel": None,
        },
    ),
    "thresholds": (wd.DefectThresholds, vars(wd.DefectThresholds())),
    "wanted": (
        wd.WantedDirection,
        {
            "name": "rib",
            "ply": "low",
            "direction": (1.0, 0.0, 0.0),
            "family": "warp",
            "where": None,
        },
    ),
    "force over time": (wd.Float, {"force": [(0.0, 0.0), (0.1, 10.0)]}),
    "stages": (wd.Stages, {"strokes": [wd.Stroke(travel=(0.0, 0.0, -0.1), duration=0.1)]}),
    "pressure": (
        wd.Pressure,
        {
            "name": "air",
            "ply": "low",
            "pressure": 1e3,
            "side": "upper",
            "ramp": 1e-3,
            "where": None,
        },
    ),
    "spring": (
        wd.Spring,
        {
            "name": "grip",
            "ply": "low",
            "where": [0, 1],
            "to": (0.1, 0.0, 0.0),
            "stiffness": 100.0,
            "preload": 1.0,
            "direction": "fixed",
            "slip_force": None,
            "break_force": 20.0,
        },
    ),
    "friction": (
        wd.Friction,
        {
            "coefficient": 0.3,
            "by_pressure": [(0.0, 0.4), (1e4, 0.2)],
            "by_speed": [(0.0, 0.4), (1.0, 0.2)],
            "by_angle": [(0.0, 0.4), (90.0, 0.2)],
            "source": "a test",
        },
    ),
    "stribeck": (
        wd.Friction,
        {"coefficient": 0.3, "by_hersey": [(0.0, 0.4), (1e-4, 0.2)], "viscosity": 100.0},
    ),
    "numerics": (wd.Numerics, vars(wd.Numerics())),
    "scene": (wd.Scene, SCENE),
    "fabric": (
        wd.Fabric,
        {
            "name": "cloth",
            "areal_density": 0.6,
            "thickness": 6e-4,
            "tension": laws.LinearTension(300.0, 350.0),
            "shear": laws.NoShear(),
            "cell_warp": 1e-3,
            "cell_weft": 1e-3,
            "compressive_factor": 0.01,
            "yarn_angle": math.pi / 2,
            "bending": None,
            "compaction": None,
            "matrix": None,
            "sources": {},
            "description": "",
            "doubts": (),
        },
    ),
    "bending": (wd.Bending, {"warp": 1e-3, "weft": 1e-3, "twist": 1e-4, "coupling": 0.0}),
    "bending curve": (
        wd.BendingCurve,
        {
            "curvatures": (0.0, 20.0, 200.0),
            "moments_warp": (0.0, 4e-3, 2e-2),
            "moments_weft": (0.0, 4e-3, 2e-2),
            "in_plane": (1e-4, 1e-4),
            "twist": 1e-5,
            "friction": (1e-3, 1e-3),
            "friction_curvature": 5.0,
        },
    ),
    "compaction": (
        wd.Compaction,
        {"thicknesses": [6e-4, 5e-4, 4e-4], "pressures": [0.0, 1e4, 1e5]},
    ),
    "linear": (laws.LinearTension, {"warp": 300.0, "weft": 300.0}),
    "table of tensions": (
        laws.TabulatedTension,
        {
            "strain_warp": [0.0, 0.01, 0.02, 0.03],
            "strain_weft": [0.0, 0.01, 0.02, 0.03],
            "tension_warp": [[0.0] * 4, [1.0] * 4, [2.0] * 4, [3.0] * 4],
            "tension_weft": [[0.0, 1.0, 2.0, 3.0]] * 4,
        },
    ),
    "crimp": (
        laws.CrimpInterchange,
        {
            "spacing_warp": 5e-3,
            "spacing_weft": 5e-3,
            "crimp_warp": 4e-3,
            "crimp_weft": 4e-3,
            "stiffness_warp": 34e3,
            "stiffness_weft": 34e3,
        },
    ),
    "polynomial": (laws.ShearPolynomial, {"coefficients": (2e-4, 1e-5)}),
    "table of couples": (
        laws.ShearTable,
        {"angles": (0.0, 0.3, 0.6, 1.0), "couples": (0.0, 1e-4, 2e-4, 9e-4)},
    ),
    "isotropic": (laws.IsotropicMembrane, {"stiffness": 1e5, "poisson": 0.3}),
    "rubber": (laws.MooneyRivlin, {"c10": 2e5, "c01": 1e4, "largest_stretch": 3.0}),
    "rubber sheet": (
        wd.Fabric.rubber,
        {"name": "a", "thickness": 1e-3, "density": 1100.0, "c10": 2e5, "bends": True},
    ),
    "newtonian": (laws.Newtonian, {"viscosity": 1e5}),
    "power law": (
        laws.PowerLaw,
        {"viscosity": 1e6, "exponent": 0.5, "reference_rate": 0.1, "lowest_rate": 0.01},
    ),
    "cross": (laws.Cross, {"at_rest": 1e6, "at_last": 1e4, "time": 10.0, "exponent": 0.7}),
    "arrhenius": (
        laws.Arrhenius,
        {
            "activation_energy": 6e4,
            "reference_temperature": 533.0,
            "lowest_temperature": 463.0,
        },
    ),
    "wlf": (
        laws.WLF,
        {
            "c1": 4.0,
            "c2": 150.0,
            "reference_temperature": 533.0,
            "lowest_temperature": 463.0,
        },
    ),
    "heat": (wd.Heat, {"capacity": 900.0, "conductance": 500.0}),
    "matrix": (
        wd.Matrix,
        {
            "viscosity": laws.Newtonian(1e5),
            "shift": None,
            "rise": (1.0, 0.0),
            "modulus": None,
            "heat": None,
        },
    ),
    "prepreg": (
        wd.Ply,
        {"name": "ply_0", "fabric": "synthetic_prepreg", "mesh": PLY.mesh, "temperature": 520.0},
    ),
    "warm tool": (wd.Tool.sphere, {**MOVING, "radius": 0.05, "temperature": 400.0}),
    "turn": (
        wd.Turn,
        {
            "axis": (0.0, 1.0, 0.0),
            "angle": 1.0,
            "point": (0.0, 0.0, 0.0),
            "duration": 0.01,
            "start": 0.0,
        },
    ),
}
"""Each callable with arguments that it takes."""
HUGE = 10**400
WRONG = [
    10**5000, [10**5000] * 3,
    None, True, False, "text", "", b"x", "1.0", 1j, math.nan, math.inf, -math.inf, 0, -1, 1, 2.5,
    1e-320, 1e-200, 1e-30, 1e-9, 1e9, 1e200, 1e308, HUGE, -HUGE, 2**63, 2**31, -(2**70), [], (), {},
    set(), object(), object, len, lambda *_: HUGE, np.nan, np.float32("inf"), np.int64(-5),
    np.float64(1e300), np.array([1.0, 2.0]), np.array(1.0), np.zeros((2, 2)), np.zeros(0),
    np.array(["a"]), np.array([None]), np.array([1j]), np.array([HUGE], object), Decimal("1.5"),
    Decimal("nan"), Fraction(1, 3), [1, 2, 3], [1, 2], [math.nan] * 3, [math.inf] * 3, [HUGE] * 3,
    [1e200] * 3, [1e-200] * 3, ["a", "b", "c"], [None] * 3, [1j] * 3, [[1, 2, 3]] * 3, [[]] * 3,
    [[HUGE] * 3] * 3, [[math.nan] * 3] * 3, [[1, 2], [3]], [(0, 0), (0, 0), (0, 0)], [0, 0, 0],
    [2, 1, 0], [-1, 0, 1], [0.0, 1e308, -1e308], [0, 1e-320, 1], range(3), "abc", {1: 2}, {"a": 1},
    np.timedelta64(1, "s"), np.datetime64("2020-01-01"), slice(3), Ellipsis, NotImplemented,
    memoryview(b"abc"), wd.Still(), CLOTH, PLY, BOX, [PLY], [PLY, PLY], [None], "a\0b", "../x", "é",
    {("test", "test"): HUGE}, {("test", "test"): -1.0}, "x" * 300, [HUGE, "a"], [True, False],
]  # fmt: skip
"""Values that few arguments can take."""

"""How `tray.step`, `tray.igs`, `tray.stl` and `tray_blank.dxf` of this folder were made.

A tray with drafted walls and rounded edges, drawn for this project: no real product. The body is
the mould, a block with the tray's cavity, its rim flat at z = 0; the drawing is the blank, with a
round locating hole, in its own coordinates as a nesting program leaves them. Needs
`warpdrape[cad,dxf]`; run it in this folder.
"""

import math
from pathlib import Path

import ezdxf
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.GC import GC_MakeArcOfCircle
from OCP.gp import gp_Pnt
from OCP.IGESControl import IGESControl_Writer
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from OCP.StlAPI import StlAPI_Writer
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

LENGTH, WIDTH, DEPTH = 120.0, 80.0, 25.0
"""Of the tray's opening, and its depth [mm]."""
CORNER, DRAFT = 25.0, math.radians(20.0)
"""Radius of its corners in plan [mm], and the draft of its walls."""
RIM_RADIUS, FLOOR_RADIUS = 8.0, 6.0
"""Of the roundings between rim and wall, wall and floor [mm]."""
BLOCK = (220.0, 180.0, 40.0)
"""The mould's block [mm]."""
BLANK, BLANK_CORNER, HOLE = (200.0, 160.0), 10.0, 2.5
"""The blank, the radius of its corners, and that of its hole [mm]."""


def rounded_rectangle(length, width, radius, z):
    """A closed wire of four lines and four arcs at a height [mm]."""
    wire = BRepBuilderAPI_MakeWire()
    x, y = 0.5 * length, 0.5 * width
    for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        middle = (sx * (x - radius), sy * (y - radius))
        first = math.atan2(sy, sx) - 0.25 * math.pi
        on = [
            gp_Pnt(middle[0] + radius * math.cos(a), middle[1] + radius * math.sin(a), z)
            for a in (first, first + 0.25 * math.pi, first + 0.5 * math.pi)
        ]
        nx, ny = (-sy, sx)  # the next corner, counter-clockwise
        away = first + 0.5 * math.pi
        start = gp_Pnt(
            nx * (x - radius) + radius * math.cos(away),
            ny * (y - radius) + radius * math.sin(away),
            z,
        )
        wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(*on).Value()).Edge())
        wire.Add(BRepBuilderAPI_MakeEdge(on[2], start).Edge())
    return wire.Wire()


def mould():
    """The block with the cavity, its edges rounded."""
    x, y, z = BLOCK
    block = BRepPrimAPI_MakeBox(gp_Pnt(-x / 2, -y / 2, -z), gp_Pnt(x / 2, y / 2, 0.0)).Shape()
    inward = DEPTH * math.tan(DRAFT)
    loft = BRepOffsetAPI_ThruSections(True, True)
    loft.AddWire(rounded_rectangle(LENGTH, WIDTH, CORNER, 0.0))
    loft.AddWire(
        rounded_rectangle(LENGTH - 2 * inward, WIDTH - 2 * inward, CORNER - inward, -DEPTH)
    )
    loft.Build()
    body = BRepAlgoAPI_Cut(block, loft.Shape()).Shape()
    fillet = BRepFilletAPI_MakeFillet(body)
    for height, radius in ((0.0, RIM_RADIUS), (-DEPTH, FLOOR_RADIUS)):
        for edge in edges_inside(body, height):
            fillet.Add(radius, edge)
    return fillet.Shape()


def edges_inside(body, height):
    """Edges of the cavity at a height [mm]."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    explorer, found = TopExp_Explorer(body, TopAbs_ShapeEnum.TopAbs_EDGE), []
    while explorer.More():
        edge = getattr(TopoDS, "Edge_s", TopoDS.Edge)(explorer.Current())
        curve = BRepAdaptor_Curve(edge)
        at = [curve.Value(curve.FirstParameter() + s * (curve.LastParameter() - curve.FirstParameter()))
              for s in (0.0, 0.5, 1.0)]
        level = all(abs(p.Z() - height) < 1e-6 for p in at)
        if level and max(abs(p.X()) for p in at) < 0.5 * LENGTH + 1.0:
            found.append(edge)
        explorer.Next()
    return found[::2] if len(found) > 8 else found


def draw_blank(path):
    """The blank as loose lines and arcs, with a hole, in millimetres."""
    (a, b), r = BLANK, BLANK_CORNER
    drawing = ezdxf.new("R2010", units=ezdxf.units.MM)
    space = drawing.modelspace()
    for (x, y), first in (((a - r, b - r), 0), ((r, b - r), 90), ((r, r), 180), ((a - r, r), 270)):
        space.add_arc((x, y), r, first, first + 90)
    for start, end in (((r, 0), (a - r, 0)), ((a, r), (a, b - r)), ((a - r, b), (r, b)), ((0, b - r), (0, r))):
        space.add_line(start, end)
    space.add_circle((12.0, 12.0), HOLE)
    drawing.saveas(path)


if __name__ == "__main__":
    body = mould()
    step = STEPControl_Writer()
    step.Transfer(body, STEPControl_StepModelType.STEPControl_AsIs)
    step.Write("tray.step")
    iges = IGESControl_Writer("MM", 0)
    iges.AddShape(body)
    iges.Write("tray.igs")
    BRepMesh_IncrementalMesh(body, 0.05, False, 0.3)
    StlAPI_Writer().Write(body, "tray.stl")
    draw_blank(Path("tray_blank.dxf"))

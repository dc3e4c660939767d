"""What the scenes of pressed shapes have in common: their parameters, plies, die ring and holder.

Each of them gives its own dimensions; what all take, `Press`, is written here once.
"""

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from typing import Any

import numpy as np

from warpdrape import InputError, Ply, Scene, Tool
from warpdrape.errors import length, positive
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.fabric_library import with_bending
from warpdrape.scenes.press import ACCURACY, BRAKE, ROOM, press_scene, read_layup
from warpdrape.tools.profile import Piece, Surface
from warpdrape.tools.shaped import holder
from warpdrape.tools.sweep import sample_plan
from warpdrape.units import deg, mm

BEYOND = 10 * mm
"""How far die and holder go on beyond the blank's corners."""


@dataclass(frozen=True, kw_only=True)
class Press:
    """What every pressed shape takes besides its own dimensions.

    Attributes:
        layup: warp angles from the die up, one for each ply, from x [deg].
        blank_length: of the blanks along x [m].
        blank_width: of the blanks along y [m].
        cells: squares of four triangles along x.
        travel: punch travel from where it touches the plies; none for the scene's own [m].
        duration: of the stroke; none for that of the accuracy: 40, 80 or 160 ms [s].
        brake: share of the stroke in which the punch slows down, below 1 [-].
        kinetic_limit: kinetic over internal energy above which tools go slower, 0 for none [-].
        holder_force: on the blank holder [N].
        friction: Coulomb coefficient of tools on plies [-].
        ply_friction: Coulomb coefficient between plies [-].
        fabric: name or file of a fabric.
        bending: "fabric" for its own, "none", or a stiffness in all directions [N·m].
        mesh: "grid", "aligned" to the yarns, "diagonal" or "random".
        facet: size of the tools' facets [m].
        contact_share: penalty stiffness over m/Δt² [-].
        contact: "fast", or "exact" to search for every vertex at every step.
        minimum_time_step: mass is added until the stable step reaches it, 0 adds none [s].
        mass_scaling: "plain" on vertices, or "selective" against the stretching of triangles.
        accuracy: "draft", "standard" or "reference": the summary says what it costs.
        fast: another name for the standard accuracy.
        approach: "semi_discrete"; stress as a state, "green_naghdi" or "fibre_frame"; "yarns",
            chains of bars, or "sliding_yarns"; or a net, "fishnet", on the closed tools.
    """

    layup: str = "0"
    blank_length: float = 300 * mm
    blank_width: float = 300 * mm
    cells: int = 30
    travel: float | None
    duration: float | None = None
    brake: float = BRAKE
    kinetic_limit: float = 0.0
    holder_force: float = 100.0
    friction: float = 0.2
    ply_friction: float = 0.3
    fabric: str = "carbon_interlock"
    bending: str = "fabric"
    mesh: str = "grid"
    facet: float = 3 * mm
    contact_share: float = 0.04
    contact: str = "fast"
    minimum_time_step: float = 0.0
    mass_scaling: str = "plain"
    accuracy: str = ACCURACY
    fast: bool = False
    approach: str = "semi_discrete"

    @functools.cached_property
    def angles_deg(self) -> list[float]:
        """Warp angles from the die up [deg]."""
        return read_layup(self.layup)

    @functools.cached_property
    def cloth(self) -> Fabric:
        """The fabric, with the bending asked for."""
        return with_bending(self.fabric, self.bending)

    @property
    def thickness(self) -> float:
        """Of the stack [m]."""
        return len(self.angles_deg) * self.cloth.thickness

    def __post_init__(self) -> None:
        for name in ("blank_length", "blank_width"):
            length(name, getattr(self, name))
        largest = max(self.blank_length, self.blank_width)
        if self.travel is not None and length("travel", self.travel) > largest:
            raise InputError(
                f"travel = {self.travel:.4g} m must not exceed the blank's {largest:.4g} m: give "
                "metres, as in 75 * mm"
            )

    def plies(self) -> list[Ply]:
        """The blanks, from the die up."""
        blank = {"cells": self.cells, "mesh": self.mesh}
        return [
            Ply.rectangle(
                f"ply_{k}",
                self.cloth,
                self.blank_length,
                self.blank_width,
                warp_angle=angle * deg,
                **blank,
            )
            for k, angle in enumerate(self.angles_deg)
        ]

    def room(self, clearance: float) -> float:
        """Room between punch and die: the clearance asked for, but what the stack needs [m]."""
        return max(positive("clearance", clearance, unit="m", zero=True), ROOM * self.thickness)

    def outer_radius(self, plan: list[Piece], edge_radius: float) -> float:
        """Radius of die and holder [m]: the whole blank lies on them.

        Args:
            plan: outline of the die's opening.
            edge_radius: of the die's edge [m].

        Raises:
            InputError: unless the blank reaches over the opening on all sides.
        """
        at, out = sample_plan(plan, self.facet)
        reach = np.abs(at + edge_radius * out).max(axis=0)
        for name, least, given in zip(
            ("blank_length", "blank_width"),
            2.0 * reach,
            (self.blank_length, self.blank_width),
            strict=True,
        ):
            if given <= least:
                raise InputError(
                    f"{name} = {given:.4g} m must exceed the die's opening with its rounded edge, "
                    f"{least:.4g} m, so that the holder has something to hold"
                )
        return float(np.hypot(0.5 * self.blank_length, 0.5 * self.blank_width)) + BEYOND


def pressed(**defaults: Any) -> Callable[[Callable[..., Scene]], Callable[..., Scene]]:
    """Give a scene's ``build`` the parameters of `Press` in place of its own ``press``.

    Args:
        defaults: of this shape, where they are not those of `Press`; a travel of None where it
            hangs on the stack.
    """
    described = inspect.getdoc(Press).partition("Attributes:\n")[2]

    def around(build: Callable[..., Scene]) -> Callable[..., Scene]:
        own = inspect.signature(build)
        shape = [p for p in own.parameters.values() if p.name != "press"]
        shared = [_parameter(field, defaults) for field in fields(Press)]
        signature = own.replace(parameters=[*shape, *shared])

        @functools.wraps(build)
        def built(**given: Any) -> Scene:
            call = signature.bind(**given)
            call.apply_defaults()
            values = dict(call.arguments)
            dimensions = {p.name: values[p.name] for p in shape}
            if values["travel"] is None:
                values["travel"] = defaults["travel"]
            press = Press(**{p.name: values[p.name] for p in shared})
            return build(**dimensions, press=press)

        built.__signature__ = signature
        built.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
        own_lines = inspect.getdoc(build).partition("\n    press:")[0]
        built.__doc__ = f"{own_lines}\n{described}"
        return built

    return around


def _parameter(field: Any, defaults: dict[str, Any]) -> inspect.Parameter:
    default = defaults.get(field.name, field.default)
    if default is MISSING:
        raise TypeError(f"pressed() needs {field.name}")
    return inspect.Parameter(
        field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=field.type
    )


def shape_scene(
    name: str,
    press: Press,
    shape: dict[str, float],
    *,
    punch: Surface,
    die: Surface,
    plan: list[Piece],
    edge_radius: float,
) -> Scene:
    """Put the tools of a shape on the press, with a holder round the die's opening.

    Args:
        name: of the scene.
        press: what all shapes take.
        shape: the scene's own parameters, for ``run.json``.
        punch: pointing down, its lowest point at z = 0.
        die: facing up, its flat at z = 0.
        plan: outline of the die's opening.
        edge_radius: of the die's edge [m].
    """
    outer = press.outer_radius(plan, edge_radius)
    ring = holder(plan, edge_radius, outer, press.facet)
    tools = (
        Tool(name="punch", surface=punch),
        Tool(name="die", surface=die),
        Tool(name="holder", surface=ring),
    )
    return press_scene(
        name,
        press.plies(),
        tools,
        {**shape, **{field.name: getattr(press, field.name) for field in fields(Press)}},
        press.friction,
        press.ply_friction,
    )

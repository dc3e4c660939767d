"""The air round plies, which takes heat from faces that nothing covers."""

from __future__ import annotations

from dataclasses import dataclass

from warpdrape.errors import positive
from warpdrape.materials.viscosity import check_temperature
from warpdrape.wording import brief


@dataclass(frozen=True, kw_only=True)
class Air:
    """The air, and what else plies radiate to, at one temperature.

    It takes heat from faces of plies near which there is neither tool nor ply: by convection, and
    by radiation as the plies' emissivity says.

    Attributes:
        temperature: [K].
        convection: heat that passes from a face [W/(m²·K)]; still air takes about 5 to 10.
    """

    temperature: float
    convection: float = 10.0

    __repr__ = brief

    def __post_init__(self) -> None:
        check_temperature("air.temperature", self.temperature)
        positive("air.convection", self.convection, unit="W/(m²·K)", zero=True)

"""What a picture can show of a ply: the quantities of the USD file, in units that people read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpdrape.blanks.triangles import area_percentile
from warpdrape.errors import one_of
from warpdrape.results.tool_distance import TOOL_DISTANCE

STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Leading digits at which a scale ends."""


@dataclass(frozen=True)
class Quantity:
    """A quantity of a ply, per triangle or vertex.

    Attributes:
        title: in words.
        primvar: its name in the file.
        unit: as shown; a sign that follows the number closely, or a word.
        factor: from the file's unit to that.
        signed: shown with its sign; else its size.
        spiky: contact's, which is shown up to its 99th percentile.
        offset: added after the factor.
        from_least: whether a scale begins at the least value; else at zero.
    """

    title: str
    primvar: str
    unit: str
    factor: float
    signed: bool = False
    spiky: bool = False
    offset: float = 0.0
    from_least: bool = False

    def of(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values to show, of those in the file, scalars or vectors."""
        values = self.with_sign(values)
        return values if self.signed else np.abs(values)

    def with_sign(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values in the unit shown, with their sign; of vectors their length."""
        if values.ndim == 2:
            values = np.linalg.norm(values, axis=1)
        return self.factor * values + self.offset if self.offset else self.factor * values

    def scale(self, values: NDArray[np.float64]) -> tuple[float, float]:
        """Ends of a colour scale for values to show."""
        if self.unit == "°":
            return 0.0, max(5.0 * float(np.ceil(values.max() / 5.0 - 1e-9)), 5.0)
        if self.from_least:
            return 10.0 * float(np.floor(values.min() / 10)), 10.0 * float(
                np.floor(values.max() / 10) + 1
            )
        highest = float(np.quantile(values, 0.99) if self.spiky else values.max())
        lowest = min(float(values.min()), 0.0) if self.signed else 0.0
        return -rounded_up(-lowest), rounded_up(highest) or rounded_up(float(values.max())) or 1.0

    def text(self, value: float) -> str:
        """A value with its unit."""
        if self.unit == "°":
            return f"{value:.1f}°"
        return f"{value:.3g} {self.unit}"

    def caption(
        self,
        values: NDArray[np.float64],
        triangles: NDArray[np.int64],
        areas: NDArray[np.float64],
        *,
        short: bool,
    ) -> str:
        """What there is of it on a ply, in a line.

        Args:
            values: to show, by triangle or vertex.
            triangles: vertices, shape (m, 3).
            areas: of the triangles.
            short: leave the title out.
        """
        over = values if len(values) == len(triangles) else values[triangles].mean(axis=1)
        largest, most = self.text(values.max()), self.text(area_percentile(over, areas, 0.95))
        if short:
            return f"up to {largest}, 95 % below {most}"
        return f"{self.title} up to {largest}, 95 % of the area below {most}"


def rounded_up(value: float) -> float:
    """The next round number from a value on; zero for zero and below."""
    if value <= 0.0:
        return 0.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * min(step for step in STEPS if step * power >= value * (1.0 - 1e-9)))


QUANTITIES = {
    "shear": Quantity("shear angle", "shearAngle", "°", 1.0),
    "warp-strain": Quantity("warp strain", "warpStrain", "%", 100.0, signed=True),
    "weft-strain": Quantity("weft strain", "weftStrain", "%", 100.0, signed=True),
    "warp-tension": Quantity("warp tension", "warpTension", "N/mm", 1e-3, signed=True),
    "weft-tension": Quantity("weft tension", "weftTension", "N/mm", 1e-3, signed=True),
    "warp-curvature": Quantity("warp curvature", "warpCurvature", "1/m", 1.0),
    "weft-curvature": Quantity("weft curvature", "weftCurvature", "1/m", 1.0),
    "slip": Quantity("slip", "slip", "mm", 1e3),
    "warp-slide": Quantity("slide of the warp", "warpSlide", "mm", 1e3),
    "weft-slide": Quantity("slide of the weft", "weftSlide", "mm", 1e3),
    "contact-pressure": Quantity("contact pressure", "contactPressure", "kPa", 1e-3, spiky=True),
    "tool-pressure": Quantity("tool pressure", "toolPressure", "kPa", 1e-3, spiky=True),
    "temperature": Quantity(
        "temperature", "temperature", "°C", 1.0, offset=-273.15, from_least=True
    ),
    "thickness": Quantity("thickness", "thickness", "mm", 1e3),
    "fibre-volume": Quantity("fibre volume fraction", "fibreVolumeFraction", "%", 100.0),
    "wrinkle": Quantity("wrinkle amplitude", "wrinkle", "mm", 1e3),
    "tool-distance": Quantity("distance from the nearest tool", TOOL_DISTANCE, "mm", 1e3),
}
"""By the name that a user gives."""


def quantity_named(name: str) -> Quantity:
    """The quantity of a name; `InputError` with the nearest one where there is none."""
    return QUANTITIES[one_of("field", name, QUANTITIES)]

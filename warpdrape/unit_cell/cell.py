"""A unit cell: the weave, its yarns' sizes and stiffnesses, and whether these go together."""

from __future__ import annotations

import math
from dataclasses import dataclass

from warpdrape.errors import InputError, length, one_of, positive
from warpdrape.materials.fabric import MOST_FIBRES
from warpdrape.unit_cell.compaction import YarnCompaction
from warpdrape.unit_cell.path import amplitude_of, crimp_of
from warpdrape.unit_cell.weave import Weave

FAMILIES = ("warp", "weft")
SECTIONS = {"lens": 1.0, "ellipse": 0.5}
"""A section's height over its largest is (1 − ξ²) to this power, ξ from −1 to 1 across it."""
AREAS = {"lens": 2.0 / 3.0, "ellipse": math.pi / 4.0}
"""A section's area over width times height [-]."""
HEIGHT_ERROR = 0.02
"""By how much two crimps may miss the height that the yarns have [-]."""

FULLEST = 0.97 * MOST_FIBRES
"""Share of fibres in a section that leaves nothing to be squeezed [-]."""
Pair = tuple[float, float]
"""Of the warp, of the weft."""


@dataclass(frozen=True, kw_only=True)
class UnitCell:
    """Yarns of a regular weave; pairs are of warp and weft.

    Attributes:
        weave: which yarn lies over which.
        spacing: between neighbouring yarns of the family [m].
        width: of a yarn, across it [m].
        height: of a yarn, through the thickness [m].
        stiffness: EA of a straight yarn [N].
        bending: B of a yarn, out of the ply's plane [N·m²].
        compaction: how sections resist being squeezed.
        crimp: a yarn's length over that of its cells, less one [-]; None to follow from the rest.
        section: "lens" or "ellipse".
        friction: between yarns [-].
        sticking_angle: rotation over which friction at a crossover builds up [rad].
        slack: stiffness of a yarn that is compressed along itself over EA [-].
    """

    weave: Weave
    spacing: Pair
    width: Pair
    height: Pair
    stiffness: Pair
    bending: Pair
    compaction: YarnCompaction
    crimp: tuple[float | None, float | None] = (None, None)
    section: str = "lens"
    friction: float = 0.0
    sticking_angle: float = math.radians(1.0)
    slack: float = 0.01

    def __post_init__(self) -> None:
        for name, unit in (("stiffness", "N"), ("bending", "N·m²")):
            for family, value in zip(FAMILIES, getattr(self, name), strict=True):
                positive(f"{name}_{family}", value, unit=unit)
        for name in ("spacing", "width", "height"):
            for family, value in zip(FAMILIES, getattr(self, name), strict=True):
                length(f"{name}_{family}", value)
        for family, width, spacing in zip(FAMILIES, self.width, self.spacing, strict=True):
            if width >= spacing:
                raise InputError(
                    f"width_{family} = {1e3 * width:.4g} mm must be below spacing_{family} = "
                    f"{1e3 * spacing:.4g} mm: yarns of a family lie side by side"
                )
        one_of("section", self.section, SECTIONS)
        positive("friction", self.friction, zero=True)
        if not 0.0 < positive("sticking_angle", self.sticking_angle, unit="rad") < 0.5:
            raise InputError(
                f"sticking_angle = {math.degrees(self.sticking_angle):.4g}° must be below 29°"
            )
        if not 0.0 < positive("slack", self.slack) <= 1.0:
            raise InputError(f"slack = {self.slack} must lie in 0 … 1")
        _ = self.amplitudes  # says what does not fit

    @property
    def cell(self) -> Pair:
        """Length of the unit cell along warp and weft [m]: the spacing of the other family."""
        return self.spacing[1], self.spacing[0]

    @property
    def changes(self) -> Pair:
        """Share of its spacings over which a warp, a weft yarn changes sides [-]."""
        shares = []
        for signs in (self.weave.signs, self.weave.weft_signs()):
            n = len(signs)
            shares.append(sum(signs[k] != signs[(k + 1) % n] for k in range(n)) / n)
        return shares[0], shares[1]

    @property
    def sections(self) -> Pair:
        """Area of a yarn's section [m²]."""
        w, h = self.width, self.height
        return AREAS[self.section] * w[0] * h[0], AREAS[self.section] * w[1] * h[1]

    @property
    def amplitudes(self) -> Pair:
        """Height of a warp, a weft yarn's middle line above the ply's at a crossover [m].

        Together half of both yarns' heights, so that they touch. Shared by the crimps, where these
        are given; else each yarn waves by half of the height of those that it crosses.

        Raises:
            InputError: the crimps need other heights.
        """
        total = 0.5 * (self.height[0] + self.height[1])
        wanted = [
            None if c is None else amplitude_of(c, self.cell[k], self.width[1 - k], self.changes[k])
            for k, c in enumerate(self._checked_crimps())
        ]
        first, second = wanted
        if first is not None and second is not None:
            needed = first + second
            if abs(needed / total - 1.0) > HEIGHT_ERROR:
                shown = [
                    f"crimp_{f} = {_percent(c)}" for f, c in zip(FAMILIES, self.crimp, strict=True)
                ]
                raise InputError(
                    f"{' and '.join(shown)} need heights of {2e3 * needed:.4g} mm together, "
                    f"height_warp and height_weft are {2e3 * total:.4g} mm: correct one, or leave "
                    "one crimp out"
                )
            return first * total / needed, second * total / needed
        if first is not None:
            return first, self._rest(0, first, total)
        if second is not None:
            return self._rest(1, second, total), second
        return 0.5 * self.height[1], 0.5 * self.height[0]

    def _rest(self, family: int, given: float, total: float) -> float:
        """What the amplitude of one family leaves the other [m]; `InputError` where nothing."""
        if given < total:
            return total - given
        most = crimp_of(total, self.cell[family], self.width[1 - family], self.changes[family])
        raise InputError(
            f"crimp_{FAMILIES[family]} = {_percent(self.crimp[family])} is more than the "
            f"{_percent(most)} that heights of {2e3 * total:.4g} mm together allow"
        )

    def _checked_crimps(self) -> tuple[float | None, float | None]:
        for family, crimp in zip(FAMILIES, self.crimp, strict=True):
            if crimp is not None and positive(f"crimp_{family}", crimp, zero=True) > 0.5:
                raise InputError(f"crimp_{family} = {crimp} is above 0.5: give 0.4 % as such")
        return self.crimp

    @property
    def crimps(self) -> Pair:
        """Crimp of warp and weft yarns as woven [-]."""
        warp, weft = (
            crimp_of(a, self.cell[k], self.width[1 - k], self.changes[k])
            for k, a in enumerate(self.amplitudes)
        )
        return warp, weft

    @property
    def locking(self) -> float:
        """Shear angle [rad] at which neighbours have no more room than their width: cos γ = w/s.

        Of the family that comes to it first, in a ply that is not stretched.
        """
        return min(math.acos(w / s) for w, s in zip(self.width, self.spacing, strict=True))


def _percent(share: float | None) -> str:
    return "none" if share is None else f"{100 * share:.4g} %"


def fibre_shares(section: str, width: Pair, height: Pair, fibre_areas: Pair) -> Pair:
    """Share of a yarn's section that is fibres, as woven [-].

    Args:
        section: "lens" or "ellipse".
        width: of a warp, a weft yarn [m].
        height: … [m].
        fibre_areas: of the fibres in a warp, a weft yarn [m²].

    Raises:
        InputError: more than round fibres can fill.
    """
    area = AREAS[one_of("section", section, AREAS)]
    warp, weft = (f / (area * w * h) for f, w, h in zip(fibre_areas, width, height, strict=True))
    for family, share in zip(FAMILIES, (warp, weft), strict=True):
        if share >= FULLEST:
            raise InputError(
                f"fibres fill {100 * share:.3g} % of a {family} yarn's section, more than "
                f"{100 * FULLEST:.3g} %: check linear_density, fibre_density, width and height"
            )
    return warp, weft

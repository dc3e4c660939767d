"""Which column of a laboratory's table is which: names in several languages, and units."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

from warpdrape.calibration.lab_units import lab_factor

NAMES: dict[str, Sequence[str]] = {
    "travel": (
        "travel displacement extension crosshead stroke elongation position weg standardweg "
        "traversenweg dehnweg verlängerung deplacement allongement course spostamento"
    ).split(),
    "force": "force load kraft standardkraft zugkraft last effort charge forza carico f".split(),
    "time": "time zeit temps tempo t".split(),
    "specimen": "specimen sample probe prüfling eprouvette provino run nr no id".split(),
    "angle": "angle shear gamma winkel scherwinkel schubwinkel cisaillement γ".split(),
    "strain": "strain dehnung deformation epsilon ε".split(),
    "strain_warp": ("strain warp", "warp strain", "dehnung kette", "epsilon warp", "e1", "ε1"),
    "strain_weft": ("strain weft", "weft strain", "dehnung schuss", "epsilon weft", "e2", "ε2"),
    "force_warp": ("force warp", "warp force", "load warp", "kraft kette", "f1", "fx"),
    "force_weft": ("force weft", "weft force", "load weft", "kraft schuss", "f2", "fy"),
    "overhang": "overhang überhang length länge longueur".split(),
    "curvature": "curvature krümmung courbure k κ".split(),
    "moment": "moment bending m couple biegemoment".split(),
    "thickness": "thickness dicke gap épaisseur spalt h".split(),
    "pressure": "pressure druck stress pression p".split(),
    "friction": ("friction", "coefficient", "mu", "μ", "µ", "reibwert", "cof"),
    "speed": "speed velocity geschwindigkeit vitesse rate".split(),
    "line_force": ("force per width", "shear force", "line force", "schubkraft", "force", "kraft"),
}
"""Column → names under which laboratories have it; the first of a row that fits is taken."""
_UNIT = re.compile(r"^(.*?)\s*[\[(<]\s*([^\[\]()<>]*?)\s*[\])>]\s*$")
_TAIL = re.compile(r"^(.*?)(?:\s+in\s+|\s*[,/]\s*|[\s_]+)(\S+)$")


@dataclass(frozen=True)
class Heading:
    """A column's name and unit, as its header has them.

    Attributes:
        name: without the unit.
        unit: as written, "" where there is none.
        text: the whole header.
    """

    name: str
    unit: str
    text: str


def heading(text: str, below: str = "") -> Heading:
    """Read a header such as "Kraft [N]", "Load (kN)", "Weg in mm" or "force_N".

    Args:
        text: the header.
        below: a unit on a line of its own under it.
    """
    text = " ".join(text.strip().strip('"').split())
    if below:
        return Heading(text, below.strip().strip('[]()<>" '), f"{text} {below}".strip())
    if found := _UNIT.match(text):
        return Heading(found[1], found[2], text)
    if (found := _TAIL.match(text)) and _is_unit(found[2]):
        return Heading(found[1], found[2], text)
    return Heading(text, "", text)


def _is_unit(word: str) -> bool:
    """Whether a word at a header's end is one of the units that stand there without brackets."""
    plain = (
        "mm cm m µm N kN cN mN gf kgf ° deg rad % s ms min kPa MPa Pa bar gf/cm N/m N/mm".split()
    )
    return word in plain or word in ("1/m", "1/cm", "gf·cm/cm", "gf.cm/cm", "mm/min", "mm/s")


def plain(name: str) -> str:
    """A name in lower case, its words apart, without the accents that few type."""
    words = re.sub(r"[\W_]+", " ", name.lower()).strip()
    return "".join(ch if ch in "äöü" else unicodedata.normalize("NFD", ch)[0] for ch in words)


def fit_of(role: str, head: Heading, quantity: str) -> int:
    """How well a column fits a role: 0 not at all; more for whole names than for parts of them."""
    if head.unit and lab_factor(quantity, head.unit) is None:
        return 0
    name = plain(head.name)
    words = name.split()
    for wanted in map(plain, NAMES[role]):
        parts = wanted.split()
        if name == wanted:
            return 4
        if len(parts) > 1 and all(p in words for p in parts):
            return 3
        if len(parts) == 1 and len(wanted) > 2 and wanted in words:
            return 2
        if len(parts) == 1 and len(wanted) > 3 and any(w.startswith(wanted) for w in words):
            return 1
    return 0

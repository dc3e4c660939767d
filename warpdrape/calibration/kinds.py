"""The kinds of test, and what each needs: columns of its table, and values of its set-up."""

from __future__ import annotations

from dataclasses import dataclass, field

FAMILIES = ("warp", "weft")
FACES = ("tool", "ply")


@dataclass(frozen=True)
class Kind:
    """A kind of test.

    Attributes:
        words: what it is called in messages and pictures.
        columns: ways in which its table may be given, each as column → quantity; the first one
            that a table has is taken.
        values: key → quantity of values with a unit that must be given.
        optional: the same of those that may.
        choices: key → the texts that it may have.
        rising: column along which a curve is loaded; "" for readings and loops.
        also: columns that are read where they are there.
    """

    words: str
    columns: tuple[dict[str, str], ...]
    values: dict[str, str] = field(default_factory=dict)
    optional: dict[str, str] = field(default_factory=dict)
    choices: dict[str, tuple[str, ...]] = field(default_factory=dict)
    rising: str = ""
    also: dict[str, str] = field(default_factory=dict)


_PULLED = {"preload": "force", "tare": "force", "compliance": "compliance", "slack": "length"}
_TRAVEL = {"travel": "length", "force": "force"}

KINDS = {
    "picture_frame": Kind(
        "picture frame",
        (_TRAVEL, {"angle": "angle", "force": "force"}),
        {"side": "length"},
        {"sample": "length", "until": "angle", **_PULLED},
        rising="travel",
    ),
    "bias_extension": Kind(
        "bias extension",
        (_TRAVEL, {"angle": "angle", "force": "force"}),
        {"width": "length", "height": "length"},
        {"until": "angle", **_PULLED},
        rising="travel",
    ),
    "shear_loop": Kind(
        "Kawabata shear",
        ({"angle": "angle", "line_force": "force per length"},),
        {},
        {"tension": "force per length"},
    ),
    "uniaxial_tension": Kind(
        "uniaxial tension",
        ({"strain": "ratio", "force": "force"}, _TRAVEL),
        {"width": "length"},
        {"gauge": "length", "until": "ratio", **_PULLED},
        {"family": FAMILIES},
        rising="travel",
    ),
    "biaxial_tension": Kind(
        "biaxial tension",
        (
            {
                "strain_warp": "ratio",
                "strain_weft": "ratio",
                "force_warp": "force",
                "force_weft": "force",
            },
        ),
        {"width": "length"},
    ),
    "cantilever": Kind(
        "cantilever",
        ({"overhang": "length"},),
        {},
        {"angle": "angle"},
        {"family": FAMILIES},
        also={"angle": "angle"},
    ),
    "bending_loop": Kind(
        "Kawabata bending",
        ({"curvature": "curvature", "moment": "moment per width"},),
        {},
        {},
        {"family": FAMILIES},
    ),
    "sled": Kind(
        "sled",
        (_TRAVEL,),
        {"speed": "speed"},
        {
            "normal": "force",
            "pressure": "pressure",
            "area": "area",
            "steady_from": "length",
            "tare": "force",
            "yarns": "angle",
        },
        {"against": FACES},
    ),
    "friction_table": Kind(
        "friction readings",
        ({"pressure": "pressure", "speed": "speed", "friction": "ratio"},),
        {},
        {"yarns": "angle"},
        {"against": FACES},
    ),
    "compaction": Kind(
        "compaction",
        (
            {"thickness": "length", "pressure": "pressure"},
            {"thickness": "length", "force": "force"},
        ),
        {},
        {
            "area": "area",
            "plies": "count",
            "contact_pressure": "pressure",
            "compliance": "compliance",
        },
    ),
}
"""Name in a file of tests → kind."""

ANY = (
    "kind",
    "files",
    "columns",
    "units",
    "delimiter",
    "decimal",
    "empty",
    "toe",
    "weight",
    "note",
)
"""Keys that every test may have."""

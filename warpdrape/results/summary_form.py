"""The form of a run's summary: the entries that anything reads, and what each of them may be.

A summary is checked against it when it is read, so that what reads it may take it for granted, and
a value that no run writes is told by its name.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from warpdrape.results.forms import (
    Form,
    by_name,
    count,
    each,
    either,
    entries,
    flag,
    maybe,
    number,
    one_of,
    text,
    together,
)


def odd_entries(summary: Any) -> list[str]:
    """Names of a summary's entries that no run writes; none for one that is as it should be.

    Entries that nothing reads may be anything.
    """
    odd = list(SUMMARY(summary, ""))
    return odd or [f"reported.{name}" for name in summary["reported"] if name not in summary]


def listed(form: Form, other: str, size: str, most: str) -> Form:
    """Entries that sum up their list: how many are resolved and the largest of these; and others.

    Args:
        form: of the entries.
        other: name of the like entries for those that the mesh does not resolve.
        size: name of what is largest, in the list.
        most: name of the largest, in the entries.
    """

    def of_list(value: Any, name: str) -> Iterator[str]:
        odd = list(form(value, name))
        yield from odd
        for resolved, sums in () if odd else ((True, value), (False, value[other])):
            sizes = [one[size] for one in value["list"] if one["resolved"] is resolved]
            if (sums["number"], sums[most]) != (len(sizes), max(sizes, default=0.0)):
                yield f"{name}.list"

    return of_list


PLACE, ON_BLANK = each(number, 3), each(number, 2)
SPREAD = entries(dict.fromkeys(("min", "mean", "max"), number))
BEGUN = maybe(entries({"time_s": number, "displacement_m": by_name(number)}))
SEEN = {"number": count, "max_amplitude_m": number, "area_share": number, "first": BEGUN}
WRINKLE = entries(
    {
        "at_m": PLACE,
        "on_blank_m": ON_BLANK,
        "axis_on_blank": ON_BLANK,
        "amplitude_m": number,
        "length_m": number,
        "resolved": flag,
    }
)
SHORT, SMALL = "too_short_for_the_mesh", "too_small_for_the_mesh"
WRINKLES = listed(
    entries({**SEEN, SHORT: entries(SEEN), "list": each(WRINKLE)}),
    SHORT,
    "amplitude_m",
    "max_amplitude_m",
)
JUDGED = ("locking_angle_deg", "max_past_deg", "area_share")
SHEAR = entries(
    {
        **dict.fromkeys(JUDGED, maybe(number)),
        "max_at_m": PLACE,
        "max_on_blank_m": ON_BLANK,
    }
)
FAILURE = ("failure_strain", "failed_area_share")
YARN = entries(
    {
        **dict.fromkeys(FAILURE, maybe(number)),
        "max_strain": number,
        "min_strain": number,
        "compressed_area_share": number,
        "max_at_m": PLACE,
        "max_on_blank_m": ON_BLANK,
    }
)
BRIDGE = entries(
    {"tool": text, "gap_m": number, "resolved": flag, "at_m": PLACE, "on_blank_m": ON_BLANK}
)
BRIDGED = {"number": count, "max_gap_m": number, "area_m2": number}
CAVITY = entries(
    {
        "tools": each(text),
        "under_force": flag,
        "area_share": number,
        "thickness_m": SPREAD,
        "fibre_volume_fraction": maybe(SPREAD),
    }
)
MISALIGNED = entries({"name": text, "family": text, "mean_deg": number, "max_deg": number})
DEFECTS = entries(
    {
        "wrinkles": maybe(WRINKLES),
        "shear": together(SHEAR, JUDGED),
        "yarns": entries(dict.fromkeys(("warp", "weft"), together(YARN, FAILURE))),
        "draw_in": entries({"min_m": number, "max_m": number}),
    },
    {
        "misalignment": each(MISALIGNED),
        "bridging": listed(
            entries({**BRIDGED, SMALL: entries(BRIDGED), "list": each(BRIDGE)}),
            SMALL,
            "gap_m",
            "max_gap_m",
        ),
        "cavities": each(CAVITY),
    },
)
PLY = entries(
    {
        "name": text,
        "triangles": count,
        **dict.fromkeys(("max_shear_deg", "p95_shear_deg", "mean_abs_shear_deg"), number),
        **dict.fromkeys(("max_strain_warp", "max_strain_weft"), number),
        "draw_in_m": by_name(maybe(number)),
    },
    {"woven": flag, "fibre_volume_fraction": SPREAD, "defects": DEFECTS},
)
TOOL = entries(
    {
        "name": text,
        "displacement_m": number,
        **dict.fromkeys(("force_n", "max_force_n", "max_penetration_m"), maybe(number)),
    },
    {"max_face_penetration_m": maybe(number), "coverage": number, "angle_deg": number},
)
INTERFACE = entries(
    {
        "vertices_of": text,
        "on": text,
        **dict.fromkeys(("mean_slip_m", "max_slip_m", "mean_pressure_pa"), number),
        "max_pressure_pa": number,
    }
)
OFF = {"p95_shear_deg": number, "draw_in_m": number}
ALWAYS = {
    "status": one_of("completed", "failed"),
    "message": text,
    "warnings": each(text),
    "approach": text,
    "steps": count,
    "triangles": count,
    "simulated_s": number,
    "wall_s": number,
    "plies": each(PLY),
    "tools": each(TOOL),
    "interfaces": each(INTERFACE),
    "reported": each(text),
}
OF_A_NET = entries({**ALWAYS, "not_given": each(text)})
PARTS = ("softer_yarns", "inertia", "soft_contact")
ESTIMATE = entries({**OFF, **dict.fromkeys(PARTS, entries(OFF))})
STEPPED = {
    **ALWAYS,
    "quasi_static": flag,
    "loaded": flag,
    **dict.fromkeys(("energy_error", "kinetic_ratio", "max_penetration_m"), number),
    **dict.fromkeys(("mass_kg", "added_mass_kg", "added_mass_kinetic_ratio"), number),
    **dict.fromkeys(("mass_scaling_order", "yarn_softening", "softening_strain"), number),
    "numerical_error": either("not_known", entries({"not_known": text}), ESTIMATE),
}
PACED = dict.fromkeys(("kinetic_limit", "slowest_pace", "kinetic_over_limit"), number)
MAY_BE = {
    "process_clock": entries(dict.fromkeys(("process_s", "inertia"), number)),
    "kinetic_ratio_loaded": number,
    "mean_softening_strain": number,
}
OF_STEPS = either("kinetic_limit", entries({**STEPPED, **PACED}, MAY_BE), entries(STEPPED, MAY_BE))
SUMMARY = either("not_given", OF_A_NET, OF_STEPS)

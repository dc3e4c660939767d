"""The verdict on a run: which defects are beyond their limits, where, and since when."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpdrape.defects.limits import Limits
from warpdrape.errors import InputError, one_of


@dataclass(frozen=True)
class Fault:
    """A defect beyond its limit.

    Attributes:
        who: name of the ply or tool.
        what: the defect, in words, with its size and limit.
        at: where on the formed ply [m]; None where it has no place.
        on_blank: the same on the flat blank [m].
        since: simulated time from which on it is there [s]; None where that is not recorded.
    """

    who: str
    what: str
    at: Sequence[float] | None = None
    on_blank: Sequence[float] | None = None
    since: float | None = None

    def words(self) -> str:
        """One line: who, what, where, since when."""
        text = f"{self.who}: {self.what}"
        if self.at is not None:
            text += f", at ({', '.join(f'{1e3 * x:.0f}' for x in self.at)}) mm"
        if self.since is not None:
            text += f", since {1e3 * self.since:.3g} ms"
        return text


def judge(
    summary: Mapping[str, Any], history: Mapping[str, np.ndarray], limits: Limits
) -> list[Fault]:
    """Return what is beyond its limits; nothing for a part that is fit.

    Args:
        summary: as in ``summary.json``.
        history: columns over the frames.
        limits: what the part may have.

    Raises:
        InputError: if the run has no defects in its summary, or no tool of a name in the limits.
    """
    if any("defects" not in ply for ply in summary["plies"]):
        raise InputError(
            "the run's summary has no defects: it is of an older version; run it again"
        )
    faults: list[Fault] = []
    for ply in summary["plies"]:
        faults += _wrinkles(ply, history, limits)
        faults += _shear(ply, history, limits)
        if ply.get("woven", True):  # a diaphragm spans the mould beside the part
            faults += _bridges(ply, limits)
        faults += _yarns(summary, ply, limits)
        faults += _misalignment(ply, limits)
    known = [w["name"] for ply in summary["plies"] for w in ply["defects"].get("misalignment", ())]
    for name in limits.misalignment_deg:
        one_of("wanted direction", name, known)
    tools = {tool["name"]: tool.get("coverage", 0.0) for tool in summary["tools"]}
    for name, least in limits.coverage.items():
        one_of("tool", name, tools)
        if tools[name] < least:
            words = f"covered by plies on {_percent(tools[name])}, wanted {_percent(least)}"
            faults.append(Fault(name, words))
    return faults


def not_judged(summary: Mapping[str, Any], limits: Limits) -> list[str]:
    """What could not be judged for want of data, in words."""
    missing: dict[str, list[str]] = {}
    strained = "tensions" not in summary.get("not_given", ())
    for ply in summary["plies"]:
        yarns = ply["defects"]["yarns"].values()
        for wanted, known, words in (
            (
                limits.wrinkle_amplitude,
                ply["defects"]["wrinkles"] is not None,
                "wrinkles (the approach cannot show them)",
            ),
            (
                limits.past_locking_area,
                ply["defects"]["shear"]["area_share"] is not None,
                "shear past locking (no locking_angle in the fabric)",
            ),
            (
                limits.yarn_strain,
                strained,
                "yarn strain (the approach has yarns that do not stretch)",
            ),
            (
                limits.failed_yarn_area,
                strained and all(own["failed_area_share"] is not None for own in yarns),
                "failed yarns (no failure_strain in the fabric)"
                if strained
                else "failed yarns (the approach has yarns that do not stretch)",
            ),
            (
                limits.fibre_volume_fraction,
                "fibre_volume_fraction" in ply,
                "fibre volume fraction (no fibre_density in the fabric)",
            ),
        ):
            if wanted is not None and not known:
                missing.setdefault(words, []).append(ply["name"])
    return [f"{words} of {', '.join(plies)}" for words, plies in missing.items()]


def verdict(faults: Sequence[Fault], unknown: Sequence[str] = ()) -> str:
    """The verdict in words, a line for each fault and for all that was not judged."""
    lines = ["Fit: no defect is beyond its limit"]
    if faults:
        count = f"{len(faults)} defect{'s are' if len(faults) > 1 else ' is'} beyond the limits"
        lines = [f"Unfit: {count}", *(f"  {fault.words()}" for fault in faults)]
    if unknown:
        lines.append(f"  not judged: {'; '.join(unknown)}")
    return "\n".join(lines)


def _wrinkles(
    ply: Mapping[str, Any], history: Mapping[str, np.ndarray], limits: Limits
) -> Iterator[Fault]:
    wrinkles, most = ply["defects"]["wrinkles"], limits.wrinkle_amplitude
    if wrinkles is None:  # of an approach that has none, such as a net
        return
    for resolved, numbers, column in (
        (True, wrinkles, "wrinkle_m"),
        (False, wrinkles["too_short_for_the_mesh"], "short_wrinkle_m"),
    ):
        doubt = "" if resolved else " (too short for the mesh: refine it to be sure)"
        if most is not None and numbers["max_amplitude_m"] > most:
            high = [w for w in wrinkles["list"] if w["amplitude_m"] > most]
            high = [w for w in high if w["resolved"] is resolved]
            noun = "wrinkle" if resolved else "wave"
            words = f"{len(high)} {noun}{'s' if len(high) > 1 else ''}"
            words += f" above {_mm(most)}" if most > 0.0 else ""
            words += f", the largest of amplitude {_mm(high[0]['amplitude_m'])}{doubt}"
            since = _since(history, f"{ply['name']}_{column}", most)
            yield Fault(ply["name"], words, high[0]["at_m"], high[0]["on_blank_m"], since)
        if limits.wrinkle_area is not None and numbers["area_share"] > limits.wrinkle_area:
            allowed = _percent(limits.wrinkle_area)
            words = f"wrinkled on {_percent(numbers['area_share'])}, allowed {allowed}{doubt}"
            yield Fault(ply["name"], words)


def _shear(
    ply: Mapping[str, Any], history: Mapping[str, np.ndarray], limits: Limits
) -> Iterator[Fault]:
    shear = ply["defects"]["shear"]
    place = (shear["max_at_m"], shear["max_on_blank_m"])
    if limits.shear_deg is not None and ply["max_shear_deg"] > limits.shear_deg:
        words = f"shear of {ply['max_shear_deg']:.1f}°, allowed {limits.shear_deg:g}°"
        since = _since(history, f"{ply['name']}_max_shear_deg", limits.shear_deg)
        yield Fault(ply["name"], words, *place, since)
    share, most = shear["area_share"], limits.past_locking_area
    if most is not None and share is not None and share > most:
        angle = shear["locking_angle_deg"]
        words = f"past its locking angle of {angle:.3g}° on {_percent(share)}, by up to "
        words += f"{shear['max_past_deg']:.2g}°"
        since = _since(history, f"{ply['name']}_max_shear_deg", angle)
        yield Fault(ply["name"], words, *place, since)


def _bridges(ply: Mapping[str, Any], limits: Limits) -> Iterator[Fault]:
    for bridge in ply["defects"].get("bridging", {}).get("list", ()):
        if limits.bridge_gap is None or not bridge["resolved"]:
            continue
        if bridge["gap_m"] > limits.bridge_gap:
            words = f"bridges {bridge['tool']} with a gap of {_mm(bridge['gap_m'])}, allowed "
            words += _mm(limits.bridge_gap)
            yield Fault(ply["name"], words, bridge["at_m"], bridge["on_blank_m"])


def _doubt(summary: Mapping[str, Any], past: float) -> str:
    """What to doubt of a yarn strain past its limit; nothing where softening does not explain it.

    Args:
        summary: as in ``summary.json``.
        past: by which the strain exceeds the limit [-].
    """
    softening, owed = (summary.get(name, 0.0) for name in ("yarn_softening", "softening_strain"))
    if softening <= 1.0 or past > owed:
        return ""
    return (
        f" (yarns were softened {softening:.3g} times, which stretches them by up to "
        f"{_percent(owed)} too far: take yarn_softening = 1, in press scenes "
        "accuracy = reference, to be sure)"
    )


def _yarns(summary: Mapping[str, Any], ply: Mapping[str, Any], limits: Limits) -> Iterator[Fault]:
    for family, own in ply["defects"]["yarns"].items():
        if limits.yarn_strain is not None and own["max_strain"] > limits.yarn_strain:
            words = f"{family} strain of {_percent(own['max_strain'])}, allowed "
            words += _percent(limits.yarn_strain)
            words += _doubt(summary, own["max_strain"] - limits.yarn_strain)
            yield Fault(ply["name"], words, own["max_at_m"], own["max_on_blank_m"])
        failed, most = own["failed_area_share"], limits.failed_yarn_area
        if most is not None and failed is not None and failed > most:
            words = f"{family} past its failure strain of {_percent(own['failure_strain'])} on "
            words += _percent(failed)
            words += _doubt(summary, own["max_strain"] - own["failure_strain"])
            yield Fault(ply["name"], words, own["max_at_m"], own["max_on_blank_m"])
    most, volume = limits.fibre_volume_fraction, ply.get("fibre_volume_fraction")
    if most is not None and volume is not None and volume["max"] > most:
        words = f"fibre volume fraction of {_percent(volume['max'])}, allowed {_percent(most)}"
        yield Fault(ply["name"], words)


def _misalignment(ply: Mapping[str, Any], limits: Limits) -> Iterator[Fault]:
    for own in ply["defects"].get("misalignment", ()):
        most = limits.misalignment_deg.get(own["name"])
        if most is not None and own["mean_deg"] > most:
            words = f"{own['family']} off {own['name']} by {own['mean_deg']:.1f}° in the mean, "
            yield Fault(ply["name"], words + f"allowed {most:g}°")


def _since(history: Mapping[str, np.ndarray], column: str, limit: float) -> float | None:
    """Time of the frame from which on a column stays above a limit [s], None if unknown."""
    if column not in history:
        return None
    below = np.flatnonzero(~(history[column] > limit))
    first = 0 if not len(below) else int(below[-1]) + 1
    times = history["time_s"]
    return float(times[first]) if first < len(times) else None


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"

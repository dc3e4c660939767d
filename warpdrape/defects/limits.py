"""What defects a part may have: limits, and the small TOML file that states them."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.errors import InputError, nearest, positive
from warpdrape.materials.fabric_units import si_factor

_QUANTITIES = {
    "wrinkle_amplitude": "length",
    "wrinkle_area": "ratio",
    "shear_deg": "",
    "past_locking_area": "ratio",
    "bridge_gap": "length",
    "yarn_strain": "ratio",
    "failed_yarn_area": "ratio",
    "fibre_volume_fraction": "ratio",
}
_TABLES = ("misalignment_deg", "coverage")
_THRESHOLDS = "thresholds"
_WITH_UNIT = re.compile(r"\s*([-+0-9.eE]+)\s*(\S.*?)\s*")


@dataclass(frozen=True, kw_only=True)
class Limits:
    """The most that a part may have of each defect; None is not judged.

    Without any wrinkle, bridge, shear past locking or failed yarn, by default.

    Attributes:
        wrinkle_amplitude: of any wrinkle [m].
        wrinkle_area: share of a ply that may be wrinkled [-].
        shear_deg: of the shear angle either way [deg].
        past_locking_area: share of a ply past its fabric's locking angle [-].
        bridge_gap: of a ply off a tool that it spans [m].
        yarn_strain: of any yarn, in tension [-].
        failed_yarn_area: share of a ply whose yarns are past their failure strain [-].
        fibre_volume_fraction: anywhere [-].
        misalignment_deg: mean angle of yarns from a wanted direction [deg], by its name.
        coverage: least share of tools' surfaces with a ply on them [-], by the tool's name.
    """

    wrinkle_amplitude: float | None = 0.0
    wrinkle_area: float | None = None
    shear_deg: float | None = None
    past_locking_area: float | None = 0.0
    bridge_gap: float | None = 0.0
    yarn_strain: float | None = None
    failed_yarn_area: float | None = 0.0
    fibre_volume_fraction: float | None = None
    misalignment_deg: Mapping[str, float] = field(default_factory=dict)
    coverage: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in _QUANTITIES:
            value = getattr(self, name)
            if value is not None:
                positive(name, value, zero=True)
        for name in _TABLES:
            if not isinstance(getattr(self, name), Mapping):
                value = getattr(self, name)
                raise InputError(f"{name} = {value!r} must be a table, as {{name = 0.5}}")
        for wanted, angle in self.misalignment_deg.items():
            positive(f"misalignment_deg of {wanted}", angle, zero=True, unit="deg")
        for tool, share in self.coverage.items():
            if positive(f"coverage of {tool}", share, zero=True) > 1.0:
                raise InputError(f"coverage of {tool} = {share} must be a share, at most 1")


def limits_entry(limits: Limits | None) -> dict[str, Any] | None:
    """Limits as a summary has them; None where a scene has set none."""
    if limits is None:
        return None
    found = asdict(limits)
    return found | {name: dict(found[name]) for name in _TABLES}


def limits_of(summary: Mapping[str, Any]) -> Limits:
    """The limits that a run's scene has set; those by default where it has set none.

    Args:
        summary: as in ``summary.json``.

    Raises:
        InputError: if it has others than are known.
    """
    entry = summary.get("limits")
    try:
        return Limits() if entry is None else Limits(**entry)
    except (TypeError, InputError) as error:
        raise InputError(
            f"the run's summary has limits of another version ({error}): give a file of limits"
        ) from error


def read_limits(path: str | os.PathLike[str]) -> Limits:
    """Read a file of limits.

    A number is in SI, or has its unit in a text: ``wrinkle_amplitude = "1 mm"``. A limit that the
    file does not name is not judged. A table ``[thresholds]`` is for `read_thresholds`.

    Args:
        path: the TOML file.

    Raises:
        InputError: it cannot be read, or has an unknown key or an unusable value.
    """
    file = Path(path)
    given = _table_of(file)
    given.pop(_THRESHOLDS, None)
    known = [each.name for each in fields(Limits)]
    for key in given:
        if key not in known:
            raise InputError(
                f"limits {file}: key {key!r} is unknown{nearest(key, [*known, _THRESHOLDS])}"
            )
    values: dict[str, Any] = dict.fromkeys(_QUANTITIES)
    for key, value in given.items():
        values[key] = value if key in _TABLES else _in_si(file, key, value)
    try:
        return Limits(**values)
    except InputError as error:
        raise InputError(f"limits {file}: {error}") from None


def read_thresholds(path: str | os.PathLike[str], run: DefectThresholds) -> DefectThresholds | None:
    """Read the table ``[thresholds]`` of a file of limits: what counts as a defect.

    Args:
        path: the TOML file.
        run: the run's own, which hold where the table says nothing.

    Returns:
        The thresholds; None where the file has no such table.

    Raises:
        InputError: as `read_limits`, of this table.
    """
    file = Path(path)
    given = _table_of(file).get(_THRESHOLDS)
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise InputError(
            f"limits {file}: {_THRESHOLDS} = {given!r} must be a table: write [{_THRESHOLDS}] and "
            "the thresholds below it"
        )
    known = [each.name for each in fields(DefectThresholds)]
    for key in given:
        if key not in known:
            raise InputError(f"limits {file}: threshold {key!r} is unknown{nearest(key, known)}")
    try:
        return replace(run, **given)
    except InputError as error:
        raise InputError(f"limits {file}: {error}") from None


def _table_of(file: Path) -> dict[str, Any]:
    """What a TOML file of limits holds."""
    try:
        return tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(f"limits {file} cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"limits {file}: not valid TOML: {error}") from error


def _in_si(file: Path, key: str, value: Any) -> Any:
    """A value with its unit in a text as a number in SI; others as they are."""
    kind = _QUANTITIES[key]
    found = _WITH_UNIT.fullmatch(value) if isinstance(value, str) and kind else None
    if found is None:
        return value
    factor = si_factor(kind, found[2])
    try:
        number = float(found[1])
    except ValueError:
        return value
    if factor is None:
        raise InputError(f"limits {file}: {key} = {value!r}: {found[2]!r} is no unit of a {kind}")
    return factor * number

"""Parameters of a study: those of the scene, and values of its fabric's card."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

from warpdrape.commands.scene_library import SceneScript
from warpdrape.commands.scene_parameters import Parameter, shown
from warpdrape.errors import InputError, finite, nearest, said
from warpdrape.studies.cards import Card
from warpdrape.studies.distributions import KINDS, Spread, read_spread

_CARD_KEYS = ("card", "relative")
_BAND = re.compile(r"(\d+)\s?% band over [^:]*: ±([^;]*)")
_PERCENT = re.compile(r"([\d.]+(?:[eE][-+]?\d+)?) ?%")


@dataclass(frozen=True)
class Varied:
    """A parameter that differs from run to run.

    Attributes:
        name: column of the table; that of the scene's parameter, where it is one.
        unit: of its values.
        spread: how it varies; None where a list of runs gives its values.
        own: the scene's parameter; None for a value of the card.
        key: dotted key of the card; empty for a scene's parameter.
        relative: whether the card's value is multiplied by it.
    """

    name: str
    unit: str
    spread: Spread | None
    own: Parameter | None = None
    key: str = ""
    relative: bool = False

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers."""
        return self.own is None or (self.own.kind in (float, int) and not self.own.several)

    def at(self, share: float) -> Any:
        """Its value at a share of its distribution [-]."""
        assert self.spread is not None
        whole = self.own is not None and self.own.kind is int
        return self.spread.whole_at(share) if whole else self.spread.at(share)

    def steps(self, count: int) -> list[Any]:
        """So many values of it from end to end; of a whole number each once."""
        assert self.spread is not None
        values = self.spread.steps(count)
        if self.own is not None and self.own.kind is int:
            values = list(dict.fromkeys(map(round, values)))
        return values

    def read(self, given: Any) -> Any:
        """A value as a study writes it, in SI or the card's unit."""
        if self.own is not None:
            return _of_scene(self.own, given)
        return _of_card(self.name, given, "" if self.relative else self.unit)


def exact(value: Any) -> str:
    """A value as ``--set NAME=…`` takes it, to the last bit."""
    if isinstance(value, list | tuple):
        return ",".join(map(exact, value))
    return repr(value) if isinstance(value, float) else shown(value)


def read_parameter(
    name: str, given: Any, script: SceneScript, card: Card | None, *, spread: bool = True
) -> Varied:
    """Read one parameter of a study.

    Args:
        name: of it.
        given: its table in the study file.
        script: the scene.
        card: of the fabric, if the study varies values of it.
        spread: whether the table must say how it varies.

    Raises:
        InputError: naming the parameter and what is wrong.
    """
    if not isinstance(given, Mapping):
        raise InputError(
            f"parameter {name!r}: {said(given)} must be a table, as {{ values = [1] }}"
        )
    known = (*KINDS, *_CARD_KEYS)
    for key in given:
        if key not in known:
            raise InputError(f"parameter {name!r}: {key!r} is unknown{nearest(key, known)}")
    try:
        varied = _bare(name, given, script, card)
        if not spread and not any(kind in given for kind in KINDS):
            return varied
        given = _without_band(given, varied, card)
        found = read_spread(given, varied.read, numeric=varied.numeric)
    except InputError as error:
        words = str(error)
        raise InputError(words if name in words else f"parameter {name!r}: {words}") from None
    return Varied(name, varied.unit, found, varied.own, varied.key, varied.relative)


def _bare(name: str, given: Mapping[str, Any], script: SceneScript, card: Card | None) -> Varied:
    """The parameter without how it varies."""
    if "card" in given:
        if card is None:
            raise InputError(
                f"scene {script.name!r} has no parameter 'fabric' that takes a file, so that no "
                "value of a card can vary"
            )
        if name in script.parameters:
            raise InputError("is a parameter of the scene: call the value of the card otherwise")
        relative = given.get("relative", "band" in given)
        if not isinstance(relative, bool):
            raise InputError(f"relative = {relative!r} must be true or false")
        unit = card.check(str(given["card"]), relative=relative)
        return Varied(name, "-" if relative else unit, None, None, str(given["card"]), relative)
    if "relative" in given or "band" in given:
        raise InputError("relative and band are for values of a card: give card = KEY")
    if name not in script.parameters:
        raise InputError(
            f"scene {script.name!r} has no parameter {name!r}{nearest(name, script.parameters)}"
        )
    own = script.parameters[name]
    return Varied(name, own.unit, None, own)


def _without_band(given: Mapping[str, Any], varied: Varied, card: Card | None) -> Mapping[str, Any]:
    """A confidence band as the normal distribution that has it, about the card's own value.

    ``band = 0.04`` is half the width of a 90 % band over the value; ``band = "card"`` is what
    ``warpdrape calibrate`` wrote beside it.
    """
    if "band" not in given:
        return given
    if not varied.relative:
        raise InputError("band is a share of the card's value: leave relative away, or say true")
    if any(kind in given for kind in KINDS if kind != "band"):
        return given  # one too many: refused where it is read
    level, half = 0.90, given["band"]
    if half == "card":
        assert card is not None
        level, half = band_of(card, varied.key)
    half = finite("band", half)
    if not 0.0 < half < 1.0:
        raise InputError(f"band = {half!r} must be half the band's width over the value, as 0.04")
    sd = half / NormalDist().inv_cdf(0.5 + 0.5 * level)
    low = 1e-3  # a factor of a stiffness stays above zero
    return {"normal": {"mean": 1.0, "sd": sd, "low": low}}


def band_of(card: Card, key: str) -> tuple[float, float]:
    """Level and half width over the value of a card's confidence band [-], the widest if several.

    Raises:
        InputError: if the card says none.
    """
    table = card.table(key)
    words = f"{table.get('doubt', '')}; {table.get('source', '')}"
    found = _BAND.search(words)
    shares = [float(share) for share in _PERCENT.findall(found[2])] if found else []
    if found is None or not shares:
        raise InputError(
            f"band: {key} of {card.named} has no band beside it, as warpdrape calibrate writes: "
            "give a number, as band = 0.04"
        )
    return float(found[1]) / 100.0, max(shares) / 100.0


def _of_scene(own: Parameter, given: Any) -> Any:
    """A value of the scene's parameter, as --set reads it."""
    if isinstance(given, str | bool | int | float):
        return own.read(exact(given))
    if isinstance(given, list):
        return own.read(",".join(map(exact, given)))
    raise InputError(f"{own.name} = {said(given)} must be a number, a text or a list")


def _of_card(name: str, given: Any, unit: str) -> float:
    """A value in the unit that the card has it in; a text may say that unit."""
    if isinstance(given, str):
        number, _, said_unit = given.strip().partition(" ")
        if said_unit.strip() and said_unit.strip() != unit:
            raise InputError(f"{name} = {given!r} must be in the card's unit, {unit or 'none'}")
        try:
            given = float(number)
        except ValueError:
            raise InputError(
                f"{name} = {given!r} must be a number in {unit or 'no unit'}"
            ) from None
    return finite(name, given)

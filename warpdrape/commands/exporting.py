"""Options of an export's format, as the command line gives them: NAME=VALUE."""

from __future__ import annotations

from collections.abc import Sequence

from warpdrape.commands.scene_parameters import Parameter
from warpdrape.errors import InputError, one_of
from warpdrape.exports.formats import FORMATS


def read_options(settings: Sequence[str], **flags: str | None) -> dict[str, float | str]:
    """Read them.

    Args:
        settings: each NAME=VALUE, numbers with a unit or in SI.
        flags: options that have a flag of their own; None where it was not given.

    Raises:
        InputError: if one is unknown, given twice, or no number where one is wanted.
    """
    known = {option.name: option for each in FORMATS.values() for option in each.options}
    options: dict[str, float | str] = {
        name: text for name, text in flags.items() if text is not None
    }
    for setting in settings:
        name, sign, text = setting.partition("=")
        name = name.strip()
        if not sign:
            raise InputError(f"--set {setting} must be NAME=VALUE, such as fibre_diameter=7um")
        option = known[one_of("option", name, known)]
        if name in options:
            raise InputError(f"--set {name} is given twice: give it once")
        reader = Parameter(
            name, option.kind, 7e-6 if option.unit else 2.0, False, f"[{option.unit}]"
        )
        options[name] = reader.read(text.strip())
    return options

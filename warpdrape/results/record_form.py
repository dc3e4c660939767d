"""The form of a run's record: what each entry of ``run.json`` may be that anything reads back.

Records of older versions lack some of them: who needs one says so.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from warpdrape.results.forms import by_name, count, each, entries, maybe, number, text


def odd_entries(record: Any, needed: Collection[str] = ()) -> list[str]:
    """Names of a record's entries that no run writes, or that are needed and not there.

    Args:
        record: of a run.
        needed: entries that must be there, beside the scene's name.
    """
    odd = list(RECORD(record, ""))
    return odd or [name for name in needed if name not in record] or list(_without_fabric(record))


def _without_fabric(record: dict[str, Any]) -> Iterator[str]:
    """Plies whose fabric the record does not have."""
    if "fabrics" in record:
        for number_of, ply in enumerate(record.get("plies", ())):
            if ply["fabric"] not in record["fabrics"]:
                yield f"plies[{number_of}].fabric"


def anything(value: Any, name: str) -> Iterator[str]:
    """Any value: nothing reads what is in it."""
    return iter(())


NAMED = entries({"name": text})
LAID = entries({"name": text, "fabric": text}, {"stabiliser_n_m": maybe(each(number, 2))})
TEXTS = each(text)
CALL = entries({}, {"scene": text, "digest": text, "settings": TEXTS, "extensions": TEXTS})
RECORD = entries(
    {"scene": text},
    {
        "approach": text,
        "script": maybe(text),
        "parameters": by_name(anything),
        "call": CALL,
        "frames": count,
        "device": text,
        "threads": count,
        "numerics": by_name(anything),
        "defect_thresholds": by_name(number),
        "versions": entries({"warpdrape": text}),
        "plies": each(LAID),
        "fabrics": by_name(entries({"name": text, "thickness": number})),
        "tools": each(NAMED),
        "clamps": each(NAMED),
        "pressures": each(by_name(anything)),
        "springs": each(by_name(anything)),
    },
)

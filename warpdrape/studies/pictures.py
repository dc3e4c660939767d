"""Pictures of a study: effects of parameters on measures, and every pair of columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape.results.figures import Figure
from warpdrape.studies.effects import Effect, is_number
from warpdrape.studies.indices import Index
from warpdrape.studies.map_files import FAINT, INK
from warpdrape.studies.table import Table

MOST_PAIRED = 9
"""Columns of the picture of pairs, at most: more cannot be read."""
DOT, LINE = "#8aa0b8", "#b3261e"


def draw_effects(table: Table, found: Sequence[Effect]) -> Figure:
    """A panel for each measure and parameter: a dot a run, and the mean with its standard error.

    Args:
        table: of the study, with a measure that varies.
        found: its effects.
    """
    found = [effect for effect in found if varies(table, effect.measure)]
    measures = list(dict.fromkeys(effect.measure for effect in found))
    parameters = list(dict.fromkeys(effect.parameter for effect in found))
    size = (1.2 + 2.3 * len(parameters), 0.8 + 1.9 * len(measures))
    figure = Figure(figsize=size, dpi=110)
    axes = figure.subplots(
        len(measures), len(parameters), squeeze=False, sharex="col", sharey="row"
    )
    for effect in found:
        row, column = measures.index(effect.measure), parameters.index(effect.parameter)
        _draw_effect(axes[row, column], table, effect)
    for row, name in enumerate(measures):
        axes[row, 0].set_ylabel(name, size=8, color=INK)
    for column, name in enumerate(parameters):
        axes[-1, column].set_xlabel(name, size=8, color=INK)
    figure.tight_layout(h_pad=0.6, w_pad=0.6)
    return figure


def _draw_effect(axes, table: Table, effect: Effect) -> None:
    values = table.numbers(effect.measure)
    given = table.columns[effect.parameter]
    if effect.words:
        places = np.array([_place(effect.words, v) for v in given])
        axes.set_xticks(range(len(effect.words)), effect.words)
    else:
        places = np.array(given, dtype=float)
    axes.plot(places, values, ".", color=DOT, markersize=3.5)
    errors = np.nan_to_num(effect.errors)
    axes.errorbar(effect.levels, effect.means, errors, color=LINE, linewidth=1.4, capsize=2.5)
    plain(axes)
    if np.isfinite(effect.rank):
        axes.set_title(f"rank correlation {effect.rank:+.2f}", size=7, color=FAINT, pad=2)


def _place(words: Sequence[str], value) -> float:
    return words.index(str(value)) if str(value) in words else np.nan


def draw_pairs(table: Table) -> tuple[Figure, list[str]]:
    """Every pair of columns that vary: dots below the diagonal, how often each value on it.

    Returns:
        The figure, and columns that found no room.
    """
    names = [n for n in (*table.parameters, *table.measures) if varies(table, n)]
    shown, left = names[:MOST_PAIRED], names[MOST_PAIRED:]
    n = max(len(shown), 1)
    figure = Figure(figsize=(1.0 + 1.6 * n, 0.8 + 1.6 * n), dpi=110)
    axes = figure.subplots(n, n, squeeze=False)
    for row, below in enumerate(shown):
        for column, above in enumerate(shown):
            each = axes[row, column]
            if column > row:
                each.set_visible(False)
                continue
            plain(each)
            if row == column:
                values = table.numbers(below)
                each.hist(values[np.isfinite(values)], bins=12, color=DOT)
                each.set_yticks([])
            else:
                each.plot(table.numbers(above), table.numbers(below), ".", color=DOT, markersize=3)
            each.tick_params(labelbottom=row == n - 1, labelleft=column == 0 and row > 0)
            if row == n - 1:
                each.set_xlabel(above, size=7, color=INK)
            if column == 0:
                each.set_ylabel(below, size=7, color=INK)
    figure.tight_layout(h_pad=0.3, w_pad=0.3)
    return figure, left


def draw_indices(found: Sequence[Index]) -> Figure:
    """Bars: first-order and total index of each parameter, a panel a measure."""
    measures = list(dict.fromkeys(index.measure for index in found))
    names = list(dict.fromkeys(index.parameter for index in found))
    columns = min(len(measures), 3)
    rows = -(-len(measures) // columns)
    figure = Figure(figsize=(0.5 + 3.4 * columns, 0.6 + (0.8 + 0.35 * len(names)) * rows), dpi=110)
    axes = figure.subplots(rows, columns, squeeze=False)
    for each in axes.flat[len(measures) :]:
        each.set_visible(False)
    for each, measure in zip(axes.flat, measures, strict=False):
        own = [index for index in found if index.measure == measure]
        places, both = np.arange(len(own)), np.isfinite([index.total for index in own]).all()
        for shift, kind, colour in ((-0.2, "first", "#35608d"), (0.2, "total", "#6ba3a0")):
            values = np.array([getattr(index, kind) for index in own])
            errors = np.array([getattr(index, f"{kind}_95") for index in own])
            if np.isfinite(values).all():
                label = "first order" if kind == "first" else "total"
                each.barh(
                    places + shift * both,
                    values,
                    0.36,
                    xerr=errors,
                    color=colour,
                    label=label,
                    error_kw={"linewidth": 0.8},
                )
        each.set_yticks(places, [index.parameter for index in own])
        each.invert_yaxis()
        each.set_title(measure, size=9, color=INK)
        each.axvline(0.0, color=FAINT, linewidth=0.6)
        plain(each)
    axes[0, 0].legend(fontsize=7, frameon=False)
    figure.tight_layout()
    return figure


def varies(table: Table, name: str) -> bool:
    """Whether a column is of numbers, and they differ."""
    column = [v for v in table.columns[name] if v is not None]
    if not is_number(column):
        return False
    values = table.numbers(name)
    values = values[np.isfinite(values)]
    return len(values) > 1 and float(np.ptp(values)) > 0.0


def plain(axes) -> None:
    """Take away what a panel does not need."""
    axes.tick_params(labelsize=7, colors=FAINT, length=2)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)

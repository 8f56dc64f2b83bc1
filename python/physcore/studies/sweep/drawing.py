"""Figures and films of a sweep."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from physcore.checks import word
from physcore.errors import SceneError
from physcore.film import film as film_recordings
from physcore.film.labels.parameters import scale_of, value_text
from physcore.film.writers import WRITERS
from physcore.storage.formats import writable
from physcore.studies.figures import axes_for, save
from physcore.studies.sweep.result import SweepRow, SweepRows, number_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from physcore.film.writers import Film

LINES = 10
"""Largest number of lines in the colors of the default cycle; more have a colormap."""


def distinct(rows: Sequence[SweepRow]) -> dict[str, dict[str, Any]]:
    """The values of each parameter by their texts, in the order in which they occur."""
    return {name: {row.texts[name]: row.parameters[name] for row in rows} for name in rows[0].parameters}


def plot(table: SweepRows, path: str | os.PathLike[str] | None, axes: Axes | None, x: str | None) -> Axes:
    """Plot values against a parameter; see `Sweep.plot`."""
    known = distinct(table.rows)
    along = _along(known) if x is None else word(x, "x", tuple(known))
    lines = _lines(table, along)
    axes = axes_for(path, axes)
    scale, places = scale_of(list(known[along].values())), known[along]
    if scale == "words":
        places = {each: index for index, each in enumerate(places)}
        axes.set_xticks(range(len(places)), list(places))
    for number, (label, rows) in enumerate(lines.items()):
        points = sorted((places[row.texts[along]], number_of(row)) for row in rows)
        color = f"C{number}" if len(lines) <= LINES else _shade(number / (len(lines) - 1))
        axes.plot(*zip(*points, strict=True), "o-", markersize=4, color=color, label=label)
    if scale == "log":
        axes.set_xscale("log")
    failed, (lowest, highest) = [places[row.texts[along]] for row in table.failed], axes.get_ylim()
    if failed:
        axes.plot(failed, [lowest] * len(failed), "x", color="0.3", markersize=8, clip_on=False, label="failed")
    axes.set(xlabel=along, ylabel="value", ylim=(lowest, highest))
    axes.grid(alpha=0.25)
    if len(lines) > 1 or failed:
        axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(axes, path)
    return axes


def film(table: SweepRows, path: str | os.PathLike[str], where: Mapping[str, object], options: dict[str, Any]) -> Film:
    """Film recordings; see `Sweep.film`."""
    writable(path, WRITERS)
    known = distinct(table.rows)
    asked = {word(name, "where", tuple(known)): value_text(value) for name, value in where.items()}
    for name, text in asked.items():
        if text not in known[name]:
            raise SceneError(f"where[{name!r}]: must be one of {', '.join(known[name])}, got {text}")
    rows = [row for row in table.rows if all(row.texts[name] == text for name, text in asked.items())]
    good = [row for row in rows if row.error is None]
    if not good:
        raise SceneError(f"film: every point failed, the first one with {rows[0].error}")
    several = [len(each) for each in distinct(good).values() if len(each) > 1]
    columns = several[-1] if len(several) > 1 and math.prod(several) == len(good) else None
    shown = {"parameters": [row.parameters for row in good], "columns": columns, **options}
    return film_recordings([row.recording for row in good], path, **shown)


def _along(known: dict[str, dict[str, Any]]) -> str:
    """The parameter of the horizontal axis: the first one with several numbers, else the first one."""
    numeric = (name for name, each in known.items() if len(each) > 1 and scale_of(list(each.values())) != "words")
    return next(numeric, next(iter(known)))


def _lines(table: SweepRows, along: str) -> dict[str, list[SweepRow]]:
    """The rows of each line with a value, by the values of all other parameters.

    Raises:
        SceneError: every point failed.
    """
    lines: dict[str, list[SweepRow]] = {}
    for row in table.rows:
        if row.error is None:
            label = ", ".join(f"{name} = {text}" for name, text in row.texts.items() if name != along)
            lines.setdefault(label, []).append(row)
    if not lines:
        raise SceneError(f"plot: every point failed, the first one with {table.rows[0].error}")
    return lines


def _shade(fraction: float) -> Any:
    """A color of the colormap viridis."""
    from matplotlib import colormaps

    return colormaps["viridis"](fraction)

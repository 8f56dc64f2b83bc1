"""Figures and films of a sweep."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from physcore.checks import shown, word
from physcore.errors import SceneError
from physcore.film import film as film_recordings
from physcore.film.labels.parameters import scale_of
from physcore.film.writers import WRITERS
from physcore.storage.formats import writable
from physcore.studies.figures import axes_for, save
from physcore.studies.sweep.result import SweepRow, SweepRows, cell, number_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from physcore.film.writers import Film

LINES = 10
"""Largest number of lines in the colors of the default cycle; more have a colormap."""


def distinct(rows: tuple[SweepRow, ...]) -> dict[str, list[Any]]:
    """The values of each parameter, in the order in which they occur."""
    names = rows[0].parameters
    return {name: list({cell(row.parameters[name]): row.parameters[name] for row in rows}.values()) for name in names}


def plot(table: SweepRows, path: str | os.PathLike[str] | None, axes: Axes | None, x: str | None) -> Axes:
    """Plot values against a parameter; see `Sweep.plot`."""
    values = distinct(table.rows)
    along = _along(values) if x is None else word(x, "x", tuple(values))
    lines = _lines(table.rows, along)
    axes = axes_for(path, axes)
    scale = scale_of(values[along])
    places = {cell(each): index if scale == "words" else each for index, each in enumerate(values[along])}
    for number, (label, rows) in enumerate(lines.items()):
        points = sorted((places[cell(row.parameters[along])], number_of(row)) for row in rows if row.error is None)
        color = f"C{number}" if len(lines) <= LINES else _shade(number / (len(lines) - 1))
        axes.plot(
            [at for at, _ in points], [value for _, value in points], "o-", markersize=4, color=color, label=label
        )
    axes.set(xlabel=along, ylabel="value")
    if scale == "log":
        axes.set_xscale("log")
    if scale == "words":
        axes.set_xticks(range(len(places)), list(places))
    failed = [places[cell(row.parameters[along])] for row in table.failed]
    lowest, highest = axes.get_ylim()
    axes.plot(
        failed, [lowest] * len(failed), "x", color="0.3", markersize=8, clip_on=False, label="failed" if failed else ""
    )
    axes.set_ylim(lowest, highest)
    axes.grid(alpha=0.25)
    if len(lines) > 1 or failed:
        axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(axes, path)
    return axes


def film(table: SweepRows, path: str | os.PathLike[str], where: Mapping[str, object], options: dict[str, Any]) -> Film:
    """Film recordings; see `Sweep.film`."""
    writable(path, WRITERS)
    known = distinct(table.rows)
    for name, value in where.items():
        if word(name, "where", tuple(known)) and cell(value) not in map(cell, known[name]):
            raise SceneError(f"where[{name!r}]: must be one of {', '.join(map(cell, known[name]))}, got {shown(value)}")
    rows = [row for row in table.rows if all(cell(row.parameters[name]) == cell(each) for name, each in where.items())]
    good = tuple(row for row in rows if row.error is None)
    if not good:
        raise SceneError(f"film: every point failed, the first one with {rows[0].error}")
    several = [len(each) for each in distinct(good).values() if len(each) > 1]
    columns = several[-1] if len(several) > 1 and math.prod(several) == len(good) else None
    recordings = [row.recording for row in good]
    parameters = [row.parameters for row in good]
    return film_recordings(recordings, path, **{"parameters": parameters, "columns": columns, **options})


def _along(values: dict[str, list[Any]]) -> str:
    """The parameter of the horizontal axis: the first one with several numbers, else the first one."""
    numeric = (name for name, each in values.items() if len(each) > 1 and scale_of(each) != "words")
    return next(numeric, next(iter(values)))


def _lines(rows: tuple[SweepRow, ...], along: str) -> dict[str, list[SweepRow]]:
    """The rows of each line, by the values of all other parameters.

    Raises:
        SceneError: a value is not a number.
    """
    lines: dict[str, list[SweepRow]] = {}
    for row in rows:
        label = ", ".join(f"{name} = {cell(value)}" for name, value in row.parameters.items() if name != along)
        lines.setdefault(label, []).append(row)
        if row.error is None:
            number_of(row)
    if all(row.error is not None for row in rows):
        raise SceneError(f"plot: every point failed, the first one with {rows[0].error}")
    return lines


def _shade(fraction: float) -> Any:
    """A color of the colormap viridis."""
    from matplotlib import colormaps

    return colormaps["viridis"](fraction)

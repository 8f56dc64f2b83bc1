"""Table of a sweep: a row for each point, with plots and films."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from physcore.checks import shown
from physcore.markup import Printed, html_table, text_table
from physcore.studies.sweep.result import RESULTS, SweepRow, SweepRows, measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from physcore.film.layout import Arrangement
    from physcore.film.writers import Film

SUMMARY = 6
"""Largest number of rows of a summary."""


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(SweepRows, Printed):
    """Table of a sweep: a row for each point, in the order of the grid. At a prompt it shows a part, `print` all rows.

        table = pc.sweep(lambda number: scene, {"number": [1, 2]}, 0.1, measure=len)  # a Sweep
        for row in table:
            print(row.parameters, row.value, row.error)
        table.best().parameters

    `sweep` returns it.
    """

    def plot(
        self, path: str | os.PathLike[str] | None = None, axes: Axes | None = None, *, x: str | None = None
    ) -> Axes:
        """Plot the values against a parameter with Matplotlib (`pip install "physcore[plot]"`).

        The other parameters have a line for each of their values. Points that failed are crosses at the bottom.

        Args:
            path: the file to write, with a suffix that Matplotlib supports; None: no file.
            axes: the axes to draw into; a new figure by default.
            x: name of the parameter; None: the first one with several numbers, else the first one.

        Raises:
            SceneError: the values are not numbers, or there is no such parameter.
            PhyscoreError: Matplotlib is not installed.
            FileError: the file cannot be written.
        """
        from physcore.studies.sweep.drawing import plot

        return plot(self, path, axes, x)

    def film(
        self,
        path: str | os.PathLike[str],
        *,
        where: Mapping[str, object] | None = None,
        arrangement: Arrangement = "panels",
        **options: Any,
    ) -> Film:
        """Film the recordings of a sweep with keep=True, with bars for the parameters. Failed points are left out.

            table.film("sweep.gif", where={"dt": 1e-3})

        Args:
            path: the file to write, as for `physcore.film`.
            where: values of some parameters; only their points are shown. None: all points.
            arrangement: "panels": beside each other; "sequence": one after the other.
            options: other arguments of `physcore.film`.

        Raises:
            SceneError: recordings were not kept, or there is no such point.
            FileError: the file cannot be written.
        """
        from physcore.studies.sweep.drawing import film

        return film(self, path, where or {}, {"arrangement": arrangement, **options})

    def __str__(self) -> str:
        return "\n".join([self._caption, *text_table([self._heads, *map(_cells, self.rows)], {len(self._heads) - 1})])

    def __repr__(self) -> str:
        """The first rows, as at a prompt."""
        shown_rows = self.rows[:SUMMARY]
        lines = text_table([self._heads, *map(_cells, shown_rows)], {len(self._heads) - 1})
        rest = [f"{len(shown_rows)} of {len(self)} rows; print shows all"] * (len(shown_rows) < len(self))
        return "\n".join([self._caption, *lines, *rest])

    def _repr_html_(self) -> str:
        """The table as HTML, for notebooks."""
        rows = {str(index): _cells(row) for index, row in enumerate(self.rows)}
        return html_table(["", *self._heads], rows, self._caption)

    @property
    def _heads(self) -> list[str]:
        return [*self.rows[0].parameters, *RESULTS]

    @property
    def _caption(self) -> str:
        failures = f", {len(self.failed)} failed" if self.failed else ""
        return f"Sweep: {len(self)} points of a duration of {self.duration:g}{failures}"


def _cells(row: SweepRow) -> list[str]:
    """The cells of a row."""
    error = "" if row.error is None else f"{type(row.error).__name__}: {shown(str(row.error))[1:-1]}"
    return [*row.texts.values(), measured(row.value), f"{row.seconds:.3g}", error]

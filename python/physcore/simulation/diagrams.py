"""Diagrams of recordings, drawn by Matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from physcore.checks import FloatArray, shown
from physcore.errors import PhyscoreError, SceneError
from physcore.units.systems import UnitSystem

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAND = 0.2
"""Opacity of the band between the smallest and the largest value."""


def canvas(axes: Axes | None) -> Axes:
    """The given axes, or the axes of a new figure.

    Raises:
        PhyscoreError: Matplotlib is not installed.
        SceneError: the value is not an Axes object.
    """
    try:
        from matplotlib import pyplot
        from matplotlib.axes import Axes
    except ImportError:
        raise PhyscoreError('plotting needs Matplotlib: pip install "physcore[plot]"') from None
    if axes is None:
        return pyplot.subplots(layout="constrained")[1]
    if not isinstance(axes, Axes):
        raise SceneError(f"plot.axes: must be Axes of Matplotlib, got {shown(axes)}")
    return axes


def over_time(
    times: FloatArray, values: FloatArray, names: str, label: str, axes: Axes | None, units: UnitSystem
) -> Axes:
    """Plot the components of a quantity over time: the mean of each, and a band from its smallest to its largest value.

    Args:
        times: times [s], shape (F,).
        values: values, shape (F, N, C): C components of N objects.
        names: one letter for each component.
        label: the quantity, with its unit.
        axes: the axes to draw into; a new figure by default.
        units: the units of the scene.
    """
    axes = canvas(axes)
    if values.shape[1]:
        for name, part in zip(names, np.moveaxis(values, 2, 0), strict=True):
            (line,) = axes.plot(times, part.mean(axis=1), label=name)
            if part.shape[1] > 1:
                axes.fill_between(times, part.min(axis=1), part.max(axis=1), color=line.get_color(), alpha=BAND, lw=0)
    axes.set(xlabel=units.label("time", "s"), ylabel=label)
    if len(names) > 1:
        axes.legend(frameon=False)
    return axes

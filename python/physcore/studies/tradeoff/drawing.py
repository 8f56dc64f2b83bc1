"""Figures of a trade-off, and films of a row beside the reference."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, Literal

from physcore.film import film as film_recordings
from physcore.film.writers import WRITERS
from physcore.numerics.contacts import ContactSolver
from physcore.numerics.fluids import FluidMethod
from physcore.numerics.integrators import Integrator
from physcore.simulation.simulation import Simulation
from physcore.storage.formats import writable
from physcore.studies.figures import axes_for, save
from physcore.studies.tradeoff.labels import differences
from physcore.studies.tradeoff.result import CERTAIN, Measurements, Row

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

MARKERS = {"f64": "o", "f32": "s"}
LINES: dict[str, Literal["-", ":"]] = {"f64": "-", "f32": ":"}
PALEST = 0.75
"""Largest fraction of white in the shades of a color."""


def plot(trade: Measurements, path: str | os.PathLike[str] | None, axes: Axes | None) -> Axes:
    """Plot error against time; see `Tradeoff.plot`."""
    axes = axes_for(path, axes)
    front = [row for row in trade.front if row.total_error > 0.0]
    axes.plot(
        [row.seconds for row in front],
        [row.total_error for row in front],
        color="0.85",
        linewidth=9,
        zorder=0,
        solid_capstyle="round",
        label="Pareto front",
    )
    colors = _colors(trade)
    for (variant, precision), rows in _series(trade).items():
        axes.plot(
            [row.seconds for row in rows],
            [row.total_error for row in rows],
            LINES[precision],
            marker=MARKERS[precision],
            markersize=4,
            color=colors[variant],
        )
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="time of a run [s]",
        ylabel=trade.scene.units.label(f"error ({trade.measure})", "m"),
    )
    floor = CERTAIN * max(reference.uncertainty for reference in trade.references)
    lowest, highest = axes.get_ylim()
    if floor > lowest:
        axes.axhspan(lowest, floor, color="0.5", alpha=0.15, linewidth=0, label="not resolved by the reference")
    for row in trade.rows:
        if not math.isfinite(row.error):
            color = colors[_variant(row)]
            axes.plot([row.seconds], [highest], "x", color=color, markersize=8, markeredgewidth=2, clip_on=False)
    axes.set_ylim(lowest, highest)
    axes.tick_params(which="minor", labelsize="xx-small")
    axes.grid(alpha=0.25)
    _explain(trade, axes, colors)
    save(axes, path)
    return axes


Variant = tuple[str, float | None, tuple[FluidMethod | ContactSolver, ...]]
"""Key of a color: the label of an integrator, a resolution, and the compared methods of fluids and of contacts."""


def _variant(row: Row) -> Variant:
    return row.label, row.resolution, tuple(row.methods.values())


def _name(variant: Variant) -> str:
    label, resolution, compared = variant
    return ", ".join([label, *([] if resolution is None else [f"{resolution:g}"]), *map(differences, compared)])


def _colors(trade: Measurements) -> dict[Variant, tuple[float, float, float]]:
    """A color for each class of integrators, in shades for its variants, the last one darkest."""
    from matplotlib.colors import to_rgb

    kinds: dict[type[Integrator], dict[Variant, None]] = {}
    for row in trade.rows:
        kinds.setdefault(type(row.integrator), {})[_variant(row)] = None
    colors = {}
    for index, variants in enumerate(kinds.values()):
        for position, variant in enumerate(reversed(variants)):
            white = PALEST * position / len(variants)
            red, green, blue = (white + (1.0 - white) * channel for channel in to_rgb(f"C{index}"))
            colors[variant] = red, green, blue
    return colors


def _explain(trade: Measurements, axes: Axes, colors: dict[Variant, tuple[float, float, float]]) -> None:
    """A legend beside the axes: colors, precisions, and shaded areas."""
    from matplotlib.lines import Line2D

    precisions = dict.fromkeys(row.precision for row in trade.rows)
    variants = dict.fromkeys(map(_variant, trade.rows))
    handles: list[Artist] = [
        Line2D([], [], color=colors[variant], label=_name(variant), linewidth=2.5) for variant in variants
    ]
    handles += [
        Line2D([], [], color="0.3", linestyle=LINES[each], marker=MARKERS[each], markersize=4, label=each)
        for each in precisions
    ]
    handles += axes.get_legend_handles_labels()[0]
    axes.legend(handles=handles, frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))


def _series(trade: Measurements) -> dict[tuple[Variant, str], list[Row]]:
    """The rows that can be drawn with logarithmic axes, grouped by line."""
    found: dict[tuple[Variant, str], list[Row]] = {}
    for row in trade.rows:
        if math.isfinite(row.error) and row.total_error > 0.0:
            found.setdefault((_variant(row), row.precision), []).append(row)
    return found


def film(trade: Measurements, path: str | os.PathLike[str], row: Row, fps: float, options: dict[str, Any]) -> None:
    """Film a row beside the reference; see `Tradeoff.film`."""
    writable(path, WRITERS)
    position = list(dict.fromkeys(_variant(each)[1:] for each in trade.rows)).index(_variant(row)[1:])
    experiment, reference = trade.experiments[position], trade.references[position]
    chosen = Simulation(experiment.scene, **row.numerics).record(trade.duration, fps)
    truth = Simulation(
        experiment.scene,
        reference.choice.integrator,
        experiment.dt(reference.choice),
        "f64",
        experiment.threads,
        fluids=experiment.fluids,
        contacts=experiment.contacts,
    ).record(trade.duration, fps)
    meter = trade.scene.units.suffix("m")
    titles = [f"{row.label}, {row.precision}, {row.seconds:.2g} s", f"reference, ±{reference.uncertainty:.0e}{meter}"]
    film_recordings([chosen, truth], path, **{"titles": titles, "size": (960, 480), **options})

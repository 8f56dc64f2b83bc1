"""A trade as a figure, and as a film of what was chosen beside the reference."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from physcore.checks import shown
from physcore.errors import PhyscoreError, SceneError
from physcore.film import film as film_recordings
from physcore.film.writers import WRITERS
from physcore.numerics.fluids import FluidMethod
from physcore.simulation.simulation import Simulation
from physcore.storage.files import replacing, require_writable
from physcore.storage.formats import writable
from physcore.studies.tradeoff.report import differences
from physcore.studies.tradeoff.result import CERTAIN, Measurements, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARKERS = {"f64": "o", "f32": "s"}
LINES = {"f64": "-", "f32": ":"}


def require_plottable(path: str | os.PathLike[str] | None) -> None:
    """Find out whether a figure can be written, before the work begins.

    Raises:
        SceneError: it is no path, or ends like no format that Matplotlib writes.
        FileError: the file cannot be written.
        PhyscoreError: Matplotlib is not installed.
    """
    try:
        from matplotlib.backend_bases import FigureCanvasBase
    except ImportError:
        raise PhyscoreError('plotting needs Matplotlib: pip install "physcore[plot]"') from None
    if path is None:
        return
    known, suffix = FigureCanvasBase.get_supported_filetypes(), _suffix(require_writable(path))
    if suffix not in known:
        raise SceneError(f"path: must end in {', '.join(f'.{each}' for each in known)}, got {shown(str(path))}")


def _suffix(path: str | os.PathLike[str]) -> str:
    """The format of a figure."""
    return Path(path).suffix.lstrip(".").lower() or "png"


def plot(trade: Measurements, path: str | os.PathLike[str] | None, axes: Axes | None) -> Axes:
    """Error against time; see `Tradeoff.plot`."""
    if path is not None or axes is None:
        require_plottable(path)
    if axes is None:
        from matplotlib.figure import Figure

        axes = Figure(figsize=(7.2, 4.8), layout="constrained").subplots()
    names = list(dict.fromkeys(type(row.integrator).__name__ for row in trade.rows))
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
    for (name, precision, resolution, fluids), rows in _series(trade).items():
        label = f"{name}, {precision}" + ("" if resolution is None else f", {resolution:g}")
        label += "" if fluids is None else f", {differences(fluids)}"
        axes.plot(
            [row.seconds for row in rows],
            [row.total_error for row in rows],
            LINES[precision],
            marker=MARKERS[precision],
            markersize=4,
            color=f"C{names.index(name)}",
            label=label,
        )
    axes.set(xscale="log", yscale="log", xlabel="time of a run [s]", ylabel=f"error ({trade.measure}) [m]")
    floor = CERTAIN * max(reference.uncertainty for reference in trade.references)
    lowest, highest = axes.get_ylim()
    if floor > lowest:
        axes.axhspan(lowest, floor, color="0.5", alpha=0.15, linewidth=0, label="not resolved by the reference")
    for row in trade.rows:
        if not math.isfinite(row.error):
            color = f"C{names.index(type(row.integrator).__name__)}"
            axes.plot([row.seconds], [highest], "x", color=color, markersize=8, markeredgewidth=2, clip_on=False)
    axes.set_ylim(lowest, highest)
    axes.tick_params(which="minor", labelsize="xx-small")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    if path is not None:
        with replacing(path) as file:
            figure = axes.get_figure(root=True)
            assert figure is not None
            figure.savefig(file, format=_suffix(path), dpi=144)
    return axes


def _series(trade: Measurements) -> dict[tuple[str, str, float | None, FluidMethod | None], list[Row]]:
    """The rows that have a place in a logarithmic figure, by what a line stands for."""
    found: dict[tuple[str, str, float | None, FluidMethod | None], list[Row]] = {}
    for row in trade.rows:
        if math.isfinite(row.error) and row.total_error > 0.0:
            key = (type(row.integrator).__name__, row.precision, row.resolution, row.fluids)
            found.setdefault(key, []).append(row)
    return found


def film(trade: Measurements, path: str | os.PathLike[str], row: Row, fps: float, options: dict[str, Any]) -> None:
    """What was chosen beside the reference; see `Tradeoff.film`."""
    writable(path, WRITERS)
    position = list(dict.fromkeys((each.fluids, each.resolution) for each in trade.rows)).index(
        (row.fluids, row.resolution)
    )
    experiment, reference = trade.experiments[position], trade.references[position]
    chosen = Simulation(experiment.scene, **row.numerics).record(trade.duration, fps)
    truth = Simulation(
        experiment.scene,
        reference.choice.integrator,
        experiment.dt(reference.choice),
        "f64",
        experiment.threads,
        fluids=experiment.fluids,
    ).record(trade.duration, fps)
    name = type(row.integrator).__name__
    titles = [f"{name}, {row.precision}, {row.seconds:.2g} s", f"reference, ±{reference.uncertainty:.0e} m"]
    film_recordings([chosen, truth], path, **{"titles": titles, "size": (960, 480), **options})

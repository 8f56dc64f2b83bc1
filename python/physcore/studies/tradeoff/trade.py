"""Result of a trade-off study: the measurements, with methods to report them."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from physcore.storage.files import replacing
from physcore.studies.tradeoff.result import Measurements

# Reports and drawings are imported on use, so that `import physcore` is faster.
if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Tradeoff(Measurements):
    """Trade-off between speed and accuracy in one scene. A prompt shows its Pareto front, `print` all rows, and
    `explain` returns an explanation.

        trade = pc.tradeoff(scene, duration=0.1, budget=1.0)  # a Tradeoff
        print(trade)
        simulation = pc.Simulation(scene, **trade.best(error=1e-3).numerics)

    `tradeoff` returns it.
    """

    def explain(self) -> str:
        """The results as sentences."""
        from physcore.studies.tradeoff.report import explanation

        return explanation(self)

    def plot(self, path: str | os.PathLike[str] | None = None, axes: Axes | None = None) -> Axes:
        """Plot error against time, on logarithmic axes, with Matplotlib (`pip install "physcore[plot]"`).

        The Pareto front is highlighted. Rows that diverged are crosses at the top. Below the shaded line, errors are
        within the uncertainty of the reference.

        Args:
            path: the file to write, with a suffix that Matplotlib supports; None: no file.
            axes: the axes to draw into; a new figure by default.

        Raises:
            PhyscoreError: Matplotlib is not installed.
            FileError: the file cannot be written.
        """
        from physcore.studies.tradeoff.drawing import plot

        return plot(self, path, axes)

    def film(self, path: str | os.PathLike[str], *, error: float, fps: float = 30.0, **options: Any) -> None:
        """Film the fastest row within an error beside the reference.

        Args:
            path: the file to write, ending in .gif or .png.
            error: the largest acceptable error [m].
            fps: frames per second of simulated time.
            options: arguments of `physcore.film`.

        Raises:
            PhyscoreError: no row meets the bound.
            FileError: the file cannot be written.
        """
        from physcore.studies.tradeoff.drawing import film

        film(self, path, self.best(error=error), fps, options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save all measurements as JSON, with the machine, the version and the seed.

        Raises:
            FileError: the file cannot be written.
        """
        from physcore.studies.tradeoff.report import document

        with replacing(path) as file:
            file.write((json.dumps(document(self), indent=2, ensure_ascii=False) + "\n").encode())

    def __repr__(self) -> str:
        """The Pareto front as a table of ten lines at most, as at a prompt."""
        from physcore.studies.tradeoff.report import summary

        return summary(self)

    def __str__(self) -> str:
        from physcore.studies.tradeoff.report import table

        return table(self)

    def _repr_html_(self) -> str:
        """The table as HTML, for notebooks."""
        from physcore.studies.tradeoff.report import html

        return html(self)

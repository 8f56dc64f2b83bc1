"""What speed costs in accuracy: the measurements, with all the ways to look at them."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from physcore.storage.files import replacing
from physcore.studies.tradeoff.result import Measurements

# Reports and drawings are imported where they are used: `import physcore` need not wait for them.
if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class Tradeoff(Measurements):
    """What speed costs in accuracy, in one scene; `print` it for the table, `explain` it for sentences.

        trade = pc.tradeoff(scene, duration=0.1, budget=1.0)  # a Tradeoff
        print(trade)
        simulation = pc.Simulation(scene, **trade.best(error=1e-3).numerics)

    `tradeoff` measures it.
    """

    def explain(self) -> str:
        """What was found, in sentences."""
        from physcore.studies.tradeoff.report import explanation

        return explanation(self)

    def plot(self, path: str | os.PathLike[str] | None = None, axes: Axes | None = None) -> Axes:
        """Draw error against time, both logarithmic, with Matplotlib (`pip install "physcore[plot]"`).

        The front is underlaid, rows that blew up are crosses at the top, and below the shaded line the reference is not
        good enough to tell.

        Args:
            path: where to write the figure, with a suffix that Matplotlib knows; None: nowhere.
            axes: where to draw; a new figure by default.

        Raises:
            PhyscoreError: Matplotlib is not installed.
            FileError: the file cannot be written.
        """
        from physcore.studies.tradeoff.drawing import plot

        return plot(self, path, axes)

    def film(self, path: str | os.PathLike[str], *, error: float, fps: float = 30.0, **options: Any) -> None:
        """Show the fastest row within an error beside the reference, as a GIF.

        Args:
            path: where to write, ending in .gif or .png.
            error: the largest error to accept [m].
            fps: frames per second of simulated time.
            options: for `physcore.film`.

        Raises:
            PhyscoreError: no row is that good.
            FileError: the file cannot be written.
        """
        from physcore.studies.tradeoff.drawing import film

        film(self, path, self.best(error=error), fps, options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything that was measured as JSON, with the machine, the version and the seed.

        Raises:
            FileError: the file cannot be written.
        """
        from physcore.studies.tradeoff.report import document

        with replacing(path) as file:
            file.write((json.dumps(document(self), indent=2, ensure_ascii=False) + "\n").encode())

    def __str__(self) -> str:
        from physcore.studies.tradeoff.report import table

        return table(self)

    def _repr_html_(self) -> str:
        """For notebooks: the same table."""
        from physcore.studies.tradeoff.report import html

        return html(self)

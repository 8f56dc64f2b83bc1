"""Result of a sweep: a row for each point."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from physcore.checks import flag, shown
from physcore.errors import FileError, PhyscoreError, SceneError
from physcore.film.labels.parameters import value_text
from physcore.markup import Printed
from physcore.simulation.recording import Recording
from physcore.simulation.tables import pandas_module
from physcore.studies.sweep.folder import Folder
from physcore.studies.sweep.task import Outcome, Task

if TYPE_CHECKING:
    from pandas import DataFrame

RESULTS = ("value", "seconds", "error")
"""Columns of a table beside the parameters."""


@dataclass(frozen=True, eq=False, repr=False)
class SweepRow(Printed):
    """Row of a sweep: a point of the grid with its result."""

    parameters: dict[str, Any]
    """Parameters by name."""
    value: Any = None
    """Value of the measure; None if the point failed, or nothing is measured."""
    error: Exception | None = None
    """Exception of the point; None if there is none."""
    seconds: float = 0.0
    """Time of the simulation [s]."""
    task: Task | None = field(default=None, kw_only=True)
    """Task of the point, if its recording is kept."""
    kept: Outcome | tuple[Folder, int] | None = field(default=None, kw_only=True)
    """Outcome with the recording, or the folder and the number of its file; None if it is not kept."""

    @property
    def recording(self) -> Recording:
        """The recording of a sweep with keep=True. Its scene is built again.

        Raises:
            SceneError: recordings were not kept, or the point failed; or `build` now gives another scene.
            FileError: the file is damaged.
        """
        if self.kept is None or self.task is None:
            reason = "recordings are kept by sweep(…, keep=True)" if self.error is None else f"it failed: {self.error}"
            raise SceneError(f"recording: there is none of {self.label}: {reason}")
        scene, outcome = self.task.scene(), self.kept
        if isinstance(outcome, tuple):
            folder, index = outcome
            read = folder.read(index)
            if read is None:
                raise FileError(f"recording: {folder.file(index)} is gone or damaged; call sweep again")
            outcome = read
        if outcome.recording is None or outcome.scene != self.task.hash(scene):
            raise SceneError(
                f"recording: build gives another scene for {self.label} than before; if it takes random numbers, give "
                "it a seed"
            )
        return Recording.from_content(outcome.recording, scene)

    @property
    def texts(self) -> dict[str, str]:
        """The parameters as texts, different ones for different values."""
        return {name: value_text(value) for name, value in self.parameters.items()}

    @property
    def label(self) -> str:
        """The parameters as one text."""
        return ", ".join(f"{name} = {each}" for name, each in self.texts.items())

    def __str__(self) -> str:
        result = measured(self.value) if self.error is None else f"{type(self.error).__name__}: {self.error}"
        return f"{self.label}: {result}"


@dataclass(frozen=True, eq=False)
class SweepRows:
    """Rows of a sweep, in the order of the grid."""

    rows: tuple[SweepRow, ...]
    """Rows in the order of the grid; the last parameter varies fastest."""
    duration: float
    """Simulated duration [s]."""

    def __iter__(self) -> Iterator[SweepRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, index: int) -> SweepRow:
        return self.rows[index]

    @property
    def failed(self) -> tuple[SweepRow, ...]:
        """The rows of the points that failed."""
        return tuple(row for row in self.rows if row.error is not None)

    def best(self, maximize: bool = False) -> SweepRow:
        """The row with the least value, or the first one of these.

            softest = table.best(maximize=True)

        Args:
            maximize: whether to take the largest value.

        Raises:
            SceneError: the values are not numbers.
            PhyscoreError: no point has a value that is a number; the message has the first error.
        """
        sign = -1.0 if flag(maximize, "maximize") else 1.0
        found = [(row, number_of(row)) for row in self.rows if row.error is None]
        numbers = [(row, value) for row, value in found if not math.isnan(value)]
        if not numbers:
            reason = f": {self.failed[0]}" if self.failed else ""
            raise PhyscoreError(f"best: no point has a value{reason}")
        return min(numbers, key=lambda entry: sign * entry[1])[0]

    def to_dataframe(self) -> DataFrame:
        """Convert to a pandas data frame (`pip install "physcore[pandas]"`).

            table.to_dataframe().pivot(index="stiffness", columns="damping", values="value")

        Returns:
            DataFrame: a row for each point. The columns are the parameters, value, seconds and error, the message of
                the exception or None.

        Raises:
            PhyscoreError: pandas is not installed.
            SceneError: a parameter has the name of another column.
        """
        pandas = pandas_module()
        names = tuple(self.rows[0].parameters)
        for name in RESULTS:
            if name in names:
                raise SceneError(f"to_dataframe: {name!r} is the name of a parameter and of a column of results")
        columns: dict[str, list[Any]] = {name: [row.parameters[name] for row in self.rows] for name in names}
        columns["value"] = [row.value for row in self.rows]
        columns["seconds"] = [row.seconds for row in self.rows]
        columns["error"] = [None if row.error is None else str(row.error) for row in self.rows]
        table: DataFrame = pandas.DataFrame(columns)
        return table


def number_of(row: SweepRow) -> float:
    """The value of a row as a number.

    Raises:
        SceneError: it is none.
    """
    if isinstance(row.value, bool) or not isinstance(row.value, (int, float)):
        raise SceneError(f"measure: must give one number at each point, gave {shown(row.value)} for {row.label}")
    return float(row.value)


def measured(value: object) -> str:
    """A value of the measure in a table."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return "—" if value is None else value_text(value)

"""Conversion of recordings to pandas data frames, with a row for each particle at each time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from physcore import memory
from physcore.checks import FloatArray
from physcore.errors import PhyscoreError, SceneError

if TYPE_CHECKING:
    from pandas import DataFrame

COLUMNS = {"positions": "{axis}", "velocities": "v{axis}"}
"""Column names of vectors; for other vectors they begin with the name of the field."""
AXES = "xyz"


def pandas_module() -> Any:
    """The module pandas.

    Raises:
        PhyscoreError: it is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise PhyscoreError('data frames need pandas: pip install "physcore[pandas]"') from None
    return pandas


def data_frame(
    times: FloatArray, channels: Mapping[str, FloatArray], owners: Sequence[tuple[object, int]] = ()
) -> DataFrame:
    """A data frame of the fields of particles over time.

    Args:
        times: times [s], shape (F,).
        channels: fields by name, of shape (F, N) or (F, N, D); other fields are omitted.
        owners: the name and the number of particles of each body, for a column of names.

    Raises:
        PhyscoreError: pandas is not installed.
        SceneError: there are no particles, or the table would not fit into memory.
    """
    pandas = pandas_module()
    number = next((values.shape[1] for values in channels.values() if values.ndim in (2, 3)), None)
    if number is None:
        raise SceneError("to_dataframe: nothing with particles was recorded; fields on grids are arrays")
    frames = len(times)
    index = np.concatenate([np.arange(count) for _, count in owners]) if owners else np.arange(number)
    columns: dict[str, object] = {"time": np.repeat(times, number)}
    if owners:
        names, counts = zip(*owners, strict=True)
        codes = np.tile(np.repeat(np.arange(len(owners)), counts), frames)
        columns["body"] = pandas.Categorical.from_codes(codes, categories=list(names))
    columns["particle"] = np.tile(index, frames)
    fields = {name: values for name, values in channels.items() if values.shape[1:2] == (number,) and values.ndim < 4}
    memory.require(8.0 * sum(values.size for values in fields.values()), "the numbers of the table", "to_dataframe")
    for name, values in fields.items():
        if values.ndim == 2:
            columns[name] = values.ravel()
            continue
        axes = AXES if values.shape[2] <= len(AXES) else f"w{AXES}"  # quaternions are (w, x, y, z)
        for axis, component in zip(axes, np.moveaxis(values, 2, 0), strict=False):
            columns[COLUMNS.get(name, name + "_{axis}").format(axis=axis)] = component.ravel()
    table: DataFrame = pandas.DataFrame(columns)
    return table

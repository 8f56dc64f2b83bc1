"""Signals: values over time, from files of sound."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import FloatArray, array, count, frozen, number
from physcore.entrance import entrance
from physcore.errors import FileError, SceneError
from physcore.files.reader import Options, Reader, reading


class Signal:
    """Signal: values at equal intervals of time, which can drive a source.

        click = pc.Signal(np.sin(np.arange(100) / 5.0), rate=8000.0)
        click.values, click.rate, click.duration
        source = pc.Source((0.5, 0.5), amplitude=1.0, signal=click)

    A signal is a function of the time [s]: linear between its values, and zero before and after. `pc.read` reads one
    from a .wav file, with the full scale as 1.

    Args:
        values: values, shape (N,), or (N, channels).
        rate: number of values per second [1/s].

    Raises:
        SceneError: a shape does not fit, or a value is not finite.
    """

    def __init__(self, values: ArrayLike, rate: float) -> None:
        samples = array(values, "Signal.values")
        if samples.ndim not in (1, 2) or not samples.size:
            raise SceneError(f"Signal.values: must have the shape (N,) or (N, channels), got {samples.shape}")
        self.values: FloatArray = frozen(samples)
        self.rate = number(rate, "Signal.rate", above=0.0)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return len(self.values) / self.rate

    @entrance
    def channel(self, index: int) -> Signal:
        """One channel of several.

            left = pc.Signal(np.zeros((10, 2)), rate=10.0).channel(0)

        Args:
            index: index of the channel.

        Raises:
            SceneError: there is no such channel.
        """
        columns = self.values.reshape(len(self.values), -1)
        place = count(index, "channel.index", most=columns.shape[1] - 1)
        return Signal(columns[:, place], self.rate)

    def __call__(self, time: ArrayLike) -> FloatArray:
        """The values at times [s].

        Raises:
            SceneError: there are several channels.
        """
        if self.values.ndim == 2:
            raise SceneError(f"Signal: has {self.values.shape[1]} channels; take one: signal.channel(0)")
        times = np.arange(len(self.values)) / self.rate
        return np.asarray(np.interp(np.asarray(time, dtype=np.float64), times, self.values, left=0.0, right=0.0))

    def __repr__(self) -> str:
        channels = f", {self.values.shape[1]} channels" if self.values.ndim == 2 else ""
        return f"Signal({self.duration:.4g} s at {self.rate:g} Hz{channels})"


class WavReader(Reader):
    """Reader of sounds."""

    kind: ClassVar = "sounds"
    package: ClassVar = "scipy"
    suffixes: ClassVar = (".wav",)

    def read(self, path: Path, suffix: str, options: Options) -> Signal:
        """All samples of a file, scaled such that the full scale is 1."""
        del suffix, options
        from scipy.io import wavfile

        with reading(path, "scipy"):
            rate, samples = wavfile.read(path)
        if not samples.size:
            raise FileError(f"{path}: has no samples")
        values = samples.astype(np.float64)
        if samples.dtype == np.uint8:
            values = (values - 128.0) / 128.0
        elif samples.dtype.kind == "i":  # 24 bits are in the upper ones of 32
            values /= -float(np.iinfo(samples.dtype).min)
        return Signal(values, float(rate))

"""Split steps as users of SciPy and FFTW write them: kicks of two steps in one, the Fourier transform of a square."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals import optional

fft, pyfftw = optional("scipy.fft"), optional("pyfftw")

Array = NDArray[Any]


class SplitSteps:
    """An opponent's state: ψ, and the phases of V and of the modes."""

    def __init__(self, start: Array, phases: tuple[Array, Array], dtype: type, threads: int) -> None:
        """`phases`: V h/ħ of the cells, and T h/ħ of the modes."""
        self.threads = threads
        self.values = (pyfftw.empty_aligned if pyfftw else np.empty)(start.shape, dtype)
        self.plan()
        self.values[...] = start
        self.half, self.kick, self.drift = (
            np.exp(-1j * phase).astype(dtype) for phase in (0.5 * phases[0], phases[0], phases[1])
        )

    def plan(self) -> None:
        """Prepare transforms; may overwrite ψ."""

    def drifted(self, values: Array) -> Array:
        """ψ after its modes have turned."""
        raise NotImplementedError

    def step(self, steps: int) -> None:
        """Take steps."""
        values = self.values
        values *= self.half
        for done in range(1, steps + 1):
            values = self.drifted(values)
            values *= self.kick if done < steps else self.half
        self.values = values


class ScipySteps(SplitSteps):
    """scipy.fft, in place."""

    def drifted(self, values: Array) -> Array:
        """ψ after its modes have turned."""
        modes = fft.fft2(values, overwrite_x=True, workers=self.threads)
        modes *= self.drift
        result: Array = fft.ifft2(modes, overwrite_x=True, workers=self.threads)
        return result


class FftwSteps(SplitSteps):
    """FFTW with measured plans, in place."""

    def plan(self) -> None:
        """Measure."""
        options: dict[str, Any] = {"axes": (0, 1), "threads": self.threads, "flags": ("FFTW_MEASURE",)}
        self.forward = pyfftw.FFTW(self.values, self.values, **options)
        self.backward = pyfftw.FFTW(self.values, self.values, direction="FFTW_BACKWARD", **options)

    def drifted(self, values: Array) -> Array:
        """ψ after its modes have turned."""
        self.forward.execute()
        values *= self.drift
        self.backward.execute()
        values *= 1.0 / values.size
        return values


RIVALS = {"SciPy": fft and ScipySteps, "FFTW, measured plans": pyfftw and FftwSteps}

"""Measured quantities of demos, with their expected values from theory, experiment or a conservation law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from physcore.simulation.recording import Recording

DIGITS = (3, 7)
"""Least and largest number of significant digits; in between, as many as show the error."""


LEAST = 1e-6
"""Smallest error that is written [%]."""


@dataclass(frozen=True)
class Figure:
    """Measured value and its expected value; `str` gives a line of text.

    Args:
        quantity: name of the measured quantity.
        measured: measured value.
        expected: expected value; not zero.
        source: origin of the expected value, such as "by theory".
        bound: largest relative error at which the demo passes.
        unit: unit of both values, in the usual symbols; empty for a ratio.
    """

    quantity: str
    measured: float
    expected: float
    source: str
    bound: float
    unit: str = ""

    @property
    def error(self) -> float:
        """The relative error of the measured value."""
        return abs(self.measured / self.expected - 1.0)

    @property
    def holds(self) -> bool:
        """Whether the error is within its bound."""
        return self.error <= self.bound

    def __str__(self) -> str:
        measured, expected = (f"{self._written(value)} {self.unit}".strip() for value in (self.measured, self.expected))
        verdict = "within" if self.holds else "more than"
        return (
            f"{self.quantity} {measured}, {expected} {self.source} "
            f"(off by {_percent(self.error)}, {verdict} {_percent(self.bound)})"
        )

    def _written(self, value: float) -> str:
        """A value with one digit more than needed to show the error."""
        least, most = DIGITS
        needed = 2 - math.floor(math.log10(self.error)) if 0.0 < self.error < math.inf else most
        digits = min(max(needed, least), most)
        text = f"{value:#.{digits}g}"
        return text if "e" in text else text.rstrip(".")


def budget(recordings: Mapping[str, Recording], bound: float) -> Figure:
    """Final forms of a scene's energy (motion, strain, compression and heat), with the energy that it received.

    The received energy is the initial kinetic energy, the change of height, and the work of wind or drivers. Heat is
    computed from the power of drag, damping, viscosity and contacts. Both sides are therefore equal only if the
    equations of motion are solved correctly.
    """
    (energy,) = (recording.energy for recording in recordings.values())
    height = energy.by_term["gravity"]
    stored = energy.potential - height + energy.internal
    found = energy.kinetic[-1] + stored[-1] - stored[0] + energy.dissipated[-1]
    given = energy.kinetic[0] + height[0] - height[-1] + energy.work[-1]
    terms = {"springs": "strain", "surface tension": "surface"}
    forms = ["motion", *(form for term, form in terms.items() if term in energy.by_term)]
    forms += ["compression"] * bool(energy.internal.any())
    given_by = ["the throw"] * bool(energy.kinetic[0]) + ["the fall"] + ["the wind"] * bool(energy.work[-1])
    source = f"from {' and '.join(given_by)}"
    return Figure(f"{', '.join(forms)} and heat at the end", float(found), float(given), source, bound, "J")


def _percent(fraction: float) -> str:
    """A fraction in percent with two digits."""
    percent = 100.0 * fraction
    if 0.0 < percent < LEAST:
        return f"less than {LEAST:f} %"
    if percent == 0.0 or not math.isfinite(percent):
        return f"{percent:g} %"
    decimals = max(1 - math.floor(math.log10(percent)), 0)
    return f"{percent:.{decimals}f}".rstrip("0").rstrip(".") + " %" if decimals else f"{percent:.0f} %"

"""Charges in an electric and a magnetic field."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from physcore.checks import FloatArray, Vector, number, vector
from physcore.errors import SceneError
from physcore.scene.items import Force

Field: TypeAlias = float | Vector | Callable[[float, FloatArray], FloatArray]
"""A field: a vector, the same everywhere, or `function(time, positions)`."""


@dataclass(frozen=True)
class ElectromagneticField(Force):
    """The force on charges in an electric field E and a magnetic field B: F = q (E + v × B).

        beam = pc.Particles([[0, 0]], [[1, 0]], charge=1.0)
        scene = pc.Scene(beam, pc.ElectromagneticField(electric=(0.0, 0.1), magnetic=2.0))

    A uniform E has the potential energy −q E·x, by_term["electromagnetic field"]. What a function's E does is work,
    unless `potential` is given. A magnetic force does no work. Where there is a magnetic field, Boris() is the default
    integrator.

    Args:
        electric: E [V/m], a vector, or `function(time, positions)` with the time [s] and the positions (N, D) [m] of
            the particles that it acts on, which gives E at these, (N, D). The number 0 is no field.
        magnetic: B [T], a vector or such a function. In 2D its component along z: a number, or a function that gives
            (N,).
        potential: `potential(positions)`, the energy of those particles in E [J], one number.
        on: the body or bodies that feel it; all by default.

    Raises:
        SceneError: a field is no such thing or not finite. In a run: a function raised an exception, or gave something
            else; the message starts with `forces[i].electric`, `.magnetic` or `.potential`.

    Source: J. D. Jackson, Classical Electrodynamics, 3rd edition (1999), § 6.7 and § 12.1.
    """

    electric: Field = 0.0
    magnetic: Field = 0.0
    potential: Callable[[FloatArray], float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(electric=_field(self.electric, "electric"), magnetic=_field(self.magnetic, "magnetic"))
        if isinstance(self.electric, float) and self.electric != 0.0:
            raise SceneError(f"ElectromagneticField.electric: must be a vector, a function or 0, got {self.electric:g}")
        if self.potential is not None and not callable(self.potential):
            raise SceneError(f"ElectromagneticField.potential: must be a function, got {self.potential!r}")

    @property
    def is_magnetic(self) -> bool:
        """Whether there is a magnetic field."""
        return callable(self.magnetic) or self.magnetic not in (0.0, (0.0, 0.0, 0.0))

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """In 2D B is a number, in 3D a vector."""
        magnetic = self.magnetic
        if isinstance(magnetic, tuple) and dimension == 2:
            return "magnetic", len(magnetic)
        if isinstance(magnetic, float) and magnetic != 0.0 and dimension == 3:
            return "magnetic", 1
        return super().mismatch(dimension)


def _field(value: object, name: str) -> object:
    """A field, checked."""
    path = f"ElectromagneticField.{name}"
    if callable(value):
        return value
    if isinstance(value, (int, float)):
        return number(value, path)
    return vector(value, path)

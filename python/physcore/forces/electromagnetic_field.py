"""Lorentz force of external electric and magnetic fields."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from physcore.checks import FloatArray, Vector, number, shown, vector
from physcore.errors import SceneError
from physcore.forces.fields import READY_FIELDS, ReadyField
from physcore.scene.items import Force

Field: TypeAlias = float | Vector | ReadyField | tuple[ReadyField, ...] | Callable[[float, FloatArray], FloatArray]
"""A field: a vector, a built-in field or a sum of these, or `function(time, positions)`."""


@dataclass(frozen=True)
class ElectromagneticField(Force):
    """Lorentz force on charges in an electric field E and a magnetic field B: F = q (E + v × B).

        beam = pc.Particles([[0, 0]], [[1, 0]], charge=1.0)
        scene = pc.Scene(beam, pc.ElectromagneticField(electric=(0.0, 0.1), magnetic=2.0))

    A uniform E and the E of a trap have a potential energy, by_term["electromagnetic field"]. The E of a function does
    external work, unless `potential` is given. A magnetic force does no work. With a magnetic field, Boris() is the
    default integrator. The charges do not interact with each other; for this, add Coulomb().

    Args:
        electric: E [V/m]. A vector; one of QuadrupoleTrap, PaulTrap, TravellingWave and UniformField; a tuple of these,
            which are added; or a function. `function(time, positions)` has the time [s] and the positions (N, D) [m] of
            the particles that the field acts on. It returns E at each particle, (N, D), which may depend on this
            particle's position only. The number 0 is no field.
        magnetic: B [T]: likewise, with MagneticDipole, CurrentLoop, MagneticBottle, TravellingWave and UniformField. In
            2D, its component along z: a number, or a function that returns (N,).
        potential: `potential(positions)`, the energy of these particles in the E of a function [J], one number.
        on: the body or bodies that feel the field; all by default.

    Raises:
        SceneError: a field is not valid, not finite, or not of the scene's dimension. In a run: a function raised an
            exception, or returned what is no array of numbers. The message begins with `forces[i].electric`,
            `.magnetic` or `.potential`.

    Source: J. D. Jackson, Classical Electrodynamics, 3rd edition (1999), § 6.7 and § 12.1.
    """

    feels_charges: ClassVar[bool] = True
    timed: ClassVar[tuple[str, ...]] = ("electric", "magnetic")
    by_place: ClassVar[bool] = True
    parts: ClassVar[tuple[type, ...]] = READY_FIELDS

    electric: Field = 0.0
    magnetic: Field = 0.0
    potential: Callable[[FloatArray], float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(electric=_field(self.electric, "electric"), magnetic=_field(self.magnetic, "magnetic"))
        if isinstance(self.electric, float) and self.electric != 0.0:
            raise SceneError(f"ElectromagneticField.electric: must be a vector, a function or 0, got {self.electric:g}")
        if self.potential is not None and not callable(self.potential):
            raise SceneError(f"ElectromagneticField.potential: must be a function, got {shown(self.potential)}")
        if self.potential is not None and not callable(self.electric):
            raise SceneError(
                "ElectromagneticField.potential: is for an electric field that is a function; others know it"
            )

    @property
    def is_magnetic(self) -> bool:
        """Whether there is a magnetic field."""
        return _is_there(self.magnetic)

    @property
    def is_electric(self) -> bool:
        """Whether there is an electric field."""
        return _is_there(self.electric)

    @property
    def changes(self) -> bool:
        """Whether a field may depend on time."""
        fields = (part for field in (self.electric, self.magnetic) for part in _parts(field))
        return any(callable(part) or getattr(part, "changes", False) for part in fields)

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The field whose dimension does not fit. In 2D, B is a number or a function, in 3D it is not a number;
        built-in fields have a dimension of their own.
        """
        for name in ("electric", "magnetic"):
            value = getattr(self, name)
            parts = value if isinstance(value, tuple) else (value,)
            for part in parts:
                if isinstance(part, ReadyField) and (
                    part.dimension != dimension or (name, dimension) == ("magnetic", 2)
                ):
                    return name, 3 if name == "magnetic" else part.dimension
        magnetic = self.magnetic
        if isinstance(magnetic, tuple) and isinstance(magnetic[0], float) and dimension == 2:
            return "magnetic", len(magnetic)
        if isinstance(magnetic, float) and magnetic != 0.0 and dimension == 3:
            return "magnetic", 1
        return super().mismatch(dimension)


def _field(value: object, name: str) -> object:
    """The validated form of a field."""
    path = f"ElectromagneticField.{name}"
    parts = value if isinstance(value, (tuple, list)) else (value,)
    if any(isinstance(part, ReadyField) for part in parts):
        for part in parts:
            if not isinstance(part, ReadyField) or not getattr(part, name):
                raise SceneError(f"{path}: must be a sum of {name} fields, got {shown(part)}")
        return value if isinstance(value, ReadyField) else tuple(parts)
    if callable(value) and not isinstance(value, type):
        return value
    if isinstance(value, (int, float)):
        return number(value, path)
    return vector(value, path)


def _parts(field: object) -> tuple[object, ...]:
    """The terms of a field."""
    return field if isinstance(field, tuple) else (field,)


def _is_there(field: object) -> bool:
    """Whether a field is not zero everywhere."""
    vectors = isinstance(field, tuple) and all(isinstance(each, float) for each in field)
    return any(field) if vectors else field != 0.0  # type: ignore[arg-type]

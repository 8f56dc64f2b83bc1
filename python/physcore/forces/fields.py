"""Electric and magnetic fields that the engine computes, for `ElectromagneticField`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from physcore.checks import Vector, number, vector
from physcore.errors import SceneError

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class ReadyField:
    """A field as a function of position and time, of an item of a scene."""

    electric: ClassVar[bool] = True
    """Whether there is an electric field of that form."""
    magnetic: ClassVar[bool] = True
    """Whether there is a magnetic one."""
    changes: ClassVar[bool] = False
    """Whether it changes in time."""

    def __post_init__(self) -> None:
        raise NotImplementedError

    @property
    def dimension(self) -> int:
        """That of the scenes that it is for."""
        return 3

    def _set(self, **values: object) -> None:
        """The values of a frozen instance, checked: numbers and vectors in three dimensions."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _number(self, name: str, **bounds: Any) -> None:
        self._set(**{name: number(getattr(self, name), f"{type(self).__name__}.{name}", **bounds)})

    def _vector(self, name: str, length: int = 3) -> None:
        path = f"{type(self).__name__}.{name}"
        value = vector(getattr(self, name), path)
        if len(value) != length:
            raise SceneError(f"{path}: must have {length} components, got {len(value)}")
        self._set(**{name: value})


@dataclass(frozen=True)
class UniformField(ReadyField):
    """The same field everywhere, to be added to others.

        pc.ElectromagneticField(magnetic=(pc.UniformField((0, 0, 1.0)), pc.MagneticDipole((0, 0, 1e5))))

    Args:
        field: E [V/m] or B [T], in 2D or 3D.

    Raises:
        SceneError: it is not finite, or not in 2D or 3D.
    """

    field: Vector

    def __post_init__(self) -> None:
        self._set(field=vector(self.field, "UniformField.field"))

    @property
    def dimension(self) -> int:
        """That of its vector."""
        return len(self.field)


@dataclass(frozen=True)
class QuadrupoleTrap(ReadyField):
    """The electric field of a Penning trap, E = s (x/2, y/2, −z) about its center, with a potential.

        trap = pc.ElectromagneticField(electric=pc.QuadrupoleTrap(1.0), magnetic=(0.0, 0.0, 6.0))

    Args:
        strength: s [V/m²].
        center: [m].

    Raises:
        SceneError: a value is not finite, or a vector has not 3 components.

    Source: L. S. Brown, G. Gabrielse, Rev. Mod. Phys. 58, 233 (1986), equation (1.2) with s = V₀/d².
    """

    magnetic: ClassVar[bool] = False

    strength: float
    center: Vector = ORIGIN

    def __post_init__(self) -> None:
        self._number("strength")
        self._vector("center")


@dataclass(frozen=True)
class PaulTrap(ReadyField):
    """The electric field of a Paul trap, E = s (x/2, y/2, −z), s = constant + alternating cos(2πft + φ).

        trap = pc.ElectromagneticField(electric=pc.PaulTrap(0.0, 4.0e8, frequency=2.0e6))

    Its potential changes in time: that change is work, so that the energy budget closes.

    Args:
        constant, alternating: the parts of s [V/m²].
        frequency: f [Hz].
        phase: φ [rad].
        center: [m].

    Raises:
        SceneError: a value is not finite, the frequency is not above 0, or a vector has not 3 components.

    Source: W. Paul, Rev. Mod. Phys. 62, 531 (1990).
    """

    magnetic: ClassVar[bool] = False
    changes: ClassVar[bool] = True

    constant: float
    alternating: float
    frequency: float
    phase: float = 0.0
    center: Vector = ORIGIN

    def __post_init__(self) -> None:
        for name in ("constant", "alternating", "phase"):
            self._number(name)
        self._number("frequency", above=0.0)
        self._vector("center")


@dataclass(frozen=True)
class MagneticDipole(ReadyField):
    """The field of a point dipole, B = μ₀/4π (3 (m·r̂) r̂ − m)/r³, such as the Earth's.

        belt = pc.ElectromagneticField(magnetic=pc.MagneticDipole((0.0, 0.0, -8.0e22)))

    Args:
        moment: m [A·m²].
        center: [m].

    Raises:
        SceneError: a value is not finite, or a vector has not 3 components.

    Source: J. D. Jackson, Classical Electrodynamics, 3rd edition (1999), equation (5.56).
    """

    electric: ClassVar[bool] = False

    moment: Vector
    center: Vector = ORIGIN

    def __post_init__(self) -> None:
        self._vector("moment")
        self._vector("center")


@dataclass(frozen=True)
class CurrentLoop(ReadyField):
    """The field of a circular loop of current, by complete elliptic integrals; infinite on the wire.

        mirror = (pc.CurrentLoop(0.1, 1e4, (0, 0, -0.2)), pc.CurrentLoop(0.1, 1e4, (0, 0, 0.2)))
        ions = pc.Particles([[0.0, 0.0, 0.0]], velocities=[[1e4, 0.0, 1e4]], mass=1.7e-27, charge=1.6e-19)
        scene = pc.Scene(ions, pc.ElectromagneticField(magnetic=mirror))

    Args:
        radius: [m].
        current: [A], right-handed about the axis.
        center: [m].
        axis: its direction, of any length.

    Raises:
        SceneError: the radius is not above 0, the axis is 0, a value is not finite, or a vector has not 3 components.

    Source: J. Simpson et al., "Simple analytic expressions for the magnetic field of a circular current loop",
    NASA/TM-2013-217919.
    """

    electric: ClassVar[bool] = False

    radius: float
    current: float
    center: Vector = ORIGIN
    axis: Vector = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        self._number("radius", above=0.0)
        self._number("current")
        self._vector("center")
        self._vector("axis")
        if not any(self.axis):
            raise SceneError(f"CurrentLoop.axis: must not be zero, got {self.axis}")


@dataclass(frozen=True)
class MagneticBottle(ReadyField):
    """The field of a magnetic bottle, B₀ [−xz/L², −yz/L², 1 + (z² − (x² + y²)/2)/L²] about its center.

        bottle = pc.ElectromagneticField(magnetic=pc.MagneticBottle(0.1, length=0.5))

    It is the expansion to second order of any field that is weakest at its center and symmetric about the z axis: it
    has neither sources nor currents.

    Args:
        strength: B₀ [T], at the center.
        length: L, the height above it at which the field on the axis is 2 B₀ [m].
        center: [m].

    Raises:
        SceneError: the length is not above 0, a value is not finite, or a vector has not 3 components.

    Source: L. S. Brown, G. Gabrielse, Rev. Mod. Phys. 58, 233 (1986), section V.
    """

    electric: ClassVar[bool] = False

    strength: float
    length: float
    center: Vector = ORIGIN

    def __post_init__(self) -> None:
        self._number("strength")
        self._number("length", above=0.0)
        self._vector("center")


@dataclass(frozen=True)
class TravellingWave(ReadyField):
    """A plane wave, A cos(k·x − 2πft + φ); an electric one has no potential, so that all it does is work.

        light = pc.TravellingWave((0, 1e6, 0), (2 * math.pi / 1e-6, 0, 0), frequency=3e14)
        electrons = pc.Particles([[0.0, 0.0, 0.0]], mass=9.1e-31, charge=-1.6e-19)
        scene = pc.Scene(electrons, pc.ElectromagneticField(electric=light))

    Args:
        amplitude: A [V/m or T].
        wave_vector: k [rad/m].
        frequency: f [Hz].
        phase: φ [rad].

    Raises:
        SceneError: the frequency is not above 0, a value is not finite, or the vectors have not the same components.
    """

    changes: ClassVar[bool] = True

    amplitude: Vector
    wave_vector: Vector
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        self._set(amplitude=vector(self.amplitude, "TravellingWave.amplitude"))
        self._vector("wave_vector", len(self.amplitude))
        self._number("frequency", above=0.0)
        self._number("phase")

    @property
    def dimension(self) -> int:
        """That of its vectors."""
        return len(self.amplitude)


READY_FIELDS: tuple[type[ReadyField], ...] = (
    UniformField,
    QuadrupoleTrap,
    PaulTrap,
    MagneticDipole,
    CurrentLoop,
    MagneticBottle,
    TravellingWave,
)
"""Every field that the engine computes."""

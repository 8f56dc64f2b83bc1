"""Built-in electric and magnetic fields for `ElectromagneticField`, evaluated by the engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from physcore.checks import Vector, number, vector
from physcore.errors import SceneError

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class ReadyField:
    """Base class of built-in fields: functions of position and time."""

    electric: ClassVar[bool] = True
    """Whether the field can be electric."""
    magnetic: ClassVar[bool] = True
    """Whether the field can be magnetic."""
    changes: ClassVar[bool] = False
    """Whether the field depends on time."""

    def __post_init__(self) -> None:
        raise NotImplementedError

    @property
    def dimension(self) -> int:
        """The dimension of the scenes that the field is for."""
        return 3

    def _set(self, **values: object) -> None:
        """Replace the values of a frozen instance by their validated forms."""
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
    """Uniform field, to be added to other fields.

        pc.ElectromagneticField(magnetic=(pc.UniformField((0, 0, 1.0)), pc.MagneticDipole((0, 0, 1e5))))

    Args:
        field: E [V/m] or B [T], in 2D or 3D.

    Raises:
        SceneError: the field is not finite, or not in 2D or 3D.
    """

    field: Vector

    def __post_init__(self) -> None:
        self._set(field=vector(self.field, "UniformField.field"))

    @property
    def dimension(self) -> int:
        """The dimension of the vector."""
        return len(self.field)


@dataclass(frozen=True)
class QuadrupoleTrap(ReadyField):
    """Electric field of a Penning trap, E = s (x/2, y/2, −z) about its center, with a potential.

        trap = pc.ElectromagneticField(electric=pc.QuadrupoleTrap(1.0), magnetic=(0.0, 0.0, 6.0))

    Args:
        strength: s [V/m²].
        center: center of the trap [m].

    Raises:
        SceneError: a value is not finite, or a vector does not have 3 components.

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
    """Electric field of a Paul trap, E = s (x/2, y/2, −z), s = constant + alternating cos(2πft + φ).

        trap = pc.ElectromagneticField(electric=pc.PaulTrap(0.0, 4.0e8, frequency=2.0e6))

    The potential depends on time. Its change counts as work, so that the energy budget closes.

    Args:
        constant, alternating: the constant part and the amplitude of s [V/m²].
        frequency: f [Hz].
        phase: φ [rad].
        center: center of the trap [m].

    Raises:
        SceneError: a value is not finite, the frequency is not above 0, or a vector does not have 3 components.

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
    """Magnetic field of a point dipole, B = μ₀/4π (3 (m·r̂) r̂ − m)/r³, such as the Earth's.

        belt = pc.ElectromagneticField(magnetic=pc.MagneticDipole((0.0, 0.0, -8.0e22)))

    Args:
        moment: m [A·m²].
        center: position of the dipole [m].

    Raises:
        SceneError: a value is not finite, or a vector does not have 3 components.

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
    """Magnetic field of a circular current loop, by complete elliptic integrals; infinite on the wire.

        mirror = (pc.CurrentLoop(0.1, 1e4, (0, 0, -0.2)), pc.CurrentLoop(0.1, 1e4, (0, 0, 0.2)))
        ions = pc.Particles([[0.0, 0.0, 0.0]], velocities=[[1e4, 0.0, 1e4]], mass=1.7e-27, charge=1.6e-19)
        scene = pc.Scene(ions, pc.ElectromagneticField(magnetic=mirror))

    Args:
        radius: radius of the loop [m].
        current: current [A], right-handed about the axis.
        center: center of the loop [m].
        axis: direction of the axis, a vector of any length.

    Raises:
        SceneError: the radius is not above 0, the axis is 0, a value is not finite, or a vector does not have 3
            components.

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
    """Magnetic field of a magnetic bottle, B₀ [−xz/L², −yz/L², 1 + (z² − (x² + y²)/2)/L²] about its center.

        bottle = pc.ElectromagneticField(magnetic=pc.MagneticBottle(0.1, length=0.5))

    This is the second-order expansion of any field that is weakest at its center and symmetric about the z axis. The
    field has neither sources nor currents.

    Args:
        strength: B₀ [T], at the center.
        length: L, the height above the center at which the field on the axis is 2 B₀ [m].
        center: center of the bottle [m].

    Raises:
        SceneError: the length is not above 0, a value is not finite, or a vector does not have 3 components.

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
    """Plane wave, A cos(k·x − 2πft + φ). An electric wave has no potential and does external work.

        light = pc.TravellingWave((0, 1e6, 0), (6.283e6, 0, 0), frequency=3e14)
        electrons = pc.Particles([[0.0, 0.0, 0.0]], mass=9.1e-31, charge=-1.6e-19)
        scene = pc.Scene(electrons, pc.ElectromagneticField(electric=light))

    Args:
        amplitude: A [V/m or T].
        wave_vector: k [rad/m].
        frequency: f [Hz].
        phase: φ [rad].

    Raises:
        SceneError: the frequency is not above 0, a value is not finite, or the vectors differ in size.
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
        """The dimension of the vectors."""
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
"""All built-in fields."""

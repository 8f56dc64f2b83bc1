"""Bodies: particles, and particles connected by springs. Bodies are immutable, and serve as keys into results."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import lengths
from physcore.checks import (
    DIMENSIONS,
    BoolArray,
    FloatArray,
    IntArray,
    array,
    broadcast,
    frozen,
    mask,
    regular,
    require,
    text,
)
from physcore.errors import SceneError
from physcore.scene.fields import Element
from physcore.units.systems import Default

ROUNDED = 1e-4
"""Tolerance of a rod's length, relative, as for coordinates in f32; its ends are moved to fit."""
BEYOND = 1e-3
"""Tolerance of the largest length of a spring at the start, relative, equal to the residual error of impulses."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Body:
    """Base class of bodies: N particles in D dimensions.

        isinstance(cloth, pc.Body)  # True
        len(cloth), cloth.positions, cloth.mass

    Particles, SpringNetwork, Fluid and RigidBodies are bodies.
    """

    positions: FloatArray
    """Positions [m], shape (N, D)."""
    velocities: FloatArray
    """Velocities [m/s], shape (N, D)."""
    mass: FloatArray
    """Mass of each particle [kg], shape (N,)."""
    charge: FloatArray
    """Charge of each particle [C], shape (N,)."""
    radius: FloatArray
    """Radius of each particle [m], shape (N,)."""
    fixed: BoolArray
    """Mask of the particles that keep their given velocity, shape (N,)."""
    name: str | None
    """Name of the body, also a key into results."""

    section: ClassVar[str] = "bodies"
    is_fluid: ClassVar[bool] = False
    """Whether the body is a fluid."""
    is_loose: ClassVar[bool] = True
    """Whether the particles of the body do not act on each other of themselves."""
    is_rigid: ClassVar[bool] = False
    """Whether the body consists of rigid bodies, which are no particles."""

    @property
    def dimension(self) -> int:
        """The dimension of space, 2 or 3."""
        return int(self.positions.shape[1])

    @property
    def elements(self) -> dict[Element, int]:
        """The kinds of elements that have values in the fields of a scene, with their numbers."""
        return {"particles": len(self), "walls": 1}

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the fields that a scene has because of this body."""
        return ()

    @property
    def motion(self) -> FloatArray:
        """The velocities at the start, followed by the angular velocities if there are any, shape (N, K)."""
        return self.velocities

    @property
    def network(self) -> SpringNetwork | None:
        """The body as a spring network, if it is one."""
        return None

    @property
    def defaults(self) -> dict[str, Default]:
        """Arguments with a dimension that were left at their defaults, by name."""
        return {name: value for name, value in vars(self).items() if isinstance(value, Default)}

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        return f"{type(self).__name__}({label}{len(self)} particles in {self.dimension}D)"

    def __setstate__(self, state: dict[str, object]) -> None:
        """Make the arrays of a copy or an unpickled body read-only."""
        self._set(**state)

    def _set(self, **values: object) -> None:
        """Set fields of the frozen dataclass; only for constructors."""
        for name, value in values.items():
            object.__setattr__(self, name, frozen(value) if isinstance(value, np.ndarray) else value)

    def _set_particles(
        self,
        positions: ArrayLike,
        velocities: ArrayLike,
        mass: ArrayLike,
        charge: ArrayLike,
        radius: ArrayLike,
        fixed: ArrayLike | None,
        name: str | None,
    ) -> None:
        """Check, copy and store the fields of all particles."""
        kind = type(self).__name__
        points = array(positions, f"{kind}.positions")
        if points.ndim != 2 or points.shape[1] not in DIMENSIONS:
            raise SceneError(
                f"{kind}.positions: must have the shape (N, 2) or (N, 3), got {points.shape}; "
                "one particle is [[x, y]], none are np.empty((0, 2))"
            )
        number = len(points)
        masses = broadcast(mass, (number,), f"{kind}.mass")
        require(masses > 0, masses, f"{kind}.mass", "> 0 (to hold a particle in place use fixed=)")
        radii = broadcast(radius, (number,), f"{kind}.radius")
        require(radii >= 0, radii, f"{kind}.radius", "≥ 0")
        self._set(
            positions=points,
            velocities=broadcast(velocities, points.shape, f"{kind}.velocities"),
            mass=masses,
            charge=broadcast(charge, (number,), f"{kind}.charge"),
            radius=radii,
            fixed=mask(fixed, number, f"{kind}.fixed"),
            name=None if name is None else text(name, f"{kind}.name"),
        )


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Particles(Body):
    """Independent particles.

        balls = pc.Particles([[0.0, 1.0], [0.5, 1.2]], velocities=[[1.0, 0.0], [0.0, 0.0]], radius=0.05, name="balls")

    Args:
        positions: positions [m], shape (N, D) with D = 2 or 3.
        velocities: velocities [m/s], broadcast to (N, D).
        mass: mass of each particle [kg], broadcast to (N,), above zero.
        charge: charge of each particle [C], broadcast to (N,).
        radius: radius of each particle [m], broadcast to (N,); contact with boundaries is at center ± radius.
        fixed: a bool mask of shape (N,), or integer indices. A fixed particle feels no force and keeps its velocity.
        name: name of the body, also a key into results.

    Raises:
        SceneError: a shape does not fit, or a value is not finite or out of range.
    """

    def __init__(
        self,
        positions: ArrayLike,
        velocities: ArrayLike = 0.0,
        mass: ArrayLike = 1.0,
        charge: ArrayLike = 0.0,
        radius: ArrayLike = 0.0,
        fixed: ArrayLike | None = None,
        name: str | None = None,
    ) -> None:
        self._set_particles(positions, velocities, mass, charge, radius, fixed, name)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class SpringNetwork(Body):
    """Particles connected by damped linear springs.

        corners, sides = [[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 2], [2, 0]]
        triangle = pc.SpringNetwork(corners, pairs=sides, stiffness=100.0, fixed=[0])

    A spring of length l and direction n between the particles i and j exerts the attractive force k (l − l₀) + c (v_j −
    v_i)·n, along n [N].

    Args:
        positions: positions [m], shape (N, D) with D = 2 or 3.
        pairs: indices of the two particles that each spring connects, shape (M, 2).
        stiffness: k of each spring [N/m], broadcast to (M,), at least zero. math.inf gives a rod of constant length and
            without damping. The ends of a rod must be at its rest length. Rods require RATTLE or XPBD.
        damping: c of each spring, along the spring [N·s/m], broadcast to (M,), at least zero.
        rest_length: l₀ of each spring [m], broadcast to (M,); None: the lengths that the springs have in `positions`.
        mass, fixed, velocities, charge, radius, name: as in Particles.
        breaking_strain: strain (l − l₀)/l₀ of each spring beyond which it breaks, broadcast to (M,), at least zero;
            infinite by default. A broken spring is removed at the end of the step, and its energy is dissipated as
            "tearing". `recording[network].broken` has the broken springs. Rods, and springs of rest length 0, cannot
            break.
        strain_limit: largest strain (l − l₀)/l₀ of each spring, broadcast to (M,), at least zero; infinite by default.
            At the limit a spring acts as a rod until it becomes shorter. Impulses along it keep its length, with an
                error
            of 1e-4 if few springs are at their limits. Their losses are dissipated by "contacts". A spring with a limit
            and without stiffness is a string. Rods, and springs of rest length 0, have no limit.
        faces: indices of the three corners of each triangle of a surface, shape (T, 3); None: no surface. Rigid bodies
            meet faces; `physcore.styles.Surface` (drawing), `SelfContact` and `Dihedral` (bending) use them too. They
            exert no force themselves.

    Raises:
        SceneError: a shape does not fit, an index or a value is out of range, a value is not finite, or the ends of a
            rod
            are not at its rest length.
    """

    is_loose: ClassVar[bool] = False

    pairs: IntArray
    """Indices of the particles that each spring connects, shape (M, 2)."""
    stiffness: FloatArray
    """Stiffness of each spring [N/m], shape (M,)."""
    damping: FloatArray
    """Damping along each spring [N·s/m], shape (M,)."""
    rest_length: FloatArray
    """Rest length of each spring [m], shape (M,)."""
    breaking_strain: FloatArray
    """Strain beyond which each spring breaks, shape (M,)."""
    strain_limit: FloatArray
    """Largest strain of each spring, shape (M,)."""
    faces: IntArray
    """Indices of the corners of each triangle of the surface, shape (T, 3)."""

    def __init__(
        self,
        positions: ArrayLike,
        pairs: ArrayLike,
        stiffness: ArrayLike,
        damping: ArrayLike = 0.0,
        rest_length: ArrayLike | None = None,
        mass: ArrayLike = 1.0,
        fixed: ArrayLike | None = None,
        velocities: ArrayLike = 0.0,
        charge: ArrayLike = 0.0,
        radius: ArrayLike = 0.0,
        name: str | None = None,
        faces: ArrayLike | None = None,
        breaking_strain: ArrayLike = math.inf,
        strain_limit: ArrayLike = math.inf,
    ) -> None:
        self._set_particles(positions, velocities, mass, charge, radius, fixed, name)
        links = indices(pairs, 2, len(self), "SpringNetwork.pairs")
        self._set(faces=indices([] if faces is None else faces, 3, len(self), "SpringNetwork.faces"))
        if rest_length is None:
            with np.errstate(over="ignore"):  # Overflow gives infinity, which is refused below.
                rest_length = lengths(self.positions[links[:, 1]] - self.positions[links[:, 0]])
        springs = {
            "stiffness": stiffness,
            "damping": damping,
            "rest_length": rest_length,
            "breaking_strain": breaking_strain,
            "strain_limit": strain_limit,
        }
        self._set(pairs=links)
        for column, value in springs.items():
            path = f"SpringNetwork.{column}"
            values = broadcast(value, (len(links),), path, finite=column in ("damping", "rest_length"))
            require(values >= 0, values, path, "≥ 0")
            self._set(**{column: values})
        self._check_rods()
        self._check_strains()

    @property
    def elements(self) -> dict[Element, int]:
        """The numbers of particles and springs."""
        return {**super().elements, "springs": len(self.pairs)}

    @property
    def quantities(self) -> tuple[str, ...]:
        """The tensions of rods, and which springs are broken."""
        return ("tensions",) * bool(self.rods.any()) + ("broken",) * self.can_tear

    @property
    def network(self) -> SpringNetwork | None:
        """The network itself."""
        return self

    @property
    def rods(self) -> BoolArray:
        """Mask of the springs that are rods, shape (M,)."""
        return np.isinf(self.stiffness)

    @property
    def can_tear(self) -> bool:
        """Whether a spring can break."""
        return bool(np.isfinite(self.breaking_strain).any())

    def _check_strains(self) -> None:
        """Check that springs with a breaking strain or a limit have a strain, unlike rods or springs of no length."""
        for column in ("breaking_strain", "strain_limit"):
            strains = getattr(self, column)
            strainless = np.isfinite(strains) & (self.rods | (self.rest_length == 0.0))
            if strainless.any():
                row = int(np.argmax(strainless))
                what = "a rod" if self.rods[row] else "a spring of rest length 0"
                raise SceneError(
                    f"SpringNetwork.{column}[{row}]: must be infinite for {what}, which has no strain, "
                    f"got {strains[row]:g}"
                )
        whole = np.isfinite(self.breaking_strain) & (self.strain_limit < self.breaking_strain)
        if whole.any():
            row = int(np.argmax(whole))
            raise SceneError(
                f"SpringNetwork.strain_limit[{row}]: must be at least the breaking_strain of "
                f"{self.breaking_strain[row]:g}, which the spring would never reach, got {self.strain_limit[row]:g}"
            )
        limited = np.flatnonzero(np.isfinite(self.strain_limit))
        ends = self.positions[self.pairs[limited]]
        apart = lengths(ends[:, 1] - ends[:, 0])
        with np.errstate(over="ignore"):  # an overflow to infinity is no limit
            longest = (1.0 + self.strain_limit[limited]) * self.rest_length[limited]
            beyond = apart > (1.0 + BEYOND) * longest
        if beyond.any():
            row = int(np.argmax(beyond))
            raise SceneError(
                f"SpringNetwork.strain_limit[{limited[row]}]: the spring gets {longest[row]:g} m long at most, but its "
                f"ends are {apart[row]:g} m apart"
            )

    def _check_rods(self) -> None:
        """Check that the ends of rods are at their rest lengths, which are not zero."""
        rods = np.flatnonzero(self.rods)
        ends, rest_length = self.positions[self.pairs[rods]], self.rest_length[rods]
        apart = lengths(ends[:, 1] - ends[:, 0])
        path = "SpringNetwork.rest_length"
        wrong = ~(np.abs(apart - rest_length) <= ROUNDED * rest_length) | (rest_length == 0.0)
        if wrong.any():
            row = int(np.argmax(wrong))
            raise SceneError(
                f"{path}[{rods[row]}]: a rod of {rest_length[row]:g} m, whose ends are {apart[row]:g} m apart; "
                "leave rest_length out, and place its ends at the length that it has to have"
            )


def indices(value: ArrayLike, width: int, number: int, path: str) -> IntArray:
    """Validated indices of particles, shape (M, width); negative indices count from the end."""
    given = regular(value, path)
    if given.size == 0:
        return np.empty((0, width), dtype=np.int64)
    if given.dtype.kind not in "iu" or given.ndim != 2 or given.shape[1] != width:
        raise SceneError(f"{path}: must be integers of shape (M, {width}), got {given.dtype} of shape {given.shape}")
    outside = (given < -number) | (given >= number)
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise SceneError(f"{path}[{row}, {column}]: index {given[row, column]} is outside of the {number} particles")
    indices = given.astype(np.int64)
    indices[indices < 0] += number
    twice = np.diff(np.sort(indices, axis=1), axis=1).min(axis=1) == 0
    if twice.any():
        row = int(np.argmax(twice))
        one = int(np.sort(indices[row])[:-1][np.diff(np.sort(indices[row])) == 0][0])
        raise SceneError(f"{path}[{row}]: connects particle {one} with itself")
    return np.ascontiguousarray(indices)

"""Periodic domain, in which particles that leave on one side enter on the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physcore.checks import FloatArray, IntArray, Vector, vector
from physcore.errors import SceneError


@dataclass(frozen=True)
class Periodic:
    """Periodic domain along some or all axes; at most one in a scene.

        atoms = pc.Particles(pc.block((0.0, 0.0), (10.0, 10.0), 1.2), velocities=0.1)
        scene = pc.Scene(atoms, pc.LennardJones(1.0, 1.0), pc.Periodic((0.0, 0.0), (10.0, 10.0)))

    Pair forces and fluids act across its faces, by the minimum image convention. Positions of a simulation, of
    recordings and of films are wrapped into the domain. Springs, boundaries, central and custom forces, and the angular
    momentum use unwrapped positions. Rigid bodies that may touch something are refused.

    Args:
        lower: the lower end along each axis [m]; −inf along an axis that is not periodic.
        upper: the upper end along each axis [m]; inf along an axis that is not periodic.

    Raises:
        SceneError: `lower` is not below `upper`, an axis is infinite at one end only, or no axis is periodic.
    """

    section: ClassVar[str] = "domains"

    lower: Vector
    upper: Vector

    def __post_init__(self) -> None:
        lower, upper = (vector(getattr(self, end), f"Periodic.{end}", finite=False) for end in ("lower", "upper"))
        if len(lower) != len(upper):
            raise SceneError(
                f"Periodic.upper: must have {len(lower)} components like the lower corner, got {len(upper)}"
            )
        for axis, (low, high) in enumerate(zip(lower, upper, strict=True)):
            if not low < high:
                raise SceneError(f"Periodic.upper[{axis}]: must be above the lower end {low:g}, got {high:g}")
            if math.isinf(low) != math.isinf(high):
                raise SceneError(
                    f"Periodic.upper[{axis}]: an axis is periodic between two finite ends, or (−inf, inf) where it is "
                    f"not; got ({low:g}, {high:g})"
                )
            if math.isfinite(low) and not math.isfinite(high - low):
                raise SceneError(f"Periodic.upper[{axis}]: the length from {low:g} to {high:g} is not a finite number")
        if not any(math.isfinite(low) for low in lower):
            raise SceneError("Periodic.lower: no axis is periodic; leave Periodic out")
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)

    @property
    def dimension(self) -> int:
        """The dimension of space, 2 or 3."""
        return len(self.lower)

    @property
    def lengths(self) -> FloatArray:
        """The period along each axis [m], shape (D,); inf along an axis that is not periodic."""
        lengths: FloatArray = np.array(self.upper) - np.array(self.lower)
        return lengths

    def holds(self, point: Vector) -> bool:
        """Whether a point is in the domain, including its ends."""
        return all(low <= x <= high for low, x, high in zip(self.lower, point, self.upper, strict=True))

    def wrap(self, positions: FloatArray) -> FloatArray:
        """Positions wrapped into the domain: lower ≤ x < upper along each periodic axis; shape (…, D).

        Positions within the domain keep their bits.
        """
        result = positions.copy()
        for axis, length in enumerate(self.lengths.tolist()):
            if math.isinf(length):
                continue
            low, high, x = self.lower[axis], self.upper[axis], positions[..., axis]
            wrapped = x - length * np.floor((x - low) / length)
            # By rounding, the result can be slightly below the lower end, or at the upper end: both mean the lower end.
            result[..., axis] = np.where((x < low) | (x >= high), _within(wrapped, low, high), x)
        return result

    def nearest(self, displacements: FloatArray) -> FloatArray:
        """Displacements to the nearest image [m], shape (…, D): at most half a period along each periodic axis."""
        result = displacements.copy()
        for axis, length in enumerate(self.lengths.tolist()):
            if math.isfinite(length):
                result[..., axis] -= length * np.rint(displacements[..., axis] / length)
        return result

    def with_images(self, positions: FloatArray, reach: float) -> tuple[FloatArray, IntArray]:
        """Points (N, D) wrapped into the domain, followed by images of those within `reach` of a lower face [m].

        Returns:
            The points (M, D), and the index of the original of each (M,).
        """
        points = self.wrap(positions)
        indices = np.arange(len(points))
        for axis, length in enumerate(self.lengths.tolist()):
            if math.isfinite(length):
                near = points[:, axis] < self.lower[axis] + reach
                images = points[near]
                images[:, axis] += length
                points, indices = np.concatenate([points, images]), np.concatenate([indices, indices[near]])
        return points, indices


def _within(x: FloatArray, low: float, high: float) -> FloatArray:
    return np.where((x < low) | (x >= high), low, x)

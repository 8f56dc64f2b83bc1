"""Gaps between boundaries, and their resolution by the particles of fluids."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from typing import NamedTuple, TypeAlias

import numpy as np

from physcore.arithmetic import dots, lengths
from physcore.boundaries import Box, Capsule, ConvexHull, Plane, Sphere
from physcore.checks import FloatArray
from physcore.scene.items import SceneItem
from physcore.scene.scene import Scene

OPEN = 0.1
"""Least width of a gap, in spacings of the fluid; solids that are nearer to each other count as touching."""

FEWEST = 6
"""Number of rows of particles across a gap below which it is noted."""

LOSSES = {
    1.5: "50 % to 100 % less",
    2.5: "20 % to 80 % less",
    3.5: "8 % to 40 % less",
    4.5: "5 % to 25 % less",
    FEWEST: "2 % to 15 % less",
}
"""How much less a gap lets through than a wide one, by the largest number of rows of particles across it.

Measured in slots below a gate, between bars and in a plate with sharp edges; the last loses most.
"""

FINE = 8
"""Number of rows of particles across a gap at which it lets through 5 % less at most."""

ACCURACY = 0.02
"""Accuracy of a width, in spacings."""

STEPS = 200
"""Most steps in the search for the nearest points of two solids."""


class Gap(NamedTuple):
    """Gap between two boundaries."""

    places: tuple[int, int]
    width: float
    """Width [m]."""
    rows: float
    """Width in spacings of the fluid."""


class Solid(NamedTuple):
    """Convex hull of points, enlarged by a radius."""

    points: FloatArray
    """Points (K, D) [m]."""
    radius: float


class Wall(NamedTuple):
    """Half-space, whose free side is that of its normal."""

    point: FloatArray
    normal: FloatArray


class Bowl(NamedTuple):
    """Exterior of a sphere."""

    center: FloatArray
    radius: float


Part: TypeAlias = Solid | Wall | Bowl
"""Part of a boundary."""


def narrow(scene: Scene) -> list[str]:
    """A note on the narrowest gap between two boundaries, if few particles of a fluid fit into it."""
    found = sorted(_gaps(scene), key=lambda gap: gap.rows)
    loss = next((loss for most, loss in LOSSES.items() if found and found[0].rows < most), None)
    if loss is None:
        return []
    (first, second), width, rows = found[0]
    others = sum(other.rows < FEWEST for other in found[1:])
    more = f"; {others} more have fewer than {FEWEST}" if others else ""
    return [
        f"boundaries[{first}] and boundaries[{second}]: {rows:.2g} particles fit into the gap of {width:.2g} m between "
        f"them, which lets {loss} through than it should; a spacing of {width / FINE:.2g} m keeps 5 %{more}"
    ]


def _gaps(scene: Scene) -> Iterator[Gap]:
    """The gaps between any two boundaries of a fluid."""
    parts = [_parts(boundary.resolved(scene.dimension)) for boundary in scene.boundaries]
    bodies = [
        {scene.index(fluid): fluid.spacing for fluid in scene.fluids if fluid in scene.targets(boundary)}
        for boundary in scene.boundaries
    ]
    for one, other in combinations(range(len(parts)), 2):
        theirs = [spacing for body, spacing in bodies[one].items() if body in bodies[other]]
        if theirs:
            spacing = max(theirs)
            widths = [_width(first, second, spacing) for first, second in product(parts[one], parts[other])]
            width = min((width for width in widths if width >= OPEN * spacing), default=np.inf)
            yield Gap((one, other), width, round(width / spacing, 6))


def _parts(boundary: SceneItem) -> list[Part]:
    """The parts of a boundary; none of a height field, whose valleys are another matter."""
    match boundary:
        case Plane():
            return [Wall(np.array(boundary.point), np.array(boundary.normal))]
        case Box(inside=True):
            lower, upper, axes = np.array(boundary.lower), np.array(boundary.upper), np.eye(len(boundary.lower))
            return [*(Wall(lower, axis) for axis in axes), *(Wall(upper, -axis) for axis in axes)]
        case Box():
            return [Solid(np.array(list(product(*zip(boundary.lower, boundary.upper, strict=True)))), 0.0)]
        case Sphere(inside=True):
            return [Bowl(np.array(boundary.center), boundary.radius)]
        case Sphere():
            return [Solid(np.array([boundary.center]), boundary.radius)]
        case Capsule():
            return [Solid(np.array([boundary.start, boundary.end]), boundary.radius)]
        case ConvexHull():
            return [Solid(boundary.points, 0.0)]
    return []


def _width(one: Part, other: Part, spacing: float) -> float:
    """The width of the gap between two parts [m]; infinite if they meet, or enclose no gap."""
    if not isinstance(one, Solid):
        one, other = other, one
    match one, other:
        case Solid(), Solid():
            return _between(one, other, ACCURACY * spacing)
        case Solid(), Wall():
            return float(dots(one.points - other.point, other.normal).min()) - one.radius
        case Solid(), Bowl():
            return other.radius - float(lengths(one.points - other.center).max()) - one.radius
        case Wall(), Wall() if (one.normal == -other.normal).all():
            return float(dots(other.point - one.point, one.normal))
    return np.inf


def _between(one: Solid, other: Solid, accuracy: float) -> float:
    """The distance between two solids [m]: that of the hull of all differences of their points from the origin.

    A point x of the hull is a mean of the differences p. The smallest x·p/|x| bounds the distance from below; weight is
    moved to its difference from the one with the largest. Source: B. F. Mitchell, V. F. Dem'yanov, V. N. Malozemov,
    SIAM J. Control 12, 19 (1974).
    """
    radii = one.radius + other.radius
    differences = (other.points[:, np.newaxis] - one.points).reshape(-1, one.points.shape[1])
    weights = np.zeros(len(differences))
    weights[0], x = 1.0, differences[0]
    for _ in range(STEPS):
        products, length = dots(differences, x), float(lengths(x))
        nearest, farthest = int(products.argmin()), int(np.where(weights > 0.0, products, -np.inf).argmax())
        if length <= radii + accuracy or products[nearest] >= length * (length - accuracy):
            break
        way = differences[nearest] - differences[farthest]
        moved = min(float(weights[farthest]), float(dots(x, -way) / dots(way, way)))
        weights[nearest] += moved
        weights[farthest] -= moved
        x = x + moved * way
    return float(lengths(x)) - radii

"""Convex hull of points, as an obstacle."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from physcore._core import convex_hull
from physcore.checks import FloatArray, IntArray, array, frozen
from physcore.errors import SceneError
from physcore.scene.items import Boundary
from physcore.scene.targets import On


@dataclass(frozen=True, eq=False, init=False, repr=False)
class ConvexHull(Boundary):
    """Convex hull of points: the smallest convex solid that contains them, a polygon in 2D. Particles stay outside.

        grains = pc.Particles(rng.uniform((0.1, 0.6), (0.9, 1.0), (50, 2)), radius=0.01)
        ramp = pc.ConvexHull([[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]], friction=0.2)
        scene = pc.Scene(grains, ramp, pc.Floor(), pc.Gravity((0.0, -9.81)))

    Several solids that touch or overlap act as their union. Stairs, for example, are boxes (`Box(…, inside=False)`). A
    particle of radius r meets an edge as a cylinder and a corner as a sphere, both of radius r.

    Args:
        points: points [m], shape (V, 2) or (V, 3), any number. Points inside the hull have no effect. The nearest
            facet is found by a search of all, so that a step takes a time in proportion to their number.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: the points span no area or volume, or a value is not finite.
    """

    points: FloatArray

    def __init__(
        self,
        points: ArrayLike,
        *,
        restitution: float = 1.0,
        friction: float = 0.0,
        no_slip: bool = False,
        on: On = None,
    ) -> None:
        values = array(points, "ConvexHull.points")
        if values.ndim != 2 or values.shape[1] not in (2, 3):
            raise SceneError(f"ConvexHull.points: must have the shape (V, 2) or (V, 3), got {values.shape}")
        self._set(points=frozen(values), restitution=restitution, friction=friction, no_slip=no_slip, on=on)
        self.__post_init__()
        if not self.facets():
            spanned = "an area" if self.dimension == 2 else "a volume"
            raise SceneError(f"ConvexHull.points: must span {spanned}, got points that are flat")

    def __repr__(self) -> str:
        return f"ConvexHull({len(self.points)} points in {self.dimension}D)"

    @property
    def dimension(self) -> int:
        """The dimension of space, 2 or 3."""
        return int(self.points.shape[1])

    def facets(self) -> list[IntArray]:
        """The vertex indices of every facet, counterclockwise as seen from outside; in 2D, of every side."""
        return [frozen(facet) for facet in convex_hull(self.points)]

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The name and dimension of the points, if they do not have `dimension` components; otherwise None."""
        return None if self.dimension == dimension else ("points", self.dimension)

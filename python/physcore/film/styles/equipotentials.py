"""Equipotential lines of the electric field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, array, count, number
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import BodyStyle, Painter, Part, inks
from physcore.film.styles.charges import Fields, mixed, require
from physcore.simulation.sources import Source, SourceFrame

CELL = 5.0
"""Size of the grid cells on which the potential is linearly interpolated [pixels]."""
MOST = 1000
"""Largest number of levels."""


@dataclass(frozen=True)
class Equipotentials(BodyStyle):
    """Equipotential lines of the electric field, for 2D scenes.

        styles = [pc.styles.Equipotentials(), pc.styles.FieldLines(), pc.styles.Points()]
        pc.film(recording, "dipole.gif", style=styles)

    The potential is that of all charges under Coulomb() and of all fields with a potential. It is linearly interpolated
    over triangles of five pixels, and contoured at each level.

    Args:
        levels: potentials [V], one or more. Or a number of levels, at equal steps over the visible range of the first
            frame without its extremes near charges.
        width: width of the lines [pixels].
        strength: contrast of the lines with the background, from 0 to 1.
        on: as in Style; the potential is that of the whole scene.

    Raises:
        SceneError: a value is out of range, the scene is in 3D, or it has no electric field with a potential.
    """

    overlay: ClassVar[bool] = True
    dimensions: ClassVar[tuple[int, ...]] = (2,)

    levels: int | Sequence[float] = 15
    width: float = 1.0
    strength: float = 0.4

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.levels, int):
            levels: object = count(self.levels, "Equipotentials.levels", least=1, most=MOST)
        else:
            levels = tuple(np.unique(array(self.levels, "Equipotentials.levels")).tolist())
            if not levels or len(levels) > MOST:
                raise SceneError(f"Equipotentials.levels: must be 1 to {MOST} potentials, got {len(levels)}")
        self._set(
            levels=levels,
            width=number(self.width, "Equipotentials.width", above=0.0),
            strength=number(self.strength, "Equipotentials.strength", above=0.0, most=1.0),
        )

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter of one film."""
        del parts
        if source.scene.dimension != 2:
            raise SceneError("Equipotentials: show the plane, and this scene is in 3D; FieldLines() shows space")
        require(source.scene, "electric", "Equipotentials")
        return EquipotentialsPainter(self, source, theme)


class EquipotentialsPainter(Painter):
    """Painter of equipotential lines."""

    def __init__(self, style: Equipotentials, source: Source, theme: Theme) -> None:
        self.style, self._style, self._scene, self._theme = style, style, source.scene, theme
        self._levels = np.array([]) if isinstance(style.levels, int) else np.array(style.levels)

    @property
    def settled(self) -> bool:
        """True: there is no color scale."""
        return True

    def begin(self) -> None:
        """Reset automatic levels, which the first frame determines."""
        if isinstance(self._style.levels, int):
            self._levels = np.array([])

    def observe(self, frame: SourceFrame) -> None:
        """Do nothing: the painter does not depend on the whole film."""

    def inset(self, pixels: float) -> float:
        """Half the width of a line."""
        del pixels
        return self._style.width / 2

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the lines of all levels."""
        del pixels
        columns, rows = (2 + int(2.0 * middle / CELL) for middle in view.middle)
        corner = view.center - np.array(view.middle) / view.scale
        places = corner + CELL / view.scale * np.indices((columns, rows)).reshape(2, -1).T
        values = Fields(self._scene, frame).potential(places).reshape(columns, rows)
        if len(self._levels) == 0:
            low, high = np.nanpercentile(values, (3.0, 97.0))
            assert isinstance(self._style.levels, int)
            self._levels = np.linspace(low, high, self._style.levels + 2)[1:-1]
        cuts = contours(values, self._levels)
        ends = [view.project(corner + CELL / view.scale * cuts[:, end])[0] for end in (0, 1)]
        lines = np.concatenate(ends, axis=1)
        ink = inks(np.tile(mixed(self._theme, self._style.strength), (len(lines), 1)), self._theme, None)
        canvas.lines(lines, np.full(len(lines), self._style.width, np.float32), ink)


def contours(values: FloatArray, levels: FloatArray) -> FloatArray:
    """Contour lines of a function that is linear over the triangles of a grid.

    The function is given by its values (M, N) at the corners. The result has straight segments (S, 2, 2), in units of
    cells. Triangles with a value that is not finite have none.
    """
    index = np.indices(values.shape).reshape(2, *values.shape)
    a, b, c, d = (
        part.reshape(2, -1).T for part in (index[:, :-1, :-1], index[:, 1:, :-1], index[:, 1:, 1:], index[:, :-1, 1:])
    )
    corners = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    heights = values[corners[..., 0], corners[..., 1]]
    corners, heights = corners[np.isfinite(heights).all(axis=1)], heights[np.isfinite(heights).all(axis=1)]
    order = np.argsort(heights, axis=1)
    heights = np.take_along_axis(heights, order, axis=1)
    corners = np.take_along_axis(corners, order[..., np.newaxis], axis=1).astype(float)
    cuts = []
    for level in levels:
        cut = (heights[:, 0] < level) & (heights[:, 2] >= level)
        below, points = heights[cut] - level, corners[cut]
        long, lower, upper = (_crossing(below, points, *pair) for pair in ((0, 2), (0, 1), (1, 2)))
        cuts.append(np.stack([long, np.where(below[:, 1:2] >= 0.0, lower, upper)], axis=1))
    return np.concatenate(cuts) if cuts else np.empty((0, 2, 2))


def _crossing(heights: FloatArray, points: FloatArray, one: int, other: int) -> FloatArray:
    """The zeros of linear functions on the edges of triangles between two corners; arbitrary points if there is no
    zero.
    """
    rise = heights[:, other] - heights[:, one]
    share = np.clip(-heights[:, one] / np.where(rise > 0.0, rise, 1.0), 0.0, 1.0)[:, np.newaxis]
    return points[:, one] + share * (points[:, other] - points[:, one])

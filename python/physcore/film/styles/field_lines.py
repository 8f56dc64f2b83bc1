"""Field lines of electric and magnetic fields."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, count, number, word
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.styles.arrows import heads
from physcore.film.styles.base import BodyStyle, Painter, Part, inks
from physcore.film.styles.charges import Fields, Kind, mixed, places_of, require
from physcore.simulation.sources import Source, SourceFrame

STEPS = 360
"""Number of steps of a line in each direction."""
STEP = 1.0 / 90.0
"""Length of a step, relative to half the longer side of the view."""
BEYOND = 2.5
"""Distance from the center at which lines end, relative to half the longer side of the view."""
CLOSE = 0.6
"""Distance from a charge at which a line ends [steps]."""
SHORTEST = STEPS // 18
"""Number of steps of the shortest line that is drawn."""
SAME = 1e-9
"""Change of the center and the size of the view, relative to its size, that is the rounding of a camera that turns."""
GOLDEN = np.pi * (3.0 - np.sqrt(5.0))
"""The golden angle between successive points on a sphere [rad]."""


@dataclass(frozen=True)
class FieldLines(BodyStyle):
    """Field lines: curves along the electric or the magnetic field, denser where the field is stronger.

        pc.film(recording, "dipole.gif", style=[pc.styles.FieldLines(), pc.styles.Points()])

    Electric field lines begin and end at charges. Their number is proportional to the charge, and their directions are
    evenly spread. Drawn are all lines of positive charges, and those lines of negative charges that come from far away.
    Magnetic lines, and electric ones without charges, pass through the points of a regular pattern. Each of them is cut
    where it comes too near to earlier lines. Arrowheads show the direction. The lines are integrated by the Runge–Kutta
    method of order 4, in steps of 1/90 of half the view. In 2D the magnetic field is normal to the plane, so that it
    has no field lines there.

    Args:
        field: "electric" or "magnetic".
        lines: number of lines that begin at the largest charge, at least 2; without charges, the approximate number of
            lines in the picture.
        width: width of the lines [pixels].
        strength: contrast of the lines with the background, from 0 to 1.
        on: as in Style; the field is that of the whole scene.

    Raises:
        SceneError: a value is out of range, or the scene has no such field.
    """

    overlay: ClassVar[bool] = True

    field: Kind = "electric"
    lines: int = 16
    width: float = 1.4
    strength: float = 0.75

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            field=word(self.field, "FieldLines.field", ("electric", "magnetic")),
            lines=count(self.lines, "FieldLines.lines", least=2, most=400),
            width=number(self.width, "FieldLines.width", above=0.0),
            strength=number(self.strength, "FieldLines.strength", above=0.0, most=1.0),
        )

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter of one film."""
        del parts
        require(source.scene, self.field, "FieldLines.field")
        return FieldLinesPainter(self, source, theme)


class FieldLinesPainter(Painter):
    """Painter of field lines."""

    def __init__(self, style: FieldLines, source: Source, theme: Theme) -> None:
        self.style, self._style, self._scene, self._theme = style, style, source.scene, theme
        charges = any(force.needs_charges for force in self._scene.forces)
        self._charge = np.concatenate([body.charge for body in self._scene.bodies] or [np.empty(0)])
        if style.field == "magnetic" or not charges:
            self._charge = np.zeros_like(self._charge)
        self._known: tuple[FloatArray, FloatArray] | None = None
        """Places of the charges, and the center and the reach of the view, for which the lines were found."""
        self._lines: FloatArray = np.empty((0, 0, self._scene.dimension))

    @property
    def settled(self) -> bool:
        """True: there is no color scale."""
        return True

    def observe(self, frame: SourceFrame) -> None:
        """Do nothing: the painter does not depend on the whole film."""

    def inset(self, pixels: float) -> float:
        """Half the width of a line."""
        del pixels
        return self._style.width / 2

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue all lines, with arrowheads in their middles."""
        del pixels
        lines = self._found(frame, view)
        shape = lines.shape[:2]
        if shape[0] == 0:
            return
        points, depth, _ = view.project(lines.reshape(-1, lines.shape[2]))
        points = points.reshape(*shape, 2)
        ends = np.concatenate([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 4)
        between = None
        if depth is not None:
            depth = depth.reshape(shape)
            between = np.stack([depth[:, :-1].ravel(), depth[:, 1:].ravel()], axis=1)
        drawn = np.isfinite(ends).all(axis=1) & (np.abs(ends[:, :2] - ends[:, 2:]).max(axis=1) > 0.0)
        ends, between = ends[drawn], None if between is None else between[drawn]
        ink = self._ink(len(ends), None if between is None else between.mean(axis=1), view)
        canvas.lines(ends, np.full(len(ends), self._style.width, np.float32), ink, between)
        self._arrowheads(canvas, points, depth, view)

    def _ink(self, number: int, depth: np.ndarray | None, view: View) -> np.ndarray:
        colors = np.tile(mixed(self._theme, self._style.strength), (number, 1))
        return inks(colors, self._theme, None if depth is None else view.farness(depth))

    def _arrowheads(self, canvas: Canvas, points: np.ndarray, depth: np.ndarray | None, view: View) -> None:
        """Queue an arrowhead in the middle of the visible part of each line."""
        seen = np.isfinite(points).all(axis=2) & (np.abs(points - np.array(view.middle)) < np.array(view.middle)).all(
            axis=2
        )
        rows = np.flatnonzero(seen.sum(axis=1) > 12)
        if len(rows) == 0:
            return
        order = np.cumsum(seen[rows], axis=1)
        at = np.argmax(order >= order[:, -1:] // 2, axis=1)
        at = np.clip(at, 3, points.shape[1] - 4)
        tails, tips = points[rows, at - 3], points[rows, at + 3]
        whole = np.isfinite(tails).all(axis=1) & np.isfinite(tips).all(axis=1)
        rows, at, tails, tips = rows[whole], at[whole], tails[whole], tips[whole]
        corners = heads(tails, tips, np.float32(9.0 * self._style.width))
        between = None if depth is None else depth[rows, at]
        ink = np.repeat(self._ink(len(rows), between, view)[:, np.newaxis], 3, axis=1).reshape(-1, 12)
        canvas.triangles(corners.reshape(-1, 6), ink, None if between is None else between[:, np.newaxis])

    def _found(self, frame: SourceFrame, view: View) -> FloatArray:
        """The lines (L, K, D); those of the previous frame if nothing has changed, or the camera has only turned about
        the point that it looks at.
        """
        places = [places_of(body, self._scene, frame) for body in self._scene.bodies]
        charged = np.concatenate(places or [frame.positions])[self._charge != 0.0]
        region = np.append(_middle(view), _reach(view))
        known = self._known
        kept = (
            known is not None
            and np.array_equal(known[0], charged)
            and np.abs(known[1] - region).max() < SAME * region[-1]
        )
        changes = any(force.changes for force in self._scene.forces)
        if changes or not kept:
            fields = Fields(self._scene, frame)
            self._lines = self._from_charges(fields, charged, view) if len(charged) else self._even(fields, view)
            self._known = charged, region
        return self._lines

    def _from_charges(self, fields: Fields, places: FloatArray, view: View) -> FloatArray:
        """The lines of positive charges, and the lines of negative charges that do not end at positive ones."""
        charge = self._charge[self._charge != 0.0]
        share = np.abs(charge) / np.abs(charge).max()
        step = STEP * _reach(view)
        found = []
        for positive in (True, False):
            chosen = np.flatnonzero((charge > 0.0) == positive)
            numbers = np.maximum(1, np.round(self._style.lines * share[chosen])).astype(int)
            seeds = [
                places[at] + step * _around(number, places.shape[1]) for at, number in zip(chosen, numbers, strict=True)
            ]
            if not seeds:
                continue
            lines, ended = self._followed(fields, np.concatenate(seeds), 1.0 if positive else -1.0, places, view)
            if not positive:
                # Lines that end at a positive charge have been drawn from there.
                lines = lines[~np.isin(ended, np.flatnonzero(charge > 0.0))][:, ::-1]
            found.append(lines)
        return np.concatenate(found)

    def _even(self, fields: Fields, view: View) -> FloatArray:
        """Lines through a regular pattern, each cut where it comes too near to earlier lines."""
        dimension, reach = self._scene.dimension, _reach(view)
        side = int(np.ceil((4.0 * self._style.lines) ** (1.0 / dimension)))
        seeds = np.indices((side,) * dimension).reshape(dimension, -1).T / (0.5 * (side - 1)) - 1.0
        seeds = _middle(view) + reach * seeds[np.argsort(np.abs(seeds).max(axis=1), kind="stable")]
        none = np.empty((0, dimension))
        ahead, _ = self._followed(fields, seeds, 1.0, none, view)
        behind, _ = self._followed(fields, seeds, -1.0, none, view)
        lines = np.concatenate([behind[:, :0:-1], ahead], axis=1)
        apart = 2.0 * reach / (2.2 * self._style.lines ** (1.0 / (dimension - 1.0)))
        return _spaced(lines, STEPS - 1, apart)

    def _followed(
        self, fields: Fields, seeds: FloatArray, sign: float, charges: FloatArray, view: View
    ) -> tuple[FloatArray, np.ndarray]:
        """Integrate lines from seeds along or against the field.

        Returns the lines (L, STEPS, D), NaN beyond their ends, and the index of the charge at which each ends, or −1.
        """
        middle, reach = _middle(view), _reach(view)
        step, places = STEP * reach, seeds.copy()
        lines, ended = np.full((len(seeds), STEPS, seeds.shape[1]), np.nan), np.full(len(seeds), -1)
        alive = np.arange(len(seeds))
        for index in range(STEPS):
            lines[alive, index] = places[alive]
            here = places[alive]
            moved = here + step * sign * self._slope(fields, here, step * sign)
            if len(charges):
                apart = np.linalg.norm(moved[:, np.newaxis] - charges, axis=2)
                nearest = apart.argmin(axis=1)
                at_charge = (apart.min(axis=1) < CLOSE * step) & (index > 0)
                ended[alive[at_charge]] = nearest[at_charge]
            else:
                at_charge = np.zeros(len(alive), dtype=bool)
            goes_on = (
                np.isfinite(moved).all(axis=1) & ~at_charge & (np.linalg.norm(moved - middle, axis=1) < BEYOND * reach)
            )
            places[alive] = moved
            alive = alive[goes_on]
            if len(alive) == 0:
                break
        return lines, ended

    def _slope(self, fields: Fields, here: FloatArray, step: float) -> FloatArray:
        """The mean direction over a step, by the Runge–Kutta method of order 4."""

        def direction(points: FloatArray) -> FloatArray:
            values = fields.at(self._style.field, points)
            size = np.linalg.norm(values, axis=1)[:, np.newaxis]
            with np.errstate(invalid="ignore", divide="ignore"):
                return np.where(size > 0.0, values / size, np.nan)

        a = direction(here)
        b = direction(_finite(here + 0.5 * step * a, here))
        c = direction(_finite(here + 0.5 * step * b, here))
        d = direction(_finite(here + step * c, here))
        slope: FloatArray = (a + 2.0 * b + 2.0 * c + d) / 6.0
        return slope


def _finite(points: FloatArray, otherwise: FloatArray) -> FloatArray:
    """The finite points; elsewhere the points of `otherwise`."""
    return np.where(np.isfinite(points).all(axis=1, keepdims=True), points, otherwise)


def _middle(view: View) -> FloatArray:
    """The point at the center of the view [m]."""
    middle: FloatArray = view.axes.T @ view.center
    return middle


def _reach(view: View) -> float:
    """Half the longer side of the view [m]."""
    return max(view.middle) / view.scale


def _around(number: int, dimension: int) -> FloatArray:
    """Directions spread evenly over a circle or a sphere."""
    index = np.arange(number) + 0.5
    if dimension == 2:
        angle = 2.0 * np.pi * index / number
        return np.column_stack([np.cos(angle), np.sin(angle)])
    height = 1.0 - 2.0 * index / number
    ring, angle = np.sqrt(1.0 - height**2), GOLDEN * index
    return np.column_stack([ring * np.cos(angle), ring * np.sin(angle), height])


def _spaced(lines: FloatArray, seed: int, apart: float) -> FloatArray:
    """The lines (L, K, D) with a least distance from earlier lines, cut where they come nearer than half of it. `seed`
    is the index of the points from which they were integrated.
    """
    near: set[tuple[int, ...]] = set()
    nearer: set[tuple[int, ...]] = set()
    kept = []
    for line in lines:
        known = np.isfinite(line).all(axis=1)
        cells = [np.floor(np.where(known[:, np.newaxis], scale * line / apart, 0.0)).astype(int) for scale in (1, 2)]
        coarse, fine = ([tuple(cell) for cell in part.tolist()] for part in cells)
        if coarse[seed] in near:
            continue
        free = known & np.array([cell not in nearer for cell in fine])
        # Keep the points from the seed to the first point on each side that is not free.
        first = seed + 1 - int(np.argmin(np.append(free[: seed + 1][::-1], False)))
        last = seed + int(np.argmin(np.append(free[seed:], False)))
        if last - first < SHORTEST:
            continue
        near.update(coarse[first:last])
        nearer.update(fine[first:last])
        part = np.full_like(line, np.nan)
        part[first:last] = line[first:last]
        kept.append(part)
    return np.array(kept).reshape(len(kept), *lines.shape[1:])

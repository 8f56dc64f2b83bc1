"""Looks of spheres: a ball, or the far half of a bowl; circles in 2D."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore._core import Canvas
from physcore.boundaries.sphere import Sphere
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.light import lit
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import SHADING, Look, Scenery, disc, lines
from physcore.film.page.tape import Tape
from physcore.film.shapes.spatial import ball

MERIDIANS = 12
SEGMENTS = 48


class SphereLook(Look):
    """The look of a sphere."""

    def __init__(self, sphere: Sphere) -> None:
        self.center, self.radius, self.inside = np.array(sphere.center), sphere.radius, sphere.inside

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """The center, with the radius as margin."""
        yield self.center[np.newaxis], self.radius

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw the sphere in 2D, a bowl in 3D."""
        if view.flat:
            self._circle(canvas, view, theme)
        elif self.inside:
            self._bowl(canvas, view, theme)

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Queue a ball in 3D."""
        if not view.flat and not self.inside:
            disc(canvas, view, self.center, self.radius, theme.solid, shading=SHADING)

    def record(self, tape: Tape, view: View, theme: Theme, scenery: Scenery) -> None:
        """Put the sphere on a tape; a bowl as its inside, of which the near half is never seen, with its curves."""
        if view.flat or not self.inside:
            super().record(tape, view, theme, scenery)
            return
        inside, place = ball(self.radius, 0.0, view.scale, (1.0, 1.0)), (self.center[np.newaxis], np.eye(3)[np.newaxis])
        color, around = np.array([theme.surface], dtype=float), inside.triangles[:, ::-1]
        tape.solids(inside.points, -inside.normals, inside.tones, around, *place, color)
        for curve in _curves():
            pixels, depth, _ = view.project(self.center + 0.997 * self.radius * curve)  # in front of the surface
            assert depth is not None  # views in 3D have depths
            ends, both = np.concatenate([pixels[:-1], pixels[1:]], axis=1), np.stack([depth[:-1], depth[1:]], axis=1)
            ink = np.tile(np.array([*theme.edge, 90], dtype=np.uint8), (len(ends), 1))
            tape.lines(ends, np.full(len(ends), 1.0, dtype=np.float32), ink, both)

    def _circle(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Draw a solid disc, or a ring around a hollow one."""
        inner = theme.background if self.inside else theme.surface
        disc(canvas, view, self.center, self.radius, theme.edge, extra=1.0)
        disc(canvas, view, self.center, self.radius, inner, extra=-1.0)

    def _bowl(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Draw the far half of a hollow sphere, with meridians and parallels."""
        center, radius = self.center, self.radius
        disc(canvas, view, center, radius, theme.edge, extra=1.0)
        canvas.paint()
        self._hollow(canvas, view, theme)
        eye = view.axes[2]
        for curve in _curves():
            pixels = view.project(center + radius * curve)[0]
            behind = (curve[:-1] + curve[1:]) @ eye < 0.0
            lines(canvas, np.stack([pixels[:-1], pixels[1:]], axis=1)[behind], theme.edge, 1.0, alpha=70)

    def _hollow(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Draw the far half as a lit surface, seen from inside."""
        turn, fall = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1), np.linspace(0.0, 0.5 * np.pi, SEGMENTS // 4 + 1)
        ring = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
        outward = np.sin(fall)[:, np.newaxis, np.newaxis] * ring
        outward[..., 2] -= np.cos(fall)[:, np.newaxis]
        outward = outward.reshape(-1, 3)
        pixels, depth, _ = view.project(self.center + self.radius * outward @ view.axes)
        assert depth is not None  # views in 3D have depths
        index = np.arange(len(outward)).reshape(len(fall), len(turn))
        a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
        faces = np.concatenate([np.stack(each, -1).reshape(-1, 3) for each in ((a, b, c), (a, c, d))])
        colors = lit(np.tile(np.array(theme.surface, dtype=float), (len(outward), 1)), -outward)
        inks = np.concatenate([colors, np.full((len(colors), 1), 255.0)], axis=1).astype(np.uint8)
        canvas.triangles(
            np.ascontiguousarray(pixels[faces].reshape(-1, 6)),
            np.ascontiguousarray(inks[faces].reshape(-1, 12)),
            np.ascontiguousarray(depth[faces]),
        )


def _curves() -> list[FloatArray]:
    """The parallels and meridians of a unit sphere, each (K, 3)."""
    turn, curves = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1), []
    for latitude in np.radians([-60.0, -30.0, 0.0, 30.0, 60.0]):
        ring = np.stack([np.cos(turn), np.sin(turn), np.full_like(turn, np.tan(latitude))], axis=1)
        curves.append(np.cos(latitude) * ring)
    for longitude in np.arange(MERIDIANS // 2) * (2.0 * np.pi / MERIDIANS):
        level = np.array([np.cos(longitude), np.sin(longitude), 0.0])
        curves.append(np.cos(turn)[:, np.newaxis] * level + np.sin(turn)[:, np.newaxis] * np.array([0.0, 0.0, 1.0]))
    return curves

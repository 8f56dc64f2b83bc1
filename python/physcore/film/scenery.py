"""Boundaries, the periodic domain and the centers of forces: what stands still."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.themes import Color, Theme
from physcore.scene.periodic import Periodic
from physcore.scene.scene import Scene

SHADING = 0.62
GRID = 10
MERIDIANS = 12
SEGMENTS = 48


@dataclass(frozen=True, eq=False)
class Scenery:
    """The place of scenery that has no end or no place of its own."""

    domain: Periodic | None
    """The periodic domain, drawn as a frame."""
    middle: FloatArray
    """The middle of the ground in 3D, the middle of the view in 2D [m], shape (D,)."""
    size: float
    """Half the width of the ground [m]."""


def landmarks(scene: Scene) -> Iterator[tuple[FloatArray, float]]:
    """Points (P, D) [m], and a distance around them, that belong in the picture: boxes, spheres, centers of forces."""
    for kind, boundary in _described(scene):
        if kind == "Box":
            yield _corners(boundary["lower"], boundary["upper"]), 0.0
        elif kind == "Sphere":
            yield boundary["center"][np.newaxis], float(boundary["radius"])
    if scene.periodic is not None and np.isfinite(scene.periodic.lengths).all():
        yield _corners(np.array(scene.periodic.lower), np.array(scene.periodic.upper)), 0.0
    for center in _centers(scene):
        yield center[np.newaxis], 0.0


def grounds(scene: Scene, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Points (P, D) [m] of planes that are no farther from a box along the axes than the box is large, and of a domain
    that is open along some of them.
    """
    middle, size = (lower + upper) / 2, float(np.linalg.norm(upper - lower))
    points = [np.empty((0, scene.dimension))]
    for kind, boundary in _described(scene):
        if kind == "Plane":
            height = (_corners(lower, upper) - boundary["point"]) @ boundary["normal"]
            if height.min() <= size:
                foot = middle - ((middle - boundary["point"]) @ boundary["normal"]) * boundary["normal"]
                points.append(foot[np.newaxis])
    if scene.periodic is not None:
        points.append(_corners(*_finite(scene.periodic, lower, upper)))
    return np.concatenate(points)


def draw_behind(canvas: Canvas, scene: Scene, view: View, theme: Theme, scenery: Scenery) -> None:
    """Draw at once what is behind everything that moves."""
    for kind, boundary in _described(scene):
        if kind == "Plane":
            (_half_plane if view.flat else _ground)(canvas, boundary, view, theme, scenery)
        elif kind == "Box":
            _box(canvas, boundary, view, theme, front=False)
        elif kind == "Sphere" and (view.flat or boundary["inside"]):
            (_circle if view.flat else _bowl)(canvas, boundary, view, theme)
    _domain(canvas, view, theme, scenery, front=False)
    if view.flat:
        for center in _centers(scene):
            _disc(canvas, view, center, 0.0, theme.edge, extra=3.0)
    canvas.paint()


def draw_among(canvas: Canvas, scene: Scene, view: View, theme: Theme, scenery: Scenery) -> None:
    """Add to the painting what hides things that move, and is hidden by them."""
    for kind, boundary in _described(scene):
        if kind == "Sphere" and not view.flat and not boundary["inside"]:
            _disc(canvas, view, boundary["center"], float(boundary["radius"]), theme.solid, shading=SHADING)
        elif kind == "Box" and not view.flat:
            _box(canvas, boundary, view, theme, front=True)
    if not view.flat:
        _domain(canvas, view, theme, scenery, front=True)
        for center in _centers(scene):
            _disc(canvas, view, center, 0.0, theme.edge, extra=3.0, shading=SHADING)


def _described(scene: Scene) -> Iterator[tuple[str, dict[str, FloatArray]]]:
    """The kind and the parameters of each boundary, planes with a normal of length one."""
    for boundary in scene.boundaries:
        description = boundary.describe(scene.dimension)
        yield (
            str(description["type"]),
            {name: np.asarray(value) for name, value in description.items() if name != "type"},
        )


def _centers(scene: Scene) -> Iterator[FloatArray]:
    for force in scene.forces:
        center = getattr(force, "center", None)
        if center is not None:
            yield np.asarray(center, dtype=float)


def _corners(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """The 2^D corners of a box along the axes; the bits of a corner's number say which are upper."""
    upper_in = np.array(list(np.ndindex(*(2,) * len(lower))), dtype=bool)
    return np.where(upper_in, upper, lower)


def _half_plane(canvas: Canvas, plane: dict[str, FloatArray], view: View, theme: Theme, scenery: Scenery) -> None:
    """Solid ground on the side that the normal points away from."""
    normal = plane["normal"]
    along = np.array([normal[1], -normal[0]])
    foot = plane["point"] + ((scenery.middle - plane["point"]) @ along) * along
    far = 4.0 * scenery.size
    corners = [foot - far * along, foot + far * along, foot + far * (along - normal), foot - far * (along + normal)]
    pixels = view.project(np.array(corners))[0]
    canvas.polygon(pixels, (*theme.surface, 255))
    _lines(canvas, pixels[np.newaxis, :2], theme.edge, 1.5)


def _ground(canvas: Canvas, plane: dict[str, FloatArray], view: View, theme: Theme, scenery: Scenery) -> None:
    """A square of a plane under the middle of what happens, with a grid for the eye to hold on to."""
    normal, middle, size = plane["normal"], scenery.middle, scenery.size
    foot = middle - ((middle - plane["point"]) @ normal) * normal
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    sides = np.array([-first - second, first - second, first + second, second - first])
    canvas.polygon(view.project(foot + size * sides)[0], (*theme.surface, 255))
    steps = np.linspace(-size, size, GRID + 1)[:, np.newaxis]
    starts = np.concatenate([foot + steps * first - size * second, foot + steps * second - size * first])
    ends = np.concatenate([foot + steps * first + size * second, foot + steps * second + size * first])
    pixels = np.stack([view.project(starts)[0], view.project(ends)[0]], axis=1)
    _lines(canvas, pixels, theme.edge, 1.0, alpha=80)


def _domain(canvas: Canvas, view: View, theme: Theme, scenery: Scenery, *, front: bool) -> None:
    """A thin frame around the periodic domain; along an axis that is not periodic, lines without an end."""
    if scenery.domain is None:
        return
    lower, upper = _finite(scenery.domain, scenery.middle - scenery.size, scenery.middle + scenery.size)
    open_axes = np.flatnonzero(np.isinf(scenery.domain.lengths)).tolist()
    _box(canvas, {"lower": lower, "upper": upper}, view, theme, front=front, thin=True, along=open_axes or None)


def _finite(domain: Periodic, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The corners of a domain, with those of a box along the axes that are not periodic."""
    low, high = np.array(domain.lower), np.array(domain.upper)
    return np.where(np.isinf(low), lower, low), np.where(np.isinf(high), upper, high)


def _box(
    canvas: Canvas,
    box: dict[str, FloatArray],
    view: View,
    theme: Theme,
    *,
    front: bool,
    thin: bool = False,
    along: list[int] | None = None,
) -> None:
    """The edges of a box, or only those along some axes. In 3D those that meet in the farthest corner are behind
    everything, the others in front.
    """
    corners = _corners(box["lower"], box["upper"])
    count, dimension = corners.shape
    bits = range(dimension) if along is None else [dimension - 1 - axis for axis in along]
    pairs = [(i, i | 1 << bit) for i in range(count) for bit in bits if not i & 1 << bit]
    pixels, depth, _ = view.project(corners)
    if depth is None:
        _lines(canvas, pixels[np.array(pairs)], theme.edge, 1.0 if thin else 2.0)
        return
    farthest = int(np.argmax(depth))
    chosen = np.array([pair for pair in pairs if (farthest not in pair) == front], dtype=int).reshape(-1, 2)
    depths = np.full(len(chosen), -np.inf if front else np.inf, dtype=np.float32)
    _lines(canvas, pixels[chosen], theme.edge, 0.8 if thin else 1.3, depths=depths)


def _circle(canvas: Canvas, sphere: dict[str, FloatArray], view: View, theme: Theme) -> None:
    """A round obstacle, or a ring around a hollow."""
    inner = theme.background if sphere["inside"] else theme.surface
    _disc(canvas, view, sphere["center"], float(sphere["radius"]), theme.edge, extra=1.0)
    _disc(canvas, view, sphere["center"], float(sphere["radius"]), inner, extra=-1.0)


def _bowl(canvas: Canvas, sphere: dict[str, FloatArray], view: View, theme: Theme) -> None:
    """The far half of a hollow sphere, with meridians and parallels."""
    center, radius = sphere["center"], float(sphere["radius"])
    _disc(canvas, view, center, radius, theme.edge, extra=1.0)
    _disc(canvas, view, center, radius, theme.surface, extra=-0.5)
    turn = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    curves = []
    for latitude in np.radians([-60.0, -30.0, 0.0, 30.0, 60.0]):
        ring = np.stack([np.cos(turn), np.sin(turn), np.full_like(turn, np.tan(latitude))], axis=1)
        curves.append(np.cos(latitude) * ring)
    for longitude in np.arange(MERIDIANS // 2) * (2.0 * np.pi / MERIDIANS):
        level = np.array([np.cos(longitude), np.sin(longitude), 0.0])
        curves.append(np.cos(turn)[:, np.newaxis] * level + np.sin(turn)[:, np.newaxis] * np.array([0.0, 0.0, 1.0]))
    eye = view.axes[2]
    for curve in curves:
        pixels = view.project(center + radius * curve)[0]
        behind = (curve[:-1] + curve[1:]) @ eye < 0.0
        _lines(canvas, np.stack([pixels[:-1], pixels[1:]], axis=1)[behind], theme.edge, 1.0, alpha=70)


def _disc(
    canvas: Canvas,
    view: View,
    center: FloatArray,
    radius: float,
    color: Color,
    extra: float = 0.0,
    shading: float = 0.0,
) -> None:
    """Add a disc of a radius [m] and some more pixels."""
    pixels, depth, scale = view.project(center[np.newaxis])
    canvas.discs(pixels, scale * np.float32(radius) + np.float32(extra), _ink(color, 1), depth, shading)


def _lines(
    canvas: Canvas, ends: PixelArray, color: Color, width: float, alpha: int = 255, depths: PixelArray | None = None
) -> None:
    """Add lines between pixels (M, 2, 2)."""
    count = len(ends)
    flat = np.ascontiguousarray(ends).reshape(count, 4)
    canvas.lines(flat, np.full(count, width, dtype=np.float32), _ink(color, count, alpha), depths)


def _ink(color: Color, count: int, alpha: int = 255) -> np.ndarray:
    return np.tile(np.array([*color, alpha], dtype=np.uint8), (count, 1))

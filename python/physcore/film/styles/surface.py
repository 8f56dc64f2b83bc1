"""Cloths and soft bodies as lit surfaces, plain, textured or colored by strain."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas, Texture
from physcore.checks import FloatArray, IntArray, file_path, frozen, is_word, number, regular
from physcore.errors import FileError, SceneError
from physcore.film.camera.view import Orbit, View
from physcore.film.colors.colormaps import diverging, look_up
from physcore.film.colors.light import AMBIENT, LAMP
from physcore.film.colors.themes import Color, Theme, color
from physcore.film.pictures import opened
from physcore.film.styles.base import BodyStyle, Painter, Part, Scale, body_color, inks, places, straight, sums, typical
from physcore.film.styles.rim import paint_rim, thickness_of
from physcore.film.styles.strain import rooted, strain_scale
from physcore.film.styles.torn import has_tears, intact, sides
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.channels import first_spring
from physcore.scene.periodic import Periodic
from physcore.simulation.sources import Source, SourceFrame

BACK = 0.8
"""The light of the back of a surface, beside that of its front."""
RIM = 0.75
"""That of its rim."""
NEVER = 1e-9
"""Strains below this are rounding, and stay neutral [1]."""
UPWARD = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
"""Which way a texture is upright: along z, or along y on what lies flat."""
LARGEST = 4096
"""The longest side of a texture [pixels]."""


class Picture:
    """The pixels (H, W, 3) of a texture, and what the canvas makes of them; compared by the pixels."""

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        self.pixels: NDArray[np.uint8] = frozen(np.array(pixels, order="C"))
        self.texture = Texture(self.pixels)

    def __reduce__(self) -> tuple[object, ...]:
        return Picture, (self.pixels,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Picture) and np.array_equal(self.pixels, other.pixels)

    def __hash__(self) -> int:
        return hash((self.pixels.shape, self.pixels.tobytes()))

    def __repr__(self) -> str:
        height, width, _ = self.pixels.shape
        return f"Picture({width}×{height})"


@dataclass(frozen=True)
class Surface(BodyStyle):
    """The triangles of a spring network's `faces`, filled; in 3D with Lambert's light and smooth normals. A triangle
    with a broken side is not drawn.

        pc.film(recording, "flag.gif", style=pc.styles.Surface("#c0392b", back="#f4e7d3"))

    Args:
        color: "body", "strain", or a color such as "#10c0ff"; by strain each particle has the color of its
            springs' mean, blue when compressed, red when stretched.
        texture: a picture that is laid on the body as it was at the start, seen along its thinnest side: a path, or
            an array (H, W, 3) of bytes; None: none.
        range: the strain at which colors end [1]; None: what is typical of the worst frame.
        back: the color of the back, in 3D, the side from which corners go round clockwise; None: that of the front.
        thickness: the width of the rim of a cloth in 3D [m], at least zero; None: that of its SelfContact, or no rim.
        on: as in Style; it must have faces.

    Raises:
        SceneError: a value is not valid.
        FileError: the picture cannot be read.
    """

    color: Literal["body", "strain"] | str | Color = "body"
    texture: str | os.PathLike[str] | NDArray[np.uint8] | Picture | None = None
    range: float | None = None
    back: str | Color | None = None
    thickness: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.back is not None:
            self._set(back=color(self.back, "Surface.back"))
        if not (is_word(self.color, "body") or is_word(self.color, "strain")):
            self._set(color=color(self.color, "Surface.color"))
        self._set_positive("range")
        if self.thickness is not None:
            self._set(thickness=number(self.thickness, "Surface.thickness", least=0.0))
        if self.texture is not None and not isinstance(self.texture, Picture):
            self._set(texture=Picture(_pixels(self.texture)))

    def can_draw(self, body: Body) -> bool:
        """Whether it has a surface."""
        return isinstance(body, SpringNetwork) and len(body.faces) > 0

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """A painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Surface.on: {part.body!r} has no faces; give SpringNetwork faces=, or use Strain()")
        return SurfacePainter(self, source, parts, theme)


class SurfacePainter(Painter):
    """Draws triangles."""

    def __init__(self, style: Surface, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._theme = style, style, theme
        self._domain: Periodic | None = source.scene.periodic
        faces, pairs, rest, spots, springs = [], [], [], [], []
        for part in parts:
            body = part.body
            assert isinstance(body, SpringNetwork)  # the style has made sure of it
            faces.append(body.faces + part.where.start)
            pairs.append(body.pairs + part.where.start)
            rest.append(body.rest_length)
            springs.append(np.arange(len(body.pairs)) + first_spring(source.scene, body))
            spots.append(spread(body.positions))
        self._faces: IntArray = np.concatenate(faces)
        self._pairs: IntArray = np.concatenate(pairs)
        self._rest: FloatArray = np.concatenate(rest)
        self._springs: IntArray = np.concatenate(springs)
        self._sides: IntArray | None = sides(source.scene, parts) if has_tears(source, parts) else None
        self._thickness = np.zeros(source.scene.particles)
        for part in parts:
            given = style.thickness
            self._thickness[part.where] = thickness_of(part.body, source.scene) if given is None else given
        self._back = None if style.back is None else np.array(color(style.back, "Surface.back"), dtype=np.float64)
        self._where = places(parts)
        count = source.scene.particles
        self._table = diverging(theme.compressed, theme.relaxed, theme.stretched)
        self._plain = np.zeros((count, 3))
        for part in parts:
            own = style.color in ("body", "strain")
            self._plain[part.where] = body_color(source, part, theme) if own else color(style.color, "Surface.color")
        self._texture = style.texture.texture if isinstance(style.texture, Picture) else None
        if self._texture is not None and style.color == "body":
            self._plain[:] = 255.0
        everywhere = np.zeros((count, 2), dtype=np.float32)
        everywhere[self._where] = np.concatenate(spots)
        self._spots = everywhere[self._faces].reshape(-1, 6)
        self.top = style.range or NEVER

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given, or there is none."""
        return self._style.color != "strain" or self._style.range is not None

    @property
    def scale(self) -> Scale | None:
        """The scale of colors."""
        return strain_scale(self.top, self._table) if self._style.color == "strain" else None

    def observe(self, frame: SourceFrame) -> None:
        """Find the end of the color scale."""
        if not self.settled:
            self.top = max(self.top, typical(np.abs(self._strain(frame))[self._where]))

    def inset(self, pixels: float) -> float:
        """A rim."""
        del pixels
        return 1.5

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Add triangles."""
        del pixels
        corners, depth, _ = view.project(frame.positions)
        light = np.ones(len(corners)) if view.flat else self._light(frame.positions, view)
        farness = None if depth is None else view.farness(depth)
        ink = inks(np.clip(self._colors(frame) * light[:, np.newaxis], 0.0, 255.0), self._theme, farness)
        faces, spots = self._faces, self._spots
        inked = ink[faces]
        if self._back is not None and not view.flat:
            behind = inks(np.clip(self._back * light[:, np.newaxis], 0.0, 255.0), self._theme, farness)
            one, other = corners[faces[:, 1]] - corners[faces[:, 0]], corners[faces[:, 2]] - corners[faces[:, 0]]
            # Pixels are counted downward: what goes round to the left is seen with a negative area.
            hidden = one[:, 0] * other[:, 1] > one[:, 1] * other[:, 0]
            inked[hidden] = behind[faces[hidden]]
        shown = np.ones(len(faces), dtype=np.bool_)
        if self._sides is not None:
            shown &= intact(frame, self._sides).all(axis=1)
        if self._domain is not None:
            # A triangle that reaches across a face of the domain would cross the picture.
            shown &= straight(self._domain, np.diff(frame.positions[faces[:, [0, 1, 2, 0]]], axis=1)).all(axis=1)
        if not shown.all():
            faces, spots, inked = faces[shown], spots[shown], inked[shown]
        canvas.triangles(
            np.ascontiguousarray(corners[faces].reshape(-1, 6)),
            np.ascontiguousarray(inked.reshape(-1, 12)),
            None if depth is None else depth[faces].mean(axis=1, dtype=np.float32),
            self._texture,
            spots,
        )
        if self._thickness.any() and not view.flat:
            rim = inks(np.clip(RIM * self._colors(frame) * light[:, np.newaxis], 0.0, 255.0), self._theme, farness)
            paint_rim(canvas, frame.positions, faces, self._thickness, rim, view)

    def _colors(self, frame: SourceFrame) -> FloatArray:
        if self._style.color != "strain":
            return self._plain
        return look_up(self._table, rooted(self._strain(frame) / self.top))

    def _strain(self, frame: SourceFrame) -> FloatArray:
        """The mean strain of each particle's springs that are not broken (N,)."""
        whole = slice(None) if self._sides is None else intact(frame, self._springs)
        positions, pairs = frame.positions, self._pairs[whole]
        separation = positions[pairs[:, 1]] - positions[pairs[:, 0]]
        if self._domain is not None:
            separation = self._domain.nearest(separation)
        rest = np.maximum(self._rest[whole], NEVER)
        strain = np.sqrt(np.einsum("md,md->m", separation, separation)) / rest - 1.0
        total = np.bincount(pairs.ravel(), weights=np.repeat(strain, 2), minlength=len(positions))
        mean: FloatArray = total / np.maximum(np.bincount(pairs.ravel(), minlength=len(positions)), 1)
        return mean

    def _light(self, positions: FloatArray, view: View) -> FloatArray:
        """The light on each particle (N,): Lambert's cosine with the mean normal of its faces, turned to the eye."""
        first, second, third = (positions[self._faces[:, corner]] for corner in (0, 1, 2))
        flat = np.cross(second - first, third - first)
        normals = sums(self._faces.ravel(), np.repeat(flat, 3, axis=0), len(positions))
        local = normals @ view.axes.T
        length = np.maximum(np.sqrt(np.einsum("nd,nd->n", local, local)), 1e-300)
        away = local[:, 2] < 0.0
        cosine = np.where(away, -1.0, 1.0) * (local @ LAMP) / length
        light: FloatArray = (AMBIENT + (1.0 - AMBIENT) * np.maximum(cosine, 0.0)) * np.where(away, BACK, 1.0)
        return light


def spread(positions: FloatArray) -> NDArray[np.float32]:
    """Where particles lie on a picture (N, 2), 0–1 to the right and up: seen along their thinnest direction, upright,
    from the side of the usual camera.
    """
    centered = positions - positions.mean(axis=0)
    if positions.shape[1] == 3:
        normal = np.linalg.svd(centered, full_matrices=False)[2][-1] if len(positions) > 2 else np.array(UPWARD[0])
        normal = normal if normal @ Orbit().axes[2] > 0.0 else -normal
        upward = np.array(UPWARD[int(abs(normal[2]) > 0.9)])
        upward = upward - (upward @ normal) * normal
        upward /= np.linalg.norm(upward)
        centered = np.stack([centered @ np.cross(upward, normal), centered @ upward], axis=1)
    low, high = centered.min(axis=0), centered.max(axis=0)
    places: NDArray[np.float32] = ((centered - low) / np.maximum(high - low, 1e-300)).astype(np.float32)
    return places


def _pixels(given: object) -> NDArray[np.uint8]:
    """The pixels of a texture (H, W, 3)."""
    if isinstance(given, (str, os.PathLike)):
        path = file_path(given, "Surface.texture")
        try:
            with opened(path) as image:
                image.thumbnail((LARGEST, LARGEST))
                return np.asarray(image.convert("RGB"))
        except FileError as error:
            raise FileError(f"Surface.texture: {error}") from error
    pixels = regular(given, "Surface.texture")
    if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8 or 0 in pixels.shape:
        raise SceneError(
            f"Surface.texture: must be a path or bytes of shape (H, W, 3), got {pixels.dtype} of shape {pixels.shape}"
        )
    return pixels

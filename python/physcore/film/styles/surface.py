"""Cloths and soft bodies as lit surfaces: plain, textured or colored by strain."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas, Texture
from physcore.checks import BoolArray, FloatArray, IntArray, file_path, frozen, is_word, number, regular
from physcore.errors import FileError, SceneError
from physcore.film.camera.view import Orbit, View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, diverging, look_up, ramp
from physcore.film.colors.light import lit
from physcore.film.colors.themes import Color, Theme, color
from physcore.film.page.tape import Tape
from physcore.film.shapes.creases import around, corner_normals, face_normals
from physcore.film.styles.base import BodyStyle, Painter, Part, Scale, inks, places, straight
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.frays import frays
from physcore.film.styles.rim import paint_rim, thickness_of
from physcore.film.styles.strain import rooted, strain_scale
from physcore.film.styles.torn import has_tears, intact, sides
from physcore.film.styles.typical import Typical
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.periodic import Periodic
from physcore.simulation.sources import Source, SourceFrame
from physcore.storage.pictures import opened

RIM = 0.75
"""Brightness of the rim of a surface, which faces sideways."""
BACK = 0.9
"""Brightness of the back of a surface, relative to its front."""
FRAY = 0.9
"""Brightness of loose threads, relative to the cloth."""
FRAYS = (0.8, 3.0)
"""Least and greatest width of loose threads [pixels]."""
NEVER = 1e-9
"""Least end of the color scale: smaller strains are rounding errors [1]."""
UPWARD = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
"""Upward direction of a texture: along z, or along y for horizontal bodies."""
LARGEST = 4096
"""Longest side of a texture [pixels]."""


class Picture:
    """The pixels (H, W, 3) of a texture, with the texture of the canvas; equality compares the pixels."""

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
    """Spring networks as surfaces: their `faces` as filled triangles. In 3D they have Lambertian shading with smooth
    normals. A triangle with a broken side is not drawn.

        pc.film(recording, "flag.gif", style=pc.styles.Surface("#c0392b", back="#f4e7d3"))

    Args:
        color: "body" or "strain". With "strain", each particle has the color of the mean strain of its springs: blue if
            compressed, red if stretched. Or chosen colors, as in Points: one such as "tomato", one for each body or
            particle, or values or a function for a color scale.
        texture: a picture projected onto the initial shape of the body along its thinnest direction: a path, or an
            array
            (H, W, 3) of bytes; None: no texture.
        range: the strain at the ends of the scale [1]; None: a typical value of the film.
        colormap: the map of the color scale of values, as in Points; None: a part of "viridis".
        back: the color of the back in 3D, the side from which corners are in clockwise order; None: as the front.
        thickness: the width of the rim of a cloth in 3D [m], at least zero; None: the thickness of its SelfContact, or
            no rim.
        weave: distance of the threads of a woven cloth [m], which are seen where they are wider than a pixel, and hang
            loose where the cloth has torn; None: no threads. They run as the sides of a texture. Pages show none.
        on: as in Style; each body must have faces.

    Raises:
        SceneError: a value is not valid.
        FileError: the picture cannot be read.
    """

    color: Literal["body", "strain"] | ColorChoice | PerBody | PerParticle = "body"
    texture: str | os.PathLike[str] | NDArray[np.uint8] | Picture | None = None
    range: float | None = None
    back: str | Color | None = None
    thickness: float | None = None
    colormap: ColormapName | None = None
    weave: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.back is not None:
            self._set(back=color(self.back, "Surface.back"))
        self._set(color=checked(self.color, "Surface.color", ("body", "strain")))
        ramp(self.colormap, "viridis", WHOLE, "Surface.colormap")
        self._set_positive("range", "weave")
        if self.thickness is not None:
            self._set(thickness=number(self.thickness, "Surface.thickness", least=0.0))
        if self.texture is not None and not isinstance(self.texture, Picture):
            self._set(texture=Picture(_pixels(self.texture)))

    def can_draw(self, body: Body) -> bool:
        """Whether a body has faces."""
        return body.network is not None and len(body.network.faces) > 0

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Surface.on: {part.body!r} has no faces; give SpringNetwork faces=, or use Strain()")
        return SurfacePainter(self, source, parts, theme)


class SurfacePainter(Painter):
    """Painter of triangles."""

    def __init__(self, style: Surface, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._theme = style, style, theme
        self._domain: Periodic | None = source.scene.periodic
        faces, pairs, rest, spots, springs = [], [], [], [], []
        for part in parts:
            body = cast("SpringNetwork", part.body)  # the style has checked this
            faces.append(body.faces + part.where.start)
            pairs.append(body.pairs + part.where.start)
            rest.append(body.rest_length)
            springs.append(np.arange(len(body.pairs)) + source.scene.first_spring(body))
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
        start = source.scene.gather("positions")
        self._around = None if start.shape[1] < 3 else around(start, self._faces)
        sheets = [cast("SpringNetwork", part.body).faces for part in parts]
        self._closed = np.concatenate([np.full(len(sheet), _closed(sheet)) for sheet in sheets])
        self._where = places(parts)
        count = source.scene.particles
        self._table = diverging(theme.compressed, theme.relaxed, theme.stretched)
        self._plain = np.full((count, 3), 255.0)
        self._texture = style.texture.texture if isinstance(style.texture, Picture) else None
        white = self._texture is not None and is_word(style.color, "body")
        chosen = cast("Chosen | str", (255, 255, 255) if white else style.color)
        table = ramp(style.colormap, "viridis", theme.part, "Surface.colormap")
        self._by_strain = is_word(style.color, "strain")
        self._coloring = None if self._by_strain else Coloring(chosen, table, "Surface.color", source, parts, theme)
        everywhere = np.zeros((count, 2), dtype=np.float32)
        everywhere[self._where] = np.concatenate(spots)
        self._threads: FloatArray | None = None
        if style.weave is not None:
            self._threads = np.zeros((count, 2))
            self._threads[self._where] = (
                np.concatenate([flattened(part.body.positions) for part in parts]) / style.weave
            )
        self._everywhere, self._spots = everywhere, everywhere[self._faces].reshape(-1, 6)
        self.top, self._typical = style.range or NEVER, Typical()
        if self._coloring is not None:
            self.low, self.top = self._coloring.low, self._coloring.top
            self.fixed = self._coloring.fixed if self._texture is None else None

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given, or there is no scale."""
        return self._style.range is not None if self._coloring is None else self._coloring.settled

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        return (
            strain_scale(self.top, self._table) if self._coloring is None else self._coloring.scale(self.low, self.top)
        )

    @property
    def palette(self) -> FloatArray:
        """Colors (K, 3) that may occur in any frame, including the color of the back."""
        front = super().palette
        return front if self._back is None else np.concatenate([front, self._back[np.newaxis]])

    def observe(self, frame: SourceFrame) -> None:
        """Update the end of the color scale by a frame."""
        if self._coloring is not None:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._coloring.top
        elif not self.settled:
            self.top = max(NEVER, self._typical.add(np.abs(self._strain(frame))[self._where]))

    def inset(self, pixels: float) -> float:
        """A margin of 1.5 pixels."""
        del pixels
        return 1.5

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the triangles."""
        del pixels
        corners, depth, _ = view.project(frame.positions)
        farness = None if depth is None else view.farness(depth)
        faces, spots = self._faces, self._spots
        colors = self._colors(frame)[faces].reshape(-1, 3)
        if not view.flat:
            one, other = corners[faces[:, 1]] - corners[faces[:, 0]], corners[faces[:, 2]] - corners[faces[:, 0]]
            # The y axis of pixels points down: faces that are counterclockwise in the picture have a negative area.
            away = np.repeat(one[:, 0] * other[:, 1] > one[:, 1] * other[:, 0], 3)
            if self._back is not None:
                colors = np.where(away[:, np.newaxis], self._back, colors)
            colors = lit(colors, self._normals(frame.positions, away, view))
            colors = np.where((away & ~np.repeat(self._closed, 3))[:, np.newaxis], BACK * colors, colors)
        far = None if farness is None else farness[faces].ravel()
        inked = inks(np.clip(colors, 0.0, 255.0), self._theme, far).reshape(-1, 12)
        # The inside of a closed surface is not visible.
        shown = self._whole(frame)
        if not view.flat:
            shown &= ~(self._closed & away[::3])
        if not shown.all():
            faces, spots, inked = faces[shown], spots[shown], inked[shown]
        canvas.triangles(
            np.ascontiguousarray(corners[faces].reshape(-1, 6)),
            np.ascontiguousarray(inked),
            None if depth is None else np.ascontiguousarray(depth[faces]),
            self._texture,
            spots,
            None if self._threads is None else self._threads[faces].reshape(-1, 6).astype(np.float32),
        )
        if self._threads is not None and self._sides is not None:
            self._paint_frays(canvas, frame, view, self._threads, shown)
        if self._thickness.any() and not view.flat:
            rim = inks(np.clip(RIM * self._colors(frame), 0.0, 255.0), self._theme, farness)
            paint_rim(canvas, frame.positions, faces, self._thickness, rim, view)

    def _paint_frays(
        self, canvas: Canvas, frame: SourceFrame, view: View, threads: FloatArray, shown: BoolArray
    ) -> None:
        """Queue the loose threads where the cloth has torn."""
        width = float(self._style.weave or 0.0) * view.scale
        loose = frays(frame.positions, threads, self._faces, shown, width)
        count, nodes, dimension = loose.points.shape
        points, depth, _ = view.project(loose.points.reshape(-1, dimension))
        colors = FRAY * self._colors(frame)[self._faces[loose.faces, 0]]
        if not view.flat:
            normals = face_normals(frame.positions, self._faces[loose.faces]) @ view.axes.T
            normals *= np.where(normals[:, 2] < 0.0, -1.0, 1.0)[:, np.newaxis]
            colors = lit(colors, normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, np.newaxis])
        ends, steps = points.reshape(count, nodes, 2), nodes - 1
        deep = None if depth is None else depth.reshape(count, nodes)
        farness = None if deep is None else np.repeat(view.farness(deep[:, 0]), steps)
        canvas.lines(
            np.concatenate([ends[:, :-1], ends[:, 1:]], axis=2).reshape(-1, 4),
            np.full(count * steps, np.clip(width, *FRAYS), dtype=np.float32),
            inks(np.repeat(colors, steps, axis=0), self._theme, farness),
            None if deep is None else np.stack([deep[:, :-1], deep[:, 1:]], axis=2).reshape(-1, 2),
        )

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the triangles on a tape; the page lights them."""
        del pixels
        shown, (faces, points) = self._whole(frame), self._parts
        picture = self._style.texture if isinstance(self._style.texture, Picture) else None
        spots = self._everywhere[points]
        places, colors = frame.positions[points], self._colors(frame)[points]
        for closed in (False, True):
            chosen = self._closed == closed
            if chosen.any():
                tape.surface(
                    places, faces[shown & chosen], colors, closed=closed, back=self._back,
                    texture=None if picture is None else (picture.pixels, spots),
                )  # fmt: skip
        if self._thickness.any() and not view.flat:
            rim = inks(np.clip(RIM * self._colors(frame), 0.0, 255.0), self._theme, None)
            paint_rim(cast("Canvas", tape), frame.positions, self._faces[shown], self._thickness, rim, view)

    @cached_property
    def _parts(self) -> tuple[IntArray, IntArray]:
        """The triangles (T, 3) with points of their own on each side of a sharp edge, and the particles of these."""
        corners = self._faces.ravel()
        if self._around is None:
            points, index = np.unique(corners, return_inverse=True)
        else:
            ends = np.flatnonzero(np.diff(self._around[0])) + 1
            faces = [each.tobytes() for each in np.split(self._around[1], ends)]
            known: dict[tuple[int, bytes], int] = {}
            keys = zip(corners.tolist(), faces, strict=True)
            index = np.array([known.setdefault(key, len(known)) for key in keys])
            points = np.array([corner for corner, _ in known])
        return index.reshape(-1, 3), points

    def _whole(self, frame: SourceFrame) -> BoolArray:
        """Whether each triangle has no broken side, and does not cross a face of the domain."""
        shown = np.ones(len(self._faces), dtype=np.bool_)
        if self._sides is not None:
            shown &= intact(frame, self._sides).all(axis=1)
        if self._domain is not None:
            # A triangle across a face of the domain would be drawn across the whole picture.
            around = self._faces[:, [0, 1, 2, 0]]
            shown &= straight(self._domain, np.diff(frame.positions[around], axis=1)).all(axis=1)
        return shown

    def _colors(self, frame: SourceFrame) -> FloatArray:
        if self._coloring is not None:
            self._plain[self._where] = self._coloring.colors(frame, self.low, self.top)
            return self._plain
        return look_up(self._table, rooted(self._strain(frame) / self.top))

    def _strain(self, frame: SourceFrame) -> FloatArray:
        """The mean strain (N,) of the unbroken springs of each particle."""
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

    def _normals(self, positions: FloatArray, away: BoolArray, view: View) -> FloatArray:
        """Unit normals at the corners of all faces (3T, 3), in the coordinates of the view and toward the camera.

        A corner has the mean normal of the faces around it, without those beyond a sharp edge in the initial shape.
        """
        flat = face_normals(positions, self._faces) @ view.axes.T
        normals = corner_normals(self._faces, flat, len(positions), self._around)
        normals[away] *= -1.0
        # Near the silhouette, a mean normal may point away from the camera though its face does not.
        normals[:, 2] = np.maximum(normals[:, 2], 0.0)
        return normals


def _closed(faces: IntArray) -> bool:
    """Whether a surface is closed: each edge of the faces (T, 3) occurs twice, once in each direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = int(faces.max(initial=0)) + 1
    return bool((np.sort(edges @ [count, 1]) == np.sort(edges[:, ::-1] @ [count, 1])).all())


def spread(positions: FloatArray) -> NDArray[np.float32]:
    """Texture coordinates (N, 2) of particles, 0–1 to the right and up.

    The projection is along the thinnest direction of the body, upright, from the side of the default camera.
    """
    centered = flattened(positions)
    low, high = centered.min(axis=0), centered.max(axis=0)
    places: NDArray[np.float32] = ((centered - low) / np.maximum(high - low, 1e-300)).astype(np.float32)
    return places


def flattened(positions: FloatArray) -> FloatArray:
    """Positions (N, 2) [m] along the thinnest direction of a body, to the right and up from its middle."""
    centered: FloatArray = positions - positions.mean(axis=0)
    if positions.shape[1] == 3:
        normal = np.linalg.svd(centered, full_matrices=False)[2][-1] if len(positions) > 2 else np.array(UPWARD[0])
        normal = normal if normal @ Orbit().axes[2] > 0.0 else -normal
        upward = np.array(UPWARD[int(abs(normal[2]) > 0.9)])
        upward = upward - (upward @ normal) * normal
        upward /= np.linalg.norm(upward)
        centered = np.stack([centered @ np.cross(upward, normal), centered @ upward], axis=1)
    return centered


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

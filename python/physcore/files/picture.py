"""Pictures as fields, masks, outlines and ground."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import numpy as np

from physcore.boundaries.height_field import HeightField
from physcore.checks import BoolArray, FloatArray, array, frozen, number
from physcore.checks import text as checked_text
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.files.reader import Options, Reader
from physcore.scene.masks import FILES, coverage, opacity, polygon_from_mask
from physcore.scene.polytopes import Compound, Polygon
from physcore.storage.pictures import opened

WHITE = {"1": 1.0, "L": 255.0, "I": 65535.0, "I;16": 65535.0, "I;16B": 65535.0, "F": 1.0}
"""Value of white, by Pillow's modes of gray pictures. Numbers of mode F, which may be heights, are kept."""
LUMINANCE = (0.299, 0.587, 0.114)
"""Weights of red, green and blue, as in ITU-R BT.601."""
FAINT = 1.0 / 255.0
"""Least difference of brightness: one step of eight bits."""


class Picture:
    """Picture: brightness in pixels, indexed as fields on a Grid.

        island = pc.read("island.png")
        ground = island.height_field(width=100.0, lowest=0.0, highest=12.0)
        walls = island.mask(0.5)  # for Wave(walls=…), where the picture is bright
        word = pc.Picture.text("physcore")  # as a mask or an outline

    Indices are [i, j] along x and y, from the lower left corner. A picture with transparency has its opacity in place
    of the brightness.

    Attributes:
        brightness: 0 where black, 1 where white, shape (columns, rows).
        name: the file or the text, for messages.
    """

    def __init__(self, brightness: FloatArray, name: str) -> None:
        values = array(brightness, "Picture.brightness")
        if values.ndim != 2 or not values.size:
            raise SceneError(f"Picture.brightness: must have the shape (columns, rows), got {values.shape}")
        self.brightness: FloatArray = frozen(values)
        self.name = name

    @classmethod
    @entrance
    def text(cls, text: str) -> Picture:
        """A line of text, white on black, in the face of films.

            letters = pc.Picture.text("R").mask()

        Args:
            text: the line.

        Raises:
            SceneError: no face has a sign.
        """
        line = checked_text(text, "Picture.text")
        return cls(coverage(line, "Picture.text").T[:, ::-1], repr(line))

    @property
    def negative(self) -> Picture:
        """The picture with black and white exchanged, as for dark letters on white paper."""
        return Picture(1.0 - self.brightness, self.name)

    def __repr__(self) -> str:
        columns, rows = self.brightness.shape
        return f"Picture({self.name}, {columns} × {rows} pixels)"

    @entrance
    def mask(self, level: float = 0.5) -> BoolArray:
        """The pixels that are brighter than a level.

            bright = pc.Picture.text("R").mask(0.5)

        Args:
            level: from 0 to 1.

        Returns:
            A mask (columns, rows), indexed [i, j] along x and y as fields on a Grid.

        Raises:
            SceneError: all pixels are brighter, or none.
        """
        bound = number(level, "mask.level", least=0.0, most=1.0)
        found: BoolArray = self.brightness > bound
        if found.all() or not found.any():
            low, high = self.brightness.min(), self.brightness.max()
            raise SceneError(
                f"mask.level: {'all' if found.all() else 'no'} pixels of {self.name} are brighter than {bound:g}; they "
                f"are from {low:.3g} to {high:.3g}{_advice(low, high)}"
            )
        return found

    @entrance
    def outline(self, height: float, level: float = 0.5, tolerance: float | None = None) -> Polygon | Compound:
        """The outline of what is brighter than a level, as the shape of a rigid body in 2D.

            letter = pc.RigidBody(pc.Picture.text("R").outline(height=0.3), (0.0, 1.0))

        Args:
            height: height of the picture [m].
            level: as in `mask`.
            tolerance: as in polygon_from_mask.

        Raises:
            SceneError: all pixels are brighter, or none, or a value is out of range.
        """
        self.mask(level)
        span = self.brightness - number(level, "outline.level")
        values = np.clip(0.5 + span, 0.0, 1.0).T[::-1]  # 1/2 at the level, with the slope of the picture
        return polygon_from_mask(values, height, tolerance)

    @entrance
    def height_field(
        self,
        width: float,
        lowest: float,
        highest: float,
        origin: float | tuple[float, ...] = 0.0,
        *,
        restitution: float = 1.0,
        friction: float = 0.0,
        no_slip: bool = False,
    ) -> HeightField:
        """Ground whose height is the brightness: a node at the center of each pixel.

            hills = pc.read("hills.png").height_field(width=50.0, lowest=0.0, highest=8.0)

        Args:
            width: distance from the first to the last node along x [m].
            lowest, highest: heights of black and of white [m].
            origin, restitution, friction, no_slip: as in HeightField.

        Raises:
            SceneError: the picture has no contrast, or a value is out of range.
        """
        low, high = self.brightness.min(), self.brightness.max()
        if high - low < FAINT:
            raise SceneError(
                f"height_field: {self.name} has no contrast: all pixels are {low:.3g}; the ground is a Floor"
            )
        if min(self.brightness.shape) < 2:
            raise SceneError(f"height_field: {self.name} must have at least two pixels along each side")
        spacing = number(width, "height_field.width", above=0.0) / (len(self.brightness) - 1)
        bottom = number(lowest, "height_field.lowest")
        heights = bottom + (number(highest, "height_field.highest") - bottom) * self.brightness
        return HeightField(heights, spacing, origin, restitution=restitution, friction=friction, no_slip=no_slip)


class PictureReader(Reader):
    """Reader of pictures."""

    kind: ClassVar = "pictures"
    suffixes: ClassVar = FILES

    def read(self, path: Path, suffix: str, options: Options) -> Picture:
        """The brightness of a picture, with all its bits; the opacity if it has any transparency."""
        del suffix, options
        with opened(path) as image:
            if image.mode in WHITE and "transparency" not in image.info:
                values = np.asarray(image, dtype=np.float64) / WHITE[image.mode]
            else:
                pixels = np.asarray(image.convert("RGBA"), dtype=np.float64) / 255.0
                transparency = opacity(pixels)
                values = (pixels[..., :3] * LUMINANCE).sum(axis=2) if transparency is None else transparency
        return Picture(values.T[:, ::-1], str(path))


def _advice(low: float, high: float) -> str:
    """The end of a message on a level."""
    if high - low < FAINT:
        return ": the picture has no contrast"
    return f", so that {0.5 * (low + high):.3g} would divide them"

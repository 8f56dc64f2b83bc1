"""Shapes from pictures: outlines of masks, image files and texts."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from physcore._core import Canvas, missing_signs, text_width
from physcore.checks import FloatArray, number, regular, require, shown
from physcore.entrance import entrance
from physcore.errors import FileError, SceneError
from physcore.scene.outlines import area, outlines, simplified
from physcore.scene.polytopes import Compound, Polygon
from physcore.storage.pictures import opened

TEXT = 160
"""Height of a line of text [pixels]."""
MARGIN = 20
"""Margin on both sides, over which letters may extend [pixels]."""
HALF = 0.5
"""Value at the outline, and the default tolerance [pixels]."""
FILES = (".png", ".jpg", ".jpeg", ".gif", ".webp", ".bmp", ".tif", ".tiff")
"""Endings of the names of image files."""


@entrance
def polygon_from_mask(
    mask: ArrayLike | str | os.PathLike[str], height: float = 1.0, tolerance: float | None = None
) -> Polygon | Compound:
    """Outline of a mask, an image file or a text: the shape of a rigid body in 2D.

        letter = pc.polygon_from_mask("R", height=0.3)
        x, y = np.meshgrid(np.linspace(-1.0, 1.0, 60), np.linspace(-1.0, 1.0, 60))
        ring = pc.polygon_from_mask(np.abs(np.hypot(x, y) - 0.7) < 0.2, height=0.3)
        bodies = [pc.RigidBody(letter, (0.0, 1.0)), pc.RigidBody(ring, (0.5, 1.0))]

    The outline is where the mask has the value 1/2, by linear interpolation between the centers of its pixels. Vertices
    are left out where the outline moves by at most `tolerance`. Specks that vanish thereby are left out.

    Coordinates begin at the lower left corner of the mask; x points right and y up. A shape of one piece without holes
    is a Polygon. Several pieces are a Compound, and so are pieces with holes, cut through each hole along y.

    Args:
        mask: what to outline:
            an array (rows, columns), bool or numbers from 0 to 1, the first row at the top;
            an image file, as a path or a text such as "logo.png": what is opaque, or dark if all is opaque;
            any other text: one line in the faces of films.
        height: height of the mask, of the image or of the line of text [m].
        tolerance: largest distance of the outline from that of the mask [m]; None: half a pixel.

    Raises:
        SceneError: there is no such file, it is no image, the mask is empty, a sign has no face, or a value is out of
            range.

    Source:
        W. E. Lorensen, H. E. Cline, SIGGRAPH Comput. Graph. 21, 163 (1987), in 2D; D. H. Douglas, T. K. Peucker,
        Cartographica 10, 112 (1973).
    """
    values = _values(mask)
    size = number(height, "polygon_from_mask.height", above=0.0) / len(values)
    most = HALF if tolerance is None else number(tolerance, "polygon_from_mask.tolerance", least=0.0) / size
    polygons = [loop for piece in _pieces(values) for loop in [simplified(piece, most)] if len(loop) > 2]
    if not polygons:
        raise SceneError("polygon_from_mask.mask: must have a piece that is larger than the tolerance, got none")
    shapes = [Polygon(size * loop) for loop in polygons]
    return shapes[0] if len(shapes) == 1 else Compound([(shape, (0.0, 0.0)) for shape in shapes])


def _pieces(values: FloatArray) -> list[FloatArray]:
    """The outlines of all pieces of a mask, counterclockwise (K, 2) [pixels]; pieces with holes are cut."""
    loops = outlines(values)
    hole = next((loop for loop in loops if area(loop) < 0.0), None)
    if hole is None:
        return loops
    column = np.arange(values.shape[1]) < 0.5 * (hole[:, 0].min() + hole[:, 0].max())
    return [loop for side in (column, ~column) for loop in _pieces(np.where(side, values, 0.0))]


def _values(mask: ArrayLike | str | os.PathLike[str]) -> FloatArray:
    """Values (rows, columns) from 0 to 1."""
    if isinstance(mask, os.PathLike) or (isinstance(mask, str) and Path(mask).suffix.lower() in FILES):
        return _image(Path(mask))
    if isinstance(mask, str):
        return coverage(mask, "polygon_from_mask.mask")
    path = "polygon_from_mask.mask"
    given = regular(mask, path)
    if given.ndim != 2 or given.size == 0 or given.dtype.kind not in "buif":
        raise SceneError(f"{path}: must be an array (rows, columns), an image file or a text, got {shown(mask)}")
    values = given.astype(np.float64)
    require((values >= 0.0) & (values <= 1.0), values, path, "bool, or from 0 to 1")
    return values


def _image(path: Path) -> FloatArray:
    """The opacity of an image, or its darkness if all of it is opaque."""
    if not path.exists():
        raise SceneError(f"polygon_from_mask.mask: there is no file {str(path)!r}")
    try:
        with opened(path) as image:
            pixels = np.asarray(image.convert("RGBA"), dtype=np.float64) / 255.0
    except FileError as error:
        raise SceneError(f"polygon_from_mask.mask: {error}") from error
    transparency = opacity(pixels)
    if transparency is not None:
        return transparency
    darkness: FloatArray = 1.0 - (0.299 * pixels[..., 0] + 0.587 * pixels[..., 1] + 0.114 * pixels[..., 2])
    return darkness


def opacity(pixels: FloatArray) -> FloatArray | None:
    """The opacity (rows, columns) of pixels (rows, columns, 4) from 0 to 1; None if all are opaque."""
    values: FloatArray = pixels[..., 3]
    return values if (values < 1.0).any() else None


def coverage(text: str, path: str) -> FloatArray:
    """The share of each pixel (rows, columns) that a line of text covers.

    Raises:
        SceneError: no face has a sign.
    """
    if missing := missing_signs(text):
        raise SceneError(f"{path}: no face has the signs {missing!r}")
    canvas = Canvas(text_width(text, TEXT) + 2 * MARGIN, TEXT, (0, 0, 0))
    canvas.text(text, MARGIN, 0, TEXT, (255, 255, 255, 255), -1)
    return canvas.pixels()[..., 0] / 255.0

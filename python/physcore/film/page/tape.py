"""A tape: takes the place of a canvas, and keeps the shapes that are drawn instead of their pixels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physcore._core import Sky, Texture, text_width
from physcore.checks import FloatArray, IntArray
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.page.track import Track

Color = tuple[int, int, int]
Inks = NDArray[np.uint8]
MOST = 1_500_000_000
"""Largest size of all shapes in memory [bytes]."""
TYPICAL = 0.5
"""Light at a point of typical density, as of the canvas."""
GRAINS = 8000
"""Largest number of points of a density."""
TEXELS = 512
"""Longest side of a texture [pixels]."""
FAR = 8.0
"""Shapes are cut off at this many widths of the picture from its middle."""


class Tape:
    """All shapes of a film. It has the methods of Canvas that painters and looks of scenery call."""

    def __init__(self) -> None:
        self.tracks: list[Track] = []
        self.eyes: dict[int, list[list[float]]] = {}
        """The eye of each panel in each frame, in 3D: scale [pixels/m], middle [pixels], 1 / distance [1/m]."""
        self.texts: list[list[list[object]]] = []
        """The texts of each frame: words, x, y, height, color, alignment, width."""
        self.count = 0
        """Number of frames so far."""
        self._known: dict[tuple[object, ...], Track] = {}
        self._numbers: dict[tuple[object, ...], int] = {}
        self._view: View | None = None
        self._panel, self._owner, self._name, self._still, self._whole, self._size = 0, 0, "", False, False, 0

    def next(self) -> None:
        """Begin the next frame."""
        self.texts.append([])
        self._numbers.clear()
        self.count += 1

    def look(self, panel: int, view: View) -> None:
        """Draw in a panel with a view from now on."""
        self._panel, self._view = panel, view
        if not view.flat:
            near = 1.0 / view.distance if math.isfinite(view.distance) else 0.0
            self.eyes.setdefault(panel, []).append([view.scale, *view.middle, near])

    def begin(self, owner: int, name: str, *, still: bool = False, whole: bool = False) -> None:
        """Draw the shapes of one owner from now on, which has a name in messages. `still` ones are in all frames.
        `whole` ones may lie anywhere in the panel, also beside its free part.
        """
        self._owner, self._name, self._still, self._whole = owner, name, still, whole

    # The methods of Canvas.

    def discs(
        self,
        centers: PixelArray,
        radii: PixelArray,
        colors: Inks,
        depths: PixelArray | None = None,
        shading: float = 0.0,
    ) -> None:
        """Add discs, in 3D balls."""
        self._add_round("disc", centers, radii, colors, depths, shading=float(shading))

    def halos(
        self, centers: PixelArray, radii: PixelArray, colors: Inks, depths: PixelArray | None = None,
        shadow: bool = False,
    ) -> None:  # fmt: skip
        """Add halos."""
        self._add_round("halo", centers, radii, colors, depths, shadow=bool(shadow))

    def liquid(
        self, centers: PixelArray, radii: PixelArray, colors: Inks, sky: Sky, depths: PixelArray | None = None,
        scale: float = 0.0, glow: float = 0.0,
    ) -> None:  # fmt: skip
        """Add the drops of a liquid, which join."""
        del scale
        full = opaque(colors[:, :3]) if depths is None else colors
        self._add_round("liquid", centers, radii, full, depths, glow=float(glow), sky=_parts_of(sky))

    def lines(self, ends: PixelArray, widths: PixelArray, colors: Inks, depths: PixelArray | None = None) -> None:
        """Add lines with round ends."""
        places = self._placed(ends.reshape(-1, 2), None if depths is None else depths.ravel(), None)[0]
        self._add("line", depths is not None, places.reshape(-1, 2 * places.shape[1]), widths, colors)

    def trails(
        self, past: PixelArray, widths: PixelArray, colors: Inks, fade: tuple[Color, float] | None = None,
        gaps: NDArray[np.bool_] | None = None, depths: PixelArray | None = None,
    ) -> None:  # fmt: skip
        """Add lines that taper and fade with age."""
        steps = len(past) - 1
        if steps < 1:
            return
        fresh = (np.arange(1, steps + 1, dtype=np.float32) / (steps + 1))[:, np.newaxis]
        shown = np.full((steps, len(widths)), True) if gaps is None else ~gaps
        ends = np.concatenate([past[:-1], past[1:]], axis=2)[shown]
        inks = np.broadcast_to(colors.astype(np.float32), (steps, *colors.shape)).copy()
        wide = fresh * widths
        if fade is not None:
            ground, left = np.array(fade[0], dtype=np.float32), fade[1]
            inks[..., :3] += (1.0 - left * fresh[..., np.newaxis]) * (ground - inks[..., :3])
            wide = np.maximum(wide, 1.0)
        both = None if depths is None else np.stack([depths[:-1], depths[1:]], axis=2)[shown]
        self.lines(ends, wide[shown].astype(np.float32), np.round(inks[shown]).astype(np.uint8), both)

    def triangles(
        self, corners: PixelArray, colors: Inks, depths: PixelArray | None = None, texture: Texture | None = None,
        places: PixelArray | None = None, weave: PixelArray | None = None,
    ) -> None:  # fmt: skip
        """Add triangles with a color at each corner, without their weave."""
        del places, weave
        if texture is not None:
            self._refuse("a texture")
        deep = None if depths is None else np.broadcast_to(depths, (len(corners), 3)).ravel()
        found = self._placed(corners.reshape(-1, 2), deep, None)[0]
        self._add("triangle", depths is not None, found.reshape(-1, 3 * found.shape[1]), None, colors.reshape(-1, 12))

    def polygon(self, corners: PixelArray, color: tuple[int, int, int, int]) -> None:
        """Add a convex polygon."""
        index = np.arange(1, len(corners) - 1)
        fan = np.asarray(corners, dtype=np.float32)[np.stack([np.zeros_like(index), index, index + 1], axis=1)]
        self._add("triangle", False, fan.reshape(-1, 6), None, np.tile(np.array(color, np.uint8), (len(fan), 3)))

    def ground(
        self, normal: Sequence[float], center: Sequence[float], size: float, color: Color, along: Sequence[float],
        grid: tuple[Color, float, float] | None = None, part: tuple[list[tuple[float, float]], float] | None = None,
    ) -> None:  # fmt: skip
        """Add ground, or a wall."""
        corners = None if part is None else self._on_plane(np.array(part[0]), np.array(normal), np.array(center))
        self._set(
            "ground",
            normal=[*normal], center=[*center], size=float(size), color=[*color], along=[*along], grid=grid,
            part=corners, share=None if part is None else part[1],
        )  # fmt: skip

    def backdrop(self, center: tuple[float, float], radius: float, color: Color, share: float) -> None:
        """Add a light in the background."""
        self._set("backdrop", center=[*center], radius=float(radius), color=[*color], share=float(share))

    def text(self, text: str, x: int, y: int, height: int, color: Sequence[int], align: int) -> None:
        """Add a text to the present frame."""
        wide = text_width(text, int(height))
        self.texts[-1].append([text, int(x), int(y), int(height), [*color], int(align), wide])

    def paint(self) -> None:
        """No effect: shapes are drawn in the order in which they were added, in 3D by their depth."""

    def density(
        self, points: PixelArray, table: Inks, strength: float, spread: float, places: FloatArray | None = None
    ) -> None:
        """Add points that are shown as a density, in 3D with their places (N, 3) [m]. Of many there is an even
        selection, with wider light. The light of each is relative to the mean density over all points.
        """
        assert self._view is not None  # `look` comes first
        each = 1 + len(points) // GRAINS
        points, places = points[::each], None if places is None else places[::each]
        spread = max(float(spread), 0.1) * math.sqrt(each)
        deep, known = places is not None, np.isfinite(points).all(axis=1)
        light = strength * TYPICAL / _mean_density(points[known], spread, self._view.middle)
        size = 1.0 / self._view.scale if deep else 1.0
        track = self._track("density", deep, table=opaque(table), colors=len(table), spread=spread, size=size)
        found = points if places is None else self._from_eye(places).astype(np.float32)
        arrays: dict[str, NDArray[Any]] = {"places": found[known], "light": np.array([[light]], dtype=np.float32)}
        self._keep(track, arrays)

    def picture(self, *values: object) -> None:
        """Refuse pixels.

        Raises:
            SceneError: always.
        """
        self._refuse("pixels")

    # What a canvas does not have.

    def phase(self, parts: list[NDArray[np.uint8]], corners: FloatArray, **fixed: Any) -> None:
        """Add the real and the imaginary part (nx, ny) of a wave function, on a rectangle as in `grid`."""
        assert self._view is not None  # `look` comes first
        places, cells = self._view.project(corners)[0].tolist(), [*parts[0].shape]
        arrays: dict[str, NDArray[Any]] = {
            name: np.ascontiguousarray(part.T).reshape(-1, 1)
            for name, part in zip(("real", "imaginary"), parts, strict=True)
        }
        self._keep(self._track("phase", False, cells=cells, corners=places, **fixed), arrays)

    def grid(self, values: NDArray[np.uint8], corners: FloatArray, **fixed: Any) -> None:
        """Add the values (nx, ny) of a grid as indices of a table of colors, on a rectangle with corners (4, D) [m]: at
        the origin, along x, along both, and along y.
        """
        assert self._view is not None  # `look` comes first
        places = self._view.project(corners)[0] if self._view.flat else self._from_eye(corners)
        arrays = {"values": np.ascontiguousarray(values.T).reshape(-1, 1)}
        track = self._track("grid", not self._view.flat, cells=[*values.shape], corners=places.tolist(), **fixed)
        self._keep(track, arrays)

    def surface(
        self, points: FloatArray, faces: IntArray, colors: FloatArray, *, closed: bool, back: FloatArray | None,
        texture: tuple[Inks, PixelArray] | None = None, sky: Sky | None = None,
    ) -> None:  # fmt: skip
        """Add a surface, which is lit in 3D: points (N, D) [m] with colors (N, 3), and triangles (T, 3).

        Args:
            points, faces, colors: the surface.
            closed: whether its inside is never seen.
            back: the color of the back (3,); None: as the front.
            texture: pixels (H, W, 3) that multiply the colors, and their coordinates (N, 2) at the points.
            sky: the sky that it reflects as water does; None: it reflects none.
        """
        assert self._view is not None  # `look` comes first
        deep = not self._view.flat
        place = self._from_eye(points) if deep else self._view.project(points)[0]
        ink = np.round(np.clip(colors, 0.0, 255.0)).astype(np.uint8)
        fixed: dict[str, Any] = {"closed": closed, "back": None if back is None else back.tolist()}
        if sky is not None:
            fixed["sky"] = _parts_of(sky)
        if texture is not None:
            pixels = texture[0][:: -(-texture[0].shape[0] // TEXELS), :: -(-texture[0].shape[1] // TEXELS)]
            fixed |= {"texels": opaque(pixels.reshape(-1, 3)), "texture": [*pixels.shape[1::-1]], "spots": texture[1]}
        arrays: dict[str, NDArray[Any]] = {"places": np.nan_to_num(place.astype(np.float32)), "inks": opaque(ink)}
        arrays["faces"] = faces.astype(np.uint32)
        self._keep(self._track("surface", deep, **fixed), arrays)

    def solids(
        self, points: FloatArray, normals: FloatArray, tones: FloatArray, triangles: IntArray,
        positions: FloatArray, rotations: FloatArray, colors: FloatArray,
    ) -> None:  # fmt: skip
        """Add rigid bodies in 3D of one lit mesh: positions (N, 3) [m], rotations (N, 3, 3) and colors (N, 3)."""
        assert self._view is not None  # `look` comes first
        mesh = {"points": points.astype(np.float32), "normals": normals.astype(np.float32)}
        mesh |= {"tones": tones.astype(np.float32).reshape(-1, 1), "triangles": triangles.astype(np.uint32)}
        turns = quaternions(self._view.axes @ rotations)
        track = self._track("solid", True, **mesh)
        before = track.frames.get(self.count - 2, {}).get("turns")
        if before is not None and before.shape == turns.shape:
            turns[(turns * before).sum(axis=1) < 0.0] *= -1.0
        places, inks = self._from_eye(positions).astype(np.float32), np.round(np.clip(colors, 0.0, 255.0))
        self._keep(track, {"places": places, "turns": turns, "inks": opaque(inks.astype(np.uint8))})

    def _add_round(
        self, kind: str, centers: PixelArray, radii: PixelArray, colors: Inks, depths: PixelArray | None, **fixed: Any
    ) -> None:
        places, sizes = self._placed(centers, depths, radii)
        self._add(kind, depths is not None, places, sizes, colors, **fixed)

    def _add(
        self, kind: str, deep: bool, places: NDArray[Any], sizes: NDArray[Any] | None, colors: Inks, **fixed: Any
    ) -> None:
        """Add shapes with one row of places, sizes and colors each. Those that are nowhere are left out."""
        arrays: dict[str, NDArray[Any]] = {"places": places.astype(np.float32), "inks": colors}
        if sizes is not None:
            arrays["sizes"] = rounded(np.asarray(sizes)).reshape(-1, 1)
        known = np.isfinite(arrays["places"]).all(axis=1)
        if not known.all():
            arrays = {name: values[known] for name, values in arrays.items()}
        if self._view is not None and len(places):
            reach = FAR * 2.0 * max(self._view.middle) / (self._view.scale if deep else 1.0)
            np.clip(arrays["places"], -reach, reach, out=arrays["places"])
        self._keep(self._track(kind, deep, **fixed), arrays)

    def _track(self, kind: str, deep: bool, **fixed: Any) -> Track:
        """The track of the next shapes of this kind: the nth of a frame is the same in all frames."""
        key = (self._panel, self._owner, self._still, kind, deep)
        number = self._numbers[key] = self._numbers.get(key, -1) + 1
        track = self._known.get((*key, number))
        if track is None:
            fixed |= {"whole": True} if self._whole else {}
            track = self._known[*key, number] = Track(kind, self._panel, deep, self._still, fixed)
            self.tracks.append(track)
        return track

    def _set(self, kind: str, **fixed: Any) -> None:
        """Add a single shape that does not change but with the camera."""
        track = self._track(kind, True, shapes={})
        shapes = track.fixed["shapes"]
        if not shapes or shapes[max(shapes)] != fixed:
            shapes[0 if track.still else self.count - 1] = fixed

    def _keep(self, track: Track, arrays: dict[str, NDArray[Any]]) -> None:
        self._size += track.add(0 if track.still else self.count - 1, arrays)
        if self._size > MOST:
            raise SceneError(
                f"path: a page keeps all frames in memory, and {self.count} of them have {self._size / 1e9:.1f} GB of "
                "shapes; give it fewer frames per second or fewer particles, or write an .mp4"
            )

    def _refuse(self, what: str) -> None:
        raise SceneError(
            f"style: {self._name} draws {what}, which a page cannot show; give another style, or write an .mp4 or .gif"
        )

    def _placed(
        self, pixels: PixelArray, depths: PixelArray | None, radii: PixelArray | None
    ) -> tuple[NDArray[Any], NDArray[Any] | None]:
        """Places from pixels (N, 2) and depths (N,) [m], and sizes from radii (N,) [pixels]."""
        if depths is None:
            return pixels, radii
        assert self._view is not None  # `look` comes first
        depth = depths.astype(np.float64)
        near = 1.0 / self._view.distance if math.isfinite(self._view.distance) else 0.0
        length = np.maximum(1.0 + near * depth, 0.05) / self._view.scale
        (x, y), middle = pixels.T.astype(np.float64), self._view.middle
        places = np.stack([(x - middle[0]) * length, (middle[1] - y) * length, -depth], axis=1)
        return places, None if radii is None else radii * length

    def _from_eye(self, points: FloatArray) -> FloatArray:
        """Points (N, 3) [m] along the axes of the camera, relative to the point that it looks at."""
        assert self._view is not None  # `look` comes first
        place: FloatArray = points @ self._view.axes.T - self._view.center
        return place

    def _on_plane(self, pixels: FloatArray, normal: FloatArray, center: FloatArray) -> list[list[float]]:
        """The points of a plane that are seen at pixels (K, 2), along the axes of the camera [m]."""
        assert self._view is not None  # `look` comes first
        focus = np.zeros((len(pixels), 3))
        focus[:, :2] = (pixels - self._view.middle) / self._view.scale * (1.0, -1.0)
        far = math.isfinite(self._view.distance)
        start = np.array([0.0, 0.0, self._view.distance]) if far else focus
        toward = focus - start if far else np.tile([0.0, 0.0, -1.0], (len(pixels), 1))
        way = ((center - start) @ normal) / (toward @ normal)
        points: list[list[float]] = (start + way[:, np.newaxis] * toward).tolist()
        return points


def _parts_of(sky: Sky) -> list[list[float]]:
    """The values of a sky: the colors at its horizon and zenith, the direction to the zenith, and the brightness."""
    return [[*sky.horizon], [*sky.zenith], [*sky.up], [sky.brightness]]


def _mean_density(points: PixelArray, spread: float, middle: tuple[float, float]) -> float:
    """The mean over all points of the density of points, each spread by a Gaussian [1/pixels²].

    It is Σ L² / Σ L over the pixels of a picture around `middle`, by Parseval's theorem from the Fourier transform of
    the counts and that of the Gaussian.
    """
    size = [2 * max(1, round(each)) for each in middle]
    x, y = points.astype(np.float64).T
    counts = np.histogram2d(x, y, bins=size, range=[(0.0, float(size[0])), (0.0, float(size[1]))])[0]
    waves = [2.0 * np.pi * np.fft.fftfreq(size[0])[:, np.newaxis], 2.0 * np.pi * np.fft.fftfreq(size[1])]
    lights = np.fft.fft2(counts) * np.exp(-0.5 * max(spread, 0.1) ** 2 * (waves[0] ** 2 + waves[1] ** 2))
    total = float(counts.sum())
    return float((np.abs(lights) ** 2).sum()) / (counts.size * total) if total > 0.0 else 1.0


def rounded(sizes: NDArray[Any]) -> NDArray[np.float32]:
    """Sizes with a mantissa of 10 bits: in 3D they follow from pixels, and their last bits differ in each frame."""
    fraction, exponent = np.frexp(sizes.astype(np.float64))
    result: NDArray[np.float32] = np.ldexp(np.round(fraction * 1024.0) / 1024.0, exponent).astype(np.float32)
    return result


def opaque(colors: Inks) -> Inks:
    """Colors (N, 3) as opaque inks (N, 4)."""
    return np.concatenate([colors, np.full((len(colors), 1), 255, dtype=np.uint8)], axis=1)


def quaternions(rotations: FloatArray) -> NDArray[np.float32]:
    """Unit quaternions (N, 4) (w, x, y, z) of rotations (N, 3, 3).

    The largest of the four squares 4w² = 1 + r₀₀ + r₁₁ + r₂₂, … is found first, so that no small number divides.

    Source: S. W. Shepperd, "Quaternion from rotation matrix", J. Guidance and Control 1, 223 (1978).
    """
    r = rotations
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    squares = np.stack([1.0 + trace, *(1.0 + 2.0 * r[:, k, k] - trace for k in range(3))], axis=1)
    one, two, three = (r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1])
    xy, xz, yz = (r[:, 0, 1] + r[:, 1, 0], r[:, 0, 2] + r[:, 2, 0], r[:, 1, 2] + r[:, 2, 1])
    rows = np.array(
        [
            [squares[:, 0], one, two, three],
            [one, squares[:, 1], xy, xz],
            [two, xy, squares[:, 2], yz],
            [three, xz, yz, squares[:, 3]],
        ]
    )
    each = np.arange(len(r))
    chosen = rows[squares.argmax(axis=1), :, each]
    result: NDArray[np.float32] = (chosen / np.linalg.norm(chosen, axis=1, keepdims=True)).astype(np.float32)
    return result

"""The curves of particles over the last frames, and where a picture shows them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import islice

import numpy as np

from physcore.checks import BoolArray, FloatArray
from physcore.film.camera.view import PixelArray, View
from physcore.film.styles.base import straight
from physcore.film.styles.curve import Curve
from physcore.scene.periodic import Periodic


@dataclass(eq=False)
class _Piece:
    """The part of the curves between two frames, and its pixels in the view in which it was seen last."""

    points: FloatArray
    """Shape (K, N, D) [m]."""
    view: View | None = None
    pixels: PixelArray | None = None
    """Shape (K, N, 2)."""
    depth: PixelArray | None = None
    """Shape (K, N) [m]; None in 2D."""

    def see(self, view: View) -> None:
        """Project it, if it has not been in this view: a camera that stands still needs that once for each piece."""
        if view is not self.view:
            moments, count, dimension = self.points.shape
            pixels, depth, _ = view.project(self.points.reshape(-1, dimension))
            self.view, self.pixels = view, pixels.reshape(moments, count, 2)
            self.depth = None if depth is None else depth.reshape(moments, count)


class Past:
    """The curves of N particles over the last frames, frame by frame.

    Args:
        interval: between two frames [s].
        frames: how many are kept, the present one included; None: all.
        domain: the periodic domain, in which only positions are joined.
    """

    def __init__(self, interval: float, frames: int | None, domain: Periodic | None = None) -> None:
        self._pieces: deque[_Piece] = deque(maxlen=frames)
        self._curve, self._domain = Curve(interval, smooth=domain is None), domain

    @property
    def frames(self) -> int | None:
        """How many frames are kept; None: all."""
        return self._pieces.maxlen

    def begin(self) -> None:
        """Forget everything."""
        self._pieces.clear()
        self._curve.begin()

    def add(self, points: FloatArray, velocities: FloatArray | None) -> None:
        """Take a frame into account: positions (N, D) [m], and velocities [m/s], if they are known."""
        self._pieces.append(_Piece(self._curve.piece(points, velocities)))

    def seen(self, view: View) -> tuple[PixelArray, PixelArray | None]:
        """Pixels (K, N, 2) and depths (K, N), which are None in 2D, from the end of the oldest piece on."""
        for piece in self._pieces:
            piece.see(view)
        pixels = [piece.pixels for piece in self._pieces if piece.pixels is not None]
        depths = [piece.depth for piece in self._pieces if piece.depth is not None]
        return _joined(pixels), _joined(depths) if depths else None

    @property
    def gaps(self) -> BoolArray | None:
        """Whether what is between two points crosses an edge of the domain (K−1, N); None without one."""
        if self._domain is None:
            return None
        return ~straight(self._domain, np.diff(_joined([piece.points for piece in self._pieces]), axis=0))


def _joined(pieces: list[np.ndarray]) -> np.ndarray:
    """Pieces of curves in one, from the end of the first one."""
    return np.concatenate([pieces[0][-1:], *islice(pieces, 1, None)])

"""Paths of particles over the last frames, and their projection."""

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
    """The paths between two frames, and their pixels in the latest view."""

    points: FloatArray
    """Points, shape (K, N, D) [m]."""
    view: View | None = None
    pixels: PixelArray | None = None
    """Pixels, shape (K, N, 2)."""
    depth: PixelArray | None = None
    """Depths, shape (K, N) [m]; None in 2D."""

    def see(self, view: View) -> None:
        """Project the piece, unless this was done for the same view. With a camera at rest, each piece is projected
        once.
        """
        if view is not self.view:
            moments, count, dimension = self.points.shape
            pixels, depth, _ = view.project(self.points.reshape(-1, dimension))
            self.view, self.pixels = view, pixels.reshape(moments, count, 2)
            self.depth = None if depth is None else depth.reshape(moments, count)


class Past:
    """The paths of N particles over the last frames, updated frame by frame.

    Args:
        interval: the usual time between two frames [s].
        frames: number of frames kept, including the present one; None: all.
        domain: the periodic domain, if any; paths in a domain are straight between frames.
    """

    def __init__(self, interval: float, frames: int | None, domain: Periodic | None = None) -> None:
        self._pieces: deque[_Piece] = deque(maxlen=frames)
        self._curve, self._domain = Curve(interval, smooth=domain is None), domain

    @property
    def frames(self) -> int | None:
        """The number of frames kept; None: all."""
        return self._pieces.maxlen

    def begin(self) -> None:
        """Forget all frames."""
        self._pieces.clear()
        self._curve.begin()

    def add(self, time: float, points: FloatArray, velocities: FloatArray | None) -> None:
        """Add a frame at a time [s]: positions (N, D) [m], and velocities [m/s] if they were recorded."""
        self._pieces.append(_Piece(self._curve.piece(time, points, velocities)))

    def seen(self, view: View) -> tuple[PixelArray, PixelArray | None]:
        """Pixels (K, N, 2) and depths (K, N) (None in 2D), from the end of the oldest piece on."""
        for piece in self._pieces:
            piece.see(view)
        pixels = [piece.pixels for piece in self._pieces if piece.pixels is not None]
        depths = [piece.depth for piece in self._pieces if piece.depth is not None]
        return _joined(pixels), _joined(depths) if depths else None

    @property
    def gaps(self) -> BoolArray | None:
        """Mask (K−1, N) of the segments that cross a face of the periodic domain; None without a domain."""
        if self._domain is None:
            return None
        return ~straight(self._domain, np.diff(_joined([piece.points for piece in self._pieces]), axis=0))


def _joined(pieces: list[np.ndarray]) -> np.ndarray:
    """Concatenate pieces of paths, from the end of the first one."""
    return np.concatenate([pieces[0][-1:], *islice(pieces, 1, None)])

"""The mouse in a picture: what is under it, and where it is in the scene."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.panel.artist import Picture, places_of
from physcore.scene.bodies import Body

REACH = 0.06
"""Largest distance of a pointer from what it takes hold of, as a fraction of the picture's longer side."""


def picked(picture: Picture, x: float, y: float) -> tuple[Body, int] | None:
    """The element that can move and is seen nearest to a pixel; None if none is near.

    Args:
        picture: the picture.
        x, y: the pixel, from the upper left corner.
    """
    scene = picture.state.scene
    assert scene is not None  # It is the state of a whole scene.
    places = places_of(picture.state)
    if not len(places):
        return None
    pixels, _, _ = picture.view.project(places)
    offsets = pixels.astype(np.float64) - (x, y)
    squares = (offsets * offsets).sum(axis=1)
    squares[np.concatenate([body.fixed for body in scene.bodies])] = np.inf
    row, reach = int(squares.argmin()), REACH * max(picture.pixels.shape)
    if not squares[row] <= reach * reach:
        return None
    body = next(body for body in scene.bodies if row < scene.place(body).stop)
    return body, row - scene.place(body).start


def moved(view: View, pointer: tuple[float, ...], x: float, y: float) -> FloatArray:
    """The point under a pixel [m], as far from the eye as the pointer was."""
    pixels, _, magnification = view.project(np.array([pointer]))
    across, down = (np.array([x, y]) - pixels[0]) / float(magnification[0])
    point: FloatArray = np.array(pointer) + across * view.axes[0] - down * view.axes[1]
    return point

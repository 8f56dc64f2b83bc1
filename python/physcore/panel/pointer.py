"""The mouse in a picture: what is under it, where it is in the scene, and how it turns what it holds."""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from physcore.arithmetic import lengths
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.shapes import planar, spatial
from physcore.panel.artist import Picture, places_of
from physcore.scene.bodies import Body
from physcore.scene.rigid import RigidBodies

REACH = 0.06
"""Largest distance of a pointer from what it takes hold of, as a fraction of the picture's longer side."""


def picked(picture: Picture, x: float, y: float) -> tuple[Body, int] | None:
    """The element that can move and is seen nearest to a pixel, under it if there is one; None if none is near.

    Args:
        picture: the picture.
        x, y: the pixel, from the upper left corner.
    """
    scene = picture.state.scene
    assert scene is not None  # It is the state of a whole scene.
    places = places_of(picture.state)
    if not len(places):
        return None
    pixels, _, magnification = picture.view.project(places)
    distances = lengths(pixels.astype(np.float64) - (x, y))
    sizes = np.concatenate([_radii(body) for body in scene.bodies]) * magnification
    beyond = np.maximum(distances - sizes, 0.0)
    beyond[np.concatenate([body.fixed for body in scene.bodies])] = np.inf
    row = int(np.lexsort([distances, beyond])[0])
    if not beyond[row] <= REACH * max(picture.pixels.shape):
        return None
    body = next(body for body in scene.bodies if row < scene.place(body).stop)
    return body, row - scene.place(body).start


def _radii(body: Body) -> FloatArray:
    """Radius of each element, or of a circle or a sphere around a rigid body [m]."""
    if not body.is_rigid:
        return body.radius
    shape = cast("RigidBodies", body).shape
    reach = planar.reach_of(planar.cores_of(shape)) if body.dimension == 2 else spatial.reach_of(spatial.core_of(shape))
    return np.full(len(body), reach)


def moved(view: View, pointer: tuple[float, ...], x: float, y: float) -> FloatArray:
    """The point under a pixel [m], as far from the eye as the pointer was."""
    pixels, _, magnification = view.project(np.array([pointer]))
    across, down = (np.array([x, y]) - pixels[0]) / float(magnification[0])
    point: FloatArray = np.array(pointer) + across * view.axes[0] - down * view.axes[1]
    return point


def rolled(picture: Picture, across: float, down: float) -> FloatArray:
    """Rotation by a mouse that has moved by some pixels [rad]: an angle in 2D, a rotation vector in 3D.

    What is held rolls along with the mouse, half a turn for the length of the picture's shorter side: in 3D as a ball
    under it, in 2D as a wheel on the ground.
    """
    right, below = (math.pi / min(picture.pixels.shape[:2]) * way for way in (across, down))
    axes = picture.view.axes
    rotation: FloatArray = np.array([-right]) if picture.view.flat else right * axes[1] + below * axes[0]
    return rotation

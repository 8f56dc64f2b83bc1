"""The lamp that lights surfaces."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray
from physcore.film.camera.view import View

LAMP = np.array([-0.408, 0.577, 0.707])
"""Direction to the lamp: left, up, toward the eye; where that of balls stands too."""
AMBIENT = 0.38
"""How much of its light a surface has that is turned away from the lamp."""


def lambert(normals: FloatArray, view: View) -> FloatArray:
    """The light of surfaces with unit normals (N, 3) in a scene: Lambert's cosine."""
    light: FloatArray = AMBIENT + (1.0 - AMBIENT) * np.maximum(normals @ view.axes.T @ LAMP, 0.0)
    return light

"""Lighting of surfaces in 3D, the same as the lighting of balls by the canvas."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray

LAMP = (-0.42, 0.62, 0.66)
"""Direction to the lamp: left, up, toward the camera. The canvas has the same values for balls."""
WRAP = 0.2
"""Extent of the lamp's light beyond the terminator (wrap lighting), as of a lamp of finite size."""
FILL, SKY, KEY = 0.3, 0.16, 0.72
"""Intensities of the ambient light, of the sky and of the lamp."""
RIM = 0.3
"""Intensity of the light at rims, from a lamp behind the scene."""
SHADOW, OCCLUSION = 0.5, 0.75
"""Fractions of the light removed by a shadow, and by complete ambient occlusion."""
REACH = 0.05
"""Radius of the search for ambient occlusion, as a fraction of a picture's shorter side."""


def lit(colors: FloatArray, normals: FloatArray) -> FloatArray:
    """Shade colors (N, 3) of surfaces by their unit normals (N, 3): right, up and toward the camera."""
    up = 0.5 + 0.5 * normals[:, 1]
    light = FILL + SKY * up + KEY * np.maximum((normals @ np.array(LAMP) + WRAP) / (1.0 + WRAP), 0.0)
    rim = (RIM * up * (1.0 - np.clip(normals[:, 2], 0.0, 1.0)) ** 2)[:, np.newaxis]
    result: FloatArray = np.clip((colors + (255.0 - colors) * rim) * light[:, np.newaxis], 0.0, 255.0)
    return result

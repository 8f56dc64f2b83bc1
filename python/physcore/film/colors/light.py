"""The light of surfaces in space, the same as that of balls, which the canvas lights."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray

LAMP = (-0.42, 0.62, 0.66)
"""Direction to the lamp: left, up, toward the eye; where that of balls stands too."""
WRAP = 0.2
"""How far its light reaches around, as that of a lamp that is not a point."""
FILL, SKY, KEY = 0.3, 0.16, 0.72
"""Light from everywhere, from the sky and from the lamp."""
RIM = 0.3
"""Light at rims, of a lamp behind."""
SHADOW, OCCLUSION = 0.5, 0.75
"""The shares of light that a shadow takes, and surroundings that hide everything."""
REACH = 0.05
"""How far ambient light is looked for, as a fraction of a picture's shorter side."""


def lit(colors: FloatArray, normals: FloatArray) -> FloatArray:
    """Colors (N, 3) of surfaces in the light, by their unit normals (N, 3) to the right, up and toward the eye."""
    up = 0.5 + 0.5 * normals[:, 1]
    light = FILL + SKY * up + KEY * np.maximum((normals @ np.array(LAMP) + WRAP) / (1.0 + WRAP), 0.0)
    rim = (RIM * up * (1.0 - np.clip(normals[:, 2], 0.0, 1.0)) ** 2)[:, np.newaxis]
    result: FloatArray = np.clip((colors + (255.0 - colors) * rim) * light[:, np.newaxis], 0.0, 255.0)
    return result

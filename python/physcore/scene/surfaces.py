"""Checks of the faces of a network."""

from __future__ import annotations

import numpy as np

from physcore.arithmetic import dots, lengths
from physcore.errors import SceneError
from physcore.scene.bodies import SpringNetwork

LEAST_AREA = 1e-12
"""Least area of a face, doubled and relative to the square of its longest side; above rounding errors."""


def check_areas(network: SpringNetwork, path: str) -> None:
    """Check that every face has an area in `positions`."""
    corners = network.positions[network.faces]
    sides = np.roll(corners, -1, axis=1) - corners
    with np.errstate(over="ignore", invalid="ignore"):
        longest = dots(sides, sides).max(axis=1)
        area = lengths(np.cross(sides[:, 0], sides[:, 1]))
        flat = ~(area > LEAST_AREA * longest)
    if flat.any():
        row = int(np.argmax(flat))
        raise SceneError(
            f"{path}: must have faces with an area, and the corners of faces[{row}], "
            f"the particles {network.faces[row].tolist()}, are on a line"
        )

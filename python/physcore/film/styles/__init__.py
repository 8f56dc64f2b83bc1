"""How bodies look, one file each."""

from __future__ import annotations

from physcore.film.styles.base import Painter, Style
from physcore.film.styles.fluid import Fluid
from physcore.film.styles.points import Points
from physcore.film.styles.strain import Strain

STYLES: tuple[type[Style], ...] = (
    Points,
    Strain,
    Fluid,
)
"""Every style; what is registered here is tested."""

__all__ = ["STYLES", "Fluid", "Painter", "Points", "Strain", "Style"]

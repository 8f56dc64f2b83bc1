"""Drawing styles of bodies and systems, one module each. Overlays add to bodies that another style draws.

    pc.film(recording, "cloth.png", style=pc.styles.Surface(color="strain"))

`film` takes one or several of them as `style=`.
"""

from __future__ import annotations

from physcore.entrance import entrances
from physcore.film.styles.arrows import Arrows
from physcore.film.styles.base import BodyStyle, Painter, Style, SystemStyle
from physcore.film.styles.density import Density
from physcore.film.styles.equipotentials import Equipotentials
from physcore.film.styles.field_lines import FieldLines
from physcore.film.styles.fluid import Fluid
from physcore.film.styles.grid_field import Field
from physcore.film.styles.line import Line
from physcore.film.styles.paths import Paths
from physcore.film.styles.phase import Phase
from physcore.film.styles.points import Points
from physcore.film.styles.relief import Relief
from physcore.film.styles.solids import Solids
from physcore.film.styles.strain import Strain
from physcore.film.styles.streamlines import Streamlines
from physcore.film.styles.surface import Surface
from physcore.film.styles.trails import Trails
from physcore.film.styles.tube import Tube

STYLES: tuple[type[Style], ...] = (
    Solids,
    Points,
    Strain,
    Tube,
    Surface,
    Fluid,
    Paths,
    Arrows,
    Streamlines,
    FieldLines,
    Equipotentials,
    Field,
    Phase,
    Relief,
    Line,
    Trails,
    Density,
)
"""All styles. Those registered here are tested."""

entrances(STYLES)

__all__ = [
    "STYLES",
    "Arrows",
    "BodyStyle",
    "Density",
    "Equipotentials",
    "Field",
    "FieldLines",
    "Fluid",
    "Line",
    "Painter",
    "Paths",
    "Phase",
    "Points",
    "Relief",
    "Solids",
    "Strain",
    "Streamlines",
    "Style",
    "Surface",
    "SystemStyle",
    "Trails",
    "Tube",
]


def __dir__() -> list[str]:
    return list(__all__)

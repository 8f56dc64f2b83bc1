"""Assignment of bodies and systems to painters, by the requested styles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from physcore import checks
from physcore.errors import SceneError
from physcore.film.colors.themes import Theme
from physcore.film.raised import Raised
from physcore.film.styles import (
    Density,
    Field,
    Fluid,
    Line,
    Painter,
    Phase,
    Points,
    Relief,
    Solids,
    Strain,
    Style,
    Surface,
    Trails,
)
from physcore.film.styles.base import BodyStyle
from physcore.scene.bodies import Body
from physcore.scene.system import System
from physcore.simulation.sources import Source


def asked(style: object, found: Sequence[Source]) -> list[Style]:
    """The requested styles; raise a SceneError if an item named by one of them is in no source."""
    if style is None:
        fluids = all(source.has("velocities") for source in found)
        plain: list[Style] = [Surface(color="strain"), Strain()]
        return [*plain, Fluid()] if fluids else plain
    styles = []
    every = [item for source in found for item in _items(source)]
    for given in style if isinstance(style, (list, tuple)) else [style]:
        if not isinstance(given, Style):
            missing = f"; write {given.__name__}()" if isinstance(given, type) else ""
            raise SceneError(f"style: must be one or a list of physcore.styles, got {checks.shown(given)}{missing}")
        each = given.among(every)
        for item in each.items() or ():
            if not any(item is known for known in every):
                raise SceneError(
                    f"{type(each).__name__}.on: {item!r} is not in what is filmed; "
                    "the bodies and systems of a loaded recording are new ones: recording.scene"
                )
        styles.append(each)
    return styles


def shown(source: Source, styles: Sequence[Style]) -> Source:
    """A source as it is drawn: in 3D if one of the styles draws plane objects as a relief."""
    raises = any(each.raises and any(each.draws(item) for item in _items(source)) for each in styles)
    if raises and source.scene.has_rigid_bodies:
        raise SceneError("style: a Relief shows a scene of 2D in 3D, where its rigid bodies have no shape; use Field()")
    return Raised(source) if raises else source


def painters(source: Source, styles: list[Style], theme: Theme) -> list[Painter]:
    """The painters of a source.

    The first style that can draw an item gets it. An item without such a style is drawn as solids, points, a phase, a
    field, a line, trails of few tracers or a density of many. Overlays are drawn in addition. Systems come first, then
    rigid bodies, so that bodies are drawn over fields on grids, and particles over rigid bodies.
    """
    left = list(_items(source))
    found: list[tuple[int, list[Painter]]] = []
    field = Relief() if isinstance(source, Raised) else Field()
    for each in (*styles, Solids(), Points(), Phase(), field, Line(), Density(), Trails()):
        mine = [item for item in (_items(source) if each.overlay else left) if each.draws(item)]
        if not each.overlay:
            left = [item for item in left if not any(item is other for other in mine)]
        if mine:
            found.append((_layer(each), each.painters(source, mine, theme)))
    found.sort(key=lambda entry: entry[0])
    result = [painter for _, some in found for painter in some]
    for painter in result:
        painter.meet(result)
    return result


def _layer(style: Style) -> int:
    """The place of a style in the order of drawing: systems, rigid bodies, particles."""
    return 2 - int(style.rigid) if isinstance(style, BodyStyle) else 0


def _items(source: Source) -> Iterator[Body | System]:
    """The bodies and systems of a source."""
    yield from source.scene.bodies
    yield from source.scene.systems


def share_scales(painters: list[list[Painter]]) -> None:
    """Give painters of equal styles in all panels a common color scale."""
    for each in (painter for panel in painters for painter in panel):
        alike = [
            other
            for panel in painters
            for other in panel
            if (type(other), other.style, other.quantity) == (type(each), each.style, each.quantity)
        ]
        each.low, each.top = min(other.low for other in alike), max(other.top for other in alike)

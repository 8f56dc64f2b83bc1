"""The assignment of bodies to painters, by the styles that were asked for."""

from __future__ import annotations

from collections.abc import Sequence

from physcore.checks import shown
from physcore.errors import SceneError
from physcore.film.colors.themes import Theme
from physcore.film.styles import Fluid, Painter, Points, Strain, Style
from physcore.film.styles.base import Part
from physcore.simulation.sources import Source


def asked(style: object, found: Sequence[Source]) -> list[Style]:
    """The styles that were asked for; each body that they name is in a source."""
    if style is None:
        fluids = all(source.has("velocities") for source in found)
        return [Strain(), Fluid()] if fluids else [Strain()]
    styles = []
    bodies = [body for source in found for body in source.scene.bodies]
    for each in style if isinstance(style, (list, tuple)) else [style]:
        if not isinstance(each, Style):
            missing = f"; write {each.__name__}()" if isinstance(each, type) else ""
            raise SceneError(f"style: must be one or a list of physcore.styles, got {shown(each)}{missing}")
        for body in each.bodies() or ():
            if body not in bodies:
                raise SceneError(
                    f"{type(each).__name__}.on: {body!r} is not in what is filmed; "
                    "the bodies of a loaded recording are new ones: recording.scene.bodies"
                )
        styles.append(each)
    return styles


def painters(source: Source, styles: list[Style], theme: Theme) -> list[Painter]:
    """The painters of a source: a body goes to the first style that draws it, or else to points; overlays add."""
    parts = [Part(body, source.scene.slice(body)) for body in source.scene.bodies]
    left = list(parts)
    found = []
    for each in (*styles, Points()):
        mine = [part for part in (parts if each.overlay else left) if each.draws(part.body)]
        if not each.overlay:
            left = [part for part in left if part not in mine]
        if mine:
            found.append(each.painter(source, mine, theme))
    return found


def share_scales(painters: list[list[Painter]]) -> None:
    """Let painters of equal styles, in all panels, agree on what a color means."""
    for each in (painter for panel in painters for painter in panel):
        each.top = max(
            other.top
            for panel in painters
            for other in panel
            if type(other) is type(each) and other.style == each.style
        )

"""Rigid bodies as solids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, cast

import numpy as np

from physcore._core import Canvas, norms
from physcore.checks import FloatArray, flag, is_word
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import ColormapName, look_up, sequential, varied
from physcore.film.colors.themes import Color, Theme
from physcore.film.styles.base import BodyStyle, Painter, Part, Scale
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.joints import JointMarks
from physcore.film.styles.solids_planar import PlanarSolids
from physcore.film.styles.solids_spatial import SpatialSolids
from physcore.film.styles.typical import Typical
from physcore.scene.bodies import Body
from physcore.scene.items import System
from physcore.scene.rigid import RigidBodies
from physcore.simulation.sources import Source, SourceFrame

WORDS = ("body", "speed", "index")
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Fractional parts of its multiples are evenly spread, and those of neighbors are apart."""


@dataclass(frozen=True)
class Solids(BodyStyle):
    """Rigid bodies as filled shapes with a rim in 2D, as lit solids in 3D.

        pc.film(recording, "dice.gif", style=pc.styles.Solids("speed"))
        pc.film(recording, "dice.gif", style=pc.styles.Solids({"dice": "ivory"}, marks=False))

    Bodies of one item have its color, in shades by which neighbors can be told apart. Fixed bodies have the color of
    boundaries.

    Args:
        color: "body": a color for each item; "speed": the speed of the centers of mass [m/s], on a scale that begins at
            zero; "index": the index among the bodies that are drawn. Or chosen colors, as in Points.
        colormap: the map of the color scale, as in Points.
        marks: whether a pattern is painted on the bodies, by which their rotation is seen.
        joints: whether joints are drawn: pins for a Hinge and a BallJoint, a bar for a Rod, a zigzag for a SpringJoint,
            a rail for a Prismatic joint. Joints that are broken vanish.
        forces: whether the forces of joints are shown by arrows, on the first body of each joint; or the force of the
            longest arrow [N], above zero.
        top: the speed at the end of the color scale [m/s], above zero; None: a typical value of the film.
        on: as in Style; each body must be rigid bodies.

    Raises:
        SceneError: a value is not valid, or the fields of rigid bodies were not recorded.
    """

    rigid: ClassVar[bool] = True

    color: Literal["body", "speed", "index"] | ColorChoice | PerBody | PerParticle = "body"
    colormap: ColormapName = "viridis"
    marks: bool = True
    joints: bool = True
    forces: bool | float = False
    top: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(color=checked(self.color, "Solids.color", WORDS), marks=flag(self.marks, "Solids.marks"))
        self._set(joints=flag(self.joints, "Solids.joints"))
        if not isinstance(self.forces, (bool, np.bool_)):
            self._set_positive("forces")
        sequential(self.colormap, (0.0, 1.0), "Solids.colormap")
        self._set_positive("top")

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        turns = "angles" if source.scene.dimension == 2 else "orientations"
        needed = ["rigid_positions", turns, *(["rigid_velocities"] if is_word(self.color, "speed") else [])]
        missing = next((name for name in needed if not source.has(name)), None)
        if missing is not None:
            raise SceneError(f"Solids: needs the {missing.replace('_', ' ')} of rigid bodies, which were not recorded")
        return SolidsPainter(self, source, parts, theme)


class SolidsPainter(Painter):
    """Painter of rigid bodies."""

    def __init__(self, style: Solids, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._theme, self.parts = style, style, theme, parts
        kind = PlanarSolids if source.scene.dimension == 2 else SpatialSolids
        self._turns = "angles" if source.scene.dimension == 2 else "orientations"
        self._solids = [kind(cast("RigidBodies", part.body).shape, theme, marks=style.marks) for part in parts]
        self._joints = JointMarks(source, parts if style.joints else (), theme, style.forces)
        counts = [len(part.body) for part in parts]
        self._ends = np.cumsum([0, *counts]).tolist()
        self._table = sequential(style.colormap, theme.part, "Solids.colormap")
        self._coloring: Coloring | None = None
        if is_word(style.color, "index"):
            self._shades = look_up(self._table, (np.arange(sum(counts)) + 0.5) / max(sum(counts), 1))
        elif not is_word(style.color, "speed"):
            chosen = cast("Chosen | str", style.color)
            self._coloring = Coloring(chosen, self._table, "Solids.color", source, parts, theme)
            self.fixed = self._coloring.fixed
            if self.fixed is not None:
                self._shades = self._own(source, counts)
        self.low, self.top = 0.0, style.top or 0.0
        if self._coloring is not None:
            self.low, self.top = self._coloring.low, self._coloring.top
        self._typical = Typical()

    def _own(self, source: Source, counts: Sequence[int]) -> FloatArray:
        """The constant colors of all bodies (N, 3): shades of the color of an item, and that of boundaries."""
        assert self.fixed is not None
        index = np.concatenate([np.arange(count) for count in counts]) if counts else np.empty(0)
        shade = 2.0 * ((0.5 + GOLDEN * index) % 1.0) - 1.0
        plain = is_word(self._style.color, "body")
        colors = varied(self.fixed, shade) if plain or not isinstance(self._style.color, PerParticle) else self.fixed
        if plain:
            held = np.concatenate([part.body.fixed for part in self.parts]) if counts else np.empty(0, dtype=bool)
            flat = source.scene.dimension == 2
            colors[held] = self._theme.surface if flat else self._theme.solid
        return colors

    @property
    def legend(self) -> list[tuple[Body | System, Color]]:
        """The items that are drawn in shades of one color, each with this color."""
        return super().legend

    @property
    def settled(self) -> bool:
        """Whether the ends of all scales are known, or there is none."""
        if not self._joints.settled:
            return False
        if self._coloring is not None:
            return self._coloring.settled
        return self._style.top is not None or not is_word(self._style.color, "speed")

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        if self._coloring is not None:
            return self._coloring.scale(self.low, self.top)
        speed = is_word(self._style.color, "speed")
        return Scale("speed", "m/s", (0.0, self.top), self._table) if speed else None

    def observe(self, frame: SourceFrame) -> None:
        """Update the ends of the color scale by a frame."""
        self._joints.observe(frame)
        if self._coloring is None:
            if not is_word(self._style.color, "speed") or self._style.top is not None:
                return
            self.top = self._typical.add(self._speeds(frame))
        else:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._coloring.top

    def inset(self, pixels: float) -> float:
        """Half the width of a rim."""
        del pixels
        return 1.5

    def places(self, frame: SourceFrame) -> FloatArray | None:
        """The corners of all bodies, points around round ones, and the anchors of joints."""
        found = [
            solids.extremes(self._at("rigid_positions", frame, part), self._at(self._turns, frame, part))
            for part, solids in zip(self.parts, self._solids, strict=True)
        ]
        return np.concatenate([*found, self._joints.places(frame)]) if found else None

    def spread(self, part: Part, frame: SourceFrame) -> tuple[FloatArray, FloatArray]:
        """The positions of the bodies, with the reach of their shape."""
        reach = next(solids.reach for solids, own in zip(self._solids, self.parts, strict=True) if own is part)
        return self._at("rigid_positions", frame, part), np.full(len(part.body), reach)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the bodies and their joints."""
        colors = self._colors(frame)
        self._joints.paint_behind(canvas, frame, view, pixels)
        for index, (part, solids) in enumerate(zip(self.parts, self._solids, strict=True)):
            own = colors[self._ends[index] : self._ends[index + 1]]
            positions, turns = self._at("rigid_positions", frame, part), self._at(self._turns, frame, part)
            whole = np.isfinite(positions).all(axis=1)
            if whole.any():
                solids.paint(canvas, view, positions[whole], turns[whole], own[whole])
        self._joints.paint(canvas, frame, view, pixels)

    def _colors(self, frame: SourceFrame) -> FloatArray:
        """The colors of all bodies (N, 3)."""
        if is_word(self._style.color, "speed"):
            return look_up(self._table, self._speeds(frame) / (self.top or 1.0))
        if self._coloring is None or self.fixed is not None:
            return self._shades
        return self._coloring.colors(frame, self.low, self.top)

    def _speeds(self, frame: SourceFrame) -> FloatArray:
        """The speeds of all bodies (N,) [m/s]."""
        return norms(np.concatenate([self._at("rigid_velocities", frame, part) for part in self.parts]))

    @staticmethod
    def _at(name: str, frame: SourceFrame, part: Part) -> FloatArray:
        """The values of a field for the bodies of an item."""
        values: FloatArray = frame.fields[name][part.where]
        return values

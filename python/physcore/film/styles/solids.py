"""Rigid bodies as solids."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, cast

import numpy as np

from physcore._core import Canvas, norms
from physcore.checks import BoolArray, FloatArray, IntArray, flag, is_word
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, look_up, ramp, varied
from physcore.film.colors.themes import Theme
from physcore.film.page.tape import Tape
from physcore.film.styles.base import BodyStyle, Painter, Part, Scale
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.joints import JointMarks, pin_radius
from physcore.film.styles.solids_planar import PlanarSolids
from physcore.film.styles.solids_spatial import SpatialSolids
from physcore.film.styles.typical import Typical
from physcore.scene.periodic import Periodic
from physcore.scene.rigid import RigidBodies
from physcore.scene.solids import Shape
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
        colormap: the map of the color scale, as in Points; None: a part of "viridis".
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
    colormap: ColormapName | None = None
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
        ramp(self.colormap, "viridis", WHOLE, "Solids.colormap")
        self._set_positive("top")

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        turns = "angles" if source.scene.dimension == 2 else "orientations"
        needed = ["rigid_positions", turns, *(["rigid_velocities"] if is_word(self.color, "speed") else [])]
        missing = next((name for name in needed if not source.has(name)), None)
        if missing is not None:
            raise SceneError(f"Solids: needs the {missing.replace('_', ' ')} of rigid bodies, which were not recorded")
        return SolidsPainter(self, source, parts, theme)


@dataclass(frozen=True, eq=False)
class Group:
    """All bodies of one shape, which are drawn at once."""

    solids: PlanarSolids | SpatialSolids
    index: IntArray
    """Indices among the bodies that the painter draws, shape (M,)."""


class SolidsPainter(Painter):
    """Painter of rigid bodies."""

    def __init__(self, style: Solids, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._theme, self.parts = style, style, theme, parts
        self._flat = source.scene.dimension == 2
        self._turns = "angles" if self._flat else "orientations"
        bodies = [cast("RigidBodies", part.body) for part in parts]
        self._joints = JointMarks(source, parts if style.joints else (), theme, style.forces)
        self._rows = np.concatenate([np.arange(part.where.start, part.where.stop) for part in parts])
        self._moving = np.concatenate([_moving(body) for body in bodies])
        self._groups, self._own = self._grouped(bodies)
        self._table = ramp(style.colormap, "viridis", theme.part, "Solids.colormap")
        self._coloring: Coloring | None = None
        self._plain = np.zeros(len(self._rows), dtype=np.bool_)
        if is_word(style.color, "index"):
            self._shades = look_up(self._table, (np.arange(len(self._rows)) + 0.5) / max(len(self._rows), 1))
        elif not is_word(style.color, "speed"):
            self._coloring = Coloring(
                cast("Chosen | str", style.color), self._table, "Solids.color", source, parts, theme
            )
            if self._coloring.fixed is not None:
                self._choose(self._coloring.fixed.copy(), bodies)
        self.low, self.top = 0.0, style.top or 0.0
        if self._coloring is not None:
            self.low, self.top = self._coloring.low, self._coloring.top
        self._typical = Typical()

    def _grouped(self, bodies: Sequence[RigidBodies]) -> tuple[list[Group], list[PlanarSolids | SpatialSolids]]:
        """The bodies by shape, and the solids of each item."""
        solids: dict[Shape, PlanarSolids | SpatialSolids] = {}
        members: dict[Shape, list[IntArray]] = {}
        first = 0
        for body in bodies:
            kind = PlanarSolids if self._flat else SpatialSolids
            if body.shape not in solids:
                solids[body.shape] = kind(body.shape, self._theme, marks=self._style.marks)
            members.setdefault(body.shape, []).append(np.arange(first, first + len(body)))
            first += len(body)
        groups = [Group(each, np.concatenate(members[shape])) for shape, each in solids.items()]
        return groups, [solids[body.shape] for body in bodies]

    def _choose(self, colors: FloatArray, bodies: Sequence[RigidBodies]) -> None:
        """Set the constant colors: shades of that of an item; those of boundaries for fixed bodies without a choice."""
        choice = self._style.color
        if is_word(choice, "body") or isinstance(choice, PerBody):
            chosen = [isinstance(choice, PerBody) and choice.of(body) is not None for body in bodies]
            fixed = [body.fixed & ~own for body, own in zip(bodies, chosen, strict=True)]
            self._plain = np.concatenate(fixed).astype(np.bool_)
        self.fixed = colors.copy()
        self.fixed[self._plain] = self._theme.edge if self._flat else self._theme.solid  # visible in a legend
        colors[self._plain] = self._theme.surface if self._flat else self._theme.solid
        shade = 2.0 * ((0.5 + GOLDEN * np.concatenate([np.arange(len(body)) for body in bodies])) % 1.0) - 1.0
        if not isinstance(choice, PerParticle):
            colors = np.where(self._plain[:, np.newaxis], colors, varied(colors, shade))
        self._shades = colors

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
        """Update the joints and the ends of the color scale by a frame."""
        self._joints.observe(frame)
        if self._coloring is not None:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._coloring.top
        elif is_word(self._style.color, "speed") and self._style.top is None:
            self.top = self._typical.add(self._speeds(frame))

    def inset(self, pixels: float) -> float:
        """Half the width of a rim, or the radius of a pin."""
        return 1.5 if len(self._joints) == 0 else 1.5 + pin_radius(pixels)

    def places(self, frame: SourceFrame) -> FloatArray | None:
        """The corners of all moving bodies, points around round ones, and the anchors of joints."""
        positions, turns = self._at("rigid_positions", frame), self._at(self._turns, frame)
        found = [self._joints.places(frame)]
        for group in self._groups:
            moving = group.index[self._moving[group.index]]
            found.append(group.solids.extremes(positions[moving], turns[moving]))
        return np.concatenate(found)

    @property
    def scenery(self) -> list[tuple[FloatArray, float]]:
        """The corners of bodies at rest."""
        found = []
        for part, solids in zip(self.parts, self._own, strict=True):
            body = cast("RigidBodies", part.body)
            held, turns = ~_moving(body), body.angles if body.angles is not None else body.orientations
            if held.any() and turns is not None:
                found.append((solids.extremes(body.positions[held], turns[held]), 0.0))
        return found

    @property
    def reach(self) -> float:
        """The largest distance of a point of a moving body from its center [m]."""
        reaches = (group.solids.reach for group in self._groups if self._moving[group.index].any())
        return max(reaches, default=0.0)

    def spread(self, part: Part, frame: SourceFrame) -> tuple[FloatArray, FloatArray]:
        """The positions of the bodies, with the reach of their shape."""
        reach = next(each.reach for each, own in zip(self._own, self.parts, strict=True) if own is part)
        return frame.fields["rigid_positions"][part.where], np.full(len(part.body), reach)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the bodies and their joints."""
        self._joints.paint_behind(canvas, frame, view, pixels)
        for solids, places, turns, colors, plain in self._placed(frame):
            solids.paint(canvas, view, places, turns, colors, plain=plain)
        self._joints.paint(canvas, frame, view, pixels)

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the bodies and their joints on a tape."""
        canvas = cast("Canvas", tape)
        self._joints.paint_behind(canvas, frame, view, pixels)
        for solids, places, turns, colors, plain in self._placed(frame):
            solids.record(tape, view, places, turns, colors, plain=plain)
        self._joints.paint(canvas, frame, view, pixels)

    def _placed(
        self, frame: SourceFrame
    ) -> Iterator[tuple[PlanarSolids | SpatialSolids, FloatArray, FloatArray, FloatArray, bool]]:
        """The bodies of each shape: places, turns, colors, and whether they look like boundaries, which come first."""
        colors, positions, turns = self._colors(frame), self._at("rigid_positions", frame), self._at(self._turns, frame)
        seen = np.asarray(np.isfinite(positions).all(axis=1))
        for plain in (True, False):
            for group in self._groups:
                index = group.index[seen[group.index] & (self._plain[group.index] == plain)]
                places = positions[index]
                if self.domain is not None:  # bodies across a face of the domain are seen on both sides
                    places, origins = images(self.domain, places, group.solids.reach)
                    index = index[origins]
                if len(index):
                    yield group.solids, places, turns[index], colors[index], plain

    def _colors(self, frame: SourceFrame) -> FloatArray:
        """The colors of all bodies (N, 3)."""
        if is_word(self._style.color, "speed"):
            return look_up(self._table, self._speeds(frame) / (self.top or 1.0))
        if self._coloring is None or self.fixed is not None:
            return self._shades
        return self._coloring.colors(frame, self.low, self.top)

    def _speeds(self, frame: SourceFrame) -> FloatArray:
        """The speeds of all bodies (N,) [m/s]."""
        return norms(self._at("rigid_velocities", frame))

    def _at(self, name: str, frame: SourceFrame) -> FloatArray:
        """The values of a field for all bodies (N, …)."""
        values: FloatArray = frame.fields[name][self._rows]
        return values


def _moving(body: RigidBodies) -> BoolArray:
    """Whether each of some rigid bodies can move (N,)."""
    turning = body.angular_velocities != 0.0
    turning = turning if turning.ndim == 1 else turning.any(axis=1)
    moving: BoolArray = ~body.fixed | (body.velocities != 0.0).any(axis=1) | turning
    return moving


def images(domain: Periodic, positions: FloatArray, reach: float) -> tuple[FloatArray, IntArray]:
    """Points (N, D) followed by the periodic images of those within `reach` of a face, beyond the opposite face [m].

    Returns:
        The points (M, D), and the index of the original of each (M,).
    """
    points, origins = positions, np.arange(len(positions))
    for axis, length in enumerate(domain.lengths.tolist()):
        if math.isfinite(length):
            low, high = points[:, axis] < domain.lower[axis] + reach, points[:, axis] > domain.upper[axis] - reach
            beyond = np.concatenate([points[low], points[high]])
            beyond[:, axis] += np.repeat([length, -length], [low.sum(), high.sum()])
            points, origins = np.concatenate([points, beyond]), np.concatenate([origins, origins[low], origins[high]])
    return points, origins

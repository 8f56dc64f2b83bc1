"""Joints of rigid bodies: pins, axles, bars, springs and rails, with arrows of their forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from physcore._core import Canvas, norms
from physcore.checks import BoolArray, FloatArray
from physcore.constraints import BallJoint, Hinge, Prismatic, Rod, SpringJoint, Weld
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.themes import Color, Theme, mixed
from physcore.film.styles.anchors import Anchors, Axes, End, owner
from physcore.film.styles.arrows import heads
from physcore.film.styles.base import SHADING, InkArray, Part
from physcore.film.styles.strain import divided
from physcore.film.styles.typical import Typical
from physcore.scene.items import Constraint
from physcore.simulation.sources import Source, SourceFrame

Kind: TypeAlias = Literal["axle", "pin", "seam", "rail", "bar", "coil"]
KINDS: dict[type[Constraint], Kind] = {
    Hinge: "axle",
    BallJoint: "pin",
    Weld: "seam",
    Prismatic: "rail",
    Rod: "bar",
    SpringJoint: "coil",
}
"""How each class of joints is drawn. A joint of another class is not drawn."""
FORCES = "joint_forces"
"""The field of the forces of joints."""
PIN = (0.0062, 1.8, 4.5)
"""Radius of a pin relative to the square root of a panel's area; its least and largest value [pixels]."""
COILS = 9
"""Number of turns of a spring."""
LONGEST = 0.15
"""Length of the longest arrow of a force, relative to the square root of a panel's area."""
LEAST = 0.03
"""Arrows shorter than this fraction of the longest are not drawn."""
CLEAR = 199
"""Opacity of arrows, which cast no shadows."""
APART = 5e-3
"""Distance of the anchors of a broken joint, relative to the distance of the bodies from them."""
NEVER = 1e-300
"""Least end of the scale of forces [N]."""


class JointMarks:
    """The joints of the bodies that one painter draws.

    Args:
        source: the source.
        parts: the bodies.
        theme: the colors.
        forces: the force of the longest arrow [N]; True: a typical value of the film; False: no arrows.

    Raises:
        SceneError: arrows are asked for and forces were not recorded.
    """

    def __init__(self, source: Source, parts: Sequence[Part], theme: Theme, forces: float | bool) -> None:
        scene = source.scene
        self._theme, self._flat = theme, scene.dimension == 2
        if forces is not False and not source.has(FORCES):
            raise SceneError("Solids.forces: needs the forces of joints, which were not recorded, or there are none")
        self.arrows, self._given = forces is not False, None if isinstance(forces, bool) else forces
        self.top, self._typical = self._given or NEVER, Typical()
        mine = [
            (joint, KINDS[type(joint)])
            for joint in scene.constraints
            if type(joint) in KINDS and any(part.body is owner(joint) for part in parts)
        ]
        self._joints = [joint for joint, _ in mine]
        self._kinds = np.array([kind for _, kind in mine], dtype=object)
        self._ends = [
            Anchors([End.of(joint, scene, side) for joint in self._joints], scene.dimension) for side in (0, 1)
        ]
        self._axes = Axes(self._joints, self._ends[1])
        self._rows = np.array([scene.parts(joint)["force"][1] for joint in self._joints], dtype=np.int64)
        strength = [getattr(joint, "breaking_force", math.inf) for joint in self._joints]
        self._breakable = np.isfinite(np.array(strength, dtype=float))
        self._recorded = source.has(FORCES)
        self._loaded = np.zeros(len(mine), dtype=np.bool_)
        self._broken_at = np.full(len(mine), np.inf)
        one, other = (end.initial for end in self._ends)
        self._rest = norms(one - other) if len(mine) else np.empty(0)
        self._ways = np.zeros((len(mine), 2))

    def __len__(self) -> int:
        return len(self._joints)

    @property
    def settled(self) -> bool:
        """Whether the end of the scale of forces was given, or there are no arrows, breaks or rails."""
        waits = self._breakable.any() or (self._kinds == "rail").any()
        return not waits and (not self.arrows or self._given is not None)

    def observe(self, frame: SourceFrame) -> None:
        """Note the breaks, the ways along rails and the typical force up to a frame."""
        if not len(self):
            return
        one, other = (end.at(frame) for end in self._ends)
        axes = self._axes.at(frame)
        way = ((one - other) * axes).sum(axis=1)
        self._ways[:, 0], self._ways[:, 1] = np.minimum(self._ways[:, 0], way), np.maximum(self._ways[:, 1], way)
        unloaded = np.zeros(len(self), dtype=np.bool_)
        if self._recorded:
            forces = frame.fields[FORCES][self._rows]
            free = (forces == 0.0).all(axis=1)
            unloaded, self._loaded = self._loaded & free, self._loaded | ~free
            if self.arrows and self._given is None:
                self.top = max(self._typical.add(norms(forces)[self._intact(frame)]), NEVER)
        off = norms(one - other - (self._kinds == "rail")[:, np.newaxis] * way[:, np.newaxis] * axes)
        off = np.where(self._kinds == "bar", np.abs(off - self._rest), np.where(self._kinds == "coil", 0.0, off))
        size = self._ends[0].size + self._ends[1].size
        broken = self._breakable & (unloaded | (off > APART * size))
        self._broken_at = np.where(broken, np.minimum(self._broken_at, frame.time), self._broken_at)

    def places(self, frame: SourceFrame) -> FloatArray:
        """The anchors (P, D) [m]."""
        intact = self._intact(frame)
        return np.concatenate([end.at(frame)[intact] for end in self._ends])

    def paint_behind(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue what is behind the bodies in 2D: rails, and arms from anchors to the centers of bodies."""
        if not len(self):
            return
        theme, radius, intact = self._theme, pin_radius(pixels), self._intact(frame)
        self._paint_rails(canvas, frame, view, radius, intact)
        arm = mixed(theme.edge, theme.background, 0.25)
        for end in self._ends:
            held = intact & end.is_body
            self._lines(canvas, view, end.at(frame)[held], end.centers(frame)[held], arm, 1.1 * radius)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue bars, springs, pins and arrows."""
        if not len(self):
            return
        theme, radius, intact = self._theme, pin_radius(pixels), self._intact(frame)
        one, other = (end.at(frame) for end in self._ends)
        bars, coils = intact & (self._kinds == "bar"), intact & (self._kinds == "coil")
        self._lines(canvas, view, one[bars], other[bars], mixed(theme.edge, theme.text, 0.35), 1.3 * radius)
        self._paint_coils(canvas, view, one[coils], other[coils], radius)
        pins = intact & np.isin(self._kinds, ["axle", "pin"] if self._flat else ["pin"])
        if not self._flat:
            self._paint_axles(canvas, frame, view, radius, intact)
        points = np.concatenate([one[pins], one[bars], other[bars], one[coils], other[coils]])
        sizes = np.concatenate([np.full(pins.sum(), radius), np.full(2 * int(bars.sum() + coils.sum()), 0.75 * radius)])
        self._paint_pins(canvas, view, points, sizes)
        if self.arrows:
            self._paint_arrows(canvas, frame, view, pixels, intact)

    def _intact(self, frame: SourceFrame) -> BoolArray:
        """The joints that are not broken (J,)."""
        intact: BoolArray = frame.time < self._broken_at
        return intact

    def _paint_rails(self, canvas: Canvas, frame: SourceFrame, view: View, radius: float, intact: BoolArray) -> None:
        """Queue the rails of sliders, as far as limits allow, or as far as bodies have moved."""
        rails = np.flatnonzero(intact & (self._kinds == "rail"))
        if not len(rails):
            return
        limits = np.array([[getattr(self._joints[k], name) for name in ("lower", "upper")] for k in rails], dtype=float)
        ends = np.where(np.isnan(limits), self._ways[rails], limits)
        foot, axis = self._ends[1].at(frame)[rails], self._axes.at(frame)[rails]
        low, high = (foot + ends[:, side, np.newaxis] * axis for side in (0, 1))
        self._lines(canvas, view, low, high, self._theme.edge, 1.5 * radius)
        if self._flat:
            self._lines(canvas, view, low, high, self._theme.background, 0.6 * radius)

    def _paint_axles(self, canvas: Canvas, frame: SourceFrame, view: View, radius: float, intact: BoolArray) -> None:
        """Queue the axles of hinges in 3D, which reach through their bodies."""
        axles = intact & (self._kinds == "axle")
        middle, axis = self._ends[0].at(frame)[axles], self._axes.at(frame)[axles]
        half = (self._axes.reach[axles] + radius / view.scale)[:, np.newaxis] * axis
        ends = np.concatenate([middle - half, middle + half])
        self._lines(canvas, view, middle - half, middle + half, self._theme.text, 1.8 * radius)
        self._paint_pins(canvas, view, ends, np.full(len(ends), radius))

    def _paint_coils(self, canvas: Canvas, view: View, one: FloatArray, other: FloatArray, radius: float) -> None:
        """Queue springs as zigzag lines in the plane of the picture."""
        (starts, near, _), (ends, far, _) = view.project(one), view.project(other)
        along = ends - starts
        length = np.maximum(np.sqrt((along**2).sum(axis=1, keepdims=True)), np.float32(1e-6))
        aside = 1.9 * radius * np.stack([along[:, 1], -along[:, 0]], axis=1) / length
        turns = np.arange(2 * COILS)
        marks = np.concatenate([[0.0, 0.1], 0.1 + 0.8 * (turns + 0.5) / len(turns), [0.9, 1.0]])
        swings = np.concatenate([[0.0, 0.0], np.where(turns % 2, -1.0, 1.0), [0.0, 0.0]])
        points = starts[:, np.newaxis] + marks[:, np.newaxis] * along[:, np.newaxis]
        points = (points + swings[:, np.newaxis] * aside[:, np.newaxis]).astype(np.float32)
        lines = np.concatenate([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 4)
        ink = _ink(mixed(self._theme.text, self._theme.edge, 0.25), len(lines))
        depths = None
        if near is not None and far is not None:
            deep = near[:, np.newaxis] + marks * (far - near)[:, np.newaxis]
            depths = np.stack([deep[:, :-1], deep[:, 1:]], axis=2).reshape(-1, 2).astype(np.float32)
        canvas.lines(np.ascontiguousarray(lines), np.full(len(lines), 0.65 * radius, dtype=np.float32), ink, depths)

    def _paint_pins(self, canvas: Canvas, view: View, points: FloatArray, sizes: FloatArray) -> None:
        """Queue pins at points (N, D) with radii (N,) [pixels], each in a ring."""
        centers, depth, magnification = view.project(points)
        radii = (sizes * magnification / max(view.scale, 1e-300)).astype(np.float32)
        inner = _ink(self._theme.text, len(points))
        if depth is None:
            canvas.discs(centers, radii + np.float32(1.1), _ink(self._theme.background, len(points)))
            canvas.discs(centers, radii, inner)
        else:
            canvas.discs(centers, 1.3 * radii, inner, depth - radii / np.float32(view.scale), SHADING)

    def _paint_arrows(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float, intact: BoolArray) -> None:
        """Queue arrows of the forces on the first bodies, above all others in 2D."""
        forces = frame.fields[FORCES][self._rows]
        size = norms(forces) / self.top
        shown = intact & (size > LEAST)
        longest = LONGEST * math.sqrt(pixels)
        forces, size = forces[shown], size[shown]
        way = (
            forces * (np.minimum(size, 1.0) / np.maximum(size * self.top, NEVER) * longest / view.scale)[:, np.newaxis]
        )
        start = self._ends[0].at(frame)[shown]
        (tails, depth, _), (tips, there, _) = view.project(start), view.project(start + way)
        corners = heads(tails, tips, np.float32(0.5 * longest))
        ink = _ink(self._theme.stretched, len(tails))
        ink[:, 3] = CLEAR
        widths = np.full(len(tails), max(0.028 * longest, 1.4), dtype=np.float32)
        if depth is not None and there is not None:  # in front of the bodies that they act on
            near = (2.0 * (self._ends[0].size + self._ends[1].size)[shown]).astype(np.float32)
            depth, there = depth - near, there - near
        both = None if depth is None or there is None else np.stack([depth, there], axis=1)
        canvas.lines(np.concatenate([tails, corners[:, 1:].mean(axis=1)], axis=1), widths, ink, both)
        three = np.tile(ink, 3)
        canvas.triangles(corners.reshape(-1, 6), three, None if there is None else there[:, np.newaxis])

    def _lines(
        self, canvas: Canvas, view: View, one: FloatArray, other: FloatArray, color: Color, width: float
    ) -> None:
        """Queue lines between points (N, D), in 3D in parts that are sorted by their own depths."""
        (starts, near, _), (ends, far, _) = view.project(one), view.project(other)
        lines, ink = np.concatenate([starts, ends], axis=1), _ink(color, len(one))
        widths = np.full(len(one), width, dtype=np.float32)
        if near is None or far is None:
            canvas.lines(lines, widths, ink)
        elif len(lines):
            canvas.lines(*divided(lines, widths, ink, near, far - near, whole=view.turnable))


def pin_radius(pixels: float) -> float:
    """The radius of a pin in a panel of so many pixels [pixels]."""
    share, least, most = PIN
    return min(max(share * math.sqrt(pixels), least), most)


def _ink(color: Color, count: int) -> InkArray:
    """Opaque inks (count, 4) of one color."""
    return np.tile(np.array([*color, 255], dtype=np.uint8), (count, 1))

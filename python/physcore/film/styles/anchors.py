"""Anchors and axes of joints in the frames of a film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from physcore.checks import BoolArray, FloatArray, IntArray
from physcore.constraints.joint import located
from physcore.film.shapes.spatial import core_of
from physcore.scene.items import Constraint
from physcore.scene.rotations import planar_rotations, spatial_rotations
from physcore.scene.scene import Scene
from physcore.scene.targets import whole
from physcore.simulation.sources import SourceFrame


@dataclass(frozen=True, eq=False)
class End:
    """One end of a joint at the start."""

    anchor: FloatArray
    """The anchor [m], shape (D,)."""
    rotation: FloatArray
    """The rotation of the body, shape (D, D)."""
    center: FloatArray
    """The center of the body [m], shape (D,); the anchor without a body."""
    row: int = -1
    """The row in the fields of particles, or of rigid bodies; -1 for the world."""
    is_body: bool = False
    """Whether the end is a rigid body."""
    size: float = 0.0
    """The size of the body [m]."""

    @classmethod
    def of(cls, joint: Constraint, scene: Scene, side: int) -> End:
        """The first or the second end of a joint."""
        given, own = getattr(joint, "anchors", None), getattr(joint, "anchor", None)
        anchor, still = np.array(own if given is None else given[side], dtype=float), np.eye(scene.dimension)
        ends = getattr(joint, ("one", "other")[side]) or ()
        if not ends:
            return cls(anchor, still, anchor)
        body, index = located(ends[0])
        center = np.array(body.positions[index])
        if not body.is_rigid:
            return cls(center, still, center, scene.slice(body).start + index)
        first = cast("slice", scene.parts(body)["positions"][1]).start
        flat, size = body.angles is not None, body.shape.properties(scene.dimension).size ** (1.0 / scene.dimension)
        turn = planar_rotations(body.angles[[index]]) if flat else spatial_rotations(body.orientations[[index]])
        return cls(anchor, turn[0], center, first + index, True, size)


class Anchors:
    """One anchor of each joint: a point of a body, a particle, or a point of the world."""

    def __init__(self, ends: Sequence[End], dimension: int) -> None:
        count = len(ends)
        self.initial = np.array([end.anchor for end in ends]).reshape(count, dimension)
        self.is_body: BoolArray = np.array([end.is_body for end in ends], dtype=np.bool_)
        self._rows: IntArray = np.array([end.row for end in ends], dtype=np.int64)
        self._is_particle: BoolArray = (self._rows >= 0) & ~self.is_body
        local = [end.rotation.T @ (end.anchor - end.center) for end in ends]
        self._local = np.array(local).reshape(count, dimension)
        self._turned = np.array([end.rotation for end in ends]).reshape(count, dimension, dimension)
        self._turns = "angles" if dimension == 2 else "orientations"
        self.size = np.array([end.size for end in ends])

    def at(self, frame: SourceFrame) -> FloatArray:
        """The anchors in a frame (J, D) [m]."""
        result = self.centers(frame)
        if self.is_body.any():
            turned = np.einsum("nij,nj->ni", self._rotations(frame), self._local[self.is_body])
            result[self.is_body] += turned
        return result

    def centers(self, frame: SourceFrame) -> FloatArray:
        """The centers of the bodies in a frame (J, D) [m]; the anchors where there is no body."""
        result = self.initial.copy()
        if self.is_body.any():
            result[self.is_body] = frame.fields["rigid_positions"][self._rows[self.is_body]]
        if self._is_particle.any():
            result[self._is_particle] = frame.positions[self._rows[self._is_particle]]
        return result

    def turned(self, vectors: FloatArray, frame: SourceFrame) -> FloatArray:
        """Vectors (J, D) that turn with the bodies, given at the start."""
        result = vectors.copy()
        if self.is_body.any():
            own = np.einsum("nji,nj->ni", self._turned[self.is_body], vectors[self.is_body])
            result[self.is_body] = np.einsum("nij,nj->ni", self._rotations(frame), own)
        return result

    def _rotations(self, frame: SourceFrame) -> FloatArray:
        """The rotations (M, D, D) of the ends that are bodies."""
        turns = frame.fields[self._turns][self._rows[self.is_body]]
        return planar_rotations(turns) if turns.ndim == 1 else spatial_rotations(turns)


class Axes:
    """The axes of joints that have one; others have a vector of zeros."""

    def __init__(self, joints: Sequence[Constraint], other: Anchors) -> None:
        dimension = other.initial.shape[1]
        zero = (0.0,) * dimension
        self._other = other
        self._axes = np.array([getattr(joint, "axis", None) or zero for joint in joints]).reshape(-1, dimension)
        self.reach = np.array([_reach(joint, axis) for joint, axis in zip(joints, self._axes, strict=True)])

    def at(self, frame: SourceFrame) -> FloatArray:
        """The axes in a frame (J, D)."""
        return self._other.turned(self._axes, frame)


def _reach(joint: Constraint, axis: FloatArray) -> float:
    """Half the extent along an axis, about the anchor, of the bodies of a joint [m]."""
    if len(axis) < 3 or not axis.any():
        return 0.0
    most = 0.0
    for name in ("one", "other"):
        for body, index in map(located, getattr(joint, name) or ()):
            if body.is_rigid:
                turn = spatial_rotations(body.orientations[index : index + 1])[0]
                offset = body.positions[index] - np.array(cast("Any", joint).anchor)
                for points, radius in core_of(body.shape):
                    heights = (points @ turn.T + offset) @ axis
                    most = max(most, float(np.abs(heights).max()) + radius)
    return most


def owner(joint: Constraint) -> object:
    """The rigid bodies whose painter draws a joint."""
    ends = [*(getattr(joint, "one", None) or ()), *(getattr(joint, "other", None) or ())]
    return next((whole(end) for end in ends if whole(end).is_rigid), None)

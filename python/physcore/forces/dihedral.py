"""Bending of a surface by the angles between its faces."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from physcore.arithmetic import arctan2, dots, lengths
from physcore.checks import FloatArray, IntArray, frozen, number, shown
from physcore.errors import SceneError
from physcore.scene.bodies import SpringNetwork
from physcore.scene.items import Force, On
from physcore.scene.surfaces import check_areas


@dataclass(frozen=True)
class Dihedral(Force):
    """Resistance of a surface to bending, by the angle at every edge where two of its faces meet (discrete shells).

        cloth = pc.cloth((40, 30), 0.025, 400.0, bend_stiffness=0.0, mass=1e-4, origin=(0.0, 0.0, 0.0))
        scene = pc.Scene(cloth, pc.Dihedral(cloth, 1e-5), pc.Gravity((0.0, 0.0, -9.81)))

    With the angle θ by which the face beyond an edge is turned against the one before it, and its value θ₀ in the
    `positions` of the body, an edge has the energy and the torque

        U = ½ B w (θ − θ₀)²,   τ = −w (B (θ − θ₀) + damping · dθ/dt),   w = |e|²/A,

    |e| the length of the edge and A the area of its two faces together, both in `positions`. Its four corners feel
    −τ ∇θ: forces without a sum and without a moment. They do not resist stretching, and springs do not resist bending
    if they are in the surface, as those of a cloth without bend springs. The energy is by_term["dihedral"].

    This is Grinspun's energy with 3 k = B/2, so that B is the rigidity of a plate: ½ B/R² per area where the particles
    lie on a cylinder of radius R, on a mesh of equilateral triangles in every direction, on one of squares with
    diagonals, as a cloth has, along its rows and columns, where every edge across the bend turns by a/R, has w = 1 and
    the area a² about it. The rest follows from the mesh, as in all models of hinges. Equilateral triangles have
    Poisson's ratio −1/3. A cloth resists a twist κ = ∂²z/∂x∂y by 2 B κ² per area, twice as much as a plate, and in
    free motion it bends with 5/6 B, because particles where eight edges meet rise against the others.

    The angle θ − θ₀ is counted from −π to π: at ±π, where faces lie on one another, the energy is continuous and the
    torque changes its sign. A face without area, in a run, has no angle and feels no force. Where a spring along a side
    of a face breaks (`breaking_strain`), the face bends no more, and its energy is dissipated as "tearing".

    Args:
        on: the SpringNetwork in 3D, or several, or their names, with faces (T, 3) of which no more than two meet at an
            edge.
        stiffness: the bending rigidity B [N·m], at least zero; E h³/12/(1 − ν²) of an elastic sheet of thickness h.
        damping: [N·m·s], at least zero; what it takes counts as dissipated by damping.

    Raises:
        SceneError: a value is out of range or not finite, or the surface is not as above: it has no faces, one without
            area or one twice, or an edge of three.

    Source: E. Grinspun, A. N. Hirani, M. Desbrun, P. Schröder, "Discrete shells", Symposium on Computer Animation 2003;
    ∇θ by R. Bridson, S. Marino, R. Fedkiw, "Simulation of clothing with folds and wrinkles", there.
    """

    on: On = field(kw_only=False)
    """The network or networks that it acts on."""
    stiffness: float
    damping: float = 0.0
    hinges: IntArray = field(init=False, repr=False, compare=False)
    """The two ends of every edge between two faces, and their opposite corners, as indices (H, 4) into the particles of
    all networks, one after the other."""
    rest_angle: FloatArray = field(init=False, repr=False, compare=False)
    """θ₀ of every such edge, shape (H,)."""
    weight: FloatArray = field(init=False, repr=False, compare=False)
    """w = |e|²/A of every such edge, shape (H,)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        named = self.bodies()
        if not named:
            raise SceneError(f"Dihedral.on: must be a SpringNetwork with faces, got {shown(self.on)}")
        networks = tuple(dict.fromkeys(named))
        self._set(
            on=networks,
            stiffness=number(self.stiffness, "Dihedral.stiffness", least=0.0),
            damping=number(self.damping, "Dihedral.damping", least=0.0),
        )
        if self.by_name:
            return
        parts = [_hinges(body, "Dihedral.on" + (f"[{k}]" if len(named) > 1 else "")) for k, body in enumerate(networks)]
        starts = np.cumsum([0, *map(len, networks)])
        self._set(
            hinges=frozen(np.concatenate([start + part[0] for start, part in zip(starts, parts, strict=False)])),
            rest_angle=frozen(np.concatenate([angle for _, angle, _ in parts])),
            weight=frozen(np.concatenate([weight for _, _, weight in parts])),
        )


def _hinges(body: object, path: str) -> tuple[IntArray, FloatArray, FloatArray]:
    """Corners (H, 4), angles (H,) and weights (H,) of the edges of a surface between two faces, at rest."""
    if not isinstance(body, SpringNetwork):
        raise SceneError(f"{path}: must be a SpringNetwork with faces, got {shown(body)}")
    if body.dimension != 3:
        raise SceneError(f"{path}: must be in 3D, got {body!r}; a surface bends in space, give its positions a z")
    if not len(body.faces):
        raise SceneError(f"{path}: must have faces, got {body!r} without any; say which: SpringNetwork(…, faces=…)")
    hinges = _edges(body.faces, path)
    check_areas(body, path)
    start, end, one, other = np.moveaxis(body.positions[hinges], 1, 0)
    edge = end - start
    length = lengths(edge)
    normals = np.cross(edge, one - start), np.cross(other - start, edge)
    angle = arctan2(length * dots(normals[0], other - start), dots(*normals))
    return hinges, angle, length * length / (0.5 * sum(lengths(normal) for normal in normals))


def _edges(faces: IntArray, path: str) -> IntArray:
    """The edges between two faces, with their opposite corners, shape (H, 4), in the order of their ends."""
    sides = np.concatenate([faces[:, [0, 1, 2]], faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]])
    ends = np.sort(sides[:, :2], axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    sides, ends = sides[order], ends[order]
    same = (ends[1:] == ends[:-1]).all(axis=1)
    if (same[1:] & same[:-1]).any():
        first, second = ends[int(np.argmax(same[1:] & same[:-1]))].tolist()
        raise SceneError(
            f"{path}: must have one face or two at every edge, got more at that of the particles {first} and {second}; "
            "give each sheet of a branching surface a body of its own"
        )
    first = sides[:-1][same]
    opposite = sides[1:][same, 2]
    twice = first[:, 2] == opposite
    if twice.any():
        raise SceneError(
            f"{path}: must have every face once, got {sorted(first[int(np.argmax(twice))].tolist())} twice"
        )
    return np.column_stack([first, opposite])

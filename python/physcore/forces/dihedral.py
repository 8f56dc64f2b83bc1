"""Bending of a surface by the angles between its faces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from physcore.arithmetic import arctan2, dots, lengths
from physcore.checks import FloatArray, IntArray, frozen, number, shown
from physcore.errors import SceneError
from physcore.forces.hinge_weights import face_shares
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.items import Force
from physcore.scene.selection import Selection
from physcore.scene.surfaces import check_areas
from physcore.scene.targets import On


@dataclass(frozen=True)
class Dihedral(Force):
    """Bending resistance of a surface, by the dihedral angle at every edge between two faces (discrete shells).

        cloth = pc.cloth((40, 30), 0.025, 400.0, bend_stiffness=0.0, mass=1e-4, origin=(0.0, 0.0, 0.0))
        scene = pc.Scene(cloth, pc.Dihedral(cloth, 1e-5), pc.Gravity((0.0, 0.0, -9.81)))

    θ is the angle by which the face beyond an edge is turned against the face before it. θ₀ is its value in the
    `positions` of the body. The energy and the torque of an edge are

        U = ½ B w (θ − θ₀)²,   τ = −w (B (θ − θ₀) + damping · dθ/dt),   w = |e|²/a.

    Here |e| is the length of the edge in `positions`. The forces on the four corners are −τ ∇θ; their sum and their
    moment are zero. They do not resist stretching. Springs within the surface, as in a cloth without bend springs, do
    not resist bending. The energy is by_term["dihedral"].

    a is the area of the two faces, corrected by the directions of edges so that B is the rigidity of a plate. Bent to
    a radius R, the surface has the energy ½ B/R² per area once it is at rest. Poisson's ratio is −1/3. A strip with
    free sides therefore has the rigidity 8/9 B, as a strip of such a plate.

    This is exact, for small angles and in every direction, on a mesh of equilateral triangles and on the mesh of a
    cloth. It is also exact on such a mesh with cells up to 1.5 times as long as wide. Measured rigidities over B:

        mesh                                                  this force      a = area (Grinspun)
        cloth                                                 1.00            0.83 … 1.33
        cloth with cells 2 times as long                      0.78 … 1.24     0.62 … 1.91
        cloth, particles moved by up to 0.2 spacings          1.04 … 1.08     0.89 … 1.38
        equilateral, particles moved by up to 0.2 sides       1.06 … 1.08     1.03 … 1.05
        squares, diagonals at random                          1.11 … 1.50     0.90 … 1.69
        squares, all diagonals alike                          0.83 … 3.06     1.00 … 3.00

    The energy of a cloth whose particles are placed on a cylinder is 4/3 of ½ B/R². The particles where eight edges
    meet then move by an eighth of spacing²/R against the others, and the energy falls to that of a plate.

    The angle θ − θ₀ is in the range from −π to π. At ±π, where faces lie on one another, the energy is continuous and
    the torque changes its sign. A face whose area vanishes in a run has no angle and feels no force. If a spring along
    a side of a face breaks (`breaking_strain`), the face no longer resists bending. Its energy is dissipated as
    "tearing".

    Args:
        on: the SpringNetwork in 3D, or several, or their names, with faces (T, 3). At most two faces meet at an edge.
            Of a selection of particles, edges between two faces with all corners in it.
        stiffness: the bending rigidity B [N·m], at least zero; E h³/12/(1 − ν²) of an elastic sheet of thickness h.
        damping: damping coefficient [N·m·s], at least zero; its losses count as dissipated by damping.

    Raises:
        SceneError: a value is out of range or not finite, or the surface is not valid: it has no faces, a face without
            area, a repeated face, or an edge of three faces.

    Source: E. Grinspun, A. N. Hirani, M. Desbrun, P. Schröder, "Discrete shells", Symposium on Computer Animation 2003,
    where 3 k = B/2; the rigidity of equilateral triangles by H. S. Seung, D. R. Nelson, Phys. Rev. A 38, 1005 (1988);
    ∇θ by R. Bridson, S. Marino, R. Fedkiw, "Simulation of clothing with folds and wrinkles", ibid.
    """

    on: On = field(kw_only=False)
    """The network or networks that the force acts on."""
    stiffness: float
    damping: float = 0.0
    hinges: IntArray = field(init=False, repr=False, compare=False)
    """The two ends of every edge between two faces and the opposite corners, as indices (H, 4) into the concatenated
    particles of all networks.
    """
    rest_angle: FloatArray = field(init=False, repr=False, compare=False)
    """θ₀ of every such edge [rad], shape (H,)."""
    weight: FloatArray = field(init=False, repr=False, compare=False)
    """w = |e|²/a of every such edge, shape (H,)."""

    @property
    def dissipates(self) -> bool:
        """Whether there is damping."""
        return self.damping > 0.0

    def fall(self, dimension: int) -> FloatArray:
        """Zero: a flat surface stays flat."""
        return np.zeros(dimension)

    def __post_init__(self) -> None:
        super().__post_init__()
        named = self.targets()
        if not named:
            raise SceneError(f"Dihedral.on: must be a SpringNetwork with faces, got {shown(self.on)}")
        self._set(
            stiffness=number(self.stiffness, "Dihedral.stiffness", least=0.0),
            damping=number(self.damping, "Dihedral.damping", least=0.0),
        )
        if self.by_name:
            return
        parts = [_hinges(each, "Dihedral.on" + (f"[{k}]" if len(named) > 1 else "")) for k, each in enumerate(named)]
        starts = np.cumsum([0, *(len(each.body if isinstance(each, Selection) else each) for each in named)])
        self._set(
            hinges=frozen(np.concatenate([start + part[0] for start, part in zip(starts, parts, strict=False)])),
            rest_angle=frozen(np.concatenate([angle for _, angle, _ in parts])),
            weight=frozen(np.concatenate([weight for _, _, weight in parts])),
        )


def _hinges(target: Body | str | Selection, path: str) -> tuple[IntArray, FloatArray, FloatArray]:
    """Corners (H, 4), rest angles (H,) and weights (H,) of the edges between two faces of a surface, or of a part."""
    body = target.body if isinstance(target, Selection) else target
    if not isinstance(body, SpringNetwork):
        raise SceneError(f"{path}: must be a SpringNetwork with faces, got {shown(body)}")
    if body.dimension != 3:
        raise SceneError(f"{path}: must be in 3D, got {body!r}; a surface bends in space, give its positions a z")
    if not len(body.faces):
        raise SceneError(f"{path}: must have faces, got {body!r} without any; say which: SpringNetwork(…, faces=…)")
    faces = body.faces[target.mask[body.faces].all(axis=1)] if isinstance(target, Selection) else body.faces
    hinges, sides = _edges(faces, path)
    if isinstance(target, Selection) and not len(hinges):
        raise SceneError(f"{path}: must have the four corners of two faces at an edge, got {target!r}")
    check_areas(body, path)
    start, end, one, other = np.moveaxis(body.positions[hinges], 1, 0)
    edge = end - start
    length = lengths(edge)
    normals = np.cross(edge, one - start), np.cross(other - start, edge)
    angle = arctan2(length * dots(normals[0], other - start), dots(*normals))
    shares = face_shares(body.positions, faces).T.ravel()
    return hinges, angle, length * length / (shares[sides[0]] + shares[sides[1]])


def _edges(faces: IntArray, path: str) -> tuple[IntArray, tuple[IntArray, IntArray]]:
    """The edges between two faces with their opposite corners, shape (H, 4), sorted by their ends; and the two sides of
    faces that meet there: side k of face t has the index k T + t.
    """
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
    return np.column_stack([first, opposite]), (order[:-1][same], order[1:][same])

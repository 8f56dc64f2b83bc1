"""Meshes of triangles, and the items of a scene that are made of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from physcore import _core
from physcore.arithmetic import dots, lengths
from physcore.boundaries.convex_hull import ConvexHull
from physcore.checks import BoolArray, FloatArray, IntArray, array, broadcast, frozen, number, span, text
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.files.faults import fault_of
from physcore.files.filling import tetrahedra
from physcore.scene.bodies import SpringNetwork, indices
from physcore.scene.polytopes import MeshShape
from physcore.scene.records import Record
from physcore.scene.rigid import RigidBody
from physcore.scene.shapes import block

NONE = (1.0, 0.0, 0.0, 0.0)
"""Orientation of a body that is not turned."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Mesh:
    """Mesh of triangles in 3D, from which bodies and obstacles are made.

        corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]
        mesh = pc.Mesh(corners, faces=[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        mesh.volume, mesh.area, mesh.is_closed
        scene = pc.Scene(mesh.rigid_body(density=700.0), pc.Gravity(), pc.Floor(-0.2))

    `pc.read` reads one from a file, `pc.from_mesh` takes one of another package.

    Args:
        vertices: vertices [m], shape (K, 3).
        faces: indices of the corners of each triangle, shape (T, 3), counterclockwise as seen from outside.
        name: name for messages and for the bodies that are made of it, such as that of the file.

    Raises:
        SceneError: a shape does not fit, an index is out of range, or a value is not finite.
    """

    vertices: FloatArray
    """Vertices [m], shape (K, 3)."""
    faces: IntArray
    """Indices of the corners of each triangle, shape (T, 3)."""
    name: str | None
    """Name, or None."""

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, name: str | None = None) -> None:
        points = array(vertices, "Mesh.vertices")
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 3:
            raise SceneError(f"Mesh.vertices: must have the shape (K, 3), at least 3 of them, got {points.shape}")
        triangles = indices(faces, 3, len(points), "Mesh.faces")
        if not len(triangles):
            raise SceneError("Mesh.faces: must be at least one triangle, got none")
        label = None if name is None else text(name, "Mesh.name")
        for field, value in {"vertices": frozen(points), "faces": frozen(triangles), "name": label}.items():
            object.__setattr__(self, field, value)

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        size = " × ".join(f"{extent:.3g}" for extent in np.ptp(self.vertices, axis=0))
        return f"Mesh({label}{len(self.vertices)} vertices, {len(self.faces)} faces, {size} m)"

    @cached_property
    def area(self) -> float:
        """Area of all faces [m²]."""
        return float(self._areas.sum())

    @cached_property
    def volume(self) -> float:
        """Volume within the faces [m³]; negative if they are clockwise as seen from outside.

        Raises:
            SceneError: the mesh is not closed.
        """
        self._require_closed("volume")
        return self._signed_volume

    @property
    def is_closed(self) -> bool:
        """Whether each edge belongs to two faces, which pass it in opposite directions."""
        return self.fault is None

    @cached_property
    def fault(self) -> str | None:
        """The first place where the mesh is not closed, as a sentence; None if it is closed."""
        return fault_of(self.vertices, self.faces)

    @cached_property
    def edges(self) -> IntArray:
        """The two vertices of each edge, in increasing order, shape (E, 2)."""
        edges = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        return frozen(np.unique(edges, axis=0))

    @entrance
    def moved(self, by: ArrayLike = 0.0, scale: float = 1.0) -> Mesh:
        """The mesh, scaled about the origin and then moved.

            cup = pc.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).moved((0.0, 0.0, 0.5), scale=0.1)

        Args:
            by: way [m], shape (3,).
            scale: factor, above zero.

        Raises:
            SceneError: a value is not valid.
        """
        way = broadcast(by, (3,), "moved.by")
        return Mesh(span(scale, "moved.scale") * self.vertices + way, self.faces, self.name)

    @entrance
    def cloth(
        self,
        stiffness: float,
        areal_density: float,
        damping: float = 0.0,
        *,
        fixed: ArrayLike | None = None,
        velocities: ArrayLike = 0.0,
        radius: ArrayLike = 0.0,
        name: str | None = None,
        breaking_strain: float = float("inf"),
        strain_limit: float = float("inf"),
    ) -> SpringNetwork:
        """Cloth: a particle at each vertex, a spring along each edge, and the faces. It need not be closed.

            sheet = pc.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
            flag = sheet.cloth(stiffness=100.0, areal_density=0.2, fixed=[0, 3])

        A particle has a third of the area of its faces. `Dihedral(cloth, …)` resists bending, `SelfContact` contact.

        Args:
            stiffness: stiffness of each spring [N/m].
            areal_density: mass per area [kg/m²], above zero.
            damping: damping along each spring [N·s/m].
            fixed, velocities, radius: as in Particles.
            name: name of the body; None: that of the mesh.
            breaking_strain, strain_limit: as in SpringNetwork.

        Raises:
            SceneError: a vertex has no face, or a value is out of range.
        """
        shares = np.bincount(self.faces.ravel(), weights=np.repeat(self._areas / 3.0, 3), minlength=len(self.vertices))
        if not shares.all():
            alone = int(np.argmin(shares))
            raise SceneError(f"{self._called}: must have an area of faces at each vertex, and vertex {alone} has none")
        return SpringNetwork(
            self.vertices,
            self.edges,
            stiffness,
            damping,
            mass=number(areal_density, "cloth.areal_density", above=0.0) * shares,
            fixed=fixed,
            velocities=velocities,
            radius=radius,
            name=self.name if name is None else name,
            faces=self.faces,
            breaking_strain=breaking_strain,
            strain_limit=strain_limit,
        )

    @entrance
    def soft_body(
        self,
        spacing: float,
        stiffness: float,
        damping: float = 0.0,
        density: float = 1000.0,
        *,
        fixed: ArrayLike | None = None,
        velocities: ArrayLike = 0.0,
        radius: ArrayLike = 0.0,
        name: str | None = None,
        breaking_strain: float = float("inf"),
        strain_limit: float = float("inf"),
    ) -> SpringNetwork:
        """Soft body: particles at the vertices and on a lattice within, with springs along the edges of tetrahedra.

            jelly = mesh.soft_body(spacing=0.05, stiffness=200.0, density=1000.0)

        The lattice is body-centered cubic. The tetrahedra are those of the Delaunay triangulation whose centers are in
        the mesh; the edges of the mesh have springs in any case. A particle has a quarter of the mass of its
        tetrahedra, half of which it gives to its neighbors, so that none is very light. The whole has the mass of the
        volume. The first particles are the vertices. Needs scipy: `pip install 'physcore[files]'`.

        Args:
            spacing: edge of the cubes of the lattice [m], above zero; near the length of the edges of the mesh.
            stiffness: stiffness of each spring [N/m].
            damping: damping along each spring [N·s/m].
            density: mass per volume [kg/m³], above zero.
            fixed, velocities, radius: as in Particles.
            name: name of the body; None: that of the mesh.
            breaking_strain, strain_limit: as in SpringNetwork.

        Raises:
            SceneError: the mesh is not closed, or a value is out of range.
            PhyscoreError: scipy is not installed.
        """
        self._require_closed("soft_body")
        points, corners = tetrahedra(self, span(spacing, "soft_body.spacing"), "soft_body.spacing")
        one, *others = (points[corners[:, corner]] for corner in range(4))
        a, b, c = (other - one for other in others)
        volumes = np.abs(dots(a, np.cross(b, c))) / 6.0
        shares = np.bincount(corners.ravel(), weights=np.repeat(0.25 * volumes, 4), minlength=len(points))
        sides = corners[:, [0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3]].reshape(-1, 2)
        pairs = np.unique(np.sort(np.concatenate([sides, self.edges]), axis=1), axis=0)
        degrees = np.bincount(pairs.ravel(), minlength=len(points))
        given = 0.5 * shares / degrees  # to each neighbor
        taken = np.bincount(pairs.ravel(), weights=given[pairs[:, ::-1].ravel()], minlength=len(points))
        mass = number(density, "soft_body.density", above=0.0) * abs(self.volume)
        return SpringNetwork(
            points,
            pairs,
            stiffness,
            damping,
            mass=mass * (0.5 * shares + taken) / shares.sum(),
            fixed=fixed,
            velocities=velocities,
            radius=radius,
            name=self.name if name is None else name,
            faces=self.faces,
            breaking_strain=breaking_strain,
            strain_limit=strain_limit,
        )

    @cached_property
    def shape(self) -> MeshShape:
        """The solid within the faces, as the shape of rigid bodies.

        Raises:
            SceneError: the mesh is not closed.
        """
        self._require_closed("shape")
        return MeshShape(self.vertices, self.faces)

    @entrance
    def rigid_body(
        self,
        position: ArrayLike | None = None,
        *,
        orientation: ArrayLike = NONE,
        velocity: ArrayLike = 0.0,
        angular_velocity: ArrayLike = 0.0,
        density: float = 1000.0,
        mass: float | None = None,
        friction: float = 0.5,
        restitution: float = 0.0,
        fixed: bool = False,
        charge: float = 0.0,
        name: str | None = None,
    ) -> RigidBody:
        """Rigid body: the solid within the faces.

            die = mesh.rigid_body((0.0, 0.0, 1.0), angular_velocity=(3.0, 0.0, 0.0), density=700.0)

        Args:
            position: position of the center of mass [m], shape (3,); None: where the mesh is.
            orientation, velocity, angular_velocity, density, mass, friction, restitution, fixed, charge: as in
                RigidBody.
            name: name of the body; None: that of the mesh.

        Raises:
            SceneError: the mesh is not closed, or a value is out of range.
        """
        solid = self.shape
        return RigidBody(
            solid,
            solid.properties(3).center if position is None else position,
            orientation=orientation,
            velocity=velocity,
            angular_velocity=angular_velocity,
            density=density,
            mass=mass,
            friction=friction,
            restitution=restitution,
            fixed=fixed,
            charge=charge,
            name=self.name if name is None else name,
        )

    @entrance
    def boundary(self, *, friction: float = 0.0, restitution: float = 1.0, name: str | None = None) -> RigidBody:
        """Obstacle: the solid within the faces, which stays in its place.

            rock = mesh.boundary(friction=0.4, restitution=0.2)
            bowl = mesh.boundary()  # a mesh with an inner and an outer side holds water

        It is a rigid body that is fixed. Particles, cloths, soft bodies, rigid bodies and fluids stay outside, by exact
        distances from the faces. `recording[rock].force` has the force of fluids.

        Args:
            friction, restitution: as in RigidBody. With another body friction counts as √(μ₁ μ₂), of which a particle
                takes that of the obstacle.
            name: name of the body; None: that of the mesh.

        Raises:
            SceneError: the mesh is not closed, or a value is out of range.
        """
        return self.rigid_body(fixed=True, friction=friction, restitution=restitution, name=name)

    @entrance
    def hull(self, *, restitution: float = 1.0, friction: float = 0.0, no_slip: bool = False) -> ConvexHull:
        """Obstacle: the convex hull of the vertices.

            stone = mesh.hull(friction=0.3)

        Args:
            restitution, friction, no_slip: as in Boundary.

        Raises:
            SceneError: the vertices are flat, or a value is out of range.
        """
        return ConvexHull(self.vertices, restitution=restitution, friction=friction, no_slip=no_slip)

    @entrance
    def contains(self, points: ArrayLike) -> BoolArray:
        """Whether each point is within the faces.

            inside = mesh.contains(pc.block((0, 0, 0), (0.1, 0.1, 0.1), 0.02))

        Args:
            points: positions [m], shape (N, 3).

        Returns:
            A mask of shape (N,).

        Raises:
            SceneError: the mesh is not closed, or the shape does not fit.
        """
        places = array(points, "contains.points")
        if places.ndim != 2 or places.shape[1] != 3:
            raise SceneError(f"contains.points: must have the shape (N, 3), got {places.shape}")
        solid = self.shape
        center = np.array(solid.properties(3).center)
        inside: BoolArray = _core.points_inside(
            Record.of(solid).described(), 3, places, center[np.newaxis], np.array([NONE])
        )
        return inside

    @entrance
    def fill(self, spacing: float) -> FloatArray:
        """The centers of the cells of a cubic lattice that are within the faces, as `pc.block` has them.

            water = pc.Fluid(mesh.fill(0.01), spacing=0.01)

        Args:
            spacing: edge of a cell [m], above zero.

        Returns:
            Positions [m], shape (N, 3), ordered along x first.

        Raises:
            SceneError: the mesh is not closed, or has no room for a cell.
        """
        step = span(spacing, "fill.spacing")
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        cells = block(low, np.maximum(high, low + step) + step, step)
        found: FloatArray = cells[self.contains(cells)]
        if not len(found):
            raise SceneError(f"fill.spacing: {self._called} has no room for a cell of {step:g} m")
        return found

    @cached_property
    def _areas(self) -> FloatArray:
        """Area of each face [m²], shape (T,)."""
        first, second, third = (self.vertices[self.faces[:, corner]] for corner in range(3))
        return 0.5 * lengths(np.cross(second - first, third - first))

    @cached_property
    def _signed_volume(self) -> float:
        """Sum of the volumes of the tetrahedra between the first vertex and each face [m³]."""
        corners = self.vertices[self.faces] - self.vertices[0]
        return float(dots(corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6.0

    @property
    def _called(self) -> str:
        """The name in messages."""
        return self.name or "the mesh"

    def _require_closed(self, path: str) -> None:
        """Check that the mesh is closed.

        Raises:
            SceneError: it is not.
        """
        if self.fault is not None:
            raise SceneError(
                f"Mesh.{path}: must be a closed mesh, but of {self._called}: {self.fault}. Close it where it was made, "
                "or with trimesh: repair.fill_holes(…), repair.fix_normals(…); an open one is a cloth: mesh.cloth(…)"
            )

"""Base of the formats of surfaces: their units, and meshes of fluids and rigid bodies.

Surfaces of fluids are found from their particles by the package pysplashsurf.
"""

from __future__ import annotations

from abc import abstractmethod
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from physcore.checks import FloatArray
from physcore.errors import PhyscoreError
from physcore.film.shapes.spatial import mesh_of
from physcore.output.base import ExportJob, TrajectoryWriter
from physcore.scene.rigid import RigidBodies
from physcore.units.systems import SI

if TYPE_CHECKING:
    from pysplashsurf import TriMesh3d

PACKAGE = "pysplashsurf"
ACROSS = 200.0
"""Number of pixels across a rigid body, for which its round parts are smooth."""
ROUNDS = 25
"""Rounds of smoothing that the package recommends. They move vertices by a small part of the spacing."""
THRESHOLD = 0.6
"""Level of the color field at the surface, for which it lies half a spacing outside of the outermost particles."""


class SurfaceMesh(NamedTuple):
    """A surface of triangles."""

    points: FloatArray
    """Vertices, shape (N, 3)."""
    faces: NDArray[Any]
    """Vertices of the triangles, counterclockwise seen from outside, shape (M, 3)."""
    normals: FloatArray
    """Unit vectors to the outside, shape (N, 3)."""


class SurfaceWriter(TrajectoryWriter):
    """Writer of surfaces that move, in meters and seconds unless the user asks for other units."""

    holds_particles: ClassVar = False
    prescribed: ClassVar = SI

    def write(self, job: ExportJob, target: Path) -> None:
        """Write all frames.

        Raises:
            PhyscoreError: there are fluids, and the package for their surfaces is missing.
        """
        if any(body.is_fluid for body, _ in job.surfaces.values()) and find_spec(PACKAGE) is None:
            raise PhyscoreError(f"{target}: surfaces of fluids need {PACKAGE}: pip install 'physcore[files]'")
        self.write_surfaces(job, target)

    @abstractmethod
    def write_surfaces(self, job: ExportJob, target: Path) -> None:
        """Write all frames, for which all packages are installed."""


def solid_surface(body: RigidBodies, scale: float) -> SurfaceMesh:
    """The surface of each of some rigid bodies in its own frame, with lengths times a factor."""
    size = float(np.cbrt(body.shape.properties(3).size))
    solid = mesh_of(body.shape, ACROSS / size, marks=False)
    return SurfaceMesh(scale * solid.points, solid.triangles, solid.normals)


def liquid_surface(positions: FloatArray, spacing: float) -> SurfaceMesh:
    """The surface of a liquid with particles at these positions (N, 3), by marching cubes of half a spacing.

    Source: F. Löschner, T. Böttcher, S. R. Jeske, J. Bender, "Weighted Laplacian Smoothing for Surface Reconstruction
    of Particle-based Fluids", Vision, Modeling, and Visualization (2023).
    """
    from pysplashsurf import reconstruction_pipeline

    if not len(positions):
        return SurfaceMesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), np.empty((0, 3)))
    found, _ = reconstruction_pipeline(
        np.ascontiguousarray(positions),
        particle_radius=0.5 * spacing,
        rest_density=1.0,
        smoothing_length=2.0,
        cube_size=1.0,
        iso_surface_threshold=THRESHOLD,
        mesh_cleanup=True,
        decimate_barnacles=True,
        mesh_smoothing_weights=True,
        compute_normals=True,
        mesh_smoothing_iters=ROUNDS,
        normals_smoothing_iters=ROUNDS,
    )
    mesh = cast("TriMesh3d", found.mesh)  # no quadrilaterals were asked for
    return SurfaceMesh(np.asarray(mesh.vertices), mesh.triangles.astype(np.int64), found.point_attributes["normals"])

"""Surfaces of fluids as triangles, from their particles, by the package pysplashsurf."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from physcore.checks import FloatArray
from physcore.errors import PhyscoreError
from physcore.output.base import ExportJob

if TYPE_CHECKING:
    from pysplashsurf import TriMesh3d

PACKAGE = "pysplashsurf"
ROUNDS = 25
"""Rounds of smoothing that the package recommends. They move vertices by a small part of the spacing."""
THRESHOLD = 0.6
"""Level of the color field at the surface, for which it lies half a spacing outside of the outermost particles."""


class LiquidSurface(NamedTuple):
    """A surface of triangles."""

    points: FloatArray
    """Vertices, shape (N, 3)."""
    faces: NDArray[Any]
    """Vertices of the triangles, counterclockwise seen from outside, shape (M, 3)."""
    normals: FloatArray
    """Unit vectors out of the liquid, shape (N, 3)."""


def require(job: ExportJob, target: Path) -> None:
    """Check that the package is there if a job has liquids.

    Raises:
        PhyscoreError: it is not installed.
    """
    if any(body.is_fluid for body, _ in job.surfaces.values()) and find_spec(PACKAGE) is None:
        raise PhyscoreError(f"{target}: surfaces of fluids need {PACKAGE}: pip install 'physcore[files]'")


def liquid_surface(positions: FloatArray, spacing: float) -> LiquidSurface:
    """The surface of a liquid with particles at these positions (N, 3), by marching cubes of half a spacing.

    Source: F. Löschner, T. Böttcher, S. R. Jeske, J. Bender, "Weighted Laplacian Smoothing for Surface Reconstruction
    of Particle-based Fluids", Vision, Modeling, and Visualization (2023).
    """
    from pysplashsurf import reconstruction_pipeline

    if not len(positions):
        return LiquidSurface(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), np.empty((0, 3)))
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
    return LiquidSurface(np.asarray(mesh.vertices), mesh.triangles.astype(np.int64), found.point_attributes["normals"])

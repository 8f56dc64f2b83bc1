"""Symptom "coarse": a field has waves, or a surface has folds, that are too short for its grid or mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from physcore.arithmetic import dots
from physcore.checks import FloatArray
from physcore.scene.system import System
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

OCTAVE = 0.5
"""The last octave of a grid begins at this fraction of its largest wave number, with four cells in a wavelength."""
LAST_MODES = 0.9
"""Fraction of the largest wave number at which the last modes of a transform begin."""
SHARE = 0.05
"""Share of the squared amplitude in the last octave above which a field is coarse."""
FOLDED = 0.05
"""Share of a mesh's inner edges folded by more than 90° above which its wrinkles are as short as its springs.

A single sharp fold across a sheet of n by n squares has a share of 1/(3 n).
"""


def coarse(case: Case) -> Iterator[Finding]:
    """Check the spectra of fields on grids, and the folds of surfaces."""
    yield from _waves(case)
    yield from _folds(case)


def _folds(case: Case) -> Iterator[Finding]:
    """Check the angles between adjacent triangles of each surface, at the end."""
    for body in case.scene.networks:
        if case.scene.dimension != 3 or case.positions is None:
            continue
        share = folded(case.positions[-1, case.scene.slice(body)], body.faces)
        if share > FOLDED:
            cause = (
                f"{case.scene.path(body)} has {share:.0%} of its inner edges folded by more than 90°: its wrinkles "
                "are as short as its springs"
            )
            cure = "take a finer mesh, or a stiffness against bending (pc.Dihedral or bend=) that makes wrinkles longer"
            yield Finding("coarse", cause, cure, share)


def folded(positions: FloatArray, faces: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> float:
    """The share of inner edges at which two adjacent triangles are folded by more than 90°; 0.0 without inner edges."""
    faces = np.asarray(faces)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    ascending = edges[:, 0] < edges[:, 1]
    edges = np.sort(edges, axis=1)
    order = np.lexsort(edges.T)
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    if len(one) == 0:
        return 0.0
    corners = positions[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Triangles with the same orientation traverse their common edge in opposite directions.
    sign = np.where(ascending[one] != ascending[other], 1.0, -1.0)
    return float(np.mean(sign * dots(normals[owner[one]], normals[owner[other]]) < 0.0))


def _waves(case: Case) -> Iterator[Finding]:
    """Check the spectra of the first, middle and last frames of fields on grids."""
    for system in case.scene.grids:
        if system.solid is not None:
            continue
        begin = LAST_MODES if case.plan.integrator == "SplitStep" else OCTAVE
        share = max((_share(field, begin) for field in _fields(case, system)), default=0.0)
        if share > SHARE:
            fate = (
                "beyond which a grid knows none"
                if begin == LAST_MODES
                else "which differences slow down or turn around"
            )
            cause = (
                f"{case.scene.system(system)} has {share:.0%} of its square in waves of fewer than {2.0 / begin:.2g} "
                f"cells, {fate}"
            )
            finer = f"{0.5 * system.grid.spacing:.2g}{case.scene.units.suffix('m')}"
            cure = f"take a spacing of {finer} or less, or smoother fields"
            yield Finding("coarse", cause, cure, share)


def _fields(case: Case, system: System) -> list[np.ndarray[tuple[int, ...], np.dtype[np.complex128]]]:
    """The first field of a system, or its wave function, at some frames; none that was not recorded."""
    own: Mapping[str, FloatArray]
    if case.recording is not None:
        own = case.recording[system].channels
    else:
        assert case.simulation is not None
        own = case.simulation[system].fields
    values = own.get("wave_function", own.get(system.primary))
    if values is None:
        return []
    if case.recording is None:
        return [np.asarray(values)]
    return [np.asarray(values[frame]) for frame in (0, len(values) // 2, -1)]


def _share(field: FloatArray | np.ndarray[tuple[int, ...], np.dtype[np.complex128]], begin: float) -> float:
    """The share of the squared amplitude in waves beyond a fraction of the largest wave number of an axis.

    The window cos² lets a field that is not periodic have no step at its ends. A mean of real fields is no wave.
    """
    values = np.array(field, dtype=complex)
    if not np.iscomplexobj(field):
        values -= values.mean()
    short = np.zeros(values.shape, dtype=bool)
    for axis, count in enumerate(values.shape):
        along = [1] * values.ndim
        along[axis] = count
        values *= np.sin(np.pi * (np.arange(count) + 0.5) / count).reshape(along) ** 2
        short |= (np.abs(np.fft.fftfreq(count)) > 0.5 * begin).reshape(along)
    power = np.square(np.abs(np.fft.fftn(values)))
    total = float(power.sum())
    return float(power[short].sum()) / total if total > 0.0 else 0.0

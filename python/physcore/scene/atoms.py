"""Atoms: particles with species, bonds and a cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import IntArray, frozen, items, shown, text
from physcore.errors import SceneError
from physcore.scene.bodies import Particles, indices
from physcore.scene.periodic import Periodic
from physcore.spelling import did_you_mean
from physcore.units.systems import SI, UnitSystem


class Atoms(Particles):
    """Particles that a file of atoms or molecules describes: with species, bonds and a periodic cell.

        argon: pc.Atoms = pc.read("argon.xyz", unit="metal")
        scene = pc.Scene(argon, argon.domain, pc.LennardJones(1.65e-21, 3.4e-10))
        argon.species[:3], argon.units
        argon.of("Ar")  # indices, as in on=(argon, argon.of("Ar"))

    Files of recordings keep atoms as Particles.

    Args:
        positions, velocities, mass, charge, radius, fixed, name: as in Particles, in `units`.
        species: name of the element or type of each atom; one name is that of all.
        bonds: indices of the two atoms of each bond, shape (B, 2); None: none.
        domain: periodic cell; None: none.
        units: units of all numbers, for `Scene(units=…)`.

    Raises:
        SceneError: a shape does not fit, or a value is not valid.
    """

    species: tuple[str, ...]
    """Names of the elements or types, one for each atom."""
    bonds: IntArray
    """Indices of the two atoms of each bond, shape (B, 2)."""
    domain: Periodic | None
    """Periodic cell, or None."""
    units: UnitSystem
    """Units of all numbers."""

    def __init__(
        self,
        positions: ArrayLike,
        species: str | Sequence[str],
        velocities: ArrayLike = 0.0,
        mass: ArrayLike = 1.0,
        charge: ArrayLike = 0.0,
        radius: ArrayLike = 0.0,
        fixed: ArrayLike | None = None,
        name: str | None = None,
        *,
        bonds: ArrayLike | None = None,
        domain: Periodic | None = None,
        units: UnitSystem = SI,
    ) -> None:
        super().__init__(positions, velocities, mass, charge, radius, fixed, name)
        one = isinstance(species, str)
        names = (species,) * len(self) if one else tuple(items(species, "Atoms.species", "names"))
        if len(names) != len(self) or not all(isinstance(each, str) for each in names):
            raise SceneError(f"Atoms.species: must be {len(self)} names, one for each atom, got {shown(species)}")
        pairs = indices([] if bonds is None else bonds, 2, len(self), "Atoms.bonds")
        if domain is not None and not isinstance(domain, Periodic):
            raise SceneError(f"Atoms.domain: must be a Periodic or None, got {shown(domain)}")
        if not isinstance(units, UnitSystem):
            raise SceneError(f"Atoms.units: must be a system of units, such as pc.units.SI, got {shown(units)}")
        self._set(species=tuple(map(str, names)), bonds=pairs, domain=domain, units=units)

    def of(self, species: str) -> IntArray:
        """The indices of all atoms of a species.

            water = pc.read("water.gro")
            oxygen = water.of("O")

        Args:
            species: name of the species.

        Raises:
            SceneError: there is none of this species.
        """
        name = text(species, "of.species")
        found = np.flatnonzero([each == name for each in self.species])
        if not len(found):
            known = tuple(dict.fromkeys(self.species))
            raise SceneError(f"of.species: must be one of {known}, got {shown(species)}{did_you_mean(species, known)}")
        return frozen(found)

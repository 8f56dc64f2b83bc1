"""Units and physical constants in SI, and systems of units for scenes.

    earth = pc.Particles([[pc.units.AU, 0.0]], mass=pc.units.earth_mass)
    year = pc.units.year  # [s]

A length of 5 AU is 5 * pc.units.AU. With a system of units, the numbers of a scene are in its units instead:

    astronomical = pc.units.system(length=pc.units.AU, time=pc.units.day, mass=pc.units.solar_mass)
    scene = pc.Scene(pc.Particles([[1.0, 0.0]], [[0.0, 0.0172]]), pc.CentralForce(1.0), units=astronomical)

`constants` has the sources of the values.
"""

from __future__ import annotations

from physcore.units.constants import (
    AU,
    atomic_mass,
    boltzmann_constant,
    coulomb_constant,
    day,
    earth_mass,
    earth_radius,
    electron_charge,
    electron_mass,
    electron_volt,
    elementary_charge,
    gravitational_constant,
    hour,
    jupiter_mass,
    light_year,
    minute,
    parsec,
    proton_mass,
    reduced_planck_constant,
    solar_mass,
    solar_radius,
    speed_of_light,
    year,
)
from physcore.units.systems import SI, UnitSystem, dimensionless, system

__all__ = [
    "AU",
    "SI",
    "UnitSystem",
    "atomic_mass",
    "boltzmann_constant",
    "coulomb_constant",
    "day",
    "dimensionless",
    "earth_mass",
    "earth_radius",
    "electron_charge",
    "electron_mass",
    "electron_volt",
    "elementary_charge",
    "gravitational_constant",
    "hour",
    "jupiter_mass",
    "light_year",
    "minute",
    "parsec",
    "proton_mass",
    "reduced_planck_constant",
    "solar_mass",
    "solar_radius",
    "speed_of_light",
    "system",
    "year",
]


def __dir__() -> list[str]:
    return list(__all__)

"""Values of units and physical constants in SI.

Sources: E. Tiesinga et al., CODATA recommended values of the fundamental physical constants: 2018, Rev. Mod. Phys. 93,
025010 (2021), unless another source is given. The constants that define the SI are exact. Resolutions of the IAU: the
astronomical unit (2012 B2), and nominal values of the Sun, the Earth and Jupiter (2015 B3). Masses are the nominal GM
over G.
"""

from __future__ import annotations

from typing import Final

minute: Final = 60.0
"""Minute [s]."""
hour: Final = 3600.0
"""Hour [s]."""
day: Final = 86400.0
"""Day [s]."""
year: Final = 365.25 * day
"""Julian year [s] (IAU)."""

speed_of_light: Final = 299792458.0
"""Speed of light c [m/s], exact."""
gravitational_constant: Final = 6.67430e-11
"""Gravitational constant G [m³/(kg·s²)]."""
coulomb_constant: Final = 8.9875517923e9
"""Coulomb constant k = 1/(4π ε₀) [N·m²/C²], with ε₀ = 8.8541878128e-12 F/m."""
reduced_planck_constant: Final = 1.054571817646156e-34
"""Reduced Planck constant ħ [J·s], exact to 16 digits."""
boltzmann_constant: Final = 1.380649e-23
"""Boltzmann constant k_B [J/K], exact."""

AU: Final = 149597870700.0
"""Astronomical unit [m], exact (IAU 2012 B2)."""
light_year: Final = speed_of_light * year
"""Light year [m] (IAU)."""
parsec: Final = 3.0856775814913673e16
"""Parsec [m], 648000/π AU (IAU 2015 B2)."""

solar_mass: Final = 1.3271244e20 / gravitational_constant
"""Mass of the Sun [kg], from its nominal GM (IAU 2015 B3)."""
earth_mass: Final = 3.986004e14 / gravitational_constant
"""Mass of the Earth [kg], from its nominal GM (IAU 2015 B3)."""
jupiter_mass: Final = 1.2668653e17 / gravitational_constant
"""Mass of Jupiter [kg], from its nominal GM (IAU 2015 B3)."""
solar_radius: Final = 6.957e8
"""Nominal radius of the Sun [m] (IAU 2015 B3)."""
earth_radius: Final = 6.3781e6
"""Nominal equatorial radius of the Earth [m] (IAU 2015 B3)."""

elementary_charge: Final = 1.602176634e-19
"""Elementary charge e [C], exact; the charge of a proton."""
electron_charge: Final = -elementary_charge
"""Charge of the electron [C], negative."""
electron_volt: Final = 1.602176634e-19
"""Electronvolt [J], exact."""
electron_mass: Final = 9.1093837015e-31
"""Mass of the electron [kg]."""
proton_mass: Final = 1.67262192369e-27
"""Mass of the proton [kg]."""
atomic_mass: Final = 1.66053906660e-27
"""Atomic mass unit [kg]."""

UNITS: Final = {
    **dict.fromkeys(("minute", "hour", "day", "year"), "s"),
    **dict.fromkeys(("AU", "light_year", "parsec", "solar_radius", "earth_radius"), "m"),
    **dict.fromkeys(("solar_mass", "earth_mass", "jupiter_mass"), "kg"),
    **dict.fromkeys(("electron_mass", "proton_mass", "atomic_mass"), "kg"),
    **dict.fromkeys(("elementary_charge", "electron_charge"), "C"),
    "electron_volt": "J",
    "speed_of_light": "m/s",
    "gravitational_constant": "m³/(kg·s²)",
    "coulomb_constant": "N·m²/C²",
    "reduced_planck_constant": "J·s",
    "boltzmann_constant": "J/K",
}
"""SI unit of each constant."""

"""Materials of thin sheets: areal density, and stiffness against stretching, shear and bending.

    cloth = pc.cloth((40, 30), 0.025, damping=0.02, origin=(0.0, 0.0, 0.0), material=pc.materials.silk)
    scene = pc.Scene(cloth, pc.Dihedral(cloth, pc.materials.silk.bending), pc.Gravity((0.0, 0.0, -9.81)))

The values are representative and rounded. They are starting points, not data of a particular fabric. Fabrics of one
name differ by a factor of two or three in each value. Real fabrics are softer in the first percent of a stretch than
beyond, and lose energy at every bend and shear. The sheets here are linear, and lose energy only by damping. The values
of rubber and steel follow from Young's modulus E, Poisson's ratio ν and the thickness h: E h/(1 − ν²), E h/2(1 + ν) and
E h³/12(1 − ν²).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from physcore.checks import number, text
from physcore.errors import SceneError


@dataclass(frozen=True)
class Material:
    """Material of a thin sheet, elastic along its threads.

        mine = pc.materials.Material(areal_density=0.2, warp=1e4, weft=5e3, shear=50.0, bending=1e-5)

    Args:
        areal_density: mass per area [kg/m²], above zero.
        warp: stiffness along the rows [N/m], the force per width and strain of a sheet at constant width; above 0.
        weft: stiffness along the columns [N/m], likewise.
        shear: shear stiffness G h [N/m], the shear force per width and angle [rad]; at least zero, and at most `warp`
            and `weft`. A lattice of springs resists stretching at least as much as shear.
        bending: bending rigidity B [N·m], at least zero: the stiffness of `Dihedral`.
        thickness: thickness h [m], at least zero; for information only, because all other values are for the whole
            sheet.
        source: source of the values.

    Raises:
        SceneError: a value is out of range or not finite.
    """

    areal_density: float
    warp: float
    weft: float
    shear: float
    bending: float
    thickness: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        for name in ("areal_density", "warp", "weft"):
            object.__setattr__(self, name, number(getattr(self, name), f"Material.{name}", above=0.0))
        for name in ("shear", "bending", "thickness"):
            object.__setattr__(self, name, number(getattr(self, name), f"Material.{name}", least=0.0))
        if self.shear > min(self.warp, self.weft):
            raise SceneError(
                f"Material.shear: must be at most warp and weft, {min(self.warp, self.weft):g} N/m, got {self.shear:g}"
            )
        object.__setattr__(self, "source", text(self.source, "Material.source"))


def _elastic(density: float, modulus: float, ratio: float, thickness: float, source: str) -> Material:
    """A sheet of an isotropic solid, from density [kg/m³], Young's modulus [Pa], Poisson's ratio and thickness [m]."""
    stretch = modulus * thickness / (1.0 - ratio * ratio)
    shear = 0.5 * modulus * thickness / (1.0 + ratio)
    return Material(
        density * thickness, stretch, stretch, shear, stretch * thickness * thickness / 12.0, thickness, source
    )


_KAWABATA = (
    "of the order that is measured by the KES-F system (S. Kawabata, The standardization and analysis of hand "
    "evaluation, 2nd ed., Textile Machinery Society of Japan 1980): a secant at its largest tension, 490 N/m"
)

silk: Final = Material(0.07, 1.5e4, 8e3, 20.0, 1.5e-6, 1e-4, f"plain weave of 16 momme; {_KAWABATA}")
"""Light silk (habutai), 0.1 mm thick."""
cotton: Final = Material(0.15, 1.5e4, 6e3, 50.0, 6e-6, 3e-4, f"plain weave for shirts; {_KAWABATA}")
"""Cotton for shirts, 0.3 mm thick."""
denim: Final = Material(
    0.4,
    1.2e4,
    8e3,
    100.0,
    2e-5,
    9e-4,
    "stretch (the mean of warp and weft), shear and bending of the order measured by KES-F on six denims, 500 gf/cm at "
    "4.7 % to 5.7 %, 1.5 to 3.4 gf/(cm·°) and 0.14 to 0.23 gf·cm²/cm: Journal of Textiles 2016, 4614168, table 5; the "
    "areal density is that of 12 oz/yd²",
)
"""Denim of 12 ounces, 0.9 mm thick."""
rubber: Final = _elastic(1000.0, 1.5e6, 0.5, 1e-3, "soft rubber, E = 1.5 MPa, of the range 1 to 5 MPa of handbooks")
"""Soft rubber, 1 mm thick, for small strains; in a spring network its Poisson's ratio is 1/4."""
steel: Final = _elastic(7850.0, 2e11, 0.3, 1e-4, "mild steel, E = 200 GPa, of any handbook")
"""Steel foil, 0.1 mm thick."""


def __dir__() -> list[str]:
    return ["Material", *(name for name, value in globals().items() if isinstance(value, Material))]

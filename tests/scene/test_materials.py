"""Materials: a cloth of springs has the mass and the elastic energies of the sheet that it stands for."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.scene.materials import Material

SHEETS = {name: value for name, value in vars(pc.materials).items() if isinstance(value, Material)}
STRAIN = 1e-4


def deformed(cloth: pc.SpringNetwork, gradient: list[list[float]]) -> float:
    """The energy of a uniform deformation x → x + G x [J]."""
    run = pc.Simulation(pc.Scene(cloth), dt=1e-9)
    run.set(positions=cloth.positions + cloth.positions @ np.array(gradient).T)
    return run.energy().by_term["springs"]


@pytest.mark.parametrize("shape", [(2, 2), (6, 4)])
@pytest.mark.parametrize("name", SHEETS)
def test_a_cloth_has_the_energies_of_its_material(name, shape):
    """½ K ε² per area where it is stretched at constant width, ½ G h γ² where it is sheared, up to a relative error of
    ε: the next terms are cubic in the strain.
    """
    sheet, spacing = SHEETS[name], 0.03
    cloth = pc.cloth(shape, spacing, material=sheet)
    area = (shape[0] - 1) * (shape[1] - 1) * spacing**2
    for gradient, stiffness in (
        ([[STRAIN, 0.0], [0.0, 0.0]], sheet.warp),
        ([[0.0, 0.0], [0.0, STRAIN]], sheet.weft),
        ([[0.0, STRAIN], [0.0, 0.0]], sheet.shear),
        ([[0.0, 0.0], [STRAIN, 0.0]], sheet.shear),
    ):
        # Rows that are turned by a shear stretch by γ²/2: K γ⁴/8 per area, little beside ½ G h γ² by K γ²/(4 G h).
        turned = (sheet.warp + sheet.weft) / sheet.shear * STRAIN**2
        assert deformed(cloth, gradient) == pytest.approx(0.5 * stiffness * STRAIN**2 * area, rel=STRAIN + turned)


@pytest.mark.parametrize("name", SHEETS)
def test_a_cloth_weighs_what_its_area_does(name):
    sheet = SHEETS[name]
    cloth = pc.cloth((5, 4), 0.5, material=sheet)
    share = np.outer([0.5, 1.0, 1.0, 0.5], [0.5, 1.0, 1.0, 1.0, 0.5]).ravel()
    assert cloth.mass == pytest.approx(sheet.areal_density * 0.25 * share, rel=1e-15)
    assert math.fsum(cloth.mass) == pytest.approx(sheet.areal_density * 4 * 3 * 0.25, rel=1e-15)


def test_a_finer_cloth_is_as_stiff():
    """Springs of a sheet have its stiffness, whatever their length: k a/a."""
    coarse, fine = (pc.cloth((n, n), 1.0 / (n - 1), material=pc.materials.cotton) for n in (3, 9))
    stretch = [[STRAIN, 0.0], [0.0, 2.0 * STRAIN]]
    assert deformed(coarse, stretch) == pytest.approx(deformed(fine, stretch), rel=1e-9)


def test_springs_at_the_border_carry_half_the_width():
    sheet = Material(1.0, 10.0, 6.0, 2.0, 0.0)
    cloth = pc.cloth((3, 3), 1.0, damping=0.1, material=sheet)
    assert cloth.stiffness.tolist() == [4, 4, 8, 8, 4, 4] + [2, 4, 2, 2, 4, 2] + [2] * 8
    assert (cloth.damping == 0.1).all()
    assert len(cloth.pairs) == 6 + 6 + 8, "and there are no bend springs"


def test_what_is_given_counts_instead_of_the_material():
    sheet = Material(1.0, 10.0, 6.0, 2.0, 0.0)
    stiff = pc.cloth((3, 3), 1.0, 5.0, material=sheet)
    assert stiff.stiffness.tolist() == [5.0] * 12 + [2.0] * 8
    assert pc.cloth((3, 3), 1.0, material=sheet, mass=0.3).mass.tolist() == [0.3] * 9
    without = pc.cloth((3, 3), 1.0, material=sheet, shear_stiffness=0.0)
    assert without.stiffness.tolist() == [5, 5, 10, 10, 5, 5, 3, 6, 3, 3, 6, 3]
    bent = pc.cloth((3, 3), 1.0, material=sheet, bend_stiffness=0.5)
    assert bent.stiffness.tolist()[20:] == [0.5] * 6
    assert pc.cloth((2, 2), 1.0, 1.0).mass.tolist() == [1.0] * 4


def test_a_cloth_of_a_material_bends_as_that_does():
    sheet = pc.materials.denim
    cloth = pc.cloth((6, 5), 0.02, origin=(0.0, 0.0, 0.0), material=sheet)
    run = pc.Simulation(pc.Scene(cloth, pc.Dihedral(cloth, sheet.bending)), dt=1e-6)
    height = 1e-3 * cloth.positions[:, 0] ** 2
    run.set(positions=cloth.positions + np.outer(height, [0.0, 0.0, 1.0]))
    # κ = 2e-3/m, in the area a² about each edge between two columns; slopes of up to 2e-4 are squared.
    assert run.energy().by_term["dihedral"] == pytest.approx(0.5 * sheet.bending * 2e-3**2 * 4 * 4 * 0.02**2, rel=1e-6)


@pytest.mark.parametrize("name", SHEETS)
def test_every_material_says_where_it_is_from(name):
    assert SHEETS[name].source
    assert 0.0 < SHEETS[name].thickness < 2e-3


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Material(0.0, 1.0, 1.0, 0.5, 0.0), "Material.areal_density: must be > 0"),
        (lambda: Material(1.0, 1.0, -1.0, 0.5, 0.0), "Material.weft: must be > 0"),
        (lambda: Material(1.0, 1.0, 1.0, 0.5, -1.0), "Material.bending: must be ≥ 0"),
        (lambda: Material(1.0, 3.0, 2.0, 2.5, 0.0), "Material.shear: must be at most warp and weft, 2 N/m, got 2.5"),
        (
            lambda: pc.cloth((3, 3), 1.0, material=Material(1.0, 3.0, 2.0, 1.0, 0.0), shear_stiffness=2.5),
            "cloth.shear_stiffness: must be at most the material's stiffness along the weft, 2 N/m, got 2.5",
        ),
    ],
)
def test_what_springs_cannot_be_is_refused(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()

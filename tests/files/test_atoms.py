"""Atoms: files written by ASE and by hand come back in SI units, and in those that are asked for."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import physcore as pc
from physcore.units import atomic_mass, elementary_charge

pytest.importorskip("ase", reason="ASE, which reads and writes atoms, is not installed")
import ase.io
import ase.units
from ase.build import bulk, molecule
from ase.calculators.lammps import convert

ANGSTROM = 1e-10
METAL = pc.units.system(length=(ANGSTROM, "Å"), time="ps", mass="u", charge="e")
TABLES = 1e-7
"""Relative difference of the constants of CODATA 2014, which ASE has, and 2018."""


def salt():
    """Sodium chloride with velocities in Å/ps, in a rectangular cell."""
    atoms = bulk("NaCl", "rocksalt", a=5.64, cubic=True).repeat((2, 1, 1))
    rng = np.random.default_rng(5)
    atoms.positions += rng.uniform(0.1, 0.3, (len(atoms), 3))
    atoms.set_velocities(rng.normal(size=(len(atoms), 3)) / (1e3 * ase.units.fs))
    return atoms


def speeds(atoms):
    """Velocities of ASE [m/s]; 1 Å/ps = 100 m/s."""
    return 100.0 * atoms.get_velocities() * 1e3 * ase.units.fs


def test_extended_xyz_of_ase_comes_back(tmp_path):
    atoms = salt()
    ase.io.write(tmp_path / "salt.xyz", atoms, format="extxyz")
    own = pc.read(tmp_path / "salt.xyz", unit="metal")
    assert isinstance(own, pc.Particles)
    assert own.species == tuple(atoms.get_chemical_symbols())
    # ASE writes eight decimals [Å].
    np.testing.assert_allclose(own.positions, ANGSTROM * atoms.positions, rtol=0.0, atol=1e-8 * ANGSTROM)
    np.testing.assert_allclose(own.velocities, speeds(atoms), rtol=0.0, atol=1e-6 * abs(speeds(atoms)).max())
    np.testing.assert_allclose(own.mass, atomic_mass * atoms.get_masses(), rtol=1e-12)
    assert own.domain == pc.Periodic((0.0,) * 3, own.domain.lengths.tolist())
    assert own.domain.lengths == pytest.approx(ANGSTROM * np.array([11.28, 5.64, 5.64]))
    np.testing.assert_array_equal(own.of("Cl"), np.flatnonzero(atoms.numbers == 17))


def test_units_can_be_those_of_atoms(tmp_path):
    atoms = salt()
    ase.io.write(tmp_path / "salt.xyz", atoms, format="extxyz")
    own = pc.read(tmp_path / "salt.xyz", unit="metal", units="metal")
    assert own.units == METAL
    np.testing.assert_allclose(own.positions, atoms.positions, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(own.mass, atoms.get_masses(), rtol=1e-12)
    scene = pc.Scene(own, own.domain, pc.LennardJones(1.0, 1.0, cutoff=2.5), units=own.units)
    assert pc.simulate(scene, 0.01, fps=200)[own].positions.shape == (3, 16, 3)


def test_extended_xyz_without_units_is_refused(tmp_path):
    ase.io.write(tmp_path / "salt.xyz", salt(), format="extxyz")
    with pytest.raises(pc.SceneError, match=r'read.unit: .*salt.xyz does not name its units; .*unit="metal"'):
        pc.read(tmp_path / "salt.xyz")
    with pytest.raises(pc.SceneError, match=r"read.unit: must be 'si', 'metal'.*did you mean 'metal'"):
        pc.read(tmp_path / "salt.xyz", unit="metall")


def test_own_exports_come_back(tmp_path):
    """A file of physcore names its units; masses, charges and velocities are in it."""
    grains = pc.Particles(np.eye(3), [0.0, 0.5, 0.0], mass=[1.0, 2.0, 3.0], charge=1e-9)
    scene = pc.Scene(grains, pc.Periodic((-1.0,) * 3, (2.0, 2.0, 3.0)), pc.ElectromagneticField((0.0, 0.0, 0.0)))
    recording = pc.simulate(scene, 1.0, fps=2)
    pc.export(recording, tmp_path / "grains.xyz")
    own = pc.read(tmp_path / "grains.xyz", frame=1)
    np.testing.assert_array_equal(own.positions, recording.positions[1])
    np.testing.assert_array_equal(own.velocities, recording.velocities[1])
    np.testing.assert_array_equal(own.mass, grains.mass)
    np.testing.assert_array_equal(own.charge, grains.charge)
    assert own.domain == scene.periodic
    assert pc.read(tmp_path / "grains.xyz", frame=-1).positions.tolist() == recording.positions[-1].tolist()
    with pytest.raises(pc.SceneError, match=r"read.frame: .* has no frame 3"):
        pc.read(tmp_path / "grains.xyz", frame=3)


@pytest.mark.parametrize("style", ["metal", "real", "si"])
def test_data_of_lammps_come_back(style, tmp_path):
    atoms = salt()
    atoms.set_initial_charges(np.where(atoms.numbers == 11, 1.0, -1.0))
    ase.io.write(
        tmp_path / "salt.data",
        atoms,
        format="lammps-data",
        units=style,
        atom_style="charge",
        masses=True,
        velocities=True,
    )
    own = pc.read(tmp_path / "salt.data", unit=style)
    np.testing.assert_allclose(own.positions, ANGSTROM * atoms.positions, rtol=TABLES, atol=1e-15)
    np.testing.assert_allclose(own.velocities, speeds(atoms), rtol=TABLES, atol=1e-6)
    np.testing.assert_allclose(own.mass, atomic_mass * atoms.get_masses(), rtol=TABLES)
    np.testing.assert_allclose(own.charge, elementary_charge * atoms.get_initial_charges(), rtol=TABLES)
    assert own.species == tuple(atoms.get_chemical_symbols())
    with pytest.raises(pc.SceneError, match=r"read.unit: .*salt.data does not name its units.*'metal'"):
        pc.read(tmp_path / "salt.data")


DATA = """LAMMPS data file via write_data, version 2 Aug 2023, timestep = 0, units = {units}

3 atoms
2 atom types
2 bonds
1 bond types

0 10 xlo xhi
-1 9 ylo yhi
0 12 zlo zhi

Masses

1 15.999
2 1.008

Atoms # full

2 1 2 0.42 1.5 1.0 1.0
1 1 1 -0.84 1.0 1.0 1.0
3 1 2 0.42 1.0 1.9 1.0

Velocities

1 0.5 0 0
2 0 1 0
3 0 0 2

Bonds

1 1 1 2
2 1 1 3
"""


def test_data_of_lammps_have_bonds_and_name_their_units(tmp_path):
    (tmp_path / "water").write_text(DATA.format(units="real"))
    own = pc.read(tmp_path / "water", ".data")
    assert own.species == ("O", "H", "H")
    assert own.bonds.tolist() == [[0, 1], [0, 2]]
    assert own.charge == pytest.approx(elementary_charge * np.array([-0.84, 0.42, 0.42]))
    assert own.velocities[0, 0] == pytest.approx(0.5e5, rel=TABLES)  # Å/fs
    assert own.domain.lower == pytest.approx((0.0, -1e-10, 0.0))
    net = pc.SpringNetwork(own.positions, own.bonds, stiffness=100.0, mass=own.mass)
    assert net.rest_length == pytest.approx([0.5e-10, 0.9e-10])


def test_numbers_without_units_remain(tmp_path):
    (tmp_path / "dust.data").write_text(DATA.format(units="lj"))
    own = pc.read(tmp_path / "dust.data")
    assert own.units.is_dimensionless
    assert own.species == ("1", "2", "2")
    np.testing.assert_allclose(own.positions, [[1, 1, 1], [1.5, 1, 1], [1, 1.9, 1]], rtol=1e-14)
    np.testing.assert_allclose(own.velocities, np.diag([0.5, 1.0, 2.0]), rtol=1e-9)  # digits of ASE's tables
    np.testing.assert_allclose(own.mass, [15.999, 1.008, 1.008], rtol=1e-14)
    scene = pc.Scene(own, own.domain, pc.ElectromagneticField((0.0, 0.0, 1.0)), units=own.units)
    assert scene.units.is_dimensionless
    with pytest.raises(pc.SceneError, match=r"read.units: .* is without units"):
        pc.read(tmp_path / "dust.data", units="metal")


DUMP = """{units}ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp ff
0 4
0 5
0 6
ITEM: ATOMS id type x y z vx vy vz{columns}
2 2 3 1 1 0 0 1{values}
1 1 1 1 1 0 2 0{values}
"""


def test_dumps_of_lammps_come_back(tmp_path):
    path = tmp_path / "run.lammpstrj"
    path.write_text(DUMP.format(units="ITEM: UNITS\nmetal\n", columns=" element q", values=" Ar 0.5"))
    own = pc.read(path)
    np.testing.assert_allclose(own.positions, ANGSTROM * np.array([[1, 1, 1], [3, 1, 1]]))
    np.testing.assert_allclose(own.velocities, 100.0 * np.array([[0, 2, 0], [0, 0, 1]]), rtol=TABLES)
    assert own.species == ("Ar", "Ar")
    assert own.charge == pytest.approx(0.5 * elementary_charge)
    assert own.domain.lengths == pytest.approx([4e-10, 5e-10, np.inf])


def test_types_without_masses_are_no_elements(tmp_path):
    path = tmp_path / "run.dump"
    path.write_text(DUMP.format(units="", columns="", values=""))
    with pytest.raises(pc.SceneError, match=r"read.masses: .*run.dump does not say what an atom '1' weighs"):
        pc.read(path, unit="metal")
    own = pc.read(path, unit="metal", masses={"1": 2e-26, "2": 3e-26})
    assert own.mass.tolist() == [2e-26, 3e-26]
    with pytest.raises(pc.SceneError, match=r"read.masses: '3' is none of the species"):
        pc.read(path, unit="metal", masses={"3": 1.0})


def test_files_of_gromacs_come_back(tmp_path):
    atoms = salt()
    ase.io.write(tmp_path / "salt.gro", atoms, format="gromacs")
    own = pc.read(tmp_path / "salt.gro")
    # Three decimals [nm], four [nm/ps].
    np.testing.assert_allclose(own.positions, ANGSTROM * atoms.positions, rtol=0.0, atol=0.51e-12)
    np.testing.assert_allclose(own.velocities, speeds(atoms), rtol=0.0, atol=0.051)
    assert own.species == tuple(atoms.get_chemical_symbols())
    with pytest.raises(pc.SceneError, match=r"read.unit: .*salt.gro has units by its format"):
        pc.read(tmp_path / "salt.gro", unit="metal")


def test_files_of_the_protein_data_bank_come_back(tmp_path):
    ethanol = molecule("CH3CH2OH")
    ase.io.write(tmp_path / "ethanol.pdb", ethanol)
    own = pc.read(tmp_path / "ethanol.pdb")
    np.testing.assert_allclose(own.positions, ANGSTROM * ethanol.positions, rtol=0.0, atol=0.51e-13)
    assert own.species == tuple(ethanol.get_chemical_symbols())
    assert own.domain is None
    assert own.mass == pytest.approx(atomic_mass * ethanol.get_masses())


def test_a_tilted_cell_is_a_warning(tmp_path):
    ase.io.write(tmp_path / "tilted.xyz", bulk("Cu"), format="extxyz")
    with pytest.warns(pc.SceneWarning, match="tilted.xyz: its cell is not rectangular"):
        assert pc.read(tmp_path / "tilted.xyz", unit="metal").domain is None


@pytest.mark.parametrize("suffix", [".xyz", ".gro", ".pdb", ".data", ".dump"])
@pytest.mark.parametrize("content", [b"", b"nonsense\n", bytes(range(256))], ids=["empty", "text", "bytes"])
def test_a_damaged_file_is_an_error_with_its_name(suffix, content, tmp_path):
    (tmp_path / f"bad{suffix}").write_bytes(content)
    options = {} if suffix in (".gro", ".pdb") else {"unit": "metal"}
    with pytest.raises((pc.FileError, pc.SceneError), match=f"bad{suffix}"):
        pc.read(tmp_path / f"bad{suffix}", **options)


def test_charges_of_lammps_are_converted():
    """The formula of the test above: ASE converts charges by the same table as lengths."""
    assert convert(1.0, "charge", "si", "ASE") == pytest.approx(1.0 / elementary_charge, rel=TABLES)


def test_an_unknown_species_is_refused(tmp_path):
    ase.io.write(tmp_path / "salt.gro", salt(), format="gromacs")
    with pytest.raises(pc.SceneError, match=r"of.species: must be one of \('Na', 'Cl'\)"):
        pc.read(tmp_path / "salt.gro").of("K")


def test_atoms_are_particles_of_scenes_files_and_copies(tmp_path):
    atoms = pc.Atoms(np.eye(3), ["O", "H", "H"], mass=[16.0, 1.0, 1.0], bonds=[[0, 1], [0, 2]], name="water")
    scene = pc.Scene(atoms, pc.Gravity((0.0, 0.0, -1.0)))
    recording = pc.simulate(scene, 0.1)
    recording.save(tmp_path / "run.npz")
    loaded = pc.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(loaded["water"].positions, recording[atoms].positions)
    (kept,) = loaded.scene.bodies
    assert type(kept) is pc.Particles
    again = pickle.loads(pickle.dumps(atoms))
    assert again.species == atoms.species
    np.testing.assert_array_equal(again.bonds, atoms.bonds)
    with pytest.raises(pc.SceneError, match=r"Atoms.species: must be 3 names"):
        pc.Atoms(np.eye(3), ["O"])
    with pytest.raises(pc.SceneError, match=r"Atoms.bonds\[0, 1\]: index 3 is outside"):
        pc.Atoms(np.eye(3), "O", bonds=[[0, 3]])

"""Trajectories in the units of programs for atoms, as ASE and MDAnalysis read them without help."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import physcore as pc
from physcore.units import atomic_mass, boltzmann_constant, electron_volt, elementary_charge

ANGSTROM = 1e-10
ROUNDED = 1e-13
"""Relative error of a conversion: a few roundings."""
TABLES = 1e-7
"""Relative difference of the constants of CODATA 2014, which ASE has, and 2018."""


@pytest.fixture(scope="module")
def argon():
    """Argon at some 100 K in a periodic cell, in SI."""
    places = pc.block((0.0,) * 3, (3 * 3.8 * ANGSTROM,) * 3, 3.8 * ANGSTROM)
    speeds = (
        np.random.default_rng(7).normal(size=places.shape) * (boltzmann_constant * 100.0 / (40 * atomic_mass)) ** 0.5
    )
    atoms = pc.Atoms(places, "Ar", speeds, mass=39.948 * atomic_mass, charge=elementary_charge)
    force = pc.LennardJones(0.0104 * electron_volt, 3.4 * ANGSTROM, cutoff=5.0 * ANGSTROM)
    domain, field = pc.Periodic((0.0,) * 3, (3 * 3.8 * ANGSTROM,) * 3), pc.ElectromagneticField((0.0, 0.0, 0.0))
    return pc.simulate(pc.Scene(atoms, force, domain, field), 2e-13, fps=1e13)


def test_ase_reads_masses_momenta_and_temperature(argon, tmp_path):
    ase_io = pytest.importorskip("ase.io", reason="ASE is not installed")
    pc.export(argon, tmp_path / "argon.xyz", units="metal")
    frames = ase_io.read(tmp_path / "argon.xyz", index=":", format="extxyz")
    assert len(frames) == 3
    for index, frame in enumerate(frames):
        assert set(frame.get_chemical_symbols()) == {"Ar"}
        np.testing.assert_allclose(frame.positions, argon.positions[index] / ANGSTROM, rtol=ROUNDED)
        np.testing.assert_allclose(frame.get_masses(), 39.948, rtol=ROUNDED)
        assert frame.info["Time"] == pytest.approx(0.1 * index)
        # Kinetic energies of frames and of the audit are at the same times here.
        assert frame.get_kinetic_energy() == pytest.approx(argon.energy.kinetic[index] / electron_volt, rel=TABLES)
        assert frame.info["kinetic"] == pytest.approx(argon.energy.kinetic[index] / electron_volt)
        assert frame.info["Temperature"] == pytest.approx(frame.get_temperature(), rel=1e-6)  # k_B changed by 6e-7
        assert frame.arrays["velo"][0] == pytest.approx(argon.velocities[index, 0] / 100.0)
        assert frame.get_charges() == pytest.approx(1.0)
        assert frame.cell.lengths() == pytest.approx([11.4] * 3)


def test_read_takes_what_export_writes(argon, tmp_path):
    pytest.importorskip("ase", reason="ASE is not installed")
    pc.export(argon, tmp_path / "argon.xyz", units="metal")
    own = pc.read(tmp_path / "argon.xyz", frame=-1)
    assert own.species == ("Ar",) * 27
    np.testing.assert_allclose(own.positions, argon.positions[-1], rtol=ROUNDED)
    np.testing.assert_allclose(own.velocities, argon.velocities[-1], rtol=ROUNDED)
    np.testing.assert_allclose(own.mass, argon.scene.bodies[0].mass, rtol=ROUNDED)
    np.testing.assert_allclose(own.charge, elementary_charge, rtol=ROUNDED)
    assert own.domain.lengths == pytest.approx(argon.scene.periodic.lengths)


@pytest.mark.parametrize(
    ("style", "length", "energy"), [("real", ANGSTROM, 6.9477e-21), ("gromacs", 1e-9, 1.66054e-21)]
)
def test_other_styles_have_their_units(argon, style, length, energy, tmp_path):
    """1 kcal/mol and 1 kJ/mol."""
    pc.export(argon, tmp_path / "argon.xyz", units=style)
    text = (tmp_path / "argon.xyz").read_text()
    kinetic = [float(each) for each in re.findall(r"kinetic=(\S+)", text)]
    assert kinetic == pytest.approx(argon.energy.kinetic / energy, rel=1e-5)
    lattice = re.search(r'Lattice="(\S+)', text)
    assert float(lattice[1]) == pytest.approx(11.4 * ANGSTROM / length)


def test_mdanalysis_opens_h5md_as_it_is(argon, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of its import
        mda = pytest.importorskip("MDAnalysis", reason="MDAnalysis is not installed")
    pytest.importorskip("h5py", reason="h5py is not installed")
    pc.export(argon, tmp_path / "argon.h5md", units="metal")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe.empty(27, trajectory=True, velocities=True)
        universe.load_new(str(tmp_path / "argon.h5md"))
        assert len(universe.trajectory) == 3
        for index, frame in enumerate(universe.trajectory):
            assert frame.time == pytest.approx(0.1 * index)  # ps
            # MDAnalysis keeps single precision.
            np.testing.assert_allclose(frame.positions, argon.positions[index] / ANGSTROM, rtol=1e-6, atol=1e-6)
            np.testing.assert_allclose(frame.velocities, argon.velocities[index] / 100.0, rtol=1e-6, atol=1e-6)
            assert frame.dimensions == pytest.approx([11.4, 11.4, 11.4, 90.0, 90.0, 90.0])
        universe.trajectory.close()


def test_h5md_in_meters_names_no_units_at_elements(argon, tmp_path):
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    for units, named in ((None, None), ("gromacs", "nm"), ("metal", "Angstrom")):
        pc.export(argon, tmp_path / "argon.h5md", units=units)
        with h5py.File(tmp_path / "argon.h5md") as file:
            assert file["particles/all/position/value"].attrs.get("unit") == named
            assert ("h5md/modules/units" in file) == (named is not None)
            energy = file["parameters/units"].attrs["energy"]
            assert energy == {None: "J", "nm": "kJ mol-1", "Angstrom": "eV"}[named]
            assert ("temperature" in file["observables"]) == (named is not None)


def test_a_system_of_units_is_converted_too(argon, tmp_path):
    units = pc.units.system(length="nm", time="ns", mass="u", charge="e")
    pc.export(argon, tmp_path / "argon.xyz", units=units)
    head = (tmp_path / "argon.xyz").read_text().splitlines()[1]
    assert 'Units="length=nm time=ns mass=u charge=e"' in head
    assert "Temperature" not in head
    kinetic = float(re.search(r"kinetic=(\S+)", head)[1])
    assert kinetic == pytest.approx(argon.energy.kinetic[0] / (atomic_mass * (1e-9 / 1e-9) ** 2))  # u·(nm/ns)²


def test_units_that_cannot_be_are_refused(argon, tmp_path):
    with pytest.raises(pc.SceneError, match=r"units: must be 'si', 'metal'.*did you mean 'metal'"):
        pc.export(argon, tmp_path / "argon.xyz", units="metall")
    bare = pc.Scene(pc.Particles([[0.0, 0.0]]), units=pc.units.dimensionless)
    with pytest.raises(pc.SceneError, match="units: must be left out"):
        pc.export(bare, tmp_path / "bare.xyz", duration=0.1, units="metal")
    pond = pc.Scene(pc.Wave(pc.Grid((4, 4), 1.0), 1.0))
    with pytest.raises(pc.SceneError, match="units: fields on grids"):
        pc.export(pond, tmp_path / "pond.pvd", duration=0.1, units="metal")


def test_atoms_have_their_species_beside_others(tmp_path):
    both = pc.Scene(pc.Atoms(np.zeros((1, 3)), "O"), pc.Particles(np.ones((1, 3))))
    pc.export(both, tmp_path / "both.xyz", duration=0.0)
    assert [line.split()[0] for line in (tmp_path / "both.xyz").read_text().splitlines()[2:]] == ["O", "X"]

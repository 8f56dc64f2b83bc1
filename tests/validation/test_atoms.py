"""Validation: a Lennard-Jones liquid keeps its energy, and has the pressure and the structure that it should have.

In reduced units: ε = σ = m = 1.
"""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation

pytestmark = [pytest.mark.validation, pytest.mark.long]


def liquid(cells: int, density: float, temperature: float, cutoff: float, dt: float) -> tuple[pc.Simulation, float]:
    """Atoms on a face-centered lattice of so many cells along each side, with no total momentum, and the side."""
    count = 4 * cells**3
    side = (count / density) ** (1.0 / 3.0)
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    basis = np.array([[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]])
    velocities = np.random.default_rng(1957).standard_normal((count, 3))
    velocities -= velocities.mean(axis=0)
    velocities *= np.sqrt(temperature * 3 * (count - 1) / (velocities**2).sum())
    atoms = pc.Particles((corners + basis).reshape(-1, 3) * (side / cells), velocities)
    law, box = pc.LennardJones(1.0, 1.0, cutoff=cutoff), pc.Periodic((0.0,) * 3, (side,) * 3)
    return simulation(pc.Scene(atoms, law, box), pc.VelocityVerlet(), dt), side


def temperature(run: pc.Simulation) -> float:
    return 2.0 * run.energy().kinetic / (3.0 * (len(run.positions) - 1))


def test_the_energy_of_a_liquid_does_not_drift(record_property):
    """A million steps of 256 atoms, in less than a minute.

    Source: public logs of LAMMPS's benchmark of the same liquid (bench/in.lj: ρ* = 0.8442, T* = 1.44 at first, cutoff
    2.5, dt* = 0.005): −4.6223613 for each atom after 100 steps and −4.6211383 after 10 000, a change of 1.2e-3.

    Here the force is shifted, so that it has no edge, and lists are made anew in time: what Verlet keeps is a constant
    (S. Toxvaerd, Phys. Rev. E 50, 2271 (1994)), from which the energy swings by order dt² and back. A slope is nothing
    but chance then, and has to lie within four of its standard errors. With n samples that know nothing of each other,
    half a time unit apart, and a swing s these are s √(12/n), 4e-6 for n = 10 000 and s = 1.1e-4.
    That is to be below a hundredth of the change above, in a hundred times as many steps.
    """
    run, _ = liquid(4, 0.8442, 1.44, 2.5, 0.005)
    atoms = len(run.positions)
    run.step(10_000)
    momentum = run.momentum()
    energies = np.empty((50, 200))
    for sample in np.ndindex(energies.shape):
        run.step(100)
        energies[sample] = run.energy().total / atoms
    millions = (np.arange(50) + 0.5) / 50.0
    (slope, _), covariance = np.polyfit(millions, energies.mean(axis=1), 1, cov=True)
    chance, swing = float(np.sqrt(covariance[0, 0])), float(energies.std())
    record_property("T*", f"{temperature(run):.3f}")
    record_property("slope per atom in 1e6 steps", f"{slope:.1e} ± {chance:.0e}")
    record_property("swing per atom", f"{swing:.1e}, {np.ptp(energies):.1e} from least to greatest")
    assert abs(slope) <= 4.0 * chance
    assert chance <= 1.2e-5
    assert np.abs(run.momentum() - momentum).max() <= 1e-10


# Source: J. K. Johnson, J. A. Zollweg, K. E. Gubbins, Mol. Phys. 78, 591 (1993), table 10: the modified equation of
# Benedict, Webb and Rubin, with the a_i and b_i of tables 5 and 6 as polynomials.
X = (
    np.nan, 0.8623085097507421, 2.976218765822098, -8.402230115796038, 0.1054136629203555, -0.8564583828174598,
    1.582759470107601, 0.7639421948305453, 1.753173414312048, 2.798291772190376e3, -4.8394220260857657e-2,
    0.9963265197721935, -3.698000291272493e1, 2.084012299434647e1, 8.305402124717285e1, -9.574799715203068e2,
    -1.477746229234994e2, 6.398607852471505e1, 1.603993673294834e1, 6.805916615864377e1, -2.791293578795945e3,
    -6.245128304568454, -8.116836104958410e3, 1.488735559561229e1, -1.059346754655084e4, -1.131607632802822e2,
    -8.867771540418822e3, -3.986982844450543e1, -4.689270299917261e3, 2.593535277438717e2, -2.694523589434903e3,
    -7.218487631550215e2, 1.721802063863269e2,
)  # fmt: skip
POWERS_A = (
    {1: 1.0, 2: 0.5, 3: 0.0, 4: -1.0, 5: -2.0}, {6: 1.0, 7: 0.0, 8: -1.0, 9: -2.0}, {10: 1.0, 11: 0.0, 12: -1.0},
    {13: 0.0}, {14: -1.0, 15: -2.0}, {16: -1.0}, {17: -1.0, 18: -2.0}, {19: -2.0},
)  # fmt: skip
POWERS_B = (
    {20: -2, 21: -3}, {22: -2, 23: -4}, {24: -2, 25: -3}, {26: -2, 27: -4}, {28: -2, 29: -3}, {30: -2, 31: -3, 32: -4},
)  # fmt: skip
"""The power of T with which each x_i enters a coefficient."""


def johnson(density: float, temperature: float) -> tuple[float, float]:
    """Pressure, and energy of interaction for each atom: a_i(T) gives the one, a_i − T da_i/dT the other."""

    def sums(powers: tuple[dict[int, float], ...], weight: float) -> list[float]:
        return [
            sum(X[i] * temperature**power * (1.0 - weight * power) for i, power in terms.items()) for terms in powers
        ]

    decay = np.exp(-3.0 * density**2)
    waning = [(1.0 - decay) / 6.0]
    for i in range(1, 6):
        waning.append(-(decay * density ** (2 * i) - 2 * i * waning[-1]) / 6.0)
    pressure = density * temperature + sum(a * density ** (i + 2) for i, a in enumerate(sums(POWERS_A, 0.0)))
    pressure += decay * sum(b * density ** (2 * i + 3) for i, b in enumerate(sums(POWERS_B, 0.0)))
    energy = sum(a * density ** (i + 1) / (i + 1) for i, a in enumerate(sums(POWERS_A, 1.0)))
    energy += sum(b * each for b, each in zip(sums(POWERS_B, 1.0), waning, strict=True))
    return float(pressure), float(energy)


# Source: Lennard-Jones fluid properties, NIST Standard Reference Simulation Website (Monte Carlo with tails):
# ρ* = 0.776, T* = 0.85, pressure 6.7714e-3 and energy −5.5121 ± 4e-4 for each atom; digits as two public repositories
# quote them.
DENSITY, HEAT = 0.776, 0.85
PRESSURE, ENERGY = 6.7714e-3, -5.5121
CUTOFF = 4.0


def distances(positions: Array, side: float) -> Array:
    """Of all pairs [σ], by the nearest image."""
    first, second = np.triu_indices(len(positions), 1)
    apart = positions[first] - positions[second]
    apart -= side * np.rint(apart / side)
    found: Array = np.sqrt((apart**2).sum(axis=1))
    return found


def test_a_liquid_has_the_pressure_and_the_energy_of_the_literature(record_property):
    """500 atoms near T* = 0.85, moved by the shifted force, with the virial and tails of the full potential.

    The motion chooses its own temperature: Johnson's equation says what that changes, block by block, since at constant
    energy what is hotter is bound more: the difference fluctuates by (1.5 + du/dT)/1.5 times as much as u. Tolerances:
    three standard errors of 20 blocks of 2 τ, which must be small enough to tell something, 0.02 of the pressure and
    0.004 of the energy. The shift of the force by 24/4⁷ = 1.5e-3 pushes alike from all sides.

    The first peak of g(r) lies between σ and the well's 2^(1/6) σ, where the fluid's pressure presses it.
    """
    run, side = liquid(5, DENSITY, 1.49, CUTOFF, 0.004)
    edges = np.arange(0.8, 3.4, 0.02)
    counts = np.zeros(len(edges) - 1)
    seen = []
    run.step(3000)
    for _ in range(400):
        run.step(25)
        r = distances(run.positions, side)
        counts += np.histogram(r, edges)[0]
        sixth = r[r < CUTOFF] ** -6.0
        energy = 4.0 * (sixth**2 - sixth).sum() / 500.0
        virial = 24.0 * (2.0 * sixth**2 - sixth).sum() / (3.0 * side**3)
        seen.append((temperature(run), virial, energy))
    means = np.reshape(seen, (20, 20, 3)).mean(axis=1)
    heat = means[:, 0].mean()
    ninth, third = CUTOFF**-9.0, CUTOFF**-3.0
    energies = means[:, 2] + 8.0 / 3.0 * np.pi * DENSITY * (ninth / 3.0 - third)
    pressures = DENSITY * means[:, 0] + means[:, 1] + 16.0 / 3.0 * np.pi * DENSITY**2 * (2.0 / 3.0 * ninth - third)
    warmer = np.array([johnson(DENSITY, each) for each in means[:, 0]])
    published = np.array([PRESSURE, ENERGY]) + warmer - johnson(DENSITY, HEAT)
    differences = np.column_stack([pressures, energies]) - published
    (pressure, energy), errors = differences.mean(axis=0), differences.std(axis=0) / np.sqrt(19.0)
    shells = 4.0 / 3.0 * np.pi * (edges[1:] ** 3 - edges[:-1] ** 3)
    function = counts / 400.0 / (shells * DENSITY * 500.0 / 2.0)
    peak = int(np.argmax(function))
    record_property("T*", f"{heat:.4f}")
    record_property("pressure", f"{pressures.mean():.3f}, less the published one: {pressure:.3f} ± {errors[0]:.3f}")
    record_property("energy", f"{energies.mean():.4f}, less the published one: {energy:.4f} ± {errors[1]:.4f}")
    record_property("first peak of g(r)", f"{function[peak]:.2f} at {edges[peak] + 0.01:.2f}")
    assert heat == pytest.approx(HEAT, abs=0.05)
    assert abs(pressure) < 3.0 * errors[0] < 0.06
    assert abs(energy) < 3.0 * errors[1] < 0.012
    assert 1.0 < edges[peak] + 0.01 < 2.0 ** (1.0 / 6.0)


def test_the_published_equation_is_consistent():
    """ρ² du/dρ = p − T dp/dT, by central differences of 1e-5, to their 1e-10 and rounding over 1e-5."""
    step, density, heat = 1e-5, 0.8, 1.2
    slope = (johnson(density + step, heat)[1] - johnson(density - step, heat)[1]) / (2.0 * step)
    warming = (johnson(density, heat + step)[0] - johnson(density, heat - step)[0]) / (2.0 * step)
    assert density**2 * slope == pytest.approx(johnson(density, heat)[0] - heat * warming, rel=1e-7)

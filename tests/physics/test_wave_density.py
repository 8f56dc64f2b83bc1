"""Waves through media of varying density: reflection, energy, limits of the step, and what stays as it was."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.errors import SceneError


def impedances(first, second):
    """Density and speed on both sides, and the coefficients of reflection and transmission of the displacement."""
    (z1, z2) = (rho * c for rho, c in (first, second))
    return (z1 - z2) / (z1 + z2), 2.0 * z1 / (z1 + z2)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ((1.0, 1.0), (4.0, 1.0)),
        ((4.0, 1.0), (1.0, 1.0)),
        ((2.0, 1.0), (1.0, 2.0)),  # equal impedances
        ((1.0, 1.0), (9.0, 1.0 / 3.0)),  # equal tensions: a string of two densities
        ((1.2e-3, 1.0), (1.0, 4.3)),  # air and water
    ],
)
@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.RungeKutta4()], ids=["VelocityVerlet", "RungeKutta4"])
def test_an_interface_reflects_by_its_impedances(first, second, integrator):
    """A Gaussian of 25 cells at 1/e: dispersion k² h²/24, and the same by the interface, are 1e-3 of it."""
    grid = pc.Grid(1000, 0.01)
    x = grid.coordinates[0]
    left, width = x < 5.0, 0.25
    rho, c = (np.where(left, one, other) for one, other in zip(first, second, strict=True))

    def shape(s):
        return np.exp(-((s / width) ** 2))

    rate = 2.0 * (x - 3.0) / width**2 * shape(x - 3.0)  # to the right, with c = 1
    item = pc.Wave(grid, c, shape(x - 3.0), rate, density=rho, edges="absorbing")
    run = pc.Simulation(pc.Scene(item), integrator=integrator, dt=0.8 * min(0.01 / c.max(), 0.01))
    run.run(3.2)
    time = run.time
    reflection, transmission = impedances(first, second)
    back = reflection * shape(x - (10.0 - 3.0 - time))
    through = transmission * shape((x - 5.0) * first[1] / second[1] + 5.0 - 3.0 - time)
    expected = np.where(left, back, through)
    assert np.abs(run[item].displacement - expected).max() < 0.02
    # The energy is divided as R² and 1 − R².
    density = rho * run[item].rate ** 2
    assert density[left].sum() / density.sum() == pytest.approx(reflection**2, abs=2e-3)


def test_the_pressure_of_sound_is_reflected_by_acoustic_impedances():
    """With 1/(ρ c²) as the density: R = (Z₂ − Z₁)/(Z₂ + Z₁) with Z = ρ c, here 1 and 6."""
    grid = pc.Grid(1000, 0.01)
    x = grid.coordinates[0]
    mass_density, c = np.where(x < 5.0, 1.0, 3.0), np.where(x < 5.0, 1.0, 2.0)
    hump = np.exp(-(((x - 3.0) / 0.25) ** 2))
    rate = 2.0 * (x - 3.0) / 0.25**2 * hump
    sound = pc.Wave(grid, c, hump, rate, density=1.0 / (mass_density * c**2), edges="absorbing")
    run = pc.Simulation(pc.Scene(sound), dt=0.004)
    run.run(3.2)
    assert run[sound].displacement[x < 4.5].max() == pytest.approx(5.0 / 7.0, abs=0.01)
    assert run[sound].displacement[x > 5.5].max() == pytest.approx(12.0 / 7.0, abs=0.02)


def noise(cells, **options):
    """A field of noise in a medium of noise."""
    rng = np.random.default_rng(5)
    grid = pc.Grid(cells, 0.1)
    speed, density = rng.uniform(0.5, 1.5, cells), 10.0 ** rng.uniform(-1.0, 1.0, cells)
    start = rng.normal(size=(2, *cells))
    return pc.Wave(grid, **{"speed": speed, "density": density, "displacement": start[0], "rate": start[1], **options})


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize(
    "integrator", [pc.VelocityVerlet(), pc.RungeKutta4(), pc.PEFRL()], ids=lambda i: type(i).__name__
)
@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_field_of_equal_densities_is_the_number_bit_for_bit(order, integrator, precision):
    runs = []
    for density in (3.0, np.full((9, 8), 3.0)):
        item = noise((9, 8), density=density, damping=0.3, order=order)
        run = pc.Simulation(pc.Scene(item), integrator=integrator, precision=precision, dt=0.02)
        run.step(40)
        runs.append((run[item].displacement, run[item].rate, vars(run.energy()), run.plan.dt_limit))
    assert all(np.array_equal(one, other) for one, other in zip(runs[0][:2], runs[1][:2], strict=True))
    assert runs[0][2:] == runs[1][2:]


def matrix(item):
    """Operator M^-1 A of a wave in 1D between fixed ends, from its definition."""
    rho, c, h = np.asarray(item.density), np.asarray(item.speed), item.grid.spacing
    stiff = rho * c**2 / h**2
    faces = 2.0 * stiff[:-1] * stiff[1:] / (stiff[:-1] + stiff[1:])
    a = np.diag(np.concatenate([[2.0 * stiff[0]], faces]) + np.concatenate([faces, [2.0 * stiff[-1]]]))
    a -= np.diag(faces, 1) + np.diag(faces, -1)
    return a, rho


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.RungeKutta4()], ids=["VelocityVerlet", "RungeKutta4"])
def test_the_limit_of_the_step_holds_the_largest_frequency(integrator):
    """The largest eigenvalue by power iteration. The bound by rows of the matrix is not far above it."""
    item = noise((40,), displacement=0.0)
    a, rho = matrix(item)
    vector = np.random.default_rng(1).normal(size=40)
    for _ in range(5000):
        vector = a @ vector / rho
        vector /= np.abs(vector).max()
    largest = float((vector @ a @ vector) / (rho @ vector**2))
    stable = {"VelocityVerlet": 2.0, "RungeKutta4": np.sqrt(8.0)}[type(integrator).__name__] / np.sqrt(largest)
    run = pc.Simulation(pc.Scene(item), integrator=integrator)
    assert 0.7 * stable < run.plan.dt_limit <= stable * (1.0 + 1e-12)
    run = pc.Simulation(pc.Scene(item), integrator=integrator, dt=0.999 * run.plan.dt_limit)
    run.step(3000)
    assert run.energy().total < 10.0 * pc.Simulation(pc.Scene(item)).energy().total


def test_the_energy_is_the_one_whose_gradient_is_the_force():
    """½ Σ h (ρ v² + u A u), from the definition."""
    item = noise((40,))
    a, rho = matrix(item)
    u, v = np.asarray(item.displacement), np.asarray(item.rate)
    energy = pc.Simulation(pc.Scene(item)).energy()
    assert energy.kinetic == pytest.approx(0.05 * (rho * v * v).sum(), rel=1e-13)
    assert energy.by_term["wave"] == pytest.approx(0.05 * u @ a @ u, rel=1e-13)
    run = pc.Simulation(pc.Scene(item), integrator=pc.RungeKutta4(), dt=1e-4)
    run.step(1)
    assert (run[item].rate - v) / 1e-4 == pytest.approx(-(a @ u) / rho - 0.5e-4 * (a @ v) / rho, rel=1e-4, abs=1e-2)


@pytest.mark.parametrize("order", [2, 4])
def test_the_energy_is_kept_to_the_order_of_the_method(order):
    """Damping and sources too are booked by cell, each with its density."""
    damped = {"damping": 0.3, "sources": pc.Source((0.4, 0.3), 5.0, 1.0), "edges": {"x": "free"}}
    for options in ({}, damped):
        item = noise((9, 8), order=order, **options)

        def drift(steps, item=item):
            run = pc.Simulation(pc.Scene(item), integrator=pc.RungeKutta4(), dt=0.4 / steps)
            start = run.energy().balance
            run.step(steps)
            return abs(run.energy().balance - start) / start

        coarse, fine = drift(40), drift(80)
        assert fine < 1e-4
        assert coarse / fine > 14.0


def test_open_edges_take_what_leaves_through_several_densities():
    grid = pc.Grid((40, 30), 0.1)
    x, y = grid.coordinates
    hump = np.exp(-((x - 2.0) ** 2 + (y - 1.5) ** 2) / 0.1)
    density = np.where(y < 1.5, 1.0, 5.0)
    item = pc.Wave(grid, 1.0, hump, density=density, edges="absorbing")
    run = pc.Simulation(pc.Scene(item), integrator=pc.RungeKutta4(), dt=0.02)
    start = run.energy()
    run.run(15.0)
    end = run.energy()
    assert end.total < 1e-4 * start.total
    assert end.balance == pytest.approx(start.balance, rel=1e-5)


def test_smooth_media_keep_order_two():
    """Coarse cells hold the means of fine ones, so that differences of solutions are of order 2 throughout."""

    def end(cells):
        grid = pc.Grid(cells, 1.0 / cells, periodic=True)
        x = 2.0 * np.pi * grid.coordinates[0]
        item = pc.Wave(grid, 1.0 + 0.3 * np.sin(x), np.cos(x), density=np.exp(np.cos(x)))
        run = pc.Simulation(pc.Scene(item), integrator=pc.RungeKutta4(), dt=0.002)
        run.run(0.6)
        return run[item].displacement.reshape(20, -1).mean(axis=1)

    coarse, middle, fine = (end(cells) for cells in (40, 80, 160))
    assert np.log2(np.abs(coarse - middle).max() / np.abs(middle - fine).max()) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize(
    ("density", "message"),
    [
        (0.0, r"Wave\.density: must be > 0, got 0"),
        (np.zeros((4, 3)), r"Wave\.density\[0, 0\]: must be > 0, got 0"),
        (np.ones(3), r"Wave\.density: must be a number, a function or an array of the shape \(4, 3\)"),
        (lambda x, y: x - 1.0, r"Wave\.density\[0, 0\]: must be > 0, got -0\.75"),
        (np.full((4, 3), np.inf), r"Wave\.density\[0, 0\]: must be finite"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_path(density, message):
    with pytest.raises(SceneError, match=message):
        pc.Wave(pc.Grid((4, 3), 0.5), 1.0, density=density)

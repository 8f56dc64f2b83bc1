"""Fluids: the same bits however a run is asked for, no push from within, and a budget that closes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array, name

SPACING = 0.05
DT = 5e-4
SLOW = pc.WeaklyCompressible(sound_speed=10.0)
VARIANCE = {2: 5.0 / 18.0, 3: 4.0 / 15.0}
"""σ² = ∫ W x² dV of Wendland's C2, in units of h²."""


def tank(sides: float = 1.0, dimension: int = 2, **numerics: object) -> pc.Simulation:
    """A column of water that falls over in a box; it names no precision, which makes it single."""
    size = (0.5 * sides, *(0.3,) * (dimension - 2), sides)
    water = pc.Fluid(pc.block((0.0,) * dimension, size, SPACING), SPACING, name="water")
    box = pc.Box((0.0,) * dimension, (2.0 * sides, *(0.3,) * (dimension - 2), 2.0 * sides))
    down = pc.Gravity((*(0.0,) * (dimension - 1), -9.81))
    return pc.Simulation(pc.Scene(water, box, down), **{"dt": DT, **numerics})


def test_water_pushes_and_rubs_in_pairs():
    """In a periodic box without walls the momentum is kept: forces cancel, and 36 neighbors' rounding is left.

    Each is at most c² ρ₀ (compression 1 %) over the spacing, per volume: ε times that per step, for every particle.
    """
    cells = pc.block((0.0, 0.0), (1.0, 1.0), SPACING)
    swirl = 0.5 * np.stack([np.sin(2 * np.pi * cells[:, 1]), np.sin(2 * np.pi * cells[:, 0])], axis=1)
    water = pc.Fluid(cells, SPACING, velocities=swirl + 0.1)
    scene = pc.Scene(water, pc.Periodic((0.0, 0.0), (1.0, 1.0)))
    run = pc.Simulation(scene, dt=DT, precision="f64", fluids=pc.WeaklyCompressible(10.0, shifting=0.0))
    before = run.momentum()
    run.step(1000)
    force = 10.0**2 * 1000.0 * 0.01 * SPACING
    motion = (water.mass[:, None] * np.abs(run.velocities)).sum()
    assert np.abs(run.momentum() - before).max() <= 1000 * EPSILON * (36 * len(cells) * force * DT + motion)
    assert run.energy().kinetic < 0.5 * (water.mass[:, None] * water.velocities**2).sum()


@pytest.mark.parametrize("diffusion", [0.0, 0.1])
def test_the_budget_closes_as_the_step_becomes_small(diffusion):
    """Kick-drift-kick is of order 2, and what the diffusion of density takes is metered over its own drift.

    Over 0.2 s: later, small differences have grown, and no two runs are the same flow.
    """
    cells = pc.block((0.0, 0.0), (1.0, 1.0), SPACING)
    swirl = 0.5 * np.stack([np.sin(2 * np.pi * cells[:, 1]), np.sin(2 * np.pi * cells[:, 0])], axis=1)
    water = pc.Fluid(cells, SPACING, velocities=swirl)
    scene = pc.Scene(water, pc.Periodic((0.0, 0.0), (1.0, 1.0)))
    method = pc.WeaklyCompressible(20.0, density_diffusion=diffusion, shifting=0.0)
    holes = []
    for dt in (1e-3, 2.5e-4):
        run = pc.Simulation(scene, dt=dt, precision="f64", fluids=method)
        before = run.energy()
        run.run(0.2)
        after = run.energy()
        holes.append(abs(after.balance - before.balance))
        assert {name for name, loss in after.dissipated_by.items() if loss != 0.0} == {"viscosity"}
        assert after.internal >= 0.0
    assert holes[0] < 1e-3 * after.dissipated
    assert np.log2(holes[0] / holes[1]) / 2.0 > 1.8


def stream(speed: float, drops: int | None = None) -> pc.Simulation:
    """Water of which all, or some drops, go at a speed, where sound has 10 m/s."""
    cells = pc.block((0.0, 0.0), (2.0, 2.0), SPACING)
    velocities = np.zeros_like(cells)
    velocities[:drops, 0] = speed
    water = pc.Fluid(cells, SPACING, velocities=velocities)
    return pc.Simulation(pc.Scene(water, pc.Periodic((0.0, 0.0), (2.0, 2.0))), fluids=SLOW)


def test_sound_is_faster_where_water_is_compressed():
    """c = c₀ (ρ/ρ₀)³ by Tait's equation with γ = 7. The limit is that of the densest water, felt by the least dense.

    The box is full, so that there is no surface, where waves are faster.
    """
    quiet = pc.WeaklyCompressible(5.0, artificial_viscosity=0.0, density_diffusion=0.0)
    water = pc.Fluid(pc.block((0.0, 0.0), (0.5, 1.0), 0.1), 0.1, viscosity=0.0)
    box, down = pc.Box((0.0, 0.0), (0.5, 1.0)), pc.Gravity((0.0, -9.81))
    run = pc.Simulation(pc.Scene(water, box, down), dt=1e-4, precision="f64", fluids=quiet)
    ratios = run[water].densities / 1000.0
    assert ratios.max() > 1.1
    scenes = [pc.Scene(water, box, *pull) for pull in ([down], [])]
    limits = [pc.stability_limit(scene, pc.VelocityVerlet(), fluids=quiet) for scene in scenes]
    assert limits[0] == pytest.approx(limits[1] * ratios.max() ** -3 * np.sqrt(ratios.min()), rel=1e-9)


def neighbors(dimension: int, h: float) -> Iterator[tuple[Array, float]]:
    """The ways to the neighbors on a lattice of unit spacing, with V |F|, F = W'/r of Wendland's C2 [1/m²].

    F is scaled so that the gradient of a linear field is exact: Σ V |F| x² = 1.
    """
    ways = np.stack(np.meshgrid(*[np.arange(-4, 5)] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    weights = np.maximum(1.0 - np.linalg.norm(ways, axis=1) / (2.0 * h), 0.0) ** 3
    weights /= (weights * ways[:, 0] ** 2).sum()
    near = weights > 0.0
    return zip(ways[near], weights[near], strict=True)


def differences(values: Array, h: float) -> Array:
    """Σ V |F| (φⱼ − φᵢ) for a field on a periodic lattice of unit spacing."""
    axes = tuple(range(values.ndim - 1))
    pairs = neighbors(len(axes), h)
    return sum((weight * (np.roll(values, -way, axis=axes) - values) for way, weight in pairs), np.zeros_like(values))


@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("dimension", [2, 3])
def test_viscosity_and_diffusion_are_those_of_the_literature(dimension):
    """Friction as J. P. Morris et al., J. Comput. Phys. 136 (1997) 214: dv/dt = 2μ/ρ Σ V |F| (vⱼ − vᵢ).

    Diffusion as D. Molteni and A. Colagrossi, Comput. Phys. Commun. 180 (2009) 861: dρ/dt = 2δhc Σ V |F| (ρⱼ − ρᵢ).

    A step at some 10 m/s moves drops by 1e-5 m and changes densities by 1e-5 of them. Their pressure so gives 1e-3 m/s²
    at most, of which half counts; friction gives 0.3 m/s².
    """
    side, h, sound, diffusion, dt = 8, 1.5, 10.0, 0.1, 1e-6
    shape = (side,) * dimension
    cells = pc.block((0.0,) * dimension, (float(side),) * dimension, 1.0)
    places = tuple(np.floor(cells).astype(int).T)
    velocities = 10.0 * np.random.default_rng(5).standard_normal(cells.shape)
    water = pc.Fluid(
        cells,
        1.0,
        density=500.0,
        velocities=velocities,
        viscosity=3.0,
    )
    method = pc.WeaklyCompressible(sound, artificial_viscosity=0.0, density_diffusion=diffusion, shifting=0.0)
    endless = pc.Periodic((0.0,) * dimension, (float(side),) * dimension)
    run = pc.Simulation(pc.Scene(water, endless), dt=dt, precision="f64", fluids=method)
    field = np.zeros((*shape, dimension))
    field[places] = velocities
    rubbed = 2.0 * 3.0 / 500.0 * differences(field, h)[places]
    run.step(1)
    pressed = (run.velocities - velocities) / dt
    assert np.abs(pressed - rubbed).max() < 2e-3 * np.abs(rubbed).max()
    densities = np.zeros((*shape, 1))
    densities[(*places, 0)] = run[water].densities
    run.set(velocities=np.zeros_like(velocities))
    run.step(1)
    evened = (run[water].densities - densities[(*places, 0)]) / dt
    expected = 2.0 * diffusion * h * sound * differences(densities, h)[(*places, 0)]
    assert np.abs(evened - expected).max() < 2e-3 * np.abs(expected).max()


@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("dimension", [2, 3])
def test_viscosity_of_several_fluids_acts_along_the_line_of_a_pair(dimension):
    """dv/dt = 2μ/ρσ² Σ V |F| (vⱼ − vᵢ)·d d, where d is the way from i to j, in two fluids that are one, as above."""
    side, h, dt = 8, 1.5, 1e-6
    cells = pc.block((0.0,) * dimension, (float(side),) * dimension, 1.0)
    places = tuple(np.floor(cells).astype(int).T)
    velocities = 10.0 * np.random.default_rng(5).standard_normal(cells.shape)
    half = len(cells) // 2
    fluids = [
        pc.Fluid(cells[part], 1.0, density=density, velocities=velocities[part], viscosity=3.0)
        for part, density in ((slice(None, half), 500.0), (slice(half, None), 500.0 + 1e-9))
    ]
    method = pc.WeaklyCompressible(10.0, artificial_viscosity=0.0, density_diffusion=0.0, shifting=0.0)
    endless = pc.Periodic((0.0,) * dimension, (float(side),) * dimension)
    run = pc.Simulation(pc.Scene(*fluids, endless), dt=dt, precision="f64", fluids=method)
    field = np.zeros((*(side,) * dimension, dimension))
    field[places] = velocities
    rubbed, axes = np.zeros_like(field), tuple(range(dimension))
    for way, weight in neighbors(dimension, h):
        rubbed += weight * ((np.roll(field, -way, axis=axes) - field) @ way)[..., None] * way
    rubbed *= 2.0 * 3.0 / 500.0 / (VARIANCE[dimension] * h**2)
    run.step(1)
    pressed = (run.velocities - velocities) / dt
    assert np.abs(pressed - rubbed[places]).max() < 2e-3 * np.abs(rubbed).max()


@pytest.mark.parametrize("free", [False, True], ids=["endless", "free"])
@pytest.mark.parametrize("integrator", [pc.SemiImplicitEuler(), pc.VelocityVerlet()], ids=name)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_limit_of_thick_water_is_that_of_the_wave_which_it_damps_most(dimension, integrator, free):
    """It is that of a drag of γ = 2μ/ρ ∫ |F| (1 − cos kx) dV, F = W'/r, where the fluid has no surface.

    With a surface, γ = 2μ/ρσ² ∫ |F| x² (1 − cos kx) dV, of a longitudinal wave. Sound is too slow to count.
    Of 48 waves up to kh = 6 the largest counts. Midpoints and 24 directions are good to 1e-3.
    """
    spacing, density, viscosity = 0.1, 500.0, 3.0
    h = 1.5 * spacing
    cosines = {2: np.cos((np.arange(400) + 0.5) * np.pi / 800), 3: (np.arange(400) + 0.5) / 400}[dimension]
    r = (np.arange(1000) + 0.5) * 2.0 / 1000  # in units of h, as far as the kernel reaches
    height, shell = {2: (1.75 / np.pi, 2.0 * np.pi * r), 3: (1.3125 / np.pi, 4.0 * np.pi * r**2)}[dimension]
    slope = 5.0 * height * (1.0 - 0.5 * r) ** 3  # Wendland's C2
    along = r[:, None] * cosines
    weights = along**2 / VARIANCE[dimension] if free else np.ones_like(along)
    waves = [(weights * (1.0 - np.cos(k * along))).mean(axis=1) for k in np.arange(1, 49) / 8.0]
    integral = max(float((slope * shell * wave).sum()) for wave in waves) * 2.0 / 1000
    damping = 2.0 * viscosity / density / h**2 * integral
    water = pc.Fluid(
        pc.block((0.0,) * dimension, (1.0,) * dimension, spacing),
        spacing,
        density=density,
        viscosity=viscosity,
    )
    method = pc.WeaklyCompressible(1e-3, artificial_viscosity=0.0, density_diffusion=0.0)
    domain = [] if free else [pc.Periodic((0.0,) * dimension, (1.0,) * dimension)]
    limit = pc.stability_limit(pc.Scene(water, *domain), integrator, fluids=method)
    dragged = pc.Scene(pc.Particles([[0.0] * dimension]), pc.Drag(linear=float(damping)))
    assert limit == pytest.approx(pc.stability_limit(dragged, integrator), rel=1e-3)


@pytest.mark.parametrize("smoothing", [1.25, 1.5, 2.0])
def test_shear_along_axes_and_diagonals_of_a_lattice_feels_one_viscosity(smoothing):
    """Forces along the line of a pair: Σ V |F| x²y²/σ² along the axes, and Σ V |F| (x² − y²)²/4σ² along the diagonals.

    Both are 1 in a continuum; with F/d² instead of F they are 0.89 and 1.11 at the default smoothing.
    """
    ways, weights = (np.array(part) for part in zip(*neighbors(2, smoothing), strict=True))
    others = ways.any(axis=1)
    (x, y), weights = ways[others].T, weights[others]
    unit = VARIANCE[2] * smoothing**2
    found = [(weights * moment).sum() / unit for moment in (x**2 * y**2, (x**2 - y**2) ** 2 / 4.0)]
    np.testing.assert_allclose(found, 1.0, atol=0.05)
    if smoothing == 1.5:
        np.testing.assert_allclose(found, [0.999, 1.047], atol=1e-3)
        monaghan = [
            (weights * moment / (x**2 + y**2)).sum() * 4.0 for moment in (x**2 * y**2, (x**2 - y**2) ** 2 / 4.0)
        ]
        np.testing.assert_allclose(monaghan, [0.89, 1.11], atol=5e-3)


def test_a_flow_that_is_fast_beside_sound_warns_once():
    """Any warning but the expected one is an error here, and so is a second one. One drop in 1600 may be fast."""
    stream(3.0, drops=1).step(1)
    stream(1.49).step(20)
    run = stream(2.0)
    with pytest.warns(pc.MachWarning, match=r"100\.0% .* faster than Mach 0\.15 where sound has 10 m/s") as caught:
        run.step(20)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    run.step(20)
    run.run(0.01)
    with pytest.warns(pc.MachWarning):
        pc.simulate(run.scene, duration=0.01, fluids=SLOW)


def test_a_tank_is_seen_with_its_fields():
    run = tank()
    assert run.plan.precision == "f32"
    assert {"neighbors", "fluid"} <= set(run.plan.stages)
    water = run["water"]
    # It starts under the weight of what is above it: ρ g h, to the density's effect on itself, some percent.
    depth = 1.0 - water.positions[:, 1]
    np.testing.assert_allclose(water.pressures, 1000.0 * 9.81 * depth, rtol=0.03)
    assert (np.diff(water.densities[np.argsort(depth)]) >= 0.0).all()

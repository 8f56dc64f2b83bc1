"""Fluids with other integrators than the default: those whose drifts and kicks take turns and go forwards."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import ALL, Array, largest_step, name, state, unwarned

FORWARD = [pc.SemiImplicitEuler(), pc.VelocityVerlet(), pc.McLachlan2()]
"""Splittings without negative substeps."""
OTHERS = [integrator for integrator in ALL if integrator not in FORWARD]
SIDE, SPACING, SOUND = 1.0, 0.1, 10.0
CARRIED = pc.WeaklyCompressible(sound_speed=SOUND, artificial_viscosity=0.02, shifting=0.0)
COUNTED = pc.WeaklyCompressible(SOUND, pc.WendlandC4(), artificial_viscosity=0.0, density_from="summation")
QUIET = {"method": COUNTED, "viscosity": 0.0}
"""A fluid whose energy is that of places and velocities alone."""


def vortices(
    integrator: pc.Integrator, dt: object = "auto", method: pc.FluidMethod = CARRIED, viscosity: float = 1e-3
) -> pc.Simulation:
    """Four vortices in a periodic box, in double precision."""
    cells = pc.block((0.0, 0.0), (SIDE, SIDE), SPACING)
    x, y = 2.0 * np.pi * cells.T
    flow = 0.5 * np.stack([np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)], axis=1)
    water = pc.Fluid(cells, SPACING, velocities=flow, viscosity=viscosity, name="water")
    scene = pc.Scene(water, pc.Periodic((0.0, 0.0), (SIDE, SIDE)))
    with unwarned():
        return pc.Simulation(scene, integrator, dt, "f64", 1, fluids=method)


def path(integrator: pc.Integrator, dt: float, **changes: object) -> Array:
    """The states at five times, and 1/1000 of the densities."""
    run = vortices(integrator, dt, **changes)
    states = []
    for _ in range(5):
        run.step(round(0.01 / dt))
        states.append(np.concatenate([state(run).ravel(), 1e-3 * run["water"].densities]))
    return np.array(states)


def measured_order(integrator: pc.Integrator, dt: float, **changes: object) -> float:
    coarse, middle, fine = (path(integrator, dt / halving, **changes) for halving in (1, 2, 4))
    return float(np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)))


@pytest.mark.parametrize("integrator", FORWARD, ids=name)
def test_a_density_that_is_carried_along_is_of_order_one(integrator, record_property):
    """As the plan says: volumes and diffusion are those of the drift's beginning. ω dt ≤ 0.04 for the fastest sound."""
    order = measured_order(integrator, 5e-4)
    record_property("order", f"{order:.3f}")
    assert vortices(integrator).plan.order == 1
    assert order == pytest.approx(1.0, abs=0.1)


STEPS = {1: 2.5e-4, 2: 1e-3, 3: 2e-3, 4: 2e-3, 5: 2e-3, 6: 5e-3}
"""ω dt from 0.02 to 0.4, and for the longest the rounding of 100 particles is still far below the error."""


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_density_that_is_counted_has_the_order_of_the_integrator(integrator, record_property):
    """Of every one, without viscosity: positions, velocities and the densities at the steps' ends."""
    plan = vortices(integrator, 1e-3, **QUIET).plan
    order = measured_order(integrator, STEPS[integrator.order], **QUIET)
    record_property("order", f"{order:.3f}")
    assert plan.order == integrator.order
    assert order == pytest.approx(integrator.order, abs=0.15)


@pytest.mark.parametrize("integrator", ALL[1:], ids=name)
def test_the_limit_of_quiet_water_is_that_of_its_fastest_wave(integrator):
    """The same ω for all: limits are to each other as those of an oscillator, which for Verlet is 2."""
    scene = vortices(pc.VelocityVerlet(), **QUIET).scene
    limits = [pc.stability_limit(scene, each, fluids=COUNTED) for each in (integrator, pc.VelocityVerlet())]
    ratio = limits[0] / limits[1]
    assert ratio == pytest.approx(largest_step(integrator) / 2.0, rel=1e-6)


def test_viscosity_brings_a_splitting_down_to_order_two():
    """Water rubs with a force that depends on velocity, which PEFRL predicts to second order."""
    assert vortices(pc.PEFRL(), **QUIET).plan.order == 4
    assert vortices(pc.PEFRL(), **{**QUIET, "viscosity": 0.1}).plan.order == 2


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_energy_of_a_counted_density_is_that_of_the_end_of_the_step(integrator):
    """A new simulation that starts there finds the same densities, but for the rounding of sums in another order."""
    run = vortices(integrator, 1e-3, **QUIET)
    run.step(7)
    cells, flow = run.positions, run.velocities
    water = pc.Fluid(cells, SPACING, velocities=flow, viscosity=0.0)
    scene = pc.Scene(water, pc.Periodic((0.0, 0.0), (SIDE, SIDE)))
    fresh = pc.Simulation(scene, pc.VelocityVerlet(), 1e-3, "f64", 1, fluids=COUNTED)
    np.testing.assert_allclose(run["water"].densities, fresh[water].densities, rtol=1e-12)


@pytest.mark.parametrize("integrator", OTHERS, ids=name)
def test_others_are_refused_with_the_reason(integrator):
    backwards = isinstance(integrator, pc.PEFRL | pc.BlanesMoan4 | pc.BlanesMoan6)
    reason = "substeps run backwards" if backwards else "density is advanced over the drifts"
    fit = r"SemiImplicitEuler\(\), VelocityVerlet\(\), McLachlan2\(\)"
    with pytest.raises(pc.SceneError, match=rf"integrator: .*{fit}.*{name(integrator)}.*{reason}"):
        vortices(integrator)


@pytest.mark.parametrize("viscosity", [0.0, 0.3])
@pytest.mark.parametrize("integrator", FORWARD, ids=name)
def test_the_limit_is_that_of_a_real_run(integrator, viscosity, record_property):
    """It is for the waves of a continuum and the fastest of all lengths. A lattice carries some of them, at rates that
    are off by some percent where the kernel is no longer than a few spacings; a run can bear more, not much less.
    """
    cells = pc.block((0.0, 0.0), (SIDE, SIDE), SPACING)
    flow = 1e-3 * np.random.default_rng(5).standard_normal(cells.shape)
    method = pc.WeaklyCompressible(SOUND, artificial_viscosity=viscosity, shifting=0.0)
    scene = pc.Scene(pc.Fluid(cells, SPACING, velocities=flow), pc.Periodic((0.0, 0.0), (SIDE, SIDE)))
    found = pc.stability_limit(scene, integrator, fluids=method, measured=True)
    record_property("measured over theory", f"{found.measured / found.theory:.3f}")
    assert 0.97 < found.measured / found.theory < 1.25


@pytest.mark.parametrize("integrator", FORWARD, ids=name)
def test_the_budget_closes_with_the_order_of_the_integrator(integrator):
    """What diffusion takes is metered over its own drift, and what viscosity takes by its own power at the kicks."""
    holes = []
    for dt in (1e-3, 2.5e-4):
        run = vortices(integrator, dt, replace(CARRIED, sound_speed=20.0))
        before = run.energy()
        run.run(0.1)
        after = run.energy()
        holes.append(abs(after.balance - before.balance))
        assert after.dissipated > 0.02 * before.kinetic
    assert np.log2(holes[0] / holes[1]) / 2.0 > integrator.order - 0.2
    assert holes[1] < 1e-3 * after.dissipated


@pytest.mark.parametrize("dt", ["auto", 2e-4], ids=["auto", "given"])
@pytest.mark.parametrize("integrator", FORWARD, ids=name)
def test_a_checkpoint_at_any_step_of_a_splash_changes_no_bit(integrator, dt, tmp_path: Path):
    """Also between the renewal of lists and the look at the surface, and where the limit is looked at next."""
    cells = pc.block((0.0, 0.3), (0.4, 0.7), 0.04)
    water = pc.Fluid(cells, 0.04, velocities=(1.0, -2.0))
    method = pc.WeaklyCompressible(sound_speed=100.0)
    scene = pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (1.0, 1.0)))
    with unwarned():
        whole = pc.Simulation(scene, integrator, dt, "f64", 1, fluids=method)
        parts = pc.Simulation(scene, integrator, dt, "f64", 1, fluids=method)
    for _ in range(20):
        whole.step(8)
        parts.step(8)
        parts.save(tmp_path / "splash.npz")
        parts = pc.load(tmp_path / "splash.npz")
    assert parts.state_hash() == whole.state_hash()

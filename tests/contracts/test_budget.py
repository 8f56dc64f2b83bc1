"""The energy budget closes: total + dissipated − work is constant up to the error of the integrator."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from contracts.scenes import SCENES, Case

FIXED = {name: case for name, case in SCENES.items() if not case.adaptive}
STEPS, SAMPLES, REFINEMENT = 16, 8, 4
UNDIVIDED = {"ripples beside a network": 4}
"""Parts of the step at which each system takes whole ones: the sizes of substeps do not follow that of the step."""


def closure(case: Case, refinement: int, precision: str) -> tuple[float, float]:
    """Root mean square of the change of the balance [J] at common times, and what rounding and a tree may add to it.

    Rounding adds an ε of the energies in every step, with random signs: five standard deviations. The phases by which a
    wave function is multiplied are rounded once, so that each of them adds the same in every step, as does
    the factor of absorption. The force of a tree is the gradient of its potential up to its error.
    """
    run = case.simulation(dt=case.dt / refinement, precision=precision)
    first = run.energy().balance
    errors, size = [], 0.0
    for _ in range(SAMPLES):
        run.step(refinement * STEPS // SAMPLES)
        energy = run.energy()
        errors.append(energy.balance - first)
        parts = (energy.kinetic, *energy.by_term.values(), energy.internal, energy.dissipated, energy.work)
        size = max(size, sum(abs(part) for part in parts))
    epsilon = float(np.finfo(precision.replace("f", "float")).eps)
    roundings = 5.0 * np.sqrt(refinement * STEPS)
    if any(isinstance(system, pc.Schrodinger) for system in run.scene.systems):
        roundings = refinement * STEPS * (run.plan.evaluations + 1) * run.scene.dimension
    return float(np.sqrt(np.mean(np.square(errors)))), (roundings * epsilon + run.plan.force_error) * size


@pytest.mark.parametrize(
    ("name", "precision"),
    [(name, precision) for name, case in FIXED.items() for precision in ("f64", "f32")[: 1 if case.is_double else 2]],
)
def test_the_budget_closes_to_the_order_of_the_integrator(name, precision, record_property):
    """A quarter of the time step leaves 4^−p of the error, and half as much again for the terms of the next orders.

    Nothing that is dissipated or put in may be missing: a part of it that the budget does not see would stay.
    """
    case = FIXED[name]
    order = case.simulation(precision=precision).plan.order
    parts = UNDIVIDED.get(name, 1)
    coarse, _ = closure(case, parts, precision)
    fine, rounding = closure(case, parts * REFINEMENT, precision)
    record_property("order", f"{np.log2(max(coarse, 1e-300) / max(fine, 1e-300)) / np.log2(REFINEMENT):.2f}")
    assert fine <= 1.5 * coarse / REFINEMENT**order + rounding


@pytest.mark.parametrize(
    "name", [name for name, case in SCENES.items() if isinstance(case.numerics.get("dt"), pc.AdaptiveStep)]
)
def test_steps_that_follow_the_motion_close_it_better_the_shorter_they_are(name):
    """A quarter of the safety makes steps a quarter as long; a quarter of the tolerance, 4^(1/5) of them at order 5.

    From half of the usual length on: there errors of first and second order may still cancel.
    """
    case = SCENES[name]
    usual = case.numerics["dt"]

    def drift(divisor: float) -> tuple[float, int]:
        tolerance = None if usual.tolerance is None else usual.tolerance / divisor**5
        run = case.simulation(dt=pc.AdaptiveStep(usual.safety / divisor, tolerance))
        first = run.energy().balance
        run.run(case.duration)
        return abs(run.energy().balance - first), run.steps

    (coarse, few), (fine, many) = drift(2.0), drift(8.0)
    assert many > few
    order = case.simulation().plan.order
    assert fine <= 1.5 * coarse * (few / many) ** order

"""Studies of scenes with several items, none of which acts on another: every item counts, scaled to its motion."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.studies.state import compared
from physcore.studies.tradeoff.chaos import twin
from physcore.studies.tradeoff.experiment import Choice, Experiment

DURATION = 2.0
SPEED = 0.25
"""Speed of a free particle [m/s], which every method advances exactly, up to rounding."""
VERLET = pc.VelocityVerlet()


def wave() -> pc.Wave:
    """The lowest mode of a square with fixed edges, in n cells of 1/n."""
    grid = pc.Grid((12, 12), 1.0 / 12)
    return pc.Wave(grid, 1.0, lambda x, y: 1e-3 * np.sin(np.pi * x) * np.sin(np.pi * y), edges="fixed", name="pond")


def free(dimension: int = 2) -> pc.Particles:
    """A free particle."""
    return pc.Particles(np.zeros((1, dimension)), velocities=[SPEED] + [0.0] * (dimension - 1))


def measured(*items: object) -> pc.Tradeoff:
    """The errors of Verlet's method at two time steps."""
    scene = pc.Scene(*items)
    return pc.tradeoff(scene, DURATION, integrators=[VERLET], precisions=["f64"], dts=[0.04, 0.02], budget=0.5)


def test_an_item_has_its_primary_field_and_bodies_have_one_together():
    still = pc.Particles([[0.0, 0.0]], fixed=True)
    nothing = pc.Tracers(np.empty((0, 2)), pc.Flow(lambda time, x: x))
    names = [channel for each in compared(pc.Scene(free(), wave(), still)) for channel in each.channels]
    assert names == ["positions", "pond.displacement"]
    assert [each.channels for each in compared(pc.Scene(still, wave(), nothing))] == [("pond.displacement",)]
    assert [each.channels for each in compared(pc.Scene(still))] == [("positions",)]


def test_the_error_of_the_second_item_decides_in_a_tradeoff():
    """The error is that of the wave, by the ratio of the largest changes: SPEED · DURATION, and crest to crest."""
    alone, both = measured(wave()), measured(free(), wave())
    distance, changed = both.experiments[0].scales
    assert distance == pytest.approx(SPEED * DURATION, rel=1e-12)
    assert changed == pytest.approx(2e-3, rel=0.05)  # from one crest to the other
    assert [row.error for row in both.rows] == pytest.approx(
        [row.error * distance / changed for row in alone.rows], rel=1e-3
    )
    assert min(row.error for row in both.rows) > 1e-6  # the particle's own is a rounding error


def test_the_order_of_items_is_that_of_their_scales():
    """Of two waves the first gives the unit: one of a tenth of the height has a tenth of the error."""
    grid = wave().grid
    small = pc.Wave(grid, 1.0, 0.1 * wave().displacement, edges="fixed", name="small")
    errors = [measured(*items).rows[0].error for items in ((wave(), small), (small, wave()))]
    assert errors[0] == pytest.approx(10.0 * errors[1], rel=1e-6)


def test_accuracy_holds_for_the_second_item():
    """1e-3 m of the particle's way of 0.5 m are 2e-3 of the wave's largest change, of crest to crest."""
    accuracy = 1e-3
    scene = pc.Scene(free(), wave())
    found = pc.simulate(scene, DURATION, fps=8, integrator=VERLET, accuracy=accuracy)
    fine = pc.simulate(scene, DURATION, fps=8, integrator=VERLET, dt=found.plan.dt / 16)
    coarse = pc.simulate(scene, DURATION, fps=8, integrator=VERLET, dt=0.05)
    largest = float(np.abs(fine["pond"].displacement - fine["pond"].displacement[0]).max())
    allowed = accuracy * largest / (SPEED * DURATION)
    errors = [float(np.abs(run["pond"].displacement - fine["pond"].displacement).max()) for run in (found, coarse)]
    assert errors[0] < allowed < errors[1]
    assert found.plan.dt < 0.05


def test_the_chaos_of_the_second_item_counts():
    scene = pc.Scene(free(3), pc.Tracers([[1.0, 1.0, 20.0]], pc.Lorenz(), name="dust"))
    experiment = Experiment(scene, 40.0)
    chaos = twin(experiment, Choice(pc.RungeKutta4(), "f64", 400), seed=0)
    assert chaos.chaotic
    assert chaos.exponent == pytest.approx(0.906, rel=0.4)
    calm = twin(Experiment(pc.Scene(free(3)), 40.0), Choice(VERLET, "f64", 4), seed=0)
    assert not calm.chaotic


def test_positions_in_a_periodic_domain_are_compared_across_its_faces_beside_a_field():
    scene = pc.Scene(free(), wave(), pc.Periodic((0.0, 0.0), (1.0, 1.0)))
    experiment = Experiment(scene, DURATION, scales=(0.5, 0.002))
    start = experiment.observe(experiment.start(Choice(VERLET, "f64", 1)))
    one, other = np.stack([start, start]), np.stack([start, start])
    one[0, 0], other[0, 0] = 0.99, 0.01
    one[1, -1] += 0.3
    assert experiment.distances(one, other) == pytest.approx([0.02, 0.3])
    heights = experiment.comparison.parts(one)[1]
    assert heights.shape == (2, 12, 12)
    assert heights[1, -1, -1] == pytest.approx(wave().displacement[-1, -1] + 0.3 * 0.002 / 0.5)

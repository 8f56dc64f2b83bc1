"""Studies compare, perturb and restore rigid bodies with their rotations, and pass the solver of contacts on."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import physcore as pc
from physcore.scene.marks import gyrations
from physcore.studies import stability
from physcore.studies.state import can_touch, compared, is_whole, nudge, restore, state

pytestmark = pytest.mark.usefixtures("clock_of_work")

DOWN = pc.Gravity((0.0, -9.81))
SWEPT = pc.ContactSolver(substeps=8, iterations=3, sequential=0)


def tumbling() -> pc.Scene:
    """A body that tumbles about its center, which does not move."""
    body = pc.RigidBody(pc.Cuboid(0.4, 0.2, 0.1), (0.0, 0.0, 0.0), angular_velocity=(0.3, 4.0, 0.5))
    return pc.Scene(body)


def pair(dimension: int) -> pc.Scene:
    """Two bodies, of which the second one is fixed."""
    shape = pc.Rectangle(0.3, 0.1) if dimension == 2 else pc.Cuboid(0.3, 0.2, 0.1)
    return pc.Scene(pc.RigidBodies(shape, [(0.0,) * dimension, (1.0,) * dimension], fixed=[1], name="pair"))


def test_a_tradeoff_compares_rotations():
    """The splitting of order 2: half the step, a quarter of the error. The center is at rest in all runs."""
    trade = pc.tradeoff(
        tumbling(), 2.0, integrators=["VelocityVerlet"], precisions=["f64"], dts=[1 / 64, 1 / 128, 1 / 256]
    )
    errors = [row.error for row in trade.rows]
    assert len(errors) == 3
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(4.0, rel=0.05)
    assert all(row.status == "ok" for row in trade.rows)


def test_a_requested_accuracy_holds_for_rotations():
    """The error of a rotation is that of points at the radius of gyration."""
    accuracy = 1e-4
    recording = pc.simulate(tumbling(), 2.0, fps=8, accuracy=accuracy, progress=False)
    exact = pc.simulate(tumbling(), 2.0, fps=8, dt=1 / 8192)
    overlap = np.abs((recording[0].orientations * exact[0].orientations).sum(axis=-1))
    angles = 2.0 * np.arccos(np.minimum(overlap, 1.0))
    # A rotation about an axis at 45° to both marks moves them by 1/√2 of the arc.
    assert angles.max() * gyrations(tumbling())[0] <= math.sqrt(2.0) * accuracy
    assert recording.plan.dt > 1 / 2048  # no finer than required: an error of 1e-6 would take 1/4000


@pytest.mark.parametrize("dimension", [2, 3])
def test_an_error_of_a_rotation_is_an_arc_at_the_radius_of_gyration(dimension):
    scene, angle = pair(dimension), 1e-3
    one, other = (pc.Simulation(scene, dt=0.01) for _ in range(2))
    (primary,) = compared(scene)
    if dimension == 2:
        other["pair"].set(angles=[angle, 0.0])
    else:
        other["pair"].set(orientations=[(math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)), (1.0, 0.0, 0.0, 0.0)])
    change = primary.difference(primary.values(other), primary.values(one))[np.newaxis]
    assert change.shape[1:] == primary.shape
    arc = 2.0 * gyrations(scene)[0] * math.sin(angle / 2)
    assert primary.distances(change)[0] == pytest.approx(arc, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_angular_velocities_are_compared_and_perturbed(dimension):
    """By those of points at the radius of gyration; fixed bodies are left alone."""
    scene = pair(dimension)
    run = pc.Simulation(scene, dt=0.01)
    (primary,) = compared(scene)
    turning = 3.0 if dimension == 2 else (0.0, 0.0, 3.0)
    run["pair"].set(angular_velocities=[turning, np.zeros_like(turning)])
    rates = primary.rates(run)
    assert np.linalg.norm(rates, axis=1).max() == pytest.approx(3.0 * gyrations(scene)[0], rel=1e-12)
    before = run["pair"].fields["angular_velocities"]
    nudge(run, [1e-3], seed=1)
    change = np.abs(run["pair"].fields["angular_velocities"] - before).reshape(2, -1)
    assert (change[0] > 0.0).all()
    assert change[0].max() < 5.0 * 1e-3 / gyrations(scene)[0]
    assert (change[1] == 0.0).all()


def test_marks_move_with_their_velocities():
    """A short step moves each compared point by its rate times the step, to second order."""
    for scene in (tumbling(), pair(2)):
        run = pc.Simulation(scene, dt=1e-6)
        if len(scene.bodies[0]) == 2:
            run["pair"].set(velocities=[(1.0, 2.0), (0.0, 0.0)], angular_velocities=[5.0, 0.0])
        (primary,) = compared(scene)
        before, rates = primary.values(run), primary.rates(run)
        run.step(1)
        np.testing.assert_allclose(primary.values(run) - before, 1e-6 * rates, rtol=0.0, atol=1e-11)


def test_a_state_holds_rotations():
    scene = pair(3)
    run = pc.Simulation(scene, dt=0.01)
    run["pair"].set(angular_velocities=[(1.0, 2.0, 3.0), (0.0, 0.0, 0.0)])
    run.step(50)
    kept, hashed = state(run), run["pair"].fields
    run.step(50)
    restore(run, kept)
    for name, values in hashed.items():
        np.testing.assert_allclose(run["pair"].fields[name], values, rtol=1e-14, atol=1e-15)


def test_what_remembers_more_than_its_state_is_not_started_anew():
    bars = pc.RigidBodies(pc.Rectangle(0.4, 0.1), [(0.2, 0.0), (0.6, 0.0)])
    hinges = [pc.Hinge((bars, 0), None, (0.0, 0.0)), pc.Hinge((bars, 1), (bars, 0), (0.4, 0.0))]
    assert is_whole(pc.Scene(bars, *hinges, DOWN))
    weak = pc.Hinge((bars, 1), (bars, 0), (0.4, 0.0), breaking_force=100.0)
    assert not is_whole(pc.Scene(bars, hinges[0], weak, DOWN))


def test_only_motion_without_impacts_is_taken_to_be_smooth():
    bars = pc.RigidBodies(pc.Rectangle(0.4, 0.1), [(0.2, 0.0), (0.6, 0.0)])
    alone = pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.2, 0.0))
    pin, stop = pc.Hinge(alone, None, (0.0, 0.0)), pc.Hinge(alone, None, (0.0, 0.0), lower=-0.5)
    ends = (bars, 0), (bars, 1)
    assert not can_touch(pc.Scene(alone, pin))
    assert can_touch(pc.Scene(alone, stop))
    assert not can_touch(pc.Scene(bars, pc.Hinge(*ends, (0.4, 0.0))))
    assert can_touch(pc.Scene(bars, pc.SpringJoint(*ends, None, 10.0)))
    assert can_touch(pc.Scene(bars))
    assert can_touch(pc.Scene(alone, pc.Particles([[2.0, 0.0]])))


def test_the_solver_of_contacts_reaches_every_run(monkeypatch):
    """Those that measure a limit of stability, and those that find how far items move."""
    bar = pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.2, 0.0))
    scene = pc.Scene(bar, pc.SpringJoint(bar, None, [(0.4, 0.0), (0.4, 1.0)], 100.0), pc.Particles([[9.0, 0.0]]), DOWN)
    given = []

    class Watched(pc.Simulation):
        def __init__(self, *arguments: object, **numerics: object) -> None:
            given.append(numerics.get("contacts"))
            super().__init__(*arguments, **numerics)

    monkeypatch.setattr(stability, "Simulation", Watched)
    monkeypatch.setattr("physcore.studies.tradeoff.comparison.Simulation", Watched)
    monkeypatch.setattr("physcore.studies.tradeoff.experiment.Simulation", Watched)
    pc.stability_limit(scene, "VelocityVerlet", contacts=SWEPT, measured=True)
    pc.tradeoff(scene, 0.1, integrators=["VelocityVerlet"], dts=[1 / 64], contacts=[SWEPT], budget=0.5)
    assert len(given) > 3
    assert set(given) == {SWEPT}
    with pytest.raises(pc.SceneError, match="contacts: there are no rigid bodies"):
        pc.stability_limit(pc.Scene(pc.Particles([[0.0, 0.0]])), "VelocityVerlet", contacts=SWEPT)


def test_rows_show_the_methods_of_fluids_and_of_contacts():
    trade = pc.tradeoff(tumbling(), 0.1, dts=[1 / 64], contacts=[SWEPT], budget=0.5)
    fluids = pc.WeaklyCompressible(shifting=6.0)
    both = replace(trade, rows=tuple(replace(row, fluids=fluids) for row in trade.rows))
    assert list(both.rows[0].methods) == ["fluids", "contacts"]
    for text in (str(both), both._repr_html_()):
        assert "WeaklyCompressible(shifting=6.0)" in text
        assert "ContactSolver(substeps=8, iterations=3, sequential=0)" in text
    html = both._repr_html_()
    heads = html[html.index("<thead>") : html.index("</thead>")].count("<th>")
    first = html[html.index("<tbody>") :].split("</tr>")[0]
    assert heads == first.count("<td>") == 11
    assert "fluids" in html
    assert "contacts" in html


def test_chaotic_bodies_are_started_anew_from_a_reference():
    """Discs in a box, by elastic impacts: errors over short windows."""
    places = [(0.3 + 0.4 * (k % 3), 0.3 + 0.4 * (k // 3)) for k in range(9)]
    speeds = np.random.default_rng(2).normal(size=(9, 2))
    discs = pc.RigidBodies(pc.Disc(0.12), places, velocities=speeds, friction=0.0, restitution=1.0)
    scene = pc.Scene(discs, pc.Box((0.0, 0.0), (1.4, 1.4)))
    solver = pc.ContactSolver(sequential=0)
    options = {"integrators": ["VelocityVerlet"], "precisions": ["f64"], "dts": [1 / 64], "contacts": [solver]}
    trade = pc.tradeoff(scene, 3.0, budget=0.3, **options)
    assert trade.measure == "restart"
    (row,) = trade.rows
    assert row.bias is not None
    assert 0.0 < row.error < math.inf

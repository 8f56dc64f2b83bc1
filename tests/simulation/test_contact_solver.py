"""The solver of contacts is given beside the scene, saved, stated in the plan, and compared."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import physcore as pc
from contracts.rigid_scenes import heap

COUNT = 12
SWEPT = pc.ContactSolver(substeps=8, iterations=3, sequential=4)
LONELY = pc.Scene(pc.Particles([[0.0, 0.0]]))


def after(steps: int = 60, scene: pc.Scene | None = None, **numerics: object) -> pc.Simulation:
    run = pc.Simulation(scene or heap(COUNT), dt=1 / 240, **numerics)
    run.step(steps)
    return run


def test_a_large_group_is_swept_and_a_small_one_is_not():
    assert (
        after(contacts="auto").state_hash() == after().state_hash() == after(contacts=pc.ContactSolver()).state_hash()
    )
    large = after(contacts=pc.ContactSolver(sequential=COUNT - 1))
    assert large.state_hash() != after().state_hash()
    # A group of as many bodies as that is none of the large ones, whose parts then do not matter.
    assert after(contacts=pc.ContactSolver(9, 5, sequential=COUNT)).state_hash() == after().state_hash()
    assert large.state_hash() != after(contacts=pc.ContactSolver(8, sequential=COUNT - 1)).state_hash()
    assert large.state_hash() != after(contacts=pc.ContactSolver(iterations=4, sequential=COUNT - 1)).state_hash()


def tower(count: int = 8) -> pc.Scene:
    boxes = pc.RigidBodies(pc.Rectangle(0.2, 0.2), [(0.0, 0.1 + 0.2 * k) for k in range(count)], friction=0.5)
    return pc.Scene(boxes, pc.Floor(0.0, friction=0.5), pc.Gravity((0.0, -9.81)))


def test_a_tower_sinks_by_the_square_of_the_substeps():
    """Contacts that overlap are springs of a period of four substeps: depths are weights over k ~ m/τ². A half is for
    sweeps, which only come near. Where contacts are solved to rounding nothing sinks.
    """

    def sunk(**options: int) -> float:
        run = after(240, tower(), contacts=pc.ContactSolver(**options))
        return float(np.abs(run[0].positions[:, 1] - tower().bodies[0].positions[:, 1]).max())

    assert sunk(sequential=8) < 1e-12
    depths = [sunk(substeps=substeps, sequential=0) for substeps in (1, 4, 8)]
    assert depths[0] > 1e-5
    assert depths[1] < 1.5 * depths[0] / 16.0
    assert depths[2] < 1.5 * depths[1] / 4.0


@pytest.mark.parametrize("start", np.linspace(0.0, 1.0, 6, endpoint=False))
def test_a_body_of_a_large_group_bounces_wherever_in_a_step_it_meets_the_floor(start):
    """A disc at 2 m/s, whose gap closes in each of the four parts of a step of 2/256 m."""
    disc = pc.RigidBody(pc.Disc(0.1), (0.0, 0.3 + start * 2.0 / 256.0), velocity=(0.0, -2.0), restitution=0.75)
    run = pc.Simulation(
        pc.Scene(disc, pc.Floor(0.0, restitution=0.0)), dt=1 / 256, contacts=pc.ContactSolver(sequential=0)
    )
    run.step(77)
    assert run[disc].velocities[0, 1] == pytest.approx(1.5, rel=1e-12)
    # The impact takes place at the end of a part: the disc waits there for less than a part.
    bounced = float(run[disc].positions[0, 1]) - 0.1
    exact = 1.5 * (run.time - 0.1 - start / 256.0)
    assert exact - 1.5 / 1024 - 1e-12 <= bounced <= exact + 1e-12


def test_an_elastic_gas_of_a_large_group_keeps_its_energy():
    places = [(0.3 + 0.4 * (k % 3), 0.3 + 0.4 * (k // 3)) for k in range(9)]
    speeds = np.random.default_rng(2).normal(size=(9, 2))
    discs = pc.RigidBodies(pc.Disc(0.12), places, velocities=speeds, friction=0.0, restitution=1.0)
    scene = pc.Scene(discs, pc.Box((0.0, 0.0), (1.4, 1.4)))
    energy = pc.simulate(scene, 3.0, fps=4, dt=1 / 256, contacts=pc.ContactSolver(sequential=0)).energy
    np.testing.assert_allclose(energy.kinetic, energy.kinetic[0], rtol=1e-12)
    assert energy.dissipated[-1] <= 1e-12 * energy.kinetic[0]


def test_the_plan_states_how_large_groups_are_taken():
    (note,) = [note for note in after(0, contacts=SWEPT).plan.notes if note.startswith("rigid bodies: ")]
    assert note.endswith("groups of more than 4 in 8 substeps with 3 iterations")
    assert "groups" not in str(after(0).plan)


def test_a_solver_is_saved_pickled_and_kept_in_a_changed_scene(tmp_path):
    run = after(10, contacts=SWEPT)
    run.save(tmp_path / "run.npz")
    others = [pc.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))]
    run.step(10)
    for other in others:
        other.step(10)
        assert other.state_hash() == run.state_hash()
        assert other.provenance == run.provenance
    fields = {"substeps": 8, "iterations": 3, "sequential": 4}
    assert run.provenance.numerics["contacts"] == {"kind": "ContactSolver", "fields": fields}
    assert "contacts" not in pc.Simulation(LONELY).provenance.numerics
    run.replace(pc.Scene(*run.scene.bodies, *run.scene.boundaries, pc.Gravity((0.0, -5.0))))
    assert run.provenance.numerics["contacts"] == {"kind": "ContactSolver", "fields": fields}


def test_solvers_of_the_same_parameters_are_equal():
    assert pc.ContactSolver(4, 2, 32) == pc.ContactSolver() != SWEPT
    assert len({pc.ContactSolver(), pc.ContactSolver(), SWEPT}) == 2


def test_solvers_are_compared_in_a_tradeoff():
    trade = pc.tradeoff(heap(5), 0.1, dts=[1 / 320], contacts=[SWEPT, "auto", pc.ContactSolver()], budget=0.5)
    assert list(dict.fromkeys(row.contacts for row in trade.rows)) == [SWEPT, pc.ContactSolver()]  # in both precisions
    assert "ContactSolver(substeps=8, iterations=3, sequential=4)" in str(trade)
    for row in trade.rows:
        assert row.numerics["contacts"] == row.contacts
        pc.Simulation(heap(5), **row.numerics).step(1)
    assert pc.tradeoff(heap(5), 0.1, dts=[1 / 320], budget=0.5).rows[0].contacts is None


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.ContactSolver(substeps=0), r"ContactSolver.substeps: must be ≥ 1, got 0"),
        (lambda: pc.ContactSolver(iterations=1.5), r"ContactSolver.iterations: must be a whole number, got 1.5"),
        (lambda: pc.ContactSolver(sequential=-1), r"ContactSolver.sequential: must be ≥ 0, got -1"),
        (lambda: after(0, contacts=8), r"contacts: must be a ContactSolver\(…\) or 'auto', got 8"),
        (lambda: after(0, contacts=pc.ContactSolver), r"contacts: .*; write ContactSolver\(\)"),
        (lambda: after(0, LONELY, contacts=SWEPT), "contacts: there are no rigid bodies in this scene"),
        (lambda: pc.tradeoff(LONELY, 0.1, contacts=["auto"]), "contacts: there are no rigid bodies in this scene"),
        (lambda: pc.tradeoff(heap(2), 0.1, contacts=[]), "contacts: must not be empty"),
        (lambda: pc.tradeoff(heap(2), 0.1, contacts=[1]), r"contacts\[0\]: must be a ContactSolver"),
    ],
)
def test_what_is_no_solver_is_refused(make, message):
    with pytest.raises(pc.SceneError, match=message):
        make()

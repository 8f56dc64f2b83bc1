"""The diagnosis of rigid bodies: overlaps at the start, sinking and jitter are found, and sound scenes are silent."""

from __future__ import annotations

import importlib
import re

import numpy as np
import pytest

import physcore as pc
from physcore.simulation.notes import material_drift
from physcore.simulation.overlapping import overlaps

SIDE = 0.2
REACH = SIDE / np.sqrt(2.0)
"""Half the diagonal of a box, its size [m]."""
FLOOR = pc.Floor(0.0, restitution=0.0, friction=0.5)
pytestmark = pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")


def symptoms(run: pc.Recording | pc.Simulation) -> dict[str, pc.Finding]:
    return {finding.symptom: finding for finding in pc.diagnose(run)}


def tower(count: int, overlap: float = 0.0) -> pc.Scene:
    heights = [(0.5 + k) * SIDE - (k + 1) * overlap for k in range(count)]
    boxes = pc.RigidBodies(pc.Rectangle(SIDE, SIDE), [(0.0, y) for y in heights], friction=0.5, name="tower")
    return pc.Scene(boxes, FLOOR, pc.Gravity())


def solver(finding: pc.Finding) -> pc.ContactSolver:
    """The solver that a cure names."""
    given = re.search(r"pc\.ContactSolver\(([^)]*)\)", finding.cure)
    assert given is not None
    return pc.ContactSolver(sequential=0, **{name: int(value) for name, value in re.findall(r"(\w+)=(\d+)", given[1])})


def test_overlaps_have_the_depth_that_geometry_gives():
    """Of two boxes, a box that is turned by 45°, and the floor; bodies that are apart have none."""
    boxes = pc.RigidBodies(pc.Rectangle(SIDE, SIDE), [(0.0, 0.1), (0.0, 0.3), (1.0, 0.2)], name="boxes")
    scene = pc.Scene(boxes, FLOOR)
    turned = [0.0, 0.0, np.pi / 4]
    frames = {
        "rigid_positions": np.array([[(0.0, 0.09), (0.0, 0.28), (1.0, 0.13)], [(0.0, 0.1), (0.0, 0.5), (1.0, 0.2)]]),
        "angles": np.array([turned, turned]),
    }
    first, second = overlaps(scene, frames)
    found = {(each.one, each.other): each for each in first}
    assert set(found) == {
        ("bodies['boxes'][0]", "bodies['boxes'][1]"),
        ("bodies['boxes'][0]", "boundaries[0]"),
        ("bodies['boxes'][2]", "boundaries[0]"),
    }
    depths = [each.depth for each in found.values()]
    assert sorted(depths) == pytest.approx(sorted([0.01, 0.01, REACH - 0.13]), rel=1e-9)
    assert [each.size for each in found.values()] == pytest.approx([REACH] * 3)
    assert [each for each in second if each.depth > 1e-12] == []


@pytest.mark.parametrize("dimension", [2, 3])
def test_joined_bodies_do_not_overlap(dimension):
    shape = pc.Rectangle(0.4, 0.1) if dimension == 2 else pc.Cuboid(0.4, 0.1, 0.1)
    turns = {"angles": np.zeros((1, 2))} if dimension == 2 else {"orientations": np.tile([1.0, 0, 0, 0], (1, 2, 1))}
    rest = (0.0,) * (dimension - 1)
    bars = pc.RigidBodies(shape, [(0.0, *rest), (0.3, *rest)])
    fields = {"rigid_positions": bars.positions[np.newaxis], **turns}
    pin = pc.BallJoint((bars, 0), (bars, 1), (0.15, *rest))
    assert overlaps(pc.Scene(bars, pin), fields) == [[]]
    (alone,) = overlaps(pc.Scene(bars), fields)
    assert [each.depth for each in alone] == pytest.approx([0.1], rel=1e-9)


@pytest.mark.filterwarnings("ignore:.* overlaps .* at the start by:physcore.SceneWarning")
@pytest.mark.parametrize("overlap", [0.0, 1e-3])
def test_bodies_that_overlap_at_the_start_are_found(overlap):
    """Of a run ahead and of one that is recorded."""
    scene = tower(3, overlap)
    for run in (pc.Simulation(scene), pc.simulate(scene, 0.5, dt=1 / 240)):
        found = symptoms(run)
        assert set(found) == ({"overlaps"} if overlap else set())
        if overlap:
            assert found["overlaps"].measured == pytest.approx(overlap / REACH, rel=1e-9)
            assert "0.001 m" in found["overlaps"].cure


@pytest.mark.filterwarnings("ignore:.* overlaps .* at the start by:physcore.SceneWarning")
def test_later_states_are_no_starts():
    run = pc.Simulation(tower(3, 1e-3), dt=1 / 240)
    run.step(1)
    assert "overlaps" not in symptoms(run)


@pytest.mark.parametrize("substeps", [2, 5])
def test_a_tower_that_is_not_solved_for_sinks(substeps):
    """The lowest contact of 20 boxes bears 19 of them: its overlap falls with the square of the substeps.

    Boxes that sink tilt, so that corners are a little deeper than centers.
    """
    sunk = pc.simulate(tower(20), 2.0, dt=1 / 60, contacts=pc.ContactSolver(substeps=substeps, sequential=0))
    found = symptoms(sunk)
    assert ("sinks" in found) == (substeps == 2)
    if "sinks" in found:
        boxes = sunk["tower"].positions[-1]
        deepest = np.append(SIDE - np.diff(boxes[:, 1]), SIDE / 2 - boxes[0, 1]).max()
        assert found["sinks"].measured == pytest.approx(deepest / REACH, rel=0.15)
        cured = pc.simulate(tower(20), 2.0, dt=1 / 60, contacts=solver(found["sinks"]))
        assert pc.diagnose(cured) == ()


def test_a_state_that_has_sunk_is_found_in_a_run():
    run = pc.Simulation(tower(20), dt=1 / 60, contacts=pc.ContactSolver(substeps=2, sequential=0))
    assert "sinks" not in symptoms(run)
    run.run(2.0)
    assert "sinks" in symptoms(run)


def hopping(restitution: float) -> pc.Scene:
    """A disc that falls by 3 mm, again and again if impacts are elastic, in 49 ms."""
    disc = pc.RigidBody(pc.Disc(0.1), (0.0, 0.103), restitution=restitution, name="disc")
    return pc.Scene(disc, pc.Floor(0.0, restitution=restitution), pc.Gravity())


def test_a_body_that_hops_in_place_jitters():
    found = symptoms(pc.simulate(hopping(1.0), 2.0, dt=1 / 120))
    assert set(found) == {"jitters"}
    assert "'disc'" in found["jitters"].cause
    assert found["jitters"].measured > 0.35
    cured = re.search(r"restitution of (\S+) or less", found["jitters"].cure)
    assert cured is not None
    assert pc.diagnose(pc.simulate(hopping(float(cured[1])), 2.0, dt=1 / 120)) == ()


def test_bodies_in_motion_do_not_jitter():
    """A pendulum, a wheel that spins fast in place, and a ball that bounces high."""
    rod = pc.RigidBody(pc.Rectangle(0.05, 0.4), (0.0, 1.0), 0.0, angular_velocity=4.0)
    wheel = pc.RigidBody(pc.Disc(0.2), (2.0, 1.0), angular_velocity=47.0)
    ball = pc.RigidBody(pc.Disc(0.1), (4.0, 1.0), restitution=0.9)
    joints = pc.Hinge(rod, None, (0.0, 1.2)), pc.Hinge(wheel, None, (2.0, 1.0))
    scene = pc.Scene(rod, wheel, ball, *joints, pc.Floor(0.0), pc.Gravity())
    assert pc.diagnose(pc.simulate(scene, 3.0, dt=1 / 240)) == ()


def test_a_pile_at_rest_is_well():
    """By sweeps, although the energy of its motion is next to nothing at the end."""
    rng = np.random.default_rng(1)
    places = [(0.15 + 0.25 * (k % 6) + 0.01 * rng.normal(), 0.2 + 0.25 * (k // 6)) for k in range(40)]
    heap = pc.RigidBodies(pc.Disc(0.1), places)
    scene = pc.Scene(heap, pc.Box((0.0, 0.0), (1.6, 4.0), restitution=0.0), pc.Gravity())
    assert pc.diagnose(pc.simulate(scene, 3.0, dt=1 / 120)) == ()


@pytest.mark.filterwarnings("error")
def test_a_stack_that_settles_by_less_than_is_seen_is_no_drift():
    """Of a group that is swept; the balance drifts by a multiple of the energy of its motion. A pendulum's swing of
    the same energy, on a joint, is measured.
    """
    recording = pc.simulate(tower(40), 1.0, dt=1 / 240)
    assert recording.energy.material_drift > 0.5
    assert material_drift(recording) == 0.0
    assert pc.diagnose(recording) == ()
    rod = pc.RigidBody(pc.Rectangle(0.05, 0.4), (0.0, 1.0), angular_velocity=0.05)
    swing = pc.simulate(pc.Scene(rod, pc.Hinge(rod, None, (0.0, 1.2)), pc.Gravity()), 1.0, dt=1 / 60)
    assert material_drift(swing) == swing.energy.material_drift > 0.0


@pytest.mark.parametrize(
    ("name", "part"), [("cradle", 0.3), ("dominoes", 0.2), ("wrecking_ball", 0.2), ("galton", 0.1)]
)
def test_demos_of_rigid_bodies_are_well(name, part):
    shown = importlib.import_module(f"physcore.gallery.{name}")
    duration = part * shown.DURATION
    assert pc.diagnose(pc.simulate(shown.scene(), duration, fps=40 / duration, dt=1 / 480)) == ()

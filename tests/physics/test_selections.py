"""Forces on some particles of a body: those of the scene in which these particles are a body of their own."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import simulation

COUNT = 9


def particles(seed: int, part: Any = slice(None), charge: float = 0.0) -> pc.Particles:
    """Charged particles of some size in random motion in 3D, or some of them."""
    rng = np.random.default_rng(seed)
    x, v = rng.uniform(-0.5, 0.5, (COUNT, 3)), rng.normal(size=(COUNT, 3))
    mass, sign = rng.uniform(0.5, 2.0, COUNT), rng.choice([-charge, charge], COUNT)
    return pc.Particles(x[part], v[part], mass[part], sign[part], radius=0.2)


FORCES: dict[str, Callable[[Any], pc.Force]] = {
    "gravity": lambda on: pc.Gravity((0.3, -2.0, 1.0), on=on),
    "gravity in time": lambda on: pc.Gravity(lambda t: (0.3, -2.0, 1.0 + t), on=on),
    "drag": lambda on: pc.Drag(0.3, 0.2, (1.0, 0.0, -1.0), on=on),
    "center": lambda on: pc.CentralForce((0.1, 0.0, 0.2), 2.0, exponent=-2.0, softening=0.1, on=on),
    "field": lambda on: pc.ElectromagneticField((1e4, 0.0, 0.0), (0.0, 0.0, 1e5), on=on),
    "field of a function": lambda on: pc.ElectromagneticField(lambda t, x: 1e5 * x, on=on),
    "function": lambda on: pc.CustomForce(lambda t, x, v: -x - 0.1 * v, on=on),
    "spheres": lambda on: pc.SoftSpheres(50.0, 0.5, 0.2, on=on),
    "atoms": lambda on: pc.LennardJones(1.0, 0.3, on=on),
    "gravitation": lambda on: pc.Gravitation(0.5, 0.1, on=on, sources=on),
    "charges": lambda on: pc.Coulomb(softening=0.1, on=on, sources=on),
}
"""Forces on what `on` names."""
CHARGED = ("field", "field of a function", "function", "charges")
"""Those that may act on charges."""


@pytest.mark.parametrize("name", FORCES)
@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), mask=st.lists(st.booleans(), min_size=COUNT, max_size=COUNT).filter(any))
def test_some_particles_feel_what_they_would_as_a_body(name, seed, mask):
    """Sums over pairs have another order, with rounding of 1e-13 of accelerations up to 1e3 m/s² in 1 ms. The other
    particles fly straight on.
    """
    chosen, force = np.array(mask), FORCES[name]
    charge = 1e-5 if name in CHARGED else 0.0
    whole, apart, rest = (particles(seed, part, charge) for part in (slice(None), chosen, ~chosen))
    part = simulation(pc.Scene(whole, force((whole, chosen))), pc.RungeKutta4(), 1e-4)
    split = simulation(pc.Scene(apart, rest, force(apart)), pc.RungeKutta4(), 1e-4)
    for run in (part, split):
        run.step(10)
    size = np.abs(split.velocities).max()
    for own, other in ((chosen, split[apart]), (~chosen, split[rest])):
        np.testing.assert_allclose(part.positions[own], other.positions, rtol=0, atol=1e-13 * size)
        np.testing.assert_allclose(part.velocities[own], other.velocities, rtol=0, atol=1e-13 * size)
    np.testing.assert_array_equal(part.velocities[~chosen], whole.velocities[~chosen])
    energies = [run.energy() for run in (part, split)]
    for name in ("total", "work", "dissipated"):
        found, expected = (getattr(energy, name) for energy in energies)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * energies[1].kinetic)


@pytest.mark.parametrize(
    "index",
    [2, -7, [-7], slice(2, 3), np.arange(COUNT) == 2, np.array([2], np.uint8), range(2, 3), (2,)],
    ids=repr,
)
def test_indices_are_those_of_numpy(index):
    body = particles(0)
    given, expected = (pc.Scene(body, pc.Gravity((0.0, 0.0, -1.0), on=(body, each))) for each in (index, [2]))
    assert given.hash() == expected.hash()
    assert given.forces == expected.forces
    assert hash(given.forces[0]) == hash(expected.forces[0])
    assert given.members(given.forces[0]).tolist() == [k == 2 for k in range(COUNT)]


def test_all_particles_of_a_body_are_the_body():
    body = particles(0)
    for index in (slice(None), np.ones(COUNT, bool), range(COUNT)):
        assert pc.Gravity(on=(body, index)) == pc.Gravity(on=body)
    named = pc.Scene(pc.Particles([[0.0, 0.0]], name="ball"), pc.Gravity(on=("ball", 0)))
    assert named.forces[0].targets() == named.bodies


def test_names_lists_and_sources_select_too():
    """A comet between two stars of a binary, of which one attracts it; and what is named in a list."""
    stars = pc.Particles([[-1.0, 0.0], [1.0, 0.0]], name="stars")
    comet = pc.Particles([[0.0, 1.0]], name="comet")
    pull = pc.Gravitation(1.0, on=["comet", ("stars", [0])], sources=("stars", [1]))
    run = pc.Simulation(pc.Scene(stars, comet, pull), pc.SemiImplicitEuler(), 1e-3)
    run.step()
    expected = np.array([[0.25, 0.0], [0.0, 0.0], [0.5**1.5, -(0.5**1.5)]]) * 1e-3
    np.testing.assert_allclose(run.velocities, expected, rtol=1e-12)
    scene = run.scene
    assert scene.members(scene.forces[0]).tolist() == [True, False, True]
    assert scene.members(scene.forces[0], "sources").tolist() == [False, True, False]
    assert scene.targets(scene.forces[0]) == (comet, stars)


def test_files_pickles_and_reprs_have_the_particles(tmp_path):
    body = particles(3, charge=1e-5)
    forces = [
        force(("cloud", [1, 4, 5])) for name, force in FORCES.items() if "function" not in name and "time" not in name
    ]
    named = pc.Particles(body.positions, body.velocities, body.mass, body.charge, 0.2, name="cloud")
    run = pc.Simulation(pc.Scene(named, *forces), dt=1e-3)
    run.step(5)
    run.save(tmp_path / "run.npz")
    loaded, copied = pc.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run.scene))
    assert loaded.scene.hash() == copied.hash() == run.scene.hash()
    assert run.scene.hash() != pc.Scene(named, *forces[1:], pc.Gravity((0.3, -2.0, 1.0), on=("cloud", [1, 4]))).hash()
    for each in (run, loaded):
        each.step(20)
    assert loaded.state_hash() == run.state_hash()
    assert "on=((Particles('cloud', 9 particles in 3D), [1, 4, 5]),)" in repr(run.scene.forces[0])


def test_faces_and_edges_of_a_part_are_those_within_it():
    """Wind and bending of the left half of a cloth, as if it were a cloth of its own."""
    sheet = pc.cloth((6, 4), 0.1, 10.0, origin=(0.0, 0.0, 0.0))
    columns = np.arange(24) % 6
    rng = np.random.default_rng(1)
    bumps = rng.uniform(-0.02, 0.02, (24, 3))
    body = pc.SpringNetwork(sheet.positions + bumps, [], 0.0, faces=sheet.faces)
    inner = np.cumsum(columns < 3) - 1
    kept = (columns < 3)[sheet.faces].all(axis=1)
    half = pc.SpringNetwork(body.positions[columns < 3], [], 0.0, faces=inner[sheet.faces[kept]])
    for force in (lambda on: pc.Wind((3.0, 1.0, 4.0), on=on), lambda on: pc.Dihedral(on, 0.1)):
        whole = simulation(pc.Scene(body, force((body, columns < 3))), pc.VelocityVerlet(), 1e-3)
        alone = simulation(pc.Scene(half, force(half)), pc.VelocityVerlet(), 1e-3)
        for run in (whole, alone):
            run.set(positions=run.positions + 0.01 * np.sin(50.0 * run.positions))
            run.step(10)
        np.testing.assert_allclose(whole.positions[columns < 3], alone.positions, rtol=0, atol=1e-13)
        assert whole.energy().total == pytest.approx(alone.energy().total, rel=1e-11)


BODY, OTHER = particles(0), particles(1)
WATER = pc.Fluid(pc.block((0.0, 0.0), (0.4, 0.4), 0.1), 0.1)
SHEET = pc.cloth((3, 3), 0.1, 10.0, origin=(0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Gravity(on=(BODY, 9)), "Gravity.on: index 9 is outside of Particles(9 particles in 3D)"),
        (lambda: pc.Gravity(on=[OTHER, (BODY, [0, -10])]), "Gravity.on[1]: index -10 is outside of Particles"),
        (lambda: pc.Gravity(on=(BODY, [1, 2, -8])), "Gravity.on: selects particle 1 of Particles(9"),
        (lambda: pc.Gravity(on=[(BODY, [1]), (BODY, [1])]), "Gravity.on[1]: names particle 1 of Particles"),
        (lambda: pc.Gravity(on=[BODY, (BODY, [1])]), "Gravity.on[1]: names particle 1 of Particles"),
        (lambda: pc.Gravity(on=[BODY, BODY]), "Gravity.on[1]: names particle 0 of Particles"),
        (lambda: pc.Gravity(on=(BODY, [])), "Gravity.on: must select at least one particle of Particles"),
        (lambda: pc.Gravity(on=(BODY, slice(4, 4))), "Gravity.on: must select at least one particle of Particles"),
        (lambda: pc.Gravity(on=(BODY, np.zeros(9, bool))), "Gravity.on: must select at least one particle"),
        (lambda: pc.Gravity(on=(BODY, np.ones(8, bool))), "must have 9 entries, got 8"),
        (lambda: pc.Gravity(on=(BODY, [0.0, 1.0])), "Gravity.on: must select particles by an integer, a slice"),
        (lambda: pc.Gravity(on=(BODY, 1.0)), "Gravity.on: must select particles by an integer, a slice"),
        (lambda: pc.Gravity(on=(BODY, True)), "Gravity.on: must select particles by an integer, a slice"),
        (lambda: pc.Gravity(on=(BODY, [[0, 1]])), "Gravity.on: must select particles by an integer, a slice"),
        (lambda: pc.Gravity(on=(BODY, slice("a"))), "Gravity.on: must be a slice of whole numbers"),
        (lambda: pc.Gravity(on=(BODY, 2**70)), "Gravity.on: must select particles by an integer, a slice"),
        (lambda: pc.Gravity(on=(BODY, np.uint64(2**63))), "Gravity.on: index 9223372036854775808 is beyond"),
        (lambda: pc.Gravity(on=(BODY, None)), "Gravity.on: must select particles by an integer, a slice"),
        (lambda: pc.Gravity(on=(1.0, [0])), "Gravity.on: must be a body, its name, or several"),
        (lambda: pc.Scene(BODY, pc.Gravity(on=("bal", [0]))), "forces[0].on: nothing is called 'bal'"),
        (lambda: pc.Scene(pc.Particles([[0, 0]], name="a"), pc.Drag(1.0, on=("a", 1))), "[0].on: index 1 is outside"),
        (lambda: pc.Scene(BODY, pc.Gravity(on=(OTHER, [0]))), "is not in the scene; add it as an item too"),
        (lambda: pc.Scene(WATER, pc.Gravity(on=(WATER, [0]))), "forces[0].on: must be the whole fluid"),
        (lambda: pc.Scene(SHEET, pc.Wind((1.0, 0.0, 0.0), on=(SHEET, [0, 1]))), "[0].on: must have all three corners"),
        (lambda: pc.Dihedral((SHEET, [0, 1, 3]), 1.0), "Dihedral.on: must have the four corners of two faces"),
        (lambda: pc.Floor(on=(BODY, [0])), "Floor.on: must be a body, its name, or several"),
        (lambda: pc.SelfContact(SHEET, 0.01, on=(SHEET, [0])), "SelfContact.on: must be a body, its name, or several"),
    ],
)  # fmt: skip
def test_mistakes_are_named(build, message):
    with pytest.raises(pc.SceneError, match=re.escape(message)):
        build()

"""The tree of gravitation and of Coulomb's law: the exact sum beside it, its order, its symmetries, and its plan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation

SOFTENING = 0.05


def cloud(count: int, dimension: int, seed: int = 1) -> Array:
    """Places, most of them about the middle."""
    return 0.3 * np.random.default_rng(seed).normal(size=(count, dimension))


def kick(scene: pc.Scene, **numerics: object) -> Array:
    """The accelerations of particles at rest: an explicit step of 1 s changes v by exactly a."""
    run = simulation(scene, pc.ExplicitEuler(), 1.0, on_divergence="ignore", **numerics)
    run.step(1)
    return run.velocities


def energy(scene: pc.Scene) -> float:
    """The potential energy at the start."""
    return simulation(scene, pc.VelocityVerlet(), 1.0).energy().potential


def rms(vectors: Array) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))


def scaled(scene: pc.Scene, length: float, mass: float) -> pc.Scene:
    """The same stars at `length` times the distances, with `mass` times the masses."""
    (body,), (force,) = scene.bodies, scene.forces
    assert isinstance(body, pc.Particles)
    assert isinstance(force, pc.Gravitation)
    return pc.Scene(
        pc.Particles(length * body.positions, mass=mass * body.mass), replace(force, softening=length * force.softening)
    )


def stars(count: int = 900, dimension: int = 3, **options: object) -> pc.Scene:
    mass = np.random.default_rng(2).uniform(0.5, 1.5, count) / count
    return pc.Scene(pc.Particles(cloud(count, dimension), mass=mass), pc.Gravitation(1.0, SOFTENING, **options))


def ions(count: int = 900, dimension: int = 3, **options: object) -> pc.Scene:
    """Charges of both signs: the total of many cells is nearly zero, their dipoles are not."""
    charge = np.random.default_rng(2).uniform(-1.0, 1.0, count)
    return pc.Scene(pc.Particles(cloud(count, dimension), charge=charge), pc.Coulomb(1.0, SOFTENING, **options))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("scene", [stars, ions])
def test_the_error_falls_with_the_third_power_of_the_opening_angle(scene, dimension):
    """The first term that is left out of a cell's field is that of its octupoles, (s/d)³; those of many cells add at
    random, and fewer cells are large. Wrong quadrupoles would leave (s/d)², wrong dipoles s/d.

    Potentials err by no more than fields, whose octupoles are four times theirs; the energy is of both signs for
    charges, so that its error is compared with the energy of all pairs without their signs.
    """
    exact, body = kick(scene(3000, dimension)), scene(3000, dimension).bodies[0]
    weights = body.mass if scene is stars else np.abs(body.charge)
    size = abs(energy(pc.Scene(pc.Particles(body.positions, mass=weights), pc.Gravitation(1.0, SOFTENING))))
    errors = []
    for angle in (0.3, 0.6):
        tree = scene(3000, dimension, opening_angle=angle)
        errors.append(rms(kick(tree) - exact) / rms(exact))
        assert abs(energy(tree) - energy(scene(3000, dimension))) < errors[-1] * size
    assert 2.0**2.5 < errors[1] / errors[0] < 2.0**5.0
    assert errors[1] < 2e-3


@pytest.mark.parametrize("softening", [0.0, 0.7])
@pytest.mark.parametrize("total", [1.0, 0.0], ids=["charged", "neutral"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_small_cell_errs_like_the_cube_of_its_size(dimension, total, softening):
    """A cluster of charges of the size r, seen from d = 1 and more: field and potential of its octupoles are left out,
    r³, and the power of its moving charges to r². Halving r divides them by 8 and 4, but for the next order, r ≤ 1/16.
    """
    rng = np.random.default_rng(3)
    charge = rng.uniform(-1.0, 1.0, 12)
    charge += (total - charge.sum()) / 12
    shape, motion = rng.uniform(-1.0, 1.0, (12, dimension)), rng.uniform(-1.0, 1.0, (12, dimension))
    places = 1.5 * np.eye(dimension)[0] + rng.uniform(-0.5, 0.5, (40, dimension))

    def errors(size: float) -> Array:
        found = []
        for angle in (0.0, 0.5):
            cluster = pc.Particles(size * shape, motion, charge=charge)
            probes = pc.Particles(places, charge=1.0)
            scene = pc.Scene(cluster, probes, pc.Coulomb(1.0, softening, angle, on=probes, sources=cluster))
            run = simulation(scene, pc.ExplicitEuler(), 1.0, on_divergence="ignore")
            assert run.plan.pairs == (40 if angle else 40 * 12)
            start = run.energy().potential
            run.step(1)
            found.append((run.velocities[12:], start, run.energy().work))
        (felt, before, work), (cell, approximate, power) = found
        return np.array([rms(cell - felt), abs(approximate - before), abs(power - work)])

    large, small = errors(1.0 / 16.0), errors(1.0 / 32.0)
    np.testing.assert_allclose(np.log2(large / small), [3.0, 3.0, 2.0], atol=0.5)


@pytest.mark.parametrize("scene", [stars, ions])
@pytest.mark.parametrize("dimension", [2, 3])
def test_single_precision_errs_by_rounding(dimension, scene):
    """The cells are the same but for rounding at their edges, and each term is off by some ε."""
    tree = scene(2000, dimension, opening_angle=0.6)
    one, other = kick(tree, precision="f32"), kick(tree, precision="f64")
    assert rms(one - other) < 1e-5 * rms(other)


def test_scaling_by_powers_of_two_scales_the_bits():
    """Lengths by 8 and masses by 4: accelerations by 1/16, without any rounding."""
    tree = stars(opening_angle=0.7)
    np.testing.assert_array_equal(16.0 * kick(scaled(tree, 8.0, 4.0)), kick(tree))


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_order_of_the_stars_does_not_matter(dimension):
    """Each is summed along the curve through all, wherever it stands in the arrays."""
    tree = stars(dimension=dimension, opening_angle=0.7)
    body, order = tree.bodies[0], np.random.default_rng(5).permutation(900)
    shuffled = pc.Scene(pc.Particles(body.positions[order], mass=body.mass[order]), *tree.forces)
    np.testing.assert_array_equal(kick(shuffled), kick(tree)[order])


def test_momentum_is_kept_to_the_force_error():
    """|Σ m Δa| ≤ √(Σ m²) √(Σ Δa²): the exact forces cancel. The error is measured on all of them."""
    tree = stars(opening_angle=0.8)
    mass, felt = tree.bodies[0].mass, kick(tree)
    error = simulation(tree, pc.VelocityVerlet(), 1.0).plan.force_error
    # The plan's figure is over the rms of the exact accelerations, of which these are (1 ± error).
    bound = np.sqrt((mass**2).sum()) * np.sqrt((felt**2).sum()) * error / (1.0 - error)
    assert np.linalg.norm(mass @ felt) <= bound


def test_charges_of_no_total_pull_by_their_dipole():
    """Pairs of opposite charges far from each other: without their dipoles cells would have no field at all."""
    ends = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]])
    far = np.array([[3.0, 0.0, 0.0], [3.0, 0.1, 0.0]])
    scene = [
        pc.Scene(pc.Particles(np.vstack([ends, far]), charge=[1.0, -1.0, 1.0, 1.0]), pc.Coulomb(1.0, 0.0, angle))
        for angle in (0.0, 0.5)
    ]
    exact, tree = (kick(each) for each in scene)
    # The quadrupole of two opposite charges about their middle is 0; octupoles are (0.005/3)² of the dipole.
    assert rms(tree[2:] - exact[2:]) < 1e-4 * rms(exact[2:])


@pytest.mark.parametrize("law", ["on", "sources", "fixed"])
def test_targets_sources_and_fixed_bodies_are_those_that_are_named(law):
    def scene(angle: float) -> pc.Scene:
        fixed = [0, 5] if law == "fixed" else None
        one = pc.Particles(cloud(500, 3), mass=1.0 / 500, fixed=fixed)
        other = pc.Particles(cloud(300, 3, seed=9) + 0.4, mass=1.0 / 300)
        chosen = {} if law == "fixed" else {law: one}
        return pc.Scene(one, other, pc.Gravitation(1.0, SOFTENING, angle, **chosen))

    exact, tree = kick(scene(0.0)), kick(scene(0.5))
    assert rms(tree - exact) < 2e-3 * rms(exact)
    np.testing.assert_array_equal(tree == 0.0, exact == 0.0)
    assert energy(scene(0.5)) == pytest.approx(energy(scene(0.0)), rel=1e-4)


def test_the_work_of_one_sided_sources_is_that_of_the_exact_sum():
    rng = np.random.default_rng(7)
    one = pc.Particles(cloud(800, 3), rng.normal(size=(800, 3)), mass=1.0 / 800)
    other = pc.Particles(cloud(200, 3, seed=9) + 0.4, mass=1.0)
    works = []
    for angle in (0.0, 0.5):
        scene = pc.Scene(one, other, pc.Gravitation(1.0, SOFTENING, angle, sources=one))
        run = simulation(scene, pc.VelocityVerlet(), 1e-3)
        run.step(3)
        works.append(run.energy().work)
    # The power is expanded to one order less than the field: (s/2d)² of each cell's part, which have both signs.
    assert works[1] == pytest.approx(works[0], rel=1e-2)


def test_the_plan_tells_the_error_and_the_interactions(tmp_path):
    """Of up to 1000 stars it is the rms error of all."""
    exact, tree = stars(), stars(opening_angle=0.7)
    felt = kick(exact)
    run = simulation(tree, pc.VelocityVerlet(), 0.01)
    assert run.plan.force_error == pytest.approx(rms(kick(tree) - felt) / rms(felt), rel=1e-9)
    assert 900 < run.plan.pairs < 900**2
    assert "rms error" in str(run.plan)
    plain = simulation(exact, pc.VelocityVerlet(), 0.01).plan
    assert (plain.force_error, plain.pairs) == (0.0, 900**2)
    assert "rms error" not in str(plain)
    run.step(3)
    run.save(tmp_path / "run.physcore")
    loaded = pc.load(tmp_path / "run.physcore")
    assert (loaded.plan.force_error, loaded.plan.pairs) == (run.plan.force_error, run.plan.pairs)
    run.step(3)
    loaded.step(3)
    np.testing.assert_array_equal(loaded.positions, run.positions)


def test_an_automatic_angle_has_the_error_that_is_wished():
    """At least 0.8 of it where the curve has no jump; the exact sum where it is not worth a tree."""
    for wished in (1e-3, 1e-4):
        plan = simulation(stars(4000, opening_angle="auto", force_error=wished), pc.VelocityVerlet(), 0.01).plan
        assert 0.7 * wished < plan.force_error <= wished
        assert plan.pairs < 0.7 * 4000**2
    few = simulation(stars(20, opening_angle="auto"), pc.VelocityVerlet(), 0.01).plan
    assert (few.force_error, few.pairs) == (0.0, 20**2)
    fine = simulation(stars(opening_angle="auto", force_error=1e-13), pc.VelocityVerlet(), 0.01).plan
    assert (fine.force_error, fine.pairs) == (0.0, 900**2)


def test_the_automatic_step_is_that_of_the_exact_sum():
    """The tide of cells by their total alone errs like (s/d)², and little of the largest tide is theirs."""
    limits = [simulation(stars(opening_angle=angle), pc.VelocityVerlet(), 0.01).plan.dt_limit for angle in (0.0, 0.6)]
    assert limits[1] == pytest.approx(limits[0], rel=0.02)


@pytest.mark.parametrize("angle", [1e-300, 0.5, 2.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_bodies_anywhere_are_summed(dimension, angle):
    """In one place, on a line, one alone, far from all others; cells that contain a target are never taken whole."""
    line = np.linspace(0.0, 1.0, 300)[:, None] * np.eye(dimension)[0]
    lone = np.vstack([cloud(200, dimension), np.full((1, dimension), 1e12)])
    for places in (np.ones((3000, dimension)), line, line[:1], line[:2], lone, np.repeat(line[:3], 500, axis=0)):
        body = pc.Particles(places)
        exact = kick(pc.Scene(body, pc.Gravitation(1.0, 0.1)))
        tree = kick(pc.Scene(body, pc.Gravitation(1.0, 0.1, angle)))
        # No nearer than its size a cell errs at most like the monopole of its bodies: of the order of their pull.
        assert np.abs(tree - exact).max() <= 0.5 * np.abs(exact).max()
        if angle < 1.0:
            assert rms(tree - exact) <= 1e-2 * rms(exact)


@pytest.mark.parametrize("dimension", [2, 3])
def test_stars_far_from_a_cluster_do_not_coarsen_its_tree(dimension):
    """By keys of 2²¹ or 2³¹ cells along the whole scene the cluster would be one leaf, and all of its pairs summed."""
    cluster = cloud(2000, dimension)
    far = np.array([1e8, 1e10])[:, None] * np.eye(dimension)[0]
    law = pc.Gravitation(1.0, SOFTENING, 0.8)
    alone, beside = (
        simulation(pc.Scene(pc.Particles(places), law), pc.VelocityVerlet(), 1.0).plan.pairs
        for places in (cluster, np.vstack([cluster, far]))
    )
    # Each star is a leaf beside the cluster, whose average leaf has by its charge 0.1 % more; each sees a few cells.
    assert beside == pytest.approx(alone + 2 * 2000, rel=0.02)


def test_the_plan_counts_the_memory_of_the_tree():
    """Of each star at least its key, its record, its sums and its place, of 16, 64, 48 and 4 bytes."""
    exact, tree = (simulation(stars(2000, opening_angle=angle), pc.VelocityVerlet(), 1.0).plan for angle in (0.0, 0.7))
    assert 2000 * 132 < tree.memory - exact.memory < 2000 * 200


def test_coincident_particles_are_named_where_there_is_no_softening():
    places = np.concatenate([cloud(70, 2), [[0.3, 0.4]], [[0.3, 0.4]]])
    scene = pc.Scene(pc.Particles(places), pc.Gravitation(1.0, opening_angle=1.0))
    with pytest.raises(pc.SceneError, match=r"forces\[0\].*particles 70 and 71 both at \[0.3, 0.4\] m.*softening"):
        simulation(scene, pc.VelocityVerlet(), 0.01).step(1)


def test_bodies_that_leave_the_range_of_numbers_are_reported():
    motion = np.zeros((300, 3))
    motion[7] = 1e30
    body = pc.Particles(cloud(300, 3), motion)
    run = simulation(pc.Scene(body, pc.Gravitation(1.0, 0.1, 0.5)), pc.VelocityVerlet(), 1e10, precision="f32")
    with pytest.raises(pc.SimulationDiverged):
        run.step(3)


def test_an_opening_angle_is_a_number_or_automatic():
    for law in (pc.Gravitation, pc.Coulomb):
        with pytest.raises(pc.SceneError, match=rf"{law.__name__}\.opening_angle"):
            law(opening_angle=-0.1)
        with pytest.raises(pc.SceneError, match=rf"{law.__name__}\.opening_angle"):
            law(opening_angle="wide")
        with pytest.raises(pc.SceneError, match=rf"{law.__name__}\.force_error"):
            law(opening_angle="auto", force_error=0.0)

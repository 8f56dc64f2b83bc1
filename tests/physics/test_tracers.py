"""Tracers in flows: orders, symmetries, what vortices conserve, limits, divergence, and what is refused."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

import physcore as pc
from contracts.transforms import flow_in_python
from physcore.integrators import INTEGRATORS
from physcore.systems.flows import FLOWS

FIRST_ORDER = [kind for kind in INTEGRATORS if kind.advances("Tracers")]
READY = [kind for kind in FLOWS if kind is not pc.Flow]
START = np.array([[0.3, -0.2, 0.4], [-0.5, 0.1, 0.7], [0.2, 0.6, -0.3]])
PAIR = ([[0.0, 0.0], [1.0, 0.0]], [2.0, 1.0])


def end(scene: pc.Scene, integrator: Any, dt: float, steps: int, **numerics: Any) -> np.ndarray:
    """The positions of all points after some steps."""
    run = pc.Simulation(scene, integrator, dt=dt, **{"precision": "f64", **numerics})
    run.step(steps)
    return np.concatenate([run[system].positions for system in scene.systems])


def vortices(**options: Any) -> pc.PointVortices:
    """Four vortices, which is the fewest whose motion is chaotic."""
    centers = [[0.0, 0.0], [1.0, 0.0], [0.3, 1.1], [-0.8, 0.5]]
    return pc.PointVortices(centers, [1.0, 2.0, -1.0, 1.5], **options)


def swirl() -> pc.Scene:
    four = vortices()
    return pc.Scene(pc.Tracers([[0.4, 0.3], [-1.0, -1.0], [2.0, 0.1]], four), four)


SCENES = {kind.__name__: (lambda kind=kind: pc.Scene(pc.Tracers(START, kind()))) for kind in READY} | {
    "vortices": swirl
}


@pytest.mark.parametrize("integrator", FIRST_ORDER)
@pytest.mark.parametrize("name", SCENES)
def test_errors_fall_by_the_order_of_the_integrator(name, integrator):
    """Over 4/|∇v| in 64 and 128 steps, where terms of the next order are below a tenth; the reference has 2000."""
    scene = SCENES[name]()
    duration = 40.0 * pc.Simulation(scene).plan.dt_limit
    exact = end(scene, pc.DormandPrince5(), duration / 2000, 2000)
    coarse, fine = (np.linalg.norm(end(scene, integrator(), duration / steps, steps) - exact) for steps in (64, 128))
    assert fine > 1e-13
    assert math.log2(coarse / fine) == pytest.approx(integrator.order, abs=0.3)


@pytest.mark.parametrize("kind", READY)
def test_velocities_are_those_of_the_formula(kind):
    """A few roundings of terms of some 10 m/s; the sine of Thomas' flow is good to 2 ulp."""
    dust = pc.Tracers(5.0 * START, kind())
    run = pc.Simulation(pc.Scene(dust), precision="f64")
    np.testing.assert_allclose(run[dust].velocities, flow_in_python(kind())(0.0, 5.0 * START), rtol=0.0, atol=1e-13)


def test_a_function_of_the_same_operations_gives_the_same_bits():
    def lorenz(time: float, place: np.ndarray) -> np.ndarray:
        x, y, z = place.T
        return np.column_stack([10.0 * (y - x), x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z])

    for integrator in FIRST_ORDER:
        ready, own = (
            end(pc.Scene(pc.Tracers(START, flow)), integrator(), 0.01, 200) for flow in (pc.Lorenz(), pc.Flow(lorenz))
        )
        np.testing.assert_array_equal(ready, own)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_mirrored_tracers_stay_mirror_images_to_the_bit(precision):
    """(x, y, z) → (−x, −y, z) is a symmetry of Lorenz' flow and of rounding, wherever a tracer stands in a register."""
    half = np.array([0.0, 0.0, 25.0]) + np.random.default_rng(2).normal(size=(101, 3))
    dust = pc.Tracers(np.vstack([half, half[::-1] * (-1.0, -1.0, 1.0)]), pc.Lorenz())
    final = end(pc.Scene(dust), pc.RungeKutta4(), 0.01, 3000, precision=precision)
    np.testing.assert_array_equal(final[:101], final[101:][::-1] * (-1.0, -1.0, 1.0))
    assert np.ptp(final[:, 0]) > 15.0


@pytest.mark.parametrize(
    ("flow", "divergence"), [(pc.Lorenz(), -41.0 / 3.0), (pc.Thomas(), -3 * 0.208186), (pc.Halvorsen(), -3 * 1.89)]
)
def test_volumes_shrink_by_the_divergence_of_the_flow(flow, divergence):
    """The matrix of differences over 2ε is off by ε² of third derivatives, and by 1e-16/ε of rounding."""
    corners = pc.Tracers(START[0] + 1e-4 * np.vstack([np.eye(3), -np.eye(3)]), flow)
    moved = end(pc.Scene(corners), pc.RungeKutta4(), 1e-3, 300)
    assert np.linalg.det((moved[:3] - moved[3:]) / 2e-4) == pytest.approx(math.exp(0.3 * divergence), rel=1e-5)


@pytest.mark.parametrize("core", [0.0, 0.5])
def test_two_vortices_turn_about_their_center_and_what_stands_with_them_turns_along(core):
    """With d² + δ² in the place of d². The tips of equilateral triangles on two vortices move with them (Gröbli 1877),
    at any core, because all distances are the same. After a turn all are where they were.
    """
    pair = pc.PointVortices(*PAIR, core)
    marks = pc.Tracers([[0.5, math.sqrt(0.75)], [0.5, -math.sqrt(0.75)]], pair)
    period = 4.0 * math.pi**2 * (1.0 + core**2) / 3.0
    start = np.concatenate([pair.centers, marks.positions])
    missed = [
        np.abs(end(pc.Scene(pair, marks), pc.RungeKutta4(), period / steps, steps) - start).max()
        for steps in (100, 200)
    ]
    assert missed[0] < 1e-5
    assert math.log2(missed[0] / missed[1]) == pytest.approx(4.0, abs=0.5)


def test_vortices_keep_their_hamiltonian_and_the_moments_of_their_circulation():
    """The moments are linear and quadratic sums, with an error of the step's order, 1e-12 at a distance of 1."""
    four = vortices()
    gamma = four.circulations
    recording = pc.simulate(pc.Scene(four), 10.0, fps=5, dt=0.01, integrator=pc.DormandPrince5())
    p, (i, j) = recording[four].positions, np.triu_indices(4, 1)
    apart = np.linalg.norm(p[:, i] - p[:, j], axis=2)
    hamiltonian = -(gamma[i] * gamma[j] * np.log(apart)).sum(axis=1) / (2.0 * math.pi)
    budget = recording.budgets["hamiltonian"]
    np.testing.assert_allclose(budget.total, hamiltonian, rtol=0.0, atol=1e-14)
    assert budget.unit == "m⁴/s²"
    assert np.abs(budget.drift).max() < 1e-11
    assert np.ptp(gamma @ p, axis=0).max() < 1e-12
    assert np.ptp((p**2).sum(axis=2) @ gamma) < 1e-11


def test_a_vortex_that_is_set_supplies_its_hamiltonian():
    four = vortices()
    run = pc.Simulation(pc.Scene(four), dt=0.01)
    run.step(10)
    before = run.budgets()["hamiltonian"]
    run[four].set(positions=2.0 * four.centers)
    after = run.budgets()["hamiltonian"]
    assert after.total != pytest.approx(before.total)
    assert after.balance == pytest.approx(before.balance, rel=1e-14)
    assert after.supplied == pytest.approx(after.total - before.total)


def test_the_limit_is_a_tenth_of_the_inverse_gradient_at_the_tracers():
    """|∇v| of the formulas by central differences over 2e-5 m, off by some 1e-9; dt="auto" is half of the limit."""
    for kind in READY:
        velocity, squares = flow_in_python(kind()), np.zeros(len(START))
        for shift in 1e-5 * np.eye(3):
            slopes = (velocity(0.0, START + shift) - velocity(0.0, START - shift)) / 2e-5
            squares += (slopes**2).sum(axis=1)
        plan = pc.Simulation(pc.Scene(pc.Tracers(START, kind()))).plan
        assert (plan.limit_kind, plan.limit_term) == ("accuracy", "flow")
        assert plan.dt_limit == pytest.approx(0.1 / math.sqrt(squares.max()), rel=1e-8)
        assert plan.dt == pytest.approx(0.5 * plan.dt_limit, rel=1e-12)
        own = pc.Simulation(pc.Scene(pc.Tracers(START, pc.Flow(velocity)))).plan
        assert own.dt_limit == pytest.approx(plan.dt_limit, rel=1e-5)  # by one-sided differences


def test_the_gradient_of_a_vortex_is_that_of_a_shear_by_its_circulation():
    """At a distance r all derivatives squared add up to 2 (Γ/(2π r²))²; a vortex has no gradient of its own."""
    one = pc.PointVortices([[0.0, 0.0]], 3.0)
    dust = pc.Tracers([[0.3, 0.4], [2.0, 0.0]], one)
    limit = 0.1 / (math.sqrt(2.0) * 3.0 / (2.0 * math.pi * 0.25))
    assert pc.Simulation(pc.Scene(one, dust)).plan.dt_limit == pytest.approx(limit, rel=1e-14)
    assert pc.Simulation(pc.Scene(one)).plan.limit_kind == "none"
    pair = pc.PointVortices([[0.3, 0.4], [0.0, 0.0]], [1e-9, 3.0])
    assert pc.Simulation(pc.Scene(pair)).plan.dt_limit == pytest.approx(limit, rel=1e-8)


def test_a_tracer_that_runs_to_infinity_is_named():
    """Far from its attractor Halvorsen's flow escapes in a finite time, like 1/(t* − t)."""
    dust = pc.Tracers([[-5.0, 0.0, 0.0], [-40.0, -40.0, -40.0], [-4.0, 0.0, 1.0]], pc.Halvorsen(), name="dust")
    for integrator in (pc.RungeKutta4(), pc.ExplicitEuler()):
        run = pc.Simulation(pc.Scene(dust), integrator, dt=0.01)
        with pytest.raises(pc.SimulationDiverged, match=r"position of tracer 1 of dust is not finite") as caught:
            run.step(1000)
        assert caught.value.particle == 1
        assert caught.value.step == run.steps + 1
        assert np.isfinite(run[dust].positions).all()


def test_a_function_that_runs_to_infinity_or_is_no_number_diverges():
    with np.errstate(all="ignore"):
        away = pc.Simulation(pc.Scene(pc.Tracers([[1.0, 1.0]], pc.Flow(lambda time, x: x * x * x))), dt=0.1)
        with pytest.raises(pc.SimulationDiverged, match=r"position of tracer 0 of systems\[0\]"):
            away.step(1000)
        root = pc.Simulation(pc.Scene(pc.Tracers([[1.0, 1.0]], pc.Flow(lambda time, x: np.sqrt(x) - 2.0))), dt=0.1)
        with pytest.raises(pc.SimulationDiverged, match=r"systems\[0\].flow.function returns NaN for tracer 0 at \["):
            root.step(1000)
        assert np.isfinite(root[root.scene.systems[0]].positions).all()


def test_steps_by_error_keep_their_tolerance():
    """The error of a step is at most the tolerance, and 60 of them on a turn of a pair add up to no more than 60."""
    pair = pc.PointVortices(*PAIR)
    for integrator in (pc.DormandPrince5(), pc.BogackiShampine3(), pc.RungeKuttaChebyshev()):
        run = pc.Simulation(pc.Scene(pair), integrator, dt=pc.AdaptiveStep(tolerance=1e-7))
        run.run(4.0 * math.pi**2 / 3.0)
        assert 1e-10 < np.abs(run[pair].positions - pair.centers).max() < run.steps * 1e-7


def test_tracers_stand_beside_bodies():
    stone = pc.Particles([[0.0, 0.0]], [[1.0, 0.0]])
    four = vortices(name="four")
    dust = pc.Tracers([[0.4, 0.3]], four)
    alone, beside = (pc.simulate(pc.Scene(*bodies, dust, four), 1.0, fps=10, dt=0.01) for bodies in ([], [stone]))
    assert alone.positions.shape == (11, 0, 2)
    np.testing.assert_allclose(beside[stone].positions[-1], [[1.0, 0.0]])
    np.testing.assert_array_equal(alone[dust].positions, beside[dust].positions)
    assert {"systems[0].positions", "four.velocities"} <= set(alone.channels)
    assert "four: velocity of point vortices" in str(beside.plan)


def test_tracers_move_with_the_vortices_of_the_present_state(tmp_path):
    """At the start, after steps, in a file that is loaded, and after vortices are moved: Σ Γ/(2π r) about each."""
    pair = pc.PointVortices(*PAIR)
    run = pc.Simulation(pc.Scene(pc.Tracers([[0.4, 0.3]], pair), pair), dt=0.01)

    def velocity(state: pc.Simulation) -> np.ndarray:
        """By the formula; the velocity that is read is close to it."""
        tracer, moving = (state[system] for system in state.scene.systems)
        x, y = (tracer.positions - moving.positions).T
        rate = np.array(PAIR[1]) / (math.tau * (x * x + y * y))
        expected = np.array([-np.sum(rate * y), np.sum(rate * x)])
        np.testing.assert_allclose(tracer.velocities[0], expected, rtol=1e-13)
        return expected

    found = [velocity(run)]
    run.step(70)
    run.save(tmp_path / "state")
    found += [velocity(run), velocity(pc.load(tmp_path / "state"))]
    run[pair].set(positions=pair.centers + 0.5)
    found.append(velocity(run))
    assert len({tuple(each) for each in found}) == 3


def test_vortices_that_come_after_their_tracers_are_saved_and_copied(tmp_path):
    scene = swirl()
    run = pc.Simulation(scene, dt=0.01)
    run.step(10)
    run.save(tmp_path / "half")
    other, copied = pc.load(tmp_path / "half"), pickle.loads(pickle.dumps(run))
    for each in (run, other, copied):
        each.step(10)
        dust, four = each.scene.systems
        assert dust.flow is four
        assert each.state_hash() == run.state_hash()
    assert other.scene.hash() == scene.hash()


REFUSED = {
    "shape": (lambda: pc.Tracers([1.0, 2.0], pc.Lorenz()), r"Tracers.positions: must have the shape"),
    "finite": (lambda: pc.Tracers([[0.0, math.nan, 0.0]], pc.Lorenz()), r"Tracers.positions\[0, 1\]: must be finite"),
    "flow": (lambda: pc.Tracers([[0.0, 0.0]], 3.0), r"Tracers.flow: must be one of Lorenz"),
    "class": (lambda: pc.Tracers([[0.0, 0.0]], pc.Lorenz), r"Tracers.flow: must be one of Lorenz"),
    "dimension": (lambda: pc.Tracers([[0.0, 0.0]], pc.Lorenz()), r"Tracers.flow: Lorenz is in 3D.* are in 2D"),
    "plane": (lambda: pc.Tracers(START, vortices()), r"Tracers.flow: PointVortices is in 2D.* are in 3D"),
    "parameter": (lambda: pc.Lorenz(rho=math.inf), r"Lorenz.rho: must be finite"),
    "function": (lambda: pc.Flow(1.0), r"Flow.function: must be a function"),
    "circulations": (lambda: pc.PointVortices([[0.0, 0.0]], [1.0, 2.0]), r"PointVortices.circulations: must broadcast"),
    "core": (lambda: pc.PointVortices([[0.0, 0.0]], 1.0, core=-1.0), r"PointVortices.core: must be ≥ 0"),
    "absent": (
        lambda: pc.Scene(pc.Tracers([[0.0, 0.0]], vortices())),
        r"systems\[0\].flow: .* is not in the scene; add it",
    ),
    "coincident": (
        lambda: pc.Simulation(pc.Scene(pc.PointVortices([[1.0, 0.0], [0.0, 0.0], [1.0, 0.0]], 1.0))),
        r"systems\[0\].centers\[2\]: expected a place of its own, got that of vortex 0, .*core > 0",
    ),
    "integrator": (
        lambda: pc.Simulation(pc.Scene(pc.Tracers(START, pc.Lorenz())), pc.VelocityVerlet()),
        r"integrator: VelocityVerlet\(\) cannot drive it; ExplicitEuler\(\), RungeKutta4\(\).* can",
    ),
    "precision": (
        lambda: pc.Simulation(pc.Scene(pc.Tracers([[1e39, 0.0, 0.0]], pc.Lorenz())), precision="f32"),
        r"systems\[0\].positions\[0, 0\]: expected a number that f32 holds",
    ),
    "shape of a function": (
        lambda: pc.Simulation(pc.Scene(pc.Tracers(START, pc.Flow(lambda time, x: x[:, :2])))),
        r"systems\[0\].flow.function: expected velocities of shape \(3, 3\).*got the shape \(3, 2\)",
    ),
    "start of a function": (
        lambda: pc.Simulation(pc.Scene(pc.Tracers(START, pc.Flow(lambda time, x: x * math.inf)))),
        r"systems\[0\].flow.function: expected velocities that are finite",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_is_refused_with_its_path(name):
    build, message = REFUSED[name]
    with pytest.raises(pc.SceneError, match=message):
        build()


def test_tracers_and_their_vortices_have_one_integrator():
    four = vortices()
    dust = pc.Tracers([[0.4, 0.3]], four)
    with pytest.raises(pc.SceneError, match=r"integrator of systems\[1\]: expected RungeKutta4.*same stages"):
        pc.Simulation(pc.Scene(four, dust), {dust: pc.ExplicitEuler()})


def test_lyapunov_exponents_of_a_linear_flow_are_its_eigenvalues():
    """Of a triangular matrix after a while, on its diagonal; the integrator's error is 1e-8 of λ at λ dt = 0.02."""
    matrix = np.array([[-1.0, 3.0, 0.0], [0.0, 0.5, 1.0], [0.0, 0.0, -2.0]])
    cloud = pc.Tracers([[1.0, 2.0, 3.0]], pc.Flow(lambda time, x: x @ matrix.T))
    spectrum = pc.lyapunov(cloud, 4.0, transient=30.0, interval=0.5, dt=0.01)
    np.testing.assert_allclose(spectrum.exponents, [0.5, -1.0, -2.0], rtol=0.0, atol=1e-6)
    assert np.isnan(spectrum.errors).all()  # eight intervals have no tenths
    assert spectrum.dimension == pytest.approx(1.5, abs=1e-6)


def test_lyapunov_exponents_of_the_butterfly_are_those_of_the_literature():
    """0.9056, 0 and −14.5723 (Sprott 2003); their sum is the divergence, but for some 1e-6 of RungeKutta4 at this
    step. The scatter among 300 paths of 100 s says how good the mean is: 0.0014.
    """
    cloud = pc.Tracers(np.array([0.0, 0.0, 25.0]) + np.random.default_rng(1).normal(size=(300, 3)), pc.Lorenz())
    spectrum = pc.lyapunov(cloud, 100.0, transient=20.0, dt=0.005)
    assert (np.abs(spectrum.exponents - [0.9056, 0.0, -14.5723]) < 4.0 * spectrum.errors).all()
    assert (spectrum.errors < 0.002).all()
    assert spectrum.sum == pytest.approx(-41.0 / 3.0, abs=2e-5)
    assert spectrum.dimension == pytest.approx(2.0622, abs=5e-4)
    assert spectrum.each.shape == (300, 3)


def test_tracers_among_vortices_have_exponents_whose_sum_is_zero():
    """Their flow is incompressible. Neighbors part in proportion to time: the rate is 0.095/s in 40 s and 0.034/s
    in 160 s. It is not told from zero.
    """
    four = vortices()
    places = np.random.default_rng(3).uniform(-1.0, 1.0, (60, 2))
    spectrum = pc.lyapunov(pc.Tracers(places, four), 40.0, dt=0.01)
    assert spectrum.sum == pytest.approx(0.0, abs=1e-4)
    assert not spectrum.exponential.any()
    assert (np.abs(spectrum.exponents) <= spectrum.errors).all()


def test_lyapunov_refuses_what_it_cannot_do():
    cloud = pc.Tracers(START, pc.Lorenz())
    with pytest.raises(pc.SceneError, match=r"lyapunov.scene: must be a Scene or Tracers"):
        pc.lyapunov("cloud", 1.0)  # type: ignore[arg-type]
    with pytest.raises(pc.SceneError, match=rf"lyapunov.exponents: must be at most {START.size} in this scene"):
        pc.lyapunov(pc.Scene(cloud), 0.1, dt=0.01, exponents=START.size + 1)
    with pytest.raises(pc.SceneError, match=r"lyapunov.precision: must be 'f64'"):
        pc.lyapunov(cloud, 1.0, precision="f32")
    with pytest.raises(pc.SceneError, match=r"lyapunov.duration: must be > 0"):
        pc.lyapunov(cloud, 0.0)
    with pytest.raises(pc.PhyscoreError, match=r"lyapunov.interval: neighbors parted by .* shorter interval"):
        pc.lyapunov(pc.Tracers(START, pc.Lorenz()), 40.0, interval=20.0, dt=0.005)


def test_recordings_of_tracers_are_saved_and_not_exported_as_trajectories(tmp_path):
    recording = pc.simulate(swirl(), 0.2, fps=10, dt=0.01)
    recording.save(tmp_path / "run")
    loaded = pc.load(tmp_path / "run")
    for one, other in zip(recording.scene.systems, loaded.scene.systems, strict=True):
        np.testing.assert_array_equal(recording[one].positions, loaded[other].positions)
    assert loaded.budgets["hamiltonian"].unit == "m⁴/s²"
    assert "7 tracers in 2D" in repr(loaded)
    with pytest.raises(pc.SceneError, match=r"recording: .* there are neither; positions of tracers"):
        pc.export(recording, tmp_path / "run.pvd")

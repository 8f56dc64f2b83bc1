"""Charges in electric and magnetic fields, and Boris' method."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import Array

EPSILON = np.finfo(float).eps
numbers = st.floats(-2.0, 2.0)
vectors = st.tuples(numbers, numbers, numbers)


def ion(position: Any, velocity: Any, **options: Any) -> pc.Particles:
    return pc.Particles([position], [velocity], **{"charge": 1.0, **options})


def after(scene: pc.Scene, steps: int, dt: float, integrator: pc.Integrator | None = None) -> pc.Simulation:
    run = pc.Simulation(scene, integrator or pc.Boris(), dt=dt, precision="f64")
    run.step(steps)
    return run


def field_of(kind: str, field: Any, points: Array) -> Array:
    """A field at points, by the forces on charges at rest there, or on ones that move along each axis: by the first
    step of Euler's method, which is not meant to be stable.
    """
    axes = np.zeros((1, 3)) if kind == "electric" else np.eye(3)
    h, rows = 1.0 if kind == "electric" else 2.0**-20, []
    for axis in axes:
        charges = pc.Particles(points, np.broadcast_to(axis, points.shape), charge=1.0)
        scene = pc.Scene(charges, pc.ElectromagneticField(**{kind: field}))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pc.StabilityWarning)
            rows.append((after(scene, 1, h, pc.ExplicitEuler()).velocities - axis) / h)
    if kind == "electric":
        return rows[0]
    x, y, _ = rows  # v × B for v along x is (0, −B_z, B_y), for v along y (B_z, 0, −B_x)
    return np.stack([-y[:, 2], x[:, 2], y[:, 0]], axis=1)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@given(electric=vectors, magnetic=vectors, velocity=vectors, mass=st.floats(0.5, 2.0), dt=st.floats(0.01, 3.0))
def test_a_step_is_boris_map(electric, magnetic, velocity, mass, dt):
    """Half a drift, half a kick, the rotation, half a kick, half a drift, in NumPy; some 20 roundings of numbers below
    20, and of a velocity that is a force over a mass times dt.
    """
    q, e, b, v = -1.5, np.array(electric), np.array(magnetic), np.array(velocity)
    x = np.array([0.3, -0.2, 0.1])
    scene = pc.Scene(ion(x, v, mass=mass, charge=q), pc.ElectromagneticField(electric, magnetic))
    run = after(scene, 1, dt)
    half = 0.5 * dt * q * e / mass
    t = 0.5 * dt * q * b / mass
    minus = v + half
    plus = minus + np.cross(minus + np.cross(minus, t), 2.0 * t / (1.0 + t @ t))
    size = 20.0 * (1.0 + dt) * EPSILON * max(1.0, np.abs(minus).max(), np.abs(plus).max(), np.abs(half).max())
    np.testing.assert_allclose(run.velocities[0], plus + half, rtol=0.0, atol=size)
    np.testing.assert_allclose(run.positions[0], x + 0.5 * dt * (v + plus + half), rtol=0.0, atol=size * (1.0 + dt))


def test_an_exact_angle_has_no_phase_error():
    """The gyration is then that of the equation of motion at the middle of each step: after 1000 steps of 0.7 rad,
    each of which rounds the angle by some 2 ε, at random.
    """
    scene = pc.Scene(ion((0.0, 0.0), (1.0, 0.0)), pc.ElectromagneticField(magnetic=1.0))
    velocity = after(scene, 1000, 0.7, pc.Boris(exact_angle=True)).velocities[0]
    np.testing.assert_allclose(velocity, [math.cos(700.0), -math.sin(700.0)], atol=10 * math.sqrt(1000) * EPSILON)
    other = after(scene, 1000, 0.7).velocities[0]
    assert np.abs(other - velocity).max() > 0.1


@pytest.mark.parametrize("exact", [False, True])
def test_a_magnetic_field_does_no_work(exact):
    rng = np.random.default_rng(2)
    shape = (30, 3)
    ions = pc.Particles(rng.normal(size=shape), rng.normal(size=shape), charge=rng.choice([-1.0, 2.0], 30))
    loops = (pc.CurrentLoop(2.0, 1e7, (0.0, 0.0, -1.0)), pc.CurrentLoop(2.0, 1e7, (0.0, 0.0, 1.0), (0.2, 0.0, 1.0)))
    scene = pc.Scene(ions, pc.ElectromagneticField(magnetic=loops))
    recording = pc.simulate(scene, 20.0, fps=5, dt=0.02, integrator=pc.Boris(exact_angle=exact), precision="f64")
    assert (recording.energy.work == 0.0).all()
    assert (recording.energy.dissipated == 0.0).all()
    assert (recording.energy.potential == 0.0).all()
    speeds = np.linalg.norm(recording.velocities, axis=2)
    # A step rounds a velocity by some ε, at random.
    assert np.abs(speeds / speeds[0] - 1.0).max() < 10 * math.sqrt(1000) * EPSILON


def test_the_map_keeps_volume_in_phase_space():
    """Its determinant is 1, of a matrix by central differences of 1e-3: their error is 1e-6 of third derivatives,
    which are some 10; the trap is linear, but the bottle is not.
    """
    field = pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), pc.MagneticBottle(3.0, 1.0))
    base, h = np.array([0.3, -0.2, 0.4, 0.5, 0.1, -0.3]), 1e-3

    def mapped(state: Array) -> Array:
        run = after(pc.Scene(ion(state[:3], state[3:]), field), 3, 0.3)
        return np.concatenate([run.positions[0], run.velocities[0]])

    columns = [(mapped(base + h * axis) - mapped(base - h * axis)) / (2.0 * h) for axis in np.eye(6)]
    assert np.linalg.det(np.stack(columns, axis=1)) == pytest.approx(1.0, abs=3e-5)


def test_a_run_goes_back_to_where_it_began():
    """With v and B reversed, as time reversal asks."""
    forward = pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (pc.MagneticBottle(3.0, 1.0), pc.UniformField((0, 1, 0))))
    back = pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (pc.MagneticBottle(-3.0, 1.0), pc.UniformField((0, -1, 0))))
    start = np.array([0.3, -0.2, 0.4]), np.array([0.5, 0.1, -0.3])
    there = after(pc.Scene(ion(*start), forward), 200, 0.05)
    again = after(pc.Scene(ion(there.positions[0], -there.velocities[0]), back), 200, 0.05)
    # Roundings of 400 steps, which a bounded motion of 10 s enlarges like t.
    np.testing.assert_allclose(again.positions[0], start[0], atol=400 * 10 * EPSILON)
    np.testing.assert_allclose(again.velocities[0], -start[1], atol=400 * 10 * EPSILON)


@pytest.mark.parametrize(
    ("integrator", "order"),
    [
        (pc.Boris(), 2),
        (pc.Boris(exact_angle=True), 2),
        (pc.VelocityVerlet(), 2),
        (pc.PEFRL(), 2),
        (pc.RungeKutta4(), 4),
        (pc.DormandPrince5(), 5),
    ],
    ids=str,
)
def test_orders_with_charges_that_attract_and_fields_that_vary(integrator, order):
    """In 1/r² and E and B together, as the plan says. A step is h, h/2, h/4: the next order is off by a fraction of
    h.
    """
    pair = pc.Particles([[0.6, 0.0, 0.1], [-0.6, 0.1, 0.0]], [[0.0, 0.7, 0.1], [0.1, -0.6, 0.0]], charge=[1.0, -1.0])
    field = pc.ElectromagneticField(pc.PaulTrap(0.3, 0.4, 0.5), pc.MagneticBottle(1.0, 1.5))
    scene = pc.Scene(pair, pc.Coulomb(1.0), field)
    assert pc.Simulation(scene, integrator, dt=0.01).plan.order == order
    steps = {2: 200, 4: 50, 5: 40}[order]
    runs = [after(scene, steps * factor, 1.0 / (steps * factor), integrator).positions for factor in (1, 2, 4)]
    measured = math.log2(np.abs(runs[0] - runs[1]).max() / np.abs(runs[1] - runs[2]).max())
    assert measured == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize(
    "magnetic",
    [
        (0.5, -1.0, 6.0),
        pc.MagneticDipole((1e6, 0.0, 2e7), (0.0, 0.0, -3.0)),
        pc.CurrentLoop(2.0, 1e7),
        pc.MagneticBottle(3.0, 1.0),
    ],
    ids=["uniform", "dipole", "loop", "bottle"],
)
def test_fields_alone_are_what_they_are_among_other_forces(magnetic, precision):
    """Whole steps in registers are those of stages, to some 20 roundings in each of 40 steps, of numbers below 10."""
    rng = np.random.default_rng(4)
    ions = pc.Particles(*rng.normal(size=(2, 100, 3)), mass=rng.uniform(0.5, 2.0, 100), charge=-1.0, fixed=[3])
    field = pc.ElectromagneticField(pc.QuadrupoleTrap(1.0, (0.1, 0.0, 0.2)), magnetic)
    runs = [
        pc.Simulation(pc.Scene(ions, field, *others), pc.Boris(), dt=0.02, precision=precision)
        for others in ((), (pc.CustomForce(lambda time, x, v: 0.0 * x),))
    ]
    for run in runs:
        run.step(40)
    epsilon = np.finfo(np.float64 if precision == "f64" else np.float32).eps
    np.testing.assert_allclose(runs[0].positions, runs[1].positions, rtol=0.0, atol=40 * 20 * 10 * epsilon)


def test_boris_without_a_magnetic_field_is_position_verlet():
    ball = ion((0.5, 0.2), (0.1, 1.0))
    scene = pc.Scene(ball, pc.CentralForce((0.0, 0.0), 1.0), pc.ElectromagneticField(electric=(0.1, 0.2)))
    run = after(scene, 50, 0.05)
    x, v = ball.positions[0].copy(), ball.velocities[0].copy()
    for _ in range(50):
        x += 0.025 * v
        v += 0.05 * ((0.1, 0.2) - x / np.linalg.norm(x) ** 3)
        x += 0.025 * v
    np.testing.assert_allclose(run.positions[0], x, atol=1e-13)


READY: dict[str, tuple[str, Any]] = {
    "trap": ("electric", pc.QuadrupoleTrap(1.5, (0.1, 0.2, -0.1))),
    "alternating": ("electric", pc.PaulTrap(0.5, 1.0, 2.0, phase=0.3)),
    "dipole": ("magnetic", pc.MagneticDipole((1e6, 2e6, -3e6), (0.0, 0.1, 0.0))),
    "loop": ("magnetic", pc.CurrentLoop(0.7, 1e6, (0.1, 0.0, 0.2), (1.0, -1.0, 2.0))),
    "bottle": ("magnetic", pc.MagneticBottle(2.0, 0.8, (0.0, 0.1, 0.2))),
}


@pytest.mark.parametrize("name", READY)
def test_ready_fields_have_neither_sources_nor_currents(name):
    """∇·F = 0 and ∇ × F = 0, by central differences of 1e-3: errors of 1e-6/6 of third derivatives, some 30 times the
    field here.
    """
    kind, field = READY[name]
    rng, h = np.random.default_rng(5), 1e-3
    points = rng.uniform(0.8, 1.6, (20, 3)) * rng.choice([-1.0, 1.0], (20, 3))
    offsets = [points + sign * h * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    values = field_of(kind, field, np.concatenate([points, *offsets])).reshape(7, 20, 3)
    gradient = [(values[1 + 2 * axis] - values[2 + 2 * axis]) / (2.0 * h) for axis in range(3)]  # ∂_axis F
    size = 1e-4 * np.abs(values[0]).max()
    assert np.abs(sum(gradient[axis][:, axis] for axis in range(3))).max() < size
    for one, other in ((0, 1), (1, 2), (2, 0)):
        assert np.abs(gradient[one][:, other] - gradient[other][:, one]).max() < size


def test_a_loop_is_the_sum_of_its_elements():
    """Biot and Savart's law over the wire, by the rectangle rule, which converges faster than any power: 2000 parts
    are enough at distances of a tenth of the radius. On the axis it is μ₀ I a²/2 (a² + z²)^(3/2).
    """
    radius, current = 0.5, 1e6
    rng = np.random.default_rng(1)
    points = np.concatenate([rng.uniform(-1.0, 1.0, (40, 3)), [[0.0, 0.0, 0.0], [0.0, 0.0, 0.3], [1e-9, 0.0, 0.3]]])
    distance = np.hypot(np.hypot(points[:, 0], points[:, 1]) - radius, points[:, 2])
    points = points[distance > 0.05]
    angle = 2.0 * np.pi * np.arange(2000) / 2000
    wire = radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    element = 2.0 * np.pi * radius / 2000 * np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
    apart = points[:, None] - wire
    pulls = np.cross(element, apart) / np.linalg.norm(apart, axis=2)[..., None] ** 3
    expected = 1.00000000055e-7 * current * pulls.sum(axis=1)
    found = field_of("magnetic", pc.CurrentLoop(radius, current), points)
    # Velocities of 1 that change by B 2⁻²⁰ round it by ε 2²⁰ of 1.
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=4 * EPSILON * 2.0**20)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize("name", ["trap", "alternating"])
def test_forces_are_gradients_of_potentials(name):
    """−∇φ by central differences, exact for a quadratic potential but for rounding, ε/2h."""
    field, h = READY[name][1], 0.1
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (10, 3))
    found = field_of("electric", field, points)

    def energy(point: Array) -> float:
        scene = pc.Scene(pc.Particles([point], charge=1.0), pc.ElectromagneticField(electric=field))
        return pc.Simulation(scene, dt=1.0).energy().by_term["electromagnetic field"]

    for point, force in zip(points, found, strict=True):
        slopes = [(energy(point - h * axis) - energy(point + h * axis)) / (2.0 * h) for axis in np.eye(3)]
        np.testing.assert_allclose(force, slopes, atol=1e-13)


@pytest.mark.parametrize(
    "field",
    [
        pc.PaulTrap(0.2, 1.5, 1.0),
        pc.TravellingWave((0.0, 0.4, 0.0), (3.0, 0.0, 0.0), 0.8),
        lambda time, x: 0.3 * np.cos(2.0 * time) * np.roll(x, 1, axis=1),
    ],
    ids=["paul", "wave", "function"],
)
def test_what_comes_from_outside_is_work(field):
    """The budget closes to the order of the method at least: a quarter of the error at half of the step."""
    ions = pc.Particles([[0.5, 0.2, 0.1], [-0.3, 0.4, 0.2]], [[0.1, 0.5, 0.2], [0.4, 0.0, 0.1]], charge=[1.0, -0.7])
    scene = pc.Scene(ions, pc.ElectromagneticField(field, (0.0, 0.3, 1.0)))
    drifts = []
    for dt in (0.02, 0.01):
        energy = pc.simulate(scene, 6.0, fps=5, dt=dt, precision="f64").energy
        assert np.ptp(energy.work) > 0.02
        drifts.append(np.abs(energy.drift).max())
    assert drifts[1] < 2e-3
    assert drifts[0] / drifts[1] > 3.0


def test_ions_stay_in_a_paul_trap_where_mathieus_equation_says_so():
    """Along z its parameter is q = 2 s Q/(m ω²) for the alternating strength s: stable below 0.908 (McLachlan 1947)."""
    for parameter, stays in ((0.85, True), (0.96, False)):
        strength = 0.5 * parameter * (2.0 * np.pi) ** 2
        scene = pc.Scene(
            ion((0.0, 0.0, 0.01), (0.0, 0.0, 0.0)), pc.ElectromagneticField(pc.PaulTrap(0.0, strength, 1.0))
        )
        heights = pc.simulate(scene, 60.0, fps=10, dt=0.005, precision="f64").positions[:, 0, 2]
        assert (np.abs(heights).max() < 0.5) == stays


def test_boris_is_the_default_where_there_is_a_magnetic_field_alone():
    ions = ion((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    for field, name in (
        (pc.ElectromagneticField(magnetic=(0.0, 0.0, 1.0)), "Boris"),
        (pc.ElectromagneticField(magnetic=pc.MagneticDipole((0.0, 0.0, 1.0), (1.0, 1.0, 1.0))), "Boris"),
        (pc.ElectromagneticField((1.0, 0.0, 0.0)), "VelocityVerlet"),
        (pc.ElectromagneticField((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "VelocityVerlet"),
    ):
        assert pc.Simulation(pc.Scene(ions, field), dt=0.01).plan.integrator == name


def test_the_gyration_limits_the_step():
    """The accuracy to a hundredth of its period, 2πm/|qB|; and of methods that do not turn velocities, their
    stability.
    """
    scene = pc.Scene(ion((0.0, 0.0), (1.0, 0.0), charge=-2.0, mass=0.5), pc.ElectromagneticField(magnetic=3.0))
    period = 2.0 * np.pi * 0.5 / 6.0
    assert pc.stability_limit(scene, pc.Boris()) == math.inf
    assert pc.stability_limit(scene, pc.RungeKutta4()) == pytest.approx(2.0 * math.sqrt(2.0) / 12.0)
    run = pc.Simulation(scene)
    assert period / 400.0 < run.dt <= period / 100.0
    assert "gyration" in str(run.plan)


def test_charges_without_a_field_are_warned_of():
    charged = ion((0.0, 0.0), (1.0, 0.0))
    with pytest.warns(pc.SceneWarning, match=r"bodies\[0\]\.charge: no force .* add Coulomb\(\)"):
        pc.Scene(charged, pc.Gravity((0.0, -9.81)))
    for force in (pc.Coulomb(), pc.ElectromagneticField(magnetic=1.0), pc.CustomForce(lambda time, x, v: -x)):
        pc.Scene(charged, force)
    pc.Scene(pc.Particles([[0.0, 0.0]]))


def test_the_plan_says_where_relativity_matters():
    field = pc.ElectromagneticField(magnetic=1.0)
    slow, fast = (pc.Simulation(pc.Scene(ion((0.0, 0.0), (v, 0.0)), field), dt=1e-3) for v in (2e7, 4e7))
    assert "relativistic" not in str(slow.plan)
    assert "0.13 c" in str(fast.plan)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.ElectromagneticField(1.0), r"ElectromagneticField\.electric: must be a vector, a function or 0"),
        (lambda: pc.ElectromagneticField(pc.CurrentLoop(1.0, 1.0)), r"electric: must be a sum of electric fields"),
        (lambda: pc.ElectromagneticField(magnetic=pc.QuadrupoleTrap(1.0)), "must be a sum of magnetic fields"),
        (
            lambda: pc.ElectromagneticField(magnetic=(pc.CurrentLoop(1.0, 1.0), (0, 0, 1))),
            r"must be a sum .* got \(0, 0",
        ),
        (lambda: pc.ElectromagneticField((1.0, 0.0), potential=len), "is for an electric field that is a function"),
        (lambda: pc.ElectromagneticField(magnetic=math.nan), r"ElectromagneticField\.magnetic"),
        (lambda: pc.CurrentLoop(0.0, 1.0), r"CurrentLoop\.radius: must be above 0|CurrentLoop\.radius: must be > 0"),
        (lambda: pc.CurrentLoop(1.0, 1.0, axis=(0, 0, 0)), r"CurrentLoop\.axis: must not be zero"),
        (lambda: pc.MagneticDipole((1.0, 0.0)), r"MagneticDipole\.moment: must have 3 components, got 2"),
        (lambda: pc.PaulTrap(0.0, 1.0, 0.0), r"PaulTrap\.frequency"),
        (lambda: pc.Boris(exact_angle=1.0), r"Boris\.exact_angle"),
    ],
)
def test_a_field_that_cannot_be_is_refused(make, message):
    with pytest.raises(pc.SceneError, match=message):
        make()


@pytest.mark.parametrize(
    ("field", "dimension", "message"),
    [
        (pc.ElectromagneticField(magnetic=(0.0, 0.0, 1.0)), 2, r"forces\[0\]\.magnetic"),
        (pc.ElectromagneticField(magnetic=1.0), 3, r"forces\[0\]\.magnetic"),
        (pc.ElectromagneticField(pc.QuadrupoleTrap(1.0)), 2, r"forces\[0\]\.electric"),
        (pc.ElectromagneticField(magnetic=pc.CurrentLoop(1.0, 1.0)), 2, r"forces\[0\]\.magnetic"),
        (pc.ElectromagneticField((1.0, 0.0)), 3, r"forces\[0\]\.electric"),
    ],
)
def test_a_field_of_another_dimension_is_refused(field, dimension, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Scene(pc.Particles(np.zeros((1, dimension)), charge=1.0), field)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (lambda time, x: x * math.nan, r"forces\[0\]\.electric: expected finite numbers, got NaN in row 0"),
        (lambda time, x: x[:, 0], r"forces\[0\]\.electric"),
        (lambda time, x: 1 / 0, r"forces\[0\]\.electric.*ZeroDivisionError"),
    ],
)
def test_a_function_that_fails_is_named(field, message):
    ions = pc.Particles([[1.0, 0.0], [0.0, 1.0]], charge=1.0)
    with pytest.raises(pc.SceneError, match=message):
        pc.Simulation(pc.Scene(ions, pc.ElectromagneticField(field)), dt=0.01).step(1)

"""Validation, area A: one or two degrees of freedom against closed forms and high-precision references.

Coordinates of a mechanical system are put in the place of x and y of one particle of 1 kg, and its equation of motion
into a CustomForce: so the integrators solve exactly the textbook's problem. "Excellent" and "good" are the tolerances
of the catalogue from which the cases are taken.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation, state

pytestmark = pytest.mark.validation

EULER, SEMI, VERLET, RK4 = pc.ExplicitEuler(), pc.SemiImplicitEuler(), pc.VelocityVerlet(), pc.RungeKutta4()


def system(acceleration, position: list[float], velocity: list[float]) -> pc.Scene:
    """x'' = acceleration(x, v) for one particle, with arrays of shape (2,)."""

    def force(time: float, positions: Array, velocities: Array) -> Array:
        return np.array([acceleration(positions[0], velocities[0])])

    return pc.Scene(pc.Particles([position], [velocity]), pc.CustomForce(force))


# A01. Source: rational arithmetic on the integrators' own update matrices, 40 digits; x'' = −x, x = 1, v = 0, dt = 1/8,
# 1024 steps. Excellent: 3e-13 in f64, 1e-4 in f32; of a figure of which 1e-4 is below an ulp, 1e-4 of it.
A01 = {
    EULER: (-293.7190633272240164273687, -2786.717303439593542120441, 7852064.217451461501520791),
    SEMI: (-0.7919831273632388730029349, -0.6620451654090450235135248, 1.065541075069546031445782),
    VERLET: (-0.7506053045251735590333396, -0.6594590514816659413904251, 0.9982945637624270645864757),
    RK4: (-0.692690321228835834744005, -0.7211975962466883244885012, 0.9999458539561090459282265),
}
WELL = pc.CentralForce((0.0, 0.0, 0.0), 1.0, exponent=1.0)
SPRING = pc.SpringNetwork(
    [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], [[0, 1]], stiffness=1.0, rest_length=0.0, fixed=[0], name="mass"
)
OSCILLATORS = {
    "well": pc.Scene(pc.Particles([[1.0, 1.0, 1.0]], name="mass"), WELL),
    "spring": pc.Scene(SPRING),
    "custom": pc.Scene(pc.Particles([[1.0, 1.0, 1.0]], name="mass"), pc.CustomForce(lambda time, x, v: -x)),
}


@pytest.mark.parametrize("kind", OSCILLATORS)
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 3e-13), ("f32", 1e-4)])
@pytest.mark.parametrize("integrator", A01, ids=lambda i: type(i).__name__)
def test_a01_a_harmonic_oscillator_is_exactly_the_discrete_one(integrator, precision, tolerance, kind, record_property):
    run = simulation(OSCILLATORS[kind], integrator, 0.125, precision=precision)
    run.step(1024)
    x, v, ratio = A01[integrator]
    size = max(1.0, math.hypot(x, v)) if integrator == EULER else 1.0
    found = run["mass"]
    errors = np.concatenate([np.abs(found.positions[-1] - x), np.abs(found.velocities[-1] - v)])
    record_property("error", f"{errors.max():.1e}")
    assert errors.max() <= tolerance * size
    x, v = found.positions[-1], found.velocities[-1]
    assert (x**2 + v**2) == pytest.approx(ratio, rel=20.0 * tolerance)


# A02. Source: T = 4 √(l/g) K(sin²(θ₀/2)); state by Jacobi's sn, cn, dn; g = 9.81, l = 1.
PERIODS = {
    10: 2.009892627298600682930,
    90: 2.367841947576237449303,
    150: 3.535098186381523473931,
    179: 7.825796837537682702958,
}
ANGLE_150_AT_5, RATE_150_AT_5 = -2.378845188148448250750, -1.675507689556736884103
TEXTBOOK_PENDULUM = {
    EULER: (7.8373, 1.7913, 0.41525),
    SEMI: (8.0861e-3, 4.1153e-3, 2.0759e-3),
    VERLET: (5.2767e-5, 1.3193e-5, 3.2982e-6),
    RK4: (2.3752e-8, 1.9808e-9, 1.3933e-10),
}


def pendulum(degrees: float) -> pc.Scene:
    """θ'' = −(g/l) sin θ."""
    return pc.Scene(pc.Particles([[math.radians(degrees), 0.0]]), pc.CustomForce(lambda time, x, v: -9.81 * np.sin(x)))


@pytest.mark.parametrize("degrees", PERIODS)
def test_a02_the_period_of_a_pendulum(degrees, record_property):
    """Excellent: 3e-6 at 179°, Verlet with dt = 1e-3; four times the time to θ = 0, found within its step."""
    run = simulation(pendulum(degrees), VERLET, 1e-3)
    while run.positions[0, 0] > 0.0:
        run.step(1)
    # At θ = 0 the acceleration vanishes: back along a straight line.
    quarter = run.time - run.positions[0, 0] / run.velocities[0, 0]
    error = 4.0 * quarter / PERIODS[degrees] - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 3e-6


@pytest.mark.parametrize("integrator", TEXTBOOK_PENDULUM, ids=lambda i: type(i).__name__)
def test_a02_the_error_of_a_pendulum_is_that_of_the_textbook_scheme(integrator, record_property):
    """Of θ at t = 5 s, from 150°, in 500, 1000 and 2000 steps. Excellent: ratio within 0.005, order within 0.05.

    The order of explicit Euler (2.1) and of RungeKutta4 (3.8) is not yet the asymptotic one on these grids, so there
    the textbook's errors themselves are the test.
    """
    errors = []
    for steps in (500, 1000, 2000):
        run = simulation(pendulum(150.0), integrator, 5.0 / steps)
        run.step(steps)
        errors.append(abs(float(run.positions[0, 0]) - ANGLE_150_AT_5))
    ratios = np.array(errors) / TEXTBOOK_PENDULUM[integrator]
    record_property("ratio to the textbook's error", np.round(ratios, 5).tolist())
    np.testing.assert_allclose(ratios, 1.0, rtol=0.0, atol=0.005)
    if integrator in (SEMI, VERLET):
        assert np.log2(errors[1] / errors[2]) == pytest.approx(integrator.order, abs=0.05)


def test_a02_the_state_at_t_5():
    """RungeKutta4 with dt = 5e-4: its error of 1.4e-10 at four times that step falls by 4⁴."""
    run = simulation(pendulum(150.0), RK4, 5e-4)
    run.run(5.0)
    assert run.positions[0, 0] == pytest.approx(ANGLE_150_AT_5, abs=1e-11)
    assert run.velocities[0, 0] == pytest.approx(RATE_150_AT_5, abs=1e-11)


# A04. Source: elementary closed forms; x'' + 2ζω x' + ω² x = 0, ω = 2, x = 1, v = 0, t = 5.
A04 = {
    0.1: (-0.3368516805904133628014, 0.370691413969211798),
    1.0: (0.0004993992273873333668915, -0.000907998595249697031),
    2.0: (0.07390407190962298158548, -0.0396050727711101637),
}
A04_EXCELLENT = {0.1: 4.3e-9, 1.0: 4.0e-12}


def damped(ratio: float, kind: str) -> pc.Scene:
    damping = 2.0 * ratio * 2.0
    if kind == "drag":
        return pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 4.0, 1.0), pc.Drag(linear=damping))
    spring = pc.SpringNetwork(
        [[1.0, 0.0], [-9.0, 0.0]], [[0, 1]], stiffness=4.0, damping=damping, rest_length=9.0, fixed=[1]
    )
    return pc.Scene(spring)


@pytest.mark.parametrize("kind", ["drag", "spring"])
@pytest.mark.parametrize("ratio", A04)
def test_a04_a_damped_oscillator(ratio, kind, record_property):
    """Excellent: 4.3e-9 at ζ = 0.1 and 4e-12 at ζ = 1 for RungeKutta4 with dt = 0.01, and its order within 0.05.

    There is no figure for ζ = 2, whose faster decay rate λ = 7.5/s matters for a moment only: that of ζ = 0.1. A spring
    9 m long rounds x to 1e-15 m.
    """
    errors = []
    for dt in (0.02, 0.01):
        run = simulation(damped(ratio, kind), RK4, dt)
        run.run(5.0)
        errors.append(np.abs([run.positions[0, 0] - A04[ratio][0], run.velocities[0, 0] - A04[ratio][1]]))
    record_property("error of x", f"{errors[1][0]:.2e}")
    assert errors[1][0] <= A04_EXCELLENT.get(ratio, 4.3e-9)
    coarse, fine, finest = (path(damped(ratio, kind), RK4, steps) for steps in (500, 1000, 2000))
    measured = np.log2(np.linalg.norm(coarse - fine) / np.linalg.norm(fine - finest))
    assert measured == pytest.approx(4.0, abs=0.05)


def path(scene: pc.Scene, integrator: pc.Integrator, steps: int) -> Array:
    run = simulation(scene, integrator, 5.0 / steps)
    states = []
    for _ in range(20):
        run.step(steps // 20)
        states.append(state(run))
    return np.array(states)


# A06. Source: 60-digit Taylor series; M. Hénon, C. Heiles, Astron. J. 69 (1964) 73. Columns x, y, px, py.
HENON_HEILES_START = 0.3966526608171604504878174
HENON_HEILES = {
    10: (-0.006602924213153088303561, -0.1707215830809925027799, -0.2376905163381227251641, 0.2787079042666895910744),
    100: (0.08711046349968104802685, 0.3336240416690196401629, 0.2594017630885305164816, 0.01330189276097982373278),
    300: (0.1959407698558901831439, 0.09980444352424980506196, 0.331577186003419944106, -0.03699656994475327941567),
}
TEXTBOOK_HENON_HEILES = {
    SEMI: (1.6966e-2, 4.8467e-3, 1.7039e-3),
    VERLET: (1.5807e-2, 3.9530e-3, 9.8824e-4),
    RK4: (6.0002e-5, 3.2938e-6, 1.9130e-7),
}


def henon_heiles() -> pc.Scene:
    def force(time: float, positions: Array, velocities: Array) -> Array:
        x, y = positions[0]
        return np.array([[-x - 2.0 * x * y, -y - x * x + y * y]])

    def potential(positions: Array) -> float:
        x, y = positions[0]
        return float((x * x + y * y) / 2.0 + x * x * y - y**3 / 3.0)

    return pc.Scene(pc.Particles([[0.0, 0.1]], [[HENON_HEILES_START, 0.0]]), pc.CustomForce(force, potential))


@pytest.mark.parametrize("integrator", TEXTBOOK_HENON_HEILES, ids=lambda i: type(i).__name__)
def test_a06_the_error_of_a_regular_orbit_is_that_of_the_textbook_scheme(integrator, record_property):
    """The larger one of x and y at t = 100, in 1000, 2000 and 4000 steps. Excellent: within 0.005."""
    errors = []
    for steps in (1000, 2000, 4000):
        run = simulation(henon_heiles(), integrator, 100.0 / steps)
        run.step(steps)
        errors.append(np.abs(run.positions[0] - HENON_HEILES[100][:2]).max())
    ratios = np.array(errors) / TEXTBOOK_HENON_HEILES[integrator]
    record_property("ratio to the textbook's error", np.round(ratios, 5).tolist())
    np.testing.assert_allclose(ratios, 1.0, rtol=0.0, atol=0.005)


def test_a06_the_energy_has_no_trend(record_property):
    """Excellent: 5e-4 relative at t = 100, Verlet with dt = 0.05. On the way the error swings; its mean stays."""
    run = simulation(henon_heiles(), VERLET, 0.05)
    energies = [run.energy().total]
    for _ in range(2000):
        run.step(1)
        energies.append(run.energy().total)
    error = np.array(energies) * 12.0 - 1.0
    record_property("error", f"{error[-1]:.2e}")
    assert abs(error[-1]) <= 5e-4
    assert abs(error[:500].mean() - error[-500:].mean()) <= 0.1 * np.abs(error).max()


@pytest.mark.parametrize("time", HENON_HEILES)
def test_a06_pefrl_follows_the_orbit_to_order_four(time, record_property):
    """No catalogue figure: the error at dt = 0.1 is 1e-6 at t = 300, and halving dt divides it by 16."""
    errors = []
    for dt in (0.1, 0.05, 0.025):
        run = simulation(henon_heiles(), pc.PEFRL(), dt)
        run.run(float(time))
        errors.append(np.abs(state(run)[:, 0].ravel() - HENON_HEILES[time]).max())
    record_property("errors", ", ".join(f"{error:.1e}" for error in errors))
    assert errors[0] < 2e-6
    assert np.log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.2)


# A09. Source: 62-digit Taylor series; columns θ1, θ2, ω1, ω2; both masses and lengths 1, g = 9.81, from (90°, 90°).
DOUBLE_PENDULUM = {
    1: (-0.6250876998063906299541, -1.034585085680012340612, -3.922279572887976616873, -1.303099248696331243323),
    5: (-0.6271867050665307301381, -1.301315550209811677908, 2.125408673842910650651, 3.881888727265607439255),
    10: (-0.5684746640159501887761, -0.5263937279324046983296, 6.078384885761964854825, -9.681360681708878758077),
    20: (0.7487609754791818265207, -25.83246199889377678179, 4.078003969275087781432, 2.779889455386669743296),
}


def double_pendulum(angles: Array, rates: Array) -> list[float]:
    """Lagrange's equations for two unit masses on unit rods, solved for the accelerations."""
    (one, two), (w1, w2), g = angles.tolist(), rates.tolist(), 9.81
    delta = one - two
    sine, cosine = math.sin(delta), math.cos(delta)
    # 2 α1 + c α2 = −s ω2² − 2 g sin θ1,  c α1 + α2 = s ω1² − g sin θ2
    first, second = -sine * w2 * w2 - 2.0 * g * math.sin(one), sine * w1 * w1 - g * math.sin(two)
    determinant = 2.0 - cosine * cosine
    return [(first - cosine * second) / determinant, (2.0 * second - cosine * first) / determinant]


@pytest.mark.parametrize(("time", "dt", "tolerance"), [(1, 0.005, 7e-7), (5, 0.005, 7e-7), (20, 0.00125, 4.8e-5)])
def test_a09_a_double_pendulum(time, dt, tolerance, record_property):
    """Excellent: 7e-7 at t = 5 with dt = 0.005, 4.8e-5 at t = 20 with dt = 0.00125 (chaos multiplies by 1e4)."""
    run = simulation(system(double_pendulum, [math.pi / 2, math.pi / 2], [0.0, 0.0]), RK4, dt)
    run.run(float(time))
    error = np.abs(state(run)[:, 0].ravel() - DOUBLE_PENDULUM[time]).max()
    record_property("error", f"{error:.2e}")
    assert error <= tolerance


# A11. Source: amplification matrices; E. Hairer, G. Wanner, Solving ODEs II, sec. IV.2.
GROWTH = {
    (VERLET, 1.01): 1.326584426950908,
    (VERLET, 10.0): 397.9974874213240,
    (SEMI, 1.01): 1.326584426950908,
    (SEMI, 10.0): 397.9974874213240,
    (RK4, 0.5): 0.9574271077563381,
    (RK4, 0.99): 0.9310048861145733,
    (RK4, 1.01): 1.073185265238907,
    (RK4, 10.0): 26532.99834168766,
    (EULER, 0.1): math.sqrt(1.01),
}
LIMIT = {VERLET: 2.0, SEMI: 2.0, RK4: 2.828427124746190097603, EULER: 1.0}
"""ω dt; explicit Euler has none: its factor is ω dt itself, and its growth (1 + ω² dt²)^½."""


@pytest.mark.parametrize(
    ("integrator", "factor"), GROWTH, ids=lambda i: type(i).__name__ if not isinstance(i, float) else i
)
def test_a11_the_growth_per_step(integrator, factor, record_property):
    """Excellent: 1e-9 relative. The slower mode of Verlet falls as the faster one grows: after 60 steps of 1.33 each it
    is below 1.33^−120 = 1e-15 of it. RungeKutta4 and explicit Euler scale and turn (x, v), both modes alike.
    """
    run = simulation(OSCILLATORS["well"], integrator, factor * LIMIT[integrator], on_divergence="ignore")
    run.step(60 if factor < 10.0 else 20)
    before = np.linalg.norm(state(run)[:, -1])
    run.step(1)
    growth = float(np.linalg.norm(state(run)[:, -1]) / before)
    record_property("growth", f"{growth:.12g}")
    assert growth == pytest.approx(GROWTH[integrator, factor], rel=1e-9)


@pytest.mark.parametrize("integrator", [VERLET, SEMI, RK4], ids=lambda i: type(i).__name__)
def test_a11_bounded_below_and_growing_above(integrator):
    """Over 1e4 steps. Verlet's ellipse at 0.99 is elongated by 1/√(1 − 0.99²) = 7.1."""
    below = simulation(OSCILLATORS["well"], integrator, 0.99 * LIMIT[integrator])
    below.step(10_000)
    assert np.abs(state(below)).max() <= 7.1 * math.sqrt(2.0)
    above = simulation(OSCILLATORS["well"], integrator, 1.01 * LIMIT[integrator])
    with pytest.raises(pc.SimulationDiverged):
        above.step(10_000)


@pytest.mark.parametrize(
    ("integrator", "limit"),
    [(EULER, 2.0), (VERLET, None), (RK4, 2.785293563405281623530)],
    ids=["Euler", "Verlet", "RK4"],
)
def test_a11_the_limit_on_the_real_axis(integrator, limit, record_property):
    """x' = −λx as v' = −(b/m) v. Verlet takes the force at the predicted velocity, whose own limit is 1: λ dt ≤ 1,
    because g² + (3c/2 − 1) g − c/2 = 0 for the velocity has a root at −1 for c = 1; there is no catalogue figure.
    """
    limit = limit or 1.0
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]]), pc.Drag(linear=1.0))
    assert pc.stability_limit(scene, integrator) == pytest.approx(limit, rel=1e-9)
    for factor, stable in ((0.99, True), (1.01, False)):
        run = simulation(scene, integrator, factor * limit, on_divergence="ignore")
        run.step(2000)
        assert (abs(run.velocities[0, 0]) < 1.0) == stable


# A13. Source: symmetry of velocity Verlet. The figure-8 of three bodies: C. Moore, Phys. Rev. Lett. 70 (1993) 3675;
# A. Chenciner, R. Montgomery, Ann. Math. 152 (2000) 881.
def figure_eight() -> pc.Scene:
    position, velocity = np.array([0.97000436, -0.24308753]), np.array([-0.93240737, -0.86473146])
    bodies = pc.Particles([position, -position, [0.0, 0.0]], [-velocity / 2.0, -velocity / 2.0, velocity])

    def gravity(time: float, positions: Array, velocities: Array) -> Array:
        separation = positions[None] - positions[:, None]
        cube = (separation**2).sum(axis=2) ** 1.5
        np.fill_diagonal(cube, 1.0)
        return (separation / cube[..., None]).sum(axis=1)

    return pc.Scene(bodies, pc.CustomForce(gravity))


def return_error(scene: pc.Scene, integrator: pc.Integrator, dt: float, precision: str = "f64") -> float:
    """Of the positions, after 10 s forward, around, and 10 s back."""
    run = simulation(scene, integrator, dt, precision=precision)
    start = state(run)
    run.run(10.0)
    run.set(velocities=-run.velocities)
    run.run(10.0)
    return float(np.abs(state(run)[0] - start[0]).max())


@pytest.mark.parametrize("integrator", [VERLET, pc.PEFRL()], ids=lambda i: type(i).__name__)
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-12), ("f32", 1e-4)])
@pytest.mark.parametrize("scene", [pendulum(150.0), figure_eight()], ids=["pendulum", "figure-8"])
def test_a13_a_symmetric_method_returns_to_its_start(scene, precision, tolerance, integrator, record_property):
    """Excellent: 1e-12 in f64, 1e-4 in f32."""
    error = return_error(scene, integrator, 0.01, precision)
    record_property("return error", f"{error:.1e}")
    assert error <= tolerance


def test_a13_runge_kutta_does_not(record_property):
    """Truncation remains, 4.316e-8 and 1.349e-9 in the textbook's runs, and falls by 2⁵ when dt is halved."""
    coarse, fine = (return_error(pendulum(150.0), RK4, dt) for dt in (0.01, 0.005))
    record_property("return errors", f"{coarse:.3e}, {fine:.3e}")
    assert coarse == pytest.approx(4.316e-8, rel=0.05)
    assert fine == pytest.approx(1.349e-9, rel=0.05)
    assert np.log2(coarse / fine) == pytest.approx(5.0, abs=0.1)

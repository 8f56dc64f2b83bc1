"""Validation, area E: modes and waves of chains and membranes against closed forms.

"Excellent" and "good" are the tolerances of the catalogue from which the cases are taken.
"""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, line, membrane, modal_frequency, simulation

pytestmark = pytest.mark.validation

VERLET = pc.VelocityVerlet()

# By each method the coordinate q of a mode obeys Σ a_j q_(n−j) = −(ω dt)² Σ b_j q_(n−j), from its formulas.
RECURRENCES = {
    pc.BackwardEuler(1e-14): ([1.0, -2.0, 1.0], [1.0, 0.0, 0.0]),
    pc.ProjectiveDynamics(200): ([1.0, -2.0, 1.0], [1.0, 0.0, 0.0]),
    pc.ImplicitMidpoint(1e-14): ([1.0, -2.0, 1.0], [0.25, 0.5, 0.25]),
    pc.BDF2(1e-14): (np.convolve([1.5, -2.0, 0.5], [1.5, -2.0, 0.5]), [1.0, 0.0, 0.0, 0.0, 0.0]),
}
STIFF_METHODS = {"argvalues": RECURRENCES, "ids": lambda integrator: type(integrator).__name__}


def recurrence_frequency(series: Array, dt: float, integrator: pc.Integrator) -> float:
    """ω of a mode from its coordinate at every step of one of these methods, by least squares."""
    change, weight = (np.convolve(series, row, "valid") for row in RECURRENCES[integrator])
    return float(np.sqrt(-(weight @ change) / (weight @ weight)) / dt)


# E01. Source: ω_n = 2 √(k/m) sin(nπ/(2(N+1))), N = 10, k = m = 1, fixed ends.
CHAIN_MODES = (
    0.28462967654657028089, 0.56346511368285939542, 0.83083002600377285106, 1.0812816349111951642,
    1.3097214678905701281, 1.5114991487085165675, 1.6825070656623623377, 1.8192639907090367428,
    1.9189859472289947798, 1.9796428837618654648,
)  # fmt: skip


SHAPES = np.sin(np.outer(np.arange(1, 11), np.arange(1, 11)) * np.pi / 11)
"""Shapes of the modes: that of mode n at the masses in row n − 1."""


def chain(amplitudes: Array) -> pc.Scene:
    """Ten masses between two walls, shifted along the chain by the given sum of modes."""
    sites = np.arange(12)
    shift = sum(a * np.sin(n * np.pi * sites / 11) for n, a in enumerate(amplitudes, start=1))
    pairs = np.stack([sites[:-1], sites[1:]], axis=1)
    return pc.Scene(pc.SpringNetwork(line(sites + shift), pairs, 1.0, rest_length=1.0, fixed=[0, 11]))


def coordinates(run: pc.Simulation) -> Array:
    """Amplitudes of the ten modes."""
    shift = run.positions[1:11, 0] - np.arange(1, 11)
    return SHAPES @ shift / 5.5


@pytest.mark.parametrize("mode", range(1, 11))
def test_e01_the_frequency_of_each_mode_of_a_chain(mode, record_property):
    """Excellent: 1e-10 relative to the discrete value, Verlet with dt = 0.05.

    Positions of up to 11 m are rounded to 1e-15 m, and the second difference of q is (0.014)² of it: 1e-11 for a single
    step of the slowest mode at an amplitude of 0.1 m, and less by least squares over 20 000.
    """
    run = simulation(chain(0.1 * np.eye(10)[mode - 1]), VERLET, 0.05)
    series = [coordinates(run)[mode - 1]]
    for _ in range(20_000):
        run.step(1)
        series.append(coordinates(run)[mode - 1])
    error = modal_frequency(np.array(series), 0.05) / CHAIN_MODES[mode - 1] - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 1e-10


@pytest.mark.parametrize("integrator", **STIFF_METHODS)
@pytest.mark.parametrize("mode", [1, 4, 10])
def test_e01_the_frequency_of_a_mode_by_methods_for_stiff_matter(mode, integrator, record_property):
    """Good: 1e-6, relative to the discrete value; 300 steps, in which damped modes do not vanish yet.

    Rounding of 1e-15 m is 1e-14 of the amplitude, over (ω dt)² ≥ 2e-4 and √300 3e-12.
    """
    run = simulation(chain(0.1 * np.eye(10)[mode - 1]), integrator, 0.05)
    series = []
    for _ in range(300):
        run.step(1)
        series.append(coordinates(run)[mode - 1])
    error = recurrence_frequency(np.array(series), 0.05, integrator) / CHAIN_MODES[mode - 1] - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 1e-9


@pytest.mark.parametrize("mode", [1, 4, 10])
def test_e01_no_energy_leaks_into_other_modes(mode, record_property):
    """Excellent: 1e-13 of the energy in 1e5 steps, with an amplitude of 0.1 m."""
    run = simulation(chain(0.1 * np.eye(10)[mode - 1]), VERLET, 0.05)
    leak = 0.0
    for _ in range(100):
        run.step(1000)
        velocities = SHAPES @ run.velocities[1:11, 0] / 5.5
        energies = velocities**2 + (np.array(CHAIN_MODES) * coordinates(run)) ** 2
        leak = max(leak, 1.0 - energies[mode - 1] / energies.sum())
    record_property("leak", f"{leak:.1e}")
    assert leak <= 1e-13


# E02. Source: ω = 2 sin(qa/2), group velocity cos(qa/2); k = m = a = 1, periodic, N = 200.
DISPERSION = {
    0.1: (0.31286893008046173802, 0.98768834059513772619),
    0.25: (0.76536686473017954346, 0.92387953251128675613),
    0.5: (1.4142135623730950488, 0.70710678118654752440),
    1.0: (2.0000000000000000000, 0.0),
}
SITES = np.arange(200)


def ring(shift: Array, velocities: Array) -> pc.Scene:
    """A periodic chain laid out straight: the spring from the last to the first is 199 long and just as stiff.

    Along the chain its elongation is u_199 − u_0, so that it pushes where its neighbors in the ring would.
    """
    pairs = np.stack([SITES, (SITES + 1) % 200], axis=1)
    lengths = np.where(SITES == 199, 199.0, 1.0)
    body = pc.SpringNetwork(line(SITES + shift), pairs, 1.0, rest_length=lengths, velocities=line(velocities))
    return pc.Scene(body)


@pytest.mark.parametrize("wave", DISPERSION)
def test_e02_the_frequency_of_a_wave(wave, record_property):
    """Excellent: 1e-8. Standing waves of 0.1 m at 200 m: rounding 1e-14 m, second difference (0.006)² of 0.1 m."""
    shape = np.cos(wave * np.pi * SITES)
    run = simulation(ring(0.1 * shape, 0.0 * shape), VERLET, 0.02)
    series = [shape @ (run.positions[:, 0] - SITES)]
    for _ in range(5000):
        run.step(1)
        series.append(shape @ (run.positions[:, 0] - SITES))
    error = modal_frequency(np.array(series), 0.02) / DISPERSION[wave][0] - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 1e-8


@pytest.mark.parametrize("integrator", **STIFF_METHODS)
def test_e02_the_frequency_of_a_wave_by_methods_for_stiff_matter(integrator, record_property):
    """Good: 1e-4; rounding as above, 1e-13 of the amplitude over (ω dt)² ≥ 2e-4."""
    for wave in (0.25, 1.0):
        shape = np.cos(wave * np.pi * SITES)
        run = simulation(ring(0.1 * shape, 0.0 * shape), integrator, 0.02)
        series = []
        for _ in range(60):
            run.step(1)
            series.append(shape @ (run.positions[:, 0] - SITES))
        error = recurrence_frequency(np.array(series), 0.02, integrator) / DISPERSION[wave][0] - 1.0
        record_property("error", f"{error:.1e}")
        assert abs(error) <= 1e-8


@pytest.mark.parametrize("wave", DISPERSION)
def test_e02_a_wave_packet_travels_with_the_group_velocity(wave, record_property):
    """Excellent: 1e-3, absolute where the figure is 0. The center of energy of a Gaussian packet, 20 sites wide.

    Its spectrum has a width of σ = 1/40, over which the mean of cos(q/2) is off by σ²/8 = 8e-5; dt = 0.02 adds
    (ω dt)²/8 ≤ 2e-4.
    """
    q, (omega, expected) = wave * np.pi, DISPERSION[wave]
    envelope = 0.01 * np.exp(-(((SITES - 70.0) / 20.0) ** 2) / 2.0)
    phase = q * (SITES - 70.0)
    # u = A(x − v t) cos(q x − ω t) at t = 0, with A' = −A (x − 70)/20².
    velocities = omega * envelope * np.sin(phase) + expected * envelope * (SITES - 70.0) / 400.0 * np.cos(phase)
    run = simulation(ring(envelope * np.cos(phase), velocities), VERLET, 0.02)

    def center() -> float:
        shift, speed = run.positions[:, 0] - SITES, run.velocities[:, 0]
        stretch = np.roll(shift, -1) - shift
        energy = 0.5 * speed**2 + 0.25 * (stretch**2 + np.roll(stretch, 1) ** 2)
        turned = np.angle(energy @ np.exp(2j * np.pi * (SITES - 100) / 200.0))
        return float(turned * 200.0 / (2.0 * np.pi))

    first = center()
    run.run(60.0)
    velocity = (center() - first) / run.time
    record_property("group velocity", f"{velocity:.5f}")
    assert velocity == pytest.approx(expected, abs=1e-3 * max(expected, 1e-3) if expected else 1e-3)


# E08. Source: ω² = 4 (T/(m a)) (sin² + sin²), 8 × 8 masses, T/(m a) = 1, fixed edges.
MEMBRANE = {
    (1, 1): 0.49115121587589138715,
    (1, 2): 0.76715439918586607913,
    (2, 2): 0.96737905059190105411,
    (8, 8): 2.7854569612800757716,
}


@pytest.mark.parametrize("mode", MEMBRANE)
def test_e08_the_transverse_modes_of_a_membrane(mode, record_property):
    """Excellent: 1e-6. Springs of rest length 0 are linear to the bit, T = k a; with an amplitude of 1e-5 m ones of
    rest length 0.5 (k = 2, T = 2 · 0.5) are linear to 1e-10.
    """
    sites = np.arange(10)
    shape = np.outer(np.sin(mode[0] * np.pi * sites / 9), np.sin(mode[1] * np.pi * sites / 9))
    for rest, stiffness in ((0.0, 1.0), (0.5, 2.0)):
        body = membrane(1.0, rest, stiffness, 1.0, 10, heights=1e-5 * shape)
        run = simulation(pc.Scene(body), VERLET, 0.02)
        series = [shape.ravel() @ run.positions[:, 2]]
        for _ in range(1000):
            run.step(1)
            series.append(shape.ravel() @ run.positions[:, 2])
        error = modal_frequency(np.array(series), 0.02) / MEMBRANE[mode] - 1.0
        record_property(f"error, rest length {rest}", f"{error:.1e}")
        assert abs(error) <= 1e-6


@pytest.mark.parametrize("integrator", **STIFF_METHODS)
@pytest.mark.parametrize("mode", [(1, 1), (8, 8)])
def test_e08_the_transverse_modes_by_methods_for_stiff_matter(mode, integrator, record_property):
    """Excellent: 1e-6, of springs of rest length 0, which are linear."""
    sites = np.arange(10)
    shape = np.outer(np.sin(mode[0] * np.pi * sites / 9), np.sin(mode[1] * np.pi * sites / 9))
    run = simulation(pc.Scene(membrane(1.0, 0.0, 1.0, 1.0, 10, heights=0.1 * shape)), integrator, 0.02)
    series = []
    for _ in range(60):
        run.step(1)
        series.append(shape.ravel() @ run.positions[:, 2])
    error = recurrence_frequency(np.array(series), 0.02, integrator) / MEMBRANE[mode] - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 1e-6


# E14. Source: 2 × 2 eigenproblem; wall − k₁ − m − k₂ − m, k₁ = 1, k₂ = 1e8, m = 1, x = (1, 1) at rest.
STIFF = (0.7053479129038171566300, 0.7053479122440830802584)
STIFF_LIMIT = 0.0001414213560605328094730


def stiff(precision: str = "f64") -> pc.Simulation:
    """The rest lengths are 1 m, so the masses start at 1 + 1 and 2 + 1."""
    body = pc.SpringNetwork(line([0.0, 2.0, 3.0]), [[0, 1], [1, 2]], [1.0, 1e8], rest_length=1.0, fixed=[0])
    return simulation(pc.Scene(body), VERLET, 1e-4, precision=precision)


def test_e14_a_stiffness_ratio_of_1e8(record_property):
    """Excellent: 1.6e-9 at t = 10, Verlet with dt = 1e-4 (0.707 of the limit).

    The textbook's code measures displacements and makes 1.45e-9. Positions of 3 m round the stiff spring's length to
    4e-16 m, its force to 4e-8 N, at random: 1e5 steps of 1e-4 s of that add 1e-9 m at the worst.
    """
    run = stiff()
    run.step(100_000)
    error = np.abs(run.positions[1:, 0] - [1.0, 2.0] - STIFF).max()
    record_property("error", f"{error:.2e}")
    assert error <= 1.6e-9


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [
        (pc.ImplicitMidpoint(), 1e-4),
        (pc.BDF2(), 1e-3),
        (pc.RATTLE(), 1e-4),
        (pc.XPBD(substeps=10), 1e-2),
        (pc.BackwardEuler(), 3e-2),
        (pc.ProjectiveDynamics(200), 3e-2),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, pc.Integrator) else "",
)
def test_e14_the_slow_mode_in_steps_of_a_hundredth(integrator, tolerance, record_property):
    """Excellent: 1e-4, good: 1e-2, of an amplitude of 1 m, in steps that are 70 times Verlet's limit.

    The midpoint rule is late by (ω dt)²/12 of ωt = 7, 3e-5; Verlet's, with a rod for the stiff spring, early by half;
    BDF2 late by four times as much. Euler's damps by ω² dt t/2: 2.5 %, and XPBD in ten parts of a step 0.25 %.
    """
    k2 = np.inf if isinstance(integrator, pc.RATTLE) else 1e8
    body = pc.SpringNetwork(line([0.0, 2.0, 3.0]), [[0, 1], [1, 2]], [1.0, k2], rest_length=1.0, fixed=[0])
    run = simulation(pc.Scene(body), integrator, 0.01)
    run.step(1000)
    error = np.abs(run.positions[1:, 0] - [1.0, 2.0] - STIFF).max()
    record_property("error", f"{error:.1e}")
    assert error <= tolerance


def test_e14_the_limit():
    """Gram's bound d_i/m_i + d_j/m_j is 4e8 + 1 where ω² is 2e8 + ½: a factor of √2 on the safe side, no more."""
    limit = pc.stability_limit(stiff().scene, VERLET)
    assert STIFF_LIMIT / np.sqrt(2.0) * (1.0 - 1e-8) <= limit <= STIFF_LIMIT


# E16. Source: E. Fermi, J. Pasta, S. Ulam, M. Tsingou, Los Alamos report LA-1940 (1955); own DOP853 runs at 1e-12 and
# 1e-13. N = 32, α = 1/4, x_i = sin(iπ/32), force (D₊ − D₋)(1 + α (D₊ + D₋)).
def fermi_pasta_ulam_tsingou(integrator: pc.Integrator, dt: float) -> pc.Simulation:
    """The whole force is a CustomForce: the shift of particle i stands in the place of its x."""

    def force(time: float, positions: Array, velocities: Array) -> Array:
        x = positions[:, 0]
        stretch = x[1:] - x[:-1]
        pull = stretch * (1.0 + 0.25 * stretch)
        result = np.zeros_like(positions)
        result[1:-1, 0] = pull[1:] - pull[:-1]
        return result

    def potential(positions: Array) -> float:
        stretch = np.diff(positions[:, 0])
        return float((stretch**2 / 2.0 + 0.25 * stretch**3 / 3.0).sum())

    shift = np.sin(np.arange(33) * np.pi / 32.0)
    shift[[0, -1]] = 0.0
    body = pc.Particles(line(shift), fixed=[0, 32])
    return simulation(pc.Scene(body, pc.CustomForce(force, potential)), integrator, dt)


def first_mode(run: pc.Simulation) -> float:
    """Energy of the first mode [J]."""
    shape = np.sqrt(2.0 / 32.0) * np.sin(np.arange(33) * np.pi / 32.0)
    frequency = 2.0 * np.sin(np.pi / 64.0)
    return float(((shape @ run.velocities[:, 0]) ** 2 + (frequency * (shape @ run.positions[:, 0])) ** 2) / 2.0)


def recurrence(integrator: pc.Integrator, dt: float, start: float, end: float, stride: int = 1) -> tuple[float, float]:
    """When the first mode has most energy between two times, and how much of the first."""
    run = fermi_pasta_ulam_tsingou(integrator, dt)
    first = first_mode(run)
    assert first == pytest.approx(0.07704437324484982, rel=1e-14)
    assert run.energy().total == pytest.approx(0.07704437324484983, rel=1e-14)
    run.run(start)
    times, energies = [], []
    while run.time < end:
        run.step(stride)
        times.append(run.time)
        energies.append(first_mode(run) / first)
    best = int(np.argmax(energies))
    return times[best], energies[best]


def test_e16_the_recurrence_with_the_original_time_step(record_property):
    """Excellent: the maximum, 0.977756, in cycle 28390 ± 20 of dt = 1/√8."""
    dt = 1.0 / np.sqrt(8.0)
    time, fraction = recurrence(VERLET, dt, 9900.0, 10_200.0)
    cycle = round(time / dt)
    record_property("cycle and fraction", f"{cycle}, {fraction:.6f}")
    assert abs(cycle - 28_390) <= 20
    assert fraction == pytest.approx(0.977756, abs=0.001)


@pytest.mark.long
@pytest.mark.parametrize(
    ("integrator", "dt", "tolerance"), [(pc.PEFRL(), 0.2, 1e-3), (VERLET, 0.05, 1e-2)], ids=["PEFRL", "Verlet"]
)
def test_e16_the_recurrence(integrator, dt, tolerance, record_property):
    """Excellent: t = 9378 within 0.1 %, and 0.9811 of the energy within 0.001.

    Verlet with dt = 0.05 reaches good, 1 %: its frequencies are too large by (ω dt)²/24, which delays the recurrence by
    659 · (0.05 √8)² = 13 s, as the 659 s at dt = 1/√8 scale. PEFRL has order 4 and takes the same evaluations.
    """
    time, fraction = recurrence(integrator, dt, 9200.0, 9550.0)
    record_property("time and fraction", f"{time:.1f}, {fraction:.6f}")
    assert time == pytest.approx(9378.0, rel=tolerance)
    assert fraction == pytest.approx(0.981267, abs=0.001)

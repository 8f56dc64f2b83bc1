"""Validation, area E: where chains, nets and beams hang, against closed forms and independent computations.

"Excellent" and "good" are the tolerances of the catalogue from which the cases are taken.
"""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, line, membrane, simulation

pytestmark = pytest.mark.validation

VERLET = pc.VelocityVerlet()


# Steps of a method for stiff matter [s], and what it leaves of equilibria: forces are balanced to 1e-10 of the largest.
METHODS = [pc.BackwardEuler(), pc.BDF2(), pc.ImplicitMidpoint(), pc.ProjectiveDynamics(20)]


def name(integrator: pc.Integrator) -> str:
    return type(integrator).__name__


def come_to_rest(scene: pc.Scene, integrator: pc.Integrator, duration: float, dt: float) -> pc.Simulation:
    """Let a damped scene come to rest in long steps."""
    run = simulation(scene, integrator, dt)
    run.run(duration)
    return run


def settle(scene: pc.Scene, duration: float, precision: str = "f64", fraction: float = 0.4) -> pc.Simulation:
    """Let a damped scene come to rest."""
    run = simulation(scene, VERLET, fraction * pc.stability_limit(scene, VERLET), precision=precision)
    run.run(duration)
    return run


def hanging() -> tuple[pc.Scene, Array]:
    """The chain of E04, and where it hangs."""
    sites = np.arange(21)
    pairs = np.stack([sites[:-1], sites[1:]], axis=1)
    body = pc.SpringNetwork(line(0.05 * sites), pairs, 1000.0, damping=1.0, rest_length=0.05, mass=0.1, fixed=[0])
    expected = 0.05 * sites + 0.1 * 9.81 / 1000.0 * np.cumsum(np.where(sites > 0, 21 - sites, 0))
    return pc.Scene(body, pc.Gravity((9.81, 0.0)), pc.Drag(1.5)), expected


@pytest.mark.parametrize("integrator", METHODS, ids=name)
def test_e04_a_chain_hanging_in_long_steps(integrator, record_property):
    """Excellent: 1e-10 relative. At 1/50 s; forces of 20 N to 1e-10 over 50 N/m of the chain: 4e-11 m."""
    scene, expected = hanging()
    run = come_to_rest(scene, integrator, 10.0, 0.02)
    error = np.abs(run.positions[1:, 0] / expected[1:] - 1.0).max()
    record_property("error", f"{error:.1e}")
    assert error <= 1e-9


def test_e04_a_chain_hanging_under_its_weight(record_property):
    """Source: y_i = i L₀ + (m g/k) Σ_(j≤i) (N − j + 1), N = 20. Excellent: 1e-10 relative.

    Slowest mode: ω = 2 √(k/m) sin(π/82) = 7.7/s; at critical drag b = 2 m ω it falls as t e^(−ωt): 1e-20 in 7 s.
    """
    scene, expected = hanging()
    run = settle(scene, 7.0)
    for site, figure in ((1, 0.06962), (10, 0.652055), (20, 1.20601)):
        assert expected[site] == pytest.approx(figure, rel=1e-15)
    error = np.abs(run.positions[1:, 0] / expected[1:] - 1.0).max()
    record_property("error", f"{error:.1e}")
    assert error <= 1e-10


# E06. Source: one scalar equation for the horizontal force of the discrete chain; length 2, span 1, 20 links of 0.1.
CATENARY_NODES = (
    -0.0981961439513569343, -0.195640890491162958, -0.292078874973707144, -0.387106529861024144,
    -0.480052607630607826, -0.569731702018003301, -0.653906289962255154, -0.728090224296954414,
    -0.783255645874026131, -0.804755102515979136,
)  # fmt: skip
CATENARY_FORCE, CATENARY_SAG = 2.276806350421256788480, 0.8047551025159791360097


# The same of rigid links: one scalar equation, H = 2.2957 m g.
RIGID_SAG, RIGID_FORCE, RIGID_END = 0.7982731089156397200084, 2.295667632235486457889, 9.773437976356819583004


def catenary(stiffness: float, start: Array) -> pc.Scene:
    """Twenty links between two points at the same height, m g = 1 N, with drag."""
    sites = np.arange(21)
    pairs = np.stack([sites[:-1], sites[1:]], axis=1)
    damping = 5.0 if np.isfinite(stiffness) else 0.0
    body = pc.SpringNetwork(start, pairs, stiffness, damping=damping, rest_length=0.1, mass=0.1, fixed=[0, 20])
    return pc.Scene(body, pc.Gravity((0.0, -10.0)), pc.Drag(0.7))


def triangle() -> Array:
    """Two straight legs of ten links of 0.1 m, between ends a meter apart."""
    half = np.linspace(0.0, 1.0, 11)[:, None]
    low, span = np.array([0.5, -np.sqrt(0.75)]), np.array([1.0, 0.0])
    return np.vstack([low * half, low + (span - low) * half[1:]])


@pytest.mark.parametrize("integrator", METHODS, ids=name)
def test_e06_a_catenary_of_stiff_springs_in_long_steps(integrator, record_property):
    """Excellent: 1e-9, at 1/100 s."""
    run = come_to_rest(catenary(1e4, triangle()), integrator, 14.0, 0.01)
    error = abs(-run.positions[10, 1] / CATENARY_SAG - 1.0)
    record_property("error of the sag", f"{error:.1e}")
    assert error <= 1e-9
    np.testing.assert_allclose(run.positions[1:11, 1], CATENARY_NODES, rtol=1e-8)


def test_e06_a_catenary_of_rigid_links(record_property):
    """Excellent: 1e-5; RATTLE's equilibrium is that of rigid links to rounding, tensions included."""
    scene = catenary(np.inf, triangle())
    run = come_to_rest(scene, pc.RATTLE(), 14.0, 0.005)
    error = abs(-run.positions[10, 1] / RIGID_SAG - 1.0)
    record_property("error of the sag", f"{error:.1e}")
    assert error <= 1e-10
    tensions = run[scene.bodies[0]].tensions
    assert tensions[0] == pytest.approx(RIGID_END, rel=1e-9)
    first = run.positions[1] - run.positions[0]
    assert tensions[0] * first[0] / 0.1 == pytest.approx(RIGID_FORCE, rel=1e-9)


@pytest.mark.parametrize(("substeps", "tolerance"), [(20, 1e-3), (200, 1e-5)])
def test_e06_a_catenary_of_rods_by_sweeps(substeps, tolerance, record_property):
    """Excellent: 1e-5, by XPBD of enough parts: what a sweep misses falls as their square."""
    run = come_to_rest(catenary(np.inf, triangle()), pc.XPBD(substeps), 10.0, 0.01)
    error = abs(-run.positions[10, 1] / RIGID_SAG - 1.0)
    record_property("error of the sag", f"{error:.1e}")
    assert error <= tolerance


def test_e06_a_catenary_of_stiff_springs(record_property):
    """Excellent: sag to 1e-9, k = 1e4 and m g = 1 N.

    It swings at about √(g/sag) = 3.5/s; with a drag of b/m = 7/s that falls as e^(−3.5t), to 1e-15 in 10 s.
    """
    sites = np.arange(21)
    arc = np.pi * sites / 20.0
    start = np.stack([sites / 20.0, -0.8 * np.sin(arc)], axis=1)
    run = settle(catenary(1e4, start), 14.0)
    error = abs(-run.positions[10, 1] / CATENARY_SAG - 1.0)
    record_property("error of the sag", f"{error:.1e}")
    assert error <= 1e-9
    np.testing.assert_allclose(run.positions[1:11, 1], CATENARY_NODES, rtol=1e-9)
    first = run.positions[1] - run.positions[0]
    length = np.linalg.norm(first)
    # The horizontal force is k (l − L₀) cos: l − L₀ is 1e-3 m, of which 1e-13 m is 1e-9 of the force.
    assert 1e4 * (length - 0.1) * first[0] / length == pytest.approx(CATENARY_FORCE, rel=1e-8)


# E09. Source: Newton's method, residual 2e-14 N; all springs in tension, so the equilibrium is unique.
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-10), ("f32", 2e-6)])
def test_e09_a_taut_net_under_its_weight(precision, tolerance, record_property):
    """Excellent: node positions to 1e-10 m in f64 and 2e-6 m in f32; the energy to the digits given.

    Slowest mode: transverse, ω² = (T/ma) · 2 (π/10)² with T ≈ 1 N: ω = 14/s, and a drag of b/m = 28/s is critical; 3 s
    take it to 1e-17.
    """
    body = membrane(0.1, 0.09, 100.0, 0.01, 11, damping=0.1)
    run = settle(pc.Scene(body, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(0.28)), 3.0, precision)
    nodes = run.positions.reshape(11, 11, 3)
    figures = {
        (5, 5): (0.5, 0.5, -0.0655265589939),
        (2, 5): (0.5, 0.1977723730813, -0.0440652954443),
        (1, 1): (0.0995426038463, 0.0995426038463, -0.0117167210239),
    }
    error = max(np.abs(nodes[node] - figure).max() for node, figure in figures.items())
    record_property("error", f"{error:.1e}")
    assert error <= tolerance
    # At the equilibrium the energy is stationary: it is off by rounding, and in f32 by that of lengths of 0.1 m.
    energy = 0.9439481039737
    assert run.energy().potential == pytest.approx(energy, abs=1e-12 if precision == "f64" else 1e-6)


@pytest.mark.parametrize("integrator", METHODS, ids=name)
def test_e09_a_taut_net_in_long_steps(integrator, record_property):
    """Excellent: node positions to 1e-10 m, at 1/50 s."""
    body = membrane(0.1, 0.09, 100.0, 0.01, 11, damping=0.1)
    run = come_to_rest(pc.Scene(body, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(0.28)), integrator, 6.0, 0.02)
    error = abs(run.positions.reshape(11, 11, 3)[5, 5, 2] + 0.0655265589939)
    record_property("error", f"{error:.1e}")
    assert error <= 1e-9


# E11. Source: K. E. Bisshopp, D. C. Drucker, Q. Appl. Math. 3 (1945) 272; elliptic integrals. α = P L²/(E I).
CANTILEVER = {
    1: (0.301720773799813530, 0.943566763716623117),
    5: (0.713791523611912728, 0.612371639275570128),
    10: (0.810609024880296453, 0.445004402246248730),
}


def cantilever(load: float, segments: int, stiffness: float = 1e5) -> tuple[float, float]:
    """Drop and horizontal reach of the tip of a beam, L = E I = 1, of springs of E A = `stiffness` and elastic hinges.

    A hinge between two segments turns them with E I θ/h; the one at the wall stands for half a segment only. The load
    is a force on the tip. Slowest mode 3.5/s: a drag of b/m = 7/s is critical, and 4 s take it to 1e-6.
    """
    h = 1.0 / segments
    hinges = np.full(segments, 1.0 / h)
    hinges[0] = 2.0 / h

    def force(time: float, positions: Array, velocities: Array) -> Array:
        span = np.diff(positions, axis=0)
        moment = hinges * np.diff(np.arctan2(span[:, 1], span[:, 0]), prepend=0.0)
        turning = moment - np.append(moment[1:], 0.0)
        # ∂φ/∂x of a segment is its normal over its length.
        shear = (turning / (span**2).sum(axis=1))[:, None] * np.stack([-span[:, 1], span[:, 0]], axis=1)
        result = np.zeros_like(positions)
        result[1:] -= shear
        result[:-1] += shear
        result[-1, 1] -= load
        return result

    nodes = np.arange(segments + 1)
    pairs = np.stack([nodes[:-1], nodes[1:]], axis=1)
    rigid = np.isinf(stiffness)
    damping = 0.0 if rigid else 100.0
    beam = pc.SpringNetwork(line(h * nodes), pairs, stiffness / h, damping=damping, rest_length=h, mass=h, fixed=[0])
    scene = pc.Scene(beam, pc.CustomForce(force), pc.Drag(7.0 * h))
    # The hinges' frequency, 4/h² and more at the wall, is below that of the springs, 2 √(E A)/h, of which the limit
    # knows.
    if rigid:
        run = simulation(scene, pc.RATTLE(), 0.1 * h * h)
    else:
        run = simulation(scene, VERLET, 0.6 * pc.stability_limit(scene, VERLET))
    run.run(4.0)
    return -float(run.positions[-1, 1]), float(run.positions[-1, 0])


def test_e11_an_inextensible_cantilever(record_property):
    """Of rods, as in the theory: good, 1 %, with 10 segments, of which the error is of order 2."""
    drop, reach = cantilever(5.0, 10, np.inf)
    record_property("errors", f"{drop / CANTILEVER[5][0] - 1:.1e}, {reach / CANTILEVER[5][1] - 1:.1e}")
    np.testing.assert_allclose((drop, reach), CANTILEVER[5], rtol=1e-2)


@pytest.mark.long
@pytest.mark.parametrize("load", CANTILEVER)
def test_e11_a_cantilever_with_a_tip_load(load, record_property):
    """Excellent: 0.1 % with 50 segments. The springs are strained by α/1e5 ≤ 1e-4."""
    drop, reach = cantilever(float(load), 50)
    record_property("errors", f"{drop / CANTILEVER[load][0] - 1:.1e}, {reach / CANTILEVER[load][1] - 1:.1e}")
    np.testing.assert_allclose((drop, reach), CANTILEVER[load], rtol=1e-3)


@pytest.mark.long
def test_e11_the_order_in_the_number_of_segments(record_property):
    """Excellent: 2 within 0.1, from successive differences, from which the springs' strain drops out."""
    coarse, middle, fine = (cantilever(5.0, segments)[0] for segments in (10, 20, 40))
    order = np.log2((coarse - middle) / (middle - fine))
    record_property("order", f"{order:.3f}")
    assert order == pytest.approx(2.0, abs=0.1)

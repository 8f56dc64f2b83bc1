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


def settle(scene: pc.Scene, duration: float, precision: str = "f64", fraction: float = 0.4) -> pc.Simulation:
    """Let a damped scene come to rest."""
    run = simulation(scene, VERLET, fraction * pc.stability_limit(scene, VERLET), precision=precision)
    run.run(duration)
    return run


def test_e04_a_chain_hanging_under_its_weight(record_property):
    """Source: y_i = i L₀ + (m g/k) Σ_(j≤i) (N − j + 1), N = 20. Excellent: 1e-10 relative.

    Slowest mode: ω = 2 √(k/m) sin(π/82) = 7.7/s; at critical drag b = 2 m ω it falls as t e^(−ωt): 1e-20 in 7 s.
    """
    sites = np.arange(21)
    pairs = np.stack([sites[:-1], sites[1:]], axis=1)
    body = pc.SpringNetwork(line(0.05 * sites), pairs, 1000.0, damping=1.0, rest_length=0.05, mass=0.1, fixed=[0])
    run = settle(pc.Scene(body, pc.Gravity((9.81, 0.0)), pc.Drag(1.5)), 7.0)
    expected = 0.05 * sites + 0.1 * 9.81 / 1000.0 * np.cumsum(np.where(sites > 0, 21 - sites, 0))
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


def test_e06_a_catenary_of_stiff_springs(record_property):
    """Excellent: sag to 1e-9, k = 1e4 and m g = 1 N.

    It swings at about √(g/sag) = 3.5/s; with a drag of b/m = 7/s that falls as e^(−3.5t), to 1e-15 in 10 s.
    """
    sites = np.arange(21)
    arc = np.pi * sites / 20.0
    start = np.stack([sites / 20.0, -0.8 * np.sin(arc)], axis=1)
    pairs = np.stack([sites[:-1], sites[1:]], axis=1)
    body = pc.SpringNetwork(start, pairs, 1e4, damping=5.0, rest_length=0.1, mass=0.1, fixed=[0, 20])
    run = settle(pc.Scene(body, pc.Gravity((0.0, -10.0)), pc.Drag(0.7)), 14.0)
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


# E11. Source: K. E. Bisshopp, D. C. Drucker, Q. Appl. Math. 3 (1945) 272; elliptic integrals. α = P L²/(E I).
CANTILEVER = {
    1: (0.301720773799813530, 0.943566763716623117),
    5: (0.713791523611912728, 0.612371639275570128),
    10: (0.810609024880296453, 0.445004402246248730),
}


def cantilever(load: float, segments: int) -> tuple[float, float]:
    """Drop and horizontal reach of the tip of a beam with L = E I = 1, of springs with E A = 1e5 and elastic hinges.

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
    beam = pc.SpringNetwork(line(h * nodes), pairs, 1e5 / h, damping=100.0, rest_length=h, mass=h, fixed=[0])
    scene = pc.Scene(beam, pc.CustomForce(force), pc.Drag(7.0 * h))
    # The hinges' frequency, 4/h², is below that of the springs, 2 √(E A)/h, of which the limit knows.
    run = simulation(scene, VERLET, 0.6 * pc.stability_limit(scene, VERLET))
    run.run(4.0)
    return -float(run.positions[-1, 1]), float(run.positions[-1, 0])


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

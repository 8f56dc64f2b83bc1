"""Validation, area C: attraction at rounding error, with the states of integrations in 45 to 60 digits."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array

pytestmark = pytest.mark.validation

RADAU = pc.GaussRadau15()


def rows(*coordinates: float) -> Array:
    """x y of each body, then its velocities, as the sources list them."""
    return np.array(coordinates).reshape(2, -1, 2)


def state(run: pc.Simulation) -> Array:
    return np.stack([run.positions, run.velocities])


# C07. Source: a Taylor series of 45 digits from the published start, A. Chenciner, R. Montgomery, Ann. Math. 152 (2000)
# 881; the refined period and velocity: Newton's method on the symmetry of the curve, 45 digits.
PUBLISHED = (0.466203685, 0.43236573)
REFINED, PERIOD = (0.4662036840695393534032714, 0.4323657309174768500529278), 6.3259140097821385504247
AT_20 = rows(
    *(0.98433713412227406516, 0.22908012805979019378, -0.029911847737685949318),
    *(0.027701575181485578702, -0.95442528638458811585, -0.25678170324127577248),
    *(-0.42816925410338903502, 0.44110532756411701614, 0.93408101268157001954),
    *(-0.86261493704111030757, -0.50591175857818098452, 0.42150960947699329143),
)


def eight(velocity: tuple[float, float]) -> pc.Scene:
    places = np.array([[0.97000436, -0.24308753], [-0.97000436, 0.24308753], [0.0, 0.0]])
    velocities = np.outer([1.0, 1.0, -2.0], velocity)
    return pc.Scene(pc.Particles(places, velocities), pc.Gravitation(1.0))


def test_c07_a_figure_of_eight_to_rounding(record_property):
    """Excellent: closure within 5.6e-12. The curve is stable: the start, rounded by ε/4 of 1, is what is off by then,
    and grows like t² at the most: (2 π)² ε = 1e-14.
    """
    scene = eight(REFINED)
    run = pc.Simulation(scene, RADAU)
    run.run(PERIOD)
    missed = float(np.abs(run.positions - scene.bodies[0].positions).max())
    run = pc.Simulation(eight(PUBLISHED), RADAU)
    run.run(20.0)
    off = float(np.abs(state(run) - AT_20).max())
    record_property("closure; off at t = 20", f"{missed:.1e}; {off:.1e}")
    assert missed < 1e-14
    assert off < 1e-13  # 20² ε = 9e-14


# C08. Source: a Taylor series of 60 digits; V. Szebehely, C. F. Peters, Astron. J. 72 (1967) 876.
BURRAU = {
    10.0: rows(
        *(0.77848041013808549311, 0.14139230029008616862, -2.0250924779781985862),
        *(0.097219384146058396502, 1.1529857362997075731, -0.16261088749089841837),
        *(1.7339443623805864286, 3.2247383696182900261, -0.28255545657033173998),
        *(-0.38629894784371772808, -0.8143222521720864652, -1.6258038634959998332),
    ),
    20.0: rows(
        *(3.0042926366963992054, 0.5119252350246858656, -1.3886265375108953925),
        *(-0.47047605025272216813, -0.6916743520091232093, 0.069225699187366215144),
        *(-0.41778276805919944142, 0.27458362540654598952, -1.9686266637948724347),
        *(-0.23332743385499795243, 1.8255709918714176126, 0.021911771840070768234),
    ),
}
ENERGY = -12.816666666666666667


def test_c08_three_bodies_from_rest(record_property):
    """Excellent: 1e-9 at t = 10 and 1e-6 at t = 20, after the encounter at 4.1e-4 in t = 15.83, which multiplies errors
    by some 1e4; the energy within 1e-10. Good to 1e-8 at t = 20: ε, times the 1e7 by which errors have grown, is 2e-9.
    An ulp of the places, ε/2, is 3e-13 of that distance, and of a potential energy of 5e4 J in some hundred steps at
    random.
    """
    start = pc.Particles([[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]], mass=[3.0, 4.0, 5.0])
    run = pc.Simulation(pc.Scene(start, pc.Gravitation(1.0)), RADAU)
    assert run.energy().total == pytest.approx(ENERGY, rel=1e-15)
    off = {}
    for time, expected in BURRAU.items():
        run.run(time - run.time)
        off[time] = float(np.abs(state(run) - expected).max())
    drift = abs(run.energy().total / ENERGY - 1.0)
    record_property("off at t = 10, 20; energy", f"{off[10.0]:.1e}, {off[20.0]:.1e}; {drift:.1e}")
    assert off[10.0] < 1e-11
    assert off[20.0] < 1e-8
    assert drift < 1e-10


# C10. Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, sec. II.10; IVP Test Set.
PLEIADES = np.array(
    [
        [
            *(0.370613914397051290094, 3.237284092057233092803, -3.2225590324183233471, 0.659709145577530835935),
            *(0.3425581707156579790377, 1.562172101400631016046, -0.7003092922212495385147),
        ],
        [
            *(-3.943437585517392055278, -3.271380973972549928021, 5.225081843456544192439, -2.590612434977469510811),
            *(1.198213693392274637514, -0.2429682344935823409161, 1.091449240428979747882),
        ],
    ]
)


def test_c10_the_pleiades(record_property):
    """Excellent: within 1e-9 at t = 3. Errors grow by some 1e4 in the encounters: 1e4 ε is 2e-12."""
    places = np.array([[3, 3, -1, -3, 2, -2, 2], [3, -3, 2, 0, 0, -4, 4]], dtype=float).T
    velocities = np.array([[0, 0, 0, 0, 0, 1.75, -1.5], [0, 0, 0, -1.25, 1, 0, 0]], dtype=float).T
    stars = pc.Particles(places, velocities, mass=np.arange(1.0, 8.0))
    run = pc.Simulation(pc.Scene(stars, pc.Gravitation(1.0)), RADAU)
    run.run(3.0)
    off = float(np.abs(run.positions.T - PLEIADES).max())
    record_property("off", f"{off:.1e}")
    assert off < 5e-12


# C11. Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, p. 129.
MOON, PERIOD_OF_ARENSTORF = 0.012277471, 17.0652165601579625588917206249
SPEED, HALFWAY = -2.00158510637908252240537862224, (-1.244822052026569705585, 0.5539903081422230677753)


def rotating(time: float, positions: Array, velocities: Array) -> Array:
    """Coriolis, centrifugal and attracting forces in the frame that turns with the earth and the moon."""
    earth, moon = (positions - (place, 0.0) for place in (-MOON, 1.0 - MOON))
    pulls = [mass * d / ((d**2).sum(axis=1) ** 1.5)[:, None] for mass, d in ((1.0 - MOON, earth), (MOON, moon))]
    turned = np.stack([velocities[:, 1], -velocities[:, 0]], axis=1)
    return positions + 2.0 * turned - pulls[0] - pulls[1]


def test_c11_arenstorfs_orbit_of_four_loops(record_property):
    """Excellent: closure within 1e-7. A force that depends on velocity, in passes 0.006 from the moon, that multiply
    errors by some 1e5 in all: 1e5 ε = 2e-11 and, with the moon's place rounded, ten times that.
    """
    satellite = pc.Particles([[0.994, 0.0]], [[0.0, SPEED]])
    run = pc.Simulation(pc.Scene(satellite, pc.CustomForce(rotating)), RADAU)
    half = 0.5 * PERIOD_OF_ARENSTORF
    run.run(half)
    expected = [[HALFWAY[0], 0.0]], [[0.0, HALFWAY[1]]]
    middle = float(np.abs(state(run) - np.array(expected)).max())
    run.run(half)
    closure = math.hypot(*(run.positions[0] - (0.994, 0.0)))
    record_property("off halfway, closure", f"{middle:.1e}, {closure:.1e}")
    assert middle < 1e-10
    assert closure < 2e-10

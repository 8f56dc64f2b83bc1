"""Validation, area F: flows along walls, drops, a rotating square and vortices.

"Excellent" and "good" are the tolerances of the catalogue from which the cases are taken. All fluids have the defaults
of `pc.Fluid` but for the values that a case names. Where one misses its tolerance, the test says by how much and why.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array
from validation.flows import half_axes, hole, start, widest_hole

pytestmark = pytest.mark.validation

# F04. Source: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136, 214 (1997); series of 60 terms. A channel of 1 mm,
# ν = 1e-6 m²/s, ρ = 1000 kg/m³, driven by 1e-4 m/s², at rest at first: u [m/s] at y/L = 0.1, 0.25, 0.5 by time [s].
POISEUILLE = {
    0.0225: (1.254566459693024e-6, 2.023939265325034e-6, 2.232737507021605e-6),
    0.045: (1.936029064776645e-6, 3.518050065431126e-6, 4.234570557410374e-6),
    0.1125: (3.186626726980708e-6, 6.369704365467843e-6, 8.249913844793919e-6),
    0.225: (4.067314916074194e-6, 8.384910256787162e-6, 1.109980165917942e-5),
    1.0: (4.499793805058182e-6, 9.374528175329319e-6, 1.249933273915166e-5),
}
WIDTH, NU, FASTEST = 1e-3, 1e-6, 1.25e-5
ACROSS = 50
GAP = WIDTH / ACROSS
SLOW = pc.WeaklyCompressible(sound_speed=10.0 * FASTEST)
"""Sound is ten times as fast as the flow."""
CHANNEL = (
    pc.Plane((0.0, 0.0), (0.0, 1.0), no_slip=True),
    pc.Plane((0.0, WIDTH), (0.0, -1.0), no_slip=True),
    pc.Periodic((0.0, -np.inf), (8 * GAP, np.inf)),
)


def channel_water(velocities: Array | float = 0.0) -> pc.Fluid:
    """Of eight particles along the channel and fifty across."""
    cells = pc.block((0.0, 0.0), (8 * GAP, WIDTH), GAP)
    return pc.Fluid(cells, GAP, viscosity=1e-3, velocities=velocities)


def startup(y: Array, time: float) -> Array:
    """u(y, t) of the flow between resting walls that a body force starts."""
    odd = 2 * np.arange(60)[:, None] + 1
    waves = np.sin(odd * np.pi * y / WIDTH) * np.exp(-((odd * np.pi / WIDTH) ** 2) * NU * time)
    scale = 1e-4 / NU
    return scale / 2.0 * y * (WIDTH - y) - (4.0 * scale * WIDTH**2 / (np.pi * odd) ** 3 * waves).sum(axis=0)


@pytest.fixture(scope="module")
def poiseuille() -> dict[float, tuple[Array, Array]]:
    """Found and exact speeds by time.

    The body force is a function: gravity would make the fluid start under its weight, and nothing holds it along here.
    """
    water = channel_water()
    push = water.mass[0] * np.tile([1e-4, 0.0], (len(water.positions), 1))
    run = start(water, *CHANNEL, pc.CustomForce(lambda time, positions, velocities: push), fluids=SLOW)
    profiles = {}
    for time in POISEUILLE:
        run.run(time - run.time)
        part = run[water]
        profiles[time] = part.velocities[:, 0], startup(part.positions[:, 1], time)
    return profiles


@pytest.mark.long
def test_f04_the_start_of_a_channel_flow(poiseuille, record_property):
    """Good: 2 % of the largest speed (L2), 50 particles across, at each of the five times; the first two are within the
    excellent 0.5 %.
    """
    for time, reference in POISEUILLE.items():
        np.testing.assert_allclose(startup(np.array([0.1, 0.25, 0.5]) * WIDTH, time), reference, rtol=1e-12)
        found, exact = poiseuille[time]
        error = np.sqrt(((found - exact) ** 2).mean()) / FASTEST
        record_property(f"L2 at {time} s", f"{error:.2%}")
        assert error <= (0.005 if time < 0.1 else 0.02)


@pytest.mark.long
def test_f04_the_steady_channel_flow(poiseuille, record_property):
    """Good: 1 % relative."""
    found, exact = poiseuille[1.0]
    error = float(found @ exact / (exact @ exact)) - 1.0
    record_property("error", f"{error:.2%}")
    assert abs(error) <= 0.01


def test_f04_gravity_along_a_periodic_channel_presses_nowhere(record_property):
    """Gravity along a channel without ends is a body force: ρ₀ everywhere, to rounding."""
    water = channel_water()
    run = start(water, *CHANNEL, pc.Gravity((1e-4, 0.0)), fluids=SLOW)
    densities = run[water].densities
    record_property("densities", f"{densities.min():.0f} to {densities.max():.0f}")
    np.testing.assert_allclose(densities, 1000.0, rtol=1e-12)


@pytest.mark.filterwarnings("ignore:fluids.sound_speed")  # Of the flow at the start, which is bent at a wall.
def test_couette_flow_less_its_steady_part(record_property):
    """Source: the exact series. Walls do not move here; but the start of a flow between a resting wall and one that
    moves with U, less the steady U y/L, is the decay of u = −U y/L between two resting walls.

    Tolerances as for F04: excellent, 0.5 % of U (L2). The decay of the slowest wave shows the viscosity: within 2 %.
    """
    cells = channel_water().positions
    water = channel_water(np.stack([-FASTEST * cells[:, 1] / WIDTH, 0.0 * cells[:, 1]], axis=1))
    run = start(water, *CHANNEL, fluids=SLOW)
    waves = np.arange(1, 100)[:, None]
    slowest = []
    for time in (0.0225, 0.045, 0.1125, 0.225):
        run.run(time - run.time)
        part = run[water]
        turns = waves * np.pi * part.positions[:, 1] / WIDTH
        sizes = 2.0 * FASTEST / (waves * np.pi) * (-1.0) ** waves * np.exp(-((waves * np.pi / WIDTH) ** 2) * NU * time)
        error = np.sqrt(((part.velocities[:, 0] - (sizes * np.sin(turns)).sum(axis=0)) ** 2).mean()) / FASTEST
        record_property(f"L2 at {time} s", f"{error:.2%}")
        assert error <= 0.005
        slowest.append(np.sin(turns[0]) @ part.velocities[:, 0])
        assert np.abs(part.velocities[:, 1]).max() <= 1e-6 * FASTEST
    viscosity = np.log(slowest[-2] / slowest[-1]) / ((np.pi / WIDTH) ** 2 * 0.1125 * NU) - 1.0
    record_property("viscosity", f"{viscosity:+.2%}")
    assert abs(viscosity) <= 0.02


# F07. Source: the exact solution, which decays by exp(−8π² ν t). L = U = ρ = 1, ν = 0.01.
VORTEX_RATE = 0.7895683520871486895068


@dataclass
class Vortices:
    """What was seen of the Taylor–Green flow at t = 2."""

    rate: float
    error: float
    momentum: float
    moving: float
    energy: pc.EnergySeries


def vortices_with(method: pc.FluidMethod) -> Vortices:
    """Of 50 × 50 particles."""

    def flow(x: Array) -> Array:
        turn = 2.0 * np.pi * x
        return np.stack([-np.cos(turn[:, 0]) * np.sin(turn[:, 1]), np.sin(turn[:, 0]) * np.cos(turn[:, 1])], axis=1)

    cells = pc.block((0.0, 0.0), (1.0, 1.0), 0.02)
    water = pc.Fluid(cells, 0.02, density=1.0, viscosity=0.01, velocities=flow(cells))
    run = start(water, pc.Periodic((0.0, 0.0), (1.0, 1.0)), fluids=method)
    recording = run.record(2.0, fps=10.0)
    decay = np.exp(-2.0 * VORTEX_RATE)
    speeds = np.linalg.norm(run.velocities, axis=1)
    return Vortices(
        rate=-np.log(speeds.max()) / 2.0,
        error=np.abs(run.velocities - decay * flow(run.positions)).sum(axis=1).mean() / decay,
        momentum=float(np.abs(run.momentum()).max()),
        moving=float((water.mass[:, None] * np.abs(water.velocities)).sum()),
        energy=recording.energy,
    )


@pytest.fixture(scope="module")
def vortices() -> Vortices:
    return vortices_with(pc.WeaklyCompressible())


def test_f07_vortices_decay(vortices, record_property):
    """Good: 5 % on the rate of the largest speed to t = 2, 50 × 50 particles."""
    record_property("rate, over the exact one", f"{vortices.rate / VORTEX_RATE:.3f}")
    assert vortices.rate == pytest.approx(VORTEX_RATE, rel=0.05)


def test_f07_vortices_keep_their_shape(vortices, record_property):
    """Good: 10 % of the exact maximum (L1) at t = 2."""
    record_property("L1", f"{vortices.error:.1%}")
    assert vortices.error <= 0.10


def test_f07_vortices_keep_the_momentum_and_the_budget(vortices, record_property):
    """Momentum to the rounding of single precision: forces of all steps together change the flow by its own momentum,
    and each is rounded to 1.2e-7 of itself, at random.
    """
    epsilon = float(np.finfo(np.float32).eps)
    record_property("momentum", f"{vortices.momentum / vortices.moving:.1e}")
    record_property("budget", f"{hole(vortices.energy):.1e}")
    assert vortices.momentum <= epsilon * vortices.moving
    assert hole(vortices.energy) <= widest_hole(vortices.energy)


# F09. Source: A. Colagrossi, PhD thesis, Rome (2005); invariants exact. L = ω = 1; the fluid is water.
Square = tuple[pc.Fluid, dict[float, pc.Snapshot], dict[float, float], pc.EnergySeries]


def square_with(method: pc.FluidMethod) -> Square:
    """The patch, what is seen of it at ωt = 0, 2, 4, its angular momentum then, and the budget."""
    cells = pc.block((-0.5, -0.5), (0.5, 0.5), 0.02)
    water = pc.Fluid(cells, 0.02, velocities=np.stack([cells[:, 1], -cells[:, 0]], axis=1))
    run = start(water, fluids=method)
    seen, spin = {0.0: run[water]}, {0.0: float(run.angular_momentum()[0])}
    recording = run.record(2.0, fps=10.0)
    seen[2.0], spin[2.0] = run[water], float(run.angular_momentum()[0])
    run.run(2.0)
    seen[4.0], spin[4.0] = run[water], float(run.angular_momentum()[0])
    return water, seen, spin, recording.energy


@pytest.fixture(scope="module")
def square() -> Square:
    return square_with(pc.WeaklyCompressible(shifting=0.0))


def test_f09_a_rotating_square_keeps_its_spin_its_mass_and_its_symmetry(square, record_property):
    """Excellent: angular momentum to 1e-4 until ωt = 4; Σ m/ρ to 0.3 % and four equal arms to 1 % at ωt = 2.

    At the start, less by the lattice's own: kinetic energy and spin of a square are ∫ r² = (1 − Δ²)/6.
    """
    water, seen, spin, energy = square
    assert spin[0.0] == pytest.approx(-1000.0 * (1.0 - 0.02**2) / 6.0, rel=1e-12)
    assert energy.kinetic[0] == pytest.approx(1000.0 * (1.0 - 0.02**2) / 12.0, rel=1e-12)
    loss = spin[4.0] / spin[0.0] - 1.0
    volume = (water.mass / seen[2.0].densities).sum() - 1.0
    x, y = seen[2.0].positions.T
    tip = np.argmax(np.hypot(x, y))
    around = np.rint((np.arctan2(y, x) - np.arctan2(y[tip], x[tip])) / (np.pi / 2.0)) % 4
    arms = np.array([np.hypot(x, y)[around == arm].max() for arm in range(4)])
    record_property("angular momentum", f"{loss:.1e}")
    record_property("volume", f"{volume:.3%}")
    record_property("arms differ by", f"{np.ptp(arms) / arms.mean():.2%}")
    record_property("budget", f"{hole(energy):.1e}")
    assert abs(loss) <= 1e-4
    assert abs(volume) <= 0.003
    assert np.ptp(arms) / arms.mean() <= 0.01
    assert hole(energy) <= widest_hole(energy)


def test_a_disc_that_turns_as_a_whole_goes_on(record_property):
    """Nothing is sheared and nothing presses in a well of the frequency of the turning: no viscosity can show, ν = 0.01
    m²/s. Excellent: angular momentum to 1e-4 in a turn, as in F09; kinetic energy to twice that. Forces along v, which
    are those of ∇²v, take 57 % of it.
    """
    cells = pc.ball((0.0, 0.0), 0.5, 0.025)
    water = pc.Fluid(cells, 0.025, viscosity=10.0, velocities=np.stack([-cells[:, 1], cells[:, 0]], axis=1))
    run = start(water, pc.CentralForce((0.0, 0.0), float(water.mass[0]), exponent=1.0))
    spin, kinetic = run.angular_momentum()[0], run.energy().kinetic
    run.run(2.0 * np.pi)
    losses = run.angular_momentum()[0] / spin - 1.0, run.energy().kinetic / kinetic - 1.0
    record_property("angular momentum, kinetic energy", f"{losses[0]:+.1e}, {losses[1]:+.1e}")
    assert abs(losses[0]) <= 1e-4
    assert abs(losses[1]) <= 2e-4


# F10. Source: J. J. Monaghan, A. Rafiee, Int. J. Numer. Meth. Fluids 71, 537 (2013). R = Ω = 1, σ₀ = 0.5, ρ = 1000.
DROP_PERIOD = 4.567373800552743274086
DROP_WIDEST = 1.4142135623730950488


def drop_with(method: pc.FluidMethod) -> tuple[Array, Array, pc.EnergySeries]:
    """Times, half axes, and the budget of three periods; 30 particles along a radius."""
    cells = pc.ball((0.0, 0.0), 1.0, 1.0 / 30.0)
    water = pc.Fluid(cells, 1.0 / 30.0, velocities=0.5 * cells * [1.0, -1.0])
    run = start(water, pc.CentralForce((0.0, 0.0), float(water.mass[0]), exponent=1.0), fluids=method)
    recording = run.record(3.05 * DROP_PERIOD, fps=40.0)
    return recording.times, half_axes(recording[water].positions), recording.energy


@pytest.fixture(scope="module")
def drop() -> tuple[Array, Array, pc.EnergySeries]:
    return drop_with(pc.WeaklyCompressible())


def swing(times: Array, axes: Array) -> tuple[float, float]:
    """By how much the period and the largest half axis are off."""
    stretch = np.log(axes[:, 0] / axes[:, 1])
    ends = np.flatnonzero((stretch[1:-1] > 0.0) != (stretch[2:] > 0.0)) + 1
    round_at = times[ends] + (times[1] - times[0]) * stretch[ends] / (stretch[ends] - stretch[ends + 1])
    assert len(round_at) == 6
    period = float(np.diff(round_at).mean()) * 2.0 / DROP_PERIOD - 1.0
    return period, float(axes[times < DROP_PERIOD / 2.0, 0].max()) / DROP_WIDEST - 1.0


@pytest.mark.long
def test_f10_the_period_of_an_oscillating_drop(drop, record_property):
    """Good: 2 %. It is round at the start and after every half period: from the first of these to the sixth.

    Good: 3 % on the largest half axis. The drop starts without the pressure that balances its field, and so swings in
    size as well, which is not in the solution.
    """
    times, axes, energy = drop
    period, widest = swing(times, axes)
    record_property("period", f"{period:+.2%}")
    record_property("largest half axis", f"{widest:+.2%}")
    record_property("budget", f"{hole(energy):.1e}")
    assert abs(period) <= 0.02
    assert abs(widest) <= 0.03
    assert hole(energy) <= widest_hole(energy)


@pytest.mark.long
def test_f10_an_oscillating_drop_loses_little_energy(drop, record_property):
    """Good: 5 % of the energy per period. Of the kinetic energy of the start it is five times as much."""
    times, _, energy = drop
    losses = energy.total[0] - np.interp(DROP_PERIOD * np.arange(4), times, energy.total)
    each = np.diff(losses)
    record_property("per period, of all energy", [f"{loss / energy.total[0]:.2%}" for loss in each])
    record_property("of the motion", [f"{loss / energy.kinetic[0]:.1%}" for loss in each])
    assert each.max() / energy.total[0] <= 0.05


# F12. Source: J. J. Monaghan, J. Comput. Phys. 110, 399 (1994); Taylor series. R = 1, u₀ = (−100 x, 100 y), c = 1400.
ELLIPSE = {
    0.0008: (0.92327280650081965978, 1.0831034911446969208),
    0.0038: (0.69482125228695964426, 1.4392190749902425354),
    0.0076: (0.51426647435910959692, 1.9445171907156156857),
}


def ellipse_with(shifting: float | Literal["auto"]) -> tuple[dict[float, Array], pc.EnergySeries]:
    """Half axes by time, and the budget; 30 particles along a radius."""
    cells = pc.ball((0.0, 0.0), 1.0, 1.0 / 30.0)
    flow = 100.0 * cells * [-1.0, 1.0]
    water = pc.Fluid(cells, 1.0 / 30.0, density=1.0, velocities=flow)
    method = pc.WeaklyCompressible(sound_speed=1400.0, shifting=shifting)
    recording = start(water, fluids=method).record(0.0076, fps=5000.0)
    at = {time: int(np.argmin(np.abs(recording.times - time))) for time in ELLIPSE}
    return {time: half_axes(recording[water].positions[frame]) for time, frame in at.items()}, recording.energy


@pytest.fixture(scope="module")
def ellipse() -> tuple[dict[float, Array], pc.EnergySeries]:
    return ellipse_with("auto")


def test_f12_the_long_axis_of_a_free_drop(ellipse, record_property):
    """Good: 2 % on the half axes at three times; here the long one at all, and the short one at the first two.

    Without shifting the short one is 4.6 % too long at the last: particles then stand in strands along the long axis.
    """
    found, energy = ellipse
    for time, reference in ELLIPSE.items():
        errors = found[time] / reference - 1.0
        record_property(f"at {time} s", [f"{error:+.2%}" for error in errors])
        assert abs(errors[1]) <= 0.02
        assert abs(errors[0]) <= 0.02 or time > 0.005
    record_property("budget", f"{hole(energy):.1e}")
    assert hole(energy) <= widest_hole(energy)


def test_f12_the_short_axis_of_a_free_drop(ellipse, record_property):
    """Good: 2 %."""
    error = ellipse[0][0.0076][0] / ELLIPSE[0.0076][0] - 1.0
    record_property("error", f"{error:+.2%}")
    assert abs(error) <= 0.02

"""Validation, area F: water that falls and swings: the broken dam, the standing wave, and what long steps cost.

"Excellent" and "good" are the tolerances of the catalogue from which the cases are taken. All fluids have the defaults
of `pc.Fluid`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array
from validation.flows import GRAVITY, damped_wave, hole, start, widest_hole

# A dam that breaks with the defaults throws up drops that are faster than its fall.
HASTE = pytest.mark.filterwarnings("ignore::physcore.MachWarning")

pytestmark = [pytest.mark.validation, pytest.mark.long, HASTE]

# F14. Source: J. C. Martin, W. J. Moyce, Phil. Trans. R. Soc. A 244, 312 (1952), tables 2 and 6 for n² = 2, a = 57.15
# mm: front x/a by t √(2g/a), up to 3, and height at the wall over 2a by t √(g/a), until it is less than half.
FRONT_TIMES = np.array([0.41, 0.84, 1.19, 1.43, 1.63, 1.83, 1.98, 2.20, 2.32, 2.51, 2.65, 2.83, 2.98])
FRONTS = np.array([1.11, 1.22, 1.44, 1.67, 1.89, 2.11, 2.33, 2.56, 2.78, 3.00, 3.22, 3.44, 3.67])
COLUMN_TIMES = np.array([0.56, 0.77, 0.93, 1.08, 1.28, 1.46, 1.66, 1.84, 2.00, 2.21])
COLUMNS = np.array([0.94, 0.89, 0.83, 0.78, 0.72, 0.67, 0.61, 0.56, 0.50, 0.44])
# F16. Source: S. Koshizuka, Y. Oka, Nucl. Sci. Eng. 123, 421 (1996): the same with a = 146 mm.
LARGER_TIMES = np.array([0.381, 0.769, 1.153, 1.537, 1.935, 2.323, 2.719, 3.096])
LARGER_FRONTS = np.array([1.111, 1.252, 1.505, 1.892, 2.241, 2.615, 3.003, 3.624])

WIDTH = 0.05715
"""a [m]."""
UNIT = math.sqrt(WIDTH / (2.0 * 9.81))
"""Of the times of fronts [s]."""
CUSTOMARY = 0.2
"""By how much later a front may be than in the experiment, whose gate opens in some time."""


def broken_dam(columns: int, **numerics: Any) -> tuple[pc.Fluid, pc.Simulation]:
    """A column of so many particles across and twice as many up."""
    spacing = WIDTH / columns
    water = pc.Fluid(pc.block((0.0, 0.0), (WIDTH, 2.0 * WIDTH), spacing), spacing)
    return water, start(water, pc.Box((0.0, 0.0), (6.0 * WIDTH, 4.0 * WIDTH)), GRAVITY, **numerics)


def dam_with(method: pc.FluidMethod) -> pc.Recording:
    """Until the front has gone 3 a, with 40 particles across."""
    return broken_dam(40, fluids=method)[1].record(3.3 * UNIT, fps=100.0 / UNIT)


@pytest.fixture(scope="module")
def dam() -> pc.Recording:
    return dam_with(pc.WeaklyCompressible())


def front(recording: pc.Recording) -> Array:
    """In units of a."""
    found: Array = (recording.positions[:, :, 0].max(axis=1) + WIDTH / 80.0) / WIDTH
    return found


def misfit(recording: pc.Recording, times: Array, fronts: Array, latest: float = CUSTOMARY) -> float:
    """The largest relative difference to an experiment, with the shift that makes it least."""
    found = front(recording)
    moments = recording.times / UNIT
    shifts = np.linspace(0.0, latest, 31)
    return min(float(np.abs(np.interp(times, moments + shift, found) / fronts - 1.0).max()) for shift in shifts)


def test_f14_the_front_of_a_broken_dam(dam, record_property):
    """Good: 10 % of the front for T < 3. It runs ahead, as that of any fluid without friction does, by 5 to 10 %.

    The excellent 4 % are reached with a shift of up to 0.3, and without the first point: the gate was still opening.
    """
    error = misfit(dam, FRONT_TIMES, FRONTS)
    shifted = misfit(dam, FRONT_TIMES[1:], FRONTS[1:], 0.3)
    record_property("front", f"{error:.1%}, shifted by up to 0.3 {shifted:.1%}")
    assert error <= 0.10
    assert shifted <= 0.04


def dam_break_misfits(recording: pc.Recording) -> tuple[float, float]:
    """Of the front, and of the height at the wall."""
    x, y = np.moveaxis(recording.positions, 2, 0)
    spacing = WIDTH / 40.0
    heights = (np.where(x < 2.0 * spacing, y, 0.0).max(axis=1) + spacing / 2.0) / (2.0 * WIDTH)
    errors = np.interp(COLUMN_TIMES * math.sqrt(2.0), recording.times / UNIT, heights) - COLUMNS
    return misfit(recording, FRONT_TIMES, FRONTS), float(np.abs(errors).max())


def test_f14_the_column_behind_a_broken_dam(dam, record_property):
    """Excellent: 0.02 of the first height, without a shift."""
    _, error = dam_break_misfits(dam)
    record_property("column", f"{error:.3f}")
    assert error <= 0.02


@pytest.mark.xfail(
    reason="13 % ahead with a shift of 0.2: the fronts of Koshizuka and Oka are later by 0.4, more than is customary"
)
def test_f16_the_front_of_a_larger_dam(dam, record_property):
    """Good: 10 %. In units of a the flow is the same but for its viscosity, which is of no account in both."""
    error = misfit(dam, LARGER_TIMES, LARGER_FRONTS)
    record_property("front", f"{error:.1%}, shifted by up to 0.4 {misfit(dam, LARGER_TIMES, LARGER_FRONTS, 0.4):.1%}")
    assert error <= 0.10


def test_f22_a_front_is_slower_than_ritter_s(dam, record_property):
    """2 √(g H), H = 2a, by differences over four frames; and nothing leaks."""
    speeds = (front(dam)[4:] - front(dam)[:-4]) * WIDTH / (dam.times[4:] - dam.times[:-4])
    largest = speeds.max() / (2.0 * math.sqrt(9.81 * 2.0 * WIDTH))
    record_property("speed", f"{largest:.2f}")
    record_property("budget", f"{hole(dam.energy):.1e}")
    assert largest <= 1.0
    assert dam.positions.min() >= 0.0
    assert dam.positions[:, :, 0].max() <= 6.0 * WIDTH
    assert hole(dam.energy) <= widest_hole(dam.energy)


def test_density_and_velocity_that_take_turns_bear_long_steps(record_property):
    """As far off as with c dt/h = 0.2 where both change at once, the usual step, in less than a third of the steps.

    The error is the mean square of ρ/ρ₀ − 1 over a dam break, that of taking water for compressible; steps that distort
    sound make it larger. Not by more than 2 %, nor do they move the front by more than half a particle, at any step up
    to 0.99 of the limit.
    """
    spacing = WIDTH / 20.0
    sound = 10.0 * math.sqrt(2.0 * 9.81 * (2.0 * WIDTH - spacing / 2.0))
    limit = broken_dam(20)[1].plan.dt_limit * sound / (1.5 * spacing)
    record_property("limit of c dt/h", f"{limit:.2f}")
    found = {}
    for courant in (0.2, 0.4, 0.8, 0.99 * limit):
        water, run = broken_dam(20, dt=pc.AutoStep(safety=min(1.0, courant / limit)))
        recording = run.record(3.0 * UNIT, fps=20.0 / UNIT, channels=("positions", "densities"))
        error = math.sqrt(float(((recording[water].densities / 1000.0 - 1.0) ** 2).mean()))
        found[courant] = run.steps, error, float(recording.positions[-1, :, 0].max())
        missing = hole(recording.energy)
        record_property(f"c dt/h = {courant:.2f}", f"{run.steps} steps, {error:.3%}, budget {missing:.1e}")
    usual, longest = found[0.2], found[0.99 * limit]
    assert all(error <= 1.02 * usual[1] for _, error, _ in found.values())
    assert all(abs(place - usual[2]) <= spacing / 2.0 for _, _, place in found.values())
    assert usual[0] >= 3 * longest[0]


# F19. Source: ω² = g k tanh(k h), H. Lamb, Hydrodynamics. Depth 1 m, wavelength 2 m, amplitude 0.05 m, half a wave in
# the tank.
WAVE = 5.541131018081737392457


def standing_wave(method: pc.FluidMethod) -> tuple[pc.Recording, float, float, float]:
    """Three periods with 50 particles in the depth: also ω, and what is lost of the amplitude in each period, by the
    velocities and by the peaks of kinetic energy.

    It starts level, with the velocities of the linear wave (∇² φ = 0), and is measured as their amplitude in all of the
    water. An amplitude a makes it slower by (ak)²/8, 0.3 %, in deep water.
    """
    spacing, k, amplitude = 0.02, math.pi, 0.05

    def shape(x: Array) -> Array:
        across, up = k * x[..., 0], k * x[..., 1]
        return np.stack([np.cosh(up) * np.sin(across), -np.sinh(up) * np.cos(across)], axis=-1) / math.sinh(k)

    cells = pc.block((0.0, 0.0), (1.0, 1.0), spacing)
    water = pc.Fluid(cells, spacing, velocities=amplitude * WAVE * shape(cells))
    run = start(water, pc.Box((0.0, 0.0), (1.0, 2.0)), GRAVITY, fluids=method)
    period = 2.0 * math.pi / WAVE
    recording = run.record(3.0 * period, fps=60.0 / period, channels=("positions", "velocities"))
    shapes = shape(recording.positions)
    values = (shapes * recording.velocities).sum(axis=(1, 2)) / (shapes**2).sum(axis=(1, 2))
    omega, rate = damped_wave(recording.times, values, WAVE)
    peaks = recording.energy.kinetic[::30]
    return recording, omega, 1.0 - math.exp(-rate * period), 1.0 - float(peaks[6] / peaks[0]) ** (1.0 / 6.0)


def test_f19_a_standing_wave(record_property):
    """Good: 2 % on the period and 10 % of the amplitude lost in each; 50 particles in the depth, three periods."""
    recording, omega, loss, by_peaks = standing_wave(pc.WeaklyCompressible())
    record_property("period", f"{WAVE / omega - 1.0:+.2%}")
    record_property("loss of amplitude per period", f"{loss:.1%}, by peaks of kinetic energy {by_peaks:.1%}")
    record_property("budget", f"{hole(recording.energy):.1e}")
    assert omega == pytest.approx(WAVE, rel=0.02)
    assert loss <= 0.10
    assert by_peaks <= 0.10
    assert recording.positions[:, :, 1].min() >= 0.0
    assert hole(recording.energy) <= widest_hole(recording.energy)


# Source: T. H. Havelock, Phil. Mag. 8, 569 (1929); R. G. Dean, R. A. Dalrymple, Water Wave Mechanics (1984), § 6.3: the
# height of the waves over the stroke of the piston that makes them. Depth 0.5 m, kd = 1, stroke 0.06 m.
def test_waves_of_a_piston_have_the_height_that_its_stroke_makes(record_property):
    """H/S = 2 (cosh 2kd − 1)/(sinh 2kd + 2kd), three depths away, where what does not travel has died out.

    On the way the artificial viscosity, ν = αhc/2(D + 2) (J. J. Monaghan, Rep. Prog. Phys. 68, 1703 (2005)), takes
    2νk² of the amplitude in a second, at the speed of groups: 5 % of it. Good: 3 % of the height, of which the linear
    theory leaves out the square of ka = 0.06. The budget closes with the work of the piston.
    """
    depth, k, stroke, spacing, length = 0.5, 2.0, 0.06, 0.05, 8.0
    omega = math.sqrt(9.81 * k * math.tanh(k * depth))
    period = 2.0 * math.pi / omega
    piston = pc.Particles(pc.block((-4.0 * spacing, 0.0), (0.0, 0.8), spacing), fixed=True, name="piston")
    water = pc.Fluid(pc.block((0.0, 0.0), (length, depth), spacing), spacing, name="water")
    run = start(water, piston, GRAVITY, pc.Box((-1.0, 0.0), (length, 1.0)))
    before = run.energy()
    moving = np.arange(len(run.positions)) >= len(water.positions)
    waves, seen = [], []
    while run.time < 5.6:
        velocities = run.velocities.copy()
        velocities[moving] = (0.5 * stroke * omega * math.sin(omega * (run.time + period / 80.0)), 0.0)
        run.set(velocities=velocities)
        run.run(period / 40.0)
        part = run[water]
        near = (part.positions[:, 0] > 1.5) & (part.positions[:, 0] < 2.0)
        if run.time > 5.6 - period:
            x, up = part.positions[near, 0], k * part.positions[near, 1]
            along, rising = omega * np.cosh(up) / math.sinh(k * depth), omega * np.sinh(up) / math.sinh(k * depth)
            cosine, sine = np.cos(k * x - omega * run.time), np.sin(k * x - omega * run.time)
            waves.append(np.stack([[along * cosine, rising * sine], [-along * sine, rising * cosine]]).reshape(2, -1))
            seen.append(part.velocities[near].T.ravel())
    amplitude = math.hypot(*np.linalg.lstsq(np.concatenate(waves, axis=1).T, np.concatenate(seen), rcond=None)[0])
    exact = 2.0 * (math.cosh(2.0 * k * depth) - 1.0) / (math.sinh(2.0 * k * depth) + 2.0 * k * depth)
    group = 0.5 * omega / k * (1.0 + 2.0 * k * depth / math.sinh(2.0 * k * depth))
    sound = 10.0 * math.sqrt(2.0 * 9.81 * (depth - spacing / 2.0))
    viscosity = 0.02 * 1.5 * spacing * sound / 8.0
    expected = exact * math.exp(-2.0 * viscosity * k**2 * 1.75 / group)
    record_property("height over stroke", f"{2.0 * amplitude / stroke:.3f}, {expected:.3f} with the loss on the way")
    after = run.energy()
    assert 2.0 * amplitude / stroke == pytest.approx(expected, rel=0.03)
    assert (run[water].positions[:, 0] > run[piston].positions[:, 0].max()).all()
    assert abs(after.balance - before.balance) <= 1e-3 * (after.work - before.work)

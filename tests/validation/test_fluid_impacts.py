"""Validation, area F: what a wall bears of water that hits it. All fluids have the defaults of `pc.Fluid`."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from validation.flows import GRAVITY, start

pytestmark = [pytest.mark.validation, pytest.mark.filterwarnings("ignore::physcore.MachWarning")]


# Source: H. Lamb, Hydrodynamics (1932), § 73: a jet of width b that a wide wall turns aside presses on it with ρU²b,
# and with ρU²/2 where it is split.
def test_a_jet_presses_on_a_wall_with_its_momentum_and_half_of_its_pressure_in_the_middle(record_property):
    """Once it has been turned aside and while some of it is still to come; good: 3 % of the force, 10 % of the
    pressure, a mean over three spacings around a point from which it falls with the square of the distance over b.
    """
    width, speed, length, spacing = 0.4, 1.0, 2.4, 0.02
    jet = pc.Fluid(
        pc.block((0.1, -0.5 * width), (0.1 + length, 0.5 * width), spacing), spacing, velocities=(-speed, 0.0)
    )
    wall, probe = pc.Plane((0.0, 0.0), (1.0, 0.0)), pc.Probe((0.0, 0.0))
    recording = start(jet, wall, probe).record(1.5, fps=100.0)
    steady = (recording.times > 0.8) & (recording.times < 1.5)
    force = -recording[wall].force[steady, 0].mean() / (1000.0 * speed**2 * width)
    pressure = recording[probe].pressure[steady].mean() / (500.0 * speed**2)
    record_property("force over ρU²b", f"{force:.3f}")
    record_property("pressure over ρU²/2", f"{pressure:.3f}")
    assert force == pytest.approx(1.0, abs=0.03)
    assert pressure == pytest.approx(1.0, abs=0.10)


# Source: "Experimental Investigation on the Impact of Dam-Break Induced Surges on a Vertical Wall", Fluids 7, 258
# (2022): reservoirs of H = 200, 250 and 300 mm; at the first contact about three times the static pressure at the bed.
@pytest.mark.parametrize("rows", [45, 60])
def test_a_front_of_water_hits_a_wall_with_a_few_times_its_static_pressure(rows, record_property):
    """At the foot of a wall 3.4 H ahead of the dam, of what a sensor with a tenth of H shows: means over 0.025 √(H/g)
    are at most twice the three times ρgH of the experiments; later, as the water rises, more than half of ρgH. The
    pressure of one particle, the first one that touches, is 2ρcU at this time, an order of magnitude more. With 30
    rows, three spacings along the sensor's radius, the front bounces back as a whole, and the peak is 12 ρgH.
    """
    depth = 0.3
    spacing, unit = depth / rows, math.sqrt(depth / 9.81)
    water = pc.Fluid(pc.block((0.0, 0.0), (2.0 * depth, depth), spacing), spacing)
    probe = pc.Probe((5.4 * depth, 0.0), radius=0.1 * depth)
    box = pc.Box((0.0, 0.0), (5.4 * depth, 3.0 * depth))
    recording = start(water, box, GRAVITY, probe).record(3.6 * unit, fps=40.0 / unit)
    pressure = recording[probe].pressure / (1000.0 * 9.81 * depth)
    first = int(np.argmax(pressure > 0.1))
    peak = float(pressure[first : first + 8].max())
    later = float(pressure[first + 12 :].mean())
    record_property("first contact, over √(H/g)", f"{recording.times[first] / unit:.2f}")
    record_property("peak over ρgH", f"{peak:.2f}")
    record_property("mean from 0.3 √(H/g) later on", f"{later:.2f}")
    assert 1.0 <= peak <= 6.0
    assert 0.5 <= later <= 3.0

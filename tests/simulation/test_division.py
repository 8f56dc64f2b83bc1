"""Scenes of several systems: in steps of a given size a system whose own limit is smaller takes equal substeps."""

from __future__ import annotations

import itertools
import math
import os
import re
import signal
import time
import warnings

import numpy as np
import pytest

import physcore as pc

STIFF = 1e5
"""Stiffness of the springs [N/m], which limits the steps of the network to a hundredth of those of the wave."""


def wave() -> pc.Wave:
    """The lowest mode of a square with fixed edges."""
    grid = pc.Grid((12, 12), 1.0 / 12)
    return pc.Wave(grid, 1.0, lambda x, y: 1e-3 * np.sin(np.pi * x) * np.sin(np.pi * y), edges="fixed", name="pond")


def network(stiffness: float = STIFF) -> pc.SpringNetwork:
    """A triangle with a tail, which turns and vibrates."""
    nodes = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0], [0.1, 0.1]]
    motion = [[0.0, 0.1], [0.0, -0.1], [0.05, 0.0], [-0.1, 0.0]]
    pairs = [[0, 1], [1, 2], [1, 3], [0, 3], [2, 3]]
    return pc.SpringNetwork(nodes, pairs, stiffness, mass=0.1, velocities=motion, name="net")


def both(stiffness: float = STIFF) -> pc.Scene:
    """A wave, and a network that does not act on it."""
    return pc.Scene(wave(), network(stiffness))


def run(scene: pc.Scene, dt: float, **numerics: object) -> pc.Simulation:
    """A simulation by Verlet's method without a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", pc.StabilityWarning)
        return pc.Simulation(scene, "VelocityVerlet", dt, **numerics)


def division(simulation: pc.Simulation) -> dict[str, tuple[int, float]]:
    """The systems that divide the step, with their substeps and their limits [s], as the plan says it."""
    text = r"(\w+) takes (\d+) equal substeps per step of (\S+) s: its own limit is (\S+) s"
    found = [re.fullmatch(text, note) for note in simulation.plan.notes]
    said = [match.groups() for match in found if match]
    assert all(float(dt) == pytest.approx(simulation.dt, rel=1e-3) for _, _, dt, _ in said)
    return {name: (int(substeps), float(limit)) for name, substeps, _, limit in said}


DT = 0.02
"""Step [s] below the limit of the wave, and far above that of the network."""


def test_the_plan_says_how_many_substeps_and_why():
    plan = run(both(), DT).plan
    ((name, (substeps, limit)),) = division(run(both(), DT)).items()
    assert name == "matter"
    assert substeps == math.ceil(DT / limit) > 20
    # The limit for all directions of the springs is not above that for the present ones.
    alone = pc.stability_limit(pc.Scene(network()), "VelocityVerlet")
    assert 0.5 * alone < limit <= alone
    assert plan.dt == DT
    assert plan.evaluations == substeps
    assert plan.dt_limit == pytest.approx(substeps * alone, rel=1e-12)
    assert plan.margin < 1.0


def test_each_system_has_the_bits_that_it_has_alone_in_its_own_steps():
    simulation = run(both(), DT)
    substeps, _ = division(simulation)["matter"]
    simulation.step(50)
    net, pond = run(pc.Scene(network()), DT / substeps), run(pc.Scene(wave()), DT)
    net.step(50 * substeps)
    pond.step(50)
    assert np.array_equal(simulation.positions, net.positions)
    assert np.array_equal(simulation.velocities, net.velocities)
    assert np.array_equal(simulation["pond"].displacement, pond["pond"].displacement)
    assert simulation.steps == 50
    assert simulation.time == 50 * DT


def test_a_system_within_its_limit_is_not_divided():
    """Up to the limit for the present directions of the springs, as alone; and never with one system."""
    limit = pc.stability_limit(both(), "VelocityVerlet")
    assert division(run(both(), limit)) == {}
    assert division(run(both(), 1.001 * limit))["matter"][0] == 2
    with pytest.warns(pc.StabilityWarning, match="will blow up"):
        alone = pc.Simulation(pc.Scene(network()), "VelocityVerlet", 1.1 * limit)
    assert division(alone) == {}
    with pytest.raises(pc.SimulationDiverged, match="beyond the limit of stability"):
        alone.step(5000)


def test_automatic_and_adaptive_steps_suit_all_systems():
    limit = pc.stability_limit(both(), "VelocityVerlet")
    for dt in (pc.AutoStep(), pc.AdaptiveStep()):
        simulation = pc.Simulation(both(), "VelocityVerlet", dt)
        simulation.run(0.01)
        assert simulation.dt <= 0.5 * limit
        assert division(simulation) == {}


def test_both_systems_converge_with_their_order():
    """The wave with the step; the network, within a factor of its substeps, as if it were alone."""
    duration = 0.32

    def last(dt: float) -> tuple[np.ndarray, np.ndarray, float]:
        simulation = run(both(1e3), dt)
        simulation.step(round(duration / dt))
        substeps = division(simulation).get("matter", (1, 0.0))[0]
        return simulation["pond"].displacement, simulation.positions, dt / substeps

    exact = last(duration / 4096)
    errors = []
    for parts in (8, 16, 32):
        heights, positions, size = last(duration / parts)
        errors.append((np.abs(heights - exact[0]).max(), np.abs(positions - exact[1]).max() / size**2))
    (one, _), (two, _), (four, _) = errors
    assert [one / two, two / four] == pytest.approx([4.0, 4.0], rel=0.1)
    ratios = [ratio for _, ratio in errors]
    assert max(ratios) < 3.0 * min(ratios)


def test_the_balance_of_energy_holds():
    with warnings.catch_warnings():
        warnings.simplefilter("error", pc.StabilityWarning)
        recording = pc.simulate(both(), 1.0, integrator="VelocityVerlet", dt=DT)
    # Verlet's energy errs by up to (ωh)²/4 of the energy: 1 at the limit ωh = 2. The motion is mostly rigid.
    assert np.abs(recording.energy.drift).max() < 1.0


def spikes() -> pc.Scene:
    """A slow wave beside a reaction with spikes, which are thrice as fast as what lies between them."""
    pond = pc.Wave(pc.Grid((12, 12), 0.5), 1.0, lambda x, y: 1e-3 * np.sin(0.5 * x * y), name="pond")
    start = {"u": 1.0, "v": lambda x, y: 3.0 + 0.1 * np.sin(np.pi * x)}
    grid, diffusion = pc.Grid((8, 8), 0.25, periodic=True), {"u": 1e-3, "v": 1e-3}
    return pc.Scene(pond, pc.ReactionDiffusion(grid, pc.Brusselator(1.0, 3.0), diffusion, start, name="tank"))


def spiking() -> pc.Simulation:
    """A simulation of `spikes` in steps below the limit of the wave, and now and then above that of the reaction."""
    return pc.Simulation(spikes(), {"pond": pc.VelocityVerlet(), "tank": pc.RungeKutta4()}, 0.2)


@pytest.mark.parametrize("parts", [(40,), (1,) * 40, (7, 33), (8, 32), (3, 5, 32)])
def test_batches_change_no_bit(parts):
    """Also where substeps change with the state."""
    whole, divided = spiking(), spiking()
    whole.step(40)
    for part in parts:
        divided.step(part)
    assert divided.state_hash() == whole.state_hash()


def test_substeps_follow_a_limit_that_varies():
    """No step of the reaction is above twice its limit: this is found again after at most its double."""
    simulation, found = spiking(), []
    for _ in range(120):
        simulation.step()
        found.append(division(simulation).get("tank", (1, 0.0))[0])
    assert found[0] == 1
    assert max(found) > 3
    changes = [one != other for one, other in itertools.pairwise(found)]
    assert 3 < sum(changes) < 30
    tank = simulation["tank"]
    fine = pc.Simulation(spikes(), {"pond": pc.VelocityVerlet(), "tank": pc.RungeKutta4()}, 0.02)
    fine.step(1200)
    assert division(fine) == {}
    assert np.abs(tank.u - fine["tank"].u).max() < 0.01 * np.abs(fine["tank"].u).max()


@pytest.mark.parametrize("start", [lambda: run(both(), DT), spiking])
@pytest.mark.parametrize("steps", [5, 8, 33])
def test_a_checkpoint_goes_on_with_the_same_bits(start, steps, tmp_path):
    simulation = start()
    simulation.step(steps)
    simulation.save(tmp_path / "half")
    resumed = pc.load(tmp_path / "half")
    assert division(resumed) == division(simulation)
    for each in (simulation, resumed):
        each.step(12)
    assert resumed.state_hash() == simulation.state_hash()


def test_a_change_of_the_state_divides_anew():
    """A spring of a quarter of its rest length is three times as stiff across its direction as along it."""
    simulation = run(both(), DT)
    before = division(simulation)["matter"][0]
    simulation.step(3)
    simulation.set(positions=0.25 * simulation.positions)
    # At least (l₀/l − 1) = 3 in the stiffness of each row, and √3 in the limit.
    assert division(simulation)["matter"][0] > 1.5 * before


def test_a_scene_that_replaces_another_divides_anew():
    simulation = run(both(1e3), DT)
    before = division(simulation)["matter"][0]
    simulation.step(3)
    simulation.replace(both(1e5))
    assert division(simulation)["matter"][0] == pytest.approx(10 * before, rel=0.2)


def test_a_failed_step_leaves_no_trace():
    """Also in substeps: those of a step of another size, which fails, and is taken in parts."""
    scene = pc.Scene(wave(), network(), pc.CustomForce(_cliff))
    simulation = pc.Simulation(scene, "VelocityVerlet", DT)
    once = simulation.state_hash()
    with pytest.raises(pc.SimulationDiverged):
        simulation.step(100)
    taken = simulation.steps
    assert 0 < taken < 100
    again = pc.Simulation(scene, "VelocityVerlet", DT)
    assert again.state_hash() == once
    again.step(taken)
    assert again.state_hash() == simulation.state_hash()


def _cliff(time: float, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """A force that is not a number from a time on."""
    return np.full_like(positions, math.nan if time > 0.5 else 0.0)


def test_a_system_that_no_step_suits_is_not_divided():
    with pytest.warns(pc.StabilityWarning, match="ExplicitEuler is not stable at any time step"):
        simulation = pc.Simulation(both(), {"bodies": pc.ExplicitEuler()}, 1e-3)
    assert division(simulation) == {}


def test_each_of_two_systems_may_be_divided():
    pattern = spikes().systems[1]
    fast = {"u": 1.0, "v": 2.0}
    tank = pc.ReactionDiffusion(pattern.grid, pc.Brusselator(1.0, 1.0), fast, pattern.initial, name="tank")
    scene = pc.Scene(wave(), tank, network())
    simulation = pc.Simulation(scene, {"bodies": pc.VelocityVerlet()}, DT)
    found = division(simulation)
    assert set(found) == {"matter", "tank"}
    simulation.step(40)
    alone = pc.Simulation(pc.Scene(tank), dt=DT / found["tank"][0])
    alone.step(40 * found["tank"][0])
    assert np.array_equal(simulation["tank"].u, alone["tank"].u)


def test_coupled_systems_take_the_steps_of_the_scene():
    vortices = pc.PointVortices([[0.0, 0.0], [0.1, 0.0]], [5.0, 5.0])
    scene = pc.Scene(vortices, pc.Tracers([[0.3, 0.1], [0.05, 0.2]], vortices), network())
    simulation = pc.Simulation(scene, dt=DT)
    assert set(division(simulation)) == {"matter"}


def test_the_measured_limit_is_that_of_undivided_steps():
    scene = pc.Scene(wave(), pc.SpringNetwork([[0.0, 0.0], [0.1, 0.0]], [[0, 1]], STIFF, mass=0.1))
    limit = pc.stability_limit(scene, "VelocityVerlet", measured=True)
    assert limit.measured == pytest.approx(limit.theory, rel=2e-3)


def test_an_event_is_found_within_divided_steps():
    """The middle of the wave passes zero after a quarter of a period, as it does without the network."""
    event = pc.Event(lambda state: state["pond"].displacement[5, 5], terminal=True)
    one, two = run(pc.Scene(wave()), DT), run(both(), DT)
    for simulation in (one, two):
        simulation.run(0.5, events=[event])
    assert two.time == one.time == pytest.approx(0.25 * math.sqrt(2.0), rel=0.01)
    two.run(0.5)
    assert division(two) == division(run(both(), DT)) != {}


@pytest.mark.skipif(os.name != "posix", reason="needs interval timers")
def test_ctrl_c_ends_a_long_divided_step():
    """One step of a stiff network of seconds: the state before it is left, and goes on."""
    side = 40
    nodes = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2) * 0.1
    pairs = [[i, i + 1] for i in range(side * side - 1) if (i + 1) % side] + [
        [i, i + side] for i in range(side * side - side)
    ]
    simulation = run(pc.Scene(wave(), pc.SpringNetwork(nodes, pairs, 1e10, mass=0.01)), DT)
    assert division(simulation)["matter"][0] > 10_000
    before = simulation.state_hash()
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        simulation.step(1000)
    assert time.monotonic() - started < 5.0
    if simulation.steps == 0:
        assert simulation.state_hash() == before

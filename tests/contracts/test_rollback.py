"""A step that fails or is interrupted leaves the state before it, from which the run goes on in the same bits."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

import physcore as pc
from contracts.scenes import IN_PYTHON, SCENES, STEPS, Case
from contracts.transforms import flow_in_python
from physcore.scene.points import PointSystem
from physcore.scene.records import parameters

FIXED = {name: case for name, case in SCENES.items() if not case.adaptive}


class Broken(Exception):
    """What a function of the user's raises."""


def again(wave: pc.Wave, source: pc.Source) -> pc.Wave:
    """The same wave with one more source."""
    values = {name: getattr(wave, name) for name in parameters(pc.Wave)}
    return pc.Wave(**{**values, "sources": (*wave.sources, source)})


def timed(dish: pc.ReactionDiffusion, signal: Callable[[float], float]) -> pc.ReactionDiffusion:
    """The same reaction as a function, with one more species that counts the time."""
    kinetics = dish.reaction
    function = IN_PYTHON[type(kinetics)](kinetics)

    def rates(*values: np.ndarray) -> tuple[np.ndarray, ...]:
        *own, time = values
        return *function(*own), np.full_like(time, 1.0 + signal(float(time.max())))

    return pc.ReactionDiffusion(
        dish.grid,
        pc.Reaction((*kinetics.names, "time"), rates),
        {**dish.diffusion, "time": 0.0},
        {**dish.initial, "time": 0.0},
        {name: dict(zip(dish.grid.sides, dish.conditions(name), strict=True)) for name in kinetics.names},
    )


def failing(case: Case, time: float) -> pc.Scene:
    """The scene of a case, and a force that is zero, and that from some time on cannot be evaluated."""
    scene = case.shared

    def function(now: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        if now > time:
            raise Broken
        return np.zeros_like(x)

    def signal(now: float) -> float:
        if now > time:
            raise Broken
        return 0.0

    if isinstance(scene.systems and scene.systems[0], PointSystem):
        if scene.dimension == 2 and not isinstance(getattr(scene.systems[0], "flow", None), pc.Flow):
            pytest.skip("point vortices call no function of the user's")
        inner = flow_in_python(scene.systems[0].flow)

        def flow(now: float, x: np.ndarray) -> np.ndarray:
            return inner(now, x) + signal(now)

        return pc.Scene(pc.Tracers(scene.systems[0].start, pc.Flow(flow)))
    if not scene.bodies:
        (system,) = scene.systems
        if isinstance(system, pc.Schrodinger):
            pytest.skip("its steps call no function of the user's")
        if isinstance(system, pc.ReactionDiffusion):
            return pc.Scene(timed(system, signal))
        assert isinstance(system, pc.Wave)
        return pc.Scene(again(system, pc.Source(np.ones(system.grid.cells, dtype=bool), 1.0, signal=signal)))
    if isinstance(
        case.numerics.get("integrator"),
        (pc.XPBD, pc.ProjectiveDynamics, pc.BackwardEuler, pc.ImplicitMidpoint, pc.BDF2),
    ):
        pytest.skip("its method refuses functions of the user's")
    force = pc.CustomForce(function, potential=lambda x: 0.0)
    domain = [] if scene.periodic is None else [scene.periodic]
    return pc.Scene(*scene.bodies, *scene.forces, *scene.boundaries, *scene.constraints, *scene.systems, *domain, force)


@pytest.mark.parametrize("name", SCENES)
def test_a_step_that_cannot_be_taken_leaves_no_trace(name):
    """However often it is tried: neighbor lists, tallies and registers of the method are those of the step before."""
    case = SCENES[name]
    good = STEPS // 2
    run = case.simulation(failing(case, (good + 0.25) * case.dt))
    plain = case.simulation(failing(case, np.inf))
    for _ in range(3):
        with pytest.raises(pc.SceneError) as caught:
            case.advance(run)
        assert isinstance(caught.value.__cause__, Broken)
    if not case.adaptive:
        assert 0 < run.steps <= good + 1  # a method that asks at the end of a step, or within it
        plain.step(run.steps)
        assert plain.state_hash() == run.state_hash()
        assert vars(plain.energy()) == vars(run.energy())
    state = run.state_hash()
    with pytest.raises(pc.SceneError):
        case.advance(run)
    assert run.state_hash() == state


@contextmanager
def interrupted(after: float) -> Iterator[None]:
    """Raise KeyboardInterrupt, as Ctrl-C does, when this process has computed for so long [s]."""

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, after)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs interval timers")
@pytest.mark.parametrize("name", FIXED)
def test_an_interrupted_run_stands_at_a_whole_step_and_goes_on(name):
    """With a hundredth of the time step nothing runs away meanwhile. A batch that was under way is abandoned."""
    case = FIXED[name]
    run, plain = (case.simulation(dt=case.dt / 100.0) for _ in range(2))
    with interrupted(0.01), pytest.raises(KeyboardInterrupt):
        run.step(10**9)
    state, steps = run.state_hash(), run.steps
    assert steps < 10**9
    run.step(STEPS)
    if steps > 0:
        plain.step(steps)
        assert plain.state_hash() == state
    plain.step(STEPS)
    assert plain.state_hash() == run.state_hash()
    assert vars(plain.energy()) == vars(run.energy())


WEB = pc.cloth((60, 60), 0.02, 1e4, mass=0.01, origin=(0.0, 0.0, 0.0), pinned="top")
WIDE = pc.cloth((150, 150), 0.02, 1e4, mass=0.01, origin=(0.0, 0.0, 0.0), pinned="top")
HEAVY = {
    "sweeps": ({"integrator": pc.XPBD(iterations=100_000)}, pc.Scene(WEB, pc.Gravity())),
    "projections": ({"integrator": pc.ProjectiveDynamics(100_000)}, pc.Scene(WIDE, pc.Gravity())),
    "equations": ({"integrator": pc.BackwardEuler()}, pc.Scene(WEB, pc.Gravity(), pc.Drag(1e-4, wind=(3.0, 1.0, 2.0)))),
}
"""Scenes of which one step takes seconds or minutes."""


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs interval timers")
@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize("kind", HEAVY)
def test_a_step_that_takes_long_is_interrupted_within(kind):
    numerics, scene = HEAVY[kind]
    run = pc.Simulation(scene, dt=1.0, **numerics)
    state = run.state_hash()
    with interrupted(0.05), pytest.raises(KeyboardInterrupt):
        run.step()
    assert run.steps == 0
    assert run.state_hash() == state

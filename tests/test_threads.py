"""Threads, signals and processes: the same bits for any number, an answer to Ctrl-C, and life after a fork."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import physcore as pc
from physcore import engine

CLOTH = pc.cloth((150, 120), spacing=0.01, stiffness=2000.0, damping=0.01, mass=1e-3, pinned="corners")
HANGING = pc.Scene(CLOTH, pc.Gravity((0.0, -9.81)), pc.Drag(1e-4))
LANDING = pc.Scene(CLOTH, pc.Gravity((0.0, -9.81)), pc.Drag(1e-4), pc.Floor(-0.001, restitution=0.5, friction=0.2))


def running(steps: int = 100, scene: pc.Scene = LANDING, **numerics) -> pc.Simulation:
    simulation = pc.Simulation(scene, dt=2e-4, **numerics)
    simulation.step(steps)
    return simulation


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_the_bits_are_the_same_for_any_number_of_threads(precision):
    simulations = [running(threads=threads, precision=precision) for threads in (1, 2, 3, 7)]
    assert len({simulation.state_hash() for simulation in simulations}) == 1
    assert len({simulation.energy().dissipated for simulation in simulations}) == 1


@pytest.mark.parametrize("level", ["scalar", "avx2", "avx512"])
def test_the_bits_are_the_same_on_every_level_of_vector_instructions(level):
    program = "from test_threads import running; print(running(threads=1).state_hash())"
    environment = {**os.environ, "PHYSCORE_SIMD": level, "PYTHONPATH": os.path.dirname(__file__)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0 and "PHYSCORE_SIMD" in done.stderr:
        pytest.skip(f"this machine has no {level}")
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == running(threads=1).state_hash()


def test_the_number_of_threads_comes_from_the_environment(monkeypatch):
    large = pc.Scene(pc.Particles(np.zeros((1_000_000, 2))))  # a small scene would use one thread anyway
    monkeypatch.setenv("PHYSCORE_NUM_THREADS", "3")
    assert pc.Simulation(large).plan.threads == 3
    assert pc.Simulation(large, threads=2).plan.threads == 2
    monkeypatch.setenv("PHYSCORE_NUM_THREADS", "many")
    with pytest.raises(pc.SceneError, match="PHYSCORE_NUM_THREADS"):
        pc.Simulation(large)


def test_a_second_thread_gets_a_clear_error_and_the_first_one_goes_on():
    simulation, plain = running(0, HANGING), running(0, HANGING)
    worker = threading.Thread(target=simulation.step, args=(2000,))
    worker.start()
    refusals = []
    while worker.is_alive():
        try:
            simulation.energy()
        except pc.PhyscoreError as error:
            refusals.append(str(error))
    worker.join()
    assert refusals
    assert "another thread" in refusals[0]
    plain.step(2000)
    assert simulation.state_hash() == plain.state_hash()


def test_nobody_steps_between_two_chunks_of_a_run(monkeypatch):
    """With dt="auto" springs run in chunks of 256 steps; between them the world is idle while its limit is found."""
    simulation, tries = pc.Simulation(HANGING), []
    look = engine.certified

    def meddle(world):
        with pytest.raises(pc.PhyscoreError, match="another thread") as caught:
            simulation.step()
        tries.append(caught.value)
        return look(world)

    monkeypatch.setattr(engine, "certified", meddle)
    simulation.step(600)
    assert (simulation.steps, len(tries)) == (600, 2)


def test_other_python_threads_run_meanwhile():
    ticks = []
    stop = threading.Event()

    def tick() -> None:
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(1e-3)

    clock = threading.Thread(target=tick)
    clock.start()
    start = time.perf_counter()
    running(1000, HANGING)
    end = time.perf_counter()
    stop.set()
    clock.join()
    assert sum(start < moment < end for moment in ticks) > 3


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs interval timers")
def test_ctrl_c_is_answered_and_the_run_can_go_on():
    small = pc.Scene(pc.rope(1000, 1.0, 1e5, damping=0.01, mass=0.01, pinned="start"), pc.Gravity((0.0, -9.81)))
    simulation, plain = (pc.Simulation(small, dt=1e-5) for _ in range(2))

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    sent = time.perf_counter() + 0.5
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.5)
        with pytest.raises(KeyboardInterrupt):
            simulation.step(10**9)
        answered = time.perf_counter()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    # 100 ms is what is promised; a shared machine may keep the process waiting that long again.
    assert answered - sent < 0.2
    steps = simulation.steps  # whole ones: what was under way when the signal came is abandoned
    assert steps < 10**9
    simulation.step(10)
    plain.step(steps + 10)
    assert simulation.state_hash() == plain.state_hash()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_simulation_goes_on_after_a_fork():
    program = """
import os, sys
from test_threads import running
simulation = running(threads=2)
child = os.fork()
simulation.step(50)
os.write(1, (simulation.state_hash() + "\\n").encode())  # in one piece, so that the two lines do not mix
if child:
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    environment = {**os.environ, "PYTHONPATH": os.path.dirname(__file__)}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    hashes = done.stdout.split()
    assert len(hashes) == 2
    assert set(hashes) == {running(150).state_hash()}

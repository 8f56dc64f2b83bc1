"""Memory: what a plan says is what is taken, and what does not fit is refused instead of ending the process."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import closing

import numpy as np
import pytest

import physcore as pc
from forks import Forks
from heavy import HEAVY
from physcore._core import available_memory

LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /proc and the limits of Linux")
REFUSED = re.compile(r"needs \d+\.\d [MG]B, \d+\.\d [MG]B are available \(.+\)")

PRELUDE = """
import re, resource, warnings
import numpy as np
import physcore as pc
warnings.simplefilter("ignore")

def kilobytes(name):
    return int(re.search(name + r":\\s+(\\d+)", open("/proc/self/status").read())[1])

def leave(megabytes):
    "Limit the address space to what is used and so much more."
    limit = kilobytes("VmSize") * 1024 + int(megabytes * 10**6)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

def refusal(function, *arguments, **more):
    try:
        function(*arguments, **more)
    except pc.PhyscoreError as error:
        return str(error)
    return "nothing was refused"

random = np.random.default_rng(1)
"""


@pytest.fixture(scope="module")
def alone() -> Iterator[Callable[[str], str]]:
    """Gives what a program prints in a process of its own, which it must end by itself."""
    threads = {"OPENBLAS_NUM_THREADS": "1", "PHYSCORE_NUM_THREADS": "2"}
    with closing(Forks(**threads, MALLOC_MMAP_THRESHOLD_="65536", MALLOC_ARENA_MAX="1")) as forks:

        def printed(program: str) -> str:
            done = forks.run(PRELUDE + textwrap.dedent(program))
            assert done.returncode == 0, f"ended with {done.returncode}: {done.stderr[-1000:]}"
            return done.stdout.strip()

        yield printed


SCENES = {
    "free": "pc.Scene(pc.Particles(random.random((100_000, 3))), pc.Gravity((0, 0, -9.81)))",
    "springs": "pc.Scene(pc.cloth((250, 250), 0.1, 100.0), pc.Gravity((0, -9.81)))",
    "atoms": "pc.Scene(pc.Particles(2.0 * random.random((8000, 3))), pc.LennardJones(1e-30, 1e-3, 0.5))",
    "fluid": "pc.Scene(pc.Fluid(pc.block((0, 0), (2, 1), 0.01), 0.01), pc.Gravity((0, -9.81)), pc.Floor(-0.005))",
}


@LINUX
@pytest.mark.parametrize("name", SCENES)
def test_the_memory_of_the_plan_is_what_the_process_takes(name, alone):
    """Within 15 % and 1 MB, beside the program itself (RssAnon leaves it out) and what the allocator keeps of what was
    given back: here it may keep nothing above 64 kB.
    """
    program = f"""
    scene = {SCENES[name]}
    before = kilobytes("RssAnon")
    simulation = pc.Simulation(scene, dt=1e-9)
    simulation.step(2)
    print((kilobytes("RssAnon") - before) * 1024, simulation.plan.memory)
    """
    taken, promised = map(int, alone(program).split())
    assert abs(taken - promised) < 0.15 * promised + 1e6, (taken, promised)


@LINUX
def test_lists_that_do_not_fit_are_refused_with_the_figures(alone):
    """8000 atoms in mutual reach: 8000² numbers of 4 bytes, and up to a quarter more."""
    program = """
    scene = pc.Scene(pc.Particles(random.random((8000, 3))), pc.LennardJones(1e-9, 1e-3, 10.0))
    leave(150)
    print(refusal(pc.Simulation, scene))
    """
    said = alone(program)
    assert REFUSED.search(said), said
    assert "needs 0.3 GB" in said
    assert "cutoff" in said


@LINUX
def test_one_large_grain_among_small_ones_is_refused(alone):
    program = """
    radius = np.full(30_000, 0.1)
    radius[0] = 60.0
    scene = pc.Scene(pc.Particles(50.0 * random.random((30_000, 3)), radius=radius), pc.SoftSpheres(1.0))
    leave(500)
    print(refusal(pc.Simulation, scene))
    """
    said = alone(program)
    assert REFUSED.search(said), said


@LINUX
def test_particles_that_do_not_fit_are_refused(alone):
    program = """
    scene = pc.Scene(pc.Particles(random.random((500_000, 3))), pc.Gravity((0, 0, -1)), pc.Drag(1.0))
    leave(90)
    print(refusal(pc.Simulation, scene, integrator=pc.DormandPrince5()))
    """
    said = alone(program)
    assert REFUSED.search(said), said


@LINUX
def test_springs_that_do_not_fit_are_refused(alone):
    program = """
    scene = pc.Scene(pc.soft_body((50, 50, 40), 0.1, 100.0))
    leave(90)
    print(refusal(pc.Simulation, scene))
    """
    said = alone(program)
    assert REFUSED.search(said), said


@LINUX
def test_a_run_whose_lists_outgrow_the_memory_stands_at_the_last_good_step(alone):
    """All atoms fly to the origin, where everybody is within the cutoff of everybody; they hardly feel each other."""
    program = """
    start = random.uniform(-300.0, 300.0, (5000, 3))
    scene = pc.Scene(pc.Particles(start, velocities=-start), pc.LennardJones(1e-30, 1e-3, 10.0))
    simulation = pc.Simulation(scene, dt=0.01)
    leave(50)
    print(refusal(simulation.step, 99).replace("\\n", " "))
    steps, positions = simulation.steps, simulation.positions
    print(steps, np.abs(positions - start * (1 - 0.01 * steps)).max())
    print(refusal(simulation.step, 99).replace("\\n", " "), simulation.steps - steps)
    """
    said, state, again = alone(program).splitlines()
    assert REFUSED.search(said), said
    steps, error = map(float, state.split())
    assert 50 < steps < 99
    assert error < 1e-9
    assert REFUSED.search(again), again
    assert again.endswith(" 0")


@LINUX
def test_a_limit_of_the_process_bounds_what_is_available(alone):
    program = """
    from physcore._core import available_memory
    leave(200)
    print(available_memory())
    """
    available = int(alone(program))
    assert 150e6 < available <= 200e6


@LINUX
def test_what_is_available_is_less_than_the_machine_has():
    available = available_memory()
    assert available is not None
    assert 0 < available < os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def test_the_lists_count_in_the_plan():
    """300 atoms in mutual reach list each other, 4 bytes each."""
    scene = pc.Scene(pc.Particles(np.random.default_rng(1).random((300, 3))), pc.LennardJones(1e-30, 1e-3, 10.0))
    assert pc.Simulation(scene).plan.memory > 300 * 299 * 4


@LINUX
@pytest.mark.parametrize("name", HEAVY)
def test_what_does_not_fit_is_refused_at_any_share_of_the_memory_that_it_takes(name, alone):
    """At 30, 60 and 90 % of the address space that building and two steps take: an error, and no abort.

    Each is tried in a process of its own, before any thread has started.
    """
    scene, numerics = HEAVY[name]
    program = f"""
    import os
    scene = {scene}

    def run():
        pc.Simulation(scene, {numerics}).step(2)

    def apart(function):
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            os.write(writer, str(function()).encode())
            os._exit(0)
        os.close(writer)
        said = os.read(reader, 100).decode()
        status = os.waitpid(child, 0)[1]
        assert status == 0, f"a child ended with {{status}}"
        return said

    def peak():
        before = kilobytes("VmSize")
        run()
        return kilobytes("VmPeak") - before

    def within(share, whole):
        leave(share * whole * 1024e-6)
        try:
            run()
        except (pc.PhyscoreError, MemoryError):
            return "refused"
        return "ran"

    whole = int(apart(peak))
    print([apart(lambda: within(share, whole)) for share in (0.3, 0.6, 0.9)].count("refused"))
    """
    assert int(alone(program)) >= 1

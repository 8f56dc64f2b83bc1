"""Functions of the user's: whenever they are called, whatever they give back, and however they fail."""

from __future__ import annotations

import gc
import subprocess
import sys
import traceback
import weakref
from collections.abc import Iterator

import numpy as np
import pytest

import physcore as pc


@pytest.mark.parametrize(
    "integrator", [pc.VelocityVerlet(), pc.RungeKutta4(), pc.PEFRL()], ids=lambda i: type(i).__name__
)
def test_a_force_of_time_gives_the_same_bits_however_the_steps_are_asked_for(integrator):
    """The time of a stage is start + (n + node)·dt with one n, not a sum over pieces."""
    ball = pc.Particles([[1.0, 0.0]])
    hashes = set()
    for pieces in ([200], [1] * 200, [7] * 28 + [4]):
        force = pc.CustomForce(lambda time, x, v: np.sin(37.0 * time) - x)
        run = pc.Simulation(pc.Scene(ball, force), integrator=integrator, dt=0.1)
        for piece in pieces:
            run.step(piece)
        hashes.add(run.state_hash())
    assert len(hashes) == 1


@pytest.mark.parametrize("give", [lambda x: (-x).tolist(), lambda x: (-x).astype(np.float32), lambda x: -x])
def test_whatever_numpy_takes_for_an_array_will_do(give):
    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: give(x))), dt=0.5)
    run.step(1)
    assert run.positions[0, 0] == 1.0 - 0.5**2 / 2


def test_a_failing_function_leaves_the_state_before_set():
    """The new state is never seen: neither positions nor energy nor what the integrator carries."""

    def force(time, x, v):
        if abs(x).max() > 10.0:
            raise RuntimeError("too far")
        return -x

    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(force)), dt=0.1)
    run.step(3)
    before = run.state_hash(), run.energy().work
    with pytest.raises(pc.SceneError, match="too far"):
        run.set(positions=[[50.0, 0.0]])
    assert (run.state_hash(), run.energy().work) == before
    run.step(1)


def test_what_holds_a_driven_particle_against_a_potential_does_work():
    """U = d²/2 between a driven and a free particle: total − work is constant to the order of Verlet."""

    def spring(time, x, v):
        pull = x[1] - x[0]
        return np.array([pull, -pull])

    pair = pc.Particles([[0.0, 0.0], [1.0, 0.0]], velocities=[[1.0, 0.0], [0.0, 0.0]], fixed=[0])
    scene = pc.Scene(pair, pc.CustomForce(spring, potential=lambda x: 0.5 * float(((x[1] - x[0]) ** 2).sum())))
    drifts = []
    for dt in (2e-2, 1e-2):
        run = pc.Simulation(scene, dt=dt)
        balance = run.energy().balance
        run.step(round(4.0 / dt))
        assert abs(run.energy().work) > 0.1
        drifts.append(abs(run.energy().balance - balance))
    assert np.log2(drifts[0] / drifts[1]) == pytest.approx(2.0, abs=0.1)


def test_double_precision_takes_springs_of_any_length():
    """f32 is refused: it is relative to the middle of the scene, and 1 m from there positions are 1e-7 m apart."""
    pair = pc.SpringNetwork([[1.0, 0.0], [1.0 + 1e-9, 0.0]], pairs=[[0, 1]], stiffness=1.0)
    scene = pc.Scene(pair, pc.Particles([[-1.0, 0.0]]))
    pc.Simulation(scene, precision="f64").step(1)
    with pytest.raises(pc.SceneError, match="precision"):
        pc.Simulation(scene, precision="f32")


def test_a_state_out_of_range_is_never_taken_for_good():
    """With the alarm for runaways off, the first value that is not finite still ends the run."""
    away = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), -1.0, exponent=3.0))
    run = pc.Simulation(away, integrator=pc.RungeKutta4(), dt=0.1, on_divergence="ignore")

    def one_by_one():
        for _ in range(1000):
            run.step(1)

    with pytest.raises(pc.SimulationDiverged, match="not finite"):
        one_by_one()
    assert np.isfinite(run.positions).all()
    assert np.isfinite(run.velocities).all()


@pytest.fixture
def few_objects() -> Iterator[None]:
    """Leave what there is to no collection: the tests and their modules are a million objects."""
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.mark.usefixtures("few_objects")
@pytest.mark.parametrize("potential", [False, True], ids=["force", "potential"])
def test_a_simulation_whose_function_refers_back_to_it_is_collected(potential):
    """The cycle simulation → world → function → closure → simulation is the garbage collector's to find."""

    def run_that_refers_to_itself():
        held = []
        force = pc.CustomForce(
            (lambda time, x, v: -x) if potential else (lambda time, x, v: -x * len(held)),
            (lambda x: 0.0 * len(held)) if potential else None,
        )
        run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), force), dt=0.1)
        held.append(run)
        run.step(2)
        return weakref.ref(run)

    alive = run_that_refers_to_itself()
    gc.collect()
    assert alive() is None


@pytest.mark.usefixtures("few_objects")
def test_a_collection_in_the_middle_of_a_step_takes_nothing_away():
    """The function runs while its world is in use, and collects, in this thread and around a running simulation."""
    calls = []

    def force(time, x, v):
        gc.collect()
        calls.append(len(held))
        return -x

    held = []
    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(force)), dt=0.1)
    held.append(run)
    run.step(3)
    assert run.steps == calls[-1] * 3


class Trouble(Exception):
    pass


def failing(error, after=0.25):
    """A well that raises `error` from some time on."""

    def force(time, x, v):
        if time > after and error is not None:
            raise error
        return -x

    return force


def test_an_exception_is_the_cause_of_a_scene_error_that_names_the_function():
    well = pc.CustomForce(lambda time, x, v: -x)
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), well, pc.CustomForce(failing(Trouble("out of range"))))
    run = pc.Simulation(scene, dt=0.1)
    with pytest.raises(pc.SceneError) as caught:
        run.step(10)
    assert str(caught.value) == "forces[1].function: raised Trouble: out of range"
    cause = caught.value.__cause__
    assert isinstance(cause, Trouble)
    assert "force" in [entry.name for entry in traceback.extract_tb(cause.__traceback__)]


@pytest.mark.parametrize(
    "error", [SystemExit(3), KeyboardInterrupt(), GeneratorExit()], ids=lambda error: type(error).__name__
)
def test_what_is_no_exception_passes_as_it_is_and_the_run_can_go_on(error):
    switch = {"error": error}
    function = lambda time, x, v: failing(switch["error"])(time, x, v)  # noqa: E731
    run, twin = (
        pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(each)), dt=0.1)
        for each in (function, lambda time, x, v: -x)
    )
    run.step(2)
    with pytest.raises(type(error)) as caught:
        run.step(1)
    assert caught.value is error
    assert run.steps == 2
    switch["error"] = None
    run.step(8)
    twin.step(10)
    assert np.array_equal(run.positions, twin.positions)


class Row:
    """A row of a result, with so many interrupts when it is looked at."""

    interrupts = 0

    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        if self.interrupts:
            self.interrupts -= 1
            raise KeyboardInterrupt
        return np.zeros(2)


def test_an_interrupt_while_a_result_is_looked_at_passes():
    """One Ctrl-C is enough, also for a function that gives a list of arrays."""
    row = Row()
    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: [row])), dt=0.1)
    row.interrupts = 1
    with pytest.raises(KeyboardInterrupt):
        run.step(10)
    assert run.steps == 0
    run.step(10)


def test_sys_exit_in_a_function_ends_the_program():
    script = (
        "import sys, physcore as pc\n"
        "force = pc.CustomForce(lambda time, x, v: sys.exit(7) if time > 0.25 else -x)\n"
        "pc.simulate(pc.Scene(pc.Particles([[1.0, 0.0]]), force), 2.0, dt=0.1)\n"
        "print('went on')\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=3600, check=False)
    assert (done.returncode, done.stdout) == (7, ""), done.stderr


@pytest.mark.parametrize("kind", [Trouble, SystemExit])
@pytest.mark.parametrize(
    "act",
    [
        lambda run: run.energy(),
        lambda run: run.set(positions=[[2.0, 0.0]]),
        lambda run: run.set(velocities=[[2.0, 0.0]]),
        lambda run: pc.Simulation(run.scene, dt=0.1),
    ],
    ids=["energy", "set positions", "set velocities", "construction"],
)
def test_a_potential_that_fails_is_named_wherever_it_is_asked_for(act, kind):
    errors = []

    def potential(x):
        if errors:
            raise errors[0]
        return 0.5 * float((x**2).sum())

    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: -x, potential))
    run = pc.Simulation(scene, dt=0.1)
    run.step(3)
    before = run.state_hash()
    errors.append(kind("no energy"))
    if kind is SystemExit:
        with pytest.raises(SystemExit):
            act(run)
    else:
        with pytest.raises(pc.SceneError, match=r"^forces\[0\]\.potential: raised Trouble: no energy$") as caught:
            act(run)
        assert caught.value.__cause__ is errors[0]
    assert run.state_hash() == before
    errors.clear()
    run.step(1)


NO_FORCES = {
    "complex": (lambda x: x + 1j, "an array of complex128, made of ndarray"),
    "masked": (lambda x: np.ma.masked_array(x, mask=[[True, False], [False, False]]), "masked entries"),
    "masked rows": (lambda x: [np.ma.masked_array(x[0], mask=[True, False]), x[1]], "masked entries"),
    "text": (lambda x: [["1.0", "2.0"], ["3.0", "4.0"]], "an array of <U3, made of list"),
    "objects": (lambda x: x.astype(object), "an array of object, made of ndarray"),
    "booleans": (lambda x: x > 0.0, "an array of bool, made of ndarray"),
    "a dictionary": (lambda x: {"force": x}, "an array of object, made of dict"),
    "nothing": (lambda x: None, r"None \(does it end with return\?\)$"),
    "ragged": (lambda x: [[1.0, 2.0], [3.0]], r"what is no regular array \(setting an array element"),
    "one row": (lambda x: x[0], r"the shape \(2,\)"),
    "turned": (lambda x: np.zeros((2, 3)), r"the shape \(2, 3\)"),
    "a number": (lambda x: 1.0, r"the shape \(\)"),
}


@pytest.mark.parametrize(("give", "found"), NO_FORCES.values(), ids=NO_FORCES)
def test_what_is_not_an_array_of_real_forces_is_refused_with_what_was_found(give, found):
    scene = pc.Scene(pc.Particles([[1.0, 0.0], [0.0, 1.0]]), pc.CustomForce(lambda time, x, v: give(x)))
    expected = r"^forces\[0\]\.function: expected forces of shape \(2, 2\), of real numbers, got "
    with pytest.raises(pc.SceneError, match=expected + found):
        pc.Simulation(scene, dt=0.1)


@pytest.mark.parametrize(
    ("give", "cure"),
    [
        (lambda x: x[0], "np.broadcast_to(value, (3, 2))"),
        (lambda x: 1.0, "np.broadcast_to(value, (3, 2))"),
        (lambda x: x.T, "value.T"),
        (lambda x: x.ravel(), "value.reshape((3, 2))"),
        (lambda x: x[:, :1], None),
        (lambda x: x[:2], None),
    ],
)
def test_a_wrong_shape_comes_with_a_cure_that_works(give, cure):
    body = pc.Particles([[1.0, 0.0], [0.0, 1.0], [2.0, 3.0]])
    with pytest.raises(pc.SceneError, match=r"forces\[0\]\.wind: expected velocities of shape \(3, 2\)") as caught:
        pc.Simulation(pc.Scene(body, pc.Drag(1.0, wind=lambda t, x: give(x))), dt=0.1)
    assert str(caught.value).partition("return ")[2].rstrip(")") == (cure or "").rstrip(")")
    if cure is not None:
        cured = lambda t, x: eval(cure, {"np": np, "value": give(x)})  # noqa: E731
        pc.Simulation(pc.Scene(body, pc.Drag(1.0, wind=cured)), dt=0.1).step(3)


def test_energies_that_are_not_summed_come_with_a_cure():
    force = pc.CustomForce(lambda time, x, v: -x, potential=lambda x: 0.5 * (x * x).sum(axis=1))
    with pytest.raises(pc.SceneError, match=r"potential: expected one energy, .* \(2,\) \(.* the sum of these\)$"):
        pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0], [0.0, 1.0]]), force), dt=0.1)


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_force_that_is_not_finite_is_refused_with_its_particle(value, precision):
    def force(time, x, v):
        forces = np.zeros_like(x)
        forces[1, 0] = value
        return forces

    bodies = [pc.Particles([[1.0, 0.0]]), pc.Particles([[2.0, 0.0], [3.0, 4.0]])]
    scene = pc.Scene(*bodies, pc.CustomForce(force, on=bodies[1]))
    shown = str(value).replace("nan", "NaN")
    found = rf"\[{shown}, 0.0\] N in row 1, for the particle at \[3.0, 4.0\] m"
    with pytest.raises(pc.SceneError, match=rf"^forces\[0\]\.function: expected finite forces, got {found}$"):
        pc.Simulation(scene, dt=0.1, precision=precision)


def test_a_force_beyond_single_precision_is_refused_there():
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: 0.0 * x + 1e39))
    pc.Simulation(scene, dt=0.1, precision="f64")
    with pytest.raises(pc.SceneError, match=r"^forces\[0\]\.function: expected forces that f32 can hold, got \[1e39"):
        pc.Simulation(scene, dt=0.1, precision="f32")


NO_ENERGIES = {
    "complex": (lambda x: 1.0 + 1j, "one energy, of real numbers, got an array of complex128, made of complex"),
    "masked": (lambda x: np.ma.masked, "one energy, of real numbers, got masked entries"),
    "text": (lambda x: "1.0", "one energy, of real numbers, got an array of <U3, made of str"),
    "a boolean": (lambda x: True, "one energy, of real numbers, got an array of bool, made of bool"),
    "nothing": (lambda x: None, "one energy, of real numbers, got None"),
    "one per particle": (lambda x: x[:, 0], r"one energy, of real numbers, got the shape \(1,\)"),
    "nan": (lambda x: float("nan"), "a finite energy, got NaN J"),
    "inf": (lambda x: -np.inf, "a finite energy, got -inf J"),
}


@pytest.mark.parametrize(("give", "message"), NO_ENERGIES.values(), ids=NO_ENERGIES)
def test_a_potential_gives_one_real_finite_number(give, message):
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: -x, give))
    with pytest.raises(pc.SceneError, match=r"^forces\[0\]\.potential: expected " + message):
        pc.Simulation(scene, dt=0.1)


@pytest.mark.parametrize("give", [lambda x: np.float32(0.0), lambda x: 0, lambda x: np.array(0.0)])
def test_a_potential_may_be_any_kind_of_real_number(give):
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: 0.0 * x, give))
    assert pc.Simulation(scene, dt=0.1).energy().potential == 0.0


def test_a_function_may_use_its_arguments_as_scratch():
    """They are copies: what it writes into them changes neither the state nor what the next function is given."""

    def spoils(time, x, v):
        forces = -x
        x[:], v[:] = np.nan, np.nan
        return forces

    def spoiled(x):
        energy = 0.5 * float((x**2).sum())
        x[:] = np.nan
        return energy

    tidy = pc.CustomForce(lambda time, x, v: -x, lambda x: 0.5 * float((x**2).sum()))
    runs = [
        pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), *forces), dt=0.1)
        for forces in ([tidy, tidy], [pc.CustomForce(spoils, spoiled), tidy])
    ]
    for run in runs:
        run.step(10)
    assert runs[0].state_hash() == runs[1].state_hash()
    assert runs[0].energy().total == runs[1].energy().total


def steep(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A force away from the center that overflows at a distance of 15 m."""
    with np.errstate(over="ignore"):
        return np.sign(x) * np.exp(50.0 * np.abs(x))


def growth(n: np.ndarray) -> tuple[np.ndarray]:
    """A logistic rate, which overflows only where steps do."""
    with np.errstate(over="ignore"):
        return (2.0 * n * (1.0 - n),)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_a_function_that_overflows_in_a_step_has_diverged():
    """The state that the step led to is not one of the function's, and the simulation stands before it."""
    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(steep)), dt=0.1)
    with pytest.raises(pc.SimulationDiverged, match=r"is where forces\[0\]\.function returns \[inf"):
        run.step(1000)
    assert np.isfinite(run.positions).all()


def test_an_overflow_does_not_end_a_search_for_the_cheapest_method():
    grid = pc.Grid(80, 0.05)
    start = np.random.default_rng(1).uniform(size=80)
    dish = pc.ReactionDiffusion(grid, pc.Reaction(("n",), growth), {"n": 1.0}, {"n": start})
    found = pc.simulate(pc.Scene(dish), 1.0, fps=4, accuracy=1e-4)
    fine = pc.simulate(pc.Scene(dish), 1.0, fps=4, dt=2e-4)
    assert np.abs(found[dish]["n"] - fine[dish]["n"]).max() <= 1e-4

"""The function `tradeoff`: checks the arguments, makes a work–precision diagram of each scene, and combines them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from physcore.arithmetic import log, power
from physcore.checks import FloatArray, count, flag, items, number, shown, span, words
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.numerics.choices import MOST_THREADS, suited
from physcore.numerics.contacts import Contacts, ContactSolver, contact_solver
from physcore.numerics.fluids import FluidMethod, WeaklyCompressible, fluid_method, fluid_methods
from physcore.numerics.integrators import INTEGRATORS, INTEGRATORS_BY_NAME, Integrator, made
from physcore.progress import Progress
from physcore.scene.scene import Scene
from physcore.simulation.recording import refuse_if_too_large
from physcore.simulation.simulation import Simulation
from physcore.spelling import did_you_mean
from physcore.studies.state import size
from physcore.studies.tradeoff.experiment import SAMPLES, Experiment, Observer
from physcore.studies.tradeoff.result import Row
from physcore.studies.tradeoff.trade import Tradeoff

if TYPE_CHECKING:
    from physcore.studies.tradeoff.search import WorkPrecisionDiagram

TICKS = 10
"""Largest update rate of the progress bar [1/s]."""
PRECISIONS: tuple[Literal["f64", "f32"], ...] = ("f64", "f32")
COPIES = 6
"""Peak memory in arrays of samples: three runs of a reference, the reference, its check and a row."""


@entrance
def tradeoff(
    scene: Scene | Callable[[float], Scene],
    duration: float,
    *,
    integrators: Sequence[Integrator | str] | None = None,
    precisions: Sequence[Literal["f32", "f64"]] = PRECISIONS,
    dts: Sequence[float] | None = None,
    resolutions: Sequence[float] | None = None,
    fluids: Sequence[FluidMethod | str] | None = None,
    contacts: Sequence[Contacts] | None = None,
    observe: Observer | None = None,
    budget: float = 30.0,
    threads: int | None = None,
    seed: int = 0,
    progress: bool | None = None,
) -> Tradeoff:
    """Measure the trade-off between speed and accuracy: integrators, time steps and precisions against a reference.

        trade = pc.tradeoff(scene, duration=0.1, budget=1.0)
        print(trade)
        simulation = pc.Simulation(scene, **trade.best(error=1e-3).numerics)

    Each integrator in each precision starts at 0.95 of its limit of stability. Its time step is halved until the error
    is that of the reference, smaller steps no longer help, or the budget is spent. Every row is compared with the
    reference at 32 equidistant times. Every row is timed five times, with all rows in random order. The reference is
    the best method in double precision with decreasing steps, extrapolated after Richardson, and checked by a method of
    another family.

    A copy perturbed by 1e-10 distinguishes chaotic and regular motion. If trajectories are lost within the duration,
    errors are measured over short windows that start on the reference. Averages over ensembles then find biased
    methods, because averages survive chaos (T. Boekholt, S. Portegies Zwart, Comput. Astrophys. Cosmol. 2, 2 (2015)).

    Args:
        scene: the scene, or a function that builds it from a resolution.
        duration: the simulated duration [s].
        integrators: the integrators or their names; None: all that support the scene.
        precisions: "f64", "f32" or both.
        dts: the time steps [s], each rounded down to an integer fraction of 1/32 of the duration. All of them are run,
            whatever the budget. None: the search described above.
        resolutions: arguments of `scene`, from the coarsest to the finest. Their references determine the error of the
            resolution, which is added to that of the time steps.
        fluids: the methods of fluids or their names; None: the default only. Errors of time steps are relative to the
            reference of the same method. With `resolutions`, the errors include those of the methods, each relative to
            the limit of its own resolutions.
        contacts: solvers of the contacts of rigid bodies; None: the default only. Errors are relative to the reference
            of the same solver. With short steps all of them have the same limit.
        observe: function of the simulation that returns the compared values, an array of numbers. None: the positions
            of all particles [m], or with `resolutions` the centers of the bodies; without particles, the first field of
            the first system. Of rigid bodies, the centers and points at their radii of gyration are compared, which
            show rotations. The first fields of further systems are compared too, scaled so that their largest changes
            in a run with the default numerics are as large; so are rigid bodies beside particles.
        budget: approximate total time [s]. The first three rows of each integrator may take as long again, and the very
            first ones are always run.
        threads: as in Simulation.
        seed: random seed of the perturbation, the ensembles and the order of the timing.
        progress: whether to show a progress bar; None: on a terminal.

    Raises:
        SceneError: an argument is not valid, or the samples would not fit into memory.
        PhyscoreError: no choice supports the scene, or all of them diverged.
    """
    from physcore.studies.tradeoff.report import machine  # imported here, because only this function needs it

    scenes = _scenes(scene, resolutions)
    interval, patience = span(duration, "duration"), span(budget, "budget")
    chosen = [kind() for kind in suited(scenes[0])] if integrators is None else _integrators(integrators)
    steps = None if dts is None else [span(dt, f"dts[{at}]") for at, dt in enumerate(items(dts, "dts", "time steps"))]
    kinds = words(precisions, "precisions", PRECISIONS)
    if steps == [] or not kinds:
        raise SceneError(f"{'precisions' if not kinds else 'dts'}: must not be empty")
    if observe is not None and not callable(observe):
        raise SceneError(f"observe: must be a function of a simulation, got {shown(observe)}")
    observer = observe or (_centers if resolutions is not None and all(each.bodies for each in scenes) else None)
    if observer is None and resolutions is not None:
        raise SceneError(
            "observe: fields of other resolutions have other shapes; say what to compare, such as "
            "observe=lambda run: run[wave].displacement[::n]"
        )
    random, bars = count(seed, "seed"), None if progress is None else flag(progress, "progress")
    team = None if threads is None else count(threads, "threads", least=1, most=MOST_THREADS)
    for each in scenes:
        if observer is None:
            needed = 8 * COPIES * (SAMPLES + 1) * size(each)
            refuse_if_too_large(SAMPLES + 1, each, needed, "observe fewer numbers: observe=…")
    methods = [
        (flow, solver)
        for flow in ((None,) if fluids is None else _fluids(fluids, scenes[0]))
        for solver in ((None,) if contacts is None else _contacts(contacts, scenes[0]))
    ]
    experiments = [
        Experiment(each, interval, team, observer, fluids=flow or "auto", contacts=solver or "auto")
        for flow, solver in methods
        for each in scenes
    ]
    with Progress(round(TICKS * patience), "measuring", bars) as bar:
        diagrams = _diagrams(experiments, chosen, kinds, steps, random, patience, bar)
    rows: list[Row] = []
    for index, method in enumerate(methods):
        own = diagrams[index * len(scenes) : (index + 1) * len(scenes)]
        errors = _discretization(own, resolutions)
        for diagram, resolution, error in zip(own, resolutions or (None,), errors, strict=True):
            rows += diagram.rows(resolution, error, *method)
    notes = dict.fromkeys(note for diagram in diagrams for note in diagram.notes)
    return Tradeoff(
        rows=tuple(rows),
        measure=diagrams[-1].measure,
        references=tuple(diagram.truth for diagram in diagrams),
        chaos=tuple(diagram.chaos for diagram in diagrams),
        experiments=tuple(diagram.experiment for diagram in diagrams),
        seed=random,
        notes=tuple(notes),
        machine=machine(diagrams[0].simd),
    )


def _diagrams(
    experiments: list[Experiment],
    integrators: list[Integrator],
    precisions: Sequence[Literal["f32", "f64"]],
    dts: list[float] | None,
    seed: int,
    patience: float,
    bar: Progress,
) -> list[WorkPrecisionDiagram]:
    """Measure each experiment with an equal share of the remaining time, then time all rows."""
    from physcore.studies.tradeoff.budget import Budget
    from physcore.studies.tradeoff.search import WorkPrecisionDiagram

    whole, ticks = Budget(patience), round(TICKS * patience)

    def tick() -> None:
        bar.update(min(round(TICKS * whole.spent()), ticks))

    diagrams = [
        WorkPrecisionDiagram(experiment, integrators, precisions, dts, seed, tick) for experiment in experiments
    ]
    for index, diagram in enumerate(diagrams):
        diagram.find(whole.share(1.0 / (len(diagrams) - index)))
    for diagram in diagrams:
        diagram.time()
    bar.update(ticks)
    return diagrams


def _scenes(scene: Scene | Callable[[float], Scene], resolutions: Sequence[float] | None) -> list[Scene]:
    """The scene, or one scene for each resolution."""
    if isinstance(scene, Scene):
        if resolutions is not None:
            raise SceneError("resolutions: the scene must then be a function that builds it from a resolution")
        return [scene]
    if not callable(scene):
        raise SceneError(f"scene: must be a Scene or a function that builds one, got {shown(scene)}")
    if resolutions is None:
        raise SceneError("resolutions: must be two or more, the coarsest first, got None")
    given = items(resolutions, "resolutions", "numbers")
    checked = [number(each, f"resolutions[{index}]", above=0.0) for index, each in enumerate(given)]
    if len(checked) < 2 or checked != sorted(set(checked)):
        raise SceneError(f"resolutions: must be two or more, the coarsest first, got {shown(resolutions)}")
    scenes = [scene(resolution) for resolution in given]
    for resolution, built in zip(resolutions, scenes, strict=True):
        if not isinstance(built, Scene):
            raise SceneError(f"scene: must give a Scene, gave {shown(built)} at resolution {resolution:g}")
    return scenes


def _integrators(integrators: Sequence[Integrator | str]) -> list[Integrator]:
    """The requested integrators, without repetitions."""
    given = [made(each) for each in items(integrators, "integrators", "integrators")]
    for integrator in given:
        if not isinstance(integrator, INTEGRATORS):
            hint = did_you_mean(integrator, INTEGRATORS_BY_NAME)
            raise SceneError(
                f"integrators: must be integrators, such as VelocityVerlet(), or their names, got {shown(integrator)}"
                f"{hint}"
            )
    if not given:
        raise SceneError("integrators: must not be empty")
    return list(dict.fromkeys(each for each in given if isinstance(each, Integrator)))


def _fluids(methods: Sequence[FluidMethod | str], scene: Scene) -> tuple[FluidMethod, ...]:
    """The requested methods of fluids, without repetitions."""
    given = [fluid_method(each, f"fluids[{index}]") for index, each in enumerate(items(methods, "fluids", "methods"))]
    if not given:
        raise SceneError("fluids: must not be empty")
    found = tuple(dict.fromkeys(method or WeaklyCompressible() for method in given))
    for method in found:
        fluid_methods(method, scene)
    return found


def _contacts(solvers: Sequence[Contacts], scene: Scene) -> tuple[ContactSolver, ...]:
    """The requested solvers of contacts, without repetitions."""
    given = items(solvers, "contacts", "solvers")
    if not given:
        raise SceneError("contacts: must not be empty")
    found = [contact_solver(each, scene, f"contacts[{index}]") for index, each in enumerate(given)]
    if None in found:
        raise SceneError("contacts: there are no rigid bodies in this scene")
    return tuple(dict.fromkeys(solver for solver in found if solver is not None))


def _centers(simulation: Simulation) -> FloatArray:
    """Mean position of each body [m]."""
    bodies = simulation.scene.bodies
    return np.array([simulation[body].positions.mean(axis=0) for body in bodies])


def _discretization(diagrams: list[WorkPrecisionDiagram], resolutions: Sequence[float] | None) -> list[float]:
    """Error of the reference of each resolution, relative to the limit of infinite resolution.

    The error of the finest resolution is its difference from the previous one, divided by rᵖ − 1. Here r is the ratio
    of the two resolutions, and p is the order observed from the last three, at least 1; it is 1 for two resolutions.
    The errors of the others add their distance from the finest.
    """
    from physcore.studies.tradeoff.reference import Reference

    truths = [diagram.truth for diagram in diagrams]
    if resolutions is None:
        return [0.0]
    samples = [truth.samples for truth in truths if isinstance(truth, Reference)]
    until = min(diagram.until() for diagram in diagrams)
    experiment = diagrams[-1].experiment
    apart = [float(experiment.distances(each[:until], samples[-1][:until]).max()) for each in samples[:-1]]
    steps = [float(experiment.distances(one[:until], two[:until]).max()) for one, two in pairwise(samples)]
    ratio, order = resolutions[-1] / resolutions[-2], 1.0
    if len(steps) > 1 and steps[-1] > 0.0:
        order = max(1.0, float(log(steps[-2] / steps[-1]) / log(ratio)))
    finest = steps[-1] / (float(power(ratio, order)) - 1.0)
    return [*(error + finest for error in apart), finest]

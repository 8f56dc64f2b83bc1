"""Simulation with given numerics, or with numerics chosen for a requested accuracy."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Unpack

from physcore.checks import flag, is_word, number, span
from physcore.entrance import entrance
from physcore.errors import AccuracyError, SceneError
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, check, suited
from physcore.numerics.integrators import RATTLE
from physcore.scene.scene import Scene
from physcore.simulation.cache import cached, check_key
from physcore.simulation.event import Event, checked
from physcore.simulation.frames import frame_count
from physcore.simulation.recording import Recording, check_channels, refuse_if_too_large
from physcore.simulation.simulation import Simulation, require_scene
from physcore.simulation.step_warnings import unwarned
from physcore.studies.state import compared, size
from physcore.studies.tradeoff.experiment import Choice, Experiment, Trial
from physcore.studies.tradeoff.methods import SAFETY, largest_step, methods
from physcore.studies.tradeoff.refinement import Target
from physcore.studies.tradeoff.selection import Candidate, Selection, select

COPIES = 6
"""Peak memory in arrays of all positions: of three runs, of one that is computed and recorded, and of their
differences.
"""


@entrance
def simulate(
    scene: Scene,
    duration: float,
    fps: float = FRAMES_PER_SECOND,
    *,
    channels: tuple[str, ...] | None = None,
    progress: bool | None = None,
    accuracy: float | None = None,
    energy_drift: float | None = None,
    events: Sequence[Event] = (),
    cache: str | os.PathLike[str] | None = None,
    key: str | None = None,
    **numerics: Unpack[Options],
) -> Recording:
    """Simulate a scene from its start, and record it.

        recording = pc.simulate(scene, duration=0.5, fps=30)
        recording.positions.shape  # (16, 20, 2)

    With `accuracy` or `energy_drift`, the integrator and the time step are chosen automatically. Short test runs
    measure the cost of every integrator. The cheapest one then makes a few runs of the whole duration, with steps from
    its measured order. The first run proven to meet the target is returned. The proof compares runs with different
    steps. If the errors of three runs follow the order of the method, the bound is twice the extrapolated error.
    Otherwise, and whenever particles can hit something, only order one is assumed. The achieved accuracy is printed,
    and is a note of the recording's plan.

    With `cache`, the recording is kept in a file. The next call with equal arguments reads it, with the same bits. The
    name of the file is a hash of the scene, the numerics, all other arguments and the version of physcore. See
    docs/sweeps.md.

    Args:
        scene: the scene.
        duration: the simulated duration [s].
        fps: frames per second of simulated time.
        channels: the recorded fields: "positions" and "velocities"; with a Fluid also "densities", "pressures",
            "wall_forces" and "probe_pressures"; fields of systems with their names, such as "pond.displacement". None:
            all except densities and pressures.
        progress: whether to show a progress bar; None: on a terminal, after one second.
        accuracy: largest error of any particle's position at any frame [m]; of rigid bodies, also that of points at
            their radii of gyration, which show rotations. Without bodies, the largest error of the
            first field of the first system, in its unit. The first fields of further systems are compared too: their
            errors, relative to their largest changes in a run with the default numerics, must not be larger.
        energy_drift: largest drift of the energy balance, as in `Recording.energy.drift`.
        events: events to look for, such as `pc.Event.crossing("ball", "y", 0.5)`, for `Recording.events`. A terminal
            one ends the run; the last frame is at or before it. With `accuracy` or `energy_drift`, the chosen run is
            repeated for them.
        cache: a folder for recordings, which is created if necessary. Warnings of the first run are not repeated; the
            notes of its plan are kept. Nothing is ever deleted.
        key: a text that stands for the functions of the scene, such as that of a CustomForce, which have no hash. Give
            another one whenever a function changes. Functions of `events` are recognized by their source, with
            defaults and closures.
        numerics: integrator, dt, precision, threads, max_energy_growth, on_divergence, fluids, contacts, as in
            Simulation. dt must not be given with `accuracy` or `energy_drift`. If an integrator is given, or one for
            each item, no other is tried.

    Raises:
        SceneError, SimulationDiverged: as for Simulation. With `cache`, a scene with functions needs a `key`.
        AccuracyError: no method reaches the accuracy or the drift; the error has the best values reached.
        FileError: the folder of the cache cannot be written.

    Warns:
        FileWarning: a file of the cache is damaged, and the recording is computed anew.
    """
    if progress is not None:
        flag(progress, "progress")
    name = check_key(key, used=cache is not None)
    run = partial(_simulate, scene, duration, fps, channels, progress, accuracy, energy_drift, events, numerics)
    if cache is None:
        return run()
    require_scene(scene)
    arguments = {"accuracy": accuracy, "energy_drift": energy_drift}
    numbers = {name: None if each is None else number(each, name, above=0.0) for name, each in arguments.items()}
    lengths = {"duration": span(duration, "duration", empty=True), "fps": span(fps, "fps")}
    return cached(cache, scene, numerics, {**numbers, **lengths}, channels, events, name, run)


def _simulate(
    scene: Scene,
    duration: float,
    fps: float,
    channels: tuple[str, ...] | None,
    progress: bool | None,
    accuracy: float | None,
    energy_drift: float | None,
    events: Sequence[Event],
    numerics: Options,
) -> Recording:
    """The recording of a run; arguments as for `simulate`."""
    if accuracy is None and energy_drift is None:
        return Simulation(scene, **numerics).record(duration, fps, channels, progress=progress, events=events)
    require_scene(scene)
    if not is_word(numerics.get("dt", "auto"), "auto"):
        raise SceneError("dt: is what accuracy= and energy_drift= choose; leave it out")
    target = Target(
        math.inf if accuracy is None else number(accuracy, "accuracy", above=0.0),
        math.inf if energy_drift is None else number(energy_drift, "energy_drift", above=0.0),
    )
    kept = check_channels(channels, scene)
    whole, rate = span(duration, "duration", empty=True), span(fps, "fps")
    if frame_count(whole, rate, scene.units) < 2:
        raise SceneError("fps: there is no frame but the first; ask for more of them, or for a longer duration")
    given = checked(events, scene)
    selection = _search(scene, target, whole, rate, kept, numerics)
    recording, proof = selection.trial.recording, _proof(selection)
    if given:
        simulation = selection.candidate.experiment.start(selection.trial.choice)
        with unwarned():
            recording = simulation.record(whole, rate, kept, progress=False, events=given)
    assert recording is not None
    print(proof)
    recording = replace(recording, channels={name: recording.channels[name] for name in kept})
    return replace(recording, plan=replace(recording.plan, notes=(*recording.plan.notes, proof)))


def _search(
    scene: Scene, target: Target, duration: float, fps: float, channels: tuple[str, ...], options: Options
) -> Selection:
    """The run that is proven to meet a target, and the other results of the selection.

    Raises:
        SceneError: no method supports the scene, or the given one does not.
        AccuracyError: no method meets the target.
    """
    numerics = check(options, scene)
    given = options.get("integrator", "auto")
    frames = frame_count(duration, fps, scene.units)
    needed = 8 * COPIES * frames * size(scene)
    refuse_if_too_large(frames, scene, needed, "or ask for fewer frames: fps=…")
    intervals = frames - 1
    experiment = Experiment(
        scene,
        intervals / fps,
        numerics.threads,
        intervals=intervals,
        max_energy_growth=options.get("max_energy_growth"),
        on_divergence=numerics.on_divergence,
        integrators=given if isinstance(given, Mapping) else None,
        fluids=options.get("fluids", "auto"),
        contacts=options.get("contacts", "auto"),
    )

    def record(choice: Choice) -> Trial:
        needed = [channel for each in compared(scene) for channel in each.channels]
        return experiment.recorded(choice, duration, fps, tuple(dict.fromkeys((*needed, *channels))))

    some = [numerics.integrator]
    if is_word(given, "auto"):
        some = [kind() for kind in suited(scene) if kind.order > 1] + [RATTLE(order=4)] * scene.has_rods
    found = methods(experiment, some, numerics.precision)
    if any(force.is_contact for force in scene.forces):
        # The contact force has a kink at first touch, which limits all methods to order two.
        found = [replace(method, order=min(method.order, 2)) for method in found]
    selection = select(
        [
            Candidate(
                experiment,
                method,
                numerics.precision,
                target,
                experiment.steps_of(SAFETY * largest_step(method, found)),
                record,
            )
            for method in found
        ]
    )
    if selection is not None and selection.proven:
        trial = selection.trial
        _refuse_trees(selection, target)
        return replace(selection, trial=trial if trial.recording is not None else record(trial.choice))
    unit = experiment.comparison.suffix
    asked = [f"within {target.accuracy:g}{unit}"] * target.compares
    asked += [f"energy drift {target.energy_drift:g}"] * math.isfinite(target.energy_drift)
    reached = "every one diverged"
    error, drift = math.inf, math.inf
    if selection is not None:
        error, drift = selection.error, selection.drift
        name = type(selection.trial.choice.integrator).__name__
        reached = f"the best was {name}, off by {error:.1e}{unit} with a drift of {drift:.1e}"
    raise AccuracyError(
        f"{'accuracy' if target.compares else 'energy_drift'}: no method gets there ({', '.join(asked)}): "
        f"{reached}; {_advice(options, scene)}",
        error=error,
        energy_drift=drift,
    )


def _refuse_trees(selection: Selection, target: Target) -> None:
    """Compare the run with one by trees of half the opening angle. All runs of the search share the error of the trees.

    Raises:
        AccuracyError: the error of the trees is above the target.
    """
    experiment, trial = selection.candidate.experiment, selection.trial
    scene = experiment.scene
    trees = [index for index, force in enumerate(scene.forces) if force.finer() is not force]
    if not trees or not target.compares:
        return
    finer = Scene(
        *scene.bodies,
        *(force.finer() for force in scene.forces),
        *scene.boundaries,
        *scene.constraints,
        *scene.systems,
        *scene.probes,
        units=scene.units,
    )
    samples = replace(experiment, scene=finer).completed(trial.choice).samples
    common = min(len(samples), len(trial.samples))
    # The error falls at least by the factor 8: a quadrupole's next term has the third power of the angle.
    error = float(experiment.distances(trial.samples[:common], samples[:common]).max()) * 8.0 / 7.0
    if error + selection.error > target.accuracy:
        unit = experiment.comparison.suffix
        raise AccuracyError(
            f"forces[{trees[0]}].opening_angle: the trees alone are off by {error:.1e}{unit}, and "
            f"{target.accuracy:g}{unit} is asked; take a smaller one, or 0 for exact sums",
            error=error + selection.error,
            energy_drift=selection.drift,
        )


def _advice(numerics: Options, scene: Scene) -> str:
    """Advice if no method meets the target."""
    advice = []
    if check(numerics, scene).precision == "f32":
        advice.append('take precision="f64"')
    if not is_word(numerics.get("integrator", "auto"), "auto"):
        advice.append("leave integrator out, so that others are tried")
    chaos = "no trajectory can be followed for long: pc.tradeoff(scene, duration) says until when"
    return "; ".join([*advice, f"where the motion is chaotic {chaos}"])


def _proof(selection: Selection) -> str:
    """A sentence on the proven error of the returned run."""
    name, dt = (
        type(selection.trial.choice.integrator).__name__,
        selection.candidate.experiment.dt(selection.trial.choice),
    )
    method = f"{name} with dt = {dt:.4g}{selection.candidate.experiment.scene.units.suffix('s')}"
    if not selection.candidate.target.compares:
        return f"{method} keeps within an energy drift of {selection.drift:.1e}"
    measured = selection.candidate.experiment.comparison.suffix
    return (
        f"{method} keeps within {selection.error:.1e}{measured} "
        f"(energy drift {selection.drift:.1e}), as runs with other steps prove"
    )

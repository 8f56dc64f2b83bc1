"""From a target to a recording: with given numerics, or with those that keep an error within what was asked for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Unpack

from physcore.checks import flag, is_word, number, span
from physcore.errors import AccuracyError, SceneError
from physcore.forces import SoftSpheres
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, check, suited
from physcore.scene.scene import Scene
from physcore.simulation.frames import frame_count
from physcore.simulation.recording import Recording, check_channels, refuse_if_too_large
from physcore.simulation.simulation import Simulation, require_scene
from physcore.spelling import spelled
from physcore.studies.state import primary, size, unit
from physcore.studies.tradeoff.experiment import Choice, Experiment, Trial
from physcore.studies.tradeoff.methods import SAFETY, largest_step, methods
from physcore.studies.tradeoff.refinement import Target
from physcore.studies.tradeoff.selection import Candidate, Selection, select

COPIES = 6
"""Arrays of all positions that are in memory at once: of three runs, of one that is made and recorded, and of what they
differ by."""


@spelled
def simulate(
    scene: Scene,
    duration: float,
    fps: float = FRAMES_PER_SECOND,
    *,
    channels: tuple[str, ...] | None = None,
    progress: bool | None = None,
    accuracy: float | None = None,
    energy_drift: float | None = None,
    **numerics: Unpack[Options],
) -> Recording:
    """Simulate a scene from its start and record it.

        recording = pc.simulate(scene, duration=0.5, fps=30)
        recording.positions.shape  # (16, 20, 2)

    With `accuracy` or `energy_drift` integrator and time step are chosen: short probes price every integrator, the
    cheapest goes on with a few runs of the whole duration, whose steps are found from the order that is measured, and
    the first run that is proven to meet the target is returned. A run is proven by others with other steps: where the
    errors of three follow the order of the method, by twice the error that this gives; else, and wherever particles can
    hit something, by no more than order one. What was achieved is printed, and is a note of the recording's plan.

    Args:
        scene: what to simulate.
        duration: [s].
        fps: frames per second of simulated time.
        channels: what to keep of each frame: "positions" and "velocities", of a Fluid also "densities" and "pressures",
            "wall_forces" and "probe_pressures", of further systems their fields after their names, "pond.displacement";
            None: all but densities and pressures.
        progress: whether to show a progress bar; None: on a terminal, when it takes longer than a second.
        accuracy: how far any particle may be from where it should be, at any frame [m]; without particles, how far any
            value of the first field of the first system may be off, in its unit.
        energy_drift: how far the energy balance may drift, as `Recording.energy.drift` counts it.
        numerics: integrator, dt, precision, threads, max_energy_growth, on_divergence, fluids, as in Simulation; dt is
            not to be given with `accuracy` or `energy_drift`, and an integrator that is given, or one for each item, is
            the only one that is tried.

    Raises:
        SceneError, SimulationDiverged: as for Simulation.
        AccuracyError: no method keeps the accuracy or the drift; with the best that was reached.
    """
    if progress is not None:
        flag(progress, "progress")
    if accuracy is None and energy_drift is None:
        return Simulation(scene, **numerics).record(duration, fps, channels, progress=progress)
    require_scene(scene)
    if not is_word(numerics.get("dt", "auto"), "auto"):
        raise SceneError("dt: is what accuracy= and energy_drift= choose; leave it out")
    target = Target(
        math.inf if accuracy is None else number(accuracy, "accuracy", above=0.0),
        math.inf if energy_drift is None else number(energy_drift, "energy_drift", above=0.0),
    )
    kept = check_channels(channels, scene)
    whole, rate = span(duration, "duration", empty=True), span(fps, "fps")
    if frame_count(whole, rate) < 2:
        raise SceneError("fps: there is no frame but the first; ask for more of them, or for a longer duration")
    selection = _search(scene, target, whole, rate, kept, numerics)
    recording, proof = selection.trial.recording, _proof(selection)
    assert recording is not None
    print(proof)
    recording = replace(recording, channels={name: recording.channels[name] for name in kept})
    return replace(recording, plan=replace(recording.plan, notes=(*recording.plan.notes, proof)))


def _search(
    scene: Scene, target: Target, duration: float, fps: float, channels: tuple[str, ...], options: Options
) -> Selection:
    """The run that is proven to meet a target.

    Raises:
        SceneError: no method can compute the scene, or it has none that was given.
        AccuracyError: none meets the target.
    """
    numerics = check(options, scene)
    given = options.get("integrator", "auto")
    frames = frame_count(duration, fps)
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
    )

    def record(choice: Choice) -> Trial:
        return experiment.recorded(choice, duration, fps, tuple(dict.fromkeys((primary(scene), *channels))))

    some = [kind() for kind in suited(scene) if kind.order > 1] if is_word(given, "auto") else [numerics.integrator]
    found = methods(experiment, some, numerics.precision)
    if any(isinstance(force, SoftSpheres) for force in scene.forces):
        # Their force begins with a kink, which leaves order two to all methods.
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
        return replace(selection, trial=trial if trial.recording is not None else record(trial.choice))
    asked = [f"within {target.accuracy:g} {unit(scene)}"] * target.compares
    asked += [f"energy drift {target.energy_drift:g}"] * math.isfinite(target.energy_drift)
    reached = "every one diverged"
    error, drift = math.inf, math.inf
    if selection is not None:
        error, drift = selection.error, selection.drift
        name = type(selection.trial.choice.integrator).__name__
        reached = f"the best was {name}, off by {error:.1e} {unit(scene)} with a drift of {drift:.1e}"
    raise AccuracyError(
        f"{'accuracy' if target.compares else 'energy_drift'}: no method gets there ({', '.join(asked)}): "
        f"{reached}; {_advice(options, scene)}",
        error=error,
        energy_drift=drift,
    )


def _advice(numerics: Options, scene: Scene) -> str:
    """What to change where nothing does what was asked for."""
    advice = []
    if check(numerics, scene).precision == "f32":
        advice.append('take precision="f64"')
    if not is_word(numerics.get("integrator", "auto"), "auto"):
        advice.append("leave integrator out, so that others are tried")
    chaos = "no trajectory can be followed for long: pc.tradeoff(scene, duration) says until when"
    return "; ".join([*advice, f"where the motion is chaotic {chaos}"])


def _proof(selection: Selection) -> str:
    """What is known of the run that is returned."""
    name, dt = (
        type(selection.trial.choice.integrator).__name__,
        selection.candidate.experiment.dt(selection.trial.choice),
    )
    if not selection.candidate.target.compares:
        return f"{name} with dt = {dt:.4g} s keeps within an energy drift of {selection.drift:.1e}"
    measured = unit(selection.candidate.experiment.scene)
    return (
        f"{name} with dt = {dt:.4g} s keeps within {selection.error:.1e} {measured} "
        f"(energy drift {selection.drift:.1e}), as runs with other steps prove"
    )

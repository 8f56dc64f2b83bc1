"""A simulation owns state and clock."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Literal

from numpy.typing import ArrayLike

from physcore.checks import FloatArray, flag, shown, span
from physcore.errors import SceneError
from physcore.numerics.choices import (
    FRAMES_PER_SECOND,
    DivergenceRule,
    Integrators,
    Numerics,
    Options,
    Precision,
    StepRule,
    check,
)
from physcore.numerics.contacts import Contacts
from physcore.numerics.fluids import Fluids, check_flows
from physcore.numerics.integrators import Integrator
from physcore.progress import Progress
from physcore.scene.bodies import Body
from physcore.scene.contents import BodyKey, ItemKey
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation import frames as sampling
from physcore.simulation.alternation import alternating
from physcore.simulation.changes import Changes
from physcore.simulation.checkpoint import Checkpoint
from physcore.simulation.earlier import Earlier
from physcore.simulation.event import Event, checked
from physcore.simulation.measured import Measured
from physcore.simulation.notes import material_drift, noted, of_scene
from physcore.simulation.occurrences import Events
from physcore.simulation.plan import Plan
from physcore.simulation.provenance import Provenance, version
from physcore.simulation.recording import Recording, check_channels, collect
from physcore.simulation.replacement import carry, numerics_for, require_alike
from physcore.simulation.serial import pack_numerics
from physcore.simulation.state import Frame, Part
from physcore.simulation.stepper import Stepper
from physcore.simulation.watch import Watch
from physcore.storage import archive

State = ArrayLike | Mapping[BodyKey, ArrayLike]
"""New values for all particles, or for some bodies."""


class Simulation(Measured):
    """The state of a scene, and the clock that moves it on.

        simulation = pc.Simulation(scene, integrator="RungeKutta4", dt=1e-3)
        simulation.step(100)
        simulation.time, simulation["cloth"].positions

    Args:
        scene: what to simulate.
        integrator: how to step, such as RungeKutta4(), or its name, "RungeKutta4"; "auto": VelocityVerlet(), with rods
            RATTLE(), in magnetic fields Boris(), or what an item says is its default; with dt="auto", smooth scenes of
            at most 1000 particles have a method of order 4 or 5. One is for all that it can drive; a mapping gives some
            items their own: `{wave: pc.RungeKutta4(), "bodies": pc.PEFRL()}`, by items or their names. All bodies are
            one system, with one integrator.
        dt: the time step [s]; "auto" is AutoStep(), which chooses it from the limit of stability of the scene, in small
            scenes AutoStep(resolve=True), which resolves the fastest oscillation; with GaussRadau15() the control of
            its own; where there are rods AdaptiveStep(), which follows the motion. Where a scene has several systems,
            such as bodies and a wave, one whose own limit is below a given time step divides it into equal substeps,
            and the plan says how many; other rules choose steps that suit all of them.
        precision: "f64", or "f32": forces in single precision, energies in double; "auto" is "f32" for scenes with a
            fluid, and "f64" for all others.
        threads: how many threads may share the work; None: PHYSCORE_NUM_THREADS, or all that the process may use. The
            results have the same bits for any number.
        max_energy_growth: how many times the largest energy so far the energy balance may rise before it counts as
            diverged; None: 1e6, and 1 with on_divergence="substep".
        on_divergence: "raise"; "substep": take a step that fails again in halves, quarters and so on, down to 1/1024 of
            it, and warn; the energy budget is then looked at in each step, which takes about as long as the forces; or
            "ignore": go on until a position or velocity is not finite; energies, which are squares, cease to be before.
        fluids: how fluids are computed, such as WeaklyCompressible(…), one method for all or a mapping
            `{water: method}`, by fluids or their names; "auto": WeaklyCompressible().
        contacts: how contacts and joints of rigid bodies are solved, ContactSolver(…); "auto": ContactSolver().

    Raises:
        SceneError: a choice is not valid, dt="auto" finds no stable step, a particle starts outside a boundary, or the
            scene does not fit into memory.
        KeyboardInterrupt: Ctrl-C.

    Warns:
        StabilityWarning: `dt` is above the limit of stability, or a step had to be taken in parts; said once in a run.
        MachWarning: a fiftieth of a fluid flows faster than 0.15 of its speed of sound; said once in a run.
    """

    def __init__(
        self,
        scene: Scene,
        integrator: Integrators = "auto",
        dt: float | StepRule | Literal["auto"] = "auto",
        precision: Precision = "auto",
        threads: int | None = None,
        *,
        max_energy_growth: float | None = None,
        on_divergence: DivergenceRule = "raise",
        fluids: Fluids = "auto",
        contacts: Contacts = "auto",
    ) -> None:
        require_scene(scene)
        options = Options(
            integrator=integrator,
            dt=dt,
            precision=precision,
            threads=threads,
            max_energy_growth=max_energy_growth,
            on_divergence=on_divergence,
            fluids=fluids,
            contacts=contacts,
        )
        with scene.units.worded():
            self._build(scene, check(options, scene))
            check_flows(self._numerics.fluids, scene)
            self._stepper.begin()

    def _build(self, scene: Scene, numerics: Numerics) -> None:
        self._scene = scene
        self._numerics = numerics
        self._world = engine.build(scene, numerics)
        self._stepper = Stepper(self._world, scene, numerics)
        self._watch: Watch | None = None

    @property
    def scene(self) -> Scene:
        """The scene that is simulated."""
        return self._scene

    @property
    def integrator(self) -> Integrator:
        """How it is stepped; where items have integrators of their own, that of the bodies or of the first system."""
        return self._numerics.integrator

    @property
    def time(self) -> float:
        """The time of the present state [s]."""
        return self._world.time

    @property
    def steps(self) -> int:
        """How many steps have been taken; one that was taken in parts counts as those."""
        return self._world.steps

    @property
    def substeps(self) -> int:
        """How many steps failed and were taken again in parts, with on_divergence="substep" or adaptive steps."""
        return self._stepper.substepped

    @property
    def dt(self) -> float:
        """The time step [s]: of the last step taken, and before the first one that of the next."""
        return self._stepper.dt

    @property
    def evaluations(self) -> int:
        """How many times each step evaluates the forces."""
        return engine.evaluations(self._world)

    @property
    def positions(self) -> FloatArray:
        """Positions of all particles, body by body [m], shape (N, D), within the periodic domain; a copy. Rigid bodies
        are no particles.
        """
        return self._field("positions")

    @property
    def velocities(self) -> FloatArray:
        """Velocities of all particles, body by body [m/s], shape (N, D); a copy."""
        return engine.read(self._world, self._scene, "velocities")

    @property
    def plan(self) -> Plan:
        """The plan: the stages of one step, and the choices that were made."""
        limit = self._stepper.limit
        plan = engine.plan(self._world, self._scene, limit, self.dt)
        notes = (*plan.notes, *map(self._scene.units.reworded, (*self._scene_notes, *self._stepper.notes(limit))))
        return replace(plan, substeps=self.substeps, notes=notes)

    @cached_property
    def _scene_notes(self) -> list[str]:
        """Notes on the scene, which look at whole fields, and call reactions and functions of time: found once."""
        return [*of_scene(self._scene, self._numerics), *alternating(self._scene, self.dt)]

    @property
    def provenance(self) -> Provenance:
        """The provenance of the present state: what it takes, beside the scene, to compute it again."""
        return Provenance(version(), pack_numerics(self._numerics), self._stepper.segments, self.state_hash())

    def __getitem__(self, item: ItemKey) -> Part:
        """The present state of one body, given itself, its index or its name; a Fluid's has densities and pressures.

        Of a further system, given itself or its name: its fields. `simulation[item].set(…)` changes them. Of a probe
        its pressure [Pa]; of a boundary, or a body in a fluid, the force of fluids on it [N], without surface tension.
        """
        parts = self._scene.parts(item)
        there = self._listed
        fields = {name: self._field(field)[rows] for name, (field, rows) in parts.items() if field in there}
        return Part(self.time, self._scene.results(item, fields), lambda values: self._set_part(item, values))

    @property
    def _listed(self) -> set[str]:
        """The names of the fields that there are with the integrator."""
        return {info.name for info in engine.fields(self._world, self._scene)}

    def _field(self, name: str) -> FloatArray:
        """The values of a field, with positions within the periodic domain."""
        values = engine.read(self._world, self._scene, name)
        return engine.show(values, self._scene) if name in engine.PLACES else values

    def __repr__(self) -> str:
        return f"Simulation({self._scene!r}, {self.integrator!r}, time={self.time:g}, steps={self.steps})"

    def step(self, n: int = 1) -> None:
        """Take n equal steps.

        Raises:
            SceneError: steps are adaptive, and so not equal: use `run`; or so many particles have come near each other
                that lists of neighbors no longer fit into memory, and the simulation stands at the last good step.
            SimulationDiverged: the state blew up; the simulation stands at the last good step.
            KeyboardInterrupt: Ctrl-C; the simulation stands at a whole step and can go on.
        """
        with self._scene.units.worded():
            self._stepper.step(n)

    @property
    def events(self) -> Events:
        """The occurrences of the events that the last `run`, `record` or `frames` looked for; also after an error."""
        return Events() if self._watch is None else self._watch.events

    def run(self, duration: float, events: Sequence[Event] = ()) -> None:
        """Advance by `duration` [s]: ⌈duration/dt⌉ steps; with dt="auto" or adaptive steps the last one ends exactly
        there.

            simulation.run(0.1, events=[pc.Event.crossing("cloth", "y", -0.1)])
            simulation.events[0].times

        Args:
            duration: [s].
            events: what to look for on the way; a terminal one ends the run, and the simulation is then at the event.

        Raises:
            SceneError: an argument is not valid, or the function of an event fails.
            SimulationDiverged, KeyboardInterrupt: as for `step`.
        """
        interval = span(duration, "run.duration", empty=True)
        watch = self._watch_for(events, None)
        with self._scene.units.worded():
            self._stepper.run(interval, watch=watch)
            self._stepper.settle(watch)

    def frame(self) -> Frame:
        """The present state with its budgets, as a Frame.

            frame = simulation.frame()
            frame.time, frame["cloth"].positions, frame.energy.total

        Its arrays are copies.
        """
        return sampling.present(self._world, self._scene, self._stepper)

    def frames(self, duration: float, fps: float = FRAMES_PER_SECOND, events: Sequence[Event] = ()) -> Iterator[Frame]:
        """Advance by `duration` [s] and give `fps` frames per second on the way, in constant memory.

        The first frame is the present state. Frames between two steps of a given dt are cubic Hermite interpolations.
        Who stops early finds the simulation at the last frame, or one step past it. `events` is as for `run`; the last
        frame is then at or before a terminal event.

        Raises:
            SceneError: an argument is out of range.
            PhyscoreError: the simulation was stepped between two frames.
            SimulationDiverged, KeyboardInterrupt: as for `step`.
        """
        return self._frames(duration, fps, self._watch_for(events, None))

    def _frames(self, duration: float, fps: float, watch: Watch | None) -> Iterator[Frame]:
        interval, rate = span(duration, "duration", empty=True), span(fps, "fps")
        return sampling.frames(self._world, self._scene, self._stepper, interval, rate, watch)

    def record(
        self,
        duration: float,
        fps: float = FRAMES_PER_SECOND,
        channels: tuple[str, ...] | None = None,
        *,
        progress: bool | None = None,
        events: Sequence[Event] = (),
    ) -> Recording:
        """Advance by `duration` [s] and keep `fps` frames per second.

        Args:
            duration: [s].
            fps: frames per second of simulated time.
            channels: what to keep of each frame, such as "positions" and "velocities", of rigid bodies too, with these
                "angles" or "orientations" and "angular_velocities", and with a Fluid "densities" and "pressures",
                "wall_forces" and "probe_pressures"; None: all but the first two of fluids.
            progress: whether to show a progress bar; None: on a terminal, when it takes longer than a second.
            events: what to look for on the way, for `Recording.events`. A terminal one ends the run; the last frame is
                then at or before it, and the simulation is at the event.

        Raises:
            SceneError: the recording would not fit into memory, or an argument is out of range.
            SimulationDiverged, KeyboardInterrupt: as for `step`.

        Warns:
            StabilityWarning: dt was left to be chosen, and the energy balance does not hold to 5 %.
            SceneWarning: this takes more than 10⁷ steps.
        """
        kept = check_channels(channels, self._scene, self._listed)
        shown = None if progress is None else flag(progress, "progress")
        watch = self._watch_for(events, kept)
        frames = self._frames(duration, fps, watch)
        count = sampling.frame_count(float(duration), float(fps), self._scene.units)
        with Progress(count, "simulating", shown) as bar:
            shapes = {info.name: info.shape for info in engine.fields(self._world, self._scene) if info.name in kept}
            recording = collect(frames, count, self._scene, float(fps), shapes, self._end, bar.update)
        self._stepper.warn_of_drift(material_drift(recording))
        return noted(recording if watch is None else replace(recording, events=watch.events))

    def _watch_for(self, events: object, channels: tuple[str, ...] | None) -> Watch | None:
        """A watch that keeps these fields; None without events."""
        given = checked(events, self._scene)
        kept = check_channels(channels, self._scene, self._listed)
        self._watch = Watch(given, self._world, self._scene, self._numerics, kept) if given else None
        return self._watch

    def replace(self, scene: Scene) -> None:
        """Go on with a changed scene, from the present state at the present time.

            stiffer = pc.Scene(pc.cloth((12, 8), 0.05, stiffness=800.0, name="cloth"), pc.Gravity())
            simulation.replace(stiffer)

        Bodies and systems that both scenes have keep their state: the same objects, those of one name, and without
        names those in the same order. All other items begin as the new scene says, and parameters are those of the new
        scene. The change of energy is work. A time step that was left to be chosen is chosen anew; all other numerics
        stay. As after `set`, what methods and forces keep from earlier steps is found anew from the state. A scene that
        is equal to the present one changes no bit. Iterations over `frames` end with an error. See docs/replace.md.

        Raises:
            SceneError: the scene is not valid; something cannot be carried over, which is named; or a particle is now
                beyond a boundary. The simulation is then as before.
            PhyscoreError: the simulation is running.

        Warns:
            StabilityWarning: a given `dt` is above the limit of stability of the new scene.
        """
        require_scene(scene)
        with scene.units.worded(), self._stepper.alone():
            require_alike(scene, self._scene)
            numerics = numerics_for(scene, self._scene, self._numerics)
            check_flows(numerics.fluids, scene)
            if engine.is_same(engine.describe(scene, numerics), engine.describe(self._scene, self._numerics)):
                return self._adopt(scene)
            world = engine.build(scene, numerics)
            carry(world, scene, self._world, self._scene)
            stepper, units = Stepper(world, scene, numerics), scene.units
            before = sampling.audit(self._world, units, self._stepper.earlier)
            after = sampling.audit(world, units, Earlier())
            stepper.begin()
            stepper.succeed(self._stepper, self._stepper.earlier.then(before, after, world.time))
            self._numerics, self._world, self._stepper = numerics, world, stepper
            return self._adopt(scene)

    def _adopt(self, scene: Scene) -> None:
        """Take another scene, whose items are the keys from now on."""
        self._scene = scene
        self.__dict__.pop("_scene_notes", None)

    def set(self, positions: State | None = None, velocities: State | None = None) -> None:
        """Replace the state between two steps; the change of energy counts as work.

        Args:
            positions: [m], an array that broadcasts to (N, D), for all particles, or a mapping from bodies to arrays;
                rigid bodies are set by a mapping. They may lie outside of the periodic domain; springs are stretched
                from one to the other as they are given.
            velocities: [m/s], likewise.

        Raises:
            SceneError: a shape does not fit, or a value is not finite.
        """
        given = {"positions": positions, "velocities": velocities}
        changes = Changes(self._world, self._scene)
        with self._scene.units.worded():
            for name, values in given.items():
                if values is not None:
                    changes.put(name, values)
            self._write(changes.fields)

    def _set_part(self, item: ItemKey, values: Mapping[str, ArrayLike]) -> None:
        """Replace fields of an item."""
        path = self._scene.system(item)
        if path is not None:
            self._set_fields(path, values)
            return
        known = [name for name, (field, _) in self._scene.parts(item).items() if self._scene.fields[field].settable]
        for name in values:
            if not known:
                raise SceneError(f"set.{name}: follows from the state of the fluid")
            if name not in known:
                raise SceneError(f"set.{name}: must be one of {', '.join(known)}")
        changes = Changes(self._world, self._scene)
        with self._scene.units.worded():
            for name, given in values.items():
                changes.put_part(item, name, given, item)
            self._write(changes.fields)

    def _set_fields(self, path: str, values: Mapping[str, object]) -> None:
        """Replace fields of a further system."""
        system = self._scene.systems_by_path[path]
        states = {info.name.removeprefix(f"{path}."): info.state for info in engine.fields(self._world, self._scene)}
        for name in values:
            if name not in system.shapes() or not states[name]:
                known = ", ".join(each for each in system.shapes() if states[each])
                raise SceneError(f"{path}.set.{name}: must be one of {known}")
        with self._scene.units.worded():
            self._write(
                {f"{path}.{name}": system.values(name, given, f"{path}.set.{name}") for name, given in values.items()}
            )

    def _write(self, fields: dict[str, FloatArray]) -> None:
        """Replace fields of the world."""
        engine.write(self._world, self._scene, fields)
        if self._watch is not None:
            self._watch.restart()

    def state_hash(self) -> str:
        """A hash of everything that the bits of the next step depend on."""
        return self._world.state_hash()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a checkpoint, from which `physcore.load` goes on with the same bits. It does not change the run.

        Raises:
            FileError: the file cannot be written, or the scene has a CustomForce.
        """
        archive.write(path, "simulation", self._checkpoint().content())

    @classmethod
    def from_content(cls, content: dict[str, archive.Tree]) -> Simulation:
        """Rebuild a simulation from the content of its checkpoint.

        Raises:
            FileError: an entry is missing or wrong; with its path.
        """
        checkpoint = Checkpoint.from_content(content)
        simulation = cls._resumed(checkpoint)
        checkpoint.verify(simulation._world)
        return simulation

    def __copy__(self) -> Simulation:
        """A simulation of the same scene that goes on from the present state by itself, with the same bits."""
        return self._resumed(self._checkpoint())

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the scene and the present state.

        Raises:
            SceneError: a function in the scene cannot be pickled.
        """
        checkpoint = self._checkpoint()
        checkpoint.require_pickles()
        return type(self)._resumed, (checkpoint,)

    def __deepcopy__(self, memo: dict[int, object]) -> Simulation:
        return self.__copy__()  # A scene never changes, and its bodies stay keys into the copy.

    def _checkpoint(self) -> Checkpoint:
        """The present state."""
        return Checkpoint(self._scene, self._numerics, self._stepper.capture(), self._world.capture())

    @classmethod
    def _resumed(cls, checkpoint: Checkpoint) -> Simulation:
        """A simulation in a state that was captured. Its limits were looked at when the run began."""
        simulation = cls.__new__(cls)
        simulation._build(checkpoint.scene, checkpoint.numerics)
        simulation._stepper.restore(checkpoint.stepper)
        simulation._world.restore(checkpoint.world)
        return simulation

    def _end(self) -> tuple[Plan, Provenance]:
        """The plan and the provenance of a recording."""
        return self.plan, self.provenance


def require_scene(scene: object) -> None:
    """Refuse what is no Scene.

    Raises:
        SceneError: it is none.
    """
    if not isinstance(scene, Scene):
        missing = f"; write Scene({type(scene).__name__}(…), …)" if isinstance(scene, Body) else ""
        raise SceneError(f"scene: must be a Scene, got {shown(scene)}{missing}")

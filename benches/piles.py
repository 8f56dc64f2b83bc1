"""Engines side by side with the same pile: their time, their overlaps, and the energy that they create or lose.

They are compared at one largest penetration: of each engine the fastest version counts that overlaps by no more than
physcore, or where none does so, the one that overlaps least. The energy that a method creates or loses is measured from
positions and velocities: contacts with friction and without restitution only take energy, so that each rise from one
sample to the next was created; in free fall energy is constant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import inf, nan
from statistics import median
from typing import Any

import numpy as np
from measure import Contender, table
from rivals.rigid.pile import FRICTION, GRAVITY, Array, Pile, State

import physcore as pc

STEP = 1.0 / 60.0
SAMPLE = 6
"""Steps between two samples of the energy, which are one turn."""
FALL = 2
"""Samples of free fall at the start of a drop."""
SLACK = 1.1
"""Ratio of penetrations that count as equal."""
NONE = 1e-4
"""Penetration over the size of a body that counts as none."""
LIMIT = 300.0
"""Seconds of CPU time after which an engine is stopped."""

Peers = dict[Any, dict[str, dict[str, Any]]]
"""Engines with the arguments of their versions, by the name of each."""


class Ours:
    """physcore, with its audit and its monitor."""

    def __init__(self, pile: Pile, dt: float = STEP, threads: int = 1, sleep: float | None = None) -> None:
        sizes, of = np.unique(pile.sizes, axis=0, return_inverse=True)
        self.rows = [np.flatnonzero(of.ravel() == k) for k in range(len(sizes))]
        turned = "angles" if pile.dimension == 2 else "orientations"
        self.bodies = [
            pc.RigidBodies(
                shape(size, pile.dimension),
                pile.positions[rows],
                **{turned: pile.turns[rows]},  # type: ignore[arg-type]
                density=pile.density,
                friction=FRICTION,
                sleep=sleep,
            )
            for size, rows in zip(sizes, self.rows, strict=True)
        ]
        down = [0.0] * (pile.dimension - 1) + [-GRAVITY]
        scene = pc.Scene(*self.bodies, *walls(pile), pc.Gravity(tuple(down)))
        self.simulation = pc.Simulation(scene, dt=dt, threads=threads)
        self.balance = self.simulation.energy().balance

    def step(self, steps: int) -> None:
        """Take steps."""
        self.simulation.step(steps)

    def state(self) -> State:
        """Of all bodies, in the order of the pile."""
        parts = [self.simulation[body] for body in self.bodies]
        back = np.argsort(np.concatenate(self.rows))
        turned = "angles" if self.bodies[0].dimension == 2 else "orientations"
        names = ("positions", turned, "velocities", "angular_velocities")
        return State(*(np.concatenate([getattr(part, name) for part in parts])[back] for name in names))

    def drift(self) -> float:
        """Change of the energy balance [J]: what physcore itself says that its method has created or lost."""
        return float(self.simulation.energy().balance - self.balance)


def shape(size: Array, dimension: int) -> Any:
    """Of a body of the pile."""
    if len(size) == 1:
        return pc.Disc(float(size[0]))
    return pc.Rectangle(*(2.0 * size)) if dimension == 2 else pc.Cuboid(*(2.0 * size))


def walls(pile: Pile) -> list[Any]:
    """Ground and walls."""
    rough: dict[str, float] = {"restitution": 0.0, "friction": FRICTION}
    sides = [] if pile.width is None else [(0.0, 1.0), (pile.width, -1.0)]
    return [pc.Floor(0.0, **rough), *(pc.Plane((at, 0.0), (normal, 0.0), **rough) for at, normal in sides)]


@dataclass
class Run:
    """An engine with a pile, its turns, and what became of the pile."""

    name: str
    build: Callable[[], Any]
    pile: Pile
    parts: int = 1
    """Steps of the engine in a sixtieth of a second."""
    contender: Contender = field(init=False)
    heights: list[float] = field(default_factory=list)
    """Energies over the potential energy at the start."""
    deepest: float = 0.0
    """Penetration [m], the largest over the samples."""
    state: State = field(init=False)
    early: Array = field(init=False)
    """Positions after a twelfth of the samples, when a pyramid has settled."""
    stopped: str = ""
    """Why it was stopped before the end."""

    def __post_init__(self) -> None:
        self.engine = self.build()
        self.contender = Contender(self.name, self.engine.step, 1, self.parts, SAMPLE * self.parts)
        self.look()

    def turn(self) -> None:
        """Take a turn, unless it has been stopped."""
        if self.stopped:
            return
        try:
            self.contender.turn()
        except pc.SimulationDiverged as error:
            self.stopped = f"diverged: {error}"
        else:
            self.look()
            if sum(self.contender.cpu) * self.contender.steps > LIMIT:
                self.stopped = f"took more than {LIMIT:g} s"
        if self.stopped:
            print(
                f"{self.name} stops at {len(self.heights) * SAMPLE * STEP - SAMPLE * STEP:.3g} s: {self.stopped}",
                flush=True,
            )

    def look(self) -> None:
        """Take a sample."""
        self.state = self.engine.state()
        self.heights.append(self.pile.energy(self.state) / self.pile.height())
        self.deepest = max(self.deepest, self.penetration)

    @property
    def penetration(self) -> float:
        """The largest overlap now [m]."""
        return self.pile.penetration(self.state)

    @property
    def milliseconds(self) -> float:
        """CPU time of a sixtieth of a second, averaged over all turns."""
        return 1e3 * self.parts * float(np.mean(self.contender.cpu)) if self.contender.cpu else nan

    @property
    def created(self) -> float:
        """The largest rise of the energy from one sample to the next, over the potential energy at the start."""
        return float(np.diff(self.heights).max(initial=-inf))

    @property
    def fallen(self) -> float:
        """Change of the energy in free fall."""
        return self.heights[min(FALL, len(self.heights) - 1)] - self.heights[0]

    @property
    def moved(self) -> float:
        """The largest displacement from the start [m]."""
        return float(np.linalg.norm(self.state.positions - self.pile.positions, axis=1).max())

    @property
    def crept(self) -> float:
        """The largest displacement since it has settled [m]."""
        return float(np.linalg.norm(self.state.positions - self.early, axis=1).max())


def runs(pile: Pile, peers: Peers, versions: Any, parts: Iterable[int]) -> list[Run]:
    """physcore and all engines that are installed; say which are not."""
    made = [Run("physcore", lambda: Ours(pile), pile)]
    for peer, settings in peers.items():
        name = versions(peer)
        if name is None:
            print(f"{peer.module}: not installed")
            continue
        for kind, setting in settings.items():
            for many in parts:
                label = ", ".join([name, *([kind] if kind else []), *([f"{many} steps"] if many > 1 else [])])

                def build(peer: Any = peer, setting: dict[str, Any] = setting, many: int = many) -> Any:
                    return peer(pile, STEP / many, **setting)

                made.append(Run(label, build, pile, many))
    return made


def drop(contestants: list[Run], seconds: float) -> None:
    """Let all engines run side by side, a sample at a time."""
    samples = max(FALL + 1, round(seconds / STEP / SAMPLE))
    for sample in range(samples):
        for run in contestants:
            run.turn()
            if sample == samples // 12:
                run.early = run.state.positions


def equal(contestants: list[Run]) -> list[Run]:
    """physcore, and of each peer the version that counts; others are left out."""
    ours, *others = contestants
    peers: dict[str, list[Run]] = {}
    for run in others:
        peers.setdefault(run.name.partition(",")[0], []).append(run)
    allowed = SLACK * max(ours.penetration, NONE * float(ours.pile.sizes.max()))

    def counts(versions: list[Run]) -> Run:
        versions = [run for run in versions if not run.stopped] or versions
        fair = [run for run in versions if run.penetration <= allowed]
        if fair:
            return min(fair, key=lambda run: run.milliseconds)
        return min(versions, key=lambda run: run.penetration if np.isfinite(run.penetration) else inf)

    return [ours, *map(counts, peers.values())]


def show(title: str, contestants: list[Run]) -> None:
    """Print the whole run of each engine."""
    chosen = equal(contestants)

    def row(run: Run) -> tuple[object, ...]:
        figures = (run.penetration, run.deepest, run.moved, run.crept)
        energies = (run.pile.kinetic(run.state) / run.pile.height(), run.heights[-1], run.created, run.fallen)
        drift = run.engine.drift() / run.pile.height() if isinstance(run.engine, Ours) else nan
        turns = run.contender.cpu or [nan]
        times = (1e3 * run.parts * each for each in (median(turns), min(turns)))
        mark = "stopped" if run.stopped else "counts" if run in chosen else ""
        lengths = (1e3 * each for each in figures)
        return run.name, run.milliseconds, *times, *lengths, *energies, drift, mark

    columns = (
        *("", "mean [ms]", "median", "best"),
        *("overlap [mm]", "largest", "moved [mm]", "crept [mm]"),
        *("kinetic", "energy", "rise", "in free fall", "drift", ""),
    )
    note = "CPU time of a sixtieth of a second; energies over the potential energy at the start"
    table(f"{title} [{note}]", columns, map(row, contestants))


def ratio(times: dict[str, float]) -> float:
    """physcore's time over that of the fastest peer."""
    others = [time for name, time in times.items() if name != "physcore"]
    return times["physcore"] / min(others) if others else nan

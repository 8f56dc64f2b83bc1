"""The work–precision diagram: rows, the Pareto front among them, and the choice that meets a target."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from physcore.checks import number
from physcore.errors import PhyscoreError, SceneError
from physcore.numerics.choices import Options
from physcore.numerics.fluids import FluidMethod
from physcore.numerics.integrators import Integrator
from physcore.scene.scene import Scene

if TYPE_CHECKING:
    from physcore.studies.tradeoff.chaos import Chaos
    from physcore.studies.tradeoff.experiment import Experiment
    from physcore.studies.tradeoff.reference import Reference
    from physcore.studies.tradeoff.restarts import Bias, Windows

Status = Literal["ok", "diverged", "biased"]
Measure = Literal["trajectory", "restart", "until the horizon"]

CERTAIN = 10.0
"""An error is measured well where it is at least this many times the uncertainty of the reference."""
NOISY = 0.05
"""Times whose median is above their minimum by more than this fraction are noisy."""


@dataclass(frozen=True)
class Prediction:
    """What was expected of a row before it was run, from the rows of the same integrator around it."""

    error: float
    """[m]"""
    seconds: float
    """[s]"""


@dataclass(frozen=True)
class Row:
    """One way to compute the scene: what it costs, and how far it is from the truth."""

    integrator: Integrator
    label: str
    """What it is called beside the others: its name, with the parameters in which those of its kind differ."""
    dt: float
    """[s]"""
    precision: Literal["f32", "f64"]
    threads: int | None
    """What was asked for; None: all that the process may use."""
    seconds: float
    """The median time of a whole run [s]."""
    least_seconds: float
    """The shortest [s]."""
    evaluations: int
    """Evaluations of the forces in a whole run."""
    pair_interactions: int
    """Springs and pairs of neighbors that these go through, about."""
    bytes_swept: int
    """The memory of the simulation times the evaluations: what would pass through the caches if none of it stayed."""
    error: float
    """The largest distance from the reference [m]; inf where it diverged."""
    error_uncertainty: float
    """How wrong that may be, because of the reference [m]."""
    energy_drift: float
    """The largest drift of the energy balance, as in `Recording.energy.drift`; inf where it diverged."""
    status: Status
    resolution: float | None = None
    """What the scene was built with, where it is a function."""
    discretization_error: float = 0.0
    """The distance of this resolution's reference from that of the finest, extrapolated; 0 where there is one scene."""
    bias: Bias | None = None
    """Where trajectories are lost: the average that is furthest from the reference's."""
    prediction: Prediction | None = None
    """For a row that was held out: what was expected of it."""
    fluids: FluidMethod | None = None
    """How fluids are computed, where that was a question."""

    @property
    def numerics(self) -> Options:
        """Keyword arguments for `Simulation`."""
        chosen = Options(integrator=self.integrator, dt=self.dt, precision=self.precision, threads=self.threads)
        return chosen if self.fluids is None else {**chosen, "fluids": self.fluids}

    @property
    def total_error(self) -> float:
        """The error of time steps and that of the resolution together [m]."""
        return self.error + self.discretization_error

    @property
    def certain(self) -> bool:
        """Whether the error is at least ten times its uncertainty."""
        return self.error >= CERTAIN * self.error_uncertainty

    @property
    def noise(self) -> float:
        """How much longer the median run took than the shortest, as a fraction of that."""
        return self.seconds / self.least_seconds - 1.0

    @property
    def noisy(self) -> bool:
        """Whether that is more than 5 %."""
        return self.noise > NOISY

    def __str__(self) -> str:
        at = "" if self.resolution is None else f", resolution {self.resolution:g}"
        at = at if self.fluids is None else f"{at}, {self.fluids}"
        error = f"{self.total_error:.2g}" if self.status != "diverged" else "—"
        return (
            f"{self.label}, dt = {self.dt:.4g} s, {self.precision}{at}: error {error} m "
            f"in {self.seconds:.3g} s, {self.status}"
        )


@dataclass(frozen=True, eq=False)
class Measurements:
    """What was measured of one scene."""

    rows: tuple[Row, ...]
    """By resolution, integrator, precision and falling time step."""
    measure: Measure
    """What the errors are: of whole trajectories; where those are lost, over short windows from points of a reference,
    or until they are."""
    references: tuple[Reference | Windows, ...]
    """What each scene was compared with, one for each method for fluids and each resolution."""
    chaos: tuple[Chaos, ...]
    """What a twin run found, likewise."""
    experiments: tuple[Experiment, ...]
    """What was computed, likewise."""
    seed: int
    notes: tuple[str, ...]
    """What was left out, and why."""
    machine: dict[str, Any] = field(default_factory=dict)
    """Where the seconds were measured, and with what."""

    @property
    def scene(self) -> Scene:
        """The scene; of several resolutions, the last."""
        return self.experiments[-1].scene

    @property
    def duration(self) -> float:
        """[s]"""
        return self.experiments[-1].duration

    @property
    def front(self) -> tuple[Row, ...]:
        """The Pareto front: the rows that no other one beats in both error and time, the fastest first."""
        front: list[Row] = []
        for row in sorted(self._good(), key=lambda row: (row.seconds, row.total_error)):
            if not front or row.total_error < front[-1].total_error:
                front.append(row)
        return tuple(front)

    @property
    def held_out(self) -> tuple[Row, ...]:
        """The rows that were predicted before they were run."""
        return tuple(row for row in self.rows if row.prediction is not None)

    def best(self, *, error: float | None = None, seconds: float | None = None) -> Row:
        """The fastest row within an error, or the most accurate one within a time, by the median of its times.

        `Simulation(scene, **row.numerics)` computes it.

        Args:
            error: the largest error to accept [m].
            seconds: the longest time to accept [s].

        Raises:
            SceneError: neither or both are given.
            PhyscoreError: no row is that good; the message says how good they get.
        """
        good = self._good()
        if (error is None) == (seconds is None):
            raise SceneError("best: give either error= or seconds=")
        if not good:
            raise PhyscoreError("best: every row diverged or is biased")
        if error is not None:
            wanted = number(error, "error", least=0.0)
            within = [row for row in good if row.total_error <= wanted]
            if not within:
                closest = min(good, key=lambda row: row.total_error)
                raise PhyscoreError(f"error: no row is within {wanted:g} m; the closest is {closest}")
            return min(within, key=lambda row: (row.seconds, row.evaluations))
        patience = number(seconds, "seconds", above=0.0)
        quick = [row for row in good if row.seconds <= patience]
        if not quick:
            raise PhyscoreError(f"seconds: no row takes {patience:g} s or less; the fastest is {min(good, key=_time)}")
        return min(quick, key=lambda row: (row.total_error, row.seconds))

    def _good(self) -> list[Row]:
        return [row for row in self.rows if row.status == "ok"]


def _time(row: Row) -> float:
    return row.seconds

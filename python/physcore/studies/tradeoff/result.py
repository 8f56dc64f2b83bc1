"""Work–precision diagram: its rows, their Pareto front, and the row that meets a target."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from physcore.checks import number
from physcore.errors import PhyscoreError, SceneError
from physcore.markup import Printed
from physcore.numerics.choices import Options
from physcore.numerics.contacts import ContactSolver
from physcore.numerics.fluids import FluidMethod
from physcore.numerics.integrators import Integrator
from physcore.scene.scene import Scene
from physcore.units.systems import SI, UnitSystem

if TYPE_CHECKING:
    from physcore.studies.tradeoff.chaos import Chaos
    from physcore.studies.tradeoff.experiment import Experiment
    from physcore.studies.tradeoff.reference import Reference
    from physcore.studies.tradeoff.restarts import Bias, Windows

Status = Literal["ok", "lost", "diverged", "biased"]
"""Status of a row. "lost": the error is as large as the motion, so that nothing of it is right."""
Measure = Literal["trajectory", "restart", "until the horizon"]

CERTAIN = 10.0
"""Least ratio of an error to the uncertainty of the reference at which the error counts as well measured."""
NOISY = 0.05
"""Times are noisy if their median is above their minimum by more than this fraction."""


@dataclass(frozen=True)
class Prediction:
    """Error and time of a row predicted from its neighbors of the same integrator, before it was run."""

    error: float
    """Predicted error [m]."""
    seconds: float
    """Predicted time [s]."""


@dataclass(frozen=True, repr=False)
class Row(Printed):
    """Row of the diagram: a choice of numerics, its cost and its error."""

    integrator: Integrator
    label: str
    """Label of the integrator: its name, with the parameters that differ within its class."""
    order: int
    """Order of the integrator in this scene."""
    dt: float
    """Time step [s]."""
    precision: Literal["f32", "f64"]
    threads: int | None
    """Requested number of threads; None: all that the process may use."""
    seconds: float
    """Median time of a whole run [s]."""
    least_seconds: float
    """Shortest time of a whole run [s]."""
    evaluations: int
    """Number of force evaluations of a whole run."""
    pair_interactions: int
    """Approximate number of springs and pairs of neighbors in these evaluations."""
    bytes_swept: int
    """Memory of the simulation times the number of evaluations [bytes]: the memory traffic without any caching."""
    error: float
    """Largest distance from the reference [m]; inf if the run diverged."""
    error_uncertainty: float
    """Uncertainty of the error due to the reference [m]."""
    energy_drift: float
    """Largest drift of the energy balance, as in `Recording.energy.drift`; inf if the run diverged."""
    status: Status
    resolution: float | None = None
    """Resolution of the scene, if `scene` is a function."""
    discretization_error: float = 0.0
    """Distance of this resolution's reference from the extrapolated one; 0 with a single scene."""
    bias: Bias | None = None
    """Most biased average, if trajectories are lost."""
    prediction: Prediction | None = None
    """Prediction of a held-out row."""
    fluids: FluidMethod | None = None
    """Method of fluids, if methods are compared."""
    contacts: ContactSolver | None = None
    """Solver of contacts, if solvers are compared."""
    units: UnitSystem = SI
    """Units of the scene."""

    @property
    def numerics(self) -> Options:
        """Keyword arguments for `Simulation`."""
        chosen = Options(integrator=self.integrator, dt=self.dt, precision=self.precision, threads=self.threads)
        if self.fluids is not None:
            chosen["fluids"] = self.fluids
        if self.contacts is not None:
            chosen["contacts"] = self.contacts
        return chosen

    @property
    def methods(self) -> dict[str, FluidMethod | ContactSolver]:
        """The method of fluids and the solver of contacts, as far as these are compared, by the names of arguments."""
        given = {"fluids": self.fluids, "contacts": self.contacts}
        return {name: method for name, method in given.items() if method is not None}

    @property
    def total_error(self) -> float:
        """Error of the time step plus error of the resolution [m]."""
        return self.error + self.discretization_error

    @property
    def certain(self) -> bool:
        """Whether the error is at least ten times its uncertainty."""
        return self.error >= CERTAIN * self.error_uncertainty

    @property
    def noise(self) -> float:
        """Relative excess of the median time over the shortest time."""
        return self.seconds / self.least_seconds - 1.0

    @property
    def noisy(self) -> bool:
        """Whether the noise exceeds 5 %."""
        return self.noise > NOISY

    def __str__(self) -> str:
        at = "" if self.resolution is None else f", resolution {self.resolution:g}"
        at = ", ".join([at, *map(str, self.methods.values())])
        error = f"{self.total_error:.2g}" if self.status != "diverged" else "—"
        return (
            f"{self.label}, dt = {self.dt:.4g}{self.units.suffix('s')}, {self.precision}{at}: "
            f"error {error}{self.units.suffix('m')} "
            f"in {self.seconds:.3g} s, {self.status}"
        )


@dataclass(frozen=True, eq=False)
class Measurements:
    """Measurements of one scene."""

    rows: tuple[Row, ...]
    """Rows, ordered by resolution, integrator, precision and decreasing time step."""
    measure: Measure
    """Kind of the errors: of whole trajectories; if these are lost, over short windows that start on a reference, or
    until the horizon.
    """
    references: tuple[Reference | Windows, ...]
    """References of each scene, one for each method of fluids and each resolution."""
    chaos: tuple[Chaos, ...]
    """Results of the perturbed runs, likewise."""
    experiments: tuple[Experiment, ...]
    """Experiments, likewise."""
    seed: int
    notes: tuple[str, ...]
    """Notes on omitted choices, with reasons."""
    machine: dict[str, Any] = field(default_factory=dict)
    """Description of the machine and the software of the measurement."""

    @property
    def scene(self) -> Scene:
        """The scene; with several resolutions, the last one."""
        return self.experiments[-1].scene

    @property
    def duration(self) -> float:
        """Simulated duration [s]."""
        return self.experiments[-1].duration

    @property
    def front(self) -> tuple[Row, ...]:
        """The Pareto front: the rows that no other row beats in both error and time, the fastest first."""
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

        `Simulation(scene, **row.numerics)` uses the numerics of the row.

        Args:
            error: the largest acceptable error [m].
            seconds: the longest acceptable time [s].

        Raises:
            SceneError: neither or both are given.
            PhyscoreError: no row meets the bound; the message has the best value.
        """
        good = self._good()
        if (error is None) == (seconds is None):
            raise SceneError("best: give either error= or seconds=")
        if not good:
            raise PhyscoreError("best: every row diverged, is lost or is biased")
        if error is not None:
            wanted = number(error, "error", least=0.0)
            within = [row for row in good if row.total_error <= wanted]
            if not within:
                closest = min(good, key=lambda row: row.total_error)
                bound = f"{wanted:g}{self.scene.units.suffix('m')}"
                raise PhyscoreError(f"error: no row is within {bound}; the closest is {closest}")
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

"""Budgets of energy and other conserved quantities: at one time, and over the frames of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from physcore.checks import FloatArray
from physcore.markup import Printed, html_table
from physcore.simulation.diagrams import canvas
from physcore.units.systems import SI, UnitSystem

if TYPE_CHECKING:
    from matplotlib.axes import Axes

T = TypeVar("T", float, FloatArray)

GOOD_DRIFT, FAIR_DRIFT = 1e-4, 1e-2
"""Largest drifts that are called good and fair.

The amplitude of an oscillation is proportional to the square root of its energy, and is thus off by half the drift. In
a film a fair one is less than 2 of the 320 pixels between the middle and the edge.
"""
WRONG_DRIFT = 0.05
"""Drift above which a run is visibly wrong: the amplitude is off by 8 of 320 pixels."""
BROKEN_DRIFT = 0.25
"""Drift above which a run with a given time step is warned of too."""

IMMATERIAL = 1e-9
"""Change of the balance that no one is warned of, over the energies that it sums."""


def verdict(drift: float) -> str:
    """The assessment of a drift of the energy balance: "good", "fair", or "look at dt"."""
    return "good" if abs(drift) <= GOOD_DRIFT else "fair" if abs(drift) <= FAIR_DRIFT else "look at dt"


@dataclass(frozen=True, eq=False)
class Budget(Generic[T]):
    """Energy budget, in joules or the scene's unit of energy."""

    kinetic: T
    """Kinetic energy of all particles that are not fixed."""
    by_term: Mapping[str, T]
    """Potential energy by force, such as `by_term["springs"]` or `by_term["surface tension"]`."""
    internal: T
    """Internal energy, of the compression of fluids."""
    dissipated: T
    """Energy dissipated by drag, damping, viscosity and contacts since the start: the time integral of their power. In
    a fluid, some of it may be negative.
    """
    dissipated_by: Mapping[str, T]
    """Dissipated energy by cause.

    The causes are `dissipated_by["drag"]`, `["damping"]` (of springs and between grains), `["viscosity"]` (of fluids,
    with the diffusion of their density), `["sleep"]` (of rigid bodies, what they had when they fell asleep) and
    `["contacts"]`. Contacts include restitution, friction, and the limits of
    joints. They also include the energy that the pressure of walls and obstacles takes from a fluid, an error of the
    image particles that vanishes with the spacing.
    """
    work: T
    """Work done since the start by wind, custom forces, motors, moving fixed particles, shifting, `Simulation.set` and
    `Simulation.replace`, each integrated separately; exactly 0 if there is none of them.
    """
    units: UnitSystem = field(default=SI, kw_only=True)
    """Units of the scene."""

    @property
    def potential(self) -> T:
        """Potential energy: the sum over all terms."""
        zero: T = self.kinetic - self.kinetic if not self.by_term else 0.0  # type: ignore[assignment]
        return sum(self.by_term.values(), start=zero)

    @property
    def total(self) -> T:
        """Total energy: kinetic, potential and internal."""
        return self.kinetic + self.potential + self.internal

    @property
    def balance(self) -> T:
        """Energy balance, total + dissipated − work: constant, up to the integrator's error."""
        return self.total + self.dissipated - self.work

    @property
    def _corner(self) -> str:
        """The text in the corner of the table."""
        return self.units.label("energy", "J")

    def _rows(self) -> dict[str, T]:
        """The rows of the table, from top to bottom."""
        spent = {f"    by {name}": value for name, value in self.dissipated_by.items() if np.any(value)}
        return {
            "kinetic": self.kinetic,
            **{f"potential: {term}": value for term, value in self.by_term.items()},
            **({"internal": self.internal} if np.any(self.internal) else {}),
            "total": self.total,
            "+ dissipated": self.dissipated,
            **spent,
            "− work": self.work,
            "= balance": self.balance,
        }


@dataclass(frozen=True, eq=False, repr=False)
class Energy(Printed, Budget[float]):
    """Energy budget at one time, in joules or the scene's unit of energy.

        energy = pc.Simulation(scene).energy()  # an Energy
        print(energy)  # a table
        energy.kinetic, energy.by_term["springs"]

    `Simulation.energy` returns it; `print` shows it as a table.
    """

    time: float
    """Time of the budget [s]."""

    def __str__(self) -> str:
        return _table([_when(self)], {name: [value] for name, value in self._rows().items()}, self._corner)

    def _repr_html_(self) -> str:
        """The table as HTML, for notebooks."""
        rows = {name: [f"{value:.6g}"] for name, value in self._rows().items()}
        return html_table([self._corner, _when(self)], rows)


@dataclass(frozen=True, eq=False, repr=False)
class EnergySeries(Printed, Budget[FloatArray]):
    """Energy budget over time, in joules or the scene's unit of energy; every array has the shape (F,).

        energy = recording.energy  # an EnergySeries
        print(energy)  # a table of its start and its end
        energy.by_term["springs"], energy.drift  # each of shape (F,)

    `Recording.energy` is of this class. `print` shows the start and the end as a table, and `plot` draws the budget.
    """

    times: FloatArray
    """Times of the budgets [s]: the last step at or before each frame."""

    @property
    def drift(self) -> FloatArray:
        """Relative drift (balance − balance[0]) / (largest kinetic energy + ranges of potential and internal energy).

        The drift is 0 if nothing moves.
        """
        change = self.balance - self.balance[0]
        scale = self.kinetic.max() + np.ptp(self.potential) + np.ptp(self.internal)
        drift: FloatArray = change / scale if scale > 0 else change
        return drift

    @property
    def material_drift(self) -> float:
        """Largest |drift|; 0 where the balance changes by less than 1e-9 of the energies that it sums.

        Where nearly nothing moves, as in a stack at rest, the energy in motion is no scale for the errors of a
        contact.
        """
        parts = (self.kinetic, *self.by_term.values(), self.internal, self.dissipated, self.work)
        summed = sum(float(np.abs(part).max()) for part in parts)
        change = float(np.abs(self.balance - self.balance[0]).max())
        return 0.0 if change <= IMMATERIAL * summed else float(np.abs(self.drift).max())

    def __str__(self) -> str:
        ends = {name: [values[0], values[-1]] for name, values in self._rows().items()}
        largest = self.material_drift
        drift = f"  drift: at most {largest:.1e} of the energy in motion: {verdict(largest)}"
        return f"{_table(['start', 'end'], ends, self._corner)}\n{drift}"

    def _repr_html_(self) -> str:
        """The table as HTML, for notebooks."""
        rows = {name: [f"{value:.6g}" for value in (values[0], values[-1])] for name, values in self._rows().items()}
        largest = self.material_drift
        rows["drift"] = ["", f"at most {largest:.1e}: {verdict(largest)}"]
        return html_table([self._corner, "start", "end"], rows)

    def at(self, index: int) -> Energy:
        """The budget of one frame."""
        values: dict[str, Any] = {
            name: {term: float(each[index]) for term, each in series.items()}
            if isinstance(series, Mapping)
            else float(series[index])
            for name, series in self.series.items()
        }
        return Energy(time=values.pop("times"), units=self.units, **values)

    @property
    def series(self) -> dict[str, FloatArray | Mapping[str, FloatArray]]:
        """All series by name."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.name != "units"}

    def plot(self, axes: Axes | None = None) -> Axes:
        """Plot the budget over time with Matplotlib (`pip install "physcore[plot]"`).

        Args:
            axes: the axes to draw into; a new figure by default.

        Raises:
            PhyscoreError: Matplotlib is not installed.
        """
        axes = canvas(axes)
        curves = {"kinetic": self.kinetic, **{f"potential: {name}": values for name, values in self.by_term.items()}}
        for label, values in curves.items():
            axes.plot(self.times, values, label=label)
        for label, values in {"internal": self.internal, "dissipated": self.dissipated, "work": self.work}.items():
            if np.any(values):
                axes.plot(self.times, values, "-" if label == "internal" else "--", label=label)
        axes.plot(self.times, self.balance, color="black", label="balance = total + dissipated − work")
        axes.set(xlabel=self.units.label("time", "s"), ylabel=self._corner)
        axes.legend(frameon=False)
        return axes


@dataclass(frozen=True, eq=False)
class Stock(Generic[T]):
    """Budget of a conserved quantity other than energy, such as the amount of a species or a probability."""

    unit: str
    """Unit of all values; empty without units."""
    total: T
    """Present amount."""
    removed_by: Mapping[str, T]
    """Amount removed since the start, by cause: `removed_by["edges"]`."""
    supplied_by: Mapping[str, T]
    """Amount supplied since the start, by cause."""
    units: UnitSystem = field(default=SI, kw_only=True)
    """Units of the scene."""

    @property
    def removed(self) -> T:
        """Total amount removed since the start."""
        return sum(self.removed_by.values(), start=self.total - self.total)

    @property
    def supplied(self) -> T:
        """Total amount supplied since the start."""
        return sum(self.supplied_by.values(), start=self.total - self.total)

    @property
    def balance(self) -> T:
        """Balance, total + removed − supplied: constant, up to the method's error."""
        return self.total + self.removed - self.supplied

    @property
    def _corner(self) -> str:
        """The text in the corner of the table."""
        return f"amount [{self.unit}]" if self.unit else "amount"

    def _rows(self) -> dict[str, T]:
        """The rows of the table, from top to bottom."""
        removed = {f"+ removed by {name}": value for name, value in self.removed_by.items() if np.any(value)}
        supplied = {f"− supplied by {name}": value for name, value in self.supplied_by.items() if np.any(value)}
        return {"total": self.total, **removed, **supplied, "= balance": self.balance}


@dataclass(frozen=True, eq=False, repr=False)
class Amount(Printed, Stock[float]):
    """Budget of a conserved quantity at one time.

        grid = pc.Grid((64, 64), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, {"u": 1.0, "v": 0.0})
        pc.Simulation(pc.Scene(dish)).budgets()["u"].total  # of an Amount

    `Simulation.budgets` returns one for each quantity, by name.
    """

    time: float
    """Time of the budget [s]."""

    def __str__(self) -> str:
        rows = {name: [value] for name, value in self._rows().items()}
        return _table([_when(self)], rows, self._corner)


@dataclass(frozen=True, eq=False, repr=False)
class AmountSeries(Printed, Stock[FloatArray]):
    """Budget of a conserved quantity over time; every array has the shape (F,).

        grid = pc.Grid((64, 64), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, {"u": 1.0, "v": 0.0})
        pc.simulate(pc.Scene(dish), duration=10.0).budgets["u"].drift  # of an AmountSeries, shape (F,)

    `Recording.budgets` has one for each quantity, by name.
    """

    times: FloatArray
    """Times of the budgets [s]: the last step at or before each frame."""

    def __str__(self) -> str:
        rows = {name: [values[0], values[-1]] for name, values in self._rows().items()}
        drift = f"  drift: at most {np.abs(self.drift).max():.1e} of the largest total"
        return f"{_table(['start', 'end'], rows, self._corner)}\n{drift}"

    @property
    def drift(self) -> FloatArray:
        """Relative drift (balance − balance[0]) / largest |total|; the absolute change if the total is always zero."""
        change: FloatArray = self.balance - self.balance[0]
        scale = float(np.abs(self.total).max())
        return change / scale if scale > 0.0 else change

    @classmethod
    def of(cls, moments: Sequence[Amount]) -> AmountSeries:
        """The series of budgets at several times."""
        first = moments[0]

        def by(name: str) -> dict[str, FloatArray]:
            return {part: np.array([getattr(each, name)[part] for each in moments]) for part in getattr(first, name)}

        return cls(
            unit=first.unit,
            total=np.array([each.total for each in moments]),
            removed_by=by("removed_by"),
            supplied_by=by("supplied_by"),
            times=np.array([each.time for each in moments]),
            units=first.units,
        )


class Drift:
    """Drift of an energy balance, as in `EnergySeries.drift`, updated by one budget at a time."""

    def __init__(self) -> None:
        self._seen: list[FloatArray] = []
        """First, smallest and largest values of balance, kinetic, potential and internal energy [J]."""

    def add(self, energy: Energy) -> float:
        """Add a budget, and return the drift relative to all budgets so far."""
        values = np.array([energy.balance, energy.kinetic, energy.potential, energy.internal])
        first, lower, upper = self._seen or [values] * 3
        self._seen = [first, np.minimum(lower, values), np.maximum(upper, values)]
        return self._relative(abs(energy.balance - first[0]))

    @property
    def largest(self) -> float:
        """The largest drift so far."""
        first, lower, upper = self._seen
        return self._relative(max(upper[0] - first[0], first[0] - lower[0]))

    def _relative(self, change: float) -> float:
        """A change relative to the scale of the energy in motion."""
        _, lower, upper = self._seen
        _, _, potential, internal = upper - lower
        scale = upper[1] + potential + internal
        return float(change / scale if scale > 0 else change)


def _when(moment: Energy | Amount) -> str:
    """The head of a column of values at one time."""
    return f"at {moment.time:.4g}{moment.units.suffix('s')}"


def _table(heads: Sequence[str], rows: Mapping[str, Sequence[float]], corner: str) -> str:
    """Numbers in columns, as text."""
    width = max(map(len, [*rows, corner]))
    lines = [f"  {corner:<{width}}" + "".join(f"  {head:>12}" for head in heads)]
    lines += [f"  {name:<{width}}" + "".join(f"  {value:>12.6g}" for value in row) for name, row in rows.items()]
    return "\n".join(lines)

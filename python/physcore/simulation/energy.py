"""The budgets of energy and of what else is conserved: at one moment, and over the frames of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from physcore.checks import FloatArray
from physcore.markup import html_table
from physcore.simulation.diagrams import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes

T = TypeVar("T", float, FloatArray)

GOOD_DRIFT = 1e-2
"""The largest drift that is called good: the amplitude of an oscillation goes with the root of its energy, and is off
by half of this, less than 2 pixels of the 320 between the middle and the edge of a film."""
WRONG_DRIFT = 0.05
"""The drift above which a run is wrong to the eye: 8 pixels, likewise."""


def verdict(drift: float) -> str:
    """What a drift of the energy balance means: "good", or "look at dt"."""
    return "good" if abs(drift) <= GOOD_DRIFT else "look at dt"


@dataclass(frozen=True, eq=False)
class Budget(Generic[T]):
    """An energy budget; everything in joules."""

    kinetic: T
    """Kinetic energy of all particles that are not fixed."""
    by_term: Mapping[str, T]
    """Potential energy by the force that it belongs to, such as `by_term["springs"]` or
    `by_term["surface tension"]`."""
    internal: T
    """Internal energy: of the compression of fluids."""
    dissipated: T
    """Energy dissipated by drag, damping, viscosity and contacts since the start: the time integral of their power. In
    a fluid some of it may be given back."""
    dissipated_by: Mapping[str, T]
    """The same by what took it: `dissipated_by["drag"]`, `["damping"]` (of springs and between grains), `["viscosity"]`
    (of fluids, and the diffusion of their density) and `["contacts"]`: restitution and friction, and what the pressure
    of walls and obstacles takes from a fluid beside them, an error of the images that vanishes with its spacing."""
    work: T
    """Work done by wind, custom forces, fixed particles that move, shifting and `Simulation.set` since the start,
    each metered by itself; exactly 0 where there is none of them."""

    @property
    def potential(self) -> T:
        """The sum over all terms."""
        zero: T = self.kinetic - self.kinetic if not self.by_term else 0.0  # type: ignore[assignment]
        return sum(self.by_term.values(), start=zero)

    @property
    def total(self) -> T:
        """Kinetic, potential and internal energy."""
        return self.kinetic + self.potential + self.internal

    @property
    def balance(self) -> T:
        """total + dissipated − work: constant, up to the integrator's error."""
        return self.total + self.dissipated - self.work

    def _rows(self) -> dict[str, T]:
        """The lines of the table, from top to bottom."""
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


@dataclass(frozen=True, eq=False)
class Energy(Budget[float]):
    """The energy budget at one moment, in joules.

        energy = pc.Simulation(scene).energy()  # an Energy
        print(energy)  # a table
        energy.kinetic, energy.by_term["springs"]

    `Simulation.energy` gives it; `print` shows it as a table.
    """

    time: float
    """When it was taken [s]."""

    def __str__(self) -> str:
        return _table([f"at {self.time:.4g} s"], {name: [value] for name, value in self._rows().items()})

    def _repr_html_(self) -> str:
        """For notebooks: the same table."""
        rows = {name: [f"{value:.6g}"] for name, value in self._rows().items()}
        return html_table(["energy [J]", f"at {self.time:.4g} s"], rows)


@dataclass(frozen=True, eq=False)
class EnergySeries(Budget[FloatArray]):
    """The energy budget over time, in joules; every array has the shape (F,).

        energy = recording.energy  # an EnergySeries
        print(energy)  # a table of its start and its end
        energy.by_term["springs"], energy.drift  # each of shape (F,)

    `Recording.energy` is one; `print` shows its start and its end as a table, and `plot` draws it.
    """

    times: FloatArray
    """When each was taken [s]: at the last step at or before each frame."""

    @property
    def drift(self) -> FloatArray:
        """(balance − balance[0]) / (largest kinetic energy + ranges of the potential and the internal energy).

        0 where nothing moves.
        """
        change = self.balance - self.balance[0]
        scale = self.kinetic.max() + np.ptp(self.potential) + np.ptp(self.internal)
        drift: FloatArray = change / scale if scale > 0 else change
        return drift

    def __str__(self) -> str:
        ends = {name: [values[0], values[-1]] for name, values in self._rows().items()}
        largest = float(np.abs(self.drift).max())
        drift = f"  drift: at most {largest:.1e} of the energy in motion: {verdict(largest)}"
        return f"{_table(['start', 'end'], ends)}\n{drift}"

    def _repr_html_(self) -> str:
        """For notebooks: the same table."""
        rows = {name: [f"{value:.6g}" for value in (values[0], values[-1])] for name, values in self._rows().items()}
        largest = float(np.abs(self.drift).max())
        rows["drift"] = ["", f"at most {largest:.1e}: {verdict(largest)}"]
        return html_table(["energy [J]", "start", "end"], rows)

    def at(self, index: int) -> Energy:
        """The budget of one frame."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        parts = {
            name: {term: float(series[index]) for term, series in value.items()}
            for name, value in values.items()
            if isinstance(value, Mapping)
        }
        whole = {name: float(value[index]) for name, value in values.items() if name not in parts and name != "times"}
        return Energy(**whole, **parts, time=float(self.times[index]))  # type: ignore[arg-type]

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the budget over time with Matplotlib (`pip install "physcore[plot]"`).

        Args:
            axes: where to draw; a new figure by default.

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
        axes.set(xlabel="time [s]", ylabel="energy [J]")
        axes.legend(frameon=False)
        return axes


@dataclass(frozen=True, eq=False)
class Stock(Generic[T]):
    """The budget of a conserved quantity beside energy, such as the amount of a species or a probability."""

    unit: str
    """The unit of all numbers."""
    total: T
    """What there is."""
    removed_by: Mapping[str, T]
    """What was removed since the start, by what removed it: `removed_by["edges"]`."""
    supplied_by: Mapping[str, T]
    """What was supplied since the start, by what supplied it."""

    @property
    def removed(self) -> T:
        """What was removed since the start."""
        return sum(self.removed_by.values(), start=self.total - self.total)

    @property
    def supplied(self) -> T:
        """What was supplied since the start."""
        return sum(self.supplied_by.values(), start=self.total - self.total)

    @property
    def balance(self) -> T:
        """total + removed − supplied: constant, up to the method's error."""
        return self.total + self.removed - self.supplied


@dataclass(frozen=True, eq=False)
class Amount(Stock[float]):
    """The budget of a conserved quantity at one moment.

        grid = pc.Grid((64, 64), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, {"u": 1.0, "v": 0.0})
        pc.Simulation(pc.Scene(dish)).budgets()["u"].total  # of an Amount

    `Simulation.budgets` gives one by the name of each quantity.
    """

    time: float
    """When it was taken [s]."""


@dataclass(frozen=True, eq=False)
class AmountSeries(Stock[FloatArray]):
    """The budget of a conserved quantity over time; every array has the shape (F,).

        grid = pc.Grid((64, 64), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, {"u": 1.0, "v": 0.0})
        pc.simulate(pc.Scene(dish), duration=10.0).budgets["u"].drift  # of an AmountSeries, shape (F,)

    `Recording.budgets` has one by the name of each quantity.
    """

    times: FloatArray
    """When each was taken [s]: at the last step at or before each frame."""

    @property
    def drift(self) -> FloatArray:
        """(balance − balance[0]) / largest |total|; the change itself where there never was anything."""
        change: FloatArray = self.balance - self.balance[0]
        scale = float(np.abs(self.total).max())
        return change / scale if scale > 0.0 else change

    @classmethod
    def of(cls, moments: Sequence[Amount]) -> AmountSeries:
        """Budgets at several times as one over time."""
        first = moments[0]

        def by(name: str) -> dict[str, FloatArray]:
            return {part: np.array([getattr(each, name)[part] for each in moments]) for part in getattr(first, name)}

        return cls(
            unit=first.unit,
            total=np.array([each.total for each in moments]),
            removed_by=by("removed_by"),
            supplied_by=by("supplied_by"),
            times=np.array([each.time for each in moments]),
        )


class Drift:
    """The drift of an energy balance, as `EnergySeries.drift` counts it, from one budget at a time."""

    def __init__(self) -> None:
        self._seen: list[FloatArray] = []
        """Of balance, kinetic, potential and internal energy [J]: the first, the smallest and the largest values."""

    def add(self, energy: Energy) -> float:
        """Look at one budget, and give its drift by all that was seen so far."""
        values = np.array([energy.balance, energy.kinetic, energy.potential, energy.internal])
        first, lower, upper = self._seen or [values] * 3
        self._seen = [first, np.minimum(lower, values), np.maximum(upper, values)]
        return self._relative(abs(energy.balance - first[0]))

    @property
    def largest(self) -> float:
        """The largest one of all."""
        first, lower, upper = self._seen
        return self._relative(max(upper[0] - first[0], first[0] - lower[0]))

    def _relative(self, change: float) -> float:
        """A change in units of the energy that has been in motion."""
        _, lower, upper = self._seen
        _, _, potential, internal = upper - lower
        scale = upper[1] + potential + internal
        return float(change / scale if scale > 0 else change)


def _table(heads: Sequence[str], rows: Mapping[str, Sequence[float]]) -> str:
    """Energies [J] in columns."""
    width = max(map(len, rows))
    lines = [f"  {'energy [J]':<{width}}" + "".join(f"  {head:>12}" for head in heads)]
    lines += [f"  {name:<{width}}" + "".join(f"  {value:>12.6g}" for value in row) for name, row in rows.items()]
    return "\n".join(lines)

"""Budgets of a run whose scene was replaced: what they have from the scenes before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Self

from physcore.simulation.energy import Amount, Energy
from physcore.storage.archive import Tree
from physcore.storage.schema import Rule, of, real, several, table
from physcore.units.systems import UnitSystem

SOURCE = "replacement"
"""Cause of what a replacement supplies to a budget other than energy."""


@dataclass(frozen=True)
class Earlier:
    """Parts of a run's budgets from the scenes before the present one."""

    times: tuple[float, ...] = ()
    """Times of the replacements [s]."""
    work: float = 0.0
    """Work [J], with the changes of energy at the replacements."""
    dissipated_by: Mapping[str, float] = field(default_factory=dict)
    """Dissipated energy by cause [J]."""
    removed_by: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Removed amounts by budget and cause."""
    supplied_by: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Supplied amounts by budget and cause, with the changes at the replacements."""

    def on(self, energy: Energy, amounts: Mapping[str, Amount]) -> tuple[Energy, dict[str, Amount]]:
        """The budgets since the start, from those since the last replacement."""
        if not self.times:
            return energy, dict(amounts)
        spent = _sum(energy.dissipated_by, self.dissipated_by)
        dissipated = sum(spent.values(), start=0.0)
        whole = {
            name: replace(
                amount,
                removed_by=_sum(amount.removed_by, self.removed_by.get(name, {})),
                supplied_by=_sum(amount.supplied_by, self.supplied_by.get(name, {})),
            )
            for name, amount in amounts.items()
        }
        work = energy.work + self.work
        return replace(energy, dissipated=dissipated, dissipated_by=spent, work=work), whole

    def then(
        self, before: tuple[Energy, Mapping[str, Amount]], after: tuple[Energy, Mapping[str, Amount]], time: float
    ) -> Earlier:
        """The parts after a replacement at a time [s].

        Args:
            before: the budgets since the start, in the scene before.
            after: the budgets of the new scene alone.
            time: the time.
        """
        (old, amounts), (new, others) = before, after
        common = {name: (amounts[name], other) for name, other in others.items() if name in amounts}
        supplied = {name: {SOURCE: other.total - one.total} for name, (one, other) in common.items()}
        return Earlier(
            times=(*self.times, time),
            work=old.work + (new.total - old.total) - new.work,
            dissipated_by=_difference(old.dissipated_by, new.dissipated_by),
            removed_by={name: _difference(one.removed_by, other.removed_by) for name, (one, other) in common.items()},
            supplied_by={
                name: _sum(_difference(one.supplied_by, other.supplied_by), supplied[name])
                for name, (one, other) in common.items()
            },
        )

    def notes(self, units: UnitSystem) -> list[str]:
        """The note of the plan on the replacements."""
        if not self.times:
            return []
        last, more = f"{self.times[-1]:.6g}{units.suffix('s')}", len(self.times) - 1
        often = f", and {more} times before" if more else ""
        return [
            f"the scene was replaced at {last}{often}: the changes of energy are work, and the limit is of this scene"
        ]

    def content(self) -> Tree:
        """The amounts as plain values, for a file."""
        return asdict(self)

    @classmethod
    def from_content(cls, content: Mapping[str, Tree]) -> Self:
        """The amounts from the result of `content`, checked by EARLIER."""
        return cls(**{**content, "times": tuple(content["times"])})


_AMOUNTS = table(real(finite=False))
EARLIER: Rule = of(
    Earlier, times=several(real()), dissipated_by=_AMOUNTS, removed_by=table(_AMOUNTS), supplied_by=table(_AMOUNTS)
)
"""Rule for what the budgets have from earlier scenes, in a file."""


def _sum(one: Mapping[str, float], other: Mapping[str, float]) -> dict[str, float]:
    """The sums of amounts by cause."""
    return {name: one.get(name, 0.0) + other.get(name, 0.0) for name in {**one, **other}}


def _difference(one: Mapping[str, float], other: Mapping[str, float]) -> dict[str, float]:
    """The differences of amounts by cause."""
    return _sum(one, {name: -amount for name, amount in other.items()})

"""Reaction–diffusion systems on a grid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias

import numpy as np

from physcore.checks import FloatArray, number, shown, text
from physcore.errors import SceneError
from physcore.scene.edges import Condition, Dirichlet, Neumann, Sides
from physcore.scene.grid import Field, Grid, GridSystem
from physcore.systems.kinetics import KINETICS, Kinetics, Reaction
from physcore.systems.resolution import SLOW, front_speed, spikes

Edge = Literal["free", "fixed"]
Side: TypeAlias = Edge | Dirichlet | Neumann
Edges: TypeAlias = Side | Mapping[str, Side] | Sequence[Condition]
"""Edge conditions: one for all edges, or a mapping from axes ("x") and sides ("x-", "x+") to conditions."""
EDGES: tuple[Edge, ...] = ("free", "fixed")


SMALL = 1e-6
"""Amount at which the growth ahead of a front is measured."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class ReactionDiffusion(GridSystem):
    """Reaction–diffusion system: u_t = D_u ∇²u + R_u(u, v, …), and likewise for each species.

        grid = pc.Grid((128, 128), spacing=0.01)
        dish = pc.ReactionDiffusion(grid, pc.GrayScott(0.035, 0.0625), diffusion={"u": 2e-5, "v": 1e-5},
                                    initial={"u": 1.0, "v": lambda x, y: 0.3 * (np.hypot(x - 0.64, y - 0.64) < 0.1)})
        recording = pc.simulate(pc.Scene(dish), duration=500.0, fps=0.1)
        recording[dish]["v"]  # (F, 128, 128)
        recording.budgets["v"].supplied  # (F,)

    The Laplacian uses two neighbors along each axis. The amount of each species, Σ u hᴰ, has a budget. Its `supplied`
    and `removed` are the time integrals of the gains and losses by reactions, cell by cell, and of the flux through
    edges. They account for the amount up to rounding.

        rod = pc.ReactionDiffusion(pc.Grid(50, 0.02), pc.Reaction(("T",), lambda T: (0 * T,)), {"T": 1e-2}, {"T": 20.0},
                                   edges={"x-": pc.Dirichlet(100.0), "x+": pc.Neumann(lambda t: -5.0 * t)})

    Args:
        grid: a grid in 1D, 2D or 3D.
        reaction: the kinetics: `GrayScott`, `FitzHughNagumo`, `Brusselator`, `Schnakenberg`, or a `Reaction`.
        diffusion: diffusivity D ≥ 0 of each species [m²/s], by name.
        initial: initial value of each species, a field: a number, an array of shape `grid.cells` or a function of the
            coordinates of the cell centers.
        edges: "free": no flux through the outer faces; "fixed": values are zero on them; `Dirichlet(value)` and
            `Neumann(gradient)`: others than zero, also as functions of the time. One condition for all edges, or a
            mapping of axes or sides, `{"x": "fixed", "y-": "free"}`; other sides are free. Or a mapping of species to
            these, `{"u": pc.Dirichlet(1.0), "v": {"x": "fixed"}}`; other species have free edges. Periodic axes of the
            grid have no edges.
        name: name of the system, also a key into results.

    Raises:
        SceneError: a species is missing or unknown; a diffusivity is below zero; a field has the wrong shape; or an
            edge is not valid.

    Source: A. M. Turing, Phil. Trans. R. Soc. B 237, 37 (1952); W. Hundsdorfer, J. G. Verwer, "Numerical Solution of
    Time-Dependent Advection-Diffusion-Reaction Equations", 2003.
    """

    has_varying_limit: ClassVar[bool] = True
    default_integrator: ClassVar[str] = "RungeKutta4"
    parts: ClassVar[tuple[type, ...]] = (Grid, Dirichlet, Neumann, *KINETICS)

    reaction: Kinetics
    """Kinetics of the reaction."""
    diffusion: Mapping[str, float]
    """Diffusivity D of each species [m²/s]."""
    initial: Mapping[str, float | FloatArray]
    """Initial value of each species, a number or of shape `grid.cells`."""
    edges: tuple[Condition, ...] | Mapping[str, tuple[Condition, ...]]  # type: ignore[assignment]
    """Edge condition of each side, in the order x−, x+, y−, y+, z−, z+; by species, if these differ."""

    def __init__(
        self,
        grid: Grid,
        reaction: Kinetics,
        diffusion: Mapping[str, float],
        initial: Mapping[str, Field],
        edges: Edges | Mapping[str, Edges] = "free",
        name: str | None = None,
    ) -> None:
        if not isinstance(grid, Grid):
            raise SceneError(f"ReactionDiffusion.grid: must be a Grid, got {shown(grid)}")
        if not isinstance(reaction, KINETICS):
            known = ", ".join(f"{kind.__name__}(…)" for kind in KINETICS)
            raise SceneError(f"ReactionDiffusion.reaction: must be one of {known}, got {shown(reaction)}")
        rates = _by_species(diffusion, reaction, "ReactionDiffusion.diffusion")
        fields = _by_species(initial, reaction, "ReactionDiffusion.initial")
        self._set(
            grid=grid,
            reaction=reaction.on(grid, "ReactionDiffusion.reaction"),
            diffusion={
                species: number(value, f"ReactionDiffusion.diffusion[{species!r}]", least=0.0)
                for species, value in rates.items()
            },
            initial={
                species: grid.uniform_or_field(value, f"ReactionDiffusion.initial[{species!r}]")  # type: ignore[arg-type]
                for species, value in fields.items()
            },
            edges=_edges(grid, edges, reaction.names),
            name=None if name is None else text(name, "ReactionDiffusion.name"),
        )

    def conditions(self, field: str) -> tuple[Condition, ...]:
        """The edge conditions of a species, in the order x−, x+, y−, y+, z−, z+."""
        return self.edges[field] if isinstance(self.edges, Mapping) else self.edges

    @property
    def units(self) -> Mapping[str, str]:
        """The species with their unit, 1; the default species of films is first."""
        names = self.reaction.names
        first = self.reaction.shown if self.reaction.shown in names else names[0]
        return dict.fromkeys((first, *names), "1")

    @property
    def signed(self) -> bool:
        """Whether values have both signs."""
        return self.reaction.signed

    @property
    def ranged(self) -> bool:
        """Whether nothing is known of the values."""
        return self.reaction.ranged

    def unresolved(self, integrator: str) -> list[str]:
        """Notes on spikes of the initial fields that diffuse too slowly, and on fronts that the grid makes too fast."""
        del integrator
        return [*self._spikes(), *self._fronts()]

    def _spikes(self) -> Iterator[str]:
        """Notes on spikes of the initial fields of species that diffuse."""
        for species, values in self.initial.items():
            if self.diffusion[species] > 0.0 and np.ndim(values) > 0:
                yield from spikes(f"initial[{species!r}]", np.asarray(values), self.grid.spacing)

    def _fronts(self) -> list[str]:
        """A note on fronts of a single species into the empty state that the grid makes too fast.

        Such a front is pulled by the growth ahead of it, r = R'(0) > 0.
        """
        diffusion = next(iter(self.diffusion.values()))
        if len(self.diffusion) != 1 or not diffusion > 0.0 or not isinstance(self.reaction, Reaction):
            return []
        few, none = np.full(self.grid.cells, SMALL), np.zeros(self.grid.cells)
        grown, left = (float(np.ravel(self.reaction.function(values)[0])[0]) for values in (few, none))
        rate = (grown - left) / SMALL
        if left != 0.0 or not 0.0 < rate < math.inf:
            return []
        cells = math.sqrt(diffusion / rate) / self.grid.spacing
        speed = front_speed(cells)
        if speed <= 1.0 + SLOW:
            return []
        return [
            f"fronts have {cells:.2g} cells in their width √(D/r), with r = {rate:.2g}/s, and run {speed:.2f} times "
            f"too fast on this grid; a spacing of {1.1 * cells * self.grid.spacing:.2g} m keeps {SLOW:.0%}"
        ]

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        kinetics, cells = type(self.reaction).__name__, " × ".join(map(str, self.grid.cells))
        return f"ReactionDiffusion({label}{kinetics}, {cells} cells)"


def _edges(grid: Grid, given: object, names: Sequence[str]) -> Sides | dict[str, Sides]:
    """The validated edge conditions: of all species, or by species if these differ.

    A mapping whose keys name both sides and species is one of sides, unless its values are mappings.
    """
    path, keys = "ReactionDiffusion.edges", {*grid.sides, *(side[0] for side in grid.sides)}
    if (
        not isinstance(given, Mapping)
        or not set(given) <= set(names)
        or not (set(given) - keys or any(isinstance(each, Mapping) for each in given.values()))
    ):
        return grid.edges(given, path, EDGES, "free", valued=True)[0]
    each = {
        name: grid.edges(given.get(name, "free"), f"{path}[{name!r}]", EDGES, "free", valued=True)[0] for name in names
    }
    return each if len(set(each.values())) > 1 else each[names[0]]


def _by_species(value: object, reaction: Kinetics, path: str) -> dict[str, object]:
    """The value for each species, in their order."""
    names = reaction.names
    if not isinstance(value, Mapping):
        raise SceneError(f"{path}: must be a mapping of the species {', '.join(map(repr, names))}, got {shown(value)}")
    for key in value:
        if key not in names:
            raise SceneError(f"{path}[{shown(key)}]: is none of the species, which are {', '.join(map(repr, names))}")
    missing = [name for name in names if name not in value]
    if missing:
        raise SceneError(f"{path}: must have a value for each species, {', '.join(map(repr, missing))} has none")
    return {name: value[name] for name in names}

"""Kinetics: the reaction rates of a `ReactionDiffusion` system."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np

from physcore.checks import array, frozen, items, number, regular, require, shown, text, word
from physcore.errors import SceneError
from physcore.scene.by_value import ByValue
from physcore.scene.grid import Field, Grid

Pearson = Literal["alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu"]

PEARSON: Mapping[Pearson, tuple[float, float]] = {
    "alpha": (0.010, 0.047),  # wavelets that meet and vanish, chaotic
    "beta": (0.026, 0.051),  # chaos of waves and spots
    "gamma": (0.022, 0.051),  # worms that break up and grow again
    "delta": (0.030, 0.055),  # fronts that leave spots and worms behind
    "epsilon": (0.018, 0.055),  # rings and spots that divide and die
    "zeta": (0.022, 0.061),  # spots that divide and crowd each other out
    "eta": (0.034, 0.063),  # worms and spots
    "theta": (0.030, 0.057),  # a labyrinth of stripes that grows from its ends
    "iota": (0.046, 0.0594),  # a lattice of holes
    "kappa": (0.050, 0.063),  # a labyrinth that fills the plane
    "lambda": (0.026, 0.061),  # spots that divide until they fill the plane: mitosis
    "mu": (0.046, 0.065),  # worms that grow at both ends and do not branch
}
"""Feed and kill rates of each class of patterns, for D_u = 2e-5 and D_v = 1e-5 m²/s."""


# To add kinetics: a class here, a line in `KINETICS`, and its counterpart in Rust.
@dataclass(frozen=True, eq=False, repr=False)
class Kinetics(ByValue):
    """Base class of reaction kinetics; the built-in ones have the species "u" and "v".

    Each parameter of built-in kinetics is a field: a number, an array of the grid's shape or a function of the
    coordinates of the cell centers. Functions are evaluated by the `ReactionDiffusion` that has the grid.
    """

    signed: ClassVar[bool] = False
    """Whether values have both signs."""
    ranged: ClassVar[bool] = False
    """Whether nothing is known of the values: films show them from the smallest to the largest."""
    shown: ClassVar[str] = "u"
    """Default species of films, which is also compared between runs."""
    least: ClassVar[float] = -math.inf
    """Smallest value of a parameter."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            path = f"{type(self).__name__}.{entry.name}"
            object.__setattr__(self, entry.name, _parameter(getattr(self, entry.name), path, self.least))

    def on(self, grid: Grid, path: str) -> Self:
        """The kinetics on a grid, with arrays in place of functions.

        Raises:
            SceneError: a parameter has another shape than the grid, or is out of range; `path` is that of the kinetics.
        """
        given = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return replace(
            self,
            **{
                name: _parameter(grid.uniform_or_field(value, f"{path}.{name}"), f"{path}.{name}", self.least)
                for name, value in given.items()
            },
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the species."""
        return ("u", "v")


def _parameter(value: Field, path: str, least: float) -> Field:
    """A number, or a read-only array, not below `least`; a function unchanged."""
    if callable(value):
        return value
    if np.ndim(regular(value, path)) == 0:
        return number(value, path, least=least)
    values = frozen(array(value, path))
    require(values >= least, values, path, f"≥ {least:g}")
    return values


@dataclass(frozen=True, eq=False, repr=False)
class GrayScott(Kinetics):
    """Gray–Scott reaction u + 2 v → 3 v in a stirred tank fed with u: spots, stripes, labyrinths and chaos.

        kinetics = pc.GrayScott(feed=0.035, kill=0.0625)
        pearson_map = pc.GrayScott(feed=lambda x, y: 0.01 + 0.02 * x, kill=lambda x, y: 0.045 + 0.01 * y)

        R_u = −u v² + F (1 − u)
        R_v =  u v² − (F + k) v

    Args:
        feed: F [1/s], a field ≥ 0.
        kill: k [1/s], a field ≥ 0.

    A field is a number, an array of the grid's shape, or a function of the coordinates of the cell centers. With F
    along x and k along y, one picture shows Pearson's map of patterns.

    Raises:
        SceneError: a value is below zero or not finite.

    Source: P. Gray, S. K. Scott, Chem. Eng. Sci. 39, 1087 (1984); J. E. Pearson, Science 261, 189 (1993).
    """

    feed: Field
    kill: Field
    shown: ClassVar[str] = "v"
    least: ClassVar[float] = 0.0

    @classmethod
    def pearson(cls, pattern: Pearson) -> Self:
        """The Gray–Scott kinetics of one of Pearson's classes of patterns, "alpha" to "mu".

            spots = pc.ReactionDiffusion(grid, pc.GrayScott.pearson("lambda"), {"u": 2e-5, "v": 1e-5}, …)

        The rates are for D_u = 2e-5 and D_v = 1e-5 m²/s. If both are multiplied by a factor, lengths grow as its square
        root. "alpha", "beta" and "gamma" are chaotic. "epsilon" and "zeta" are spots that divide and die. "lambda" are
        spots that divide until they fill the plane. "delta" and "eta" have spots and stripes, "theta", "kappa" and "mu"
        stripes, and "iota" holes.

        Raises:
            SceneError: there is no such class.

        Source: J. E. Pearson, Science 261, 189 (1993), figure 3; R. P. Munafo, mrob.com/pub/comp/xmorphia.
        """
        return cls(*PEARSON[word(pattern, "GrayScott.pearson", tuple(PEARSON))])


@dataclass(frozen=True, eq=False, repr=False)
class FitzHughNagumo(Kinetics):
    """FitzHugh–Nagumo excitable medium: nerve pulses and spiral waves.

        kinetics = pc.FitzHughNagumo(epsilon=0.08, beta=0.7, gamma=0.8)

        R_u = u − u³/3 − v + I
        R_v = ε (u + β − γ v)

    u is the membrane potential, and v is the recovery variable. With the defaults the rest state u = −1.1994, v =
    −0.6243 is stable and excitable. For currents from 0.33 to 1.42 the medium oscillates.

    Args:
        epsilon: ε, the ratio of the rates of recovery and of excitation, a field as in `GrayScott`.
        beta, gamma: parameters β and γ, fields.
        current: stimulus current I, a field.

    Raises:
        SceneError: a value is not finite.

    Source: R. FitzHugh, Biophys. J. 1, 445 (1961); J. Nagumo, S. Arimoto, S. Yoshizawa, Proc. IRE 50, 2061 (1962).
    """

    epsilon: Field = 0.08
    beta: Field = 0.7
    gamma: Field = 0.8
    current: Field = 0.0
    signed: ClassVar[bool] = True


@dataclass(frozen=True, eq=False, repr=False)
class Brusselator(Kinetics):
    """Brusselator of Prigogine and Lefever: oscillations, and patterns if v diffuses faster than u.

        kinetics = pc.Brusselator(a=2.0, b=4.0)

        R_u = a − (b + 1) u + u² v
        R_v = b u − u² v

    The uniform state is u = a, v = b/a. It oscillates for b > 1 + a². Below that it forms a pattern if b > (1 + a
    √(D_u/D_v))².

    Args:
        a, b: feed parameters, fields as in `GrayScott`.

    Raises:
        SceneError: a value is not finite.

    Source: I. Prigogine, R. Lefever, J. Chem. Phys. 48, 1695 (1968).
    """

    a: Field
    b: Field


@dataclass(frozen=True, eq=False, repr=False)
class Schnakenberg(Kinetics):
    """Schnakenberg reaction: spots and stripes if v diffuses faster than u.

        kinetics = pc.Schnakenberg(a=0.1, b=0.9)

        R_u = a − u + u² v
        R_v = b − u² v

    The uniform state is u = a + b, v = b/(a + b)².

    Args:
        a, b: feed rates, fields as in `GrayScott`.

    Raises:
        SceneError: a value is not finite.

    Source: J. Schnakenberg, J. Theor. Biol. 81, 389 (1979).
    """

    a: Field
    b: Field


@dataclass(frozen=True, eq=False, repr=False)
class Reaction(Kinetics):
    """User-defined reaction between any species, given by a NumPy function of all cells.

        logistic = pc.Reaction(("n",), lambda n: (n * (1 - n),))
        kinetics = pc.Reaction(("u", "v"), lambda u, v: (-u * v * v + F * (1 - u), u * v * v - (F + k) * v))

    The function is called once per stage of each step, on one thread. Its arguments are the values of each species in
    all cells, as arrays of the grid's shape, which it may modify. It returns the rates of all species in order, one
    array of this shape for each. The rates in a cell must not depend on other cells.

    Args:
        species: names of the species, each a Python identifier.
        function: function that returns the rates [1/s].

    Raises:
        SceneError: a name is not an identifier, or occurs twice.
    """

    species: tuple[str, ...]
    function: Callable[..., Sequence[Any]]
    signed: ClassVar[bool] = True
    ranged: ClassVar[bool] = True

    def __post_init__(self) -> None:
        names = tuple(text(name, "Reaction.species") for name in items(self.species, "Reaction.species", "names"))
        if not names or len(set(names)) < len(names) or not all(name.isidentifier() for name in names):
            raise SceneError(
                f"Reaction.species: must be different names, such as ('u', 'v'), got {shown(self.species)}"
            )
        if not callable(self.function):
            raise SceneError(f"Reaction.function: must be a function of the species, got {shown(self.function)}")
        object.__setattr__(self, "species", names)

    def on(self, grid: Grid, path: str) -> Self:
        """The kinetics itself: its function has all cells."""
        del grid, path
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the species."""
        return self.species


KINETICS: tuple[type[Kinetics], ...] = (GrayScott, FitzHughNagumo, Brusselator, Schnakenberg, Reaction)
"""All classes of kinetics."""

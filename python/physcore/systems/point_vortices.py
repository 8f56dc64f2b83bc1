"""Point vortices in 2D."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from numpy.typing import ArrayLike

from physcore.checks import BoolArray, FloatArray, broadcast, frozen, number, text
from physcore.scene.points import PointSystem, points


@dataclass(frozen=True, eq=False, init=False, repr=False)
class PointVortices(PointSystem):
    """Point vortices in 2D, which move in each other's velocity fields; also a flow for `Tracers`.

        pair = pc.PointVortices([[0.0, 0.0], [1.0, 0.0]], circulations=[2.0, 1.0])
        dye = pc.Tracers(rng.uniform(-2, 2, (500, 2)), pair)
        recording = pc.simulate(pc.Scene(pair, dye), duration=2.0)
        recording[pair].positions  # (F, 2, 2)
        recording.budgets["hamiltonian"].drift  # (F,)

    The velocity field is

        v(x) = Σ Γⱼ/(2π) e_z × (x − xⱼ)/(|x − xⱼ|² + δ²).

    Each vortex moves with the velocity field of the others at its center. Tracers in their flow are advanced in the
    same stages of each step. Conserved are Σ Γ x, Σ Γ y, Σ Γ (x² + y²), and the Hamiltonian H = −Σ Γᵢ Γⱼ ln(|xᵢ − xⱼ|²
    + δ²)/(4π) over all pairs [m⁴/s²]. The drift of its budget measures the accuracy.

    Args:
        centers: initial positions [m], shape (N, 2).
        circulations: circulation Γ of each vortex [m²/s], broadcast to (N,); positive is counterclockwise.
        core: core radius δ ≥ 0 [m], within which the velocity is smooth; 0: ideal point vortices.
        name: name of the system, also a key into results.

    Raises:
        SceneError: a shape does not fit, a value is not finite or out of range, or two vortices without a core
            coincide.

    Sources: G. Kirchhoff, "Vorlesungen über mathematische Physik", 1876, lecture 20; P. G. Saffman, "Vortex Dynamics",
    1992, chapter 7; for the core, R. Krasny, J. Comput. Phys. 65, 292 (1986).
    """

    dimensions: ClassVar[tuple[int, ...]] = (2,)

    centers: FloatArray
    """Initial positions [m], shape (N, 2)."""
    circulations: FloatArray
    """Circulation Γ of each vortex [m²/s], shape (N,)."""
    core: float
    """Core radius δ [m]."""

    def __init__(self, centers: ArrayLike, circulations: ArrayLike, core: float = 0.0, name: str | None = None) -> None:
        places = points(centers, "PointVortices.centers", (2,))
        strengths = frozen(broadcast(circulations, (len(places),), "PointVortices.circulations"))
        self._set(
            centers=places,
            circulations=strengths,
            core=number(core, "PointVortices.core", least=0.0),
            name=None if name is None else text(name, "PointVortices.name"),
        )

    @property
    def signs(self) -> BoolArray:
        """Which vortices turn anticlockwise."""
        return self.circulations > 0.0

    @property
    def start(self) -> FloatArray:
        """The initial positions [m], shape (N, 2)."""
        return self.centers

"""The largest stable time step: by theory, and by trying."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, overload

import numpy as np

from physcore.checks import flag
from physcore.errors import SimulationDiverged
from physcore.numerics.choices import Numerics, check
from physcore.numerics.fluids import Fluids
from physcore.numerics.integrators import Integrator
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.simulation import Simulation, require_scene
from physcore.simulation.stepper import unwarned
from physcore.spelling import spelled
from physcore.studies.state import nudge, place

STEPS = 2000
"""Steps of a trial: a thousandth above the limit, an undamped oscillation grows by a factor of 1.09 in each of them."""
NUDGE = 1e-9
"""How fast every particle is sent off, as a fraction of the scene's extent in one step at the limit, so that whatever
can grow is there to grow."""
MAX_ENERGY_GROWTH = 1e3
"""How many times its largest energy a run must gain to count as unstable."""
RESOLUTION = 1e-3
"""How well the limit is found, as a fraction of itself."""
FARTHEST = 64.0
"""How many times the limit of theory is tried at most."""
STRIDE = 1.1
"""How the search goes up: in strides that do not step over an edge into an island of stability beyond it."""


@dataclass(frozen=True)
class MeasuredLimit:
    """The largest time step that real runs withstood, beside that of theory.

        limit = pc.stability_limit(scene, "PEFRL", measured=True)  # a MeasuredLimit
        print(limit.measured, limit.theory)

    `stability_limit` gives it with `measured=True`.
    """

    integrator: Integrator
    measured: float
    """The largest step that held for 2000 steps [s]; inf where nothing limits it, 0 where theory promises none."""
    theory: float
    """What `stability_limit` gives without measuring [s]."""
    term: str
    """The term that binds it."""

    @property
    def margin(self) -> float:
        """How much larger the measured limit is than that of theory, as a fraction; 0 where both are 0 or inf."""
        return self.measured / self.theory - 1.0 if 0.0 < self.theory < math.inf else 0.0

    def __str__(self) -> str:
        name = type(self.integrator).__name__
        if self.theory == 0.0:
            return f"{name}: theory promises no stable step ({self.term}), and none was tried"
        if math.isinf(self.theory):
            return f"{name}: nothing limits the time step"
        return (
            f"{name}: runs hold up to dt = {self.measured:.4g} s, theory promises {self.theory:.4g} s ({self.term}): "
            f"a margin of {self.margin:+.1%}"
        )


@overload
def stability_limit(
    scene: Scene, integrator: Integrator | str, *, fluids: Fluids = "auto", measured: Literal[False] = False
) -> float: ...


@overload
def stability_limit(
    scene: Scene, integrator: Integrator | str, *, fluids: Fluids = "auto", measured: Literal[True]
) -> MeasuredLimit: ...


@spelled
def stability_limit(
    scene: Scene, integrator: Integrator | str, *, fluids: Fluids = "auto", measured: bool = False
) -> float | MeasuredLimit:
    """The largest time step [s] at which a scene is stable, as it stands at the start; inf: any; 0.0: none is certain.

        pc.stability_limit(scene, "RungeKutta4")  # [s]

    Particles under linear drag and harmonic central forces alone are oscillators, and this is their exact limit.

    For springs it is the largest eigenvalue of M⁻¹K in their present directions, by sixteen products of Lanczos'
    method and 2 % above it; in 1000 random networks 0.962 to 1.001 of the true limit. Springs that turn may lower it,
    at most to the certified bound that holds in any direction while none is shorter than half its rest length. A step
    below half of this limit is almost always below that bound as well. Where damping differs from mode to mode, it is
    the limit of the worst oscillation that the largest stiffness and damping allow together, which may be far below the
    true one. The functions of a `CustomForce` are called to find how stiff they are, as its description says.

    Args:
        scene: what to simulate.
        integrator: how, or its name.
        fluids: how fluids are computed, as in Simulation.
        measured: whether to look for the limit by bisection of real runs too, of 2000 steps from the scene's start with
            every particle nudged a little; a `MeasuredLimit` then gives both, to a thousandth.

    Raises:
        SceneError: an argument is not valid, or a particle starts outside a boundary.
    """
    require_scene(scene)
    numerics = check({"integrator": integrator, "threads": 1, "fluids": fluids}, scene)
    limit = engine.limit(engine.build(scene, numerics))
    if not flag(measured, "measured"):
        return limit.stability
    found = limit.stability
    if 0.0 < found < math.inf:
        found = _bisect(scene, numerics, found)
    return MeasuredLimit(numerics.integrator, found, limit.stability, limit.term)


def _bisect(scene: Scene, numerics: Numerics, theory: float) -> float:
    """The largest dt that holds, between one that does and one that does not."""
    holds, fails = theory, math.inf
    while not _stable(scene, numerics, holds, theory):
        holds, fails = 0.5 * holds, holds
        if holds < theory / FARTHEST:
            return 0.0
    while math.isinf(fails):
        if holds > FARTHEST * theory:
            return holds
        if _stable(scene, numerics, STRIDE * holds, theory):
            holds *= STRIDE
        else:
            fails = STRIDE * holds
    while fails > holds * (1.0 + RESOLUTION):
        middle = 0.5 * (holds + fails)
        if _stable(scene, numerics, middle, theory):
            holds = middle
        else:
            fails = middle
    return holds


def _stable(scene: Scene, numerics: Numerics, dt: float, theory: float) -> bool:
    """Whether a run holds for 2000 steps."""
    with unwarned():
        run = Simulation(
            scene, numerics.integrator, dt, "f64", max_energy_growth=MAX_ENERGY_GROWTH, fluids=numerics.fluids or "auto"
        )
    places = place(run)
    # Of particles how far they are apart, of a field how far its values are.
    extent = float(np.ptp(places, axis=0 if scene.bodies else None).max()) or 1.0
    nudge(run, NUDGE * extent / theory, seed=0)
    try:
        run.step(STEPS)
    except SimulationDiverged:
        return False
    return True

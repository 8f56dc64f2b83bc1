"""Largest stable time step, by theory and by experiment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, overload

import numpy as np

from physcore.checks import flag
from physcore.entrance import entrance
from physcore.errors import SimulationDiverged
from physcore.markup import Printed
from physcore.numerics.choices import Numerics, check
from physcore.numerics.contacts import Contacts
from physcore.numerics.fluids import Fluids
from physcore.numerics.integrators import Integrator
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.simulation import Simulation, require_scene
from physcore.simulation.step_size import undivided
from physcore.simulation.step_warnings import unwarned
from physcore.studies.state import compared, nudge
from physcore.units.systems import SI, UnitSystem

STEPS = 2000
"""Number of steps of a trial. At 0.1 % above the limit, an undamped oscillation grows by a factor of 1.09 per step."""
NUDGE = 1e-9
"""Perturbation of all velocities, as a fraction of the scene's extent per step at the limit, so that every unstable
mode is excited.
"""
MAX_ENERGY_GROWTH = 1e3
"""Ratio to its largest initial energy at which a run counts as unstable."""
RESOLUTION = 1e-3
"""Relative resolution of the limit."""
FARTHEST = 64.0
"""Largest ratio of a trial step to the theoretical limit."""
STRIDE = 1.1
"""Factor between trial steps in the upward search, small enough not to skip an unstable range."""


@dataclass(frozen=True, repr=False)
class MeasuredLimit(Printed):
    """Measured limit of stability: the largest stable time step in trial runs, and the theoretical limit.

        limit = pc.stability_limit(scene, "PEFRL", measured=True)  # a MeasuredLimit
        print(limit.measured, limit.theory)

    `stability_limit` returns it with `measured=True`.
    """

    integrator: Integrator
    measured: float
    """Largest step that was stable for 2000 steps [s]; inf without a limit, 0 if the theoretical limit is 0."""
    theory: float
    """Theoretical limit, as returned by `stability_limit` without measuring [s]."""
    term: str
    """Term of the scene that determines the limit."""
    units: UnitSystem = SI
    """Units of the scene."""

    @property
    def margin(self) -> float:
        """Relative excess of the measured limit over the theoretical one; 0 if both are 0 or inf."""
        return self.measured / self.theory - 1.0 if 0.0 < self.theory < math.inf else 0.0

    def __str__(self) -> str:
        name = type(self.integrator).__name__
        if self.theory == 0.0:
            return f"{name}: theory promises no stable step ({self.term}), and none was tried"
        if math.isinf(self.theory):
            return f"{name}: nothing limits the time step"
        second = self.units.suffix("s")
        return (
            f"{name}: runs hold up to dt = {self.measured:.4g}{second}, theory promises {self.theory:.4g}{second} "
            f"({self.term}): a margin of {self.margin:+.1%}"
        )


@overload
def stability_limit(
    scene: Scene,
    integrator: Integrator | str,
    *,
    fluids: Fluids = "auto",
    contacts: Contacts = "auto",
    measured: Literal[False] = False,
) -> float: ...


@overload
def stability_limit(
    scene: Scene,
    integrator: Integrator | str,
    *,
    fluids: Fluids = "auto",
    contacts: Contacts = "auto",
    measured: Literal[True],
) -> MeasuredLimit: ...


@entrance
def stability_limit(
    scene: Scene,
    integrator: Integrator | str,
    *,
    fluids: Fluids = "auto",
    contacts: Contacts = "auto",
    measured: bool = False,
) -> float | MeasuredLimit:
    """Find the largest stable time step of a scene [s], in its initial state.

        pc.stability_limit(scene, "RungeKutta4")  # [s]

    The result is inf if every step is stable, and 0.0 if no step is certain to be stable. For particles with only
    linear drag and harmonic central forces, which are oscillators, the limit is exact.

    For springs the limit follows from the largest eigenvalue of M⁻¹K in their present directions. The eigenvalue comes
    from sixteen products of Lanczos' method, plus 2 %. In 1000 random networks the result was 0.962 to 1.001 of the
    true limit. Rotating springs can lower the limit, at most to the certified bound. This bound is valid in all
    directions, as long as no spring is shorter than half its rest length. A step below half of the limit is almost
    always below the certified bound too. If damping differs between modes, the result is the limit for an oscillation
    with both the largest stiffness and the largest damping. This may be far below the true limit. The functions of a
    `CustomForce` are called to find their stiffness, as described there.

    Args:
        scene: the scene.
        integrator: the integrator or its name.
        fluids: the method of fluids, as in Simulation.
        contacts: the solver of the contacts of rigid bodies, as in Simulation.
        measured: whether to measure the limit too, by bisection. Trial runs have 2000 steps from the scene's start,
            with all velocities slightly perturbed. The result is a `MeasuredLimit` with both limits, to 0.1 %.

    Raises:
        SceneError: an argument is not valid, or a particle starts outside a boundary.
    """
    require_scene(scene)
    numerics = check({"integrator": integrator, "threads": 1, "fluids": fluids, "contacts": contacts}, scene)
    limit = engine.limit(engine.build(scene, numerics))
    if not flag(measured, "measured"):
        return limit.stability
    found = limit.stability
    if 0.0 < found < math.inf:
        found = _bisect(scene, numerics, found)
    return MeasuredLimit(numerics.integrator, found, limit.stability, limit.term, scene.units)


def _bisect(scene: Scene, numerics: Numerics, theory: float) -> float:
    """The largest stable dt, by bisection between a stable and an unstable step."""
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
    """Whether a run of 2000 steps is stable."""
    with unwarned(), undivided():
        run = Simulation(
            scene,
            numerics.integrator,
            dt,
            "f64",
            max_energy_growth=MAX_ENERGY_GROWTH,
            fluids=numerics.fluids or "auto",
            contacts=numerics.contacts or "auto",
        )
    # For particles the range of positions, for a field the range of its values.
    ranges = [np.ptp(each.values(run).reshape(-1, each.components), axis=0).max() for each in compared(scene)]
    nudge(run, [NUDGE * (float(extent) or 1.0) / theory for extent in ranges], seed=0)
    try:
        run.step(STEPS)
    except SimulationDiverged:
        return False
    return True

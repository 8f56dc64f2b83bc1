"""Number of steps of a run, and advice if there are too many."""

from __future__ import annotations

from physcore.checks import MOST

MOST_STEPS = 10_000_000
"""Number of steps above which a run is called long. The smallest scene takes about 1 µs per step, so that this is 10 s.
A film of one minute at 30 frames per second would have 5000 steps per frame.
"""

RELAX = {
    "springs": "lower the stiffness or the damping of the springs, raise their masses, or take pc.BackwardEuler()",
    "repulsion": "lower the stiffness or the damping of SoftSpheres, or raise the masses",
    "Lennard-Jones": "move apart the particles that start inside each other: at rest they are 1.12 sigma apart",
    "custom": "make the function of the CustomForce less steep, or raise the masses",
    "sound": "take a larger spacing or a lower sound_speed for the fluid",
    "viscosity": "take a larger spacing or a lower viscosity for the fluid",
    "gravitation": "move apart the closest particles, or give Gravitation a softening",
    "coulomb": "move apart the closest charges, or give Coulomb a softening",
    "gyration": "lower the magnetic field, or raise the masses",
    "central": "start farther from the center of the CentralForce",
    "flow": "slow the flow down",
}
"""Advice if a term of the scene limits the time step, by the term's name in the plan."""


ENCOUNTERS = ("gravitation", "coulomb", "central")
"""Terms of forces that may grow without bound as particles approach each other or a center."""

ENCOUNTER_CURE = "take dt=pc.AdaptiveStep(), integrator=pc.GaussRadau15(), or a softening"
"""Advice for close encounters, in which no fixed step is right."""


def is_encounter(term: str, kind: str) -> bool:
    """Whether close encounters limit the time step, by the term and the kind of the limit."""
    return term in ENCOUNTERS and kind == "accuracy"


def remedy(term: str, given: bool) -> str:
    """Advice for a run with too many steps. The time step was given, or follows from a term of the scene."""
    if given:
        return 'leave dt to "auto", or give a larger one'
    return RELAX.get(term, "make the scene coarser") + "; or ask for a shorter duration"


def long_run(duration: float, dt: float, term: str, given: bool) -> str | None:
    """The message before a run of a duration [s] with too many steps of dt [s]; None if there are not too many."""
    if not MOST_STEPS * dt < duration <= MOST * dt:
        return None
    steps = duration / dt
    cause = f", because of {term}" if term and not given else ""
    return (
        f"duration: {duration:g} s are {steps:.1e} steps of {dt:.2g} s{cause}: {remedy(term, given)}; "
        "pc.diagnose(simulation, duration) estimates the time"
    )

"""Fuzzing of the energy balance: without friction it closes, where the time step is far below the limit."""

from __future__ import annotations

from hypothesis import strategies as st
from oracle import Target, attempt, require
from values import evaluate

import physcore as pc
from physcore.integrators import INTEGRATORS

FRACTION = 50
"""The time step is this fraction of the limit: ω dt ≤ 0.06 for every mode and integrator, as limits are below 3/ω."""
STEPS = 200

NUMBER = st.builds("{}e{}".format, st.sampled_from(["1", "2.5", "7"]), st.integers(-2, 2))
BODY = st.one_of(
    st.builds(
        "pc.rope({}, {}, {}, mass={}, pinned={})".format,
        st.integers(2, 6),
        NUMBER,
        NUMBER,
        NUMBER,
        st.sampled_from(["None", "'start'"]),
    ),
    st.builds(
        "pc.cloth(({}, 3), {}, {}, mass={}, pinned={})".format,
        st.integers(2, 4),
        NUMBER,
        NUMBER,
        NUMBER,
        st.sampled_from(["None", "'top'"]),
    ),
    st.builds("pc.soft_body((2, {}), {}, {}, mass={})".format, st.integers(2, 4), NUMBER, NUMBER, NUMBER),
)
INTEGRATOR = st.sampled_from(
    [f"pc.{kind.__name__}()" for kind in INTEGRATORS if kind is not pc.ExplicitEuler and kind.advances("Wave")]
)
EXAMPLES = st.tuples(BODY, NUMBER, INTEGRATOR)


def check(example: tuple[str, str, str]) -> int:
    """A network that falls and turns: the drift of the balance is below ω dt in the first order, then below its square.

    The error of the energy of an oscillation is at most ω dt/2 of it with semi-implicit Euler, and (ω dt)²/4 with a
    method of order 2 (E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration", § I.1 and IX.8). The margin
    of two and of four is for springs that a motion makes faster than they are at rest.
    """
    body, speed, integrator = example
    script = f"scene = pc.Scene({body}, pc.Gravity((0.0, -9.81)))"
    scene = evaluate(f"pc.Scene({body}, pc.Gravity((0.0, -9.81)))")
    kind = evaluate(integrator)
    dt = pc.stability_limit(scene, kind) / FRACTION
    script += (
        f"\n    simulation = pc.Simulation(scene, {integrator}, dt={dt!r}); simulation.set(velocities=[{speed}, 0.0])"
    )
    simulation = pc.Simulation(scene, kind, dt, threads=1)
    simulation.set(velocities=[float(speed), 0.0])
    recording = attempt(lambda: simulation.record(STEPS * dt, 0.25 / dt), f"{script}; simulation.record(…)")
    require(recording is not None, "diverged far below the limit", script)
    bound = 0.06 if kind.order == 1 else 0.06**2
    drift = abs(recording.energy.drift).max()
    require(
        drift <= bound,
        f"the balance of {type(kind).__name__} does not close",
        f"{script}; simulation.record(…)  # {drift:.1e}",
    )
    return 4


TARGET = Target("balance", EXAMPLES, check, share=0.02, quick=30)

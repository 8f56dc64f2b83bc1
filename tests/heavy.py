"""Scenes that take tens of megabytes, each by other parts of the engine: a scene and its numerics, as texts."""

from __future__ import annotations

CHAIN = (
    "(lambda n: pc.SpringNetwork(np.c_[np.arange(n), np.zeros(n)], pairs=np.c_[np.arange(n - 1), np.arange(1, n)], "
    "stiffness=np.inf, fixed=[0]))"
)
SHEET = "pc.cloth((150, 150), 0.01, 100.0, mass=1e-4, axes=((1, 0, 0), (0, 1, 0)))"
HEAVY = {
    "tree": (
        "pc.Scene(pc.Particles(random.random((50_000, 3))), pc.Gravitation(1e-9, softening=0.01, opening_angle=1))",
        "dt=1e-3",
    ),
    "Dormand-Prince": (
        "pc.Scene(pc.Particles(random.random((200_000, 3))), pc.Gravity((0, 0, -1)))",
        "integrator='DormandPrince5', dt=1e-3",
    ),
    "neighbors": (
        "pc.Scene(pc.Particles(30 * random.random((80_000, 3)), radius=0.3), pc.SoftSpheres(100.0))",
        "dt=1e-5",
    ),
    "fluid": ("pc.Scene(pc.Fluid(pc.block((0, 0, 0), (1, 1, 0.5), 0.02), 0.02), pc.Gravity(), pc.Floor(0))", ""),
    "self-contact": (f"(lambda c: pc.Scene(c, pc.SelfContact(c, thickness=0.004)))({SHEET})", "dt=1e-5"),
    "rods": (f"pc.Scene({CHAIN}(60_000), pc.Gravity((0, -9.81)))", "dt=1e-6"),
    "rods at a wall": (f"pc.Scene({CHAIN}(25_000), pc.Gravity((0, -9.81)), pc.Floor(-5))", "dt=1e-6"),
    "projective": (f"pc.Scene({SHEET}, pc.Gravity((0, 0, -9.81)))", "integrator=pc.ProjectiveDynamics(2), dt=1e-3"),
    "implicit": (f"pc.Scene({SHEET}, pc.Gravity((0, 0, -9.81)))", "integrator='BackwardEuler', dt=1e-3"),
    "wave": ("pc.Scene(pc.Wave(pc.Grid((50, 50, 50), 0.1), 1.0, edges='absorbing'))", ""),
    "wave function": (
        "(lambda g: pc.Scene(pc.Schrodinger(g, pc.wave_packet(g, (30.0, 30.0), (1.0, 0.0), 5.0))))"
        "(pc.Grid((600, 600), 0.1))",
        "dt=1e-3",
    ),
    "tracers of vortices": (
        "(lambda v: pc.Scene(v, pc.Tracers(random.random((500_000, 2)), v)))"
        "(pc.PointVortices(random.random((10, 2)), random.random(10)))",
        "dt=1e-3",
    ),
}

"""physcore: particles, cloth, fluids, waves, reactions, wave functions and charges, with audited energy and films.

    import physcore as pc

    cloth = pc.cloth((40, 30), spacing=0.025, stiffness=400.0, damping=0.02, mass=0.002, pinned="top corners")
    recording = pc.simulate(pc.Scene(cloth, pc.Gravity()), duration=4.0)
    pc.film(recording, "cloth.gif")

A Scene describes the bodies and the forces. The numerics (integrator, dt, precision, threads) are given beside it. A
Simulation owns state and clock, a Recording holds arrays and the energy audit, and `film` draws them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from physcore import units
from physcore.boundaries import Boundary, Box, Capsule, ConvexHull, Floor, HeightField, Plane, Sphere
from physcore.constraints import Anchor, BallJoint, Hinge, Motor, Prismatic, Rod, SelfContact, SpringJoint, Weld, Wire
from physcore.entrance import entrances
from physcore.errors import (
    AccuracyError,
    FileError,
    FileWarning,
    InternalError,
    MachWarning,
    PhyscoreError,
    SceneError,
    SceneWarning,
    SimulationDiverged,
    StabilityWarning,
    WorkerError,
)
from physcore.film import film
from physcore.forces import (
    CentralForce,
    Coulomb,
    CurrentLoop,
    CustomForce,
    Dihedral,
    Drag,
    ElectromagneticField,
    Force,
    Gravitation,
    Gravity,
    LennardJones,
    MagneticBottle,
    MagneticDipole,
    PaulTrap,
    QuadrupoleTrap,
    SoftSpheres,
    TravellingWave,
    UniformField,
    Wind,
)
from physcore.numerics.choices import AdaptiveStep, AutoStep
from physcore.numerics.contacts import ContactSolver
from physcore.numerics.fluids import FluidMethod, WeaklyCompressible
from physcore.numerics.integrators import (
    BDF2,
    PEFRL,
    RATTLE,
    XPBD,
    BackwardEuler,
    BlanesMoan4,
    BlanesMoan6,
    BogackiShampine3,
    Boris,
    CrankNicolson,
    DormandPrince5,
    ExplicitEuler,
    GaussRadau15,
    ImplicitMidpoint,
    Integrator,
    McLachlan2,
    ProjectiveDynamics,
    RungeKutta4,
    RungeKuttaChebyshev,
    SemiImplicitEuler,
    SplitStep,
    Staggered,
    VelocityVerlet,
)
from physcore.scene import materials
from physcore.scene.bodies import Body, Particles, SpringNetwork
from physcore.scene.builders import cloth, rope, soft_body
from physcore.scene.edges import Absorbing, Dirichlet, Neumann
from physcore.scene.fluid import Fluid
from physcore.scene.grid import Grid
from physcore.scene.kernels import CubicSpline, Kernel, WendlandC2, WendlandC4
from physcore.scene.masks import polygon_from_mask
from physcore.scene.periodic import Periodic
from physcore.scene.polytopes import Compound, Hull, MeshShape, Polygon
from physcore.scene.probe import Probe
from physcore.scene.rigid import RigidBodies, RigidBody
from physcore.scene.scene import Scene
from physcore.scene.shapes import ball, block, cylinder
from physcore.scene.solids import Ball, Cuboid, Disc, Rectangle
from physcore.simulation.energy import Amount, AmountSeries, Energy, EnergySeries
from physcore.simulation.event import Event
from physcore.simulation.loading import load
from physcore.simulation.occurrences import Events, Occurrences
from physcore.simulation.plan import Plan
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.simulation.state import Frame, Part, Snapshot
from physcore.spelling import did_you_mean
from physcore.studies.accuracy import simulate
from physcore.systems.flows import Aizawa, Flow, Halvorsen, Lorenz, Rossler, Thomas
from physcore.systems.kinetics import Brusselator, FitzHughNagumo, GrayScott, Reaction, Schnakenberg
from physcore.systems.point_vortices import PointVortices
from physcore.systems.reaction_diffusion import ReactionDiffusion
from physcore.systems.schrodinger import Schrodinger, wave_packet
from physcore.systems.tracers import Tracers
from physcore.systems.wave import Ricker, Source, Wave

if TYPE_CHECKING:
    from physcore.files import Atoms, Mesh, Picture, Signal, Table, from_mesh, read
    from physcore.film import (
        DARK,
        LIGHT,
        Corotating,
        Curve,
        Follow,
        Keyframes,
        Orbit,
        Renderer,
        Theme,
        Window,
        provenance,
        styles,
    )
    from physcore.output import export
    from physcore.panel import Choice, Panel, Slider, Switch, live
    from physcore.studies.diagnosis import Diagnosis, Finding, diagnose
    from physcore.studies.lyapunov import Lyapunov, lyapunov
    from physcore.studies.stability import MeasuredLimit, stability_limit
    from physcore.studies.sweep import Sweep, sweep
    from physcore.studies.tradeoff import Tradeoff, tradeoff

__version__: str
"""The version of the installed package."""

__all__ = [
    "BDF2",
    "DARK",
    "LIGHT",
    "PEFRL",
    "RATTLE",
    "XPBD",
    "Absorbing",
    "AccuracyError",
    "AdaptiveStep",
    "Aizawa",
    "Amount",
    "AmountSeries",
    "Anchor",
    "Atoms",
    "AutoStep",
    "BackwardEuler",
    "Ball",
    "BallJoint",
    "BlanesMoan4",
    "BlanesMoan6",
    "Body",
    "BogackiShampine3",
    "Boris",
    "Boundary",
    "Box",
    "Brusselator",
    "Capsule",
    "CentralForce",
    "Choice",
    "Compound",
    "ContactSolver",
    "ConvexHull",
    "Corotating",
    "Coulomb",
    "CrankNicolson",
    "CubicSpline",
    "Cuboid",
    "CurrentLoop",
    "Curve",
    "CustomForce",
    "Diagnosis",
    "Dihedral",
    "Dirichlet",
    "Disc",
    "DormandPrince5",
    "Drag",
    "ElectromagneticField",
    "Energy",
    "EnergySeries",
    "Event",
    "Events",
    "ExplicitEuler",
    "FileError",
    "FileWarning",
    "Finding",
    "FitzHughNagumo",
    "Floor",
    "Flow",
    "Fluid",
    "FluidMethod",
    "Follow",
    "Force",
    "Frame",
    "GaussRadau15",
    "Gravitation",
    "Gravity",
    "GrayScott",
    "Grid",
    "Halvorsen",
    "HeightField",
    "Hinge",
    "Hull",
    "ImplicitMidpoint",
    "Integrator",
    "InternalError",
    "Kernel",
    "Keyframes",
    "LennardJones",
    "Lorenz",
    "Lyapunov",
    "MachWarning",
    "MagneticBottle",
    "MagneticDipole",
    "McLachlan2",
    "MeasuredLimit",
    "Mesh",
    "MeshShape",
    "Motor",
    "Neumann",
    "Occurrences",
    "Orbit",
    "Panel",
    "Part",
    "Particles",
    "PaulTrap",
    "Periodic",
    "PhyscoreError",
    "Picture",
    "Plan",
    "Plane",
    "PointVortices",
    "Polygon",
    "Prismatic",
    "Probe",
    "ProjectiveDynamics",
    "QuadrupoleTrap",
    "Reaction",
    "ReactionDiffusion",
    "Recording",
    "Rectangle",
    "Renderer",
    "Ricker",
    "RigidBodies",
    "RigidBody",
    "Rod",
    "Rossler",
    "RungeKutta4",
    "RungeKuttaChebyshev",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Schnakenberg",
    "Schrodinger",
    "SelfContact",
    "SemiImplicitEuler",
    "Signal",
    "Simulation",
    "SimulationDiverged",
    "Slider",
    "Snapshot",
    "SoftSpheres",
    "Source",
    "Sphere",
    "SplitStep",
    "SpringJoint",
    "SpringNetwork",
    "StabilityWarning",
    "Staggered",
    "Sweep",
    "Switch",
    "Table",
    "Theme",
    "Thomas",
    "Tracers",
    "Tradeoff",
    "TravellingWave",
    "UniformField",
    "VelocityVerlet",
    "Wave",
    "WeaklyCompressible",
    "Weld",
    "WendlandC2",
    "WendlandC4",
    "Wind",
    "Window",
    "Wire",
    "WorkerError",
    "ball",
    "block",
    "cloth",
    "cylinder",
    "diagnose",
    "export",
    "film",
    "from_mesh",
    "live",
    "load",
    "lyapunov",
    "materials",
    "polygon_from_mask",
    "provenance",
    "read",
    "rope",
    "simulate",
    "soft_body",
    "stability_limit",
    "styles",
    "sweep",
    "tradeoff",
    "units",
    "wave_packet",
]

_LATER = {
    "physcore.files": ("Atoms", "Mesh", "Picture", "Signal", "Table", "from_mesh", "read"),
    "physcore.film": (
        "DARK",
        "LIGHT",
        "Corotating",
        "Curve",
        "Follow",
        "Keyframes",
        "Orbit",
        "Renderer",
        "Theme",
        "Window",
        "provenance",
        "styles",
    ),
    "physcore.output": ("export",),
    "physcore.panel": ("Choice", "Panel", "Slider", "Switch", "live"),
    "physcore.studies.diagnosis": ("Diagnosis", "Finding", "diagnose"),
    "physcore.studies.lyapunov": ("Lyapunov", "lyapunov"),
    "physcore.studies.stability": ("MeasuredLimit", "stability_limit"),
    "physcore.studies.sweep": ("Sweep", "sweep"),
    "physcore.studies.tradeoff": ("Tradeoff", "tradeoff"),
}
"""Names that few scripts use, by module: each module is imported when one of its names is asked for."""

entrances(globals()[name] for name in __all__ if name in globals())
Recording.film = film  # Here, because what draws films imports recordings.


def __getattr__(name: str) -> object:
    """The version, and names whose module is imported when they are asked for."""
    for module, names in _LATER.items():
        if name in names:
            return getattr(import_module(module), name)
    if name != "__version__":
        raise AttributeError(f"module 'physcore' has no attribute {name!r}{did_you_mean(name, __all__)}")
    from importlib.metadata import version

    return version("physcore")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

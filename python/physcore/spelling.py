"""Suggestions for misspelt words, in messages about options, names and keywords."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from inspect import Parameter, signature
from typing import Any

SYNONYMS = {
    "RungeKutta4": ("rk4", "runge kutta", "classical runge kutta"),
    "VelocityVerlet": ("verlet", "leapfrog", "stormer verlet", "kick drift kick", "kdk"),
    "ExplicitEuler": ("euler", "forward euler"),
    "SemiImplicitEuler": ("symplectic euler", "euler cromer"),
    "BackwardEuler": ("implicit euler",),
    "ImplicitMidpoint": ("midpoint", "crank nicolson for particles"),
    "DormandPrince5": ("rk45", "dopri5", "ode45"),
    "BogackiShampine3": ("rk23", "ode23"),
    "GaussRadau15": ("ias15", "radau"),
    "BlanesMoan4": ("forest ruth", "yoshida", "yoshida4"),
    "XPBD": ("pbd", "position based dynamics"),
    "RATTLE": ("shake",),
    "SplitStep": ("strang", "split operator", "split step fourier"),
    "SpringNetwork": ("spring", "springs", "mass spring", "truss", "rods"),
    "Particles": ("particle", "point mass", "points", "balls"),
    "cloth": ("sheet", "fabric"),
    "rope": ("string", "chain", "hair"),
    "soft_body": ("jelly", "softbody"),
    "Fluid": ("water", "liquid"),
    "WeaklyCompressible": ("sph", "wcsph", "fluid method"),
    "ContactSolver": ("solver iterations", "rigid solver", "constraint solver"),
    "Gravitation": ("nbody", "newtonian gravity", "self gravity"),
    "SoftSpheres": ("repulsion", "collisions", "dem", "hertz", "granular"),
    "LennardJones": ("lj", "van der waals"),
    "Drag": ("friction", "air resistance", "damping force"),
    "CustomForce": ("force field", "user force", "python force"),
    "Floor": ("ground",),
    "Plane": ("wall", "half space"),
    "Dirichlet": ("fixed value", "dirichlet bc", "fixed", "face constrain"),
    "Neumann": ("flux", "neumann bc", "free", "gradient"),
    "Periodic": ("periodic box", "pbc", "domain"),
    "SelfContact": ("self collision", "contact", "cloth collision"),
    "Wire": ("bead", "track", "rail", "curve constraint", "roller coaster"),
    "Disc": ("circle", "disk"),
    "RigidBody": ("rigid", "solid body", "body2d"),
    "Hinge": ("revolute joint", "revolute", "pin joint", "axle"),
    "BallJoint": ("spherical joint", "ball and socket", "point to point"),
    "Weld": ("fixed joint", "weld joint"),
    "Prismatic": ("slider joint", "prismatic joint"),
    "Rod": ("distance joint", "link"),
    "SpringJoint": ("damped spring", "distance spring"),
    "ElectromagneticField": ("magnetic field", "electric field", "lorentz force"),
    "Schrodinger": ("schroedinger", "quantum", "wave function"),
    "ReactionDiffusion": ("diffusion", "heat", "heat equation"),
    "Event": ("crossing", "closest approach", "trigger", "stop condition"),
    "live": ("interactive", "gui", "show", "dashboard", "play"),
    "simulate": ("run", "solve", "integrate"),
    "film": ("animate", "render", "save gif", "movie", "video"),
}
"""Words that people try, by the name that they mean here."""

_MEANT = {re.sub(r"[^a-z0-9]", "", word): name for name, words in SYNONYMS.items() for word in words}

_UNEXPECTED = re.compile(r"unexpected keyword argument '(\w+)'")


class KeywordError(TypeError):
    """Unknown keyword argument of a function."""

    def __init__(self, function: str, name: str, known: Iterable[str]) -> None:
        self.known = tuple(dict.fromkeys(known))
        hint = did_you_mean(name, self.known) or f"; it takes {', '.join(self.known)}"
        super().__init__(f"{function}() got an unexpected keyword argument {name!r}{hint}")


class UnknownKey(KeyError):
    """Key or name that is not in a scene, a recording or a state."""

    def __str__(self) -> str:
        """The message itself: that of a KeyError is quoted."""
        return str(self.args[0])


def did_you_mean(value: object, known: Iterable[str]) -> str:
    """The end of a message that suggests a synonym, or the most similar known word; empty if there is neither."""
    if not isinstance(value, str) or value.startswith("__"):
        return ""  # Python asks for names such as __wrapped__, many at a time.
    from difflib import get_close_matches

    spelled = {each.casefold(): each for each in known}
    meant = _MEANT.get(re.sub(r"[^a-z0-9]", "", value.casefold()), "")
    if meant.casefold() in spelled:
        return f"; did you mean {spelled[meant.casefold()]!r}?"
    close = get_close_matches(value.casefold(), spelled, 1)
    return f"; did you mean {spelled[close[0]]!r}?" if close else ""


def explained(error: TypeError, function: Callable[..., object], keywords: dict[str, Any]) -> TypeError:
    """The error of an unknown keyword, with a suggestion from the known ones; any other error unchanged."""
    found = _UNEXPECTED.search(str(error))
    if found is None or found[1] not in keywords:
        return error
    parameters = signature(function).parameters.values()
    named = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
    own = [each.name for each in parameters if each.kind in named and each.name != "self"]
    if found[1] in own:
        return error
    # A function with **keywords passes them on to a function that has raised its own KeywordError.
    passed = getattr(error, "known", ()) if any(each.kind == Parameter.VAR_KEYWORD for each in parameters) else ()
    return KeywordError(function.__qualname__.removesuffix(".__init__"), found[1], (*own, *passed))

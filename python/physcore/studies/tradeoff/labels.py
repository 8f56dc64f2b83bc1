"""Labels of integrators and of methods of fluids, and solvers of contacts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from physcore.numerics.contacts import ContactSolver
from physcore.numerics.fluids import FluidMethod
from physcore.numerics.integrators import Integrator


def labels(integrators: Iterable[Integrator]) -> dict[Integrator, str]:
    """The label of each integrator: its name, with the parameters that differ in its class: XPBD(substeps=5)."""
    kinds: dict[type[Integrator], list[Integrator]] = {}
    for integrator in dict.fromkeys(integrators):
        kinds.setdefault(type(integrator), []).append(integrator)
    named = {}
    for kind, variants in kinds.items():
        given = [parameters(variant) for variant in variants]
        differing = [name for name in given[0] if any(values[name] != given[0][name] for values in given)]
        for variant, values in zip(variants, given, strict=True):
            text = ", ".join(f"{name}={values[name]!r}" for name in differing)
            named[variant] = f"{kind.__name__}({text})" if text else kind.__name__
    return named


def differences(method: FluidMethod | ContactSolver) -> str:
    """The label of a method of fluids or a solver of contacts, with all parameters that are not default:
    "WeaklyCompressible(shifting=6.0)".
    """
    default = {entry.name: entry.default for entry in fields(method)}
    other = [f"{name}={value}" for name, value in parameters(method).items() if value != default[name]]
    return f"{type(method).__name__}({', '.join(other)})"


def parameters(method: Integrator | FluidMethod | ContactSolver) -> dict[str, Any]:
    """The parameters of a method by name."""
    return {entry.name: getattr(method, entry.name) for entry in fields(method)}

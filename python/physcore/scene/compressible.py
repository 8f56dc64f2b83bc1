"""The numbers of a weakly compressible fluid's method, checked: `fluids=` has them, and Fluid had them before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from physcore.checks import is_word, number, shown, span, word
from physcore.errors import SceneError
from physcore.scene.kernels import KERNELS, Kernel


def _or_auto(check: Callable[[object, str], float], what: str) -> Callable[[object, str], float | Literal["auto"]]:
    """A check that lets "auto" pass."""

    def checked(value: object, path: str) -> float | Literal["auto"]:
        if is_word(value, "auto"):
            return "auto"
        if isinstance(value, str):
            raise SceneError(f"{path}: must be {what} or 'auto', got {shown(value)}")
        return check(value, path)

    return checked


def _coefficient(value: object, path: str) -> float:
    return number(value, path, least=0.0)


def _kernel(value: object, path: str) -> Kernel:
    if isinstance(value, KERNELS):
        return value
    known = ", ".join(f"{kind.__name__}()" for kind in KERNELS)
    missing = f"; write {value.__name__}()" if isinstance(value, type) else ""
    raise SceneError(f"{path}: must be one of {known}, got {shown(value)}{missing}")


def _density_from(value: object, path: str) -> str:
    return word(value, path, ("continuity", "summation"))


CHECKS: dict[str, Callable[[object, str], object]] = {
    "sound_speed": _or_auto(span, "a number of meters per second"),
    "kernel": _kernel,
    "artificial_viscosity": _or_auto(_coefficient, "a number"),
    "density_diffusion": _coefficient,
    "density_from": _density_from,
    "shifting": _or_auto(_coefficient, "a number"),
}
"""By the names of the arguments: what they must be, and a value and its path are given to."""

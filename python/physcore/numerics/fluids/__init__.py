"""Methods for fluids, one file each, and which of them computes which fluid of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from physcore.checks import is_word, shown
from physcore.errors import SceneError
from physcore.numerics.fluids.base import FluidMethod
from physcore.numerics.fluids.weakly_compressible import WeaklyCompressible
from physcore.scene.contents import BodyKey
from physcore.scene.scene import Scene
from physcore.spelling import did_you_mean

FLUID_METHODS: tuple[type[FluidMethod], ...] = (WeaklyCompressible,)
"""Every method; what is registered here can be saved."""

FLUID_METHODS_BY_NAME = {kind.__name__: kind for kind in FLUID_METHODS}
"""Methods by their names, by which they can be asked for."""

Fluids: TypeAlias = FluidMethod | str | Mapping[BodyKey, FluidMethod | str] | Mapping[str, FluidMethod]
"""One method for all fluids, or one for each; "auto": WeaklyCompressible()."""


def fluid_method(value: object, path: str) -> FluidMethod | None:
    """A method, or that of a name; None for "auto".

    Raises:
        SceneError: it is none.
    """
    if is_word(value, "auto"):
        return None
    kind = FLUID_METHODS_BY_NAME.get(value) if isinstance(value, str) else None
    method = value if kind is None else kind()
    if isinstance(method, FLUID_METHODS):
        return method
    known = ", ".join(f"{each.__name__}()" for each in FLUID_METHODS)
    hint = f"; write {value.__name__}()" if isinstance(value, type) else did_you_mean(value, FLUID_METHODS_BY_NAME)
    raise SceneError(f"{path}: must be one of {known}, its name, or 'auto', got {shown(value)}{hint}")


def fluid_methods(value: object, scene: Scene) -> dict[str, FluidMethod]:
    """The method of each fluid of a scene, by their paths.

    Raises:
        SceneError: something is no method or no fluid.
    """
    paths = [scene.path(fluid) for fluid in scene.fluids]
    given: dict[str, FluidMethod | None] = {}
    if isinstance(value, Mapping):
        for key, each in value.items():
            place = f"fluids[{shown(key)}]"
            given[_path(key, scene, paths, place)] = fluid_method(each, place)
    else:
        one = fluid_method(value, "fluids")
        if one is not None and not paths:
            raise SceneError("fluids: there is no Fluid in this scene")
        given = dict.fromkeys(paths, one)
    return {path: given.get(path) or WeaklyCompressible() for path in paths}


def check_flows(methods: Mapping[str, FluidMethod], scene: Scene) -> None:
    """Let each method look at the fluid that it is to compute, whose engine has been built.

    Warns:
        MachWarning, SceneWarning: as the methods say.
    """
    several = len(set(methods.values())) > 1
    for fluid in scene.fluids:
        path = scene.path(fluid)
        methods[path].check(fluid, f"fluids[{path}]" if several else "fluids", scene.units)


def _path(key: object, scene: Scene, paths: Sequence[str], place: str) -> str:
    """The path of a fluid that is given by itself, its index, its name or its path."""
    if isinstance(key, str) and key in paths:
        return key
    try:
        path = scene.path(scene.index(key))  # type: ignore[arg-type]
    except KeyError:
        path = ""
    if path not in paths:
        raise SceneError(f"{place}: is no Fluid of this scene, which has {', '.join(paths) or 'none'}")
    return path


__all__ = [
    "FLUID_METHODS",
    "FLUID_METHODS_BY_NAME",
    "FluidMethod",
    "Fluids",
    "WeaklyCompressible",
    "check_flows",
    "fluid_method",
    "fluid_methods",
]

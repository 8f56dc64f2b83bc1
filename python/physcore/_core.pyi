"""The extension module: the engine and the canvas, converted to Python and nothing more."""

from os import PathLike
from typing import Literal, TypedDict, final, type_check_only

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Canvas",
    "Gif",
    "Projection",
    "Sky",
    "Texture",
    "World",
    "advances",
    "arctan2",
    "available_memory",
    "convex_hull",
    "cos",
    "coverage",
    "exp",
    "heatmap",
    "log",
    "missing_signs",
    "norms",
    "points_inside",
    "power",
    "rigid_overlaps",
    "shape_properties",
    "sin",
    "spline_points",
    "text_width",
    "tint",
]

class _LimitRecord(TypedDict):
    dt: float
    kind: Literal["stability", "accuracy", "none"]
    term: str
    stability: float
    accuracy: float
    certified: float
    endured: float

@type_check_only
class StagesRecord(TypedDict):
    item: str
    stages: list[str]
    dimension: int
    precision: str
    integrator: str
    order: int
    evaluations: int
    pairs: int
    force_error: float
    limit_varies: bool
    layout: str
    left_out: list[str]
    notes: list[str]

class _PlanRecord(TypedDict):
    systems: list[StagesRecord]
    memory: int
    threads: int
    simd: str

_Course = tuple[float, float, int, float | None]
_Rgb = tuple[int, int, int]
_Ink = tuple[int, int, int, int]

def exp(x: NDArray[np.float64]) -> NDArray[np.float64]: ...
def log(x: NDArray[np.float64]) -> NDArray[np.float64]: ...
def sin(x: NDArray[np.float64]) -> NDArray[np.float64]: ...
def cos(x: NDArray[np.float64]) -> NDArray[np.float64]: ...
def arctan2(y: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]: ...
def power(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]: ...
def points_inside(
    record: dict[str, object],
    dimension: int,
    points: NDArray[np.float64],
    positions: NDArray[np.float64],
    orientations: NDArray[np.float64],
) -> NDArray[np.bool_]: ...
def shape_properties(
    record: dict[str, object], dimension: int
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]: ...
def rigid_overlaps(
    scene: dict[str, object], bodies: int, positions: NDArray[np.float64], turns: NDArray[np.float64]
) -> list[list[tuple[float, float, str, str]]]: ...
def available_memory() -> int | None: ...
def advances(kind: str, method: dict[str, object]) -> bool: ...

@final
class World:
    def __new__(
        cls,
        scene: dict[str, object],
        integrator: dict[str, object],
        integrators: dict[str, dict[str, object]],
        precision: str,
        threads: int | None,
        max_energy_growth: float,
        on_divergence: str,
    ) -> World: ...
    def step(self, n: int, dt: float) -> tuple[float, float, float] | None: ...
    def divide(self, dt: float) -> None: ...
    def substep(self, dt: float) -> tuple[list[tuple[int, float]], BaseException | None]: ...
    def run(
        self, course: _Course, steps: int, safety: float, free: float, tolerance: float | None
    ) -> tuple[_Course | None, tuple[float, float, float] | None]: ...
    def adaptation(self) -> tuple[int, int, float, float]: ...
    @property
    def time(self) -> float: ...
    @property
    def steps(self) -> int: ...
    @property
    def dt(self) -> float: ...
    def fields(self) -> list[tuple[str, str, str, list[int], str | None, bool]]: ...
    def read(self, name: str) -> NDArray[np.float64]: ...
    def write(self, fields: dict[str, NDArray[np.float64]]) -> None: ...
    def budgets(
        self,
    ) -> tuple[
        list[tuple[str, str, float]],
        list[tuple[str, str, float, list[tuple[str, float]], list[tuple[str, float]]]],
    ]: ...
    def momentum(self) -> NDArray[np.float64]: ...
    def angular_momentum(self) -> NDArray[np.float64]: ...
    def limit(self) -> _LimitRecord: ...
    def certified(self) -> float: ...
    def present_limit(self) -> _LimitRecord: ...
    def plan(self) -> _PlanRecord: ...
    def capture(self) -> dict[str, NDArray[np.generic]]: ...
    def restore(self, state: dict[str, NDArray[np.generic]]) -> None: ...
    def state_hash(self) -> str: ...
    def sample(
        self, field: str, points: NDArray[np.float64], on: int | None, time: float | None = None
    ) -> NDArray[np.float64]: ...

@final
class Canvas:
    def __new__(cls, width: int, height: int, background: _Rgb, samples: int = 1) -> Canvas: ...
    def clear(self) -> None: ...
    def keep(self) -> None: ...
    def clip(self, left: int, top: int, right: int, bottom: int) -> None: ...
    def discs(
        self,
        centers: NDArray[np.float32],
        radii: NDArray[np.float32],
        colors: NDArray[np.uint8],
        depths: NDArray[np.float32] | None = None,
        shading: float = 0.0,
    ) -> None: ...
    def lines(
        self,
        ends: NDArray[np.float32],
        widths: NDArray[np.float32],
        colors: NDArray[np.uint8],
        depths: NDArray[np.float32] | None = None,
    ) -> None: ...
    def triangles(
        self,
        corners: NDArray[np.float32],
        colors: NDArray[np.uint8],
        depths: NDArray[np.float32] | None = None,
        texture: Texture | None = None,
        places: NDArray[np.float32] | None = None,
        weave: NDArray[np.float32] | None = None,
    ) -> None: ...
    def halos(
        self,
        centers: NDArray[np.float32],
        radii: NDArray[np.float32],
        colors: NDArray[np.uint8],
        depths: NDArray[np.float32] | None = None,
        shadow: bool = False,
    ) -> None: ...
    def liquid(
        self,
        centers: NDArray[np.float32],
        radii: NDArray[np.float32],
        colors: NDArray[np.uint8],
        sky: Sky,
        depths: NDArray[np.float32] | None = None,
        scale: float = 0.0,
        glow: float = 0.0,
    ) -> None: ...
    def trails(
        self,
        past: NDArray[np.float32],
        widths: NDArray[np.float32],
        colors: NDArray[np.uint8],
        fade: tuple[_Rgb, float] | None = None,
        gaps: NDArray[np.bool_] | None = None,
        depths: NDArray[np.float32] | None = None,
    ) -> None: ...
    def lens(self, blur: float, distance: float) -> None: ...
    def eye(self, scale: float, middle: tuple[float, float], distance: float) -> None: ...
    def light(self, lamp: tuple[float, float, float], shadow: float, occlusion: float, reach: float) -> None: ...
    def ground(
        self,
        normal: tuple[float, float, float],
        center: tuple[float, float, float],
        size: float,
        color: _Rgb,
        along: tuple[float, float, float],
        grid: tuple[_Rgb, float, float] | None = None,
        part: tuple[list[tuple[float, float]], float] | None = None,
    ) -> None: ...
    def backdrop(self, center: tuple[float, float], radius: float, color: _Rgb, share: float) -> None: ...
    def paint(self) -> None: ...
    def polygon(self, corners: NDArray[np.float32], color: _Ink) -> None: ...
    def picture(self, pixels: NDArray[np.uint8], left: int, top: int) -> None: ...
    def density(
        self, points: NDArray[np.float32], table: NDArray[np.uint8], strength: float, spread: float
    ) -> None: ...
    def starlight(
        self,
        points: NDArray[np.float32],
        colors: NDArray[np.uint8],
        strength: float,
        spread: float,
        shadow: bool,
    ) -> None: ...
    def text(self, text: str, x: int, y: int, height: int, color: _Ink, align: int) -> None: ...
    def pixels(self) -> NDArray[np.uint8]: ...

@final
class Sky:
    def __new__(cls, horizon: _Rgb, zenith: _Rgb, up: tuple[float, float, float], brightness: float) -> Sky: ...
    @property
    def horizon(self) -> _Rgb: ...
    @property
    def zenith(self) -> _Rgb: ...
    @property
    def up(self) -> tuple[float, float, float]: ...
    @property
    def brightness(self) -> float: ...
    def reflected(
        self,
        colors: NDArray[np.float64],
        normals: NDArray[np.float64],
        places: NDArray[np.float64],
        distance: float,
    ) -> NDArray[np.float64]: ...

@final
class Texture:
    def __new__(cls, pixels: NDArray[np.uint8]) -> Texture: ...

@final
class Projection:
    def __new__(
        cls,
        axes: list[list[float]],
        center: list[float],
        scale: float,
        middle: tuple[float, float],
        distance: float,
    ) -> Projection: ...
    def project(
        self, points: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]: ...

def norms(vectors: NDArray[np.float64]) -> NDArray[np.float64]: ...
def tint(
    values: NDArray[np.float64],
    ends: tuple[float, float],
    table: NDArray[np.float64],
    background: _Rgb,
    depths: NDArray[np.float32] | None = None,
    fog: tuple[float, float] | None = None,
) -> NDArray[np.uint8]: ...

@final
class Gif:
    def __new__(
        cls,
        path: str | PathLike[str] | None,
        reserved: list[_Rgb],
        *,
        colors: int = 255,
    ) -> Gif: ...
    def observe(self, canvas: Canvas) -> None: ...
    def include(self, colors: list[_Rgb]) -> None: ...
    def frame(self, canvas: Canvas, delay: int) -> None: ...
    def tolerate(self, tolerance: float) -> None: ...
    def comment(self, text: str) -> None: ...
    def written(self) -> int: ...
    def finish(self) -> bytes | None: ...
    def close(self) -> None: ...

def convex_hull(points: NDArray[np.float64]) -> list[NDArray[np.int64]]: ...
def spline_points(points: NDArray[np.float64], closed: bool, parts: int) -> NDArray[np.float64]: ...
def text_width(text: str, height: int) -> int: ...
def missing_signs(text: str) -> str: ...
def coverage(
    mask: NDArray[np.float64], size: tuple[int, int], corner: tuple[float, float], step: float
) -> NDArray[np.uint8]: ...
def heatmap(
    values: NDArray[np.float64],
    size: tuple[int, int],
    corner: tuple[float, float],
    step: float,
    table: NDArray[np.uint8],
    ends: tuple[float, float],
    walls: tuple[NDArray[np.uint8], _Rgb] | None = None,
    isolines: tuple[float, _Ink] | None = None,
    relief: float = 0.0,
) -> NDArray[np.uint8]: ...

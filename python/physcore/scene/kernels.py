"""Smoothing kernels of fluids."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.checks import number

NARROWEST, WIDEST = 0.6, 4.0
"""Range of the smoothing. The support of 2h must reach the next particle; the cost grows with its particles."""


# To add a kernel: a class here, a line in `KERNELS`, and its counterpart in Rust.
@dataclass(frozen=True)
class Kernel:
    """Smoothing kernel: a weight W(q) of the distance r = q h, zero from q = 2 on.

        kernel = pc.WendlandC4()  # a Kernel
        method = pc.WeaklyCompressible(kernel=kernel)

    Kernels of the same class with equal smoothing are equal.
    """

    smoothing: float
    """Smoothing length h over the spacing of the particles; the support is 2h."""

    def __post_init__(self) -> None:
        path = f"{type(self).__name__}.smoothing"
        object.__setattr__(self, "smoothing", number(self.smoothing, path, least=NARROWEST, most=WIDEST))


@dataclass(frozen=True)
class WendlandC2(Kernel):
    """Wendland C2 kernel, W(q) = α (1 − q/2)⁴ (1 + 2q), with α = 7/(4π h²) in 2D and 21/(16π h³) in 3D.

        method = pc.WeaklyCompressible(kernel=pc.WendlandC2())

    The Fourier transform of the kernel is positive, so that particles do not form pairs.

    Args:
        smoothing: the smoothing length h over the spacing, from 0.6 to 4; the support is 2h.

    Raises:
        SceneError: `smoothing` is out of range.

    Source: H. Wendland, Adv. Comput. Math. 4, 389 (1995); W. Dehnen, H. Aly, MNRAS 425, 1068 (2012).
    """

    smoothing: float = 1.5


@dataclass(frozen=True)
class WendlandC4(Kernel):
    """Wendland C4 kernel, W(q) = α (1 − q/2)⁶ (1 + 3q + 35/12 q²), with α = 9/(4π h²) in 2D, 495/(256π h³) in 3D.

        method = pc.WeaklyCompressible(kernel=pc.WendlandC4())

    This kernel is smoother than WendlandC2, and suited to more neighbors.

    Args:
        smoothing: the smoothing length h over the spacing, from 0.6 to 4; the support is 2h.

    Raises:
        SceneError: `smoothing` is out of range.

    Source: H. Wendland, Adv. Comput. Math. 4, 389 (1995); W. Dehnen, H. Aly, MNRAS 425, 1068 (2012).
    """

    smoothing: float = 1.5


@dataclass(frozen=True)
class CubicSpline(Kernel):
    """Cubic spline kernel, W(q) = α (1 − 3/2 q² + 3/4 q³) up to q = 1, then α (2 − q)³/4.

        method = pc.WeaklyCompressible(kernel=pc.CubicSpline())

    The factor is α = 10/(7π h²) in 2D and 1/(π h³) in 3D. This is the classical kernel. Particles form pairs if the
    smoothing is large.

    Args:
        smoothing: the smoothing length h over the spacing, from 0.6 to 4; the support is 2h.

    Raises:
        SceneError: `smoothing` is out of range.

    Source: J. J. Monaghan, J. C. Lattanzio, Astron. Astrophys. 149, 135 (1985).
    """

    smoothing: float = 1.5


KERNELS: tuple[type[Kernel], ...] = (
    WendlandC2,
    WendlandC4,
    CubicSpline,
)
"""All kernels. Those registered here can be saved and are tested."""

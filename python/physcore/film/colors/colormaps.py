"""Perceptually uniform color maps, suited to color-blind readers and to print.

Viridis, inferno, plasma and magma are by Stéfan van der Walt, Nathaniel Smith and Eric Firing (2015), released under
CC0. Every eighth color of the original is stored; linear interpolation between them is within 3.1/255 of the original.
Cividis by Jamie Nuñez, Christopher Anderton and Ryan Renslow (PLoS ONE 13 (7), e0199239, 2018) is stored likewise,
within 5.6/255. Cividis looks nearly the same to the color-blind. Water (from deep blue to white foam) and ember (from
dark red over orange to yellow) are physcore's own. Their lightness in Oklab is linear (B. Ottosson, "A perceptual color
space for image processing", 2020).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from physcore.checks import FloatArray, shown
from physcore.errors import SceneError

ColormapName: TypeAlias = Literal["viridis", "inferno", "plasma", "magma", "cividis", "water", "ember"] | str
"""Name of one of physcore's own maps, or of a map of Matplotlib if that is installed. "coolwarm" and "RdBu_r" are
diverging maps, "twilight" is cyclic.
"""

COLORMAPS: dict[str, str] = {
    "viridis": (
        "440154 470d60 48186a 482475 472e7c 453882 424186 3e4c8a 3a548c 365d8d 32658e 2e6d8e "
        "2b758e 287d8e 25848e 228c8d 1f948c 1e9c89 20a386 25ab82 2eb37c 3aba76 48c16e 58c765 "
        "69cd5b 7fd34e 93d741 a8db34 bddf26 d5e21a eae51a fde725"
    ),
    "inferno": (
        "000004 040312 0b0724 160b39 230c4c 310a5c 3e0966 4d0d6c 5a116e 67166e 741a6e 801f6c "
        "8f2469 9b2964 a82e5f b43359 c13a50 cc4248 d74b3f e05536 e9612b ef6e21 f57b17 f8890c "
        "fb9706 fca80d fbb81d f9c72f f6d746 f2e865 f3f586 fcffa4"
    ),
    "plasma": (
        "0d0887 220690 310597 41049d 4e02a2 5b01a5 6700a8 7501a8 8104a7 8d0ba5 9814a0 a21d9a "
        "ad2793 b6308b bf3984 c7427c cf4c74 d6556d dd5e66 e3685f e97257 ef7c51 f3874a f79143 "
        "fa9c3c fca934 fdb52e fdc229 fcce25 f9dd25 f5eb27 f0f921"
    ),
    "magma": (
        "000004 030312 0a0822 140e36 1e1149 2a115c 38106c 471078 54137d 601880 6d1d81 792282 "
        "882781 942c80 a1307e ae347b bd3977 ca3e72 d6456c e24d66 ec5860 f3655c f8745c fb835f "
        "fd9266 fea36f feb27a fec185 fecf92 fde0a1 fceeb0 fcfdbf"
    ),
    "cividis": (
        "00224e 00285b 002e6a 083370 1c396f 293f6e 33446d 3d4a6c 45506c 4d556c 555b6d 5c616e "
        "646770 6b6d72 727274 787877 807f78 888578 908b78 979177 a09875 a89e73 b0a571 b9ab6d "
        "c1b26a cbb965 d3c05f dcc859 e5cf52 efd748 f8df3c fee838"
    ),
    "water": (
        "0a2a81 0b3088 0c3790 0e3d98 0f44a0 114aa8 1251b0 1658b7 1a5fbe 1f66c4 236dcb 2774d1 "
        "227cd7 2085da 238ddd 2895e0 2e9de2 36a5e4 3fade6 4ab5e8 58bce8 65c3e9 73c9ea 82d0eb "
        "8fd6ed 9ddcee ace2f0 bae7f2 c8edf5 d6f2f7 e4f8fa f1fdfe"
    ),
    "ember": (
        "4f0910 5a0911 640911 6f0811 7a0610 86040e 91020a 9a090a a4130b ad1b0c b6220d bf290c "
        "c83100 d03b00 d64600 dc5000 e25a00 e86400 ed6e03 f3780b f98112 fe8a19 ff941d ff9f1d "
        "ffaa20 ffb52b ffc245 ffce5b ffd96f ffe482 ffee95 fff7a8"
    ),
}
DARK_SIDES = ("1b6fd0 58c4f6 dcf7ff", "c8501f f7a94a fff1cf")
LIGHT_SIDES = ("7fb8e6 2a78c0 0b2f6b", "f2a58a cf4a32 6e0f1a")
"""Colors of diverging maps: from a dark background to light colors, and from a light background to dark colors."""
FINE = 4096
"""Number of colors of a table made by `spread`."""
STEPS = 256
LUMA = np.array([0.2126, 0.7152, 0.0722])
"""Weights of red, green and blue in the luma (Rec. 709)."""
DARKEST = 0.26
"""Least lightness in Oklab of a part of a map. Darker colors would not be visible on a dark background."""
WHOLE = (0.0, 1.0)
"""The part that is a whole map."""
STRAY = 0.5
"""Tolerance of the test for monotonic lightness: change of luma between neighbors among 256 colors, out of 255."""


def ramp(name: object, default: str, part: tuple[float, float], path: str) -> FloatArray:
    """256 colors (256, 3) of a whole map, as Matplotlib shows it; without a name, of a part of the default map.

    Raises:
        SceneError: as `sequential`.
    """
    return sequential(default, part, path) if name is None else sequential(name, WHOLE, path)


def sequential(name: object, part: tuple[float, float], path: str) -> FloatArray:
    """256 colors (256, 3) of the part of a map between two fractions of its way from dark to light.

    If the part begins above 0, fractions count from the color whose lightness is DARKEST. All maps thus begin with
    about the same lightness. Maps without a monotonic lightness, diverging and cyclic ones, are returned completely.

    Raises:
        SceneError: there is no such map, or it is a map of Matplotlib, which is not installed.
    """
    if isinstance(name, str) and name in COLORMAPS:
        own: list[tuple[float, ...]] = [tuple(bytes.fromhex(entry)) for entry in COLORMAPS[name].split()]
        return _between(own, _visible(own, part))
    colors = _of_matplotlib(name, path)
    change = np.diff(colors @ LUMA)
    if (change > -STRAY).all():
        return _between(colors, _visible(colors, part))
    if (change < STRAY).all():
        return _between(colors[::-1], _visible(colors[::-1], part))[::-1]
    return _between(colors, (0.0, 1.0))


def _visible(colors: Sequence[tuple[float, ...]], part: tuple[float, float]) -> tuple[float, float]:
    """Convert fractions of the way from DARKEST to the end of a map to fractions of the whole map."""
    black = np.interp(DARKEST, oklab(np.array(colors, dtype=float))[:, 0], np.linspace(0.0, 1.0, len(colors)))
    low, high = (float(black + (1.0 - black) * fraction) for fraction in part)
    return low if part[0] > 0.0 else 0.0, high


def _of_matplotlib(name: object, path: str) -> list[tuple[float, ...]]:
    """256 colors of a map of Matplotlib."""
    own = ", ".join(map(repr, COLORMAPS))
    try:
        import matplotlib
    except ImportError:
        raise SceneError(
            f"{path}: must be one of {own}, got {shown(name)}; for the names that Matplotlib knows: "
            "pip install 'physcore[plot]'"
        ) from None
    if not isinstance(name, str) or name not in matplotlib.colormaps:
        raise SceneError(f"{path}: must be one of {own}, or a name that Matplotlib knows, got {shown(name)}")
    colors = 255.0 * matplotlib.colormaps[name](np.linspace(0.0, 1.0, STEPS))[:, :3]
    return [tuple(color) for color in colors.tolist()]


LIGHTNESS, HUE = 0.075, 0.16
"""Largest change of lightness in Oklab, and of hue [rad], of the shades of a color."""


def diverging(low: tuple[int, int, int], middle: tuple[int, int, int], high: tuple[int, int, int]) -> FloatArray:
    """256 colors (256, 3) of a diverging map, from one color over a neutral one to another."""
    return _between([low, middle, high], (0.0, 1.0))


def _between(colors: Sequence[tuple[float, ...]], part: tuple[float, float]) -> FloatArray:
    points = np.linspace(*part, STEPS) * (len(colors) - 1)
    known = np.array(colors, dtype=float)
    return np.stack([np.interp(points, np.arange(len(colors)), channel) for channel in known.T], axis=1)


def look_up(table: FloatArray, fraction: FloatArray) -> FloatArray:
    """The colors (N, 3) of a table at fractions (N,) of its length; fractions beyond its ends give the end colors."""
    with np.errstate(invalid="ignore"):  # NaN gives the first color
        index = np.clip(np.nan_to_num(fraction) * STEPS, 0, STEPS - 1).astype(np.intp)
    return table[index]


def two_sided(background: tuple[int, int, int]) -> FloatArray:
    """256 colors (256, 3) of a diverging map, from a cold color over the background to a warm one.

    The cold side is for values below zero, the warm side for values above. The lightness goes from that of the
    background as far as possible, alike on both sides and linearly in Oklab. Values of equal magnitude therefore look
    equally strong. On a light background the colors become darker.
    """
    light = float(np.array(background) @ LUMA) > 127.0
    cold, warm = LIGHT_SIDES if light else DARK_SIDES
    middle = oklab(np.array([background], dtype=float))[0]
    sides = []
    for stops in (cold, warm):
        colors = oklab(np.array([tuple(bytes.fromhex(stop)) for stop in stops.split()], dtype=float))
        points, fractions = np.vstack([middle, colors]), np.linspace(0.0, 1.0, STEPS // 2)
        places = np.linspace(0.0, 1.0, len(points))
        sides.append(np.stack([np.interp(fractions, places, channel) for channel in points.T], axis=1))
    return _srgb(np.concatenate([sides[0][::-1], sides[1]]))


def spread(table: FloatArray, exponent: float, *, middle: bool) -> FloatArray:
    """A finer table (4096, 3), in which colors follow a power of the distance from the start, or from the middle."""
    places = (np.arange(FINE) + 0.5) / FINE
    if middle:
        signed = 2.0 * places - 1.0
        places = 0.5 + 0.5 * np.sign(signed) * np.abs(signed) ** exponent
    else:
        places = places**exponent
    known = (np.arange(len(table)) + 0.5) / len(table)
    return np.stack([np.interp(places, known, channel) for channel in table.T], axis=1)


_TO_LMS = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)  # fmt: skip
_TO_LAB = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip


def oklab(colors: FloatArray) -> FloatArray:
    """Oklab coordinates (N, 3), lightness and two opponent colors, of sRGB colors (N, 3) from 0 to 255."""
    fractions = colors / 255.0
    linear = np.where(fractions <= 0.04045, fractions / 12.92, ((fractions + 0.055) / 1.055) ** 2.4)
    lab: FloatArray = np.cbrt(linear @ _TO_LMS.T) @ _TO_LAB.T
    return lab


def varied(colors: FloatArray, shade: FloatArray) -> FloatArray:
    """Shades (N, 3) of colors (N, 3): lighter or darker, and warmer or colder, by amounts (N,) from −1 to 1."""
    lab = oklab(colors)
    turn = HUE * shade
    cosine, sine = np.cos(turn), np.sin(turn)
    lightness = np.clip(lab[:, 0] + LIGHTNESS * shade, 0.0, 1.0)
    return _srgb(
        np.stack([lightness, cosine * lab[:, 1] - sine * lab[:, 2], sine * lab[:, 1] + cosine * lab[:, 2]], axis=1)
    )


def _srgb(lab: FloatArray) -> FloatArray:
    """The inverse of `oklab`, clipped to the range of sRGB."""
    linear = np.clip((lab @ np.linalg.inv(_TO_LAB).T) ** 3 @ np.linalg.inv(_TO_LMS).T, 0.0, 1.0)
    fractions = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    colors: FloatArray = 255.0 * fractions
    return colors

"""Color themes of a film."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Literal, TypeAlias

from physcore.checks import items, number, shown
from physcore.errors import SceneError

Color: TypeAlias = tuple[int, int, int]
"""Red, green and blue in sRGB, each from 0 to 255."""

ThemeName = Literal["dark", "light"]

LEGIBLE = 4.5
"""Least contrast of text against its background, from the Web Content Accessibility Guidelines, level AA."""


def color(value: object, path: str) -> Color:
    """A color from three numbers 0–255, a string like "#10c0ff" or a name of CSS, such as "tomato".

    Raises:
        SceneError: the value is none of them.
    """
    if isinstance(value, str):
        from PIL import ImageColor

        try:
            channels = ImageColor.getrgb(value)
        except ValueError:
            pass
        else:
            if len(channels) == 3:  # a color with transparency has a fourth
                return channels
    if isinstance(value, (tuple, list)) and len(value) == 3:
        red, green, blue = value
        if all(isinstance(channel, int) and 0 <= channel <= 255 for channel in value):
            return (red, green, blue)
    raise SceneError(f"{path}: must be like '#10c0ff', 'tomato' or (16, 192, 255), got {shown(value)}")


@dataclass(frozen=True)
class Theme:
    """Color theme of a film. Colors that must be distinguished differ in lightness too.

        from dataclasses import replace
        night = replace(pc.DARK, background=(0, 0, 0))  # a Theme; pc.LIGHT is the other one
        pc.film(recording, "cloth.png", theme=night)

    DARK and LIGHT are the two predefined themes; `film` takes a theme as `theme=`.
    """

    background: Color
    surface: Color
    """The color of solid ground."""
    edge: Color
    """The color of the outlines of boundaries."""
    solid: Color
    """The color of solid balls."""
    text: Color
    """The color of titles, and of particles that are held in place."""
    label: Color
    """The color of the time."""
    compressed: Color
    relaxed: Color
    stretched: Color
    bodies: tuple[Color, ...]
    """Colors of the bodies, in turn; distinguishable for the color-blind."""
    part: tuple[float, float]
    """The part of a color map that contrasts with the background, as fractions of its length."""
    backdrop: Color | None = None
    """The background of 3D pictures in the middle, behind solid objects; None: a uniform background."""

    def __post_init__(self) -> None:
        names = [entry.name for entry in fields(self) if entry.name not in ("bodies", "part", "backdrop")]
        values: dict[str, object] = {name: color(getattr(self, name), f"Theme.{name}") for name in names}
        if self.backdrop is not None:
            values["backdrop"] = color(self.backdrop, "Theme.backdrop")
        bodies = items(self.bodies, "Theme.bodies", "colors")
        if not bodies:
            raise SceneError("Theme.bodies: must have at least one color")
        values["bodies"] = tuple(color(each, f"Theme.bodies[{index}]") for index, each in enumerate(bodies))
        part = items(self.part, "Theme.part", "two fractions")
        values["part"] = tuple(number(each, "Theme.part", least=0.0, most=1.0) for each in part)
        if len(part) != 2:
            raise SceneError(f"Theme.part: must be two fractions, got {shown(self.part)}")
        for name, value in values.items():
            object.__setattr__(self, name, value)


DARK = Theme(
    background=(17, 20, 27),
    surface=(66, 75, 92),
    edge=(112, 124, 145),
    solid=(134, 152, 184),
    text=(236, 239, 244),
    label=(148, 158, 174),
    compressed=(45, 140, 255),
    relaxed=(226, 230, 236),
    stretched=(255, 76, 56),
    # After Okabe and Ito, "Color Universal Design" (2008), lightened for a dark ground.
    bodies=((86, 180, 233), (240, 170, 40), (40, 190, 140), (232, 116, 60), (222, 140, 190), (240, 228, 66)),
    part=(0.36, 1.0),
    backdrop=(51, 59, 73),
)
"""Theme for projectors and screens: light colors on a dark background."""

LIGHT = Theme(
    background=(252, 252, 250),
    surface=(236, 237, 239),
    edge=(140, 148, 160),
    solid=(186, 197, 214),
    text=(24, 29, 38),
    label=(96, 106, 122),
    compressed=(0, 92, 220),
    relaxed=(186, 191, 200),
    stretched=(214, 34, 20),
    # Okabe and Ito, "Color Universal Design" (2008).
    bodies=((0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (180, 130, 0), (86, 180, 233)),
    part=(0.18, 0.88),
    backdrop=(242, 243, 244),
)
"""Theme for documents: dark colors on a white background."""

THEMES: dict[str, Theme] = {"dark": DARK, "light": LIGHT}


def resolve(theme: object) -> Theme:
    """The theme with a name, or a Theme unchanged.

    Raises:
        SceneError: there is no such theme.
    """
    if isinstance(theme, Theme):
        return theme
    if isinstance(theme, str) and theme in THEMES:
        return THEMES[theme]
    raise SceneError(f"theme: must be one of {', '.join(map(repr, THEMES))} or a Theme, got {shown(theme)}")


def chosen_theme(theme: object, background: object) -> Theme:
    """The theme with a name, or a Theme; with another background if one is given.

    Raises:
        SceneError: there is no such theme, or the background is no color.
    """
    chosen = resolve(theme)
    if background is None:
        return chosen
    return legible(replace(chosen, background=color(background, "background"), backdrop=None))


def mixed(one: Color, other: Color, share: float) -> Color:
    """The color between two others, with the given share of the second."""
    red, green, blue = (round(p + (q - p) * share) for p, q in zip(one, other, strict=True))
    return (red, green, blue)


def contrast(first: Color, second: Color) -> float:
    """Contrast ratio of two colors, from 1 to 21: the ratio of their luminances, each plus 0.05.

    Source: Web Content Accessibility Guidelines 2.2 (W3C, 2023), "contrast ratio" and "relative luminance".
    """
    lighter, darker = sorted((_luminance(first), _luminance(second)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def legible(theme: Theme) -> Theme:
    """The theme with its text and label moved toward white or black until their contrast is legible.

    A contrast of LEGIBLE is always reached: white or black has a contrast of at least √21 = 4.58 with any color.
    """
    ends: tuple[Color, Color] = ((255, 255, 255), (0, 0, 0))
    toward = max(ends, key=lambda end: contrast(end, theme.background))
    return replace(theme, text=_moved(theme.text, toward, theme), label=_moved(theme.label, toward, theme))


def _moved(color: Color, toward: Color, theme: Theme) -> Color:
    """The nearest legible color on the way to another one."""
    for step in range(17):
        moved = mixed(color, toward, step / 16)
        if contrast(moved, theme.background) >= LEGIBLE:
            break
    return moved


def _luminance(color: Color) -> float:
    """The relative luminance, from 0 to 1."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (value / 255 for value in color)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

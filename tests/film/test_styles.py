"""What styles draw is where, as large and as bright as what it shows."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageColor

import physcore as pc
from physcore.film import DARK, LIGHT, Orbit, Window
from physcore.film.assignment import shown
from physcore.film.camera.view import Face, View, fit
from physcore.film.colors.colormaps import LUMA, two_sided
from physcore.film.resampling import cubic
from physcore.film.styles import fields
from physcore.film.styles.base import Part
from physcore.film.styles.curve import Curve
from physcore.simulation.sources import Recorded, SourceFrame, sources

SIZE = (240, 180)


def still(scene: pc.Scene, path: Path, velocities: np.ndarray | None = None, **options: Any) -> np.ndarray:
    """One frame of a scene as it begins, as a picture (H, W, 3)."""
    positions = np.concatenate([body.positions for body in scene.bodies])[np.newaxis]
    moving = np.zeros_like(positions) if velocities is None else velocities[np.newaxis]
    channels = {"positions": positions, "velocities": moving}
    recording: Any = SimpleNamespace(
        scene=scene, times=np.zeros(1), positions=positions, velocities=moving, fps=30.0, channels=channels
    )
    pc.film(recording, path / "still.png", **{"size": SIZE, **options})
    with Image.open(path / "still.png") as image:
        return np.asarray(image.convert("RGB")).astype(float)


def part(scene: pc.Scene) -> list[Part]:
    """Every body of a scene."""
    return [Part(body, scene.slice(body)) for body in scene.bodies]


def view(lower: tuple[float, float], upper: tuple[float, float]) -> View:
    """A view of a part of the plane."""
    return fit(Window(lower, upper), np.array(lower), np.array(upper), (0, 0, *SIZE), 0.0)


def frame(positions: np.ndarray, velocities: np.ndarray) -> SourceFrame:
    """One time of a recording."""
    recording: Any = SimpleNamespace(
        scene=None, times=np.zeros(1), positions=positions[np.newaxis], fps=30.0,
        channels={"positions": positions[np.newaxis], "velocities": velocities[np.newaxis]},
    )  # fmt: skip
    return next(Recorded(recording).frames())


class Sheet:
    """A canvas that remembers what it was told to draw."""

    def __init__(self) -> None:
        self.drawn: dict[str, tuple[Any, ...]] = {}

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments: self.drawn.__setitem__(name, arguments)


def brightness(picture: np.ndarray) -> float:
    """How much brighter a picture is than its background, summed over all pixels."""
    return float((picture - np.array(DARK.background)).sum())


@pytest.mark.parametrize("shape", [(4, 5, 6), (2, 2, 2), (3, 2, 4)])
def test_the_faces_of_a_block_close_it_and_look_outward(shape: tuple[int, int, int]) -> None:
    """Each edge belongs to two triangles, in opposite directions, and the signed volume (Gauss's theorem) is that of
    the block: six times it is a sum of integers times the cube of the spacing, exact but for the rounding of 0.5.
    """
    block = pc.soft_body(shape, 0.5, 100.0, origin=(1.0, -2.0, 3.0))
    edges = np.concatenate([block.faces[:, [i, (i + 1) % 3]] for i in range(3)])
    there = {tuple(edge) for edge in edges.tolist()}
    assert len(there) == len(edges)
    assert all((second, first) in there for first, second in there)
    a, b, c = (block.positions[block.faces[:, corner]] for corner in range(3))
    volume = np.einsum("td,td->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(0.125 * np.prod(np.array(shape) - 1), rel=1e-12)


def test_the_faces_of_a_cloth_cover_it_once() -> None:
    cloth = pc.cloth((7, 5), 0.25, 100.0)
    a, b, c = (cloth.positions[cloth.faces[:, corner]] for corner in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    areas = 0.5 * (ux * vy - uy * vx)
    assert (areas == 0.5 * 0.25**2).all()
    assert len(areas) == 2 * 6 * 4


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1]], "SpringNetwork.faces: must be integers of shape (M, 3)"),
        ([[0, 1, 9]], "SpringNetwork.faces[0, 2]: index 9 is outside of the 4 particles"),
        ([[0, 1, 2], [1, 3, 1]], "SpringNetwork.faces[1]: connects particle 1 with itself"),
    ],
)
def test_faces_that_make_no_sense_are_refused(faces: list[list[int]], message: str) -> None:
    with pytest.raises(pc.SceneError, match=r"SpringNetwork\.faces") as caught:
        pc.SpringNetwork(np.random.default_rng(1).uniform(size=(4, 2)), [[0, 1]], 1.0, faces=faces)
    assert message in str(caught.value)


def test_faces_are_saved_with_the_scene(tmp_path: Path) -> None:
    cloth = pc.cloth((3, 4), 0.1, 1.0)
    pc.Simulation(pc.Scene(cloth), dt=1e-3).save(tmp_path / "cloth.npz")
    loaded = pc.load(tmp_path / "cloth.npz").scene.bodies[0]
    assert (loaded.faces == cloth.faces).all()


def test_a_surface_covers_its_area(tmp_path: Path) -> None:
    """A cloth of 2 m × 1 m in a window 4 m × 3 m, 60 pixels per meter: 120 × 60 pixels, and at most half a pixel more
    along its rim, because triangles are drawn half a pixel larger than they are.
    """
    scene = pc.Scene(pc.cloth((9, 5), 0.25, 1.0, origin=(1.0, 1.0)))
    plain = {"camera": Window((0.0, 0.0), (4.0, 3.0)), "labels": (), "color_bar": False}
    picture = still(scene, tmp_path, style=pc.styles.Surface(color="#ffffff"), **plain)
    covered = brightness(picture) / float((255.0 - np.array(DARK.background)).sum())
    assert 120 * 60 <= covered <= 121.1 * 61.1


def test_a_texture_lies_on_its_body_upright(tmp_path: Path) -> None:
    """Seen from the front and from above, the picture's upper left is where it is in the picture."""
    texture = np.zeros((2, 2, 3), dtype=np.uint8)
    texture[0, 0], texture[0, 1], texture[1, 0], texture[1, 1] = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0)
    bodies = {
        "flat": (pc.cloth((9, 9), 0.1, 1.0), None),
        "upright": (pc.cloth((9, 9), 0.1, 1.0, axes=((1, 0, 0), (0, 0, 1))), Orbit(azimuth=-90.0, elevation=0.0)),
        "lying": (pc.cloth((9, 9), 0.1, 1.0, axes=((1, 0, 0), (0, 1, 0))), Orbit(azimuth=-90.0, elevation=89.0)),
    }
    for body, camera in bodies.values():
        picture = still(pc.Scene(body), tmp_path, style=pc.styles.Surface(texture=texture), camera=camera, labels=())
        inked = np.argwhere(np.abs(picture - np.array(DARK.background)).max(axis=2) > 30)
        (top, left), (bottom, right) = inked.min(axis=0), inked.max(axis=0)
        assert picture[top + 8, left + 8].argmax() == 0
        assert picture[top + 8, right - 8].argmax() == 1
        assert picture[bottom - 8, left + 8].argmax() == 2
        red, green, blue = picture[bottom - 8, right - 8]
        assert min(red, green) > 2 * blue


@pytest.mark.parametrize("texture", [np.zeros((4, 4)), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), dtype=np.uint8)])
def test_a_texture_is_bytes_of_three_colors(texture: np.ndarray) -> None:
    with pytest.raises(pc.SceneError, match=r"Surface\.texture: must be a path or bytes of shape \(H, W, 3\)"):
        pc.styles.Surface(texture=texture)


def test_a_texture_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    (tmp_path / "text.png").write_text("no picture")
    for name in ("text.png", "missing.png"):
        with pytest.raises(pc.FileError, match=rf"Surface\.texture: .*{name}: cannot be read"):
            pc.styles.Surface(texture=tmp_path / name)


def test_what_has_no_surface_is_refused_as_one(tmp_path: Path) -> None:
    rope = pc.rope(5, 1.0, 10.0)
    with pytest.raises(pc.SceneError, match=r"Surface\.on: .* has no faces"):
        still(pc.Scene(rope), tmp_path, style=pc.styles.Surface(on=rope))


def test_light_comes_from_the_upper_left_and_the_back_is_darker(tmp_path: Path) -> None:
    """A square of cloth turned about the vertical: brightest where it faces the lamp on the left."""
    seen = {}
    for turn in (-50.0, 0.0, 50.0, 180.0):
        angle = np.radians(turn)
        axes = ((np.cos(angle), np.sin(angle), 0.0), (0.0, 0.0, 1.0))
        cloth = pc.cloth((5, 5), 0.1, 1.0, axes=axes)
        camera = Orbit(azimuth=-90.0, elevation=0.0, field_of_view=0.0)
        seen[turn] = still(pc.Scene(cloth), tmp_path, style=pc.styles.Surface(), camera=camera, labels=()).max()
    assert seen[-50.0] > seen[0.0] > seen[50.0]
    # Fog adds up to 0.2 of the background, whose brightest channel is 27, on both sides; and both are rounded.
    assert 0.9 * seen[0.0] - 1.0 <= seen[180.0] <= 0.9 * seen[0.0] + 0.1 * 0.2 * 27.0 + 1.0


def test_a_smooth_fluid_covers_its_volume(tmp_path: Path) -> None:
    """A block of 1 m × 0.8 m, whose surface may lie up to 0.6 spacings outside of its outermost particles, which are
    half a spacing inside of the block: 0.1 spacings beyond it at most, and no less than it but for the two outermost
    pixels' fading.
    """
    spacing = 0.05
    block = pc.Fluid(pc.block((1.0, 1.0), (2.0, 1.8), spacing), spacing, density=1000.0)
    scene = pc.Scene(block, pc.Box((0.0, 0.0), (4.0, 3.0)))
    empty = still(pc.Scene(pc.Particles(np.empty((0, 2))), pc.Box((0.0, 0.0), (4.0, 3.0))), tmp_path,
                  camera=Window((0.0, 0.0), (4.0, 3.0)), labels=())  # fmt: skip
    picture = still(scene, tmp_path, style=pc.styles.Fluid(surface=True, top=1.0), color_bar=False, labels=(),
                    camera=Window((0.0, 0.0), (4.0, 3.0)))  # fmt: skip
    covered = (np.abs(picture - empty).max(axis=2) > 40).sum() / 60.0**2
    assert 1.0 * 0.8 - 2.0 * 3.6 / 60.0 * 0.5 <= covered <= (1.0 + 0.2 * spacing) * (0.8 + 0.2 * spacing) + 3.6 / 60.0


def test_motion_blur_keeps_the_light(tmp_path: Path) -> None:
    """Discs of the same size and color, at rest and drawn out over 0.5 s / 30 of their way, 12 pixels: rounding of the
    opacity to 1/255 and of each pixel to 1/256 of its share errs by 1 % at a third of full opacity.
    """
    generator = np.random.default_rng(3)
    positions = np.stack(np.meshgrid(np.linspace(0.5, 3.5, 6), np.linspace(0.5, 2.5, 5)), axis=-1).reshape(-1, 2)
    velocities = 12.0 * generator.choice([-1.0, 1.0], size=positions.shape)
    scene, window = pc.Scene(pc.Particles(positions)), Window((0.0, 0.0), (4.0, 3.0))
    light = [
        brightness(still(scene, tmp_path, velocities, style=style, camera=window, labels=(), color_bar=False))
        for style in (pc.styles.Points(color="body", size=7.0), pc.styles.Points(color="body", size=7.0, blur=0.5))
    ]
    assert light[1] == pytest.approx(light[0], rel=0.02)


def test_only_what_is_fast_glows(tmp_path: Path) -> None:
    scene, window = pc.Scene(pc.Particles([[1.0, 1.5], [3.0, 1.5]])), Window((0.0, 0.0), (4.0, 3.0))
    velocities = np.array([[0.1, 0.0], [1.0, 0.0]])
    options: dict[str, Any] = {"camera": window, "labels": (), "color_bar": False}
    for theme, sign in (("dark", 1.0), ("light", -1.0)):
        dull, glowing = (
            still(
                scene,
                tmp_path,
                velocities,
                style=pc.styles.Points(size=8.0, glow=glow, top=1.0),
                theme=theme,
                **options,
            )
            for glow in (0.0, 1.0)
        )
        change = sign * (glowing - dull).sum(axis=2)
        assert change.min() >= -1.0
        slow, fast = change[:, :120].sum(), change[:, 120:].sum()
        assert fast > 50.0 * max(slow, 1.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_mean_velocities_are_those_of_a_rigid_rotation(dimension: int) -> None:
    """The field is linear, so that the mean velocity of a square is exactly that at its mean position."""
    positions = np.random.default_rng(1).uniform(-1.0, 1.0, size=(500, dimension))
    spin = np.array([[0.0, -2.0, 0.5], [2.0, 0.0, 1.0], [-0.5, -1.0, 0.0]])[:dimension, :dimension]
    velocities = positions @ spin.T
    box = np.full(dimension, -1.0), np.full(dimension, 1.0)
    seen = fit(Face() if dimension == 2 else Orbit(), *box, (0, 0, *SIZE), 0.0)
    shown = fields.Motion(np.arange(len(positions)))
    places, vectors = shown.samples(frame(positions, velocities), seen, 20.0)
    assert 10 < len(places) < 200
    np.testing.assert_allclose(vectors, places @ spin.T, atol=1e-13)


def test_a_smoothed_uniform_flow_is_uniform_and_ends_where_nothing_is() -> None:
    positions = np.random.default_rng(1).uniform(0.5, 1.5, size=(400, 2))
    shown = fields.Motion(np.arange(len(positions)))
    at = shown.around(frame(positions, np.tile([0.3, -0.4], (400, 1))), view((0.0, 0.0), (4.0, 3.0)), 10.0)
    inside = np.random.default_rng(2).uniform(0.6, 1.4, size=(50, 2))
    np.testing.assert_allclose(at(inside), np.tile([0.3, -0.4], (50, 1)), atol=1e-14)
    assert np.isnan(at(np.array([[3.5, 2.5], [-40.0, 0.0]]))).all()


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_the_acceleration_is_that_of_the_scenes_forces() -> None:
    """Gravity and an inverse-square attraction, felt from rest."""
    scene = pc.Scene(
        pc.cloth((3, 3), 0.1, 50.0, origin=(3.0, 3.0)),
        pc.Gravity((0.0, -9.81)),
        pc.CentralForce((0.0, 0.0), strength=2.0, exponent=-2.0),
    )
    source = sources(pc.simulate(scene, 0.01, dt=1e-3, progress=False), None, None, {})[0]
    shown = fields.field("acceleration", source, part(scene), "of")
    places = np.random.default_rng(1).uniform(0.5, 2.0, size=(20, 2))
    radius = np.linalg.norm(places, axis=1)[:, np.newaxis]
    assert isinstance(shown, fields.Space)
    np.testing.assert_allclose(shown.at(0.0, places), [0.0, -9.81] - 2.0 * places / radius**3, rtol=1e-14)


def test_arrows_point_along_the_field_and_are_as_long_as_it_is_large() -> None:
    """A field along (3, 4) that grows to the right; an arrow of the top value is 0.9 of the spacing long."""
    scene = pc.Scene(pc.Particles([[1.0, 1.0], [2.0, 1.0]]))
    source = sources(pc.simulate(scene, 0.1, progress=False), None, None, {})[0]
    style = pc.styles.Arrows(lambda time, x: x[:, :1] * np.array([0.6, 0.8]), spacing=30.0, top=4.0)
    painter, sheet = style.painter(source, part(scene), DARK), Sheet()
    painter.paint(sheet, frame(np.zeros((2, 2)), np.zeros((2, 2))), view((0.0, 0.0), (4.0, 3.0)), 1.0)  # type: ignore[arg-type]
    corners = sheet.drawn["triangles"][0].reshape(-1, 3, 2)
    tails, tips = sheet.drawn["lines"][0][:, :2], corners[:, 0]
    along = (tips - tails) * np.array([1.0, -1.0])
    length = np.linalg.norm(along, axis=1)
    expected = 27.0 * np.minimum(0.5 * (tails + tips)[:, 0] / 60.0 / 4.0, 1.0)
    np.testing.assert_allclose(along / length[:, np.newaxis], np.tile([0.6, 0.8], (len(along), 1)), atol=1e-4)
    np.testing.assert_allclose(length, expected, atol=1e-3)


def test_streamlines_of_a_rotation_are_circles() -> None:
    """The midpoint rule in steps of h goes out by h⁴/(8r³) per step at the radius r [pixels]: 20 steps of 3 pixels at
    r ≥ 20 by less than 0.03; pixels are rounded to f32.
    """
    scene = pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 1.0]]))
    source = sources(pc.simulate(scene, 0.1, progress=False), None, None, {})[0]
    style = pc.styles.Streamlines(lambda time, x: np.stack([-x[:, 1], x[:, 0]], axis=1), top=2.0)
    painter, sheet = style.painter(source, part(scene), DARK), Sheet()
    painter.paint(sheet, frame(np.zeros((2, 2)), np.zeros((2, 2))), view((-2.0, -1.5), (2.0, 1.5)), 1.0)  # type: ignore[arg-type]
    past = sheet.drawn["trails"][0].astype(float) - np.array([SIZE[0] / 2, SIZE[1] / 2])
    radius = np.linalg.norm(past, axis=2)
    outer = radius[-1] > 20.0
    assert outer.sum() > 50
    assert np.abs(radius[:, outer] - radius[-1, outer]).max() < 0.03 + 1e-4
    angle = np.unwrap(np.arctan2(-past[..., 1], past[..., 0]), axis=0)
    assert (np.diff(angle[:, outer], axis=0) > 0.0).all()


def test_a_path_is_the_whole_way_of_the_chosen(tmp_path: Path) -> None:
    """Two particles fly 3 m at 60 pixels per meter; the path of one is shown: 180 pixels long, 4 wide."""
    scene = pc.Scene(pc.Particles([[0.5, 1.0], [0.5, 2.0]], velocities=(3.0, 0.0)))
    recording = pc.simulate(scene, 1.0, fps=10, progress=False)
    options: dict[str, Any] = {"camera": Window((0.0, 0.0), (4.0, 3.0)), "labels": (), "color_bar": False, "size": SIZE}
    styles = [pc.styles.Paths([-1], width=4.0), pc.styles.Points(color="body", size=1.0, trail=0.0)]
    pc.film(recording, tmp_path / "way.png", style=styles, **options)
    with Image.open(tmp_path / "way.png") as image:
        inked = np.abs(np.asarray(image.convert("RGB")).astype(float) - np.array(DARK.background)).max(axis=2) > 20
    assert 178 * 4 <= inked[40:80].sum() <= 186 * 5
    assert inked[100:140].sum() < 20


def test_paths_of_particles_that_are_not_there_are_refused(tmp_path: Path) -> None:
    dust = pc.Particles(np.zeros((3, 2)))
    with pytest.raises(pc.SceneError, match=r"Paths\.particles: must be particles of .*, got \(3,\)"):
        still(pc.Scene(dust), tmp_path, style=pc.styles.Paths([3], on=dust))
    with pytest.raises(pc.SceneError, match=r"Paths\.particles: must be a list of indices"):
        pc.styles.Paths([0.5])


def test_space_has_no_streamlines(tmp_path: Path) -> None:
    dust = pc.Particles(np.zeros((3, 3)))
    with pytest.raises(pc.SceneError, match=r"Streamlines: show the plane"):
        still(pc.Scene(dust), tmp_path, style=pc.styles.Streamlines(on=dust))


@pytest.mark.parametrize("style", [pc.styles.Strain(), pc.styles.Surface(color="strain")])
def test_the_colors_of_strain_are_those_of_its_scale(style: pc.styles.Style, tmp_path: Path) -> None:
    """A cloth that is drawn out by a tenth along x has one strain along its rows; its mean is on the scale too."""
    cloth = pc.cloth((5, 2), 0.25, 10.0, shear_stiffness=0.0, bend_stiffness=0.0)
    source: Any = SimpleNamespace(scene=pc.Scene(cloth), count=2, fps=1.0, times=np.arange(2.0), has=lambda name: True)
    painter = style.painter(source, part(source.scene), DARK)
    drawn_out = cloth.positions * np.array([1.1, 1.1])
    painter.observe(frame(cloth.positions * 1.2, np.zeros((10, 2))))
    scale, sheet = painter.scale, Sheet()
    assert scale is not None
    painter.paint(sheet, frame(drawn_out, np.zeros((10, 2))), view((0.0, 0.0), (2.0, 1.5)), 1.0)  # type: ignore[arg-type]
    shown = (sheet.drawn["lines"][2] if "lines" in sheet.drawn else sheet.drawn["triangles"][1])[0, :3].astype(float)
    low, high = scale.ends
    place = (0.1 - low) / (high - low) * (len(scale.table) - 1)
    assert (low, high) == pytest.approx((-0.2, 0.2))
    np.testing.assert_allclose(shown, scale.table[round(place)], atol=3.0)  # a step of the table, and rounding down


@pytest.mark.parametrize("options", [{"style": pc.styles.Arrows(of=lambda: 0)}, {"camera": lambda: 0}])
def test_a_function_that_fails_is_named_and_its_exception_the_cause(options: dict[str, Any], tmp_path: Path) -> None:
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]])), 0.1, progress=False)
    path = "camera" if "camera" in options else "of"
    with pytest.raises(pc.SceneError, match=rf"^{path}: the function raised TypeError: .*positional") as caught:
        pc.film(recording, tmp_path / "film.png", progress=False, **options)
    assert isinstance(caught.value.__cause__, TypeError)


def waves(wave: pc.Wave, *bodies: pc.Particles) -> pc.Recording:
    """Its first frames."""
    return pc.simulate(pc.Scene(wave, *bodies), 0.02, 100.0, dt=0.001)


PLAIN: dict[str, Any] = {"labels": (), "color_bar": False, "sidecar": False}


def test_a_field_is_where_its_cells_are_and_as_its_sign(tmp_path: Path) -> None:
    """A window of 4 m × 3 m, 60 pixels per meter: a warm hump at (1, 2), a cold one at (3, 1), the background between,
    and walls over x > 3.5. Beyond the grid, which ends at y = 2.5, there is nothing.
    """
    grid = pc.Grid.over((0.0, 0.0), (4.0, 2.5), 0.05)
    x, y = grid.coordinates
    humps = np.exp(-((x - 1.0) ** 2 + (y - 2.0) ** 2) / 0.02) - np.exp(-((x - 3.0) ** 2 + (y - 1.0) ** 2) / 0.02)
    recording = waves(pc.Wave(grid, 1.0, humps, edges="absorbing", walls=x > 3.5))
    for theme in ("dark", "light"):
        still = tmp_path / f"{theme}.png"
        pc.film(recording, still, size=SIZE, camera=Window((0.0, 0.0), (4.0, 3.0)), theme=theme, **PLAIN)
        with Image.open(still) as image:
            picture = np.asarray(image.convert("RGB")).astype(float)
        background = np.array((DARK if theme == "dark" else LIGHT).background, dtype=float)
        apart = np.abs(picture - background).max(axis=2)
        assert apart[60, 180] < 3.0
        assert not apart[:29].any()
        warm, cold = picture[60, 60], picture[120, 180]
        assert warm[0] > warm[2] + 20.0
        assert cold[2] > cold[0] + 20.0
        assert (apart[35:175, 213:] > 15.0).all(), "walls stand out"
        assert np.ptp(picture[35:175, 213:], axis=(0, 1)).max() == 0.0, "and are of one color"


def test_the_colors_of_a_field_are_symmetric_and_go_evenly_from_the_background() -> None:
    for theme in (DARK, LIGHT):
        table = two_sided(theme.background)
        np.testing.assert_allclose(table[127:129], [theme.background] * 2, atol=4.0)
        lightness = table @ LUMA
        rise = np.diff(lightness[128:]) * (1.0 if theme is DARK else -1.0)
        assert (rise > 0.0).all()
        np.testing.assert_allclose(lightness[128:], lightness[127::-1], atol=30.0)


def test_a_field_has_one_scale_over_the_whole_film(tmp_path: Path) -> None:
    """With its range given it is settled; 0.5 of a linear scale has the color of three quarters of the table."""
    grid = pc.Grid((8, 6), 0.5)
    recording = waves(pc.Wave(grid, 0.0, 0.5))
    (source,) = sources(recording, None, None, {})
    (painter,) = pc.styles.Field(range=1.0).painters(source, recording.scene.systems, DARK)
    assert painter.settled
    assert painter.scale is not None
    assert painter.scale.ends == (-1.0, 1.0)
    pc.film(recording, tmp_path / "still.png", size=SIZE, style=pc.styles.Field(range=1.0), **PLAIN)
    with Image.open(tmp_path / "still.png") as image:
        middle = np.asarray(image.convert("RGB"))[90, 120].astype(float)
    np.testing.assert_allclose(middle, two_sided(DARK.background)[192], atol=3.0)
    with pytest.raises(pc.SceneError, match=r"Field\.quantity: must be one of displacement, rate, got 'height'"):
        pc.film(recording, tmp_path / "x.png", style=pc.styles.Field("height"))
    string = waves(pc.Wave(pc.Grid(9, 0.1), 1.0))
    with pytest.raises(pc.SceneError, match=r"Field\.on: .* has no field on a grid in 2D or 3D; use Line"):
        pc.film(string, tmp_path / "x.png", style=pc.styles.Field(on=string.scene.systems[0]))


def test_a_line_is_as_high_as_its_values(tmp_path: Path) -> None:
    """The largest value reaches 0.8 of the way to the edge; half of it half as far, on the other side of zero."""
    grid = pc.Grid(200, 0.01)
    (x,) = grid.coordinates
    shape = np.exp(-((x - 0.5) ** 2) / 0.01) - 0.5 * np.exp(-((x - 1.5) ** 2) / 0.01)
    pc.film(waves(pc.Wave(grid, 0.0, shape)), tmp_path / "line.png", size=SIZE, theme="light", **PLAIN)
    with Image.open(tmp_path / "line.png") as image:
        picture = np.asarray(image.convert("RGB")).astype(float)
    near = np.abs(picture - np.array(LIGHT.bodies[0])).max(axis=2) < 40.0
    rows = np.flatnonzero(near.any(axis=1))
    assert rows[0] == pytest.approx(90.0 - 0.8 * 90.0, abs=2.5)
    assert rows[-1] == pytest.approx(90.0 + 0.4 * 90.0, abs=2.5)


@pytest.mark.parametrize(("cells", "squares"), [(10, 37), (40, 11), (7, 7)])
def test_values_on_a_mesh_are_those_of_a_line_between_cells(cells: int, squares: int) -> None:
    """Keys' cubic keeps lines where all of its neighbors are there, and is symmetric; stretched over n cells for n > 1
    its weights still add up to 1, and differ from those of a line by less than the ripple of a sampled kernel.
    """
    places = np.linspace(0.0, cells, squares + 1)
    weights = cubic(cells, places - 0.5, width=cells / squares)
    inside = (places > 2.0 * max(1.0, cells / squares)) & (places < cells - 2.0 * max(1.0, cells / squares))
    found = weights @ (np.arange(cells) + 0.5)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(found[inside], places[inside], atol=1e-12 if squares >= cells else 0.02)
    np.testing.assert_allclose(weights, weights[::-1, ::-1], atol=1e-15)


def test_a_relief_raises_bodies_to_its_surface(tmp_path: Path) -> None:
    """On a slope of u = x/4, where the value at the end of the scale, 1, is as high as was asked for."""
    grid = pc.Grid((40, 30), 0.1)
    slope = pc.Wave(grid, 0.0, lambda x, y: 0.25 * x + 0.0 * y)
    floats = pc.Particles([[1.0, 1.0], [2.5, 2.0]])
    recording = waves(slope, floats)
    style = pc.styles.Relief(range=1.0, height=2.0)
    (source,) = sources(recording, None, None, {})
    source = shown(source, [style])
    (painter,) = style.painters(source, recording.scene.systems, DARK)
    frame = painter.raised(next(iter(source.frames())))
    np.testing.assert_allclose(frame.positions, [[1.0, 1.0, 0.5], [2.5, 2.0, 1.25]], atol=1e-12)
    pictures = []
    for height in (0.01, 1.0):
        tall = pc.styles.Relief(range=1.0, height=height, gloss=0.0)
        pc.film(
            waves(slope),
            tmp_path / "relief.png",
            size=SIZE,
            style=tall,
            camera=Orbit(azimuth=-90.0, elevation=0.0),
            **PLAIN,
        )
        with Image.open(tmp_path / "relief.png") as image:
            picture = np.asarray(image.convert("RGB")).astype(float)
        pictures.append((np.abs(picture - np.array(DARK.background)).max(axis=2) > 12.0).sum(axis=0))
    flat, steep = pictures
    rise = np.flatnonzero(steep)
    assert flat.max() < 10
    assert steep[rise[-5]] > 1.5 * steep[rise[5]] > 0  # seen from the side, it is a wedge
    solid = waves(pc.Wave(pc.Grid((4, 4, 4), 0.1), 1.0))
    with pytest.raises(pc.SceneError, match=r"Relief\.on: .* no field on a grid in 2D; use Field\(\) in 3D"):
        pc.film(solid, tmp_path / "x.png", style=pc.styles.Relief(on=solid.scene.systems[0]))


PLAIN_WINDOW: dict[str, Any] = {
    "camera": Window((0.0, 0.0), (4.0, 3.0)),
    "labels": (),
    "color_bar": False,
    "size": SIZE,
}
"""60 pixels to a meter."""
REST = pc.Flow(lambda time, x: 0.0 * x)


def last(scene: pc.Scene, path: Path, duration: float, fps: float, **options: Any) -> np.ndarray:
    """The last frame of a film, (H, W, 3)."""
    recording = pc.simulate(scene, duration, fps=fps, dt=1e-2, integrator=pc.RungeKutta4())
    pc.film(recording, path / "film.apng", **{**PLAIN_WINDOW, **options})
    with Image.open(path / "film.apng") as image:
        image.seek(image.n_frames - 1)
        return np.asarray(image.convert("RGB")).astype(float)


def sheets(count: int = 40_000) -> pc.Tracers:
    """Two squares of a square meter, of which the right one has a tenth of the density."""
    rng = np.random.default_rng(4)
    left, right = rng.uniform(0.0, 1.0, (count, 2)), rng.uniform(0.0, 1.0, (count // 10, 2))
    return pc.Tracers(np.concatenate([np.array([0.5, 1.0]) + left, np.array([2.5, 1.0]) + right]), REST)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_a_density_shows_the_dense_and_the_thin_and_does_not_saturate(theme: Any, tmp_path: Path) -> None:
    """Light of 0.5 has the tone 0.80, a tenth of it 0.24: two thirds of the way to white, and well above the ground."""
    picture = last(pc.Scene(sheets()), tmp_path, 0.0, 1.0, theme=theme)
    ground = picture[5, 5] @ LUMA
    tones = [abs((picture[70:110, left : left + 40] @ LUMA).mean() - ground) for left in (40, 160)]
    assert 15.0 < tones[1] < 0.75 * tones[0]
    assert tones[0] < 240.0
    assert np.abs(picture[20:160, 100:140] - picture[5, 5]).max() < 2.0


def test_a_density_is_exposed_for_its_typical_tracer_however_many_there_are(tmp_path: Path) -> None:
    few, many = (
        last(pc.Scene(sheets(count)), tmp_path, 0.0, 1.0, style=pc.styles.Density(spread=2.0))[70:110, 40:80].mean()
        for count in (20_000, 80_000)
    )
    assert many == pytest.approx(few, rel=0.05)


def test_strays_do_not_make_the_picture_larger(tmp_path: Path) -> None:
    """Of ten thousand tracers one is a hundred times farther away."""
    cloud = np.random.default_rng(5).uniform(-1.0, 1.0, (10_000, 2))
    cloud[77] = (300.0, 0.0)
    picture = last(pc.Scene(pc.Tracers(cloud, REST)), tmp_path, 0.0, 1.0, camera=None)
    assert (np.abs(picture - picture[2, 2]).max(axis=2) > 30).mean() > 0.3


def test_trails_follow_the_path_between_frames_and_fade(tmp_path: Path) -> None:
    """A turn about (2, 1.5) in eight frames: a chord passes 4.6 pixels inside of the middle of its arc."""
    turn = pc.Flow(lambda time, x: np.column_stack([1.5 - x[:, 1], x[:, 0] - 2.0]))
    scene = pc.Scene(pc.Tracers([[3.0, 1.5]], turn))
    picture = last(scene, tmp_path, 2.0 * np.pi * 6.0 / 8.0, 8.0 / (2.0 * np.pi), style=pc.styles.Trails(duration=9.0))
    light = np.abs(picture - np.array(DARK.background)).sum(axis=2)

    def beside(angle: float, radius: float) -> float:
        """The most light within a pixel of a place."""
        row, column = 180 - 60.0 * (1.5 + radius * np.sin(angle)), 60.0 * (2.0 + radius * np.cos(angle))
        return float(light[int(row) - 1 : int(row) + 2, int(column) - 1 : int(column) + 2].max())

    arcs = [beside((step + 0.5) * np.pi / 4.0, 1.0) for step in range(6)]
    assert min(arcs[2:]) > 60.0
    assert arcs[5] > 1.5 * arcs[1]
    assert beside(4.5 * np.pi / 4.0, np.cos(np.pi / 8.0)) < 0.5 * arcs[4]


def test_paths_that_fade_are_gone_after_their_time(tmp_path: Path) -> None:
    """A particle at 1 m/s: of two seconds the last one is shown, fresh at its end."""
    scene = pc.Scene(pc.Particles([[1.0, 1.5]], [[1.0, 0.0]]))
    style = [pc.styles.Paths(fade=1.0), pc.styles.Points(trail=0.0)]
    recording = pc.simulate(scene, 2.0, fps=10)
    pc.film(recording, tmp_path / "film.apng", style=style, **PLAIN_WINDOW)
    with Image.open(tmp_path / "film.apng") as image:
        image.seek(image.n_frames - 1)
        picture = np.asarray(image.convert("RGB")).astype(float)
    light = np.abs(picture - np.array(DARK.background)).sum(axis=2)[88:92].max(axis=0)
    assert light[60:118].max() < 3.0
    assert light[165] > 1.5 * light[130] > 10.0


def test_what_is_no_tracer_has_no_trail(tmp_path: Path) -> None:
    wave = pc.Wave(pc.Grid((4, 4), 1.0), 1.0)
    for style in (pc.styles.Trails(on=wave), pc.styles.Density(on=wave)):
        with pytest.raises(pc.SceneError, match=rf"{type(style).__name__}.on: .* has no points; only tracers"):
            last(pc.Scene(wave), tmp_path, 0.1, 10.0, style=style)


def exactly(picture: np.ndarray, name: str) -> int:
    """How many pixels have a color, within what a palette of 255 leaves of it."""
    return int((np.abs(picture.astype(int) - ImageColor.getrgb(name)).max(axis=2) <= 12).sum())


@pytest.mark.parametrize(
    ("color", "expected"),
    [
        ("tomato", {"tomato": 2}),
        ("#22cc88", {"#22cc88": 2}),
        ((34, 204, 136), {"#22cc88": 2}),
        ({"left": "tomato", "right": "#22cc88"}, {"tomato": 1, "#22cc88": 1}),
        (["tomato", "#22cc88"], {"tomato": 1, "#22cc88": 1}),
        (np.array([[255, 99, 71], [34, 204, 136]], dtype=np.uint8), {"tomato": 1, "#22cc88": 1}),
        (np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), {"#ff0000": 1, "#0000ff": 1}),
        (lambda time, places, velocities: places[:, :1] * (1.0, 0.0, 0.0), {"#ff0000": 1}),
        ([0.0, 7.0], {"#f0f921": 1}),  # the upper end of plasma
        (lambda time, places, velocities: places[:, 0], {"#f0f921": 1}),
    ],
    ids=[
        "name",
        "hex",
        "numbers",
        "mapping",
        "names",
        "bytes",
        "fractions",
        "function",
        "values",
        "function-of-values",
    ],
)
def test_points_have_the_color_that_was_asked_for(tmp_path: Path, color: Any, expected: dict[str, int]) -> None:
    balls = [pc.Particles([[x, 0.0]], radius=0.3, name=name) for x, name in ((0.0, "left"), (1.0, "right"))]
    style, camera = pc.styles.Points(color, shading=False), Window((-0.5, -0.5), (1.5, 0.5))
    picture = still(pc.Scene(*balls), tmp_path, style=style, color_bar=False, labels=(), camera=camera)
    per_ball = np.pi * (0.3 * picture.shape[1] / 2.0) ** 2
    for name, balls in expected.items():
        assert exactly(picture, name) == pytest.approx(balls * per_ball, rel=0.25), name  # without edges
    assert pc.styles.Points(color) == pc.styles.Points(color)


def test_shading_changes_the_color_of_balls_in_space_alone(tmp_path: Path) -> None:
    scene = pc.Scene(pc.Particles([[0.0, 0.0, 0.0]], radius=1.0))
    plain, lit = (still(scene, tmp_path, style=pc.styles.Points("tomato", shading=each)) for each in (False, True))
    assert exactly(plain, "tomato") > 2 * exactly(lit, "tomato")


def test_sizes_go_with_mass_or_are_given(tmp_path: Path) -> None:
    scene = pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], mass=[1.0, 1.0, 9.0]))
    for size, ratio in (("mass", 9.0), ([8.0, 8.0, 16.0], 4.0)):
        style = pc.styles.Points(["red", "red", "blue"], size=size)
        picture = still(scene, tmp_path, style=style, camera=Window((-1.0, -1.0), (3.0, 1.0)), labels=())
        # Red R and blue B of a pixel are linear in the shares that red and blue discs have in it.
        (r, _, b), total = DARK.background, picture.reshape(-1, 3)[:, [0, 2]].sum(axis=0)
        shares = np.linalg.solve([[255 - r, -r], [-b, 255 - b]], total - np.array([r, b]) * picture[..., 0].size)
        assert 2.0 * shares[1] / shares[0] == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"color": "tomatoe"}, "Points.color: must be like"),
        ({"color": {"nobody": "red"}}, "'nobody' is not among the bodies"),
        ({"color": [1.0, 2.0]}, "3 for the particles, got 2"),
        ({"color": [1.0, 2.0, np.nan]}, "Points.color: must be finite"),
        ({"color": lambda time, places, velocities: places}, "Points.color.*shape"),
        ({"color": lambda time, places, velocities: [1.0]}, "must give 3 values, got 1"),
        ({"size": "radius"}, "needs particles with a radius"),
        ({"size": [1.0, 2.0, 0.0]}, "Points.size: must be above 0"),
    ],
)
def test_what_says_no_color_or_size_is_refused(tmp_path: Path, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        still(
            pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])), tmp_path, style=pc.styles.Points(**arguments)
        )


@pytest.mark.parametrize("phase", [0.13, 0.5, 0.81])
def test_a_path_has_its_corner_at_the_wall(phase: float) -> None:
    """A ball falls from 1 m and bounces off the floor with half its speed; frames see it only before and after."""
    g, dt, velocity = 9.81, 1 / 20, np.array([0.7, 0.0])
    hit = np.sqrt(2.0 / g)
    curve, corners = Curve(dt), []
    for time in hit + dt * (phase + np.arange(-4, 3)):
        fall, rise = time <= hit, 0.5 * g * hit
        height = 1.0 - 0.5 * g * time**2 if fall else rise * (time - hit) - 0.5 * g * (time - hit) ** 2
        speed = -g * time if fall else rise - g * (time - hit)
        points = np.array([[0.7 * time, height]])
        corners.append(curve.piece(time, points, velocity + np.array([[0.0, speed]])))
    way = np.concatenate(corners)[:, 0]
    low = way[way[:, 1].argmin()]
    # The arcs are exact here; the time at which they meet is that of a parabola through moments dt/32 apart.
    assert abs(low - (0.7 * hit, 0.0)).max() < 1e-3
    assert way[:, 1].min() > -1e-3


def test_a_smooth_path_is_the_cubic_through_frames(tmp_path: Path) -> None:
    """On a circle of radius 1 with steps of θ, a Hermite cubic is off by θ⁴/384, and a chord by θ²/8."""
    curve, step = Curve(0.5), 0.5
    pieces = []
    for time in step * np.arange(8):
        place, along = np.array([[np.cos(time), np.sin(time)]]), np.array([[-np.sin(time), np.cos(time)]])
        pieces.append(curve.piece(time, place, along))
    away = np.abs(np.linalg.norm(np.concatenate(pieces), axis=2) - 1.0)
    assert away.max() < 1.1 * step**4 / 384 < 0.1 * step**2 / 8


def test_paths_take_a_color(tmp_path: Path) -> None:
    """A path of two points in the color that was asked for."""
    places = np.array([[[0.0, 0.0]], [[1.0, 0.0]]])
    scene = pc.Scene(pc.Particles(places[0]))
    recording: Any = SimpleNamespace(
        scene=scene, times=np.arange(2) / 30, positions=places, fps=30.0, channels={"positions": places}
    )
    style = [pc.styles.Paths(color="#22cc88", width=8.0), pc.styles.Points(size=2.0, trail=0.0)]
    pc.film(recording, tmp_path / "path.gif", size=SIZE, style=style, camera=Window((-0.5, -0.5), (1.5, 0.5)))
    with Image.open(tmp_path / "path.gif") as image:
        image.seek(image.n_frames - 1)
        picture = np.asarray(image.convert("RGB"))
    # FRESH of the color, over the ground.
    faded = 0.85 * np.array([34, 204, 136]) + 0.15 * np.array(DARK.background)
    assert (np.abs(picture - faded).max(axis=2) <= 8).sum() > 6.0 * SIZE[0] / 2.0


@pytest.mark.parametrize("kind", [pc.styles.Surface, pc.styles.Strain, pc.styles.Fluid])
def test_bodies_have_colors_of_ones_own(kind: Any, tmp_path: Path) -> None:
    """A left body and a right one, by name, by particle, by value and by a function; rims are lighter."""
    if kind is pc.styles.Fluid:
        bodies = [
            pc.Fluid(pc.block((x, 0.0), (x + 0.4, 0.4), 0.05), 0.05, name=name) for x, name in ((0.0, "a"), (0.6, "b"))
        ]
    else:
        bodies = [pc.cloth((9, 9), 0.05, 1.0, origin=(x, 0.0), name=name) for x, name in ((0.0, "a"), (0.6, "b"))]
    scene = pc.Scene(*bodies)
    count, first = scene.particles, len(scene.bodies[0])
    each = np.where(np.arange(count)[:, np.newaxis] < first, (255, 0, 0), (0, 0, 255))
    shift: dict[str, Any] = {"camera": Window((-0.1, -0.1), (1.1, 0.5)), "labels": (), "color_bar": False}
    for color in ({"a": "red", "b": "blue"}, each, lambda time, x, v: each):
        picture = still(scene, tmp_path, style=kind(color=color), **shift)
        left, right = picture[:, :120].reshape(-1, 3), picture[:, 120:].reshape(-1, 3)
        assert left[:, 0].max() > 150.0
        assert right[:, 2].max() > 150.0
        assert (left[:, 0] - left[:, 2]).max() > 120.0 > 60.0 > (right[:, 0] - right[:, 2]).max()
    ramp = still(scene, tmp_path, style=kind(color=np.arange(count), colormap="viridis"), **shift)
    assert (ramp[:, 120:] @ LUMA).max() > (ramp[:, :110] @ LUMA).max() + 20.0
    with pytest.raises(pc.SceneError, match=f"{kind.__name__}.color: must be one, or {count} for the particles"):
        still(scene, tmp_path, style=kind(color=[1.0, 2.0]), **shift)
    with pytest.raises(pc.SceneError, match=f"{kind.__name__}.color: 'c' is not among the bodies"):
        still(scene, tmp_path, style=kind(color={"c": "red"}), **shift)


def test_milk_hides_what_water_shows(tmp_path: Path) -> None:
    """A red ball in a clear fluid and in an opaque one."""
    spacing = 0.05
    water = pc.Fluid(pc.block((0.0, 0.0, 0.0), (0.5, 0.5, 0.3), spacing), spacing, obstacles=False)
    ball = pc.Particles([[0.25, 0.25, 0.15]], radius=0.12)
    scene, reds = pc.Scene(water, ball), []
    for opacity in (0.0, 1.0):
        style = [pc.styles.Fluid("white", opacity=opacity), pc.styles.Points("red")]
        picture = still(scene, tmp_path, style=style, labels=(), camera=Orbit(elevation=40.0))
        reds.append((picture[..., 0] - picture[..., 1]).max())
    assert reds[0] > 60.0 > 20.0 > reds[1]
    with pytest.raises(pc.SceneError, match=r"Fluid\.opacity"):
        pc.styles.Fluid(opacity=2.0)


def test_a_body_has_a_shadow_on_the_floor_in_front_of_a_backdrop(tmp_path: Path) -> None:
    """Without it the floor is as light or lighter everywhere that the ball does not hide."""
    camera = Orbit(elevation=30.0, target=(0.0, 0.0, 0.2), extent=2.0)
    options: dict[str, Any] = {"style": pc.styles.Points("red"), "camera": camera, "labels": (), "theme": "light"}
    scenes = [pc.Scene(pc.Particles([[0.0, 0.0, 0.3]], radius=radius), pc.Floor()) for radius in (0.2, 0.001)]
    with_ball, without = (still(scene, tmp_path, **options) for scene in scenes)
    lost, gray = (without - with_ball)[..., 1], np.ptp(with_ball, axis=2) < 40.0
    assert lost[gray].min() > -8.0
    assert 60.0 < lost[gray].max() < 200.0
    upright = pc.cloth((3, 3), 0.1, 1.0, axes=((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert still(pc.Scene(upright), tmp_path, background="#000000", labels=())[0, 0].max() == 0.0


def test_curves_in_one_picture_share_the_words_of_one_scale(tmp_path: Path) -> None:
    """The scale of two curves is written as that of one; two scales are written in the colors of their curves."""
    strings = [
        pc.Wave(pc.Grid.over(0.0, 1.0, 0.01), speed=1.0, displacement=0.2 * number, name=f"{number}")
        for number in (1, 2)
    ]

    def words(*styles: pc.styles.Line) -> np.ndarray:
        drawn = [string for string, _ in zip(strings, styles, strict=False)]
        return last(pc.Scene(*drawn), tmp_path, 0.05, 20.0, camera=None, style=styles, labels=())[:30]

    one = words(pc.styles.Line(on="1", range=0.5))
    assert (one != DARK.background).any()
    np.testing.assert_array_equal(words(*(pc.styles.Line(on=name, range=0.5) for name in "12")), one)
    both = words(pc.styles.Line(on="1", range=0.5), pc.styles.Line(on="2", range=0.7))
    for color in DARK.bodies[:2]:
        assert (np.abs(both.astype(int) - color).max(axis=2) < 12).sum() > 20


def test_a_heading_leaves_room_for_the_whole_scale_of_a_curve(tmp_path: Path) -> None:
    """The lines at both ends of the scale are in the picture, at equal distances from that at zero."""
    string = pc.Wave(pc.Grid.over(0.0, 1.0, 0.01), speed=1.0, displacement=0.0)
    texts = {"title": "A string", "subtitle": "Its largest values are in the picture"}
    options = {"camera": None, "style": pc.styles.Line(range=0.5), "labels": (), **texts}
    picture = last(pc.Scene(string), tmp_path, 0.05, 20.0, **options).astype(int)
    across = np.flatnonzero((np.abs(picture - DARK.background).max(axis=2) > 3).mean(axis=1) > 0.8)
    low, zero, high = across.min(), np.median(across), across.max()
    assert low < 0.4 * SIZE[1] < zero < high
    assert abs((high - zero) - (zero - low)) <= 2.0

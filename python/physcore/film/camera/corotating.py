"""Corotating frames of reference, in which a pair of bodies stays on a fixed line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from physcore.checks import MOST, FloatArray, count, shown
from physcore.errors import SceneError
from physcore.film.camera.track import Camera, Follow, is_camera
from physcore.film.derived import Derived
from physcore.scene.bodies import Body
from physcore.scene.contents import BodyKey
from physcore.scene.scene import Scene
from physcore.simulation.sources import Source, SourceFrame

Member = BodyKey | tuple[BodyKey, int]
"""A body, represented by its center of mass, or one of its particles: (body, index)."""


@dataclass(frozen=True)
class Corotating:
    """Frame of reference that rotates with a pair of bodies. The origin is their center of mass.

        planets = pc.Particles([[0, 0], [1, 0]], velocities=[[0, -0.1], [0, 1]], mass=[1.0, 0.1], name="planets")
        recording = pc.simulate(pc.Scene(planets, pc.Gravitation(1.0)), duration=2.0)
        frame = pc.Corotating(("planets", 0), ("planets", 1))
        pc.film(recording, "trojans.png", camera=frame, style=[pc.styles.Paths(), pc.styles.Points()])

    The first body is on the left and the second on the right, at all times on one horizontal line. Velocities in the
    frame are v' = R(v − V − ω × (x − X)). X and V are the position and the velocity of the center of mass, and d is the
    vector from the first body to the second. The angular velocity is ω = (d × ḋ)_z/(d_x² + d_y²), and R rotates d onto
    the x axis. Trails and paths are therefore those of the restricted three-body problem. In 3D the frame rotates about
    the z axis.

    Args:
        first, second: the pair, each a body, its index or its name, or (body, index) for one of its particles.
        camera: the camera in the coordinates of the frame: a Window in 2D, an Orbit in 3D, Keyframes or a function of
            these. None: a view that contains the whole motion.

    Raises:
        SceneError: an argument is not valid; a scene has boundaries, joints, a periodic domain or systems, which would
            rotate in this frame; or the two members of the pair coincide.

    Source: V. Szebehely, Theory of Orbits (1967), section 1.4.
    """

    first: Member
    second: Member
    camera: Camera | None = None

    def __post_init__(self) -> None:
        for name in ("first", "second"):
            object.__setattr__(self, name, _member(getattr(self, name), f"Corotating.{name}"))
        if not is_camera(self.camera):
            raise SceneError(
                f"Corotating.camera: must be a Window, an Orbit, Keyframes or a function, got {shown(self.camera)}"
            )

    def seen(self, source: Source) -> Source:
        """The source in the corotating frame."""
        return CorotatingSource(source, self)


class CorotatingSource(Derived):
    """A source whose positions and velocities are those in a corotating frame."""

    def __init__(self, origin: Source, frame: Corotating) -> None:
        super().__init__(origin)
        scene = origin.scene
        joints = [each for each in scene.constraints if each.element == "joints"]
        still = {
            "boundaries": scene.boundaries,
            "joints": joints,
            "a periodic domain": scene.periodic,
            "systems": scene.systems,
        }
        found = next((name for name, value in still.items() if value), None)
        if found is not None:
            raise SceneError(
                f"Corotating: must be of a scene with bodies alone, got one with {found}; film it with another camera"
            )
        self._pair = [_weights(scene, getattr(frame, name), f"Corotating.{name}") for name in ("first", "second")]

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start."""
        for frame in super().frames():
            yield replace(frame, fields={**frame.fields, **self._turned(frame)})

    def _turned(self, frame: SourceFrame) -> dict[str, FloatArray]:
        """The positions and velocities of a frame in the corotating frame."""
        one, other = self._pair
        share = other.sum() / (one.sum() + other.sum())

        def of_pair(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
            """The center of mass of the pair, and the vector from the first member to the second."""
            first, second = one @ vectors / one.sum(), other @ vectors / other.sum()
            return first + share * (second - first), second - first

        center, apart = of_pair(frame.positions)
        length = float(np.hypot(apart[0], apart[1]))
        if length == 0.0:
            raise SceneError(f"Corotating: the pair must be apart, got both at {center.tolist()} m at {frame.time:g} s")
        turn = np.eye(len(center))
        turn[:2, :2] = np.array([[apart[0], apart[1]], [-apart[1], apart[0]]]) / length
        fields = dict[str, FloatArray]()
        moves = "velocities" in frame.fields
        if moves:
            velocity, change = of_pair(frame.fields["velocities"])
            rate = (apart[0] * change[1] - apart[1] * change[0]) / length**2
        for prefix in ("", "rigid_"):
            if f"{prefix}positions" not in frame.fields:
                continue
            offsets = frame.fields[f"{prefix}positions"] - center
            fields[f"{prefix}positions"] = offsets @ turn.T
            if moves and f"{prefix}velocities" in frame.fields:
                carried = np.zeros_like(offsets)
                carried[:, 0], carried[:, 1] = -rate * offsets[:, 1], rate * offsets[:, 0]
                fields[f"{prefix}velocities"] = (frame.fields[f"{prefix}velocities"] - velocity - carried) @ turn.T
        return fields | _turned_bodies(frame, float(np.arctan2(apart[1], apart[0])))


def _turned_bodies(frame: SourceFrame, heading: float) -> dict[str, FloatArray]:
    """The angles or orientations of rigid bodies in a frame turned by an angle [rad] about z."""
    if "angles" in frame.fields:
        return {"angles": frame.fields["angles"] - heading}
    if "orientations" not in frame.fields:
        return {}
    cosine, sine = np.cos(0.5 * heading), -np.sin(0.5 * heading)
    w, x, y, z = frame.fields["orientations"].T
    turned = [cosine * w - sine * z, cosine * x - sine * y, cosine * y + sine * x, cosine * z + sine * w]
    return {"orientations": np.stack(turned, axis=1)}


def corotating(
    camera: Camera | Follow | Corotating | None, found: list[Source]
) -> tuple[Camera | Follow | None, list[Source]]:
    """The camera within its frame of reference, and the sources in that frame."""
    if isinstance(camera, Corotating):
        return camera.camera, [camera.seen(source) for source in found]
    return camera, found


def _member(value: object, path: str) -> Member:
    """A body's key, or a tuple of it and the index of a particle."""
    key, *rest = value if isinstance(value, tuple) and len(value) == 2 else (value,)
    if not isinstance(key, (Body, int, str)) or isinstance(key, bool):
        raise SceneError(f"{path}: must be a body or (body, index), got {shown(value)}")
    return (key, count(rest[0], f"{path}[1]", least=-MOST)) if rest else key


def _weights(scene: Scene, member: Member, path: str) -> FloatArray:
    """The masses (N,) [kg] of the particles of one member of the pair, 0 for all other particles."""
    key, index = member if isinstance(member, tuple) else (member, None)
    try:
        where, body = scene.slice(key), scene.bodies[scene.index(key)]
    except KeyError as error:
        raise SceneError(f"{path}: {error.args[0]}") from None
    if body.is_rigid:
        raise SceneError(f"{path}: must be a body of particles, got {body!r}")
    weights = np.zeros(scene.particles)
    if index is None:
        weights[where] = body.mass
        return weights
    if not -len(body) <= index < len(body):
        raise SceneError(f"{path}[1]: must be from {-len(body)} to {len(body) - 1}, got {index}")
    weights[where][index] = body.mass[index]
    return weights

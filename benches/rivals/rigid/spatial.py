"""Rigid bodies in 3D by rapier3d, MuJoCo and PyBullet, without damping of velocities."""

from __future__ import annotations

import importlib.metadata
from typing import Any

import numpy as np

from rivals import optional
from rivals.rigid.pile import FRICTION, GRAVITY, Array, Pile, State


class Rapier:
    """Rapier, in single precision: small steps with soft contacts, as stiff as Box2D allows with `stiff`."""

    module = "rapier3d"

    def __init__(self, pile: Pile, dt: float, iterations: int = 4, unit: float = 1.0, stiff: bool = False) -> None:
        import rapier3d as rapier

        self.world = rapier.PhysicsWorld(gravity=(0.0, 0.0, -GRAVITY))
        self.world.set_num_threads(1)
        self.world.auto_update_query = False
        parameters = self.world.integration_parameters
        parameters.dt, parameters.num_solver_iterations, parameters.length_unit = dt, iterations, unit
        if stiff:
            spring = rapier.SpringCoefficients(0.25 * iterations / dt, 10.0)
            parameters.contact_softness = parameters.static_contact_softness = spring
        self.world.add_collider(rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(FRICTION).restitution(0.0))
        self.handles = []
        for place, half, (w, x, y, z) in zip(
            pile.positions.tolist(), pile.sizes.tolist(), pile.turns.tolist(), strict=True
        ):
            pose = rapier.Isometry3(tuple(place), rapier.Rotation3.from_quaternion(w, x, y, z))
            body = rapier.RigidBody.dynamic().position(pose).can_sleep(False)
            box = rapier.Collider.cuboid(*half).density(pile.density).friction(FRICTION).restitution(0.0)
            self.handles.append(self.world.add_body(body, colliders=[box]))

    def step(self, steps: int) -> None:
        """Take steps."""
        for _ in range(steps):
            self.world.step()

    def state(self) -> State:
        """Of all bodies."""
        bodies = [self.world.rigid_bodies[handle] for handle in self.handles]
        turns = np.array([body.rotation.to_tuple() for body in bodies])[:, [3, 0, 1, 2]]
        vectors = (
            np.array([(v.x, v.y, v.z) for v in (getattr(body, name) for body in bodies)])
            for name in ("translation", "linvel", "angvel")
        )
        places, velocities, spins = vectors
        return State(places, turns, velocities, spins)


class MuJoCo:
    """MuJoCo: soft contacts by convex optimization in each step, as stiff as a step allows with `stiff`."""

    module = "mujoco"

    def __init__(self, pile: Pile, dt: float, solver: str = "Newton", stiff: bool = False) -> None:
        import mujoco

        self.mujoco, time = mujoco, 2.0 * dt if stiff else 0.02
        bodies = "\n".join(
            f'<body pos="{words(place)}" quat="{words(turn)}"><freejoint/>'
            f'<geom type="box" size="{words(half)}"/></body>'
            for place, turn, half in zip(pile.positions, pile.turns, pile.sizes, strict=True)
        )
        self.model = mujoco.MjModel.from_xml_string(f"""<mujoco>
            <option timestep="{dt}" gravity="0 0 {-GRAVITY}" solver="{solver}"
                jacobian="sparse" cone="pyramidal"/>
            <size memory="2G"/>
            <default>
                <geom density="{pile.density}" friction="{FRICTION} 0 0" solref="{time} 1" condim="3"/>
            </default>
            <worldbody><geom type="plane" size="0 0 1"/>{bodies}</worldbody></mujoco>""")
        self.data = mujoco.MjData(self.model)

    def step(self, steps: int) -> None:
        """Take steps."""
        self.mujoco.mj_step(self.model, self.data, steps)

    def state(self) -> State:
        """Of all bodies; MuJoCo has the angular velocities of free bodies along their own axes."""
        rows, rates = self.data.qpos.reshape(-1, 7), self.data.qvel.reshape(-1, 6)
        spins = in_the_world(rows[:, 3:], rates[:, 3:])
        return State(rows[:, :3].copy(), rows[:, 3:].copy(), rates[:, :3].copy(), spins)


class PyBullet:
    """Bullet, in double precision: impulses, and a second pass over the positions against overlap."""

    module = "pybullet"

    def __init__(self, pile: Pile, dt: float, iterations: int = 50, substeps: int = 1) -> None:
        import pybullet

        self.bullet, self.client = pybullet, pybullet.connect(pybullet.DIRECT)
        bullet, at = pybullet, {"physicsClientId": self.client}
        bullet.setGravity(0.0, 0.0, -GRAVITY, **at)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=dt,
            numSolverIterations=iterations,
            numSubSteps=substeps,
            deterministicOverlappingPairs=0,
            **at,
        )
        ground = bullet.createMultiBody(0.0, bullet.createCollisionShape(bullet.GEOM_PLANE, **at), **at)
        shapes: dict[tuple[float, ...], int] = {}
        self.bodies = []
        for place, half, (w, x, y, z), mass in zip(
            pile.positions.tolist(), pile.sizes.tolist(), pile.turns.tolist(), pile.mass.tolist(), strict=True
        ):
            key = tuple(half)
            if key not in shapes:
                shapes[key] = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, **at)
            self.bodies.append(bullet.createMultiBody(mass, shapes[key], -1, place, (x, y, z, w), **at))
        for body in (ground, *self.bodies):  # the product of the frictions counts
            bullet.changeDynamics(
                body, -1, lateralFriction=FRICTION**0.5, restitution=0.0, linearDamping=0.0, angularDamping=0.0, **at
            )

    def step(self, steps: int) -> None:
        """Take steps."""
        for _ in range(steps):
            self.bullet.stepSimulation(physicsClientId=self.client)

    def state(self) -> State:
        """Of all bodies."""
        poses = [self.bullet.getBasePositionAndOrientation(body, physicsClientId=self.client) for body in self.bodies]
        rates = [self.bullet.getBaseVelocity(body, physicsClientId=self.client) for body in self.bodies]
        places, turns, velocities, spins = (
            np.array(each) for each in (*zip(*poses, strict=True), *zip(*rates, strict=True))
        )
        return State(places, turns[:, [3, 0, 1, 2]], velocities, spins)


def words(numbers: Array) -> str:
    """Numbers in XML."""
    return " ".join(map(repr, numbers.tolist()))


def in_the_world(turns: Array, vectors: Array) -> Array:
    """Vectors along the axes of bodies, along those of the world."""
    axis = turns[:, 1:]
    twice = 2.0 * np.cross(axis, vectors)
    return vectors + turns[:, :1] * twice + np.cross(axis, twice)


def version(peer: Any) -> str | None:
    """Of an engine, None where it is not installed."""
    return optional(peer.module) and f"{peer.module} {importlib.metadata.version(peer.module)}"

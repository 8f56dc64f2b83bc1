//! Rigid bodies under gravity, stepped as matter steps them.

use glam::{DQuat, DVec3};
use physcore_base::parallel::SERIAL;
use physcore_base::scene::{Item, Value};

use crate::island::Meters;
use crate::joints::{Joint, JointKind};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::{Inertia, Orientation};
use crate::shapes::SolidShape;
use crate::surface::{Friction, Surface};
use crate::world::{CenterMotion, FixedSolid, FreeParticles, RigidWorld, SolidBody, Turn, WORLD, WorldJoint};

/// Bodies with their motions.
pub struct Laboratory {
    pub world: RigidWorld,
    pub motions: Vec<CenterMotion>,
    pub gravity: DVec3,
    pub meters: Meters,
    masses: Vec<f64>,
    /// Number of steps in which no body may touch anything, which are found apart from others if so asked.
    pub apart: usize,
    pub is_split: bool,
}

impl Laboratory {
    /// Empty space of a dimension.
    pub fn new(dimension: usize, gravity: DVec3) -> Self {
        let world = RigidWorld::new(dimension == 2);
        let (motions, masses, meters) = (Vec::new(), Vec::new(), Meters::default());
        Self { world, motions, gravity, meters, masses, apart: 0, is_split: true }
    }

    /// Adds a half-space at rest, below a plane through the origin.
    pub fn add_plane(&mut self, normal: DVec3, friction: f64, restitution: f64) {
        self.add_wall(normal, DVec3::ZERO, friction, restitution);
    }

    /// Adds a half-space at rest, below a plane through a point.
    pub fn add_wall(&mut self, normal: DVec3, position: DVec3, friction: f64, restitution: f64) {
        self.world.shapes.push(SolidShape::half_space(normal));
        let friction = Some(Friction { sliding: friction, ..Friction::default() });
        let surface = Surface { shape: self.world.shapes.len() - 1, friction, restitution };
        self.world.walls.push(FixedSolid { surface, mover: Mover::wall(&Pose { position, ..Pose::WORLD }) });
        self.world.wall_names.push("plane".to_owned());
    }

    /// Adds a body of a mass [kg]; an angle in the plane, or a quaternion.
    pub fn add(
        &mut self,
        item: &Item,
        (mass, friction, restitution): (f64, f64, f64),
        (position, orientation): (DVec3, Orientation),
        (velocity, turning): (DVec3, DVec3),
    ) {
        let dimension = if self.world.planar { 2 } else { 3 };
        let (shape, properties) = SolidShape::declared(item, dimension).unwrap();
        self.world.shapes.push(shape);
        let density = mass / properties.size;
        let inertia = if self.world.planar {
            Inertia::planar(density * properties.inertia.z_axis.z)
        } else {
            Inertia::spatial(properties.inertia * density)
        };
        let friction = Some(Friction { sliding: friction, ..Friction::default() });
        let surface = Surface { shape: self.world.shapes.len() - 1, friction, restitution };
        self.world.bodies.push(SolidBody { surface, inverse_mass: 1.0 / mass, inertia });
        self.world.state.turns.push(Turn { orientation, spin: inertia.spin(&orientation, turning) });
        self.world.names.push(format!("body {}", self.motions.len()));
        self.motions.push(CenterMotion::free(position, velocity));
        self.masses.push(mass);
    }

    /// Joins two bodies, or a body and the world, at points of both.
    pub fn join(&mut self, kind: JointKind, ends: [usize; 2], points: [DVec3; 2], axis: DVec3) -> &mut Joint {
        let movers = ends.map(|end| self.mover(end));
        let joint = Joint::new(kind, [&movers[0], &movers[1]], points, axis, self.world.planar);
        self.world.state.joints.push(WorldJoint::new(ends, joint));
        let last = self.world.state.joints.len() - 1;
        &mut self.world.state.joints[last].joint
    }

    /// Body in its present state, or the world.
    pub fn mover(&self, end: usize) -> Mover {
        if end == WORLD { Mover::wall(&Pose::WORLD) } else { self.world.mover(end, &self.motions[end], 1.0) }
    }

    /// Takes steps of `h` seconds.
    pub fn step(&mut self, h: f64, steps: usize) {
        for _ in 0..steps {
            for motion in &mut self.motions {
                motion.drift = motion.velocity + 0.5 * h * self.gravity;
            }
            let motions = &self.motions;
            if self.is_split && self.world.turn_apart(h, &|body| motions[body], &SERIAL) {
                for motion in &mut self.motions {
                    motion.position += h * motion.drift;
                    motion.velocity = motion.drift + 0.5 * h * self.gravity;
                }
                self.apart += 1;
                continue;
            }
            let moved = self.world.drift((h, false), &mut self.motions, FreeParticles::default(), &mut [], &SERIAL);
            for (motion, moved) in self.motions.iter_mut().zip(moved) {
                motion.position += if moved { DVec3::ZERO } else { h * motion.drift };
                motion.velocity = motion.drift + 0.5 * h * self.gravity;
            }
            let meters = self.world.finish(h, &mut self.motions, &mut [], &SERIAL);
            self.meters.dissipated += meters.dissipated;
            self.meters.damped += meters.damped;
            self.meters.work += meters.work;
        }
    }

    /// Energy with all that was dissipated, less the work [J].
    pub fn balance(&self) -> f64 {
        self.energy() + self.meters.dissipated + self.meters.damped - self.meters.work
    }

    /// Largest error of a row of a joint [m] or [rad].
    pub fn opening(&self) -> f64 {
        let of = |each: &WorldJoint| {
            let [one, other] = each.ends.map(|end| self.mover(end));
            each.joint.equations([&one, &other]).iter().map(|(_, error)| error.abs()).fold(0.0, f64::max)
        };
        self.world.state.joints.iter().filter(|joint| !joint.broken).map(of).fold(0.0, f64::max)
    }

    /// Momentum, and angular momentum about the origin.
    pub fn momenta(&self) -> (DVec3, DVec3) {
        let mut sums = (DVec3::ZERO, DVec3::ZERO);
        for (body, (motion, mass)) in self.motions.iter().zip(&self.masses).enumerate() {
            let momentum = *mass * motion.velocity;
            sums.0 += momentum;
            sums.1 += motion.position.cross(momentum) + self.world.state.turns[body].spin;
        }
        sums
    }

    /// Turns all velocities around.
    pub fn reverse(&mut self) {
        self.motions.iter_mut().for_each(|motion| motion.velocity *= -1.0);
        self.world.state.turns.iter_mut().for_each(|turn| turn.spin *= -1.0);
    }

    /// Kinetic and potential energy [J].
    pub fn energy(&self) -> f64 {
        let of = |(motion, mass): (&CenterMotion, &f64)| {
            mass * (0.5 * motion.velocity.length_squared() - self.gravity.dot(motion.position))
        };
        let springs = self.world.spring_energy(|end| self.mover(end));
        self.motions.iter().zip(&self.masses).map(of).sum::<f64>() + self.world.rotational_energy() + springs
    }
}

/// Disc or ball.
pub fn round(kind: &str, radius: f64) -> Item {
    Item::new(kind, [("radius", Value::Number(radius))])
}

/// Rectangle.
pub fn rectangle(width: f64, height: f64) -> Item {
    Item::new("Rectangle", [("width", Value::Number(width)), ("height", Value::Number(height))])
}

/// Cuboid.
pub fn cuboid(a: f64, b: f64, c: f64) -> Item {
    Item::new("Cuboid", [("a", Value::Number(a)), ("b", Value::Number(b)), ("c", Value::Number(c))])
}

/// Orientation by a quaternion (w, x, y, z).
pub fn turned(w: f64, x: f64, y: f64, z: f64) -> Orientation {
    Orientation::spatial(DQuat::from_xyzw(x, y, z, w).normalize())
}

impl Laboratory {
    /// Deepest overlap [m].
    pub fn overlap(&self) -> f64 {
        self.world.overlaps(&self.motions, &[]).iter().map(|overlap| overlap.depth).fold(0.0, f64::max)
    }
}

//! Rigid bodies under gravity, stepped as matter steps them.

use glam::{DMat3, DQuat, DVec3};
use physcore_base::parallel::SERIAL;
use physcore_base::scene::{Item, Value};

use crate::island::{Meters, Surface};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::{Inertia, Orientation};
use crate::rows::Friction;
use crate::shapes::Shape;
use crate::world::{FixedSolid, Motion, RigidWorld, Solid, Turn};

/// Bodies with their motions.
pub struct Laboratory {
    pub world: RigidWorld,
    pub motions: Vec<Motion>,
    pub gravity: DVec3,
    pub meters: Meters,
    masses: Vec<f64>,
}

impl Laboratory {
    /// Empty space of a dimension.
    pub fn new(dimension: usize, gravity: DVec3) -> Self {
        let world = RigidWorld::new(dimension == 2);
        Self { world, motions: Vec::new(), gravity, meters: Meters::default(), masses: Vec::new() }
    }

    /// Adds a half-space at rest, below a plane through the origin.
    pub fn add_plane(&mut self, normal: DVec3, friction: f64, restitution: f64) {
        self.add_wall(normal, DVec3::ZERO, friction, restitution);
    }

    /// Adds a half-space at rest, below a plane through a point.
    pub fn add_wall(&mut self, normal: DVec3, position: DVec3, friction: f64, restitution: f64) {
        self.world.shapes.push(Shape::half_space(normal));
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
        let (shape, properties) = Shape::declared(item, dimension).unwrap();
        self.world.shapes.push(shape);
        let density = mass / properties.size;
        let inertia = if self.world.planar {
            Inertia::planar(density * properties.inertia.z_axis.z)
        } else {
            Inertia::spatial(properties.inertia * density)
        };
        let friction = Some(Friction { sliding: friction, ..Friction::default() });
        let surface = Surface { shape: self.world.shapes.len() - 1, friction, restitution };
        self.world.bodies.push(Solid { surface, inverse_mass: 1.0 / mass, inertia });
        self.world.state.turns.push(Turn { orientation, spin: inertia.spin(&orientation, turning) });
        self.world.names.push(format!("body {}", self.motions.len()));
        self.motions.push(Motion { position, velocity, drift: velocity });
        self.masses.push(mass);
    }

    /// Takes steps of `h` seconds.
    pub fn step(&mut self, h: f64, steps: usize) {
        for _ in 0..steps {
            for motion in &mut self.motions {
                motion.drift = motion.velocity + 0.5 * h * self.gravity;
                motion.position = motion.position;
            }
            let moved = self.world.drift(h, &mut self.motions, &[], &mut [], &SERIAL);
            for (motion, _) in self.motions.iter_mut().zip(moved).filter(|(_, moved)| !moved) {
                motion.position += h * motion.drift;
            }
            let mut velocities: Vec<DVec3> = self.motions.iter().map(|motion| motion.drift + 0.5 * h * self.gravity).collect();
            let meters = self.world.finish(h, &mut velocities, &mut [], &SERIAL);
            self.motions.iter_mut().zip(velocities).for_each(|(motion, velocity)| motion.velocity = velocity);
            self.meters.dissipated += meters.dissipated;
            self.meters.work += meters.work;
        }
    }

    /// Kinetic and potential energy [J].
    pub fn energy(&self) -> f64 {
        let of =
            |(motion, mass): (&Motion, &f64)| mass * (0.5 * motion.velocity.length_squared() - self.gravity.dot(motion.position));
        self.motions.iter().zip(&self.masses).map(of).sum::<f64>() + self.world.rotational_energy()
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

/// Rotation matrix of a body.
pub fn axes(laboratory: &Laboratory, body: usize) -> DMat3 {
    laboratory.world.state.turns[body].orientation.matrix()
}

impl Laboratory {
    /// Deepest overlap [m].
    pub fn overlap(&self) -> f64 {
        self.world.overlaps(&self.motions).iter().map(|overlap| overlap.depth).fold(0.0, f64::max)
    }
}

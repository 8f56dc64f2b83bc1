//! Ballistic stepper: velocity Verlet under uniform gravity, which is exact there, followed by the contact stage. All
//! deviations in a test are therefore due to the contact stage.

use glam::DVec3;
use physcore_engine::contacts::{Before, Contacts};
use physcore_engine::math::{Real, Vector};
use physcore_engine::matter::{Columns, EnergySink, Matter, Properties};
use physcore_engine::scene::{Body, Item, Scene, Value};
use physcore_engine::simd::padded;

/// Item of a boundary with its numbers.
pub fn item(kind: &str, restitution: f64, friction: f64, values: &[(&str, Value)]) -> Item {
    let mut item = Item { kind: kind.to_owned(), ..Item::default() };
    item.values.insert("restitution".to_owned(), Value::Number(restitution));
    item.values.insert("friction".to_owned(), Value::Number(friction));
    item.values.extend(values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())));
    item
}

pub fn plane(point: DVec3, normal: DVec3, restitution: f64, friction: f64) -> Item {
    item("Plane", restitution, friction, &[("point", Value::Vector(point)), ("normal", Value::Vector(normal))])
}

pub fn floor(restitution: f64, friction: f64) -> Item {
    plane(DVec3::ZERO, DVec3::Y, restitution, friction)
}

pub fn cuboid(lower: DVec3, upper: DVec3, restitution: f64, friction: f64) -> Item {
    item("Box", restitution, friction, &[("lower", Value::Vector(lower)), ("upper", Value::Vector(upper))])
}

pub fn sphere(center: DVec3, radius: f64, inside: bool, restitution: f64, friction: f64) -> Item {
    let values = [("center", Value::Vector(center)), ("radius", Value::Number(radius)), ("inside", Value::Flag(inside))];
    item("Sphere", restitution, friction, &values)
}

/// Initial state of one particle.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    pub position: DVec3,
    pub velocity: DVec3,
    pub radius: f64,
    pub mass: f64,
    pub fixed: bool,
}

impl Ball {
    pub fn new(position: DVec3, velocity: DVec3, radius: f64) -> Self {
        Self { position, velocity, radius, mass: 1.0, fixed: false }
    }
}

/// Scene of one body of balls.
pub fn scene(dimension: usize, balls: &[Ball], boundaries: Vec<Item>) -> Scene {
    let body = Body {
        positions: balls.iter().map(|ball| ball.position).collect(),
        velocities: balls.iter().map(|ball| ball.velocity).collect(),
        mass: balls.iter().map(|ball| ball.mass).collect(),
        charge: vec![0.0; balls.len()],
        radius: balls.iter().map(|ball| ball.radius).collect(),
        fixed: balls.iter().map(|ball| ball.fixed).collect(),
        ..Body::default()
    };
    let named = boundaries.into_iter().enumerate().map(|(index, item)| Item { path: format!("boundaries[{index}]"), ..item });
    Scene { dimension, bodies: vec![body], forces: Vec::new(), boundaries: named.collect(), ..Scene::default() }
}

/// Properties of a scene's particles, in the caller's order.
pub fn properties<V: Vector>(scene: &Scene) -> Properties<V> {
    let balls = |each: fn(&Body) -> &Vec<f64>| scene.bodies.iter().flat_map(each).copied().collect::<Vec<f64>>();
    let fixed: Vec<bool> = scene.bodies.iter().flat_map(|body| &body.fixed).copied().collect();
    let mass = balls(|body| &body.mass);
    let mass: Vec<f64> = mass.iter().zip(fixed).map(|(mass, fixed)| if fixed { f64::INFINITY } else { *mass }).collect();
    let bodies = scene.bodies.iter().enumerate();
    Properties {
        charge: balls(|body| &body.charge),
        radius: balls(|body| &body.radius),
        body: bodies.flat_map(|(index, body)| std::iter::repeat_n(index as u32, body.positions.len())).collect(),
        ..Properties::new(mass)
    }
}

/// Balls, walls and gravity.
pub struct Laboratory<V: Vector> {
    pub contacts: Contacts<V>,
    pub properties: Properties<V>,
    pub matter: Matter<V>,
    pub gravity: DVec3,
    before: [Columns<V>; 2],
}

impl<V: Vector> Laboratory<V> {
    pub fn new(balls: &[Ball], boundaries: Vec<Item>, gravity: DVec3) -> Self {
        let scene = scene(V::DIMENSION, balls, boundaries);
        let properties = properties(&scene);
        let contacts = Contacts::build(&scene, &properties).expect("acceptable boundaries").expect("some boundary");
        let mut matter = Matter::zeros(balls.len(), 0, padded(balls.len()));
        for (index, ball) in balls.iter().enumerate() {
            matter.position.set(index, V::narrow(ball.position));
            matter.velocity.set(index, V::narrow(ball.velocity));
        }
        contacts.project_inside(&mut matter.position, &properties).expect("everybody inside");
        let before = [Columns::zeros(balls.len()), Columns::zeros(balls.len())];
        Self { contacts, properties, matter, gravity, before }
    }

    /// Takes a step x ← x + h v + h² g/2, v ← v + h g, and resolves the contacts.
    pub fn step(&mut self, h: f64) {
        self.before[0].copy_from(&self.matter.position);
        self.before[1].copy_from(&self.matter.velocity);
        for index in 0..self.matter.count() {
            let gravity = if self.properties.is_fixed(index) { DVec3::ZERO } else { self.gravity };
            let kick = V::narrow(gravity * (0.5 * h));
            let middle = self.matter.velocity.get(index) + kick;
            self.matter.position.set(index, self.matter.position.get(index) + middle * V::Scalar::from_f64(h));
            self.matter.velocity.set(index, middle + kick);
        }
        let before = Before::part(&self.before[0], &self.before[1], &(0..padded(self.matter.count())));
        self.contacts.resolve(&before, &mut self.matter.blocks(), &self.properties, h);
    }

    pub fn steps(&mut self, count: usize, h: f64) {
        (0..count).for_each(|_| self.step(h));
    }

    pub fn position(&self, index: usize) -> DVec3 {
        self.matter.position.get(index).widen()
    }

    pub fn velocity(&self, index: usize) -> DVec3 {
        self.matter.velocity.get(index).widen()
    }

    pub fn reverse(&mut self) {
        for index in 0..self.matter.count() {
            let velocity = self.matter.velocity.get(index);
            self.matter.velocity.set(index, -velocity);
        }
    }

    /// Kinetic energy plus potential energy in the field of gravity, of all balls that move.
    pub fn energy(&self) -> f64 {
        let moving = (0..self.matter.count()).filter(|&index| !self.properties.is_fixed(index));
        let each = |index| 0.5 * self.velocity(index).length_squared() - self.gravity.dot(self.position(index));
        moving.map(|index| self.properties.mass[index] * each(index)).sum()
    }

    pub fn dissipated(&self) -> f64 {
        self.matter.tallied(EnergySink::Contact)
    }
}

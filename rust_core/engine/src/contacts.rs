//! Contact stage: impacts, sliding and rest of particles on walls, after the integrator and within the same step.
//!
//! The integrator moves every particle without walls. [`Contacts::resolve`] then tests the path of the step, a parabola.
//! Groups of lanes with certain clearance are done ([`clearance`]). The trajectory of any other particle is integrated again
//! from the start of the step, in double precision and from impact to impact ([`trajectory`]). Sliding on supporting walls is
//! part of it ([`support`]). The kinetic energy lost in impacts and friction is tallied exactly. Total plus dissipated energy
//! is therefore as constant as without walls.

use std::ops::Range;

use glam::DVec3;

use crate::boundaries::{self, Boundary, Path, Piece, TerrainPart, Wall};
use crate::error::{Error, Result};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, Columns, EnergySink, Properties, Span};
use crate::scene::{Item, RIGID_BODIES, Scene, Value};
use crate::simd::{dispatch, padded};

mod clearance;
mod support;
mod trajectory;

use clearance::{ContactSweep, Test};
use trajectory::ParticleWalls;

/// Contact tolerance in units of rounding. A distance is a sum of four products and differences, each off by half a unit. The
/// position itself is rounded along each axis.
const CONTACT_TOLERANCE: f64 = 4.0;

/// Tolerances beyond the region of a piece of a wall, in units of rounding. A particle touches the piece up to `WITHIN`. A
/// slide goes on up to `LEFT`, which is larger: a slide that has left a piece does not find it again.
const WITHIN: f64 = 1.0;
const LEFT: f64 = 2.0;

/// Maximum number of projections out of the walls at the end of a step.
const ROUNDS: u32 = 8;

/// All walls of a scene with their contact parameters.
#[derive(Debug)]
pub struct Contacts<V: Vector> {
    surfaces: Vec<ContactWall>,
    tests: Vec<Test<V::Scalar>>,
    /// Particle radii [m], −∞ without contact; one column per set of bodies.
    reach: Vec<Vec<V::Scalar>>,
    names: Vec<&'static str>,
    /// Path of every boundary in the scene.
    paths: Vec<String>,
    /// First particle of every body, in the caller's order.
    first: Vec<usize>,
}

/// A wall with its contact parameters.
#[derive(Debug, Clone)]
pub(crate) struct ContactWall {
    wall: Wall,
    /// Coefficient of restitution e.
    restitution: f64,
    /// Coulomb's coefficient of friction μ.
    friction: f64,
    /// Whether the wall acts on each body.
    bodies: Vec<bool>,
    /// Index of the boundary that the wall belongs to.
    boundary: usize,
}

impl ContactWall {
    /// Pieces of the wall within reach of a particle in an axis-aligned box.
    fn pieces(&self, rounding: f64, (lower, upper): (DVec3, DVec3), radius: f64) -> impl Iterator<Item = Piece<'_>> {
        let reach = radius + self.slack(rounding, lower.abs().max(upper.abs()), radius);
        self.wall.pieces(lower - reach, upper + reach, radius)
    }

    /// Contact tolerance of a particle at `x` beyond its radius [m], for numbers with the relative rounding error
    /// `rounding`.
    fn slack(&self, rounding: f64, x: DVec3, radius: f64) -> f64 {
        CONTACT_TOLERANCE * rounding * (x.abs().max_element() + self.wall.extent() + radius)
    }
}

/// Contact geometry of a particle and a wall.
#[derive(Debug, Clone, Copy)]
pub struct ContactGap {
    /// Index of the wall.
    pub wall: usize,
    /// Distance of the particle's surface from the wall [m].
    pub distance: f64,
    /// Unit normal into the allowed side.
    pub normal: DVec3,
    /// Contact tolerance [m]: the particle touches the wall up to this distance.
    pub slack: f64,
    /// Coefficient of restitution e.
    pub restitution: f64,
}

/// Identifier of a contact partner: a surface, or a part of one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Key {
    /// Index of the surface.
    surface: usize,
    /// Part of the surface, for a wall that has several.
    part: Option<TerrainPart>,
}

/// A block's state at the start of the step.
#[derive(Debug, Clone, Copy)]
pub struct Before<'a, V: Vector> {
    /// Positions relative to the origin [m], padding included; unused past the dimension.
    pub position: [&'a [V::Scalar]; AXES],
    /// Velocities [m/s], padding included; unused past the dimension.
    pub velocity: [&'a [V::Scalar]; AXES],
}

impl<'a, V: Vector> Before<'a, V> {
    /// The state from two spans, positions and velocities.
    pub fn spans([position, velocity]: &'a [Span<'_, V>; 2]) -> Self {
        let part = |span: &'a Span<'_, V>| span.axes.each_ref().map(|axis| &**axis);
        Self { position: part(position), velocity: part(velocity) }
    }

    /// The state of the particles of `range`, padding included.
    pub fn part(position: &'a Columns<V>, velocity: &'a Columns<V>, range: &Range<usize>) -> Self {
        let part = |columns: &'a Columns<V>| {
            std::array::from_fn(|axis| if axis < V::DIMENSION { &columns.axis(axis)[range.clone()] } else { &[][..] })
        };
        Self { position: part(position), velocity: part(velocity) }
    }

    fn position(&self, index: usize) -> DVec3 {
        V::from_axes(|axis| self.position[axis][index]).widen()
    }

    fn velocity(&self, index: usize) -> DVec3 {
        V::from_axes(|axis| self.velocity[axis][index]).widen()
    }
}

impl<V: Vector> Contacts<V> {
    /// Contacts of a scene; None if it has no boundaries.
    ///
    /// # Errors
    /// If a boundary's parameter is invalid, or a particle does not fit into it.
    pub fn build(scene: &Scene, properties: &Properties<V>) -> Result<Option<Self>> {
        // Rigid bodies touch boundaries with their surfaces, not as particles.
        let touches = |body: usize| scene.bodies[body].item.kind != RIGID_BODIES;
        if scene.boundaries.is_empty() || !(scene.bodies.is_empty() || (0..scene.bodies.len()).any(touches)) {
            return Ok(None);
        }
        let starts = scene.bodies.iter().scan(0, |next, body| Some(std::mem::replace(next, *next + body.positions.len())));
        let mut contacts = Self {
            surfaces: Vec::new(),
            tests: Vec::new(),
            reach: Vec::new(),
            names: Vec::new(),
            paths: Vec::new(),
            first: starts.collect(),
        };
        let mut sets: Vec<Vec<bool>> = Vec::new();
        for item in &scene.boundaries {
            let boundary = boundaries::build(item, scene.dimension, properties.origin)?;
            let bodies: Vec<bool> = (0..scene.bodies.len()).map(|body| item.acts_on(body) && touches(body)).collect();
            let set = sets.iter().position(|other| *other == bodies).unwrap_or(sets.len());
            if set == sets.len() {
                contacts.reach.push(reach(properties, &bodies));
                sets.push(bodies.clone());
            }
            contacts.add(item, boundary.as_ref(), &bodies, set)?;
        }
        Ok(Some(contacts))
    }

    fn add(&mut self, item: &Item, boundary: &dyn Boundary, bodies: &[bool], set: usize) -> Result<()> {
        let restitution = item.number("restitution")?;
        if !(0.0..=1.0).contains(&restitution) {
            return Err(item.wrong("restitution", "a number from 0 to 1", Some(&Value::Number(restitution))));
        }
        let friction = item.non_negative("friction")?;
        let largest = self.reach[set].iter().map(|radius| radius.to_f64()).fold(0.0, f64::max);
        let room = room(boundary.walls());
        if largest > room {
            let found = format!("a particle of radius {largest} m");
            return Err(Error::parameter(&item.path, format!("particles of at most {room} m radius, which fit into it"), found));
        }
        let index = self.paths.len();
        self.tests.extend(Test::of(boundary.walls(), set, largest));
        self.surfaces.extend(boundary.walls().iter().map(|wall| ContactWall {
            wall: wall.clone(),
            restitution,
            friction,
            bodies: bodies.to_vec(),
            boundary: index,
        }));
        self.names.push(boundary.name());
        self.paths.push(item.path.clone());
        Ok(())
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let reach: usize = self.reach.iter().map(|column| std::mem::size_of_val(column.as_slice())).sum();
        reach + std::mem::size_of_val(self.surfaces.as_slice()) + std::mem::size_of_val(self.tests.as_slice())
    }

    /// Excludes particles whose contacts are resolved elsewhere.
    pub fn leave_out(&mut self, particles: &[u32]) {
        for column in &mut self.reach {
            particles.iter().for_each(|&index| column[index as usize] = V::Scalar::from_f64(f64::NEG_INFINITY));
        }
    }

    /// Indices of the walls that act on a particle.
    pub fn walls_of(&self, properties: &Properties<V>, index: usize) -> impl Iterator<Item = usize> {
        let body = properties.body[index] as usize;
        (0..self.surfaces.len()).filter(move |&wall| self.surfaces[wall].bodies[body])
    }

    /// Contact geometry of a particle at `x` and a wall, for numbers with the relative rounding error `rounding`.
    pub fn gap(&self, wall: usize, x: DVec3, properties: &Properties<V>, index: usize, rounding: f64) -> ContactGap {
        let (surface, radius) = (&self.surfaces[wall], properties.radius[index]);
        let (distance, normal) = surface.wall.distance(x);
        let slack = surface.slack(rounding, x, radius);
        ContactGap { wall, distance: distance - radius, normal, slack, restitution: surface.restitution }
    }

    /// Curvature of a wall [1/m] at `x` along a unit direction; see [`Wall::curvature`].
    pub fn curvature(&self, wall: usize, x: DVec3, direction: DVec3) -> f64 {
        self.surfaces[wall].wall.curvature(x, direction)
    }

    /// Path and friction coefficient of the first boundary with friction that acts on one of the movable particles; None if
    /// there is none.
    pub fn friction(&self, properties: &Properties<V>, particles: &[u32]) -> Option<(&str, f64)> {
        let rubs = |surface: &&ContactWall| {
            surface.friction > 0.0
                && particles.iter().any(|&index| {
                    !properties.is_fixed(index as usize) && surface.bodies[properties.body[index as usize] as usize]
                })
        };
        self.surfaces.iter().find(rubs).map(|surface| (self.paths[surface.boundary].as_str(), surface.friction))
    }

    /// Projects initial positions inside: moves particles whose surface overlaps a wall along its normal. Returns their
    /// number.
    ///
    /// # Errors
    /// If the center of a particle lies outside a boundary.
    pub fn project_inside(&self, position: &mut Columns<V>, properties: &Properties<V>) -> Result<usize> {
        let mut order: Vec<usize> = (0..properties.count()).filter(|&index| !properties.is_fixed(index)).collect();
        order.sort_unstable_by_key(|&index| properties.caller[index]);
        let mut pushed = 0;
        for index in order {
            let (x, body, radius) = (position.get(index).widen(), properties.body[index] as usize, properties.radius[index]);
            let mut overlaps = false;
            for surface in self.surfaces.iter().filter(|surface| surface.bodies[body]) {
                let distance = surface.wall.distance_within(x, radius).0;
                let slack = surface.slack(V::Scalar::EPSILON, x, radius);
                if distance < -slack {
                    return Err(self.outside(surface, properties, index, x, distance));
                }
                overlaps |= distance < radius - slack;
            }
            position.set(index, self.inside(x, body, radius));
            pushed += usize::from(overlaps);
        }
        Ok(pushed)
    }

    fn outside(&self, surface: &ContactWall, properties: &Properties<V>, index: usize, x: DVec3, distance: f64) -> Error {
        let body = properties.body[index] as usize;
        let index_in_body = properties.caller[index] as usize - self.first[body];
        let (boundary, kind) = (&self.paths[surface.boundary], self.names[surface.boundary]);
        let expected = format!("a center on the allowed side of {boundary} ({kind})");
        let found = format!("{}, which is {:.3e} m outside", x + properties.origin, -distance);
        Error::parameter(format!("bodies[{body}].positions[{index_in_body}]"), expected, found)
    }

    /// Position of a particle displaced to `x` after projection inside the walls; None if `x`, as rounded in the state, is
    /// clear of them.
    pub fn confine(&self, x: DVec3, properties: &Properties<V>, index: usize) -> Option<DVec3> {
        let (body, radius) = (properties.body[index] as usize, properties.radius[index]);
        let rounded = V::narrow(x).widen();
        let mut surfaces = self.surfaces.iter().filter(|surface| surface.bodies[body]);
        let distance = |surface: &ContactWall, x: DVec3| surface.wall.distance_within(x, radius).0;
        let is_entered = surfaces.any(|surface| distance(surface, x).min(distance(surface, rounded)) < radius);
        is_entered.then(|| self.inside(x, body, radius).widen())
    }

    /// Coefficients of friction and restitution of the wall that a particle displaced to `x` enters the farthest; None if `x`
    /// is clear of all walls.
    pub fn coefficients(&self, x: DVec3, properties: &Properties<V>, index: usize) -> Option<[f64; 2]> {
        let (body, radius) = (properties.body[index] as usize, properties.radius[index]);
        let surfaces = self.surfaces.iter().filter(|surface| surface.bodies[body]);
        let depths = surfaces.map(|surface| (surface.wall.distance(x).0 - radius, surface));
        let (_, deepest) = depths.min_by(|(one, _), (other, _)| one.total_cmp(other))?;
        Some([deepest.friction, deepest.restitution])
    }

    /// Nearest representable position to `x` at which a particle of `radius` is outside no wall, if the projections find one.
    fn inside(&self, x: DVec3, body: usize, radius: f64) -> V {
        let mut position = V::narrow(x);
        for round in 0..ROUNDS {
            let mut clear = true;
            // In a narrow wedge the projection out of one wall leads into the other. Later rounds use the mean normal of all
            // nearby walls.
            let together = if round < ROUNDS / 2 { DVec3::ZERO } else { self.away(position.widen(), body, radius) };
            let start = position.widen();
            for piece in self.pieces(start, body, radius) {
                let x = position.widen();
                let (distance, normal) = piece.distance(x, radius, WITHIN);
                if distance < radius {
                    let way = if together.dot(normal) > 0.0 { together / together.dot(normal) } else { normal };
                    // A projection may be rounded back to its start; later ones reach further.
                    let extra = 0.25 * f64::from(1 << round) * V::Scalar::EPSILON * x.abs().max_element();
                    position = V::narrow(x + way * (radius - distance + extra));
                    clear = false;
                }
            }
            if clear {
                break;
            }
        }
        position
    }

    /// Mean normal of the touched walls.
    fn away(&self, x: DVec3, body: usize, radius: f64) -> DVec3 {
        let mut away = DVec3::ZERO;
        for surface in self.surfaces.iter().filter(|surface| surface.bodies[body]) {
            for piece in surface.pieces(V::Scalar::EPSILON, (x, x), radius) {
                let slack = surface.slack(V::Scalar::EPSILON, x, radius);
                let (distance, normal) = piece.distance(x, radius + slack, WITHIN);
                if distance - radius <= slack {
                    away += normal;
                }
            }
        }
        away.normalize_or_zero()
    }

    /// Pieces of walls within reach of a particle at `x`.
    fn pieces(&self, x: DVec3, body: usize, radius: f64) -> impl Iterator<Item = Piece<'_>> {
        let surfaces = self.surfaces.iter().filter(move |surface| surface.bodies[body]);
        surfaces.flat_map(move |surface| surface.pieces(V::Scalar::EPSILON, (x, x), radius))
    }

    /// Resolves the contacts of one block after the integrator's step of `h` from the state `before`.
    pub fn resolve(&self, before: &Before<'_, V>, block: &mut Blocks<'_, V>, properties: &Properties<V>, h: f64) {
        dispatch(ContactSweep { contacts: self, before, block, properties, h });
    }

    /// Integrates one particle's step again, from contact to contact, if the particle touches a wall.
    #[cold]
    #[inline(never)]
    fn trajectory(&self, before: &Before<'_, V>, block: &mut Blocks<'_, V>, properties: &Properties<V>, h: f64, lane: usize) {
        let index = block.start + lane;
        let (body, radius) = (properties.body[index] as usize, properties.radius[index]);
        let (x_old, v_old) = (before.position(lane), before.velocity(lane));
        let (x_new, v_new) = (block.position.get(lane).widen(), block.velocity.get(lane).widen());
        if !(x_old + v_old + x_new + v_new).is_finite() {
            return;
        }
        let acceleration = (v_new - v_old) / h;
        // The parabola through both positions; its slope is the velocity up to the truncation error of the integrator.
        let path = Path { position: x_old, velocity: (x_new - x_old) / h - acceleration * (0.5 * h), acceleration };
        let walls = ParticleWalls { surfaces: &self.surfaces, body, radius, rounding: V::Scalar::EPSILON };
        if let Some(end) = walls.trajectory(&path, v_old, h) {
            block.position.set(lane, self.inside(end.position, body, radius));
            if !block.residual.is_empty() {
                block.residual.set(lane, V::default());
            }
            block.velocity.set(lane, V::narrow(end.velocity));
            block.tallies[0].add(EnergySink::Contact, properties.mass[index] * end.lost);
        }
    }
}

/// Radii of the movable particles of the given bodies; −∞ for all others and the padding.
fn reach<V: Vector>(properties: &Properties<V>, bodies: &[bool]) -> Vec<V::Scalar> {
    let mut reach = vec![V::Scalar::from_f64(f64::NEG_INFINITY); padded(properties.count())];
    for (index, radius) in properties.radius.iter().enumerate() {
        if bodies[properties.body[index] as usize] && !properties.is_fixed(index) {
            reach[index] = V::Scalar::from_f64(*radius);
        }
    }
    reach
}

/// Largest particle radius that fits between the walls of one boundary.
fn room(walls: &[Wall]) -> f64 {
    let mut room = f64::INFINITY;
    for (index, wall) in walls.iter().enumerate() {
        match *wall {
            Wall::Sphere { radius, inside, .. } if inside => room = room.min(radius),
            Wall::Sphere { .. } | Wall::Solid(_) | Wall::Terrain(_) => {}
            Wall::Plane { normal, offset } => {
                for other in &walls[index + 1..] {
                    if let Wall::Plane { normal: opposite, offset: behind } = *other
                        && opposite == -normal
                    {
                        room = room.min(0.5 * (-behind - offset));
                    }
                }
            }
        }
    }
    room
}

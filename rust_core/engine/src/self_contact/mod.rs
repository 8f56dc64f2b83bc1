//! Contact of meshes with themselves and with each other: nothing passes through, and distances stay at the thickness.
//!
//! A step moves vertices along straight paths. [`mesh`] finds the pairs, vertex and triangle or edge and edge, that may touch on
//! the way ([`nearby`] keeps the list complete as ways change); those whose closest points are within both elements, or locally closest,
//! are contacts, whose impulses keep them from closing to less than the thickness ([`impulses`]). Conservative advancement then looks
//! at all pairs on the new paths ([`advancement`]): what still meets becomes a contact as it meets, and if some rounds of that do not
//! help, particles move on together ([`zones`]). So no path of a step lets an edge through a triangle, whatever its length.
//!
//! The same impulses hold springs at their strain limits ([`limits`]).

use glam::DVec3;
use robust::{Coord3D, orient3d};

mod advancement;
mod distance;
mod impulses;
mod limits;
mod mesh;
mod nearby;
mod tree;
mod zones;

use distance::{Closest, combined};
use impulses::{Contact, Origin};
use limits::Limit;
use mesh::{Mesh, NONE, Pair, Rule};
use nearby::{Near, Nearby};
use tree::{Bounds, Swept};
use zones::Zones;

use crate::error::{Error, Result};
use crate::forces::springs::{self, Spring};
use crate::history::{Archive, History};
use crate::math::Vector;
use crate::matter::Properties;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::{Body, Item, Scene, Value};

/// The kind of the items.
pub const KIND: &str = "SelfContact";

/// The distance that is always kept, in units of the thickness, and of the present distance where that is less.
const KEPT: f64 = 0.5;
const KEPT_OF_PRESENT: f64 = 0.5;
/// Rounds in which what meets becomes a contact, rounds in which zones grow, and corrections of a zone at walls.
const ROUNDS: u32 = 6;
const MERGERS: u32 = 1000;
const WALLS: u32 = 8;
/// The excess over a longest length that is said, relative to that.
const NOTED: f64 = 0.01;
/// Pairs that one thread measures at a time.
const BLOCK: usize = 1024;

/// A step in which particles pass through each other that have to keep their velocities.
#[derive(Debug, Clone, Copy)]
pub struct Unresolved {
    /// One of them.
    pub particle: usize,
}

/// Keeps particles inside walls: a new position, where one is outside.
pub type Confine<'a> = dyn Fn(usize, DVec3) -> Option<DVec3> + Sync + 'a;

/// A step, the walls around it, and the threads for it.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// Its size [s].
    pub h: f64,
    /// The walls.
    pub confine: &'a Confine<'a>,
    /// The threads.
    pub executor: &'a Executor,
}

/// A body's triangles and free edges, with the springs along the sides of each.
#[derive(Debug, Clone, Default)]
struct Surface {
    faces: Vec<([u32; 3], Vec<u32>)>,
    edges: Vec<([u32; 2], Vec<u32>)>,
}

/// The forces of contacts [N].
#[derive(Debug, Clone, Default)]
struct Loads {
    /// Of pairs, by their keys.
    pairs: Vec<(u64, f64)>,
    /// Of vertices on walls, with the normal there.
    walls: Vec<(u32, DVec3, f64)>,
}

impl Loads {
    fn new(contacts: &[Contact], h: f64) -> Self {
        let (mut pairs, mut walls) = (Vec::new(), Vec::new());
        for contact in contacts.iter().filter(|contact| contact.impulse > 0.0) {
            match contact.origin {
                Origin::Pair(key) => pairs.push((key, contact.impulse / h)),
                Origin::Wall => walls.push((contact.nodes[0], contact.normal, contact.impulse / h)),
                Origin::Way => {}
            }
        }
        pairs.sort_unstable_by_key(|&(key, _)| key);
        Self { pairs, walls }
    }

    /// The force of a pair.
    fn of(&self, key: u64) -> Option<f64> {
        self.pairs.binary_search_by_key(&key, |&(key, _)| key).ok().map(|index| self.pairs[index].1)
    }
}

/// The contacts of meshes.
#[derive(Debug, Clone, Default)]
pub struct SelfContacts {
    rules: Vec<Rule>,
    /// The rule of each pair of bodies, row by row.
    table: Vec<u32>,
    surfaces: Vec<Surface>,
    /// All springs with a strain limit, and those that are whole.
    limits: Vec<Limit>,
    limited: Vec<Limit>,
    mesh: Mesh,
    nearby: Nearby,
    /// The vertices of all meshes.
    vertices: Vec<u32>,
    inverse_mass: Vec<f64>,
    /// Positions [m] and velocities [m/s] at the start of the step.
    start: Vec<DVec3>,
    start_velocities: Vec<DVec3>,
    /// The contacts of the last step.
    loads: Loads,
    saved: Loads,
    /// Steps in which particles moved on together.
    merged: u64,
    /// The largest excess of a spring over its longest length, relative to that.
    excess: f64,
}

impl SelfContacts {
    /// The contacts and strain limits that a scene with these springs declares, if there are any.
    ///
    /// # Errors
    /// If a value is wrong, or two items are about the same bodies.
    pub fn build<V: Vector>(scene: &Scene, springs: &[Spring], properties: &Properties<V>) -> Result<Option<Self>> {
        let items: Vec<&Item> = scene.constraints.iter().filter(|item| item.kind == KIND).collect();
        let limits = Limit::declared(scene, springs)?;
        let Some(path) = items.first().map(|item| item.path.as_str()).or((!limits.is_empty()).then_some("strain_limit")) else {
            return Ok(None);
        };
        if scene.dimension != 3 && !items.is_empty() {
            return Err(Error::parameter(path, "a scene in 3D", format!("one in {}D", scene.dimension)));
        }
        if scene.periodic.is_some() {
            return Err(Error::parameter(path, "no Periodic domain", "one")
                .with_hint("contacts and lengths are those of the bodies themselves, not of their images"));
        }
        let mut bodies: Vec<usize> = Vec::new();
        let mut place = |body: usize| {
            bodies.iter().position(|&known| known == body).unwrap_or_else(|| {
                bodies.push(body);
                bodies.len() - 1
            })
        };
        let (mut rules, mut pairs) = (Vec::new(), Vec::new());
        for item in items {
            let own = match item.values.get("body") {
                Some(Value::Indices(array)) if array.entries.len() == 1 => array.entries[0] as usize,
                other => return Err(item.wrong("body", "a body", other)),
            };
            let thickness = item.number("thickness")?;
            if thickness <= 0.0 {
                return Err(item.wrong("thickness", "a number > 0", Some(&Value::Number(thickness))));
            }
            let restitution = item.number("restitution")?;
            rules.push(Rule { thickness, friction: item.non_negative("friction")?, restitution });
            let one = place(own);
            for other in item.on.iter().flatten().copied().chain([own]) {
                pairs.push((item, one, place(other), rules.len() as u32 - 1));
            }
        }
        let size = bodies.len();
        let mut table = vec![NONE; size * size];
        for (item, one, other, rule) in pairs {
            if table[one * size + other] != NONE {
                return Err(Error::parameter(&item.path, "one SelfContact for two bodies", "a second one"));
            }
            (table[one * size + other], table[other * size + one]) = (rule, rule);
        }
        let engine = properties.engine();
        let surfaces: Vec<Surface> = bodies.iter().map(|&body| surface(scene, body, &engine)).collect::<Result<_>>()?;
        let inverse_mass = properties.mass.iter().map(|mass| 1.0 / mass).collect();
        let start = properties.relative(&scene.positions());
        let mut contacts = Self { rules, table, surfaces, limits, inverse_mass, start, ..Self::default() };
        contacts.leave_out(&[]);
        Ok(Some(contacts))
    }

    /// Takes the springs that are not broken, and the triangles and free edges along which none is.
    pub fn leave_out(&mut self, broken: &[bool]) {
        let whole = |springs: &[u32]| springs.iter().all(|&spring| !broken.get(spring as usize).copied().unwrap_or(false));
        self.limited = self.limits.iter().filter(|limit| whole(&[limit.spring])).copied().collect();
        let bodies: Vec<mesh::Body> = self
            .surfaces
            .iter()
            .map(|Surface { faces, edges }| {
                let faces = faces.iter().filter(|(_, sides)| whole(sides)).map(|&(face, _)| face).collect();
                (faces, edges.iter().filter(|(_, springs)| whole(springs)).map(|&(edge, _)| edge).collect())
            })
            .collect();
        let count = self.inverse_mass.len();
        self.mesh = Mesh::new(&bodies, self.table.clone(), count);
        self.vertices = self.mesh.vertices().chain(self.limited.iter().flat_map(|limit| limit.ends)).collect();
        self.vertices.sort_unstable();
        self.vertices.dedup();
    }

    /// Looks at the state of a first step.
    ///
    /// # Errors
    /// The particles of an edge that is within a triangle.
    pub fn check(&mut self, position: impl Fn(usize) -> DVec3, executor: &Executor) -> std::result::Result<(), [u32; 2]> {
        self.begin(|index| [position(index), DVec3::ZERO]);
        let x = &self.start;
        let longest = self.mesh.edges.iter().map(|&[a, b]| (x[a as usize] - x[b as usize]).length()).fold(0.0, f64::max);
        let around = |&x: &DVec3| Swept { from: Bounds::around(x, longest), way: Bounds::around(DVec3::ZERO, 0.0) };
        let boxes: Vec<Swept> = x.iter().map(around).collect();
        let all = vec![true; x.len()];
        self.mesh.sort(|vertex| self.start[vertex as usize]);
        let mut found = Vec::new();
        self.mesh.pairs(&boxes, &all, executor, &mut found, &|pair, _, _| pair.has_face().then_some(pair));
        for pair in found.into_iter().flatten() {
            let [vertex, corners @ ..] = pair.nodes;
            let [p, a, b, c] = pair.gather(x);
            for &end in self.mesh.neighbors(vertex).iter().filter(|&end| !corners.contains(end)) {
                if pierces([p, x[end as usize]], [a, b, c]) {
                    return Err([vertex, end]);
                }
            }
        }
        Ok(())
    }

    /// Takes the positions [m] and velocities [m/s] at the start of a step.
    pub fn begin(&mut self, state: impl Fn(usize) -> [DVec3; 2]) {
        self.start_velocities.resize(self.start.len(), DVec3::ZERO);
        for (index, (start, velocity)) in self.start.iter_mut().zip(&mut self.start_velocities).enumerate() {
            [*start, *velocity] = state(index);
        }
    }

    /// The velocities at the start of the step [m/s].
    pub fn start_velocities(&self) -> &[DVec3] {
        &self.start_velocities
    }

    /// The positions at the start of the step [m].
    pub fn start(&self) -> &[DVec3] {
        &self.start
    }

    /// Changes the mean velocities of a step of `h` seconds so that nothing passes through; returns whether it did.
    ///
    /// # Errors
    /// If particles that have to keep their velocities pass through each other.
    pub fn resolve(&mut self, velocities: &mut Vec<DVec3>, step: Step<'_>) -> std::result::Result<bool, Unresolved> {
        let h = step.h;
        let thickness = self.rules.iter().map(|rule| rule.thickness).fold(0.0, f64::max);
        let finite = |&vertex: &u32| (self.start[vertex as usize] + velocities[vertex as usize]).is_finite();
        if !self.vertices.iter().all(finite) {
            return Ok(false);
        }
        let free = velocities.clone();
        self.mesh.sort(|vertex| self.start[vertex as usize]);
        self.nearby.begin(&self.vertices, &self.start, [&free, &self.start_velocities], h, thickness);
        self.cover(&free, step);
        let mut contacts = self.early(&free, step);
        contacts.extend(self.loads.walls.iter().filter_map(|wall| self.resting(wall, thickness, step)));
        let mut held = vec![false; free.len()];
        contacts.iter().filter(|contact| contact.origin == Origin::Wall).for_each(|wall| held[wall.nodes[0] as usize] = true);
        let mut taut = vec![None; self.limited.len()];
        self.tauten(&mut taut, &mut contacts, &free, h);
        impulses::start(&mut contacts, velocities);
        impulses::solve(&mut contacts, velocities);
        for round in 0..=ROUNDS {
            let known = contacts.len();
            let longer = self.tauten(&mut taut, &mut contacts, velocities, h);
            for &vertex in &self.vertices {
                if velocities[vertex as usize] == free[vertex as usize] {
                    continue;
                }
                let [from, to] = self.path(vertex, velocities, h);
                if let Some(inside) = (step.confine)(vertex as usize, to) {
                    if !std::mem::replace(&mut held[vertex as usize], true) {
                        contacts.extend(self.wall(vertex, [from, to], inside, h));
                    }
                    velocities[vertex as usize] = (inside - from) / h;
                }
            }
            self.cover(velocities, step);
            let met = self.meetings(velocities, step, |_| true);
            // What presses on what a wall holds is solved together with it, once.
            if met.is_empty() && !longer && (round > 0 || contacts.len() == known) {
                break;
            }
            if round == ROUNDS {
                self.merge(met, velocities, step)?;
                break;
            }
            contacts.extend(met.iter().filter_map(|(near, closest)| self.late(near, closest, h)));
            impulses::solve(&mut contacts, velocities);
        }
        let held = self.limited.iter().zip(&taut).filter(|(_, taut)| taut.is_some());
        self.excess = held.map(|(limit, _)| limit.excess(&self.start, velocities, h)).fold(self.excess, f64::max);
        self.loads = Loads::new(&contacts, h);
        Ok(*velocities != free)
    }

    /// Adds the constraints of springs that exceed their longest lengths, or renews them; returns whether one does by more than the
    /// tolerance. `taut` are the constraints of all.
    fn tauten(&self, taut: &mut [Option<usize>], contacts: &mut Vec<Contact>, velocities: &[DVec3], h: f64) -> bool {
        let mut largest = 0.0_f64;
        for (limit, taut) in self.limited.iter().zip(taut) {
            let excess = limit.excess(&self.start, velocities, h);
            if excess <= 0.0 {
                continue;
            }
            let needed = limit.needed(&self.start, velocities, h);
            if let Some(index) = *taut {
                contacts[index].least = needed.1;
            } else {
                let impulse = h * self.loads.of(limit.key()).unwrap_or(0.0);
                let Some(constraint) = limit.constraint(needed, impulse, &self.inverse_mass) else { continue };
                *taut = Some(contacts.len());
                contacts.push(constraint);
            }
            largest = largest.max(excess);
        }
        largest > limits::TOLERANCE
    }

    /// Finds the pairs that may touch with these velocities.
    fn cover(&mut self, velocities: &[DVec3], Step { h, executor, .. }: Step<'_>) {
        let paths = (self.start.as_slice(), velocities);
        self.nearby.cover((&mut self.mesh, &self.rules), &self.vertices, paths, h, executor);
    }

    fn path(&self, vertex: u32, velocities: &[DVec3], h: f64) -> [DVec3; 2] {
        let from = self.start[vertex as usize];
        [from, from + h * velocities[vertex as usize]]
    }

    /// The contacts of the pairs that may come nearer than the thickness, the nearest first, with the impulses of the last step. Closest points on a boundary are those of several pairs: one of these counts, if it is locally closest.
    fn early(&self, free: &[DVec3], Step { h, .. }: Step<'_>) -> Vec<Contact> {
        let counts = |&&Near { ref pair, ref closest, distance }: &&Near| {
            let (travel, _) = advancement::relative(&pair.gather(free).map(|velocity| h * velocity), pair.split());
            let reached = distance - travel < self.rules[pair.rule as usize].thickness && distance > 0.0;
            reached && (closest.interior || self.is_local(pair, closest))
        };
        let contact = |&Near { ref pair, ref closest, distance }: &Near| {
            let rule = &self.rules[pair.rule as usize];
            let normal = closest.separation / distance;
            let approach = normal.dot(combined(&closest.weights, &pair.gather(free)));
            let known = self.loads.of(pair.key);
            let least = ((rule.thickness - distance) / h).min(0.0);
            // What touched in the last step rests; what arrives bounces.
            let bounces = known.is_none() && approach < least;
            let least = if bounces { least.max(-rule.restitution * approach) } else { least };
            let mut contact = Contact::new(
                (pair.nodes, Origin::Pair(pair.key)),
                closest.weights,
                normal,
                (least, rule.friction),
                &self.inverse_mass,
            )?;
            contact.impulse = known.map_or(0.0, |load| h * load);
            Some(contact)
        };
        let mut near: Vec<&Near> = self.nearby.pairs.iter().filter(counts).collect();
        near.sort_unstable_by(|one, other| one.order(other));
        near.into_iter().filter_map(contact).collect()
    }

    /// The contact of a pair as it meets on its way.
    fn late(&self, &Near { ref pair, distance, .. }: &Near, closest: &Closest, h: f64) -> Option<Contact> {
        let rule = &self.rules[pair.rule as usize];
        let normal = closest.separation.normalize_or_zero();
        let gap = normal.dot(combined(&closest.weights, &pair.gather(&self.start)));
        let least = ((distance.min(rule.thickness) - gap) / h).min(0.0);
        Contact::new((pair.nodes, Origin::Way), closest.weights, normal, (least, rule.friction), &self.inverse_mass)
    }

    /// The contact of a vertex that was on a wall in the last step, if it is within the thickness of one.
    fn resting(
        &self,
        &(vertex, normal, load): &(u32, DVec3, f64),
        thickness: f64,
        Step { h, confine, .. }: Step<'_>,
    ) -> Option<Contact> {
        let from = self.start[vertex as usize];
        let beyond = from - thickness * normal;
        let mut wall = self.wall(vertex, [from, beyond], confine(vertex as usize, beyond)?, h)?;
        wall.impulse = h * load;
        Some(wall)
    }

    /// The contact of a vertex on a path with the walls that it would leave.
    fn wall(&self, vertex: u32, [from, to]: [DVec3; 2], inside: DVec3, h: f64) -> Option<Contact> {
        let way = (inside - to).length();
        let normal = (inside - to) / way;
        // What solving leaves of a velocity is no reason for another round.
        (way > impulses::CONVERGED * (to - from).length()).then_some(())?;
        let least = normal.dot(inside - from) / h;
        Contact::new(([vertex; 4], Origin::Wall), [1.0, 0.0, 0.0, 0.0], normal, (least, 0.0), &self.inverse_mass)
    }

    /// The pairs among these that come too near each other, the nearest first, and how.
    fn meetings(
        &self,
        velocities: &[DVec3],
        Step { h, executor, .. }: Step<'_>,
        among: impl Fn(&Pair) -> bool + Sync,
    ) -> Vec<(Near, Closest)> {
        let near = &self.nearby.pairs;
        let mut found: Vec<Vec<(Near, Closest)>> = vec![Vec::new(); near.len().div_ceil(BLOCK)];
        executor.for_each_block(BlockedSlice::new(&mut found, 1), &|work: BlockedSlice<'_, Vec<(Near, Closest)>>| {
            let first = work.start * BLOCK;
            for near in near[first..near.len().min(first + BLOCK)].iter().filter(|near| among(&near.pair)) {
                let (pair, distance) = (&near.pair, near.distance);
                let motion = advancement::relative(&pair.gather(velocities).map(|velocity| h * velocity), pair.split());
                let least = (KEPT * self.rules[pair.rule as usize].thickness).min(KEPT_OF_PRESENT * distance);
                if distance - motion.0 <= least {
                    let met = advancement::meeting(|x| pair.measure(x), pair.gather(&self.start), motion, least);
                    work.items[0].extend(met.map(|closest| (*near, closest)));
                }
            }
        });
        let mut found = found.concat();
        found.sort_unstable_by(|(one, _), (other, _)| one.order(other));
        found
    }

    /// Lets particles move on together until no pair meets.
    fn merge(
        &mut self,
        mut met: Vec<(Near, Closest)>,
        velocities: &mut [DVec3],
        step: Step<'_>,
    ) -> std::result::Result<(), Unresolved> {
        self.merged += u64::from(!met.is_empty());
        let mut zones = Zones::new(self.start.len());
        let mut last = 0;
        for _ in 0..MERGERS {
            if met.is_empty() {
                return Ok(());
            }
            last = met[0].0.pair.nodes[0] as usize;
            met.iter().for_each(|(near, _)| zones.join(&near.pair.nodes));
            zones.merge(&self.inverse_mass, velocities, |members, velocity| self.within_walls(members, velocity, step));
            self.cover(velocities, step);
            met = self.meetings(velocities, step, |pair| pair.nodes.iter().any(|&node| zones.contains(node)));
        }
        Err(Unresolved { particle: last })
    }

    /// The velocity of particles that move together, without what leads one of them out of the walls; 0 if that is not found.
    fn within_walls(&self, members: &[u32], mut velocity: DVec3, Step { h, confine, .. }: Step<'_>) -> DVec3 {
        for _ in 0..WALLS {
            let way_back = |&vertex: &u32| {
                let to = self.start[vertex as usize] + h * velocity;
                confine(vertex as usize, to).map(|inside| inside - to)
            };
            let farthest = members.iter().filter_map(way_back).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
            let Some(way) = farthest else { return velocity };
            velocity += way / h;
        }
        DVec3::ZERO
    }

    /// Whether nothing near the closest points of a pair is closer.
    fn is_local(&self, pair: &Pair, closest: &Closest) -> bool {
        let x = &self.start;
        let (p, weights) = (closest.separation, &closest.weights);
        let alone = |vertex: u32, toward: DVec3| {
            let neighbors = self.mesh.neighbors(vertex);
            neighbors.iter().all(|&neighbor| toward.dot(x[neighbor as usize] - x[vertex as usize]) <= 0.0)
        };
        if pair.has_face() {
            return closest.interior && alone(pair.nodes[0], -p);
        }
        let edges = [(pair.key >> 32) as u32, pair.key as u32];
        let mut ends = 0;
        (0..2).all(|side| {
            let [a, b] = [pair.nodes[2 * side], pair.nodes[2 * side + 1]];
            let along = weights[2 * side + 1].abs();
            let toward = if side == 0 { -p } else { p };
            if along > 0.0 && along < 1.0 {
                let point = (1.0 - along) * x[a as usize] + along * x[b as usize];
                let opposite = self.mesh.opposite[edges[side] as usize];
                opposite.iter().all(|&vertex| vertex == a || vertex == b || toward.dot(x[vertex as usize] - point) <= 0.0)
            } else {
                // All edges at a vertex have it as their closest point: that to its first neighbor stands for them.
                ends += 1;
                let [vertex, other] = if along <= 0.0 { [a, b] } else { [b, a] };
                ends == 1 && self.mesh.neighbors(vertex).first() == Some(&other) && alone(vertex, toward)
            }
        })
    }

    /// The names of its parts, with what they are about.
    pub fn stages(&self) -> Vec<(&'static str, String)> {
        let contact = ("self-contact", format!("a tree of {} triangles and free edges", self.elements()));
        let limits = ("strain limits", format!("{} springs, which are rods at their longest", self.limits.len()));
        let parts = [(self.elements() > 0, contact), (!self.limits.is_empty(), limits)];
        parts.into_iter().filter(|(used, _)| *used).map(|(_, part)| part).collect()
    }

    /// The number of triangles and free edges.
    pub fn elements(&self) -> usize {
        self.mesh.elements.len()
    }

    /// Notes for the plan on the steps so far.
    pub fn notes(&self) -> Vec<String> {
        let merged = format!(
            "self-contact: in {} steps some particles moved on together, because no impulses kept them apart; shorter steps do",
            self.merged
        );
        let excess = format!(
            "strain limits: a spring was {:.1} % longer than its longest length; shorter steps hold it better",
            100.0 * self.excess
        );
        let notes = [(self.merged > 0, merged), (self.excess > NOTED, excess)];
        notes.into_iter().filter(|(holds, _)| *holds).map(|(_, note)| note).collect()
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let loads = size_of_val(self.loads.pairs.as_slice()) + size_of_val(self.loads.walls.as_slice());
        self.mesh.bytes()
            + self.nearby.bytes()
            + 2 * size_of_val(self.start.as_slice())
            + size_of_val(self.inverse_mass.as_slice())
            + loads
    }
}

/// Whether an edge passes through a triangle, decided without rounding.
fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let point = |x: DVec3| Coord3D { x: x.x, y: x.y, z: x.z };
    let side = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| orient3d(point(a), point(b), point(c), point(d));
    let turns = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    let around = turns.iter().all(|&turn| turn > 0.0) || turns.iter().all(|&turn| turn < 0.0);
    around && side(a, b, c, p) * side(a, b, c, q).signum() < 0.0
}

/// The triangles of a body, or its springs where it has none, in the engine's order.
fn surface(scene: &Scene, body: usize, engine: &[u32]) -> Result<Surface> {
    let first = scene.first(body);
    let networks = scene.bodies[..body].iter().filter(|body| body.item.kind == springs::KIND);
    let spring: usize = networks.map(|body| body.item.tuples::<2>("pairs").map(<[_]>::len)).sum::<Result<usize>>()?;
    let Body { item, .. } = &scene.bodies[body];
    let pairs = item.tuples::<2>("pairs")?;
    let number = |index: &u32| engine[first + *index as usize];
    let faces = item.tuples::<3>("faces").unwrap_or(&[]);
    let mut springs: Vec<([u32; 2], u32)> =
        pairs.iter().zip(spring as u32..).map(|(&[a, b], spring)| ([a.min(b), a.max(b)], spring)).collect();
    springs.sort_unstable();
    let along = |a: u32, b: u32| {
        let key = [a.min(b), a.max(b)];
        let from = springs.partition_point(|(ends, _)| *ends < key);
        springs[from..].iter().take_while(move |(ends, _)| *ends == key).map(|&(_, spring)| spring).collect::<Vec<u32>>()
    };
    let face = |corners: &[u32; 3]| {
        let sides = (0..3).flat_map(|corner| along(corners[corner], corners[(corner + 1) % 3])).collect();
        (corners.map(|corner| number(&corner)), sides)
    };
    let edge = |ends: &[u32; 2]| (ends.map(|end| number(&end)), along(ends[0], ends[1]));
    let edges = if faces.is_empty() { pairs.iter().map(edge).collect() } else { Vec::new() };
    Ok(Surface { faces: faces.iter().map(face).collect(), edges })
}

/// The loads of the last step's contacts.
impl History for SelfContacts {
    fn save(&mut self) {
        self.saved.clone_from(&self.loads);
    }

    fn rollback(&mut self) {
        self.loads.clone_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        let Loads { pairs, walls } = &self.loads;
        archive.write([pairs.len() as f64, walls.len() as f64]);
        // The two halves of a key are whole numbers, which doubles hold.
        archive.write(pairs.iter().flat_map(|&(key, load)| [(key >> 32) as f64, (key & 0xffff_ffff) as f64, load]));
        archive.write(walls.iter().flat_map(|&(vertex, normal, load)| [f64::from(vertex), normal.x, normal.y, normal.z, load]));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let counts = [archive.read(1)?[0], archive.read(1)?[0]].map(|count| count as usize);
        let pairs = archive.read(3 * counts[0])?.as_chunks::<3>().0.iter();
        self.loads.pairs = pairs.map(|&[high, low, load]| ((high as u64) << 32 | low as u64, load)).collect();
        let walls = archive.read(5 * counts[1])?.as_chunks::<5>().0.iter();
        self.loads.walls = walls.map(|&[vertex, x, y, z, load]| (vertex as u32, DVec3::new(x, y, z), load)).collect();
        Ok(())
    }
}

//! Contact of meshes with themselves and with each other: nothing passes through, and distances stay at the thickness.
//!
//! A step moves vertices along straight paths. [`mesh`] finds the pairs, vertex and triangle or edge and edge, that may touch on
//! the way; those whose closest points are within both elements, or locally closest, are contacts, whose impulses keep them from
//! closing to less than the thickness ([`impulses`]). Conservative advancement then looks at all pairs on the new paths
//! ([`advancement`]): what still meets becomes a contact as it meets, and if some rounds of that do not help, particles move on
//! together ([`zones`]). So no path of a step lets an edge through a triangle, whatever its length.

use glam::DVec3;
use robust::{Coord3D, orient3d};

mod advancement;
mod distance;
mod impulses;
mod mesh;
mod tree;
mod zones;

use distance::{Closest, combined, edge_edge, vertex_face};
use impulses::Contact;
use mesh::{Mesh, NONE, Pair, Rule};
use tree::Bounds;
use zones::Zones;

use crate::error::{Error, Result};
use crate::forces::springs;
use crate::history::{Archive, History};
use crate::math::Vector;
use crate::matter::Properties;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::{Body, Item, Scene, Value};

/// The kind of the items.
pub const KIND: &str = "SelfContact";

/// By how much impulses may lead a vertex beyond its first path before pairs are searched again, in units of the thickness.
const SLACK: f64 = 0.25;
/// The distance that is always kept, in units of the thickness, and of the present distance where that is less.
const KEPT: f64 = 0.5;
const KEPT_OF_PRESENT: f64 = 0.5;
/// Rounds in which what meets becomes a contact, searches of pairs, rounds in which zones grow, and corrections of a zone at walls.
const ROUNDS: u32 = 8;
const SEARCHES: u32 = 12;
const MERGERS: u32 = 1000;
const WALLS: u32 = 8;
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

/// The contacts of meshes.
#[derive(Debug, Clone, Default)]
pub struct SelfContacts {
    rules: Vec<Rule>,
    /// The rule of each pair of bodies, row by row.
    table: Vec<u32>,
    surfaces: Vec<Surface>,
    mesh: Mesh,
    /// The vertices of all meshes.
    vertices: Vec<u32>,
    inverse_mass: Vec<f64>,
    /// Positions [m] and velocities [m/s] at the start of the step.
    start: Vec<DVec3>,
    start_velocities: Vec<DVec3>,
    /// The forces of the contacts of the last step [N], by the keys of their pairs.
    loads: Vec<(u64, f64)>,
    saved: Vec<(u64, f64)>,
    /// Steps in which particles moved on together.
    merged: u64,
}

impl SelfContacts {
    /// The contacts that a scene declares, if there are any.
    ///
    /// # Errors
    /// If a value is wrong, or two items are about the same bodies.
    pub fn build<V: Vector>(scene: &Scene, properties: &Properties<V>) -> Result<Option<Self>> {
        let items: Vec<&Item> = scene.constraints.iter().filter(|item| item.kind == KIND).collect();
        let Some(first) = items.first() else { return Ok(None) };
        if scene.dimension != 3 {
            return Err(Error::parameter(&first.path, "a scene in 3D", format!("one in {}D", scene.dimension)));
        }
        if scene.periodic.is_some() {
            return Err(Error::parameter(&first.path, "no Periodic domain", "one")
                .with_hint("contacts are looked for between the bodies themselves, not between their images"));
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
        let mut contacts = Self { rules, table, surfaces, inverse_mass, start, ..Self::default() };
        contacts.leave_out(&[]);
        Ok(Some(contacts))
    }

    /// Takes the triangles and free edges along which no spring is broken.
    pub fn leave_out(&mut self, broken: &[bool]) {
        let whole = |springs: &[u32]| springs.iter().all(|&spring| !broken.get(spring as usize).copied().unwrap_or(false));
        let bodies: Vec<mesh::Body> = self
            .surfaces
            .iter()
            .map(|Surface { faces, edges }| {
                let faces = faces.iter().filter(|(_, sides)| whole(sides)).map(|&(face, _)| face).collect();
                (faces, edges.iter().filter(|(_, springs)| whole(springs)).map(|&(edge, _)| edge).collect())
            })
            .collect();
        let count = self.inverse_mass.len();
        self.mesh = Mesh::new(&bodies, self.table.clone(), count, |vertex| self.start[vertex as usize]);
        self.vertices = self.mesh.vertices().collect();
    }

    /// Looks at the state of a first step.
    ///
    /// # Errors
    /// The particles of an edge that is within a triangle.
    pub fn check(&mut self, position: impl Fn(usize) -> DVec3, executor: &Executor) -> std::result::Result<(), [u32; 2]> {
        self.begin(|index| [position(index), DVec3::ZERO]);
        let x = &self.start;
        let longest = self.mesh.edges.iter().map(|&[a, b]| (x[a as usize] - x[b as usize]).length()).fold(0.0, f64::max);
        let boxes: Vec<Bounds> = x.iter().map(|&x| Bounds { low: x, high: x }).collect();
        let pairs = self.mesh.pairs(&boxes, longest, executor);
        for pair in pairs.iter().filter(|pair| pair.has_face()) {
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
        let Step { h, executor, .. } = step;
        let thickness = self.rules.iter().map(|rule| rule.thickness).fold(0.0, f64::max);
        let finite = |&vertex: &u32| (self.start[vertex as usize] + velocities[vertex as usize]).is_finite();
        if !self.vertices.iter().all(finite) {
            return Ok(false);
        }
        let mut boxes: Vec<Bounds> = vec![Bounds::EMPTY; self.start.len()];
        for &vertex in &self.vertices {
            let [from, to] = self.path(vertex, velocities, h);
            boxes[vertex as usize] = Bounds { low: from.min(to), high: from.max(to) };
        }
        let free = velocities.clone();
        for search in 0..SEARCHES {
            let pairs = self.mesh.pairs(&boxes, (0.5 + SLACK) * thickness, executor);
            velocities.clone_from(&free);
            let contacts = self.separate(&pairs, &free, velocities, step)?;
            let mut left = false;
            for &vertex in &self.vertices {
                let bounds = &mut boxes[vertex as usize];
                let slack = DVec3::splat(SLACK * thickness);
                let [_, to] = self.path(vertex, velocities, h);
                if !(Bounds { low: bounds.low - slack, high: bounds.high + slack }).contains(to) {
                    // Farther each time, so that a vertex that others push on and on is caught.
                    let more = DVec3::splat(SLACK * thickness * f64::from(search).exp2());
                    *bounds = bounds.union(&Bounds { low: to - more, high: to + more });
                    left = true;
                }
            }
            if !left {
                self.remember(&contacts, h);
                return Ok(*velocities != free);
            }
        }
        let stray = self.vertices.iter().copied().max_by(|&one, &other| {
            let change = |vertex: u32| (velocities[vertex as usize] - free[vertex as usize]).length_squared();
            change(one).total_cmp(&change(other))
        });
        Err(Unresolved { particle: stray.unwrap_or(0) as usize })
    }

    fn path(&self, vertex: u32, velocities: &[DVec3], h: f64) -> [DVec3; 2] {
        let from = self.start[vertex as usize];
        [from, from + h * velocities[vertex as usize]]
    }

    /// Velocities at which none of these pairs meets; returns the contacts.
    fn separate(
        &mut self,
        pairs: &[Pair],
        free: &[DVec3],
        velocities: &mut [DVec3],
        step: Step<'_>,
    ) -> std::result::Result<Vec<Contact>, Unresolved> {
        let Step { h, confine, executor } = step;
        let mut distances = vec![0.0; pairs.len()];
        let mut contacts = self.contacts(pairs, free, h, &mut distances, executor);
        impulses::start(&mut contacts, velocities);
        impulses::solve(&mut contacts, velocities);
        for round in 0..=ROUNDS {
            let known = contacts.len();
            for &vertex in &self.vertices {
                if velocities[vertex as usize] == free[vertex as usize] {
                    continue;
                }
                let [from, to] = self.path(vertex, velocities, h);
                if let Some(inside) = confine(vertex as usize, to) {
                    contacts.extend(self.wall(vertex, [from, to], inside, h));
                    velocities[vertex as usize] = (inside - from) / h;
                }
            }
            let met = self.meetings(pairs, &distances, velocities, step);
            if met.is_empty() && contacts.len() == known {
                break;
            }
            if round == ROUNDS {
                self.merge(pairs, &distances, met, velocities, step)?;
                break;
            }
            for (index, closest) in met {
                contacts.extend(self.late(&pairs[index], &closest, distances[index], h));
            }
            impulses::solve(&mut contacts, velocities);
        }
        Ok(contacts)
    }

    /// The contacts of the pairs that may come nearer than the thickness, with the impulses of the last step, and the distances of all
    /// pairs [m]. Closest points on a boundary are those of several pairs: one of these counts, if it is locally closest.
    fn contacts(&self, pairs: &[Pair], free: &[DVec3], h: f64, distances: &mut [f64], executor: &Executor) -> Vec<Contact> {
        let mut found: Vec<Vec<Contact>> = vec![Vec::new(); pairs.len().div_ceil(BLOCK)];
        let work = (BlockedSlice::new(distances, BLOCK), BlockedSlice::new(&mut found, 1));
        executor.for_each_block(work, &|(distances, found): (BlockedSlice<'_, f64>, BlockedSlice<'_, Vec<Contact>>)| {
            let first = distances.start;
            for (offset, distance) in distances.items.iter_mut().enumerate() {
                let pair = &pairs[first + offset];
                let x = pair.gather(&self.start);
                let closest = measure(pair, &x);
                *distance = closest.separation.length();
                let rule = &self.rules[pair.rule as usize];
                let (travel, _) = advancement::relative(&pair.gather(free).map(|velocity| h * velocity), pair.split());
                let counts = || closest.interior || self.is_local(pair, &closest);
                if *distance - travel < rule.thickness && *distance > 0.0 && counts() {
                    found.items[0].extend(self.early(pair, &closest, *distance, free, h));
                }
            }
        });
        found.concat()
    }

    /// The contact of a pair as it is at the start.
    fn early(&self, pair: &Pair, closest: &Closest, distance: f64, free: &[DVec3], h: f64) -> Option<Contact> {
        let rule = &self.rules[pair.rule as usize];
        let normal = closest.separation / distance;
        let approach = normal.dot(combined(&closest.weights, &pair.gather(free)));
        let known = self.loads.binary_search_by_key(&pair.key, |&(key, _)| key).ok();
        let least = ((rule.thickness - distance) / h).min(0.0);
        // What touched in the last step rests; what arrives bounces.
        let bounces = known.is_none() && approach < least;
        let least = if bounces { least.max(-rule.restitution * approach) } else { least };
        let mut contact =
            Contact::new((pair.nodes, pair.key), closest.weights, normal, (least, rule.friction), &self.inverse_mass)?;
        contact.impulse = known.map_or(0.0, |known| h * self.loads[known].1);
        Some(contact)
    }

    /// The contact of a pair as it meets on its way.
    fn late(&self, pair: &Pair, closest: &Closest, distance: f64, h: f64) -> Option<Contact> {
        let rule = &self.rules[pair.rule as usize];
        let normal = closest.separation.normalize_or_zero();
        let gap = normal.dot(combined(&closest.weights, &pair.gather(&self.start)));
        let least = ((distance.min(rule.thickness) - gap) / h).min(0.0);
        Contact::new((pair.nodes, 0), closest.weights, normal, (least, rule.friction), &self.inverse_mass)
    }

    /// The contact of a vertex on a path with the walls that it would leave.
    fn wall(&self, vertex: u32, [from, to]: [DVec3; 2], inside: DVec3, h: f64) -> Option<Contact> {
        let way = (inside - to).length();
        let normal = (inside - to) / way;
        // What solving leaves of a velocity is no reason for another round.
        (way > impulses::CONVERGED * (to - from).length()).then_some(())?;
        let least = normal.dot(inside - from) / h;
        Contact::new(([vertex; 4], 0), [1.0, 0.0, 0.0, 0.0], normal, (least, 0.0), &self.inverse_mass)
    }

    /// The pairs that come too near each other, and how.
    fn meetings(
        &self,
        pairs: &[Pair],
        distances: &[f64],
        velocities: &[DVec3],
        Step { h, executor, .. }: Step<'_>,
    ) -> Vec<(usize, Closest)> {
        let mut found: Vec<Vec<(usize, Closest)>> = vec![Vec::new(); pairs.len().div_ceil(BLOCK)];
        executor.for_each_block(BlockedSlice::new(&mut found, 1), &|work: BlockedSlice<'_, Vec<(usize, Closest)>>| {
            let first = work.start * BLOCK;
            for index in first..(first + BLOCK).min(pairs.len()) {
                let (pair, distance) = (&pairs[index], distances[index]);
                let motion = advancement::relative(&pair.gather(velocities).map(|velocity| h * velocity), pair.split());
                let least = (KEPT * self.rules[pair.rule as usize].thickness).min(KEPT_OF_PRESENT * distance);
                if distance - motion.0 <= least {
                    let met = advancement::meeting(|x| measure(pair, x), pair.gather(&self.start), motion, least);
                    work.items[0].extend(met.map(|closest| (index, closest)));
                }
            }
        });
        found.concat()
    }

    /// Lets particles move on together until no pair meets.
    fn merge(
        &mut self,
        pairs: &[Pair],
        distances: &[f64],
        mut met: Vec<(usize, Closest)>,
        velocities: &mut [DVec3],
        step: Step<'_>,
    ) -> std::result::Result<(), Unresolved> {
        self.merged += 1;
        let mut zones = Zones::default();
        let mut last = 0;
        for _ in 0..MERGERS {
            if met.is_empty() {
                return Ok(());
            }
            last = pairs[met[0].0].nodes[0] as usize;
            met.iter().for_each(|(index, _)| zones.join(&pairs[*index].nodes));
            zones.merge(&self.inverse_mass, velocities, |members, velocity| self.within_walls(members, velocity, step));
            met = self.meetings(pairs, distances, velocities, step);
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

    fn remember(&mut self, contacts: &[Contact], h: f64) {
        self.loads.clear();
        let loaded = contacts.iter().filter(|contact| contact.key != 0 && contact.impulse > 0.0);
        self.loads.extend(loaded.map(|contact| (contact.key, contact.impulse / h)));
        self.loads.sort_unstable_by_key(|&(key, _)| key);
    }

    /// The number of triangles and free edges.
    pub fn elements(&self) -> usize {
        self.mesh.elements.len()
    }

    /// A note for the plan on the steps so far.
    pub fn note(&self) -> Option<String> {
        (self.merged > 0).then(|| {
            format!(
                "self-contact: in {} steps some particles moved on together, because no impulses kept them apart; shorter steps do",
                self.merged
            )
        })
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let loads = size_of_val(self.loads.as_slice()) + size_of_val(self.saved.as_slice());
        self.mesh.bytes() + 2 * size_of_val(self.start.as_slice()) + size_of_val(self.inverse_mass.as_slice()) + loads
    }
}

/// The closest points of a pair at positions.
#[inline(always)]
fn measure(pair: &Pair, x: &[DVec3; 4]) -> Closest {
    if pair.has_face() { vertex_face(x) } else { edge_edge(x) }
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
        archive.write([self.loads.len() as f64]);
        // The two halves of a key are whole numbers, which doubles hold.
        archive.write(self.loads.iter().flat_map(|&(key, load)| [(key >> 32) as f64, (key & 0xffff_ffff) as f64, load]));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let count = archive.read(1)?[0];
        let numbers = archive.read(3 * count as usize)?;
        self.loads =
            numbers.as_chunks::<3>().0.iter().map(|&[high, low, load]| ((high as u64) << 32 | low as u64, load)).collect();
        Ok(())
    }
}

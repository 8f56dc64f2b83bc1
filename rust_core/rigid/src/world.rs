//! All rigid bodies of a scene with their orientations, contacts and joints.
//!
//! Matter moves the centers of mass. A step has two parts here: [`RigidWorld::drift`], after the first kick, finds groups of
//! bodies that may touch or are joined, and moves these; [`RigidWorld::finish`], after the second kick, ends the last piece of
//! each. Groups are independent of each other, so that the bits are the same for any number of threads.

use glam::DVec3;
use physcore_base::parallel::{BlockedSlice, Executor};

use crate::broad;
use crate::collision;
use crate::island::{Accuracy, ContactKey, HeldJoint, Island, Meters, Pair, Surface};
use crate::joints::Joint;
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rotation::{Inertia, Orientation};
use crate::rows::{ContactImpulse, MOST_ROWS};
use crate::shapes::{Bounds, Shape};
use crate::springs::SpringStep;

/// Constant properties of a rigid body.
#[derive(Debug, Clone, Copy)]
pub struct Solid {
    pub surface: Surface,
    /// Inverse mass [1/kg]; 0 for a fixed body.
    pub inverse_mass: f64,
    pub inertia: Inertia,
}

/// Fixed shape that bounds the bodies.
#[derive(Debug, Clone, Copy)]
pub struct FixedSolid {
    pub surface: Surface,
    pub mover: Mover,
}

/// Particle that may meet bodies.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Index among all particles, and of its shape, a ball or disc.
    pub index: usize,
    pub surface: Surface,
    pub inverse_mass: f64,
}

/// Motion of a center of mass or a particle in a step.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Position at the start of the step [m]; then at its end.
    pub position: DVec3,
    /// Velocity at the start of the step [m/s].
    pub velocity: DVec3,
    /// Velocity of the drift, after the kick of half a step [m/s].
    pub drift: DVec3,
}

/// Orientation of a body, and its angular momentum [kg·m²/s]; of a fixed body, its angular velocity [rad/s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    pub orientation: Orientation,
    pub spin: DVec3,
}

/// Overlap of two bodies at the start.
#[derive(Debug, Clone)]
pub struct Overlap {
    /// Depth, and least size of the bodies [m].
    pub depth: f64,
    pub size: f64,
    /// Paths of the bodies in the scene.
    pub names: [String; 2],
}

/// Joint between two bodies or particles, by their indices in the world.
#[derive(Debug, Clone)]
pub struct WorldJoint {
    pub ends: [usize; 2],
    pub joint: Joint,
    pub broken: bool,
    loads: [f64; MOST_ROWS],
    bounds: [f64; 3],
    /// Mean force on the second body [N], and torque about its anchor [N·m], in the last step; 0 if broken.
    pub reaction: [DVec3; 2],
}

impl WorldJoint {
    /// Joint without load.
    pub fn new(ends: [usize; 2], joint: Joint) -> Self {
        Self { ends, joint, broken: false, loads: [0.0; MOST_ROWS], bounds: [0.0; 3], reaction: [DVec3::ZERO; 2] }
    }
}

/// State that persists from step to step.
#[derive(Debug, Clone, Default)]
pub struct RigidState {
    pub turns: Vec<Turn>,
    /// Forces of the contacts of the last step, in the order of their keys.
    pub loads: Vec<(ContactKey, ContactImpulse)>,
    pub joints: Vec<WorldJoint>,
    /// Energy of the springs that broke [J].
    pub torn: f64,
}

/// Numbers of a joint in a file.
const JOINT_NUMBERS: usize = MOST_ROWS + 3 + 8;

impl RigidState {
    /// Loads of contacts as numbers, for files.
    pub fn packed_loads(&self) -> Vec<f64> {
        let row = |(key, load): &(ContactKey, ContactImpulse)| {
            let (one, other, feature) = *key;
            let key = [f64::from(one), f64::from(other), f64::from(feature), load.normal];
            [key.as_slice(), &load.tangential.to_array(), &load.turning.to_array()].concat()
        };
        self.loads.iter().flat_map(row).collect()
    }

    /// Loads and breakage of joints as numbers, for files.
    pub fn packed_joints(&self) -> Vec<f64> {
        let row = |joint: &WorldJoint| {
            let [force, torque] = joint.reaction.map(|reaction| reaction.to_array());
            [joint.loads.as_slice(), &joint.bounds, &force, &torque, &[f64::from(u8::from(joint.broken)), joint.joint.last]]
                .concat()
        };
        self.joints.iter().flat_map(row).collect()
    }

    /// Reads the numbers of [`RigidState::packed_loads`] and [`RigidState::packed_joints`]; returns whether they fit.
    pub fn unpack(&mut self, loads: &[f64], joints: &[f64]) -> bool {
        if !loads.len().is_multiple_of(10) || joints.len() != JOINT_NUMBERS * self.joints.len() {
            return false;
        }
        let load = |row: &[f64]| {
            let [one, other, feature] = [0, 1, 2].map(|index| row[index] as u32);
            let (tangential, turning) = (DVec3::from_slice(&row[4..]), DVec3::from_slice(&row[7..]));
            ((one, other, feature), ContactImpulse { normal: row[3], tangential, turning })
        };
        self.loads = loads.chunks_exact(10).map(load).collect();
        for (joint, row) in self.joints.iter_mut().zip(joints.chunks_exact(JOINT_NUMBERS)) {
            joint.loads.copy_from_slice(&row[..MOST_ROWS]);
            joint.bounds.copy_from_slice(&row[MOST_ROWS..MOST_ROWS + 3]);
            let reactions = &row[MOST_ROWS + 3..];
            joint.reaction = [DVec3::from_slice(reactions), DVec3::from_slice(&reactions[3..])];
            (joint.broken, joint.joint.last) = (reactions[6] != 0.0, reactions[7]);
        }
        true
    }
}

/// Numerics of contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSolver {
    /// Pieces of a step of a large group.
    pub substeps: usize,
    /// Iterations of each of its solves.
    pub iterations: usize,
    /// Number of bodies of the largest group whose impacts are taken at their times.
    pub sequential: usize,
}

impl Default for ContactSolver {
    fn default() -> Self {
        Self { substeps: 4, iterations: 2, sequential: 32 }
    }
}

/// End of a joint at a point of the world.
pub const WORLD: usize = usize::MAX;

/// Rigid bodies of a scene.
#[derive(Debug, Default)]
pub struct RigidWorld {
    pub planar: bool,
    pub shapes: Vec<Shape>,
    pub bodies: Vec<Solid>,
    pub walls: Vec<FixedSolid>,
    /// Paths of bodies and of walls in the scene.
    pub names: Vec<String>,
    pub wall_names: Vec<String>,
    pub solver: ContactSolver,
    pub state: RigidState,
    /// Groups of the present step, and cleared ones.
    islands: Vec<Island>,
    spare: Vec<Island>,
    /// Springs of the present step.
    pub(crate) springs: SpringStep,
    /// Energies of the present step [J].
    pub(crate) meters: Meters,
}

impl RigidWorld {
    /// Empty world, in the plane or in space.
    pub fn new(planar: bool) -> Self {
        Self { planar, ..Self::default() }
    }

    /// Rotational energy of all bodies [J].
    pub fn rotational_energy(&self) -> f64 {
        let of = |(body, turn): (&Solid, &Turn)| 0.5 * turn.spin.dot(body.inertia.inverse(&turn.orientation) * turn.spin);
        let free = self.bodies.iter().zip(&self.state.turns).filter(|(body, _)| body.inverse_mass > 0.0);
        free.map(of).sum()
    }

    /// Angular velocity of a body [rad/s].
    pub fn angular_velocity(&self, body: usize) -> DVec3 {
        let (solid, turn) = (&self.bodies[body], &self.state.turns[body]);
        if solid.inverse_mass == 0.0 { turn.spin } else { solid.inertia.inverse(&turn.orientation) * turn.spin }
    }

    /// Sets the orientation and the angular velocity [rad/s] of a body.
    pub fn turn(&mut self, body: usize, orientation: Orientation, turning: DVec3) {
        let solid = &self.bodies[body];
        let spin = if solid.inverse_mass == 0.0 { turning } else { solid.inertia.spin(&orientation, turning) };
        self.state.turns[body] = Turn { orientation, spin };
    }

    /// Largest distance of a surface point of a body from its center [m].
    pub fn size(&self, body: usize) -> f64 {
        self.shapes[self.bodies[body].surface.shape].reach()
    }

    /// Radius of a particle [m].
    pub fn reach(&self, point: &Point) -> f64 {
        self.shapes[point.surface.shape].reach()
    }

    /// Whether there are two bodies, or a body and a wall, that may touch.
    pub fn can_touch(&self) -> bool {
        let free = self.bodies.iter().filter(|body| body.inverse_mass > 0.0).count();
        free > 0 && (self.bodies.len() > 1 || !self.walls.is_empty())
    }

    /// Whether some joint has a limit or a motor.
    pub fn has_bounded_joints(&self) -> bool {
        self.state.joints.iter().any(|joint| joint.joint.is_bounded())
    }

    /// Box that holds all bodies during a step of `h` seconds [m].
    pub fn extent(&self, motions: &[Motion], h: f64) -> (DVec3, DVec3) {
        let mut extent = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (body, motion) in motions.iter().enumerate() {
            let way = h * motion.velocity.length() + h * (motion.drift - motion.velocity).length();
            let reach = DVec3::splat(self.size(body) + way);
            extent = (extent.0.min(motion.position - reach), extent.1.max(motion.position + reach));
        }
        extent
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let joints = self.state.joints.len() * size_of::<WorldJoint>();
        self.bodies.len() * (size_of::<Solid>() + 2 * size_of::<Turn>() + size_of::<Mover>())
            + size_of_val(self.walls.as_slice())
            + 2 * (joints + self.state.loads.len() * size_of::<(ContactKey, ContactImpulse)>())
            + self.shapes.len() * size_of::<Shape>()
    }

    /// Overlaps of bodies with each other and with walls.
    pub fn overlaps(&self, motions: &[Motion]) -> Vec<Overlap> {
        let count = self.bodies.len();
        let mut movers: Vec<Mover> = motions.iter().enumerate().map(|(body, motion)| self.mover(body, motion, 1.0)).collect();
        let mut surfaces: Vec<Surface> = self.bodies.iter().map(|solid| solid.surface).collect();
        movers.extend(self.walls.iter().map(|wall| wall.mover));
        surfaces.extend(self.walls.iter().map(|wall| wall.surface));
        let dimension = if self.planar { 2 } else { 3 };
        let name = |index: usize| self.names.get(index).unwrap_or_else(|| &self.wall_names[index - count]).clone();
        let mut overlaps = Vec::new();
        for pair in self.pairs(&movers, &surfaces, count, 0.0) {
            let [one, other] = pair.map(|end| end as usize);
            let sides = [one, other].map(|end| (&self.shapes[surfaces[end].shape], movers[end].pose()));
            let (gap, _) = collision::separation((sides[0].0, &sides[0].1), (sides[1].0, &sides[1].1), dimension);
            if gap < 0.0 {
                let size = sides[0].0.reach().min(sides[1].0.reach());
                overlaps.push(Overlap { depth: -gap, size, names: [name(one), name(other)] });
            }
        }
        overlaps
    }

    /// Mover of a body in a step of `h` seconds.
    pub fn mover(&self, body: usize, motion: &Motion, h: f64) -> Mover {
        let (solid, turn) = (&self.bodies[body], &self.state.turns[body]);
        let shape = &self.shapes[solid.surface.shape];
        Mover {
            position: motion.position,
            velocity: motion.velocity,
            orientation: turn.orientation,
            spin: turn.spin,
            acceleration: (motion.drift - motion.velocity) * (2.0 / h),
            torque: DVec3::ZERO,
            inverse_mass: solid.inverse_mass,
            inertia: solid.inertia,
            arm: if shape.is_round() { 0.0 } else { shape.reach() },
        }
    }

    /// Moves bodies and particles through a step of `h` seconds, with their contacts and joints; returns which of them these
    /// have moved.
    pub fn drift(
        &mut self,
        h: f64,
        bodies: &mut [Motion],
        points: &[Point],
        motions: &mut [Motion],
        executor: &Executor,
    ) -> Vec<bool> {
        let count = self.bodies.len();
        let mut movers: Vec<Mover> = bodies.iter().enumerate().map(|(body, motion)| self.mover(body, motion, h)).collect();
        let mut surfaces: Vec<Surface> = self.bodies.iter().map(|solid| solid.surface).collect();
        for (point, motion) in points.iter().zip(&*motions) {
            movers.push(Mover {
                position: motion.position,
                velocity: motion.velocity,
                acceleration: (motion.drift - motion.velocity) * (2.0 / h),
                inverse_mass: point.inverse_mass,
                ..Mover::wall(&Pose::WORLD)
            });
            surfaces.push(point.surface);
        }
        self.begin_springs(&mut movers, points);
        movers.extend(self.walls.iter().map(|wall| wall.mover));
        surfaces.extend(self.walls.iter().map(|wall| wall.surface));
        let pairs = self.pairs(&movers, &surfaces, count + points.len(), h);
        // Other end of joints to the world.
        movers.push(Mover::wall(&Pose::WORLD));
        surfaces.push(Surface { shape: 0, friction: None, restitution: 0.0 });
        self.islands = self.groups(&movers, &surfaces, &pairs, points);
        let (shapes, solver) = (&self.shapes, self.solver);
        executor.for_each_block(BlockedSlice::new(&mut self.islands, 1), &|block: BlockedSlice<'_, Island>| {
            for island in block.items {
                let sized = |mover: &&Mover| !mover.is_fixed() && mover.inertia != Inertia::NONE;
                let accuracy = Accuracy { iterations: solver.iterations, velocities: 1e-9, linearizations: 1, positions: 0.0 };
                let sweep = (solver.substeps, accuracy);
                if island.movers.iter().filter(sized).count() <= solver.sequential {
                    island.advance(shapes, h, sweep);
                } else {
                    island.sweep(shapes, h, sweep);
                }
            }
        });
        // Bodies without contacts and joints, and fixed ones.
        let mut alone = vec![true; movers.len()];
        for island in &self.islands {
            island.members.iter().zip(&island.movers).filter(|(_, mover)| !mover.is_fixed()).for_each(|(&member, mover)| {
                alone[member] = false;
                movers[member] = *mover;
                movers[member].velocity -= 0.5 * (h - island.open) * mover.acceleration;
                movers[member].spin -= 0.5 * (h - island.open) * mover.torque;
            });
        }
        for (mover, _) in movers.iter_mut().zip(&alone).filter(|(_, alone)| **alone) {
            mover.kick(0.5 * h);
            mover.drift(h);
        }
        let mut moved: Vec<bool> = alone.iter().map(|alone| !alone).collect();
        self.springs.mark(&mut moved);
        for (index, mover) in movers.iter().enumerate().take(count) {
            self.state.turns[index] = Turn { orientation: mover.orientation, spin: mover.spin };
        }
        let (first, others) = movers.split_at(count);
        let all = bodies.iter_mut().zip(first).chain(motions.iter_mut().zip(others)).zip(&moved);
        for ((motion, mover), _) in all.filter(|((_, mover), moved)| **moved && !mover.is_fixed()) {
            (motion.position, motion.drift) = (mover.position, mover.velocity);
        }
        moved.truncate(count + points.len());
        moved
    }

    /// Pairs of movers that may touch within a step.
    fn pairs(&self, movers: &[Mover], surfaces: &[Surface], free: usize, h: f64) -> Vec<[u32; 2]> {
        let speed = |mover: &Mover| {
            mover.velocity.length() + mover.arm * mover.angular_velocity().length() + h * mover.acceleration.length()
        };
        let fastest = movers.iter().map(speed).fold(0.0, f64::max);
        let of = |(mover, surface): (&Mover, &Surface)| {
            let shape = &self.shapes[surface.shape];
            // An impact may pass the largest speed on to any body.
            let way = if mover.is_fixed() { h * speed(mover) } else { h * speed(mover).max(fastest.min(shape.reach() / h)) };
            shape.bounds(&mover.pose()).grown(way)
        };
        let bounds: Vec<Bounds> = movers.iter().zip(surfaces).map(of).collect();
        let moves: Vec<bool> = movers.iter().map(|mover| !mover.is_fixed()).collect();
        let mut pairs = Vec::new();
        broad::pairs(&bounds, &moves, &mut pairs);
        let bodies = self.bodies.len();
        let particle = |index: u32| (bodies..free).contains(&(index as usize));
        let wall = |index: u32| index as usize >= free;
        let mut joined: Vec<[u32; 2]> = self
            .state
            .joints
            .iter()
            .filter(|joint| !joint.broken && joint.joint.spring().is_none())
            .map(|joint| {
                let [one, other] = joint.ends.map(|end| end.min(u32::MAX as usize) as u32);
                [one.min(other), one.max(other)]
            })
            .collect();
        joined.sort_unstable();
        // Contacts resolve particles at walls. Bodies that are joined do not touch each other.
        pairs.retain(|pair| {
            let [one, other] = *pair;
            !(particle(one) && (particle(other) || wall(other))) && joined.binary_search(pair).is_err()
        });
        pairs
    }

    /// Groups of movers that pairs and joints connect, in the order of their first members.
    fn groups(&mut self, movers: &[Mover], surfaces: &[Surface], pairs: &[[u32; 2]], points: &[Point]) -> Vec<Island> {
        let mut roots: Vec<u32> = (0..movers.len() as u32).collect();
        let free = |index: usize| !movers[index].is_fixed();
        let joints: Vec<(usize, [usize; 2])> = self.joints(movers.len(), points);
        let links = pairs.iter().map(|pair| pair.map(|end| end as usize)).chain(joints.iter().map(|joint| joint.1));
        for [one, other] in links.clone().filter(|&[one, other]| free(one) && free(other)) {
            let (a, b) = (root(&mut roots, one as u32), root(&mut roots, other as u32));
            roots[a.max(b) as usize] = a.min(b);
        }
        let mut islands: Vec<Island> = Vec::new();
        let mut spare = std::mem::take(&mut self.spare);
        let mut number = vec![u32::MAX; movers.len()];
        for link in links {
            let end = if free(link[0]) { link[0] } else { link[1] };
            let root = root(&mut roots, end as u32) as usize;
            if number[root] == u32::MAX {
                number[root] = islands.len() as u32;
                islands.push(spare.pop().unwrap_or_else(|| Island::new(self.planar, Accuracy::FINE)));
            }
        }
        // The island of each free mover, and the places of movers in the island that is filled.
        let bodies = self.bodies.len();
        let name = |index: usize| {
            if index < bodies {
                index as u32
            } else if index < bodies + points.len() {
                (bodies + points[index - bodies].index) as u32
            } else {
                u32::MAX - (movers.len() - index) as u32
            }
        };
        let mut places: Vec<(u32, u32)> = vec![(u32::MAX, 0); movers.len()];
        let mut order: Vec<(u32, usize, bool)> = Vec::new();
        let of = |link: [usize; 2], roots: &mut Vec<u32>| {
            let end = if free(link[0]) { link[0] } else { link[1] };
            number[root(roots, end as u32) as usize]
        };
        for (index, pair) in pairs.iter().enumerate() {
            order.push((of(pair.map(|end| end as usize), &mut roots), index, false));
        }
        for (index, (_, ends)) in joints.iter().enumerate() {
            order.push((of(*ends, &mut roots), index, true));
        }
        order.sort_by_key(|&(island, index, joint)| (island, joint, index));
        for (which, index, joint) in order {
            let island = &mut islands[which as usize];
            let ends = if joint { joints[index].1 } else { pairs[index].map(|end| end as usize) };
            let local = ends.map(|end| {
                if places[end].0 != which {
                    places[end] = (which, island.movers.len() as u32);
                    island.movers.push(movers[end]);
                    island.members.push(end);
                    island.surfaces.push(surfaces[end]);
                }
                places[end].1 as usize
            });
            if joint {
                let world = &self.state.joints[joints[index].0];
                island.joints.push(HeldJoint {
                    index: joints[index].0,
                    bodies: local,
                    joint: world.joint,
                    loads: world.loads,
                    bounds: world.bounds,
                    reaction: [DVec3::ZERO; 2],
                });
            } else {
                let size = ends
                    .map(|end| self.shapes[surfaces[end].shape].reach())
                    .map(|reach| if reach > 0.0 { reach } else { f64::INFINITY });
                let size = size[0].min(size[1]);
                island.pairs.push(Pair { bodies: local, key: (name(ends[0]), name(ends[1])), size });
            }
        }
        self.spare = spare;
        islands.iter_mut().for_each(|island| island.remember(&self.state.loads));
        islands
    }

    /// Joints with the indices of their ends among the movers.
    fn joints(&self, movers: usize, points: &[Point]) -> Vec<(usize, [usize; 2])> {
        let bodies = self.bodies.len();
        let place = |end: usize| {
            if end < bodies {
                Some(end)
            } else if end == WORLD {
                Some(movers - 1)
            } else {
                points.binary_search_by_key(&(end - bodies), |point| point.index).ok().map(|place| bodies + place)
            }
        };
        let joints = self.state.joints.iter().enumerate();
        let whole = joints.filter(|(_, joint)| !joint.broken && joint.joint.spring().is_none());
        whole.filter_map(|(index, joint)| Some((index, [place(joint.ends[0])?, place(joint.ends[1])?]))).collect()
    }

    /// Ends a step of `h` seconds, given the motions of bodies and particles after the second kick; changes their velocities, and
    /// returns the energies of contacts and joints.
    pub fn finish(&mut self, h: f64, bodies: &mut [Motion], others: &mut [Motion], executor: &Executor) -> Meters {
        self.end_springs(h, bodies, others);
        let count = self.bodies.len();
        let free = count + others.len();
        for island in &mut self.islands {
            for (mover, &member) in island.movers.iter_mut().zip(&island.members).filter(|(mover, _)| !mover.is_fixed()) {
                if member < count {
                    (mover.velocity, mover.spin) = (bodies[member].velocity, self.state.turns[member].spin);
                } else {
                    mover.velocity = others[member - count].velocity;
                }
            }
        }
        executor.for_each_block(BlockedSlice::new(&mut self.islands, 1), &|block: BlockedSlice<'_, Island>| {
            block.items.iter_mut().for_each(Island::end_piece);
        });
        self.meters = Meters::default();
        self.state.loads.clear();
        let mut islands = std::mem::take(&mut self.islands);
        for island in &islands {
            for (mover, &member) in island.movers.iter().zip(&island.members).filter(|(mover, _)| !mover.is_fixed()) {
                if member < count {
                    bodies[member].velocity = mover.velocity;
                    self.state.turns[member].spin = mover.spin;
                } else if member < free {
                    others[member - count].velocity = mover.velocity;
                }
            }
            self.meters.dissipated += island.meters.dissipated;
            self.meters.work += island.meters.work;
            let pressed = island.contacts.iter().filter(|contact| contact.load.normal > 0.0);
            self.state.loads.extend(pressed.map(|contact| (contact.key, contact.load)));
            for held in &island.joints {
                let joint = &mut self.state.joints[held.index];
                (joint.loads, joint.bounds) = (held.loads, held.bounds);
                joint.reaction = held.reaction.map(|impulse| impulse / h);
                if joint.reaction[0].length() > joint.joint.breaking_force {
                    (joint.broken, joint.reaction) = (true, [DVec3::ZERO; 2]);
                }
                if let Some((_, place)) = held.joint.freedom(held.bodies.map(|body| &island.movers[body])) {
                    joint.joint.last = place / joint.joint.unit();
                }
            }
        }
        self.state.loads.sort_unstable_by_key(|(key, _)| *key);
        islands.iter_mut().for_each(Island::clear);
        self.spare.append(&mut islands);
        self.meter_springs(h, bodies, others);
        self.meters
    }
}

/// Representative of a set of a union–find forest, with path halving.
fn root(roots: &mut [u32], mut index: u32) -> u32 {
    while roots[index as usize] != index {
        let next = roots[roots[index as usize] as usize];
        roots[index as usize] = next;
        index = next;
    }
    index
}

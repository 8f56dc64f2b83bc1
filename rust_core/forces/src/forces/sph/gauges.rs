//! Gauges: the pressure at probes and the force of fluids on boundaries and obstacles, with their integrals over time.
//!
//! A probe on a wall measures the force of the wall on the particles, as a sensor of that size does. It sums their normal
//! components, each at its foot on the wall, weighted by the kernel with the probe's radius as support. The sum is divided by the
//! integral of the kernel over the wall. Elsewhere, a probe measures the mean pressure of its surroundings, in which dry parts
//! count with pressure 0. The pressure of each particle is extrapolated to the probe hydrostatically:
//!
//! ```text
//! p(x) = Σ Fⱼ·n W(xⱼ′ − x) / ∫ W dA
//! p(x) = Σ Vⱼ W(x − xⱼ) [pⱼ + ρ₀ g·(x − xⱼ)] / max(Σ Vⱼ W(x − xⱼ), ⅘ ∫ W dV)
//! ```
//!
//! The integrals exclude the space behind walls and in obstacles. If four fifths are wet, the latter is Shepard's mean, exact for
//! a fluid at rest. The tip of a front is one particle thin, and the pressure of a particle that hits a wall is 2ρcU for a
//! moment. But the particle lacks neighbors to press on, and its force on the wall is the one that stops it.
//!
//! The force on a boundary is the opposite of the force of its images on the particles. In a corner, an image by several mirrors
//! acts along all of their normals. Each wall takes the part along its normal, and an equal share of the rest. The force on an
//! obstacle is the sum over its particles. All forces are summed in blocks, which are added in their order. The forces on
//! boundaries are summed in the same pass as those on the particles.
//!
//! Pressures and forces are those of the last evaluation of the forces. The integrals add them over the time until the next
//! evaluation. The difference of two integrals is the impulse between two times, for any division into steps.
//!
//! Source: D. Shepard, ACM National Conference (1968) 517.

use std::ops::Range;

use glam::DVec3;

use super::BLOCK;
use super::kernel::KernelShape;
use super::start::{self, Materials};
use super::walls::{FluidWalls, Mirrors};
use crate::error::Result;
use crate::forces::neighbor_list::NeighborList;
use crate::history::{Archive, History};
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::{Item, Scene, Value};

/// Number of cells of the midpoint rule along each axis.
const CELLS: u32 = 32;

/// Distance from a wall within which a probe is on the wall, in units of its radius.
const ON_WALL: f64 = 0.1;

/// Wet share of the surroundings above which the mean at a probe is over the wet part alone. Inside a fluid the share is always
/// above it, although the volumes of particles do not add up to 1 exactly.
const WET: f64 = 0.8;

/// A point at which the pressure is measured.
#[derive(Debug, Clone, Copy)]
struct Probe {
    /// Position relative to the origin [m].
    position: DVec3,
    /// Radius of the mean [m].
    radius: f64,
    /// Integral ∫ W over the space that is not behind a wall, for a kernel of unit height: dV [m^D], or dA of its wall [m^(D−1)].
    room: f64,
    /// The wall of the probe, and the normal there, if it is on a wall.
    wall: Option<(u32, DVec3)>,
}

/// Present values, and their time integrals.
#[derive(Debug, Clone, Default)]
struct Readings {
    /// Force on each boundary, and on each body [N], an array per item.
    forces: Vec<[f64; AXES]>,
    /// Pressure at each probe [Pa].
    pressures: Vec<f64>,
    /// Impulses ∫ force dt [N·s].
    impulses: Vec<[f64; AXES]>,
    /// Integrals ∫ pressure dt [Pa·s].
    pressure_integrals: Vec<f64>,
    /// Time of the present values [s]; None before the first evaluation.
    time: Option<f64>,
}

/// The gauges of a scene.
#[derive(Debug)]
pub struct Gauges {
    instruments: Instruments,
    /// Number of boundaries; bodies follow.
    boundaries: usize,
    /// Force on each boundary [N], axis by axis, and pressure at each probe on a wall [Pa], for each block of slots.
    by_slots: Vec<f64>,
    /// Sums of the means at the other probes, for each block of members.
    by_members: Vec<Mean>,
    /// Members that are obstacles, body by body.
    obstacles: Vec<u32>,
    /// Parts of the obstacles, each of one body.
    parts: Vec<ObstaclePart>,
    readings: Readings,
    saved: Readings,
}

/// Probes and walls of the readings.
#[derive(Debug)]
pub struct Instruments {
    probes: Vec<Probe>,
    /// Lengths of the periodic domain [m], infinite along an axis that is not periodic.
    period: DVec3,
    /// Boundary of each wall.
    boundary_of: Vec<usize>,
    /// Index of the first value of a probe in each block of slots.
    first_probe: usize,
}

/// A part of an obstacle.
#[derive(Debug)]
struct ObstaclePart {
    body: usize,
    obstacles: Range<usize>,
    /// Force on the part [N].
    force: DVec3,
}

/// Sums of the mean pressure at a probe: Σ V W p [N·m], and Σ V W over fluid and over obstacles.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    pressed: f64,
    wet: f64,
    solid: f64,
}

/// Fluid around the probes for the mean pressure.
pub struct SurroundingFluid<'a, P> {
    pub neighbor_list: &'a NeighborList,
    pub materials: &'a Materials,
    /// Material of each member.
    pub kind: &'a [u8],
    /// Volume [m^D] and pressure [Pa] of a member.
    pub state: P,
}

impl Gauges {
    /// Gauges of a scene with these walls, with coordinates relative to an origin. `radius` is the default radius of probes [m].
    ///
    /// `obstacles` are members with their bodies, out of `count` members.
    pub fn new(
        shape: impl KernelShape,
        scene: &Scene,
        origin: DVec3,
        walls: &FluidWalls,
        radius: f64,
        (mut obstacles, count): (Vec<(usize, u32)>, usize),
    ) -> Result<Self> {
        let probe = |item: &Item| {
            let position = item.vector("position")? - origin;
            let radius = if item.values.contains_key("radius") { item.number("radius")? } else { radius };
            let wall = walls.nearest(position).filter(|(_, distance, _)| *distance < ON_WALL * radius);
            let wall = wall.map(|(number, _, normal)| (number, normal));
            let room = match wall {
                None => room(shape, scene.dimension, radius, |offset| walls.admit(position + offset, 0.0)),
                // The wall itself is not on its own allowed side.
                Some((_, normal)) => room_on_wall(shape, scene.dimension, radius, normal, |offset| {
                    walls.admit(position + offset + ON_WALL * radius * normal, 0.0)
                }),
            };
            // Rounding may place a probe on a wall behind it.
            if !walls.admit(position, -1e-6 * radius) || room == 0.0 {
                let found = Some(&Value::Vector(position + origin));
                return Err(item.wrong("position", "a point that is not behind a boundary", found));
            }
            Ok(Probe { position, radius, room, wall })
        };
        let probes: Vec<Probe> = scene.probes.iter().map(probe).collect::<Result<_>>()?;
        let rows = scene.boundaries.len() + scene.bodies.len();
        let readings = Readings {
            forces: vec![[0.0; AXES]; rows],
            pressures: vec![0.0; probes.len()],
            impulses: vec![[0.0; AXES]; rows],
            pressure_integrals: vec![0.0; probes.len()],
            time: None,
        };
        obstacles.sort_unstable();
        let of_bodies = obstacles.chunk_by(|one, other| one.0 == other.0);
        let mut parts = Vec::new();
        for of_body in of_bodies.flat_map(|of_body| of_body.chunks(BLOCK)) {
            let first = parts.last().map_or(0, |part: &ObstaclePart| part.obstacles.end);
            parts.push(ObstaclePart { body: of_body[0].0, obstacles: first..first + of_body.len(), force: DVec3::ZERO });
        }
        let (boundaries, blocks) = (scene.boundaries.len(), count.div_ceil(BLOCK));
        let off_walls = probes.iter().filter(|probe| probe.wall.is_none()).count();
        let instruments = Instruments {
            probes,
            period: scene.periodic.map_or(DVec3::INFINITY, |[lower, upper]| upper - lower),
            boundary_of: start::boundaries_of_walls(scene, origin)?,
            first_probe: AXES * boundaries,
        };
        Ok(Self {
            boundaries,
            by_slots: vec![0.0; if walls.is_empty() { 0 } else { blocks * instruments.numbers() }],
            by_members: vec![Mean::default(); blocks * off_walls],
            obstacles: obstacles.into_iter().map(|(_, member)| member).collect(),
            parts,
            instruments,
            saved: readings.clone(),
            readings,
        })
    }

    /// Adds the present readings to the integrals up to a time [s], and begins new readings.
    #[inline]
    pub fn begin(&mut self, time: f64) {
        self.readings.advance(time);
        self.by_slots.fill(0.0);
    }

    /// Sums the forces on obstacles. `force` returns the force on a member [N].
    pub fn sum_obstacles(&mut self, force: &(impl Fn(usize) -> DVec3 + Sync), executor: &Executor) {
        let obstacles = &self.obstacles;
        executor.for_each_block(BlockedSlice::new(&mut self.parts, 1), &|parts| {
            for part in parts.items {
                part.force = obstacles[part.obstacles.clone()].iter().map(|&member| force(member as usize)).sum();
            }
        });
    }

    /// The sums for the forces on walls, block by block of slots, and the instruments that add to them.
    #[inline]
    pub fn on_walls(&mut self) -> (BlockedSlice<'_, f64>, &Instruments) {
        let Self { instruments, by_slots, .. } = self;
        (BlockedSlice::new(by_slots, instruments.numbers().max(1)), instruments)
    }

    /// Takes the readings from the forces on obstacles and walls, and the means at probes that are not on a wall.
    pub fn read(
        &mut self,
        shape: impl KernelShape,
        flow: &SurroundingFluid<'_, impl Fn(usize) -> (f64, f64) + Sync>,
        executor: &Executor,
    ) {
        let Self { instruments, boundaries, by_slots, by_members, parts, readings: Readings { forces, pressures, .. }, .. } =
            self;
        let numbers = instruments.numbers();
        let Instruments { probes, period, first_probe, .. } = instruments;
        forces.fill([0.0; AXES]);
        pressures.fill(0.0);
        for block in by_slots.chunks_exact(numbers.max(1)) {
            let sums = forces.as_flattened_mut().iter_mut().take(*first_probe).chain(&mut *pressures);
            sums.zip(block).for_each(|(sum, of_block)| *sum += of_block);
        }
        for part in parts {
            forces[*boundaries + part.body].iter_mut().zip(part.force.to_array()).for_each(|(sum, along)| *sum += along);
        }
        let off_walls = || probes.iter().filter(|probe| probe.wall.is_none());
        let number = off_walls().count();
        if number == 0 {
            return;
        }
        executor.for_each_block(BlockedSlice::new(by_members, number), &|means| {
            let block = means.start / number;
            means.items.iter_mut().zip(off_walls()).for_each(|(mean, probe)| *mean = probe.mean(shape, block, *period, flow));
        });
        for (index, (probe, pressure)) in probes.iter().zip(pressures).filter(|(probe, _)| probe.wall.is_none()).enumerate() {
            let sum = |of: fn(&Mean) -> f64| by_members[index..].iter().step_by(number).map(of).sum::<f64>();
            let (pressed, wet, solid) = (sum(|mean| mean.pressed), sum(|mean| mean.wet), sum(|mean| mean.solid));
            *pressure = if wet > 0.0 { pressed / wet.max(WET * (probe.room - solid)) } else { 0.0 };
        }
    }

    /// Force on each boundary, and on each body [N].
    #[inline]
    pub fn forces(&self) -> &[[f64; AXES]] {
        &self.readings.forces
    }

    /// Pressure at each probe [Pa].
    #[inline]
    pub fn pressures(&self) -> &[f64] {
        &self.readings.pressures
    }

    /// Impulses ∫ force dt from the start to the last evaluation [N·s].
    #[inline]
    pub fn impulses(&self) -> &[[f64; AXES]] {
        &self.readings.impulses
    }

    /// Integrals ∫ pressure dt from the start to the last evaluation [Pa·s].
    #[inline]
    pub fn pressure_integrals(&self) -> &[f64] {
        &self.readings.pressure_integrals
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        let Readings { forces, pressures, .. } = &self.readings;
        let blocks = size_of_val(self.by_slots.as_slice()) + size_of_val(self.by_members.as_slice());
        let obstacles = size_of_val(self.obstacles.as_slice()) + size_of_val(self.parts.as_slice());
        4 * size_of_val(forces.as_slice()) + 5 * size_of_val(pressures.as_slice()) + blocks + obstacles
    }
}

impl Instruments {
    /// Number of values in each block of slots.
    fn numbers(&self) -> usize {
        self.first_probe + self.probes.len()
    }

    /// Adds the force on walls by the images of a fluid particle [N] to the sums of its block.
    pub fn add(&self, shape: impl KernelShape, numbers: &mut [f64], mirrors: &Mirrors, on_wall: DVec3) {
        let (forces, pressures) = numbers.split_at_mut(self.first_probe);
        let rest = mirrors.walls().iter().fold(on_wall, |rest, (_, normal)| rest - on_wall.dot(*normal) * normal);
        for &(wall, normal) in mirrors.walls() {
            let force = on_wall.dot(normal) * normal + rest / mirrors.walls().len() as f64;
            let sums = &mut forces[AXES * self.boundary_of[wall as usize]..][..AXES];
            sums.iter_mut().zip(force.to_array()).for_each(|(sum, along)| *sum += along);
            for (probe, pressure) in self.probes.iter().zip(&mut *pressures) {
                *pressure += probe.share(shape, wall, force, mirrors.x, self.period);
            }
        }
    }
}

impl Probe {
    /// Contribution of a force on a wall by a particle at `x` to the pressure of the probe [Pa].
    fn share(&self, shape: impl KernelShape, wall: u32, force: DVec3, x: DVec3, period: DVec3) -> f64 {
        let Some((_, normal)) = self.wall.filter(|(own, _)| *own == wall) else { return 0.0 };
        let mut along = self.position - x;
        wrap(&mut along, period);
        along -= along.dot(normal) * normal;
        let u = along.length() / self.radius;
        if u < 1.0 { -force.dot(normal) * shape.value(u) / self.room } else { 0.0 }
    }

    /// Sums of the mean pressure over a block of members.
    fn mean(
        &self,
        shape: impl KernelShape,
        block: usize,
        period: DVec3,
        flow: &SurroundingFluid<'_, impl Fn(usize) -> (f64, f64)>,
    ) -> Mean {
        let mut mean = Mean::default();
        // Periodic images are everywhere.
        if !period.is_finite() && flow.neighbor_list.distance_to(block, self.position) >= self.radius {
            return mean;
        }
        let gravity = flow.materials.first().gravity;
        let slots = flow.neighbor_list.neighbors().slots().iter().enumerate();
        for (member, &slot) in slots.skip(block * BLOCK).take(BLOCK) {
            let mut away = self.position - flow.neighbor_list.at(slot as usize);
            wrap(&mut away, period);
            let square = away.length_squared();
            if square < self.radius * self.radius {
                let (volume, pressure) = (flow.state)(member);
                let weight = volume * shape.value(square.sqrt() / self.radius);
                if let Some(fluid) = flow.materials.fluid(flow.kind[member]) {
                    mean.pressed += weight * (pressure + fluid.density * gravity.dot(away));
                    mean.wet += weight;
                } else {
                    mean.solid += weight;
                }
            }
        }
        mean
    }
}

/// Replaces a separation by that to the nearest image.
fn wrap(separation: &mut DVec3, period: DVec3) {
    for axis in (0..AXES).filter(|&axis| period[axis].is_finite()) {
        separation[axis] -= period[axis] * libm::rint(separation[axis] / period[axis]);
    }
}

/// Integral ∫ W dA over the admitted part of a disc [m^(D−1)], by the midpoint rule, for a kernel of unit height.
fn room_on_wall(shape: impl KernelShape, dimension: usize, radius: f64, normal: DVec3, admits: impl Fn(DVec3) -> bool) -> f64 {
    let (one, other) =
        if dimension == 2 { (DVec3::new(-normal.y, normal.x, 0.0), DVec3::ZERO) } else { normal.any_orthonormal_pair() };
    let cell = 2.0 * radius / f64::from(CELLS);
    let along = || (0..CELLS).map(|index| (f64::from(index) + 0.5) * cell - radius);
    let across: Vec<f64> = if dimension == 2 { vec![0.0] } else { along().collect() };
    let offsets = along().flat_map(|x| across.iter().map(move |&y| x * one + y * other));
    let weight = |offset: DVec3| {
        let u = offset.length() / radius;
        if u < 1.0 && admits(offset) { shape.value(u) } else { 0.0 }
    };
    offsets.map(weight).sum::<f64>() * if dimension == 2 { cell } else { cell.powi(2) }
}

/// Integral ∫ W dV over the admitted part of a ball [m^D], by the midpoint rule, for a kernel of unit height.
fn room(shape: impl KernelShape, dimension: usize, radius: f64, admits: impl Fn(DVec3) -> bool) -> f64 {
    let cell = 2.0 * radius / f64::from(CELLS);
    let along = || (0..CELLS).map(|index| (f64::from(index) + 0.5) * cell - radius);
    let flat = if dimension == 2 { vec![0.0] } else { along().collect() };
    let mut sum = 0.0;
    for x in along() {
        for y in along() {
            for &z in &flat {
                let offset = DVec3::new(x, y, z);
                let u = offset.length() / radius;
                if u < 1.0 && admits(offset) {
                    sum += shape.value(u);
                }
            }
        }
    }
    sum * if dimension == 2 { cell.powi(2) } else { cell.powi(3) }
}

impl Readings {
    /// Adds the present values over the time until `time` [s] to the integrals.
    fn advance(&mut self, time: f64) {
        let passed = time - self.time.unwrap_or(time);
        self.time = Some(time);
        let forces = self.impulses.as_flattened_mut().iter_mut().zip(self.forces.as_flattened());
        let pressures = self.pressure_integrals.iter_mut().zip(&self.pressures);
        forces.chain(pressures).for_each(|(integral, present)| *integral += passed * present);
    }

    /// Arrays of an archive, with their names.
    fn arrays(&mut self) -> [(&'static str, &mut [f64]); 4] {
        let Self { forces, pressures, impulses, pressure_integrals, .. } = self;
        [
            ("forces", forces.as_flattened_mut()),
            ("pressures", pressures),
            ("impulses", impulses.as_flattened_mut()),
            ("pressure_integrals", pressure_integrals),
        ]
    }

    /// Copies the values of other readings of the same scene without allocation.
    fn copy_from(&mut self, other: &Self) {
        self.forces.copy_from_slice(&other.forces);
        self.pressures.copy_from_slice(&other.pressures);
        self.impulses.copy_from_slice(&other.impulses);
        self.pressure_integrals.copy_from_slice(&other.pressure_integrals);
        self.time = other.time;
    }
}

impl History for Gauges {
    fn save(&mut self) {
        self.saved.copy_from(&self.readings);
    }

    fn rollback(&mut self) {
        self.readings.copy_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        let mut readings = self.readings.clone();
        readings.arrays().into_iter().for_each(|(name, numbers)| archive.write(name, numbers.iter().copied()));
        archive.write("time", [self.readings.time.unwrap_or(f64::NAN)]);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.readings.arrays().into_iter().try_for_each(|(name, numbers)| archive.read_into(name, numbers))?;
        self.readings.time = Some(archive.read_number("time")?).filter(|time| !time.is_nan());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::kernel::WendlandC2;
    use super::*;

    /// The integral ∫ W dV is h^D/(W₀h^D), to the square of a cell. Beside a wall through the middle of cell faces it is half of
    /// that.
    #[test]
    fn the_room_of_a_probe_is_the_integral_of_its_kernel() {
        for dimension in [2, 3] {
            let radius = 0.3_f64;
            let whole = (0.5 * radius).powi(dimension) / WendlandC2.height(dimension as usize);
            let found = room(WendlandC2, dimension as usize, radius, |_| true);
            assert!((found / whole - 1.0).abs() < 1e-3, "{dimension}D: {found} {whole}");
            let half = room(WendlandC2, dimension as usize, radius, |offset| offset.x > 0.0);
            assert!((half / found - 0.5).abs() < 1e-12, "{dimension}D: {half} {found}");
        }
    }

    #[test]
    fn integrals_are_those_of_what_held_until_then() {
        let mut readings = Readings {
            forces: vec![[0.0; AXES]],
            pressures: vec![0.0],
            impulses: vec![[0.0; AXES]],
            pressure_integrals: vec![0.0],
            time: None,
        };
        for (time, pressure) in [(1.0, 4.0), (1.5, 6.0), (1.5, 8.0), (2.0, 0.0)] {
            readings.advance(time);
            readings.pressures[0] = pressure;
        }
        // The pressure is 4 Pa from 1 to 1.5 s, and then 8 Pa, the last value found at that time.
        assert_eq!(readings.pressure_integrals, [0.5 * 4.0 + 0.5 * 8.0]);
    }
}

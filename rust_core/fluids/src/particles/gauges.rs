//! Gauges: the pressure at probes ([`super::probes`]) and the force of fluids on boundaries and obstacles, with their integrals
//! over time.
//!
//! The force on a boundary is the opposite of the force of its images on the particles. In a corner, an image by several mirrors
//! acts along all of their normals. Each wall takes the part along its normal, and an equal share of the rest. The force on an
//! obstacle is the sum over its particles. All forces are summed in blocks, which are added in their order. The forces on
//! boundaries are summed in the same pass as those on the particles.
//!
//! Pressures and forces are those of the last evaluation of the forces. The integrals add them over the time until the next
//! evaluation. The difference of two integrals is the impulse between two times, for any division into steps.

use std::ops::Range;

use glam::DVec3;

use super::BLOCK;
use super::kernel::KernelShape;
use super::probes::{Mean, Probe, SurroundingFluid, WET};
use super::start;
use super::walls::{FluidWalls, Mirrors};
use crate::error::Result;
use crate::forces::Readings;
use crate::history::{Archive, History};
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::Scene;

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
        let probes: Vec<Probe> =
            scene.probes.iter().map(|item| Probe::new(shape, scene, item, origin, walls, radius)).collect::<Result<_>>()?;
        let rows = scene.boundaries.len() + scene.bodies.len();
        let readings = Readings::new(rows, probes.len());
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

    /// Present values, and their time integrals.
    #[inline]
    pub fn readings(&self) -> &Readings {
        &self.readings
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

impl History for Gauges {
    fn save(&mut self) {
        self.saved.copy_from(&self.readings);
    }

    fn rollback(&mut self) {
        self.readings.copy_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        self.readings.capture(archive);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.readings.restore(archive)
    }
}

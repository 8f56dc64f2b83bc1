//! Probes of the pressure of fluids.
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
//! Source: D. Shepard, ACM National Conference (1968) 517.

use glam::DVec3;

use super::kernel::KernelShape;
use super::walls::FluidWalls;
use super::{BLOCK, Materials};
use crate::error::Result;
use crate::math::AXES;
use crate::neighbors::NeighborList;
use crate::scene::{Item, Scene, Value};

/// Number of cells of the midpoint rule along each axis.
const CELLS: u32 = 32;

/// Distance from a wall within which a probe is on the wall, in units of its radius.
const ON_WALL: f64 = 0.1;

/// Wet share of the surroundings above which the mean at a probe is over the wet part alone. Inside a fluid the share is always
/// above it, although the volumes of particles do not add up to 1 exactly.
pub const WET: f64 = 0.8;

/// A point at which the pressure is measured.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// Position relative to the origin [m].
    position: DVec3,
    /// Radius of the mean [m].
    radius: f64,
    /// Integral ∫ W over the space that is not behind a wall, for a kernel of unit height: dV [m^D], or dA of its wall [m^(D−1)].
    pub room: f64,
    /// The wall of the probe, and the normal there, if it is on a wall.
    pub wall: Option<(u32, DVec3)>,
}

/// Sums of the mean pressure at a probe: Σ V W p [N·m], and Σ V W over fluid and over obstacles.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    pub pressed: f64,
    pub wet: f64,
    pub solid: f64,
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

impl Probe {
    /// Probe of an item, with coordinates relative to an origin. `radius` is the default radius [m].
    pub fn new(
        shape: impl KernelShape,
        scene: &Scene,
        item: &Item,
        origin: DVec3,
        walls: &FluidWalls,
        radius: f64,
    ) -> Result<Self> {
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
    }

    /// Contribution of a force on a wall by a particle at `x` to the pressure of the probe [Pa].
    pub fn share(&self, shape: impl KernelShape, wall: u32, force: DVec3, x: DVec3, period: DVec3) -> f64 {
        let Some((_, normal)) = self.wall.filter(|(own, _)| *own == wall) else { return 0.0 };
        let mut along = self.position - x;
        wrap(&mut along, period);
        along -= along.dot(normal) * normal;
        let u = along.length() / self.radius;
        if u < 1.0 { -force.dot(normal) * shape.value(u) / self.room } else { 0.0 }
    }

    /// Sums of the mean pressure over a block of members.
    pub fn mean(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::kernel::WendlandC2;

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
}

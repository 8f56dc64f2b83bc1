//! Wires: particles that stay on curves, the holonomic constraint x = c(u).
//!
//! A wire pulls a bead across its tangent t₀ at the start of a step, as RATTLE does. With the end x of the free drift, the
//! bead goes to the point c(u) with
//!
//!     t₀ · (c(u) − x) = 0
//!
//! At the end of the step the velocity is v ← (t·v) t, with the tangent t there. The step is symplectic and of order 2 with
//! a symplectic method. The force of the wire is m (κ s² − a⊥), with the curvature vector κ, the speed s along the wire and
//! the acceleration a by all other forces.
//!
//! Friction acts with the impulse of the wire, at most μ times as large, and stops the bead at most. It does the work of its
//! impulse at the mean speed of the step. Source: H. C. Andersen, J. Comput. Phys. 52, 24 (1983).

mod constraint;
mod declaration;

use glam::DVec3;

use super::ForcedState;
use crate::catalog::Space;
use crate::error::Result;
use crate::history::{Archive, History};
use crate::math::spline::{CubicSpline, CurvePoint};

/// Largest accurate angle by which a wire turns under a bead in a step [rad].
const LARGEST_ANGLE: f64 = 0.5;
/// Least distance of neighboring points, relative to the length of the wire.
const NEAREST: f64 = 1e-9;
/// Share of a step limit in which a bead may come to the next bend: limits are looked at again after 16 steps.
const AHEAD: f64 = 1.0 / 16.0;
/// Tolerance of positions and velocities, in units of their rounding error.
const ROUNDINGS: f64 = 16.0;
/// Maximum number of iterations for the position on a wire.
const MOST_ITERATIONS: u32 = 30;

/// Curve with its friction.
#[derive(Debug, Clone)]
struct WireCurve {
    /// Path of the item in the scene.
    path: String,
    spline: CubicSpline,
    /// Coulomb's coefficient μ.
    friction: f64,
    /// Distances over which a bead may move in a step, at the samples of the spline [m].
    reaches: Vec<f64>,
}

/// Particle on a wire.
#[derive(Debug, Clone, Copy, Default)]
struct Bead {
    particle: u32,
    /// Index of the wire.
    wire: usize,
    /// Parameter u of the position, and a saved copy.
    place: f64,
    saved: f64,
    /// At the start of the step: the position [m], the tangent, and the speed along it [m/s].
    from: DVec3,
    tangent: DVec3,
    speed: f64,
    /// Change of the speed by friction in the drift [m/s].
    slowed: f64,
    /// Whether friction held the bead in its place in the drift.
    held: bool,
}

/// All wires of a scene with their beads.
#[derive(Debug, Clone)]
pub struct Wires {
    curves: Vec<WireCurve>,
    /// Beads, wire by wire, in the caller's order.
    beads: Vec<Bead>,
    /// Kinetic energy of velocities across wires in the given states [J].
    removed: f64,
    /// Whether the beads were put onto the wires.
    placed: bool,
    /// Highest order of convergence of a step: 1 for methods that project at the end of their steps. With friction too, whose
    /// impulse is the one at the start of each half of a step.
    order: u32,
}

impl Wires {
    /// Point of a wire under a bead.
    fn point(&self, bead: &Bead) -> CurvePoint {
        self.curves[bead.wire].spline.at(bead.place)
    }

    /// Force of the wire on a bead per mass, across the wire and along it [m/s²], at a state.
    fn accelerations<V: Space>(&self, bead: &Bead, state: &ForcedState<'_, V>, accelerations: &[DVec3]) -> [DVec3; 2] {
        let (point, index) = (self.point(bead), bead.particle as usize);
        let (tangent, acceleration) = (point.tangent(), accelerations[index]);
        let speed = tangent.dot(state.at.velocity.get(index).widen());
        let along = tangent.dot(acceleration);
        let across = point.curvature() * speed * speed - (acceleration - along * tangent);
        let most = self.curves[bead.wire].friction * across.length();
        let friction = if speed == 0.0 || bead.held { along.clamp(-most, most) } else { most.copysign(speed) };
        [across, -friction * tangent]
    }
}

impl WireCurve {
    /// Parameter of the point c with t·(c − x) = 0, from a parameter on; None if there is none near.
    fn across(&self, mut u: f64, x: DVec3, tangent: DVec3) -> Option<f64> {
        let mut before = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            let point = self.spline.at(u);
            let (off, rate) = (tangent.dot(point.position - x), tangent.dot(point.first));
            let size = self.spline.end() + point.position.abs().max_element() + x.abs().max_element();
            let rounding = f64::EPSILON * size;
            // The divergence monitor reports states that are not finite.
            if off.is_nan() || off.abs() <= rounding || (off.abs() <= ROUNDINGS * rounding && off.abs() >= before) {
                return self.spline.within(u);
            }
            if rate <= 0.0 {
                return None;
            }
            before = off.abs();
            u -= off / rate;
        }
        None
    }
}

/// History: the parameters of the beads. Where a wire crosses itself, they do not follow from the positions.
impl History for Wires {
    fn save(&mut self) {
        self.beads.iter_mut().for_each(|bead| bead.saved = bead.place);
    }

    fn rollback(&mut self) {
        self.beads.iter_mut().for_each(|bead| bead.place = bead.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("places", self.beads.iter().map(|bead| bead.place));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let places = archive.read_exactly("places", self.beads.len())?;
        self.beads.iter_mut().zip(places).for_each(|(bead, &place)| bead.place = place);
        Ok(())
    }
}

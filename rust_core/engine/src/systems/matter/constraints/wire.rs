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

use glam::DVec3;

use super::{
    ConstrainedStep, Constraint, ConstraintProperties, ConstraintStage, Declaration, DriftVelocity, ForcedState, WIRES, refuse,
    rods, self_contact,
};
use crate::error::{Error, Result};
use crate::forces::Space;
use crate::forces::springs;
use crate::history::{Archive, History};
use crate::math::Real;
use crate::math::spline::{CubicSpline, CurvePoint};
use crate::scene::{Item, Value};
use crate::stability::SpectralBound;
use crate::systems::matter::methods::Treatment;
use crate::systems::{FieldInfo, Location};

/// Kind of the items.
pub const KIND: &str = "Wire";
/// Distance from the wire above which a bead is refused, relative to the length of the wire.
const DEVIATION: f64 = 1e-4;
/// Largest accurate angle by which a wire turns under a bead in a step [rad].
const LARGEST_ANGLE: f64 = 0.5;
/// Least distance of neighboring points, relative to the length of the wire.
const NEAREST: f64 = 1e-9;
/// Length of a path on a wire over the drift along the tangent above which it leads around a bend. On a circle the ratio is
/// π/2 = 1.57 for a quarter turn.
const LONGEST_WAY: f64 = 1.6;
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
#[derive(Debug, Clone, Copy)]
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
    /// Highest order of convergence of a step: 1 for methods that project at the end of their steps. With friction too, whose
    /// impulse is the one at the start of each half of a step.
    order: u32,
}

impl Wires {
    /// Wires that a scene declares; None if there are none.
    ///
    /// # Errors
    /// If a value is wrong, if the method does not carry wires, or if another constraint or a wall acts on a bead.
    pub fn declared<V: Space>(declared: &Declaration<'_, V>) -> Result<Option<Self>> {
        let Declaration { scene, properties, .. } = declared;
        let items: Vec<&Item> = scene.constraints.iter().filter(|item| item.kind == KIND).collect();
        let Some(first) = items.first() else { return Ok(None) };
        refuse(WIRES, declared.method)?;
        if scene.periodic.is_some() {
            return Err(Error::parameter(&first.path, "no Periodic domain", "one"));
        }
        let engine = properties.engine();
        let order = if declared.method.drifts_first() { u32::MAX } else { 1 };
        let mut wires = Self { curves: Vec::new(), beads: Vec::new(), removed: 0.0, order };
        let mut taken = vec![false; properties.count()];
        for item in items {
            let points = item.vectors("points", None, V::DIMENSION)?;
            let (closed, friction) = (item.flag("closed")?, item.non_negative("friction")?);
            let length: f64 = points.windows(2).map(|ends| (ends[1] - ends[0]).length()).sum();
            let coincide = |one: &DVec3, other: &DVec3| (*one - *other).length() <= NEAREST * length;
            let repeats = closed && points.len() > 1 && coincide(&points[0], &points[points.len() - 1]);
            if points.len() < if closed { 3 } else { 2 } || points.windows(2).any(|ends| coincide(&ends[0], &ends[1])) || repeats
            {
                let given = Value::Text(format!("{} points", points.len()));
                let expected = "at least two points, three for a closed wire, that differ from the next";
                return Err(item.wrong("points", expected, Some(&given)));
            }
            if friction > 0.0 && declared.method.springs == Treatment::Rods && declared.method.orders[0] > 2 {
                let path = format!("{}.friction", item.path);
                return Err(Error::parameter(path, format!("0 with {}(order=4)", declared.method.name), friction)
                    .with_hint("parts of its steps go backward in time, where friction would speed beads up: take order=2"));
            }
            if friction > 0.0 {
                wires.order = 1;
            }
            let points: Vec<DVec3> = points.iter().map(|point| *point - properties.origin).collect();
            let spline = CubicSpline::through(&points, closed);
            let reaches = spline.reaches(LARGEST_ANGLE, AHEAD);
            wires.curves.push(WireCurve { path: item.path.clone(), spline, friction, reaches });
            for (caller, _) in scene.members(item).iter().enumerate().filter(|(_, member)| **member) {
                let particle = engine[caller];
                if properties.is_fixed(particle as usize) {
                    return Err(Error::parameter(
                        format!("{}.on", item.path),
                        "particles that move",
                        format!("particle {caller}, which is fixed"),
                    )
                    .with_hint("name the others with on=(body, indices)"));
                }
                if std::mem::replace(&mut taken[particle as usize], true) {
                    let found = format!("particle {caller} on a second one");
                    return Err(Error::parameter(&item.path, "one wire for each particle", found));
                }
                let wire = wires.curves.len() - 1;
                let (from, tangent, place) = (DVec3::ZERO, DVec3::ZERO, 0.0);
                wires.beads.push(Bead {
                    particle,
                    wire,
                    place,
                    saved: place,
                    from,
                    tangent,
                    speed: 0.0,
                    slowed: 0.0,
                    held: false,
                });
            }
        }
        wires.refuse_others(declared)?;
        Ok(Some(wires))
    }

    /// Refuses beads that rods, walls or other meshes hold too: their constraints would have to be solved together.
    fn refuse_others<V: Space>(
        &self,
        Declaration { scene, springs: declared_springs, properties, walls, .. }: &Declaration<'_, V>,
    ) -> Result<()> {
        let mut held = vec![false; properties.count()];
        declared_springs
            .iter()
            .filter(|spring| rods::is_rod(spring))
            .flat_map(|rod| rod.ends)
            .for_each(|end| held[end as usize] = true);
        let meshes = self_contact::bodies(scene)?;
        let strains = springs::strains(scene, "strain_limit")?;
        let mut limited = vec![false; properties.count()];
        let taut = declared_springs.iter().zip(strains).filter(|(_, strain)| strain.is_finite());
        taut.flat_map(|(spring, _)| spring.ends).for_each(|end| limited[end as usize] = true);
        for bead in &self.beads {
            let index = bead.particle as usize;
            let other = if held[index] {
                "a rod"
            } else if limited[index] {
                "a strain limit"
            } else if walls.as_ref().is_some_and(|walls| walls.walls_of(properties, index).next().is_some()) {
                "a boundary"
            } else if meshes.contains(&(properties.body[index] as usize)) {
                "SelfContact"
            } else {
                continue;
            };
            let path = format!("{}.on", self.curves[bead.wire].path);
            let found = format!("particle {}, on which {other} acts too", properties.caller[index]);
            return Err(Error::parameter(path, "particles that nothing but the wire holds", found)
                .with_hint("name the bodies of the other with on=, or the particles of the wire with on=(body, indices)"));
        }
        Ok(())
    }

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

impl<V: Space> Constraint<V> for Wires {
    fn about(&self) -> ConstraintProperties {
        let (count, curves) = (self.beads.len(), self.curves.len());
        let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let note = format!("{} on {}", counted(count, "bead"), counted(curves, "curve"));
        ConstraintProperties {
            name: "wires",
            stages: vec![ConstraintStage { name: "wires", note: Some(note), last: true }],
            order: self.order,
            varies: true,
            exact: true,
            iterates: false,
            cost: 300.0 * count as f64,
        }
    }

    fn bytes(&self) -> usize {
        let of = |curve: &WireCurve| curve.spline.bytes() + size_of_val(curve.reaches.as_slice());
        size_of_val(self.beads.as_slice()) + self.curves.iter().map(of).sum::<usize>()
    }

    fn notes(&self) -> Vec<String> {
        let text = || {
            format!(
                "wires: {:.3e} J of the kinetic energy that was given were velocities across wires, which they do not allow",
                self.removed
            )
        };
        (self.removed > 0.0).then(text).into_iter().collect()
    }

    /// Moves the beads onto their wires, and removes velocities across them.
    fn initialize(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        let Self { curves, beads, removed, .. } = self;
        for bead in beads {
            let (index, WireCurve { path, spline, .. }) = (bead.particle as usize, &curves[bead.wire]);
            let x = step.matter.exact_position(index);
            // Where a wire crosses itself, a bead that has not moved keeps its branch.
            let rounding = ROUNDINGS * f64::EPSILON * (spline.end() + x.abs().max_element());
            if (spline.at(bead.place).position - x).length() > rounding {
                bead.place = spline.nearest(x);
            }
            let point = spline.at(bead.place);
            let distance = (point.position - x).length();
            if distance > DEVIATION * spline.end() {
                let caller = step.properties.caller[index];
                let expected = format!("particles on the wire, up to {:.3e} m", DEVIATION * spline.end());
                return Err(Error::parameter(
                    format!("{path}.on"),
                    expected,
                    format!("particle {caller}, {} m beside it", (1e6 * distance).round() * 1e-6),
                ));
            }
            // What is on the wire up to rounding stays as it is.
            if distance > rounding {
                step.matter.set_exact_position(index, point.position);
            }
            let (velocity, tangent) = (step.matter.velocity.get(index).widen(), point.tangent());
            let along = tangent.dot(velocity) * tangent;
            if (velocity - along).length() > ROUNDINGS * V::Scalar::EPSILON.to_f64() * velocity.length() {
                step.matter.velocity.set(index, V::narrow(along));
                let [before, after] = [velocity, along].map(|v| 0.5 * step.properties.mass[index] * v.length_squared());
                *removed += if before - after > 1e-9 * before { before - after } else { 0.0 };
            }
        }
        Ok(())
    }

    fn begin(&mut self, step: &ConstrainedStep<'_, V>) {
        for bead in &mut self.beads {
            let start = self.curves[bead.wire].spline.at(bead.place);
            (bead.from, bead.tangent) = (start.position, start.tangent());
            bead.speed = bead.tangent.dot(step.matter.velocity.get(bead.particle as usize).widen());
        }
    }

    fn positions(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<bool> {
        let Self { curves, beads, .. } = self;
        for bead in beads {
            let (index, curve) = (bead.particle as usize, &curves[bead.wire]);
            let x = step.matter.exact_position(index);
            let lost = || {
                let cause = "does not stay on its wire: it leaves it at an end, or passes a bend within a step; make the wire \
                             longer or closed, or take a smaller dt";
                Error::unsolved(step.properties.caller[index] as usize, cause)
            };
            let way = x - bead.from;
            let along = bead.tangent.dot(way);
            // Friction that holds the bead needs no place ahead of it.
            bead.held = along.abs() <= curve.friction * (way - along * bead.tangent).length();
            let mut slowed = -along;
            let mut place = bead.place;
            if !bead.held {
                place = curve.across(place, x, bead.tangent).ok_or_else(lost)?;
                let across = (curve.spline.at(place).position - x).length();
                slowed = -(curve.friction * across).min(along.abs()).copysign(along);
                if slowed != 0.0 {
                    place = curve.across(place, x + slowed * bead.tangent, bead.tangent).ok_or_else(lost)?;
                }
                let room = LONGEST_WAY * along.abs() + NEAREST * curve.spline.end();
                if curve.spline.distance(bead.place, place) > room {
                    return Err(lost());
                }
            }
            bead.slowed = slowed / step.h;
            let end = curve.spline.at(place).position;
            bead.place = place;
            // Rounding of the place along the wire is no force.
            let change = end - x;
            step.pull(index, change - (bead.tangent.dot(change) - slowed) * bead.tangent);
            step.matter.set_exact_position(index, end);
        }
        Ok(true)
    }

    fn velocities(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        let mut losses = Vec::new();
        for bead in &self.beads {
            let (index, tangent) = (bead.particle as usize, self.point(bead).tangent());
            let velocity = step.matter.velocity.get(index).widen();
            // Rounding of the velocity across the wire is no motion along it.
            let free =
                Some(tangent.dot(velocity)).filter(|speed| speed.abs() > 4.0 * V::Scalar::EPSILON.to_f64() * velocity.length());
            let free = free.unwrap_or(0.0);
            let friction = self.curves[bead.wire].friction;
            let most = if bead.held && step.drift == DriftVelocity::End {
                f64::INFINITY
            } else {
                friction * (velocity - free * tangent).length()
            };
            let slowed = -most.min(free.abs()).copysign(free);
            let speed = free + slowed;
            step.matter.velocity.set(index, V::narrow(speed * tangent));
            if friction > 0.0 {
                let impulse = step.properties.mass[index] * (bead.slowed + slowed);
                losses.push((index, -0.5 * impulse * (bead.speed + speed)));
            }
        }
        step.matter.lose_in_contacts(&losses, step.driven);
        Ok(())
    }

    /// Adds the wires to the bound on the time step. A bead that is pressed on a wire oscillates about it as a pendulum does,
    /// with the stiffness of the force times the curvature.
    fn bound(&self, state: &ForcedState<'_, V>, bound: &mut SpectralBound) {
        let accelerations = (state.accelerations)();
        for bead in &self.beads {
            let index = bead.particle as usize;
            let curvature = self.point(bead).curvature().length();
            let [across, _] = self.accelerations(bead, state, &accelerations);
            bound.point(index, "wires", state.at.properties.mass[index] * across.length() * curvature, 0.0);
            let speed = state.at.velocity.get(index).widen().length();
            if speed > 0.0 {
                let WireCurve { spline, reaches, .. } = &self.curves[bead.wire];
                bound.accuracy("wires", spline.reach(reaches, bead.place, AHEAD) / speed);
            }
            // Before the bead moves, √(κ |a|) stands for its rate of turning κ |v|.
            let onset = (curvature * accelerations[index].length()).sqrt();
            if onset > 0.0 {
                bound.accuracy("wires", LARGEST_ANGLE / onset);
            }
        }
    }

    fn fields(&self) -> Vec<FieldInfo> {
        vec![FieldInfo {
            name: "wire_forces".to_owned(),
            unit: "N",
            location: Location::Points,
            shape: vec![self.beads.len(), V::DIMENSION],
            rate: None,
            state: false,
        }]
    }

    fn read(&self, _field: usize, state: &ForcedState<'_, V>) -> Vec<f64> {
        let accelerations = (state.accelerations)();
        let force = |bead: &Bead| {
            let [across, along] = self.accelerations(bead, state, &accelerations);
            (state.at.properties.mass[bead.particle as usize] * (across + along)).to_array()
        };
        self.beads.iter().flat_map(|bead| force(bead).into_iter().take(V::DIMENSION)).collect()
    }
}

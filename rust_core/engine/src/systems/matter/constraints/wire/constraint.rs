//! Wires as a constraint of matter's steps.

use super::super::{ConstrainedStep, Constraint, ConstraintProperties, ConstraintStage, DriftVelocity, ForcedState};
use super::{AHEAD, Bead, LARGEST_ANGLE, NEAREST, ROUNDINGS, WireCurve, Wires};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::math::Real;
use crate::stability::SpectralBound;
use crate::systems::{FieldInfo, Location};

/// Distance from the wire above which a bead is refused, relative to the length of the wire.
const DEVIATION: f64 = 1e-4;
/// Length of a path on a wire over the drift along the tangent above which it leads around a bend. On a circle the ratio is
/// π/2 = 1.57 for a quarter turn.
const LONGEST_WAY: f64 = 1.6;

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
        let Self { curves, beads, removed, placed, .. } = self;
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
                let path = if *placed { "set.positions".to_owned() } else { format!("{path}.on") };
                let found = format!("particle {caller}, {} m beside it", (1e6 * distance).round() / 1e6);
                return Err(Error::parameter(path, expected, found));
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
        *placed = true;
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
            location: Location::Beads,
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

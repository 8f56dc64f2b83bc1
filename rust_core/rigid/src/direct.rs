//! Impulses of small groups, by projected Gauss–Seidel iteration with Newton steps: all rows that hold are solved together.
//!
//! Iterations over rows choose which contacts bear and which of them slide. For these the equations are linearized.
//! A contact that slides has a normal impulse that takes its friction along, and in space an impulse that turns the direction of
//! friction. The matrix A = J M⁻¹ C, dense, is solved as A + ε with iterative refinement, so that redundant rows share
//! their load by least change. Source: P. Alart, A. Curnier, Comput. Meth. Appl. Mech. Eng. 92, 353 (1991).

use arrayvec::ArrayVec;
use glam::DVec3;

use crate::lu::{factorize, solution};
use crate::mover::perpendicular;
use crate::rows::{BodyVelocities, ContactImpulse, ContactRow, Row, Rows, add_energy};

/// Largest numbers of rows, and of rows of contacts.
pub const MOST: usize = 240;
pub const MOST_OF_CONTACTS: usize = 96;
/// Iterations between Newton steps, and largest numbers of Newton steps and of those that do not pay.
const SWEEPS: usize = 4;
const MOST_STEPS: usize = 8;
const MOST_FAILURES: usize = 3;
/// Shift ε over the largest diagonal entry, and number of refinements.
const SHIFT: f64 = 1e-9;
const REFINEMENTS: usize = 3;
/// Impulse over the mass of the group times the velocity that it shall change, above which the matrix of contacts counts as
/// singular. The directions of contacts amplify impulses by less; ε leaves singular ones amplified by its inverse.
const AMPLIFIED: f64 = 1e2;

/// Unknown impulse.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    Joint(usize, usize),
    Bound(usize),
    Normal(usize, DVec3),
    Tangent(usize, DVec3),
}

impl Unknown {
    /// Whether the impulse is that of a contact.
    fn is_of_contact(self) -> bool {
        matches!(self, Self::Normal(..) | Self::Tangent(..))
    }
}

/// Equation of an unknown, the direction of its impulse, and the velocity that it yields to a unit of it.
#[derive(Debug, Clone)]
struct HeldEquation {
    unknown: Unknown,
    bodies: [usize; 2],
    row: Row,
    column: Row,
    ends: ArrayVec<HeldEnd, 4>,
    yields: f64,
}

/// Body that an equation acts on, or corner of a face with its weight.
#[derive(Debug, Clone, Copy)]
struct HeldEnd {
    mover: usize,
    side: usize,
    weight: f64,
    inverse_mass: f64,
    /// Angular part of the equation, and change of the angular velocity by a unit of the impulse.
    angular: DVec3,
    turn: DVec3,
}

impl Rows {
    /// Solves for all impulses by iterations in alternating order, until no relative velocity changes by more than `tolerance`
    /// [m/s]; begins with the present impulses. Takes the velocities without impulses, and returns those with them, and whether
    /// the iterations converged. Where they did not and the impulses would add energy, plain iterations begin without impulses:
    /// each of their steps removes energy.
    pub fn solve(&mut self, free: &BodyVelocities, tolerance: f64, most: usize) -> (BodyVelocities, bool) {
        let mut v = free.clone();
        self.start(&mut v);
        if self.iterate(&mut v, tolerance, most) {
            return (v, true);
        }
        if !add_energy(&self.contacts, self.stopped(free, &v), free, &v) {
            return (v, false);
        }
        self.clear_impulses();
        v.clone_from(free);
        let converged = (0..most).any(|iteration| self.relax_all(iteration, &mut v) <= tolerance);
        (v, converged)
    }

    /// Iterates; a Newton step for the rows that hold follows some of the iterations. If it does not pay, it is undone.
    fn iterate(&mut self, v: &mut BodyVelocities, tolerance: f64, most: usize) -> bool {
        let mut before: Option<(f64, Vec<f64>, BodyVelocities)> = None;
        // Iterations from one Newton step to the next, and to the next decision.
        let (mut wait, mut next) = (SWEEPS, SWEEPS);
        let [mut steps, mut failures] = [0; 2];
        for iteration in 0..most {
            let change = self.relax_all(iteration, v);
            if change <= tolerance {
                return true;
            }
            if iteration + 1 < next {
                continue;
            }
            if let Some((change_before, impulses, velocities)) = before.take()
                && !change.le(&change_before)
            {
                self.set_impulses(&impulses);
                *v = velocities;
                failures += 1;
                wait *= 2;
                next += wait;
                continue;
            }
            next += SWEEPS;
            if next <= most && steps < MOST_STEPS && failures < MOST_FAILURES {
                let saved = (change, self.impulses(), v.clone());
                before = self.solve_held(v).then_some(saved);
                steps += 1;
            }
        }
        false
    }

    /// All impulses, row by row.
    fn impulses(&self) -> Vec<f64> {
        let joints = self.joints.iter().flat_map(|joint| joint.rows.iter().map(|row| row.impulse));
        let bounds = self.bounds.iter().map(|bounded| bounded.row.impulse);
        let of = |contact: &ContactRow| {
            let ContactImpulse { normal, tangential, turning } = contact.impulse;
            [normal, tangential.x, tangential.y, tangential.z, turning.x, turning.y, turning.z]
        };
        joints.chain(bounds).chain(self.contacts.iter().flat_map(of)).collect()
    }

    /// Sets all impulses to zero.
    pub fn clear_impulses(&mut self) {
        let count = self.impulses().len();
        self.set_impulses(&vec![0.0; count]);
    }

    /// Sets all impulses.
    fn set_impulses(&mut self, values: &[f64]) {
        let mut values = values.iter().copied();
        let joints = self.joints.iter_mut().flat_map(|joint| joint.rows.iter_mut().map(|row| &mut row.impulse));
        let bounds = self.bounds.iter_mut().map(|bounded| &mut bounded.row.impulse);
        joints.chain(bounds).zip(&mut values).for_each(|(impulse, value)| *impulse = value);
        for contact in &mut self.contacts {
            let mut next = || values.next().unwrap_or(0.0);
            let normal = next();
            let tangential = DVec3::new(next(), next(), next());
            contact.impulse = ContactImpulse { normal, tangential, turning: DVec3::new(next(), next(), next()) };
        }
    }

    /// Takes a Newton step with the rows that hold at present, if they are few; returns whether it did.
    fn solve_held(&mut self, v: &mut BodyVelocities) -> bool {
        let equations = self.held(v);
        let count = equations.len();
        if count == 0 || count > MOST {
            return false;
        }
        let mut matrix = vec![0.0; count * count];
        for (i, equation) in equations.iter().enumerate() {
            for (j, other) in equations.iter().enumerate() {
                matrix[i * count + j] = coupling(equation, other);
            }
        }
        let largest = (0..count).map(|i| matrix[i * count + i]).fold(0.0, f64::max);
        (0..count).for_each(|i| matrix[i * count + i] += SHIFT * largest + equations[i].yields);
        let Some(order) = factorize(&mut matrix, count) else { return false };
        let mut sums = vec![0.0; count];
        let is_of_contacts = equations.iter().all(|equation| equation.unknown.is_of_contact());
        let mass: f64 = v.bodies.iter().filter(|body| !body.is_fixed()).map(|body| 1.0 / body.inverse_mass).sum();
        for refinement in 0..REFINEMENTS {
            let lack =
                |(each, sum): (&HeldEquation, &f64)| each.row.target - each.row.velocity(each.bodies, v) - each.yields * sum;
            let lacks: Vec<f64> = equations.iter().zip(&sums).map(lack).collect();
            let changes = solution(&matrix, &order, &lacks);
            let largest = |values: &[f64]| values.iter().copied().map(f64::abs).fold(0.0, f64::max);
            if is_of_contacts && largest(&changes) > AMPLIFIED * mass * largest(&lacks) {
                return refinement > 0;
            }
            for ((equation, change), sum) in equations.iter().zip(changes).zip(&mut sums) {
                *sum += change;
                equation.column.push(change, equation.bodies, v);
                self.add(equation.unknown, change);
            }
        }
        true
    }

    /// Equations of the rows that hold.
    fn held(&self, v: &BodyVelocities) -> Vec<HeldEquation> {
        let mut equations = Vec::new();
        let mut add = |unknown, bodies: [usize; 2], row: Row, column: Row, yields| {
            let mut ends = ArrayVec::new();
            for (side, number) in bodies.into_iter().enumerate() {
                if let Some(body) = v.bodies.get(number) {
                    let (angular, turn) = (row.angular[side], body.inverse_inertia * column.angular[side]);
                    ends.push(HeldEnd { mover: number, side, weight: 1.0, inverse_mass: body.inverse_mass, angular, turn });
                    continue;
                }
                let (angular, turn) = (DVec3::ZERO, DVec3::ZERO);
                ends.extend(v.corners(number, row.angular[side]).map(|(mover, weight)| HeldEnd {
                    mover,
                    side,
                    weight,
                    inverse_mass: v.bodies[mover].inverse_mass,
                    angular,
                    turn,
                }));
            }
            equations.push(HeldEquation { unknown, bodies, row, column, ends, yields });
        };
        for (index, joint) in self.joints.iter().enumerate() {
            for (place, row) in joint.rows.iter().enumerate() {
                add(Unknown::Joint(index, place), joint.bodies, *row, *row, 0.0);
            }
        }
        for (index, bounded) in self.bounds.iter().enumerate() {
            if bounded.bounds[0] < bounded.row.impulse && bounded.row.impulse < bounded.bounds[1] {
                add(Unknown::Bound(index), bounded.bodies, bounded.row, bounded.row, 0.0);
            }
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let load = contact.before.normal + contact.impulse.normal;
            if load <= 0.0 {
                continue;
            }
            let along = |direction: DVec3, target: f64| Row { target, ..contact.along(direction) };
            let friction = contact.before.tangential + contact.impulse.tangential;
            let most = contact.friction.sliding * load;
            let slides = most == 0.0 || friction.length() >= (1.0 - 1e-9) * most;
            let normal = along(contact.normal, contact.least);
            let drag = if slides && most > 0.0 { friction / load } else { DVec3::ZERO };
            let column = if slides { along(contact.normal + drag, 0.0) } else { normal };
            add(Unknown::Normal(index, drag), contact.bodies, normal, column, 0.0);
            if !slides {
                for &tangent in &perpendicular(contact.normal)[..if self.planar { 1 } else { 2 }] {
                    let row = along(tangent, contact.slip.dot(tangent));
                    add(Unknown::Tangent(index, tangent), contact.bodies, row, row, 0.0);
                }
            } else if most > 0.0 && !self.planar {
                // Friction μλ turns against the slip s where s changes across it: δs + |s| δt/μλ = −s across.
                let across = contact.normal.cross(friction / friction.length());
                let row = along(across, contact.slip.dot(across));
                let slip = (contact.velocity(v) - contact.slip).reject_from_normalized(contact.normal);
                add(Unknown::Tangent(index, across), contact.bodies, row, row, slip.length() / most);
            }
        }
        equations
    }

    fn add(&mut self, unknown: Unknown, change: f64) {
        match unknown {
            Unknown::Joint(joint, row) => self.joints[joint].rows[row].impulse += change,
            Unknown::Bound(index) => self.bounds[index].row.impulse += change,
            Unknown::Normal(index, drag) => {
                let impulse = &mut self.contacts[index].impulse;
                impulse.normal += change;
                impulse.tangential += change * drag;
            }
            Unknown::Tangent(index, tangent) => self.contacts[index].impulse.tangential += change * tangent,
        }
    }
}

/// Entry of J M⁻¹ C.
fn coupling(equation: &HeldEquation, other: &HeldEquation) -> f64 {
    let mut sum = 0.0;
    for end in &equation.ends {
        for across in other.ends.iter().filter(|across| across.mover == end.mover && end.inverse_mass > 0.0) {
            let sign = if end.side == across.side { 1.0 } else { -1.0 };
            let linear = end.weight * across.weight * end.inverse_mass * equation.row.linear.dot(other.column.linear);
            sum += sign * (linear + end.angular.dot(across.turn));
        }
    }
    sum
}

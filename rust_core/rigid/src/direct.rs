//! Newton steps for the rows of small groups: all that hold at present are solved together.
//!
//! Iterations over rows choose which contacts bear and which of them slide. For these the equations are linear in the
//! impulses; a contact that slides has a normal impulse that takes its friction along. The matrix A = J M⁻¹ C, dense, is
//! solved as A + ε with iterative refinement, so that redundant rows share their load by least change. Source:
//! P. Alart, A. Curnier, Comput. Meth. Appl. Mech. Eng. 92, 353 (1991).

use glam::DVec3;

use crate::mover::perpendicular;
use crate::rows::{BodyVelocities, Row, Rows};

/// Largest numbers of rows, and of rows of contacts.
pub const MOST: usize = 240;
pub const MOST_OF_CONTACTS: usize = 96;
/// Shift ε over the largest diagonal entry, and number of refinements.
const SHIFT: f64 = 1e-9;
const REFINEMENTS: usize = 3;

/// Unknown impulse.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    Joint(usize, usize),
    Bound(usize),
    Normal(usize, DVec3),
    Tangent(usize, DVec3),
}

/// Equation of an unknown, the direction of its impulse, and its residual.
#[derive(Debug, Clone, Copy)]
struct HeldEquation {
    unknown: Unknown,
    bodies: [usize; 2],
    row: Row,
    column: Row,
}

impl Rows {
    /// Takes a Newton step with the rows that hold at present, if they are few; returns whether it did.
    pub fn solve_held(&mut self, v: &mut BodyVelocities) -> bool {
        let equations = self.held();
        let count = equations.len();
        if count == 0 || count > MOST {
            return false;
        }
        let mut matrix = vec![0.0; count * count];
        for (i, equation) in equations.iter().enumerate() {
            for (j, other) in equations.iter().enumerate() {
                matrix[i * count + j] = coupling(equation, other, v);
            }
        }
        let largest = (0..count).map(|i| matrix[i * count + i]).fold(0.0, f64::max);
        (0..count).for_each(|i| matrix[i * count + i] += SHIFT * largest);
        let Some(order) = factorize(&mut matrix, count) else { return false };
        for _ in 0..REFINEMENTS {
            let lacks: Vec<f64> = equations.iter().map(|each| each.row.target - each.row.velocity(each.bodies, v)).collect();
            let changes = solution(&matrix, &order, &lacks);
            for (equation, change) in equations.iter().zip(changes) {
                equation.column.push(change, equation.bodies, v);
                self.add(equation.unknown, change);
            }
        }
        true
    }

    /// Equations of the rows that hold.
    fn held(&self) -> Vec<HeldEquation> {
        let mut equations = Vec::new();
        let mut add = |unknown, bodies, row, column| equations.push(HeldEquation { unknown, bodies, row, column });
        for (index, joint) in self.joints.iter().enumerate() {
            for (place, row) in joint.rows.iter().enumerate() {
                add(Unknown::Joint(index, place), joint.bodies, *row, *row);
            }
        }
        for (index, bounded) in self.bounds.iter().enumerate() {
            if bounded.bounds[0] < bounded.row.impulse && bounded.row.impulse < bounded.bounds[1] {
                add(Unknown::Bound(index), bounded.bodies, bounded.row, bounded.row);
            }
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let load = contact.before.normal + contact.impulse.normal;
            if load <= 0.0 {
                continue;
            }
            let along = |direction: DVec3, target: f64| {
                let row = Row::new(direction, contact.arms.map(|arm| arm.cross(direction)));
                Row { target, ..row }
            };
            let friction = contact.before.tangential + contact.impulse.tangential;
            let most = contact.friction.sliding * load;
            let slides = most == 0.0 || friction.length() >= (1.0 - 1e-9) * most;
            let normal = along(contact.normal, contact.least);
            let drag = if slides && most > 0.0 { friction / load } else { DVec3::ZERO };
            let column = if slides { along(contact.normal + drag, 0.0) } else { normal };
            add(Unknown::Normal(index, drag), contact.bodies, normal, column);
            if !slides {
                for &tangent in &perpendicular(contact.normal)[..if self.planar { 1 } else { 2 }] {
                    let row = along(tangent, contact.slip.dot(tangent));
                    add(Unknown::Tangent(index, tangent), contact.bodies, row, row);
                }
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
fn coupling(equation: &HeldEquation, other: &HeldEquation, v: &BodyVelocities) -> f64 {
    let mut sum = 0.0;
    for (side, body) in equation.bodies.into_iter().enumerate() {
        for (across, same) in other.bodies.into_iter().enumerate() {
            if body == same {
                let sign = if side == across { 1.0 } else { -1.0 };
                sum += sign * v.coupling(body, (&equation.row, side), (&other.column, across));
            }
        }
    }
    sum
}

/// LU factorization with row pivoting, in place; returns the order of the rows, or None for a matrix that is not finite.
fn factorize(matrix: &mut [f64], count: usize) -> Option<Vec<usize>> {
    let mut order: Vec<usize> = (0..count).collect();
    for pivot in 0..count {
        let size = |row: &usize| matrix[row * count + pivot].abs();
        let best = (pivot..count).max_by(|&one, &other| size(&order[one]).total_cmp(&size(&order[other])))?;
        order.swap(pivot, best);
        let row = order[pivot];
        let value = matrix[row * count + pivot];
        if value == 0.0 || !value.is_finite() {
            return None;
        }
        for &other in &order[pivot + 1..] {
            let factor = matrix[other * count + pivot] / value;
            if factor != 0.0 {
                matrix[other * count + pivot] = factor;
                for column in pivot + 1..count {
                    matrix[other * count + column] -= factor * matrix[row * count + column];
                }
            }
        }
    }
    Some(order)
}

/// Solution of the factorized system.
fn solution(matrix: &[f64], order: &[usize], right: &[f64]) -> Vec<f64> {
    let count = order.len();
    let mut values: Vec<f64> = order.iter().map(|&row| right[row]).collect();
    for i in 0..count {
        let row = &matrix[order[i] * count..][..count];
        let sum: f64 = (0..i).map(|j| row[j] * values[j]).sum();
        values[i] -= sum;
    }
    for i in (0..count).rev() {
        let row = &matrix[order[i] * count..][..count];
        let sum: f64 = (i + 1..count).map(|j| row[j] * values[j]).sum();
        values[i] = (values[i] - sum) / row[i];
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_that_needs_pivots() {
        let matrix = [0.0, 2.0, 1.0, 1.0, 0.0, 3.0, 4.0, 1.0, 0.0];
        let mut factors = matrix;
        let order = factorize(&mut factors, 3).unwrap();
        let x = solution(&factors, &order, &[7.0, 10.0, 6.0]);
        for (row, right) in matrix.chunks_exact(3).zip([7.0, 10.0, 6.0]) {
            let sum: f64 = row.iter().zip(&x).map(|(entry, x)| entry * x).sum();
            assert!((sum - right).abs() < 1e-14);
        }
    }
}

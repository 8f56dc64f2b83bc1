//! Limited-memory BFGS: the last changes of displacements and residuals correct a constant matrix.
//!
//! Source: J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., 2006, algorithm 7.4.

use glam::DVec3;

/// Number of stored changes.
const REMEMBERED: usize = 5;

/// Change s of the displacements, change of the residual, and the inverse of their product.
#[derive(Debug)]
struct Change {
    step: Vec<DVec3>,
    residual: Vec<DVec3>,
    weight: f64,
}

/// Stored changes, oldest first.
#[derive(Debug, Default)]
pub struct Curvature {
    changes: Vec<Change>,
}

/// Scalar product, in one fixed order.
pub fn dot(one: &[DVec3], other: &[DVec3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one.dot(*other)).sum()
}

fn add(sum: &mut [DVec3], factor: f64, vector: &[DVec3]) {
    sum.iter_mut().zip(vector).for_each(|(sum, &vector)| *sum += factor * vector);
}

impl Curvature {
    /// Removes all changes.
    pub fn clear(&mut self) {
        self.changes.clear();
    }

    /// Stores a change, if the residual falls along it.
    pub fn remember(&mut self, step: Vec<DVec3>, residual: Vec<DVec3>) {
        let product = dot(&step, &residual);
        if product > 0.0 {
            self.changes.drain(..(self.changes.len() + 1).saturating_sub(REMEMBERED));
            self.changes.push(Change { step, residual, weight: 1.0 / product });
        }
    }

    /// Converts a residual into a direction of descent; `solve` multiplies by the inverse of the constant matrix.
    pub fn direct(&self, residual: &mut Vec<DVec3>, solve: impl FnOnce(&mut Vec<DVec3>)) {
        let mut shares = [0.0; REMEMBERED];
        for (change, share) in self.changes.iter().zip(&mut shares).rev() {
            *share = change.weight * dot(&change.step, residual);
            add(residual, -*share, &change.residual);
        }
        solve(residual);
        for (change, share) in self.changes.iter().zip(shares) {
            let known = change.weight * dot(&change.residual, residual);
            add(residual, share - known, &change.step);
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.changes.iter().map(|change| 2 * size_of_val(change.step.as_slice())).sum()
    }
}

//! Matrix of Newton's method: inertia, and derivatives of linear forces, of springs in their present directions, and of
//! others.

use glam::{DMat3, DVec3};

use crate::forces::derivatives::MatrixBlock;
use crate::forces::springs::Spring;

/// Derivative of a spring's force: along its direction n, and across it.
#[derive(Debug, Clone, Copy)]
struct SpringStiffness {
    ends: [u32; 2],
    direction: DVec3,
    along: f64,
    across: f64,
}

/// Symmetric matrix: σ m + h² (…) of each particle, and a block for each spring.
#[derive(Debug, Clone, Default)]
pub struct Stiffness {
    /// Diagonal, by particle; 0 if the particle is fixed.
    pub diagonal: Vec<f64>,
    links: Vec<SpringStiffness>,
    /// Blocks of all other forces: of single particles, if there are any, and of pairs.
    own: Vec<[DMat3; 2]>,
    pairs: Vec<MatrixBlock>,
    /// Inverses of the blocks on the diagonal.
    inverse: Vec<DMat3>,
}

impl Stiffness {
    /// Adds springs at these positions and velocities, whose derivatives by the displacement are `position` and `rate`. A
    /// compressed spring has a negative stiffness across. The inverse blocks leave it out, so that they are definite.
    pub fn assemble(&mut self, springs: &[Spring], places: &[DVec3], velocities: &[DVec3], [position, rate]: [f64; 2]) {
        self.links.clear();
        self.own.clear();
        self.pairs.clear();
        self.inverse.clear();
        self.inverse.extend(self.diagonal.iter().map(|&value| DMat3::from_diagonal(DVec3::splat(value))));
        for spring in springs {
            let [one, other] = spring.ends.map(|end| end as usize);
            let (offset, relative) = (places[other] - places[one], velocities[other] - velocities[one]);
            let length = offset.length();
            let link = if length > 0.0 {
                let direction = offset / length;
                let pull = spring.stiffness * (length - spring.rest_length) + spring.damping * direction.dot(relative);
                let along = position * spring.stiffness + rate * spring.damping;
                SpringStiffness { ends: spring.ends, direction, along, across: position * pull / length }
            } else {
                // Without a direction the stiffness is isotropic; for a rest length of 0 this is exact.
                let along = position * spring.stiffness;
                SpringStiffness { ends: spring.ends, direction: DVec3::ZERO, along, across: along }
            };
            let DVec3 { x, y, z } = link.direction;
            let outer = DMat3::from_cols(link.direction * x, link.direction * y, link.direction * z);
            let across = link.across.max(0.0);
            let matrix = DMat3::from_diagonal(DVec3::splat(across)) + outer * (link.along - across);
            self.inverse[one] += matrix;
            self.inverse[other] += matrix;
            self.links.push(link);
        }
    }

    /// Adds a block of another force.
    pub fn add(&mut self, block: MatrixBlock) {
        let [one, other] = block.ends.map(|end| end as usize);
        self.inverse[one] += block.definite;
        if one == other {
            self.own.resize(self.diagonal.len(), [DMat3::ZERO; 2]);
            self.own[one][0] += block.exact;
            self.own[one][1] += block.definite;
        } else {
            self.inverse[other] += block.definite.transpose();
            self.pairs.push(block);
        }
    }

    /// Inverts the blocks on the diagonal, after all are added.
    pub fn complete(&mut self) {
        for (inverse, &diagonal) in self.inverse.iter_mut().zip(&self.diagonal) {
            *inverse = if diagonal > 0.0 { inverse.inverse() } else { DMat3::ZERO };
        }
    }

    /// Writes A p into `product`; components of fixed particles are 0. If `definite`, terms that may be negative are left
    /// out.
    pub fn multiply(&self, p: &[DVec3], product: &mut [DVec3], definite: bool) {
        let least = if definite { 0.0 } else { f64::NEG_INFINITY };
        for ((product, &p), &diagonal) in product.iter_mut().zip(p).zip(&self.diagonal) {
            *product = diagonal * p;
        }
        for link in &self.links {
            let [one, other] = link.ends.map(|end| end as usize);
            let apart = p[other] - p[one];
            let across = link.across.max(least);
            let force = across * apart + (link.along - across) * link.direction.dot(apart) * link.direction;
            product[one] -= force;
            product[other] += force;
        }
        for ((product, &p), own) in product.iter_mut().zip(p).zip(&self.own) {
            *product += own[usize::from(definite)] * p;
        }
        for block in &self.pairs {
            let [one, other] = block.ends.map(|end| end as usize);
            let matrix = if definite { block.definite } else { block.exact };
            let apart = p[other] - p[one];
            product[one] -= matrix * apart;
            product[other] += matrix.transpose() * apart;
        }
        for (product, &diagonal) in product.iter_mut().zip(&self.diagonal) {
            if diagonal == 0.0 {
                *product = DVec3::ZERO;
            }
        }
    }

    /// Multiplies by the inverses of the blocks on the diagonal.
    pub fn precondition(&self, r: &[DVec3], z: &mut [DVec3]) {
        z.iter_mut().zip(r).zip(&self.inverse).for_each(|((z, &r), inverse)| *z = *inverse * r);
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.diagonal.as_slice())
            + size_of_val(self.links.as_slice())
            + size_of_val(self.own.as_slice())
            + size_of_val(self.pairs.as_slice())
            + size_of_val(self.inverse.as_slice())
    }
}

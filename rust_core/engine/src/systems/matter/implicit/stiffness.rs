//! The matrix of Newton's method: inertia, the derivatives of linear forces, and of springs in their present directions.

use glam::{DMat3, DVec3};

use crate::forces::springs::Spring;

/// The derivative of a spring's force: along n, and across it.
#[derive(Debug, Clone, Copy)]
struct Block {
    ends: [u32; 2],
    direction: DVec3,
    along: f64,
    across: f64,
}

/// A symmetric matrix: σ m + h² (…) of each particle, and a block for each spring.
#[derive(Debug, Clone, Default)]
pub struct Stiffness {
    /// By particle; 0 where it is fixed.
    pub diagonal: Vec<f64>,
    blocks: Vec<Block>,
    /// The inverses of its blocks on the diagonal.
    inverse: Vec<DMat3>,
}

impl Stiffness {
    /// Takes springs at positions, with velocities, whose derivatives by the displacement are `position` and `rate`. A spring under
    /// compression has a negative stiffness across, which is left out of the inverse blocks, so that these are definite.
    pub fn assemble(&mut self, springs: &[Spring], places: &[DVec3], velocities: &[DVec3], [position, rate]: [f64; 2]) {
        self.blocks.clear();
        self.inverse.clear();
        self.inverse.extend(self.diagonal.iter().map(|&value| DMat3::from_diagonal(DVec3::splat(value))));
        for spring in springs {
            let [one, other] = spring.ends.map(|end| end as usize);
            let (offset, relative) = (places[other] - places[one], velocities[other] - velocities[one]);
            let length = offset.length();
            let block = if length > 0.0 {
                let direction = offset / length;
                let pull = spring.stiffness * (length - spring.rest_length) + spring.damping * direction.dot(relative);
                let along = position * spring.stiffness + rate * spring.damping;
                Block { ends: spring.ends, direction, along, across: position * pull / length }
            } else {
                // Without a direction it is isotropic, and where its rest length is 0 this is exact.
                let along = position * spring.stiffness;
                Block { ends: spring.ends, direction: DVec3::ZERO, along, across: along }
            };
            let DVec3 { x, y, z } = block.direction;
            let outer = DMat3::from_cols(block.direction * x, block.direction * y, block.direction * z);
            let across = block.across.max(0.0);
            let matrix = DMat3::from_diagonal(DVec3::splat(across)) + outer * (block.along - across);
            self.inverse[one] += matrix;
            self.inverse[other] += matrix;
            self.blocks.push(block);
        }
        for (inverse, &diagonal) in self.inverse.iter_mut().zip(&self.diagonal) {
            *inverse = if diagonal > 0.0 { inverse.inverse() } else { DMat3::ZERO };
        }
    }

    /// A p into `product`; components of fixed particles are 0. `definite` leaves negative stiffness across out.
    pub fn multiply(&self, p: &[DVec3], product: &mut [DVec3], definite: bool) {
        let least = if definite { 0.0 } else { f64::NEG_INFINITY };
        for ((product, &p), &diagonal) in product.iter_mut().zip(p).zip(&self.diagonal) {
            *product = diagonal * p;
        }
        for block in &self.blocks {
            let [one, other] = block.ends.map(|end| end as usize);
            let apart = p[other] - p[one];
            let across = block.across.max(least);
            let force = across * apart + (block.along - across) * block.direction.dot(apart) * block.direction;
            product[one] -= force;
            product[other] += force;
        }
        for (product, &diagonal) in product.iter_mut().zip(&self.diagonal) {
            if diagonal == 0.0 {
                *product = DVec3::ZERO;
            }
        }
    }

    /// The product with the inverses of the blocks on the diagonal.
    pub fn precondition(&self, r: &[DVec3], z: &mut [DVec3]) {
        z.iter_mut().zip(r).zip(&self.inverse).for_each(|((z, &r), inverse)| *z = *inverse * r);
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.diagonal.as_slice()) + size_of_val(self.blocks.as_slice()) + size_of_val(self.inverse.as_slice())
    }
}

//! Rows of all joints of a group, solved together.
//!
//! The matrix A = J M⁻¹ Jᵀ has a block for every two joints of one body. Its factorization L D Lᵀ by blocks, in the order of
//! least degree, has no further blocks for chains and trees. The diagonal is shifted by a small part of itself, so that redundant
//! rows share their load; repeated solves remove the error. Sources: D. Baraff, "Linear-time dynamics using Lagrange
//! multipliers", SIGGRAPH 1996; A. George, J. W. H. Liu, SIAM Review 31, 1 (1989).

use std::collections::{BTreeMap, BTreeSet};

use arrayvec::ArrayVec;

use crate::rows::{BodyVelocities, JointRows, MOST_ROWS, inverted};

/// Shift of the diagonal, over its entries.
const SHIFT: f64 = 1e-10;
/// Largest number of blocks, over that of joints: more take longer than iterations.
const MOST_BLOCKS: usize = 32;

/// Block of two joints.
type JointBlock = [[f64; MOST_ROWS]; MOST_ROWS];

const NOTHING: JointBlock = [[0.0; MOST_ROWS]; MOST_ROWS];

/// Column of the factorization.
#[derive(Debug, Clone)]
struct Column {
    joint: usize,
    /// Inverse of the diagonal block.
    inverse: JointBlock,
    /// Blocks of L, with their joints.
    factors: Vec<(usize, JointBlock)>,
}

/// Factorized rows of all joints of a group.
#[derive(Debug, Clone)]
pub(crate) struct JointSystem {
    columns: Vec<Column>,
}

impl JointSystem {
    /// Factorization for the rows of joints; None if there are fewer than two of them, or if it has too many blocks.
    pub fn new(joints: &[JointRows], v: &BodyVelocities) -> Option<Self> {
        if joints.len() < 2 {
            return None;
        }
        let mut blocks = blocks(joints, v)?;
        let mut queue: BTreeSet<(usize, usize)> = blocks.iter().enumerate().map(|(joint, row)| (row.len(), joint)).collect();
        let mut columns = Vec::with_capacity(joints.len());
        let mut count: usize = blocks.iter().map(BTreeMap::len).sum();
        while let Some((_, joint)) = queue.pop_first() {
            let mut row = std::mem::take(&mut blocks[joint]);
            let inverse = inverted(row.remove(&joint)?, joints[joint].rows.len());
            let factors: Vec<(usize, JointBlock)> =
                row.iter().map(|(&other, block)| (other, product(&transposed(block), &inverse))).collect();
            for (other, factor) in &factors {
                let own = &mut blocks[*other];
                let before = own.len();
                own.remove(&joint);
                for (&across, block) in &row {
                    let change = product(factor, block);
                    let entry = own.entry(across).or_insert(NOTHING);
                    (0..MOST_ROWS).for_each(|i| (0..MOST_ROWS).for_each(|j| entry[i][j] -= change[i][j]));
                }
                count = count + own.len() - before;
                queue.remove(&(before, *other));
                queue.insert((own.len(), *other));
            }
            if count > MOST_BLOCKS * joints.len() {
                return None;
            }
            columns.push(Column { joint, inverse, factors });
        }
        Some(Self { columns })
    }

    /// Solves the rows of all joints; returns the largest change of a relative velocity.
    pub fn relax(&self, joints: &mut [JointRows], v: &mut BodyVelocities) -> f64 {
        let mut values: Vec<[f64; MOST_ROWS]> = joints.iter().map(|joint| joint.lacks(v)).collect();
        let change = values.iter().flatten().fold(0.0, |largest: f64, lack| largest.max(lack.abs()));
        for Column { joint, factors, .. } in &self.columns {
            let own = values[*joint];
            for (other, factor) in factors {
                let value = &mut values[*other];
                (0..MOST_ROWS).for_each(|i| value[i] -= dot(&factor[i], &own));
            }
        }
        for Column { joint, inverse, factors } in self.columns.iter().rev() {
            let mut own: [f64; MOST_ROWS] = std::array::from_fn(|i| dot(&inverse[i], &values[*joint]));
            for (other, factor) in factors {
                let value = values[*other];
                (0..MOST_ROWS).for_each(|i| (0..MOST_ROWS).for_each(|j| own[j] -= factor[i][j] * value[i]));
            }
            values[*joint] = own;
        }
        joints.iter_mut().zip(&values).for_each(|(joint, impulses)| joint.push(impulses, v));
        change
    }
}

/// Blocks of the matrix, by joints; None if there are too many.
fn blocks(joints: &[JointRows], v: &BodyVelocities) -> Option<Vec<BTreeMap<usize, JointBlock>>> {
    let bodies = joints.iter().flat_map(|joint| joint.bodies).max().map_or(0, |last| last + 1);
    let mut at: Vec<ArrayVec<(usize, usize), MOST_BLOCKS>> = vec![ArrayVec::new(); bodies];
    for (index, joint) in joints.iter().enumerate() {
        for (side, &body) in joint.bodies.iter().enumerate().filter(|(_, body)| !v.bodies[**body].is_fixed()) {
            at[body].try_push((index, side)).ok()?;
        }
    }
    let mut blocks: Vec<BTreeMap<usize, JointBlock>> = joints.iter().map(|_| BTreeMap::new()).collect();
    for (body, own) in at.iter().enumerate() {
        for &(one, side) in own {
            for &(other, across) in own {
                let sign = if side == across { 1.0 } else { -1.0 };
                let block = blocks[one].entry(other).or_insert(NOTHING);
                for (i, row) in joints[one].rows.iter().enumerate() {
                    for (j, column) in joints[other].rows.iter().enumerate() {
                        block[i][j] += sign * v.coupling(body, (row, side), (column, across));
                    }
                }
            }
        }
    }
    for (joint, row) in blocks.iter_mut().enumerate() {
        // Joints between fixed bodies have no block.
        let own = row.entry(joint).or_insert(NOTHING);
        (0..MOST_ROWS).for_each(|i| own[i][i] *= 1.0 + SHIFT);
    }
    Some(blocks)
}

fn dot(one: &[f64; MOST_ROWS], other: &[f64; MOST_ROWS]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn transposed(block: &JointBlock) -> JointBlock {
    std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]))
}

fn product(one: &JointBlock, other: &JointBlock) -> JointBlock {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..MOST_ROWS).map(|k| one[i][k] * other[k][j]).sum()))
}

//! Factorization L D Lᵀ of sparse symmetric positive definite matrices.
//!
//! The order of elimination is approximate minimum degree (crate `amd`: P. R. Amestoy, T. A. Davis, I. S. Duff, SIAM J.
//! Matrix Anal. Appl. 17, 886 (1996)). Rows of L are computed one after another, each from the columns in which it is not
//! zero. The elimination tree gives these columns: T. A. Davis, "Direct Methods for Sparse Linear Systems", 2006, chapter 4.
//! All sums are in one fixed order, so that the bits are the same on every processor.

use std::ops::{Div, Mul, SubAssign};

use glam::{DVec3, DVec4};

use crate::error::Result;
use crate::memory;
use crate::parallel::{Executor, attend};
use crate::simd::{Isa, Kernel, dispatch};

/// Factorization of matrices with one pattern of entries.
#[derive(Debug, Clone)]
pub struct Factorization {
    /// Place of each row of the matrix in the order of elimination.
    place: Vec<u32>,
    /// Entries left of the diagonal, by place: the place of the column and the index of the value.
    entries: Vec<Vec<[u32; 2]>>,
    /// Row of the matrix, by place.
    row: Vec<u32>,
    /// Elimination tree, by place: the first row below the diagonal that is not zero, or `NONE`.
    parent: Vec<u32>,
    /// Start of each column of L, by place.
    start: Vec<usize>,
    /// Rows and values of L below the diagonal, column by column.
    rows: Vec<u32>,
    values: Vec<f64>,
    /// Diagonal of D.
    pivots: Vec<f64>,
    scratch: Scratch,
}

#[derive(Debug, Clone, Default)]
struct Scratch {
    /// Row of the matrix, then of L D, by place of the column.
    row: Vec<f64>,
    /// Last row whose pattern includes the column, by place.
    mark: Vec<u32>,
    /// Pattern of a row, and a path in the tree.
    pattern: Vec<u32>,
    path: Vec<u32>,
    /// Number of values in the column so far, by place.
    filled: Vec<usize>,
}

/// Marker of no row.
const NONE: u32 = u32::MAX;

/// Name of the allocation in errors.
const NAME: &str = "the factorization";

/// Memory of the analysis per row and entry [bytes].
const ANALYSIS: usize = 250;

/// Number of entries from which on the search for the order of elimination takes more than some 20 ms.
const LONG: usize = 20_000;

impl Factorization {
    /// Analyzes the pattern of matrices with `count` rows. The entries [row, column] are off the diagonal, each once, in any
    /// triangle.
    ///
    /// # Errors
    /// If L does not fit into memory, or on an interrupt.
    pub fn new(count: usize, entries: &[[u32; 2]], executor: &Executor) -> Result<Self> {
        memory::check(NAME, ANALYSIS * (count + entries.len()), 0, || format!("for {count} rows; take fewer springs or rods"))?;
        executor.check()?;
        let row = elimination_order(count, entries, executor)?;
        executor.check()?;
        let mut place = vec![0; count];
        row.iter().enumerate().for_each(|(index, &row)| place[row as usize] = index as u32);
        let mut left = vec![Vec::new(); count];
        for (index, entry) in entries.iter().enumerate() {
            let [one, other] = entry.map(|row| place[row as usize]);
            left[one.max(other) as usize].push([one.min(other), index as u32]);
        }
        let scratch = Scratch { row: vec![0.0; count], mark: vec![NONE; count], filled: vec![0; count], ..Scratch::default() };
        let mut new = Self {
            parent: tree(&left),
            place,
            entries: left,
            row,
            start: Vec::new(),
            rows: Vec::new(),
            values: Vec::new(),
            pivots: vec![0.0; count],
            scratch,
        };
        new.allocate(executor)?;
        Ok(new)
    }

    /// Allocates the columns of L; their lengths follow from the patterns of its rows.
    fn allocate(&mut self, executor: &Executor) -> Result<()> {
        let count = self.row.len();
        let mut lengths = vec![0; count];
        for row in 0..count {
            executor.check()?;
            self.find_pattern(row);
            self.scratch.pattern.iter().for_each(|&column| lengths[column as usize] += 1);
        }
        let mut total = 0;
        for length in lengths {
            self.start.push(total);
            total += length;
        }
        memory::check(NAME, total * (size_of::<u32>() + size_of::<f64>()), 0, || {
            format!("for {total} entries of the factor; take fewer springs or rods")
        })?;
        (self.rows, self.values) = (vec![0; total], vec![0.0; total]);
        Ok(())
    }

    /// Number of values of L below the diagonal.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Number of products of a factorization: Σ n² over the lengths n of the columns of L.
    pub fn products(&self) -> usize {
        let ends = self.start.iter().copied().skip(1).chain([self.rows.len()]);
        self.start.iter().zip(ends).map(|(start, end)| (end - start) * (end - start)).sum()
    }

    /// Whether the matrix is diagonal.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Finds the columns in which a row of L is not zero, each after those on which it depends.
    fn find_pattern(&mut self, row: usize) {
        let Scratch { mark, pattern, path, .. } = &mut self.scratch;
        pattern.clear();
        mark[row] = row as u32;
        for &[column, _] in &self.entries[row] {
            path.clear();
            let mut next = column;
            while mark[next as usize] != row as u32 {
                path.push(next);
                mark[next as usize] = row as u32;
                next = self.parent[next as usize];
            }
            // A path ends in an earlier one, whose columns depend on it.
            path.iter().rev().for_each(|&column| pattern.push(column));
        }
        // Paths run from the root downwards, last to first: in reverse each column comes after its descendants.
        pattern.reverse();
    }

    /// Factorizes the matrix with these diagonal values by row, plus `shift`, and these off-diagonal values by entry. Ends early
    /// on an interrupt.
    pub fn factorize(&mut self, diagonal: &[f64], shift: f64, off_diagonal: &[f64], executor: &Executor) {
        self.scratch.filled.fill(0);
        self.scratch.mark.fill(NONE);
        for row in 0..self.row.len() {
            // The last rows take a millisecond each, where there are 10⁵.
            if executor.stopped() {
                return;
            }
            self.find_pattern(row);
            let Scratch { row: sums, pattern, filled, .. } = &mut self.scratch;
            for &[column, index] in &self.entries[row] {
                sums[column as usize] = off_diagonal[index as usize];
            }
            let mut pivot = diagonal[self.row[row] as usize] + shift;
            for &column in pattern.iter() {
                let column = column as usize;
                let sum = std::mem::take(&mut sums[column]);
                let (first, next) = (self.start[column], self.start[column] + filled[column]);
                for (below, value) in self.rows[first..next].iter().zip(&self.values[first..next]) {
                    sums[*below as usize] -= value * sum;
                }
                let value = sum / self.pivots[column];
                pivot -= value * sum;
                (self.rows[next], self.values[next]) = (row as u32, value);
                filled[column] += 1;
            }
            self.pivots[row] = pivot;
        }
    }

    /// Pivots D, in the order of elimination.
    pub fn pivots(&self) -> &[f64] {
        &self.pivots
    }

    /// Solves A x = b in place; `y` is a buffer.
    pub fn solve<X: RightSide>(&self, x: &mut [X], y: &mut Vec<X::Wide>) {
        y.resize(x.len(), X::default().widen());
        x.iter().zip(self.place.iter()).for_each(|(&value, &place)| y[place as usize] = value.widen());
        dispatch(Substitution { factorization: self, y });
        x.iter_mut().zip(self.place.iter()).for_each(|(value, &place)| *value = X::narrow(y[place as usize]));
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.values.len() * (size_of::<f64>() + size_of::<u32>())
            + self.row.len() * 64
            + self.entries.iter().map(Vec::len).sum::<usize>() * 8
    }
}

/// Component of a right-hand side: a number, or a vector. A fourth component 0 makes a vector as wide as a register.
pub trait RightSide: Copy + Default {
    /// Storage type of the component.
    type Wide: Copy + SubAssign + Mul<f64, Output = Self::Wide> + Div<f64, Output = Self::Wide>;
    /// Converts to the storage type.
    fn widen(self) -> Self::Wide;
    /// Converts from the storage type.
    fn narrow(wide: Self::Wide) -> Self;
}

impl RightSide for f64 {
    type Wide = Self;

    fn widen(self) -> Self {
        self
    }

    fn narrow(wide: Self) -> Self {
        wide
    }
}

impl RightSide for DVec3 {
    type Wide = DVec4;

    fn widen(self) -> DVec4 {
        self.extend(0.0)
    }

    fn narrow(wide: DVec4) -> Self {
        wide.truncate()
    }
}

/// Substitution: solves L D Lᵀ y = y in place, in the order of elimination.
struct Substitution<'a, W> {
    factorization: &'a Factorization,
    y: &'a mut [W],
}

impl<W: Copy + SubAssign + Mul<f64, Output = W> + Div<f64, Output = W>> Kernel for Substitution<'_, W> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { factorization: Factorization { start, rows, values, pivots, .. }, y } = self;
        let end = |column: usize| start.get(column + 1).copied().unwrap_or(values.len());
        for column in 0..pivots.len() {
            let (known, entries) = (y[column], start[column]..end(column));
            for (&row, &value) in rows[entries.clone()].iter().zip(&values[entries]) {
                y[row as usize] -= known * value;
            }
        }
        for column in (0..pivots.len()).rev() {
            let (mut sum, entries) = (y[column] / pivots[column], start[column]..end(column));
            for (&row, &value) in rows[entries.clone()].iter().zip(&values[entries]) {
                sum -= y[row as usize] * value;
            }
            y[column] = sum;
        }
    }
}

/// Order of elimination of the rows. The crate does not look for interrupts: a long search is left to a thread of its own, which
/// nobody waits for after an interrupt.
fn elimination_order(count: usize, entries: &[[u32; 2]], executor: &Executor) -> Result<Vec<u32>> {
    let mut columns: Vec<Vec<usize>> = (0..count).map(|row| vec![row]).collect();
    for &[one, other] in entries {
        columns[one as usize].push(other as usize);
        columns[other as usize].push(one as usize);
    }
    let mut starts = vec![0];
    for column in &mut columns {
        column.sort_unstable();
        starts.push(starts.last().unwrap_or(&0) + column.len());
    }
    let columns = columns.concat();
    let search = move |_: &Executor| amd::order(count, &starts, &columns, &amd::Control::default());
    let found = if entries.len() < LONG { search(executor) } else { attend(1, &|| executor.stopped(), search)? };
    let natural = || (0..count as u32).collect();
    Ok(found.map_or_else(|_| natural(), |(order, _, _)| order.into_iter().map(|row| row as u32).collect()))
}

/// Elimination tree of a matrix, from the entries left of its diagonal. Ancestors are shortcuts to the roots so far.
fn tree(entries: &[Vec<[u32; 2]>]) -> Vec<u32> {
    let mut parent = vec![NONE; entries.len()];
    let mut ancestor = parent.clone();
    for (row, left) in entries.iter().enumerate() {
        for &[column, _] in left {
            let mut next = column;
            while next != NONE && next < row as u32 {
                let above = std::mem::replace(&mut ancestor[next as usize], row as u32);
                if above == NONE {
                    parent[next as usize] = row as u32;
                }
                next = above;
            }
        }
    }
    parent
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Factorization;
    use crate::parallel::SERIAL;

    /// Diagonally dominant matrix of a given pattern: its diagonal and its full rows.
    fn matrix(count: usize, entries: &[[u32; 2]], values: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut full = vec![vec![0.0; count]; count];
        for (&[one, other], &value) in entries.iter().zip(values) {
            full[one as usize][other as usize] = value;
            full[other as usize][one as usize] = value;
        }
        let diagonal: Vec<f64> = full.iter().map(|row| 1.0 + row.iter().map(|value: &f64| value.abs()).sum::<f64>()).collect();
        (0..count).for_each(|row| full[row][row] = diagonal[row]);
        (diagonal, full)
    }

    proptest! {
        /// A backward-stable solution has ‖A x − b‖ of about n ε ‖A‖ ‖x‖. The matrix has ‖A‖ ≤ 2 max diagonal, and its
        /// smallest eigenvalue of 1 makes ‖x‖ ≤ ‖b‖.
        #[test]
        fn solutions_solve(count in 1_usize..30, seed in proptest::collection::vec((0_u32..900, -1.0..1.0_f64), 0..120)) {
            let mut entries = std::collections::BTreeMap::new();
            for (place, value) in seed {
                let (one, other) = (place / 30 % count as u32, place % 30 % count as u32);
                if one != other {
                    entries.insert([one.max(other), one.min(other)], value);
                }
            }
            let (pattern, values): (Vec<_>, Vec<_>) = entries.into_iter().unzip();
            let (diagonal, full) = matrix(count, &pattern, &values);
            let mut factorization = Factorization::new(count, &pattern, &SERIAL).unwrap();
            let right: Vec<f64> = (0..count).map(|row| (row as f64 + 1.0).sin()).collect();
            // Factorize twice, with other values first: nothing of the first factorization stays.
            factorization.factorize(&vec![1.0; count], 0.0, &vec![0.0; values.len()], &SERIAL);
            factorization.factorize(&diagonal, 0.0, &values, &SERIAL);
            let mut solution = right.clone();
            factorization.solve(&mut solution, &mut Vec::new());
            let largest = diagonal.iter().copied().fold(0.0, f64::max);
            for (row, right) in full.iter().zip(&right) {
                let product: f64 = row.iter().zip(&solution).map(|(a, x)| a * x).sum();
                prop_assert!((product - right).abs() < count as f64 * count as f64 * 2.0 * largest * f64::EPSILON);
            }
        }
    }

    #[test]
    fn a_chain_fills_nothing_in() {
        let entries: Vec<[u32; 2]> = (1..50).map(|row| [row, row - 1]).collect();
        assert_eq!(Factorization::new(50, &entries, &SERIAL).unwrap().len(), 49);
    }

    /// Nested dissection of an n × n grid fills in about 31/8 n² log₂ n values, and minimum degree no more. Rows in their
    /// natural order fill in n³.
    #[test]
    fn a_grid_fills_in_less_than_a_band() {
        let side = 40_u32;
        let along = (0..side * side).filter(|index| index % side != 0).map(|index| [index, index - 1]);
        let entries: Vec<[u32; 2]> = along.chain((side..side * side).map(|index| [index, index - side])).collect();
        let size = f64::from(side * side);
        assert!((Factorization::new(1600, &entries, &SERIAL).unwrap().len() as f64) < 31.0 / 8.0 * size * f64::from(side).log2());
    }
}

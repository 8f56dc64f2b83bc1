//! Hamiltonian H = −ħ²/2m ∇² + V + g |ψ|² on a grid, by three-point differences, and sums over cells.

use std::ops::Range;

use super::fourier::{Complex, FourierReal, Spectrum, square};
use super::passes::Field;
use crate::grid::{Edge, Edges, Padding};
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};

/// Number of cells in a block.
const BLOCK: usize = 8192;

/// Hamiltonian of a wave function.
#[derive(Debug)]
pub struct Hamiltonian<T> {
    /// Position of the user's grid within all cells, which include absorbing layers.
    pub padding: Padding,
    pub edges: Edges,
    /// Potential V of each cell [J].
    pub potential: Vec<T>,
    /// Interaction g [J·m^D].
    pub interaction: f64,
    /// Reduced Planck constant ħ [J·s].
    pub hbar: f64,
    /// Hopping energy ħ²/2m h² [J].
    pub hopping: f64,
    /// Modes along each axis.
    pub spectra: [Spectrum<T>; AXES],
}

/// Energies of a state [J].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energies {
    pub kinetic: f64,
    pub potential: f64,
    pub interaction: f64,
}

impl Energies {
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential + self.interaction
    }

    pub fn magnitude(&self) -> f64 {
        self.kinetic + self.potential.abs() + self.interaction.abs()
    }
}

impl<T: FourierReal> Hamiltonian<T> {
    /// Boundary conditions of an axis; absorbing layers have fixed ends.
    pub fn ends(&self, axis: usize) -> [Edge; 2] {
        self.edges.0[axis].map(|edge| if edge == Edge::Absorbing { Edge::Fixed } else { edge })
    }

    /// Kinetic energies of the modes along an axis [J].
    pub fn mode_energies(&self, axis: usize) -> Vec<f64> {
        self.spectra[axis].wave_numbers().iter().map(|q| self.hopping * q * q).collect()
    }

    /// Largest kinetic energy of a mode [J].
    pub fn largest_mode(&self) -> f64 {
        self.padding.outer.axes().map(|axis| self.mode_energies(axis).into_iter().fold(0.0, f64::max)).sum()
    }

    /// Sum of the neighbors of a cell along all axes, and the weight of the cell itself in −h²∇².
    #[inline(always)]
    fn neighbors(&self, values: &[T], row: usize, rows: &[[Option<usize>; 2]; 2], column: usize) -> (T, T) {
        let (grid, length) = (&self.padding.outer, self.padding.outer.row_length());
        let (mut sum, mut own) = (T::ZERO, T::ZERO);
        let of = |row: usize, column: usize| values[row * length + column];
        for axis in grid.axes() {
            let ends = self.ends(axis);
            for side in 0..2 {
                let beside = match (axis, side) {
                    (0 | 1, _) => rows[axis][side].map(|row| of(row, column)),
                    (_, 0) if column > 0 => Some(of(row, column - 1)),
                    (_, 1) if column + 1 < length => Some(of(row, column + 1)),
                    _ => grid.periodic[2].then(|| of(row, if side == 0 { length - 1 } else { 0 })),
                };
                match beside {
                    Some(value) => {
                        sum += value;
                        own += T::ONE;
                    }
                    None if ends[side] == Edge::Fixed => own += T::from_f64(2.0),
                    None => {}
                }
            }
        }
        (sum, own)
    }

    /// Adds `factor` times H, without interaction, of one component of ψ to `target`.
    pub fn apply(&self, source: &[T], target: &mut [T], factor: f64, executor: &Executor) {
        let (grid, length) = (&self.padding.outer, self.padding.outer.row_length());
        let (hopping, factor) = (T::from_f64(factor * self.hopping), T::from_f64(factor));
        executor.for_each_block(BlockedSlice::new(target, length), &|block: BlockedSlice<'_, T>| {
            let row = block.start / length;
            let rows = grid.neighbors(row);
            for (column, slot) in block.items.iter_mut().enumerate() {
                let at = block.start + column;
                let (sum, own) = self.neighbors(source, row, &rows, column);
                *slot += hopping * (own * source[at] - sum) + factor * (self.potential[at] * source[at]);
            }
        });
    }

    /// Energies of a state. If `spectral`, the kinetic energy is that of the modes, else it is computed by differences.
    pub fn energies(&self, field: &mut Field<'_, T>, spectral: bool, executor: &Executor) -> Energies {
        let content = self.padding.outer.content();
        let values = field.values.as_slice();
        let [potential, interaction] = sum([values.len(), BLOCK], executor, &|cells| {
            let mut sums = [0.0; 2];
            for (value, potential) in values[cells.clone()].iter().zip(&self.potential[cells]) {
                let density = square(*value);
                sums[0] += potential.to_f64() * density;
                sums[1] += 0.5 * self.interaction * density * density;
            }
            sums
        });
        let kinetic =
            if spectral { self.spectral_energy(field, executor) } else { self.difference_energy(field.values, executor) };
        Energies { kinetic: content * kinetic, potential: content * potential, interaction: content * interaction }
    }

    fn spectral_energy(&self, field: &mut Field<'_, T>, executor: &Executor) -> f64 {
        let along = |axis: usize| {
            let spectrum = &self.spectra[axis];
            let energies = self.mode_energies(axis);
            let shares: Vec<f64> = energies.iter().zip(spectrum.weights()).map(|(energy, weight)| energy * weight).collect();
            field.pass(axis, [None, None], spectrum.scratch(), executor, &|_, _, line, memory| {
                spectrum.analyze(line, memory);
                memory.iter().zip(&shares).map(|(mode, share)| share * square(*mode)).sum()
            })
        };
        self.padding.outer.axes().map(along).sum()
    }

    /// Kinetic energy by differences, without the factor h^D [J/m^D].
    pub fn difference_energy(&self, values: &[Complex<T>], executor: &Executor) -> f64 {
        let (grid, length) = (&self.padding.outer, self.padding.outer.row_length());
        let parts: [fn(&Complex<T>) -> T; 2] = [|value| value.re, |value| value.im];
        let of = |part: fn(&Complex<T>) -> T| {
            let own: Vec<T> = values.iter().map(part).collect();
            let [sum] = sum([grid.rows(), BLOCK.div_ceil(length)], executor, &|rows| {
                let energy = |row: usize| {
                    let around = grid.neighbors(row);
                    let of = |column: usize| {
                        let (beside, count) = self.neighbors(&own, row, &around, column);
                        let value = own[row * length + column].to_f64();
                        value * (count.to_f64() * value - beside.to_f64())
                    };
                    (0..length).map(of).sum::<f64>()
                };
                [rows.map(energy).sum()]
            });
            sum
        };
        self.hopping * parts.map(of).iter().sum::<f64>()
    }
}

/// Sums over `count` cells or rows, in blocks computed in parallel; the sums of blocks are added in order.
fn sum<const SUMS: usize>(
    [count, size]: [usize; 2],
    executor: &Executor,
    of: &(impl Fn(Range<usize>) -> [f64; SUMS] + Sync),
) -> [f64; SUMS] {
    let mut tallies = vec![[0.0; SUMS]; count.div_ceil(size)];
    executor.for_each_block(BlockedSlice::new(&mut tallies, 1), &|block: BlockedSlice<'_, [f64; SUMS]>| {
        let first = block.start * size;
        block.items[0] = of(first..count.min(first + size));
    });
    std::array::from_fn(|sum| tallies.iter().map(|sums| sums[sum]).sum())
}

//! Energy of a wave, and other sums over its cells, in double precision.

use super::fourth::{self, LineOperator};
use super::state::WaveState;
use super::sweep::WaveLaw;
use crate::grid::Window;
use crate::math::Real;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, LANES, dispatch};

/// Energies of a row without values at edges, divided by the mass of a cell.
#[derive(Debug, Clone, Copy, Default)]
pub struct RowEnergy {
    /// Kinetic part ½ Σ r v².
    pub kinetic: f64,
    /// Potential part ½ [Σ w (Δu)² + Σ κ u²]; for order 4, with the term of the second differences.
    pub potential: f64,
}

/// Energies imposed by values at edges [J].
#[derive(Debug, Clone, Copy, Default)]
pub struct ImposedEnergy {
    /// Energy of all faces.
    pub all: f64,
    /// Energy beyond that of the values at the time 0, by which the faces do work.
    pub driven: f64,
}

/// Sum Σ f (a − b)² over the cells of a row.
struct Differences<'a, T> {
    factors: &'a [T],
    one: &'a [T],
    other: &'a [T],
}

impl<T: Real> Kernel for Differences<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> f64 {
        let count = self.factors.len();
        let (factors, one, other) = (self.factors, &self.one[..count], &self.other[..count]);
        let mut sums = [0.0; LANES];
        let whole = count / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            for lane in 0..LANES {
                let difference = one[at + lane].to_f64() - other[at + lane].to_f64();
                sums[lane] += factors[at + lane].to_f64() * (difference * difference);
            }
        }
        for at in whole..count {
            let difference = one[at].to_f64() - other[at].to_f64();
            sums[at - whole] += factors[at].to_f64() * (difference * difference);
        }
        sums.iter().sum()
    }
}

impl<T: Real> WaveLaw<T> {
    /// Energies of all rows [J / kg].
    pub fn energies(&self, state: &WaveState<T>, executor: &Executor) -> Vec<RowEnergy> {
        let grid = &self.medium.laplacian.grid;
        let mut energies = vec![RowEnergy::default(); grid.rows()];
        executor.for_each_block(BlockedSlice::new(&mut energies, 64), &|block: BlockedSlice<'_, RowEnergy>| {
            let length = grid.row_length();
            let unit = (vec![T::ONE; length], vec![T::ZERO; length]);
            for (index, energy) in block.items.iter_mut().enumerate() {
                if self.padding.crosses(block.start + index) {
                    *energy = self.row_energy(state, block.start + index, (&unit.0, &unit.1));
                }
            }
        });
        energies
    }

    /// Energies imposed by values at edges, Σ m r (2 w g (u − ½ g) or −¼ w h² q²). The energy is ½ ρ h^D Σ κ (u − g)² at faces
    /// at which u is g. At faces at which the derivative is q, it includes that of half a cell.
    pub fn imposed(&self, state: &WaveState<T>, edges: &[f64]) -> ImposedEnergy {
        let (grid, spacing) = (&self.medium.laplacian.grid, self.medium.laplacian.grid.spacing);
        let (length, inside) = (grid.row_length(), self.padding.inside(2));
        let mut energy = ImposedEnergy::default();
        for row in (0..grid.rows()).filter(|&row| self.padding.crosses(row)) {
            for face in self.edges.in_row(row).iter().filter(|face| inside.contains(&face.column)) {
                let (value, u) = (edges[face.slot], state.displacement[row * length + face.column].to_f64());
                let size = |value: f64| if face.held { value * (u - 0.5 * value) } else { -0.25 * spacing * value * value };
                let scale = self.mass * self.medium.relative_density(row, face.column) * face.weight;
                energy.all += scale * size(value);
                energy.driven += scale * (size(value) - size(self.level(face)));
            }
        }
        energy
    }

    /// Sum Σ r (|L u / r + b| + |s|)² over all cells [m²/s⁴], with the sources at their largest.
    pub fn squared_accelerations(&self, state: &WaveState<T>, edges: &[f64]) -> f64 {
        let grid = &self.medium.laplacian.grid;
        let length = grid.row_length();
        let rows = Window::new(&state.displacement, length);
        let largest: Vec<f64> = self.sources.largest().collect();
        let (mut out, mut scratch) = (vec![T::ZERO; length], vec![T::ZERO; fourth::SCRATCH * length]);
        let mut sum = 0.0;
        for row in 0..grid.rows() {
            self.accelerate(rows, row, 0..length, &mut out, &mut scratch);
            self.edges.add(row, 0..length, edges, &mut out);
            let mut sizes: Vec<f64> = out.iter().map(|a| a.to_f64().abs()).collect();
            for patch in self.sources.in_row(row) {
                let driven = sizes[patch.first..].iter_mut().zip(&patch.weights);
                driven.for_each(|(size, weight)| *size += (largest[patch.source] * weight).abs());
            }
            let density = |column: usize| self.medium.relative_density(row, column);
            sum += sizes.iter().enumerate().map(|(column, size)| density(column) * size * size).sum::<f64>();
        }
        sum
    }

    fn row_energy(&self, state: &WaveState<T>, row: usize, (ones, zeros): (&[T], &[T])) -> RowEnergy {
        let (medium, laplacian) = (&self.medium, &self.medium.laplacian);
        let grid = &laplacian.grid;
        let length = grid.row_length();
        let rows = Window::new(&state.displacement, length);
        let of = |row: usize| &state.displacement[row * length..][..length];
        let (center, rate) = (of(row), &state.rate[row * length..][..length]);
        // Only faces between two inner cells count.
        let inside = self.padding.inside(2);
        let (from, last) = (inside.start, inside.end - 1);
        let sum = |factors: &[T], one: &[T], other: &[T]| {
            let [factors, one, other] = [factors, one, other].map(|row| &row[inside.clone()]);
            dispatch(Differences { factors, one, other })
        };
        let along = laplacian.faces[2].row(row);
        let line = Differences { factors: &along[from..last], one: &center[from + 1..=last], other: &center[from..last] };
        let around = if grid.periodic[2] { along[last].to_f64() } else { 0.0 };
        let mut potential = dispatch(line)
            + around * (center[from].to_f64() - center[last].to_f64()).powi(2)
            + sum(laplacian.anchor.row(row), center, zeros);
        for axis in grid.axes().filter(|&axis| axis < 2) {
            if let Some(above) = grid.beside(row, axis, true).filter(|&above| self.padding.crosses(above)) {
                potential += sum(laplacian.faces[axis].row(row), of(above), center);
            }
        }
        if let Some(fourth) = &medium.fourth {
            let mut second = vec![T::ZERO; length];
            for axis in grid.axes() {
                LineOperator { medium, fourth }.of(axis, rows, row, &mut second);
                potential += sum(fourth.slowness.row(row), &second, zeros);
            }
        }
        let density = medium.density.as_ref().map_or(ones, |density| density.relative.row(row));
        RowEnergy { kinetic: 0.5 * sum(density, rate, zeros), potential: 0.5 * potential }
    }
}

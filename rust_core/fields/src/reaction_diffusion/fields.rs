//! Fields of the species, in double precision, and the estimate of their errors.

use super::ReactionDiffusion;
use super::kinetics::with_law;
use super::law::SpeciesTally;
use crate::error::{Error, Result};
use crate::grid::Window;
use crate::math::Real;
use crate::systems::{Control, FieldInfo, Location};

impl<T: Real> ReactionDiffusion<T> {
    /// Row of a species in a field.
    pub(super) fn species_row<'a>(&self, species: usize, row: usize, field: &'a [T]) -> &'a [T] {
        let (length, fields) = (self.law.grid.row_length(), self.law.species.len());
        Window { fields, field: species, ..Window::new(field, length) }.row(row)
    }

    /// Values of a species in a field, cell by cell.
    pub(super) fn species_rows<'a>(&'a self, species: usize, field: &'a [T]) -> impl Iterator<Item = &'a T> {
        (0..self.law.grid.rows()).flat_map(move |row| self.species_row(species, row, field))
    }

    /// Descriptions of the fields, with the shape of the grid.
    pub(super) fn field_infos(&self) -> Vec<FieldInfo> {
        let shape = self.law.grid.shape();
        let info = |&name: &&str| FieldInfo {
            name: name.to_owned(),
            unit: "1",
            location: Location::Cells,
            shape: shape.clone(),
            rate: None,
            state: true,
        };
        self.law.species.iter().map(info).collect()
    }

    /// Amount of a species, summed row by row, in units of a cell with value 1.
    pub(super) fn amount(&self, species: usize) -> f64 {
        let row = |row: usize| self.species_row(species, row, &self.state.field).iter().map(|value| value.to_f64()).sum::<f64>();
        (0..self.law.grid.rows()).map(row).sum()
    }

    /// Sum of one tally of a species over all rows.
    pub(super) fn tallied(&self, species: usize, of: fn(&SpeciesTally) -> f64) -> f64 {
        self.state.tallies.iter().skip(species).step_by(self.law.species.len()).map(of).sum()
    }

    /// Replaces a field by name.
    pub(super) fn replace(&mut self, name: &str, values: &[f64]) -> Result<()> {
        let path = || format!("set.{name}");
        let grid = &self.law.grid;
        let species = self.law.species.iter().position(|&own| own == name);
        let species = species.ok_or_else(|| Error::parameter(path(), self.law.species.join(" or "), name))?;
        if values.len() != grid.count() {
            return Err(Error::parameter(path(), format!("{} numbers", grid.count()), values.len()));
        }
        if let Some(cell) = values.iter().position(|&value| !T::from_f64(value).is_finite()) {
            let expected = format!("a finite number that {} holds", T::NAME);
            return Err(Error::parameter(format!("{} at {}", path(), grid.name(cell)), expected, values[cell]));
        }
        let before = self.amount(species);
        let (length, width, offset) = (grid.row_length(), self.law.width(), species * grid.row_length());
        for (row, values) in values.chunks_exact(length).enumerate() {
            let slots = &mut self.state.field[row * width + offset..][..length];
            slots.iter_mut().zip(values).for_each(|(slot, &value)| *slot = T::from_f64(value));
        }
        self.state.tallies[species].set += self.amount(species) - before;
        Ok(())
    }

    /// Largest estimated error of the last step of `h` seconds. The slope at its end is evaluated from the present state.
    pub(super) fn estimate(&self, h: f64) -> Option<(f64, Control)> {
        let estimate = self.method.estimate.as_ref()?;
        let control = Control::pair(estimate.order);
        let Ok(given) = self.given(&self.state.field) else { return Some((f64::INFINITY, control)) };
        let (length, count) = (self.law.grid.row_length(), self.law.species.len());
        let edges = &self.workspace.edges[self.workspace.edges.len() - self.law.edge_values()..];
        let mut slope = vec![T::ZERO; count * length];
        let mut largest = 0.0_f64;
        for row in 0..self.law.grid.rows() {
            for (species, diffusion) in self.law.diffusion.iter().enumerate() {
                let window = Window { fields: count, field: species, ..Window::new(&self.state.field, length) };
                let out = &mut slope[species * length..(species + 1) * length];
                diffusion.apply(window, row, 0..length, out);
                self.law.edges[species].add(row, 0..length, edges, out);
            }
            self.react(row, given.as_deref(), &mut slope);
            let first = row * count * length;
            for (index, slope) in slope.iter().enumerate() {
                let kept = |column: usize| self.workspace.columns[column][first + index].to_f64();
                let slopes = estimate.slopes.iter().enumerate().map(|(place, weight)| weight * kept(1 + place));
                let change = h * (slopes.sum::<f64>() + estimate.slope * slope.to_f64());
                let ends = estimate.start * kept(0) + estimate.end * self.state.field[first + index].to_f64();
                let error = (ends + change).abs();
                largest = if error.is_nan() || error > largest { error } else { largest };
            }
        }
        Some((if largest.is_nan() { f64::INFINITY } else { largest }, control))
    }

    /// Adds the reaction rates in a row of the present state to those of diffusion.
    fn react(&self, row: usize, given: Option<&[T]>, slope: &mut [T]) {
        let (length, width) = (self.law.grid.row_length(), self.law.width());
        with_law!(
            &self.law.kinetics,
            law => {
                let values = [0, 1].map(|species| self.species_row(species, row, &self.state.field));
                let kinetics = law.row(row);
                for cell in 0..length {
                    let [one, other] = super::kinetics::RateLaw::rates(kinetics.at(cell), [values[0][cell], values[1][cell]]);
                    slope[cell] += one;
                    slope[length + cell] += other;
                }
            },
            _function => {
                let rates = &given.unwrap_or_default()[row * width..][..width];
                slope.iter_mut().zip(rates).for_each(|(slope, &rate)| *slope += rate);
            }
        );
    }
}

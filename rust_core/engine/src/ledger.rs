//! The energy budget: rows of energies by class and name.
//!
//! Dissipation and work are time integrals of the terms' own power, so the balance, total + dissipated − work, is constant
//! up to the truncation error of the integrator. All sums are in double precision, summed block by block in the order of
//! the particles.

use std::ops::Range;

/// The class of an energy in the budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// Kinetic energy of everything that is not fixed.
    Kinetic,
    /// Potential energy of a force.
    Potential,
    /// Internal energy of the compression of fluids.
    Internal,
    /// Energy dissipated since the start.
    Dissipated,
    /// Work done on the system since the start: by drivers, wind, user-defined forces, fixed particles that move, and the shifting of fluids.
    Work,
}

/// One energy of the budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Its class.
    pub class: Class,
    /// Its name within the class, such as that of the force.
    pub name: &'static str,
    /// Energy [J].
    pub energy: f64,
}

/// The energy budget at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    rows: Vec<Row>,
    count: usize,
    block: usize,
}

impl Ledger {
    /// An empty budget of `count` particles, whose energies are summed in blocks of `block`.
    pub fn new(count: usize, block: usize) -> Self {
        Self { rows: Vec::with_capacity(16), count, block }
    }

    /// Adds an energy [J] to the row of that class and name.
    pub fn add(&mut self, class: Class, name: &'static str, energy: f64) {
        match self.rows.iter_mut().find(|row| row.class == class && row.name == name) {
            Some(row) => row.energy += energy,
            None => self.rows.push(Row { class, name, energy }),
        }
    }

    /// Adds the sum of the energies `of(block)` [J] over all blocks.
    pub fn add_blocks(&mut self, class: Class, name: &'static str, of: impl Fn(Range<usize>) -> f64) {
        let blocks = 0..self.count.div_ceil(self.block);
        let energy = blocks.map(|index| of(index * self.block..((index + 1) * self.block).min(self.count))).sum();
        self.add(class, name, energy);
    }

    /// Adds the rows of another system's budget.
    pub fn merge(&mut self, other: &Self) {
        other.rows.iter().for_each(|row| self.add(row.class, row.name, row.energy));
    }

    /// The rows, in the order in which they were added.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The sum over a class [J].
    pub fn sum(&self, class: Class) -> f64 {
        self.rows.iter().filter(|row| row.class == class).fold(0.0, |sum, row| sum + row.energy)
    }

    /// Kinetic, internal and potential energy [J].
    pub fn total(&self) -> f64 {
        self.sum(Class::Kinetic) + self.sum(Class::Internal) + self.sum(Class::Potential)
    }

    /// total + dissipated − work [J].
    pub fn balance(&self) -> f64 {
        self.total() + self.sum(Class::Dissipated) - self.sum(Class::Work)
    }

    /// Magnitude of the terms of the balance [J], the scale of its rounding error.
    pub fn magnitude(&self) -> f64 {
        let potential = self.rows.iter().filter(|row| row.class == Class::Potential).fold(0.0, |sum, row| sum + row.energy.abs());
        self.sum(Class::Kinetic)
            + potential
            + self.sum(Class::Internal)
            + self.sum(Class::Dissipated)
            + self.sum(Class::Work).abs()
    }
}

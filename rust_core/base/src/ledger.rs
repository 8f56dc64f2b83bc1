//! Energy budget: energies by class and name; budgets of further conserved quantities.
//!
//! Dissipation and work are time integrals of the power of the terms. The balance, total + dissipated − work, is therefore
//! constant up to the truncation error of the integrator. All sums are in double precision, block by block in the order of the
//! particles.

use std::ops::Range;

use crate::error::{Error, Result};

/// Class of an energy in the budget.
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
    /// Work done on the system since the start: by drivers, wind, user-defined forces, moving fixed particles, and the shifting
    /// of fluids.
    Work,
}

/// Energy of the budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LedgerRow {
    /// Class of the energy.
    pub class: Class,
    /// Name within the class, such as that of the force.
    pub name: &'static str,
    /// Energy [J].
    pub energy: f64,
}

/// Budget of a conserved quantity other than energy, such as the amount of a species or a probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// Name of the quantity: `u`.
    pub name: String,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Amount present.
    pub stored: f64,
    /// Amounts removed since the start, by sink.
    pub removed: Vec<(&'static str, f64)>,
    /// Amounts supplied since the start, by source.
    pub supplied: Vec<(&'static str, f64)>,
}

impl Budget {
    /// Adds the budget of another system.
    fn merge(&mut self, other: &Self) {
        self.stored += other.stored;
        for (own, others) in [(&mut self.removed, &other.removed), (&mut self.supplied, &other.supplied)] {
            for &(name, amount) in others {
                match own.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, sum)) => *sum += amount,
                    None => own.push((name, amount)),
                }
            }
        }
    }
}

/// Energy budget at one time, with the budgets of further conserved quantities.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    rows: Vec<LedgerRow>,
    budgets: Vec<Budget>,
    count: usize,
    block: usize,
}

impl Ledger {
    /// Returns an empty budget of `count` particles whose energies are summed in blocks of `block`.
    pub fn new(count: usize, block: usize) -> Self {
        Self { rows: Vec::with_capacity(16), budgets: Vec::new(), count, block }
    }

    /// Adds an energy [J] to the row with this class and name.
    pub fn add(&mut self, class: Class, name: &'static str, energy: f64) {
        match self.rows.iter_mut().find(|row| row.class == class && row.name == name) {
            Some(row) => row.energy += energy,
            None => self.rows.push(LedgerRow { class, name, energy }),
        }
    }

    /// Adds the sum of the energies `of(block)` [J] over all blocks.
    pub fn add_blocks(&mut self, class: Class, name: &'static str, of: impl Fn(Range<usize>) -> f64) {
        let blocks = 0..self.count.div_ceil(self.block);
        let energy = blocks.map(|index| of(index * self.block..((index + 1) * self.block).min(self.count))).sum();
        self.add(class, name, energy);
    }

    /// Adds the budget of a further conserved quantity to the one with the same name and unit.
    pub fn add_budget(&mut self, budget: Budget) {
        match self.budgets.iter_mut().find(|known| known.name == budget.name && known.unit == budget.unit) {
            Some(known) => known.merge(&budget),
            None => self.budgets.push(budget),
        }
    }

    /// Adds the rows and the further budgets of another system.
    pub fn merge(&mut self, other: &Self) {
        other.rows.iter().for_each(|row| self.add(row.class, row.name, row.energy));
        other.budgets.iter().for_each(|budget| self.add_budget(budget.clone()));
    }

    /// Budgets of further conserved quantities, in the order of addition.
    pub fn budgets(&self) -> &[Budget] {
        &self.budgets
    }

    /// Rows of energies, in the order of addition.
    pub fn rows(&self) -> &[LedgerRow] {
        &self.rows
    }

    /// Sum over a class [J].
    pub fn sum(&self, class: Class) -> f64 {
        self.rows.iter().filter(|row| row.class == class).fold(0.0, |sum, row| sum + row.energy)
    }

    /// Total energy: kinetic, internal and potential [J].
    pub fn total(&self) -> f64 {
        self.sum(Class::Kinetic) + self.sum(Class::Internal) + self.sum(Class::Potential)
    }

    /// Energy balance, total + dissipated − work [J].
    pub fn balance(&self) -> f64 {
        self.total() + self.sum(Class::Dissipated) - self.sum(Class::Work)
    }

    /// Returns the budget if it is finite.
    ///
    /// # Errors
    /// If the balance or a stored amount is not; names the first energy or quantity that is not.
    pub fn finite(self) -> Result<Self> {
        if self.balance().is_finite() {
            let infinite = self.budgets.iter().find(|budget| !budget.stored.is_finite());
            let error = infinite.map(|budget| Error::parameter("scene", format!("a finite {}", budget.name), budget.stored));
            return error.map_or(Ok(self), Err);
        }
        let found = self.rows.iter().find(|row| !row.energy.is_finite()).map_or_else(
            || "a sum that is not".to_owned(),
            |row| {
                let name = match row.class {
                    Class::Kinetic => "kinetic",
                    Class::Internal => "internal",
                    _ => row.name,
                };
                format!("{name} energy of {} J", row.energy)
            },
        );
        Err(Error::parameter("scene", "an energy that is finite", found))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn budget(name: &str, stored: f64, removed: &[(&'static str, f64)]) -> Budget {
        Budget { name: name.to_owned(), unit: "mol", stored, removed: removed.to_vec(), supplied: vec![("feed", 0.5)] }
    }

    #[test]
    fn systems_share_the_budgets_of_one_name_and_unit() {
        let (mut ledger, mut other) = (Ledger::new(0, 1), Ledger::new(0, 1));
        ledger.add(Class::Kinetic, "kinetic", 1.0);
        ledger.add_budget(budget("u", 2.0, &[("edges", 0.25)]));
        other.add_budget(budget("u", 3.0, &[("kill", 0.125), ("edges", 1.0)]));
        other.add_budget(budget("v", 7.0, &[]));
        other.add_budget(Budget { unit: "1", ..budget("u", 9.0, &[]) });
        ledger.merge(&other);
        assert_eq!(ledger.rows().len(), 1, "amounts of something else are no energies");
        assert_eq!(ledger.total(), 1.0);
        let both = Budget {
            stored: 5.0,
            removed: vec![("edges", 1.25), ("kill", 0.125)],
            supplied: vec![("feed", 1.0)],
            ..budget("u", 0.0, &[])
        };
        assert_eq!(ledger.budgets(), [both, budget("v", 7.0, &[]), Budget { unit: "1", ..budget("u", 9.0, &[]) }]);
    }
}

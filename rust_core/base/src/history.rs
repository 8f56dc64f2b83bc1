//! History: data beside the state that persist from step to step, such as the positions at the last list build.

use crate::error::{Error, Result};

/// Persistent data on which later steps depend, other than the scene. They are saved before a batch of steps, rolled back if it
/// fails, and stored in checkpoints. The default methods are for systems without such data.
pub trait History {
    /// Saves the data at the start of a batch of steps.
    fn save(&mut self) {}

    /// Restores the last saved data.
    fn rollback(&mut self) {}

    /// Writes to an archive all data that affect the bits of later steps.
    fn capture(&self, _archive: &mut Archive) {}

    /// Reads the data from an archive written by [`History::capture`].
    ///
    /// # Errors
    /// If the archive belongs to something else.
    fn restore(&mut self, _archive: &mut Archive) -> Result<()> {
        Ok(())
    }
}

/// Sequence of numbers, written and read in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Archive {
    numbers: Vec<f64>,
    read: usize,
}

impl Archive {
    /// Returns an archive that reads these numbers.
    pub fn new(numbers: Vec<f64>) -> Self {
        Self { numbers, read: 0 }
    }

    /// Appends numbers.
    pub fn write(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.numbers.extend(numbers);
    }

    /// Reads the next `count` numbers.
    ///
    /// # Errors
    /// If there are fewer.
    pub fn read(&mut self, count: usize) -> Result<&[f64]> {
        let end = self.read.checked_add(count).filter(|&end| end <= self.numbers.len());
        let end = end.ok_or_else(|| Error::State("it does not belong to this scene".to_owned()))?;
        let numbers = &self.numbers[self.read..end];
        self.read = end;
        Ok(numbers)
    }

    /// Reads the next numbers into a column.
    ///
    /// # Errors
    /// If there are fewer.
    pub fn read_into(&mut self, column: &mut [f64]) -> Result<()> {
        self.read(column.len()).map(|numbers| column.copy_from_slice(numbers))
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// If numbers are left.
    pub fn finish(&self) -> Result<()> {
        if self.read == self.numbers.len() {
            return Ok(());
        }
        Err(Error::State("it holds more than the forces of this scene keep".to_owned()))
    }

    /// Returns all numbers.
    pub fn into_numbers(self) -> Vec<f64> {
        self.numbers
    }
}

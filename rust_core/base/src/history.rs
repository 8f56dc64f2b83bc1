//! History: data that persist from step to step besides the state, such as the positions of the last list build.

use crate::error::{Error, Result};

/// Persistent data that later steps depend on, besides the scene: saved and rolled back when a batch of steps fails,
/// captured in checkpoints and restored from them. The defaults are those of no data.
pub trait History {
    /// Saves it at the start of a batch of steps.
    fn save(&mut self) {}

    /// Returns to the last saved data.
    fn rollback(&mut self) {}

    /// Writes it to an archive, as far as the bits of later steps depend on it.
    fn capture(&self, _archive: &mut Archive) {}

    /// Reads it from an archive that [`History::capture`] wrote.
    ///
    /// # Errors
    /// If the archive belongs to something else.
    fn restore(&mut self, _archive: &mut Archive) -> Result<()> {
        Ok(())
    }
}

/// A sequence of numbers, written and read in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Archive {
    numbers: Vec<f64>,
    read: usize,
}

impl Archive {
    /// An archive to read these numbers from.
    pub fn new(numbers: Vec<f64>) -> Self {
        Self { numbers, read: 0 }
    }

    /// Adds numbers at the end.
    pub fn write(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.numbers.extend(numbers);
    }

    /// The next `count` numbers.
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

    /// Fills a column with the next numbers.
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

    /// All numbers.
    pub fn into_numbers(self) -> Vec<f64> {
        self.numbers
    }
}

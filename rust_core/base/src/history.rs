//! History: data beside the state that persist from step to step, such as the positions at the last list build.

use crate::error::{Error, Result};

/// Persistent data on which later steps depend, other than the scene. They are saved before a batch of steps, rolled back if it
/// fails, and stored in checkpoints. The default methods are for systems without such data.
pub trait History {
    /// Saves the data at the start of a batch of steps.
    fn save(&mut self) {}

    /// Restores the last saved data.
    fn rollback(&mut self) {}

    /// Writes to an archive all data that affect the bits of later steps, and the tallies.
    fn capture(&self, _archive: &mut Archive) {}

    /// Reads the data from an archive written by [`History::capture`].
    ///
    /// # Errors
    /// If an array is missing or of another size. A part of the data may then be replaced.
    fn restore(&mut self, _archive: &mut Archive) -> Result<()> {
        Ok(())
    }
}

/// Name of arrays on which no later step depends: time integrals for the budgets.
pub const TALLIES: &str = "tallies";

/// Table of named arrays, in the order of writing. Names are paths of parts, such as `matter/forces/fluid[0]/densities`. They do
/// not depend on other parts of the scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Archive {
    arrays: Vec<NamedArray>,
    /// Path of the present part, with a final slash; empty for the whole.
    part: String,
}

/// Array of an [`Archive`].
#[derive(Debug, Clone, PartialEq)]
struct NamedArray {
    name: String,
    numbers: Vec<f64>,
    read: bool,
}

impl Archive {
    /// Writes or reads a part of the data, whose names begin with that of the part.
    pub fn within<T>(&mut self, part: &str, act: impl FnOnce(&mut Self) -> T) -> T {
        let length = self.part.len();
        self.part.push_str(part);
        self.part.push('/');
        let outcome = act(self);
        self.part.truncate(length);
        outcome
    }

    /// Adds an array.
    pub fn write(&mut self, name: &str, numbers: impl IntoIterator<Item = f64>) {
        let name = self.path(name);
        debug_assert!(self.arrays.iter().all(|array| array.name != name), "{name} is written twice");
        self.arrays.push(NamedArray { name, numbers: numbers.into_iter().collect(), read: false });
    }

    /// Reads an array of any size.
    ///
    /// # Errors
    /// If it is missing.
    pub fn read(&mut self, name: &str) -> Result<&[f64]> {
        let name = self.path(name);
        match self.arrays.iter_mut().find(|array| array.name == name) {
            None => Err(foreign(&format!("{name} is missing"))),
            Some(array) => {
                array.read = true;
                Ok(&array.numbers)
            }
        }
    }

    /// Reads an array of `count` numbers.
    ///
    /// # Errors
    /// If it is missing or of another size.
    pub fn read_exactly(&mut self, name: &str, count: usize) -> Result<&[f64]> {
        let path = self.path(name);
        let numbers = self.read(name)?;
        if numbers.len() == count {
            return Ok(numbers);
        }
        Err(foreign(&format!("{path} has {} numbers instead of {count}", numbers.len())))
    }

    /// Reads an array into a column.
    ///
    /// # Errors
    /// As [`Archive::read_exactly`].
    pub fn read_into(&mut self, name: &str, column: &mut [f64]) -> Result<()> {
        self.read_exactly(name, column.len()).map(|numbers| column.copy_from_slice(numbers))
    }

    /// Reads one number.
    ///
    /// # Errors
    /// As [`Archive::read_exactly`].
    pub fn read_number(&mut self, name: &str) -> Result<f64> {
        self.read_exactly(name, 1).map(|numbers| numbers[0])
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// If an array was not read.
    pub fn finish(&self) -> Result<()> {
        self.arrays.iter().find(|array| !array.read).map_or(Ok(()), |array| Err(foreign(&format!("{} is unknown", array.name))))
    }

    /// All numbers on which later steps depend, in the order of writing.
    pub fn state(&self) -> impl Iterator<Item = &f64> {
        let is_tally = |name: &str| name.rsplit('/').next() == Some(TALLIES);
        self.arrays.iter().filter(move |array| !is_tally(&array.name)).flat_map(|array| &array.numbers)
    }

    /// Names with arrays, in the order of writing.
    pub fn into_arrays(self) -> impl Iterator<Item = (String, Vec<f64>)> {
        self.arrays.into_iter().map(|array| (array.name, array.numbers))
    }

    fn path(&self, name: &str) -> String {
        format!("{}{name}", self.part)
    }
}

impl FromIterator<(String, Vec<f64>)> for Archive {
    fn from_iter<I: IntoIterator<Item = (String, Vec<f64>)>>(arrays: I) -> Self {
        let arrays = arrays.into_iter().map(|(name, numbers)| NamedArray { name, numbers, read: false });
        Self { arrays: arrays.collect(), part: String::new() }
    }
}

/// Error of an archive that another simulation has written.
fn foreign(finding: &str) -> Error {
    Error::State(format!("{finding}; it is of another scene, of other numerics or of another version of physcore"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn archive() -> Archive {
        let mut archive = Archive::default();
        archive.write("time", [0.5]);
        archive.within("matter", |matter| {
            matter.write("positions", [1.0, 2.0]);
            matter.within("forces/fluid[0]", |fluid| fluid.write("densities", [3.0]));
            matter.write(TALLIES, [4.0]);
        });
        archive
    }

    #[test]
    fn arrays_are_read_by_the_names_of_their_parts_in_any_order() {
        let mut archive = archive();
        let density = archive.within("matter", |matter| matter.within("forces/fluid[0]", |fluid| fluid.read_number("densities")));
        assert_eq!(density, Ok(3.0));
        assert!(archive.finish().unwrap_err().to_string().starts_with("state: time is unknown; it is of another scene"));
        assert_eq!(archive.read("time"), Ok(&[0.5][..]));
        archive.within("matter", |matter| {
            assert_eq!(matter.read_exactly("positions", 2), Ok(&[1.0, 2.0][..]));
            assert_eq!(matter.read(TALLIES), Ok(&[4.0][..]));
        });
        assert_eq!(archive.finish(), Ok(()));
    }

    #[test]
    fn an_array_that_is_missing_or_of_another_size_is_named() {
        let error = |read: fn(&mut Archive) -> Result<()>| archive().within("matter", read).unwrap_err().to_string();
        assert!(error(|matter| matter.read("velocities").map(|_| ())).starts_with("state: matter/velocities is missing; "));
        let size = "state: matter/positions has 2 numbers instead of 3; ";
        assert!(error(|matter| matter.read_exactly("positions", 3).map(|_| ())).starts_with(size));
        assert!(archive().read("positions").is_err(), "a name without its part");
    }

    #[test]
    fn tallies_are_no_part_of_the_state() {
        assert_eq!(archive().state().copied().collect::<Vec<_>>(), [0.5, 1.0, 2.0, 3.0]);
        assert_eq!(archive().into_arrays().collect::<Archive>(), archive());
    }
}

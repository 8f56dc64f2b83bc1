//! Steps of a group in sweeps, so short that no body passes through another.

use crate::island::{Accuracy, BodyPair, Island};
use crate::shapes::SolidShape;

/// Largest number of sweeps in a step, and largest way of a body in one of them, over the thickness of the thinnest.
const MOST_SWEEPS: usize = 32;
const PART_OF_THICKNESS: f64 = 0.1;
/// Excess over a whole number of pieces that is rounding.
const ROUNDING: f64 = 1e-6;

/// Equal pieces of sweeps.
#[derive(Debug, Clone, Copy)]
pub struct SweepPieces {
    /// Number of pieces of a single sweep; several sweeps share them.
    pub count: usize,
    /// Length of a piece of a whole step [s].
    pub usual: f64,
    pub accuracy: Accuracy,
}

impl SweepPieces {
    /// Number of pieces of a sweep that takes a part of the time of all.
    fn share(&self, part: f64) -> usize {
        (self.count as f64 * part - ROUNDING).ceil().max(1.0) as usize
    }
}

impl Island {
    /// Number of sweeps of a time in which no body moves farther than a part of a length.
    fn sweeps_of(&self, time: f64, length: f64) -> usize {
        (time * self.speed() / (PART_OF_THICKNESS * length)).ceil().max(1.0) as usize
    }

    /// Least of a length of the pairs [m].
    pub fn least(&self, length: impl Fn(&BodyPair) -> f64) -> f64 {
        self.pairs.iter().map(length).fold(f64::INFINITY, f64::min)
    }

    /// Whether sweeps of a time let no body pass through another.
    pub fn may_be_swept(&self, time: f64) -> bool {
        self.sweeps_of(time, self.least(|pair| pair.thickness)) <= MOST_SWEEPS
    }

    /// Takes what is `left` of a step of `h` seconds in sweeps so short that no body passes through another. Where these would be
    /// too many, sizes bound them in place of thicknesses: thin bodies may be passed through. If these are too many as well, the
    /// bodies stay where they are for the rest of the step.
    pub fn take_sweeps(&mut self, shapes: &[SolidShape], (mut left, h): (f64, f64), pieces: &SweepPieces) {
        let all = left;
        let [thickness, size] = [self.least(|pair| pair.thickness), self.least(|pair| pair.size)];
        self.forget_contacts();
        for done in 0..MOST_SWEEPS {
            let by_thickness = self.sweeps_of(left, thickness);
            let fits = by_thickness <= MOST_SWEEPS - done;
            let count = if fits { by_thickness } else { self.sweeps_of(left, size) };
            let length = left / count as f64;
            self.sweep(shapes, (length, pieces.share(length / all)), pieces, count == 1);
            if count == 1 {
                return;
            }
            self.kick_and_end_piece();
            left -= length;
        }
        self.wait(h);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_share_the_pieces_of_one() {
        let accuracy = Accuracy::FINE;
        let pieces = SweepPieces { count: 4, usual: 0.25, accuracy };
        for sweeps in 1..=MOST_SWEEPS {
            assert_eq!(pieces.share(1.0 / sweeps as f64), 4_usize.div_ceil(sweeps), "{sweeps}");
        }
    }
}

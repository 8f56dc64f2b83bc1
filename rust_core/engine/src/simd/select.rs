//! Lists of the lanes that pass a test.

use super::{LANES, Lanes};

/// Writes `first` plus the number of each accepted lane to the beginning of `out`, in order, and gives how many there are.
/// What follows them in `out` is arbitrary.
#[inline(always)]
pub fn select(first: u32, accepted: &Lanes<bool>, out: &mut Lanes<u32>) -> usize {
    let mut count = 0;
    for lane in 0..LANES {
        // At most as many were accepted as were looked at, so the mask changes nothing but spares a check.
        out[count % LANES] = first + lane as u32;
        count += usize::from(accepted[lane]);
    }
    count
}

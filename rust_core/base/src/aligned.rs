//! Arrays that begin with a cache line, so that no vector register straddles two of them: those take several times as long.

use aligned_vec::{AVec, ConstAlign};

/// The size of a cache line [bytes].
const CACHE_LINE: usize = 64;

/// An array at the beginning of a cache line.
pub type Aligned<T> = AVec<T, ConstAlign<CACHE_LINE>>;

/// An array of equal values.
pub fn filled<T: Copy>(value: T, count: usize) -> Aligned<T> {
    Aligned::from_iter(CACHE_LINE, std::iter::repeat_n(value, count))
}

//! Arrays aligned to cache lines: no vector register straddles two lines, because such an access takes several times as long.

use aligned_vec::{AVec, ConstAlign};

/// Size of a cache line [bytes].
const CACHE_LINE: usize = 64;

/// Array aligned to a cache line.
pub type Aligned<T> = AVec<T, ConstAlign<CACHE_LINE>>;

/// Returns an array of `count` equal values.
pub fn filled<T: Copy>(value: T, count: usize) -> Aligned<T> {
    Aligned::from_iter(CACHE_LINE, std::iter::repeat_n(value, count))
}

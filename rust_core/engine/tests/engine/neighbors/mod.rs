//! Neighbors: none is missed and none counted twice, at any extreme; the sums over them always have the same bits.

mod extremes;
mod laboratory;
mod lists;
mod search;
mod sums;

//! Neighbors: nobody is missed, nobody counted twice, at any extreme; and the sums over them have the same bits always.

mod extremes;
mod laboratory;
mod lists;
mod search;
mod sums;

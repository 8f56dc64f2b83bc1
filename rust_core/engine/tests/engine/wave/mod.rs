//! Waves: discrete modes, orders, symmetries, budgets, bits and limits.

mod absorbing;
mod bits;
mod budgets;
mod modes;
mod scene;
mod stability;
mod symmetries;

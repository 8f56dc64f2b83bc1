//! Reactions and diffusion: discrete modes, orders, budgets, bits, limits and divergence.

mod bits;
mod budgets;
mod modes;
mod scene;
mod stability;

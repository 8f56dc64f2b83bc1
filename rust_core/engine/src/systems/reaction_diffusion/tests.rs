//! Reactions and diffusion: discrete modes, orders, symmetries, budgets, bits, limits and divergence.

mod bits;
mod budgets;
mod modes;
mod scene;
mod stability;

//! Forces, one file each. To add one: write its file, and add its line to [`registered`].

use std::ops::Range;

use crate::error::Result;
use crate::math::Vector;
use crate::matter::{Columns, Power, Properties, Span};
use crate::stability::Bound;

/// The matter at the moment when the forces are asked for.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a, V: Vector> {
    /// Positions relative to the origin [m].
    pub position: &'a Columns<V>,
    /// Velocities [m/s].
    pub velocity: &'a Columns<V>,
    /// Mass and everything else that does not change.
    pub properties: &'a Properties<V>,
    /// The time [s].
    pub time: f64,
}

/// What the forces do to one block.
#[derive(Debug)]
pub struct Rates<'a, V: Vector> {
    /// The force on every particle of the block [N], padding included. Each force adds to it.
    pub force: Span<'a, V>,
    /// The power that passes through each channel [W]. Each force adds to it.
    pub power: &'a mut Power,
}

/// How far a force reaches from the particle that it acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// It depends on the particle alone.
    Pointwise,
    /// It depends on given partners.
    Network,
    /// It depends on everything: asked for all at once, in [`Force::prepare`].
    Whole,
}

/// How a force depends on velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum VelocityDependence {
    /// Not at all.
    None,
    /// It takes energy out.
    Dissipative,
}

/// A law that accelerates matter, and its share of the energy budget.
pub trait Force<V: Vector>: Send + Sync {
    /// Its name in the plan and in the audit: `gravity`.
    fn name(&self) -> &'static str;

    /// How far it reaches.
    fn reach(&self) -> Reach;

    /// How it depends on velocity.
    fn velocity(&self) -> VelocityDependence;

    /// Work that must be done for all particles before any block is asked for.
    fn prepare(&mut self, _at: &Moment<'_, V>) -> Result<()> {
        Ok(())
    }

    /// Adds the force on each particle of `block` and the power that it dissipates or supplies there.
    fn accumulate(&self, block: Range<usize>, at: &Moment<'_, V>, rates: &mut Rates<'_, V>);

    /// The potential energy of the particles of `block` [J]; what two particles share is split between them.
    fn potential(&self, block: Range<usize>, at: &Moment<'_, V>) -> f64;

    /// Adds its stiffness and damping, as they are at this moment, to the bound on the time step.
    fn bound(&self, at: &Moment<'_, V>, bound: &mut Bound);

    /// The memory that it takes [bytes].
    fn bytes(&self) -> usize {
        0
    }
}

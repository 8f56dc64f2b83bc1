//! Uniform gravity: F = m g. Always fused ([`super::linear`]).

use std::ops::Range;

use glam::DVec3;

use super::linear::Fusion;
use super::{About, Declared, Force, ForceKind, Forces, Reach, StateView, Validity};
use crate::error::Result;
use crate::history::History;
use crate::math::Vector;
use crate::matter::Properties;
use crate::scene::{Item, Scene};
use crate::stability::{Horizon, SpectralBound};

/// Uniform acceleration of the movable particles.
#[derive(Debug)]
pub struct Gravity {
    /// Gravitational acceleration g [m/s²].
    acceleration: DVec3,
    /// Whether each particle is affected.
    members: Vec<bool>,
}

const NAME: &str = "Gravity";
const ACCELERATION: &str = "acceleration";

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build =
        |declared: &Declared<'_, V>| -> Result<Forces<V>> { Ok(vec![Box::new(Gravity::new(declared.item, declared.mobile())?)]) };
    ForceKind { name: NAME, reach: Reach::Pointwise, charges: false, build }
}

/// Acceleration of a body by all uniform gravity of a scene [m/s²].
///
/// # Errors
/// If an acceleration is not finite.
#[inline]
pub fn on_body(scene: &Scene, body: usize) -> Result<DVec3> {
    let acting = scene.forces.iter().filter(|item| item.kind == NAME && item.acts_on(body));
    acting.map(|item| item.vector(ACCELERATION)).sum()
}

impl Gravity {
    /// Gravity of an item, on the movable `members`.
    fn new(item: &Item, members: Vec<bool>) -> Result<Self> {
        Ok(Self { acceleration: item.vector(ACCELERATION)?, members })
    }
}

impl History for Gravity {}

impl<V: Vector> Force<V> for Gravity {
    fn about(&self) -> About {
        About::new("gravity", Reach::Pointwise)
    }

    fn fuse(&self, _properties: &Properties<V>, fusion: &mut Fusion) -> bool {
        for (sum, _) in fusion.acceleration.iter_mut().zip(&self.members).filter(|(_, member)| **member) {
            *sum += self.acceleration;
        }
        true
    }

    /// Potential energy U = −m g·x [J].
    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        let properties = at.properties;
        let members = block.filter(|&index| self.members[index]);
        members
            .map(|index| -properties.mass[index] * self.acceleration.dot(properties.origin + at.position.get(index).widen()))
            .sum()
    }

    fn bound(&self, _at: &StateView<'_, V>, _bound: &mut SpectralBound) -> Result<()> {
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Always
    }
}

//! Scenes with one force alone, whose steps run in registers.

use glam::DVec3;

use super::super::methods::Angle;
use super::Dynamics;
use crate::catalog::Space;
use crate::forces::{ElectromagneticLaw, InverseSquare, ReadyField};

/// Electric and magnetic field of a scene without other forces.
#[derive(Debug, Clone, Copy)]
pub struct LoneFields<'a, T> {
    pub electric: ElectromagneticLaw,
    pub magnetic: ElectromagneticLaw,
    /// Charges [C]; 0 for particles outside the fields.
    pub charges: &'a [T],
}

impl<V: Space> Dynamics<V> {
    /// Inverse-square force, if it is the only force.
    pub fn lone_inverse_square(&self) -> Option<InverseSquare<'_, V::Scalar>> {
        match self.forces.as_slice() {
            [force] => force.inverse_square(&self.properties),
            _ => None,
        }
    }

    /// Fields E and B, if they are the only forces, and [`crate::systems::matter::kernels::gyration_steps`] turns velocities in them. The
    /// engine computes the fields itself, and they do not change in time.
    pub fn lone_fields(&self) -> Option<LoneFields<'_, V::Scalar>> {
        if self.angle != Some(Angle::Boris) {
            return None;
        }
        let none = ElectromagneticLaw::Uniform(DVec3::ZERO);
        match self.forces.as_slice() {
            [magnetic] => {
                let ReadyField { law, charges, is_magnetic } = magnetic.ready_field()?;
                is_magnetic.then_some(LoneFields { electric: none, magnetic: law, charges })
            }
            [electric, magnetic] => {
                let (electric, magnetic) = (electric.ready_field()?, magnetic.ready_field()?);
                let together = std::ptr::eq(electric.charges, magnetic.charges);
                (together && !electric.is_magnetic && magnetic.is_magnetic).then_some(LoneFields {
                    electric: electric.law,
                    magnetic: magnetic.law,
                    charges: magnetic.charges,
                })
            }
            _ => None,
        }
    }
}

//! Whole steps of Boris' method in an electric and a magnetic field alone.

use super::components::columns;
use super::gyration::kick;
use crate::catalog::Space;
use crate::forces::{Affine, FieldLaw, Use, times};
use crate::math::Real;
use crate::matter::Blocks;
use crate::simd::{Isa, Kernel, dispatch_wide};
use crate::systems::matter::dynamics::{Dynamics, LoneFields};

/// Block of charges that advances by whole steps once its fields are known.
struct ChargeBlock<'a, 'b, V: Space> {
    /// Charges [C] and inverse masses [1/kg].
    charges: &'a [V::Scalar],
    inverse_mass: &'a [V::Scalar],
    electric: Affine<V::Scalar>,
    block: &'a mut Blocks<'b, V>,
    h: f64,
    number: u64,
}

/// Advances one block by whole steps in electric and magnetic fields alone.
pub fn gyration_steps<V: Space>(
    dynamics: &Dynamics<V>,
    LoneFields { electric, magnetic, charges }: LoneFields<'_, V::Scalar>,
    block: &mut Blocks<'_, V>,
    h: f64,
    number: u64,
) {
    let origin = dynamics.properties.origin;
    let Some(electric) = electric.affine(origin) else { return };
    let (charges, inverse_mass) = (&charges[block.range()], &dynamics.properties.inverse_mass[block.range()]);
    magnetic.with(0.0, origin, ChargeBlock { charges, inverse_mass, electric, block, h, number });
}

impl<V: Space> Use<V::Scalar> for ChargeBlock<'_, '_, V> {
    fn with(self, magnetic: impl FieldLaw<V::Scalar>) {
        dispatch_wide(GyrationSteps { part: self, magnetic });
    }
}

/// Whole steps of a block in a magnetic field.
struct GyrationSteps<P, B> {
    part: P,
    magnetic: B,
}

impl<V: Space, B: FieldLaw<V::Scalar>> Kernel for GyrationSteps<ChargeBlock<'_, '_, V>, B> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        // Widest vector, as in `point_force_steps`.
        if size_of::<V::Scalar>() == size_of::<f32>() { self.steps::<16>() } else { self.steps::<8>() }
    }
}

impl<V: Space, B: FieldLaw<V::Scalar>> GyrationSteps<ChargeBlock<'_, '_, V>, B> {
    /// Takes all steps, `W` charges at a time.
    #[inline(always)]
    fn steps<const W: usize>(self) {
        let Self { part: ChargeBlock { charges, inverse_mass, electric, block, h, number }, magnetic } = self;
        let half = V::Scalar::from_f64(0.5 * h);
        let (charges, inverse_mass) = (charges.as_chunks::<W>().0, inverse_mass.as_chunks::<W>().0);
        let zero = [V::Scalar::ZERO; W];
        let lanes = columns::<V, W>(&mut block.position, &mut block.velocity, &mut block.registers, &mut block.residual);
        let [first, second, third] = lanes;
        for _ in 0..number {
            for (group, (charges, inverse_mass)) in charges.iter().zip(inverse_mass).enumerate() {
                let (charges, inverse_mass) = (*charges, *inverse_mass);
                let (mut x, mut y, mut z) = (first.x[group], second.x[group], zero);
                let (mut u, mut v, mut w) = (first.v[group], second.v[group], zero);
                if V::DIMENSION > 2 {
                    (z, w) = (third.x[group], third.v[group]);
                }
                for lane in 0..W {
                    let rate = half * (charges[lane] * inverse_mass[lane]);
                    let velocity = [u[lane], v[lane], w[lane]];
                    let middle = [x[lane] + half * u[lane], y[lane] + half * v[lane], z[lane] + half * w[lane]];
                    let (mut field, mut turn) = (electric.at(middle), magnetic.at(middle));
                    if V::DIMENSION == 2 {
                        field[2] = V::Scalar::ZERO;
                        turn = [V::Scalar::ZERO, V::Scalar::ZERO, turn[2]];
                    }
                    let change = kick(velocity, times(rate, field), times(rate, turn));
                    let kicked = [velocity[0] + change[0], velocity[1] + change[1], velocity[2] + change[2]];
                    [u[lane], v[lane], w[lane]] = kicked;
                    x[lane] = middle[0] + half * kicked[0];
                    y[lane] = middle[1] + half * kicked[1];
                    z[lane] = middle[2] + half * kicked[2];
                }
                (first.x[group], second.x[group]) = (x, y);
                (first.v[group], second.v[group]) = (u, v);
                if V::DIMENSION > 2 {
                    (third.x[group], third.v[group]) = (z, w);
                }
            }
        }
    }
}

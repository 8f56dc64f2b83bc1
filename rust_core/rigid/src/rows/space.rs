//! Vectors of rows: in the plane without the components that vanish there.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use glam::{DMat3, DVec2, DVec3};
use physcore_base::simd::{Number, Pack};

use super::lanes::{Laned, LanesOf, Loaded, WidePlane, WideSpace};
use super::{BodyVelocities, BodyVelocity, ContactRow};
use crate::mover::perpendicular;

/// Element of a vector space: vector of a row, or the number that remains of one in the plane.
pub trait Linear:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self> + Mul<Self::Number, Output = Self>
{
    /// Factor: a number, or a register of numbers.
    type Number: Number;

    /// Scalar product.
    fn dot(self, other: Self) -> Self::Number;
    /// Vector of the same direction, not longer than `most`.
    #[must_use]
    fn limited(self, most: Self::Number) -> Self;
    /// Selects one vector in the lanes of a mask, another elsewhere.
    fn select(mask: <Self::Number as Number>::Mask, one: Self, other: Self) -> Self;
}

/// Vector of one row.
pub trait RowVector: Linear<Number = f64> + Laned + Debug + Default + PartialEq + AddAssign {}

macro_rules! row_vector {
    ($vector:ident, |$one:ident, $other:ident| $dot:expr) => {
        impl Linear for $vector {
            type Number = f64;

            #[inline(always)]
            fn dot(self, other: Self) -> f64 {
                let ($one, $other) = (self, other);
                $dot
            }

            #[inline(always)]
            fn limited(self, most: f64) -> Self {
                let squared = Linear::dot(self, self);
                if squared > most * most { self / squared.sqrt() * most } else { self }
            }

            #[inline(always)]
            fn select(mask: bool, one: Self, other: Self) -> Self {
                if mask { one } else { other }
            }
        }

        impl RowVector for $vector {}
    };
}

row_vector!(f64, |one, other| one * other);
row_vector!(DVec2, |one, other| one.dot(other));
row_vector!(DVec3, |one, other| one.dot(other));

/// Vectors of rows with their products.
pub trait RowAlgebra: Copy {
    /// Number, or register of numbers.
    type Number: Number;
    /// Velocity, arm or impulse.
    type Vector: Linear<Number = Self::Number>;
    /// Angular velocity or moment.
    type Turn: Linear<Number = Self::Number>;
    /// Inverse of an inertia tensor.
    type Inverse: Copy;

    /// Moment of an impulse at an arm.
    fn moment(arm: Self::Vector, impulse: Self::Vector) -> Self::Turn;
    /// Velocity of the end of an arm.
    fn swept(turn: Self::Turn, arm: Self::Vector) -> Self::Vector;
    /// Change of the angular velocity by a moment.
    fn turned(inverse: &Self::Inverse, moment: Self::Turn) -> Self::Turn;
    /// Part of a turn about a normal.
    fn about(normal: Self::Vector, turn: Self::Turn) -> Self::Turn;
    /// Vector across a normal that is not longer than `most`.
    fn held(normal: Self::Vector, vector: Self::Vector, most: Self::Number) -> Self::Vector;
    /// Largest response of two bodies to a unit impulse across the normal of a row.
    fn across(row: &ContactRow<Self>, bodies: [&BodyVelocity<Self>; 2]) -> Self::Number;
    /// Sums of inverse moments of inertia: about a normal, and a bound across it.
    fn inverse_moments(normal: Self::Vector, inverses: [&Self::Inverse; 2]) -> [Self::Number; 2];
}

/// Plane or space.
pub trait RowSpace:
    RowAlgebra<Number = f64, Vector: RowVector, Turn: RowVector, Inverse: Laned + Debug + Default> + Debug + Default
{
    /// Vectors of several rows in registers.
    type Wide<P: Pack<Scalar = f64>>: RowAlgebra<
            Number = P,
            Vector: Loaded<LanesOf<Self::Vector>>,
            Turn: Loaded<LanesOf<Self::Turn>>,
            Inverse: Loaded<LanesOf<Self::Inverse>>,
        >;

    /// Vector of the space.
    fn vector(vector: DVec3) -> Self::Vector;
    /// Vector as one in space.
    fn widen(vector: Self::Vector) -> DVec3;
    /// Angular velocity or moment of the space.
    fn turn(turn: DVec3) -> Self::Turn;
    /// Angular velocity or moment as one in space.
    fn widen_turn(turn: Self::Turn) -> DVec3;
    /// Inverse of an inertia tensor.
    fn inverse(inverse: &DMat3) -> Self::Inverse;

    /// Velocities in space; None in the plane. Joints act on them.
    fn in_space(v: &mut BodyVelocities<Self>) -> Option<&mut BodyVelocities<InSpace>>;
}

/// The plane z = 0.
#[derive(Debug, Clone, Copy, Default)]
pub struct InPlane;

/// Space.
#[derive(Debug, Clone, Copy, Default)]
pub struct InSpace;

impl RowAlgebra for InPlane {
    type Number = f64;
    type Vector = DVec2;
    type Turn = f64;
    type Inverse = f64;

    #[inline(always)]
    fn moment(arm: DVec2, impulse: DVec2) -> f64 {
        arm.perp_dot(impulse)
    }

    #[inline(always)]
    fn swept(turn: f64, arm: DVec2) -> DVec2 {
        DVec2::new(-turn * arm.y, turn * arm.x)
    }

    #[inline(always)]
    fn turned(inverse: &f64, moment: f64) -> f64 {
        inverse * moment
    }

    #[inline(always)]
    fn about(_normal: DVec2, _turn: f64) -> f64 {
        0.0
    }

    #[inline(always)]
    fn held(normal: DVec2, vector: DVec2, most: f64) -> DVec2 {
        let tangent = normal.perp();
        tangent * Number::max(Number::min(tangent.dot(vector), most), -most)
    }

    #[inline(always)]
    fn across(row: &ContactRow<Self>, bodies: [&BodyVelocity<Self>; 2]) -> f64 {
        let tangent = row.normal.perp();
        tangent.dot(row.response(tangent, bodies))
    }

    #[inline(always)]
    fn inverse_moments(_normal: DVec2, [one, other]: [&f64; 2]) -> [f64; 2] {
        [0.0, one + other]
    }
}

impl RowSpace for InPlane {
    type Wide<P: Pack<Scalar = f64>> = WidePlane<P>;

    #[inline(always)]
    fn vector(vector: DVec3) -> DVec2 {
        vector.truncate()
    }

    #[inline(always)]
    fn widen(vector: DVec2) -> DVec3 {
        vector.extend(0.0)
    }

    #[inline(always)]
    fn turn(turn: DVec3) -> f64 {
        turn.z
    }

    #[inline(always)]
    fn widen_turn(turn: f64) -> DVec3 {
        DVec3::new(0.0, 0.0, turn)
    }

    #[inline(always)]
    fn inverse(inverse: &DMat3) -> f64 {
        inverse.z_axis.z
    }

    #[inline(always)]
    fn in_space(_v: &mut BodyVelocities<Self>) -> Option<&mut BodyVelocities<InSpace>> {
        None
    }
}

impl RowAlgebra for InSpace {
    type Number = f64;
    type Vector = DVec3;
    type Turn = DVec3;
    type Inverse = DMat3;

    #[inline(always)]
    fn moment(arm: DVec3, impulse: DVec3) -> DVec3 {
        arm.cross(impulse)
    }

    #[inline(always)]
    fn swept(turn: DVec3, arm: DVec3) -> DVec3 {
        turn.cross(arm)
    }

    #[inline(always)]
    fn turned(inverse: &DMat3, moment: DVec3) -> DVec3 {
        *inverse * moment
    }

    #[inline(always)]
    fn about(normal: DVec3, turn: DVec3) -> DVec3 {
        normal.dot(turn) * normal
    }

    #[inline(always)]
    fn held(_normal: DVec3, vector: DVec3, most: f64) -> DVec3 {
        vector.limited(most)
    }

    fn across(row: &ContactRow<Self>, bodies: [&BodyVelocity<Self>; 2]) -> f64 {
        largest(perpendicular(row.normal), row, bodies)
    }

    fn inverse_moments(normal: DVec3, [one, other]: [&DMat3; 2]) -> [f64; 2] {
        let sum = *one + *other;
        let about = normal.dot(sum * normal);
        [about, sum.x_axis.x + sum.y_axis.y + sum.z_axis.z - about]
    }
}

/// Largest response of two bodies to a unit impulse in the plane of two unit vectors, which is an eigenvalue.
#[inline(always)]
pub(super) fn largest<S: RowAlgebra>(
    [first, second]: [S::Vector; 2],
    row: &ContactRow<S>,
    bodies: [&BodyVelocity<S>; 2],
) -> S::Number {
    let [a, b] = [row.response(first, bodies), row.response(second, bodies)];
    let [xx, yy, xy] = [first.dot(a), second.dot(b), first.dot(b)];
    let [half, quarter] = [S::Number::constant(0.5), S::Number::constant(0.25)];
    half * (xx + yy) + (quarter * (xx - yy) * (xx - yy) + xy * xy).sqrt()
}

impl RowSpace for InSpace {
    type Wide<P: Pack<Scalar = f64>> = WideSpace<P>;

    #[inline(always)]
    fn vector(vector: DVec3) -> DVec3 {
        vector
    }

    #[inline(always)]
    fn widen(vector: DVec3) -> DVec3 {
        vector
    }

    #[inline(always)]
    fn turn(turn: DVec3) -> DVec3 {
        turn
    }

    #[inline(always)]
    fn widen_turn(turn: DVec3) -> DVec3 {
        turn
    }

    #[inline(always)]
    fn inverse(inverse: &DMat3) -> DMat3 {
        *inverse
    }

    #[inline(always)]
    fn in_space(v: &mut BodyVelocities<Self>) -> Option<&mut BodyVelocities<InSpace>> {
        Some(v)
    }
}

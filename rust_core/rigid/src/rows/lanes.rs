//! Vectors of several rows side by side: in arrays, and in registers.

use std::fmt::{self, Debug, Formatter};
use std::ops::{Add, Mul, Neg, Sub};

use glam::{DMat3, DVec2, DVec3};
use physcore_base::simd::{Number, Pack};

use super::space::{Linear, RowAlgebra, RowSpace, largest};
use super::{BodyVelocity, ContactImpulse, ContactRow};

/// Number of rows side by side; registers hold a part of them.
pub const SIDE: usize = 8;

/// Value that is kept side by side with others, component by component.
pub trait Laned: Copy {
    /// Components of [`SIDE`] values.
    type Lanes: Copy + Debug + Default;

    /// Value of a lane.
    fn read(lanes: &Self::Lanes, lane: usize) -> Self;
    /// Writes the value to a lane.
    fn write(self, lanes: &mut Self::Lanes, lane: usize);
}

/// Components of values side by side.
pub type LanesOf<T> = <T as Laned>::Lanes;

impl Laned for f64 {
    type Lanes = [[f64; SIDE]; 1];

    #[inline(always)]
    fn read(lanes: &Self::Lanes, lane: usize) -> Self {
        lanes[0][lane]
    }

    #[inline(always)]
    fn write(self, lanes: &mut Self::Lanes, lane: usize) {
        lanes[0][lane] = self;
    }
}

impl Laned for DVec2 {
    type Lanes = [[f64; SIDE]; 2];

    #[inline(always)]
    fn read(lanes: &Self::Lanes, lane: usize) -> Self {
        Self::new(lanes[0][lane], lanes[1][lane])
    }

    #[inline(always)]
    fn write(self, lanes: &mut Self::Lanes, lane: usize) {
        (lanes[0][lane], lanes[1][lane]) = (self.x, self.y);
    }
}

impl Laned for DVec3 {
    type Lanes = [[f64; SIDE]; 3];

    #[inline(always)]
    fn read(lanes: &Self::Lanes, lane: usize) -> Self {
        Self::new(lanes[0][lane], lanes[1][lane], lanes[2][lane])
    }

    #[inline(always)]
    fn write(self, lanes: &mut Self::Lanes, lane: usize) {
        (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = (self.x, self.y, self.z);
    }
}

impl Laned for DMat3 {
    type Lanes = [[f64; SIDE]; 9];

    #[inline(always)]
    fn read(lanes: &Self::Lanes, lane: usize) -> Self {
        Self::from_cols_array(&std::array::from_fn(|component| lanes[component][lane]))
    }

    #[inline(always)]
    fn write(self, lanes: &mut Self::Lanes, lane: usize) {
        let columns = self.to_cols_array();
        for component in 0..9 {
            lanes[component][lane] = columns[component];
        }
    }
}

/// Value in registers, which takes a part of the lanes.
pub trait Loaded<L>: Copy {
    /// Loads the lanes from `first` on.
    fn load(lanes: &L, first: usize) -> Self;
    /// Writes the lanes from `first` on.
    fn store(self, lanes: &mut L, first: usize);
}

/// Vector in registers.
#[derive(Clone, Copy)]
pub struct Wide<P, const N: usize>(pub [P; N]);

impl<P, const N: usize> Debug for Wide<P, N> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Wide").finish_non_exhaustive()
    }
}

impl<P: Pack<Scalar = f64>, const N: usize> Loaded<[[f64; SIDE]; N]> for Wide<P, N> {
    #[inline(always)]
    fn load(lanes: &[[f64; SIDE]; N], first: usize) -> Self {
        let mut components = [P::constant(0.0); N];
        for component in 0..N {
            components[component] = P::load(&lanes[component][first..]);
        }
        Self(components)
    }

    #[inline(always)]
    fn store(self, lanes: &mut [[f64; SIDE]; N], first: usize) {
        for component in 0..N {
            self.0[component].store(&mut lanes[component][first..]);
        }
    }
}

macro_rules! wide_operator {
    ($trait:ident, $name:ident) => {
        impl<P: Number, const N: usize> $trait for Wide<P, N> {
            type Output = Self;

            #[inline(always)]
            fn $name(mut self, other: Self) -> Self {
                for component in 0..N {
                    self.0[component] = self.0[component].$name(other.0[component]);
                }
                self
            }
        }
    };
}

wide_operator!(Add, add);
wide_operator!(Sub, sub);

impl<P: Number, const N: usize> Mul<P> for Wide<P, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factor: P) -> Self {
        for component in 0..N {
            self.0[component] = self.0[component] * factor;
        }
        self
    }
}

impl<P: Number, const N: usize> Neg for Wide<P, N> {
    type Output = Self;

    #[inline(always)]
    fn neg(mut self) -> Self {
        for component in 0..N {
            self.0[component] = P::constant(0.0) - self.0[component];
        }
        self
    }
}

impl<P: Number, const N: usize> Linear for Wide<P, N> {
    type Number = P;

    #[inline(always)]
    fn dot(self, other: Self) -> P {
        let mut sum = self.0[0] * other.0[0];
        for component in 1..N {
            sum += self.0[component] * other.0[component];
        }
        sum
    }

    #[inline(always)]
    fn limited(self, most: P) -> Self {
        let squared = self.dot(self);
        self * P::select((most * most).less(squared), most / squared.sqrt(), P::constant(1.0))
    }

    #[inline(always)]
    fn select(mask: P::Mask, one: Self, mut other: Self) -> Self {
        for component in 0..N {
            other.0[component] = P::select(mask, one.0[component], other.0[component]);
        }
        other
    }
}

/// The plane z = 0, in registers.
#[derive(Debug, Clone, Copy)]
pub struct WidePlane<P>(P);

impl<P: Number> RowAlgebra for WidePlane<P> {
    type Number = P;
    type Vector = Wide<P, 2>;
    type Turn = Wide<P, 1>;
    type Inverse = Wide<P, 1>;

    #[inline(always)]
    fn moment(Wide([x, y]): Wide<P, 2>, Wide([u, v]): Wide<P, 2>) -> Wide<P, 1> {
        Wide([x * v - y * u])
    }

    #[inline(always)]
    fn swept(Wide([turn]): Wide<P, 1>, Wide([x, y]): Wide<P, 2>) -> Wide<P, 2> {
        Wide([P::constant(0.0) - turn * y, turn * x])
    }

    #[inline(always)]
    fn turned(Wide([inverse]): &Wide<P, 1>, moment: Wide<P, 1>) -> Wide<P, 1> {
        moment * *inverse
    }

    #[inline(always)]
    fn about(_normal: Wide<P, 2>, _turn: Wide<P, 1>) -> Wide<P, 1> {
        Wide([P::constant(0.0)])
    }

    #[inline(always)]
    fn held(Wide([x, y]): Wide<P, 2>, vector: Wide<P, 2>, most: P) -> Wide<P, 2> {
        let tangent = Wide([P::constant(0.0) - y, x]);
        tangent * tangent.dot(vector).min(most).max(P::constant(0.0) - most)
    }

    #[inline(always)]
    fn across(row: &ContactRow<Self>, bodies: [&BodyVelocity<Self>; 2]) -> P {
        let Wide([x, y]) = row.normal;
        let tangent = Wide([P::constant(0.0) - y, x]);
        tangent.dot(row.response(tangent, bodies))
    }

    #[inline(always)]
    fn inverse_moments(_normal: Wide<P, 2>, [one, other]: [&Wide<P, 1>; 2]) -> [P; 2] {
        [P::constant(0.0), one.0[0] + other.0[0]]
    }
}

/// Space, in registers.
#[derive(Debug, Clone, Copy)]
pub struct WideSpace<P>(P);

impl<P: Number> RowAlgebra for WideSpace<P> {
    type Number = P;
    type Vector = Wide<P, 3>;
    type Turn = Wide<P, 3>;
    type Inverse = Wide<P, 9>;

    #[inline(always)]
    fn moment(Wide([x, y, z]): Wide<P, 3>, Wide([u, v, w]): Wide<P, 3>) -> Wide<P, 3> {
        Wide([y * w - v * z, z * u - w * x, x * v - u * y])
    }

    #[inline(always)]
    fn swept(turn: Wide<P, 3>, arm: Wide<P, 3>) -> Wide<P, 3> {
        Self::moment(turn, arm)
    }

    #[inline(always)]
    fn turned(Wide([a, b, c, d, e, f, g, h, i]): &Wide<P, 9>, Wide([x, y, z]): Wide<P, 3>) -> Wide<P, 3> {
        Wide([*a * x + *d * y + *g * z, *b * x + *e * y + *h * z, *c * x + *f * y + *i * z])
    }

    #[inline(always)]
    fn about(normal: Wide<P, 3>, turn: Wide<P, 3>) -> Wide<P, 3> {
        normal * normal.dot(turn)
    }

    #[inline(always)]
    fn held(_normal: Wide<P, 3>, vector: Wide<P, 3>, most: P) -> Wide<P, 3> {
        vector.limited(most)
    }

    #[inline(always)]
    fn across(row: &ContactRow<Self>, bodies: [&BodyVelocity<Self>; 2]) -> P {
        let (zero, one, Wide([x, y, z])) = (P::constant(0.0), P::constant(1.0), row.normal);
        // Across the z axis, or for a normal near it, across the x axis.
        let away = Wide::select(z.max(zero - z).less(P::constant(0.9)), Wide([y, zero - x, zero]), Wide([zero, z, zero - y]));
        let first = away * (one / away.dot(away).sqrt());
        largest([first, Self::moment(row.normal, first)], row, bodies)
    }

    #[inline(always)]
    fn inverse_moments(normal: Wide<P, 3>, [one, other]: [&Wide<P, 9>; 2]) -> [P; 2] {
        let sum = *one + *other;
        let about = normal.dot(Self::turned(&sum, normal));
        [about, sum.0[0] + sum.0[4] + sum.0[8] - about]
    }
}

/// Impulses side by side.
#[derive(Debug, Clone, Copy, Default)]
pub struct ImpulseLanes<S: RowSpace> {
    pub normal: [f64; SIDE],
    tangential: LanesOf<S::Vector>,
    turning: LanesOf<S::Turn>,
}

impl<S: RowSpace> ImpulseLanes<S> {
    /// Impulses of a lane.
    pub fn read(&self, lane: usize) -> ContactImpulse<S> {
        ContactImpulse {
            normal: self.normal[lane],
            tangential: S::Vector::read(&self.tangential, lane),
            turning: S::Turn::read(&self.turning, lane),
        }
    }

    /// Writes the impulses of a lane.
    pub fn write(&mut self, impulse: &ContactImpulse<S>, lane: usize) {
        self.normal[lane] = impulse.normal;
        impulse.tangential.write(&mut self.tangential, lane);
        impulse.turning.write(&mut self.turning, lane);
    }

    /// Loads the lanes from `first` on.
    #[inline(always)]
    pub fn load<P: Pack<Scalar = f64>>(&self, first: usize) -> ContactImpulse<S::Wide<P>> {
        ContactImpulse {
            normal: P::load(&self.normal[first..]),
            tangential: Loaded::load(&self.tangential, first),
            turning: Loaded::load(&self.turning, first),
        }
    }

    /// Writes the lanes from `first` on.
    #[inline(always)]
    pub fn store<P: Pack<Scalar = f64>>(&mut self, impulse: &ContactImpulse<S::Wide<P>>, first: usize) {
        impulse.normal.store(&mut self.normal[first..]);
        impulse.tangential.store(&mut self.tangential, first);
        impulse.turning.store(&mut self.turning, first);
    }
}

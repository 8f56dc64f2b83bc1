//! Clearance test, vectorized and in the precision of the state. Most particles pass it at every step. The path lies in the
//! convex hull of its Bernstein control points. If the control points are clear of every wall, so is the path.

use glam::DVec3;

use super::{Before, Contacts};
use crate::boundaries::Wall;
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, Properties};
use crate::simd::{Isa, Kernel, LANES, Lanes};

/// A wall, or two parallel walls, in the form of the test. `set` is the index of the column of radii.
#[derive(Debug, Clone)]
pub(super) enum Test<T> {
    /// lower ≤ x ≤ upper along one axis.
    Slab { set: usize, axis: usize, lower: T, upper: T },
    /// n·x ≥ offset.
    Plane { set: usize, normal: [T; AXES], offset: T },
    /// |x − c| ≤ R or ≥ R.
    Sphere { set: usize, center: [T; AXES], radius: T, inside: bool },
    /// n·x ≥ offset for at least one of these planes.
    Solid { set: usize, planes: Vec<([T; AXES], T)> },
}

/// Maximum number of facets of a solid that are tested one by one. A solid with more facets, or none, is tested by its
/// bounding ball.
const FACETS: usize = 16;

impl<T: Real> Test<T> {
    /// Tests of the walls of a boundary, for particles of at most the radius `largest`. Each wall is offset inward by a few
    /// units of rounding. Particles within this margin are tested in double precision.
    pub fn of(walls: &[Wall], set: usize, largest: f64) -> Vec<Self> {
        let mut tests: Vec<Self> = Vec::new();
        for wall in walls {
            let margin = 8.0 * T::EPSILON * (wall.extent() + largest);
            match *wall {
                Wall::Plane { normal, offset } => {
                    let axis = (0..AXES).find(|&axis| normal[axis].abs() == 1.0);
                    let Some(axis) = axis else {
                        let normal = normal.to_array().map(T::from_f64);
                        tests.push(Self::Plane { set, normal, offset: T::from_f64(offset + margin) });
                        continue;
                    };
                    let side = normal[axis] * (offset + margin);
                    let (below, above) = if normal[axis] > 0.0 { (side, f64::INFINITY) } else { (f64::NEG_INFINITY, side) };
                    let (below, above) = (T::from_f64(below), T::from_f64(above));
                    // The two walls of a box along one axis share a test.
                    if let Some(Self::Slab { axis: other, lower, upper, .. }) = tests.last_mut()
                        && *other == axis
                    {
                        *lower = larger(*lower, below);
                        *upper = smaller(*upper, above);
                    } else {
                        tests.push(Self::Slab { set, axis, lower: below, upper: above });
                    }
                }
                Wall::Solid(ref solid) => {
                    let planes =
                        solid.planes().map(|(normal, offset)| (normal.to_array().map(T::from_f64), T::from_f64(offset + margin)));
                    let planes: Vec<_> = planes.collect();
                    let (center, radius) = solid.ball();
                    tests.push(if (1..=FACETS).contains(&planes.len()) {
                        Self::Solid { set, planes }
                    } else {
                        let center = center.to_array().map(T::from_f64);
                        Self::Sphere { set, center, radius: T::from_f64(radius + margin), inside: false }
                    });
                }
                // A particle above the highest point of the ground is clear of it.
                Wall::Terrain(ref terrain) => {
                    let (up, highest) = terrain.top();
                    let (axis, lower) = (if up == DVec3::Z { 2 } else { 1 }, T::from_f64(highest + margin));
                    tests.push(Self::Slab { set, axis, lower, upper: T::from_f64(f64::INFINITY) });
                }
                Wall::Sphere { center, radius, inside } => {
                    let radius = T::from_f64(if inside { radius - margin } else { radius + margin });
                    tests.push(Self::Sphere { set, center: center.to_array().map(T::from_f64), radius, inside });
                }
            }
        }
        tests
    }
}

/// Contacts of one block after one step.
pub(super) struct ContactSweep<'a, 'b, 'c, V: Vector> {
    pub contacts: &'a Contacts<V>,
    pub before: &'a Before<'b, V>,
    pub block: &'a mut Blocks<'c, V>,
    pub properties: &'a Properties<V>,
    pub h: f64,
}

/// Three Bernstein control points of a group's paths along one axis.
type ControlPoints<T> = [Lanes<T>; 3];

impl<V: Vector> Kernel for ContactSweep<'_, '_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let contacts = self.contacts;
        for group in 0..self.block.position.len() / LANES {
            let base = group * LANES;
            let mut clear = [V::Scalar::ONE; LANES];
            for test in &contacts.tests {
                self.apply(test, base, &mut clear);
            }
            let mut touched = false;
            for value in clear {
                touched |= value <= V::Scalar::ZERO;
            }
            if touched {
                for (lane, value) in clear.into_iter().enumerate() {
                    if value <= V::Scalar::ZERO {
                        contacts.trajectory(self.before, self.block, self.properties, self.h, base + lane);
                    }
                }
            }
        }
    }
}

impl<V: Vector> ContactSweep<'_, '_, '_, V> {
    /// Control points along one axis: P₀ = x₀, P₁ = x₀ + h v/2 = (x₀ + x₁)/2 − h (v₁ − v₀)/4, P₂ = x₁.
    #[inline(always)]
    fn control(&self, base: usize, axis: usize) -> ControlPoints<V::Scalar> {
        let (half, quarter) = (V::Scalar::from_f64(0.5), V::Scalar::from_f64(0.25 * self.h));
        let first = lanes(&self.before.position[axis][base..]);
        let last = lanes(&self.block.position.axes[axis][base..]);
        let (before, after) = (lanes(&self.before.velocity[axis][base..]), lanes(&self.block.velocity.axes[axis][base..]));
        let mut middle = [V::Scalar::ZERO; LANES];
        for lane in 0..LANES {
            middle[lane] = half * (first[lane] + last[lane]) - quarter * (after[lane] - before[lane]);
        }
        [first, middle, last]
    }

    /// Lowers each lane's clearance to 0 or below unless its clearance from a wall is certain. Only the sign is meaningful. A
    /// radius of −∞ is always clear.
    #[inline(always)]
    fn apply(&self, test: &Test<V::Scalar>, base: usize, clear: &mut Lanes<V::Scalar>) {
        let reach = |set: usize| lanes(&self.contacts.reach[set][self.block.start + base..]);
        match test {
            Test::Slab { set, axis, lower, upper } => {
                let radius = reach(*set);
                let [first, middle, last] = self.control(base, *axis);
                for lane in 0..LANES {
                    let lowest = smaller(smaller(first[lane], middle[lane]), last[lane]);
                    let highest = larger(larger(first[lane], middle[lane]), last[lane]);
                    let gap = smaller(lowest - *lower, *upper - highest) - radius[lane];
                    clear[lane] = smaller(gap, clear[lane]);
                }
            }
            Test::Plane { set, normal, offset } => {
                let (radius, lowest) = (reach(*set), self.lowest(base, normal));
                for lane in 0..LANES {
                    clear[lane] = smaller(lowest[lane] - *offset - radius[lane], clear[lane]);
                }
            }
            Test::Solid { set, planes } => {
                let radius = reach(*set);
                let mut gap = [V::Scalar::from_f64(f64::NEG_INFINITY); LANES];
                for (normal, offset) in planes {
                    let lowest = self.lowest(base, normal);
                    for lane in 0..LANES {
                        gap[lane] = larger(lowest[lane] - *offset - radius[lane], gap[lane]);
                    }
                }
                for lane in 0..LANES {
                    clear[lane] = smaller(gap[lane], clear[lane]);
                }
            }
            Test::Sphere { set, center, radius, inside } => {
                let reach = reach(*set);
                let (lowest, highest) = self.squares(base, center);
                for lane in 0..LANES {
                    let gap = if *inside {
                        let room = *radius - reach[lane];
                        room * room - highest[lane]
                    } else {
                        // |s| s instead of s², so that a radius of −∞ counts as clear.
                        let size = *radius + reach[lane];
                        lowest[lane] - size * larger(size, -size)
                    };
                    clear[lane] = smaller(gap, clear[lane]);
                }
            }
        }
    }

    /// Smallest Bernstein coefficient of n·x along a group's paths.
    #[inline(always)]
    fn lowest(&self, base: usize, normal: &[V::Scalar; AXES]) -> Lanes<V::Scalar> {
        let mut height = [[V::Scalar::ZERO; LANES]; 3];
        for (axis, &slope) in normal.iter().enumerate().take(V::DIMENSION) {
            for (height, control) in height.iter_mut().zip(self.control(base, axis)) {
                for lane in 0..LANES {
                    height[lane] += slope * control[lane];
                }
            }
        }
        let [first, middle, last] = &height;
        std::array::from_fn(|lane| smaller(smaller(first[lane], middle[lane]), last[lane]))
    }

    /// Smallest and largest Bernstein coefficient of |x − c|² along a group's paths.
    #[inline(always)]
    fn squares(&self, base: usize, center: &[V::Scalar; AXES]) -> (Lanes<V::Scalar>, Lanes<V::Scalar>) {
        let mut products = [[V::Scalar::ZERO; LANES]; 6];
        for (axis, &center) in center.iter().enumerate().take(V::DIMENSION) {
            let control = self.control(base, axis);
            for lane in 0..LANES {
                let [p, q, r] = [0, 1, 2].map(|point| control[point][lane] - center);
                for (sum, product) in products.iter_mut().zip([p * p, p * q, q * q, p * r, q * r, r * r]) {
                    sum[lane] += product;
                }
            }
        }
        let third = V::Scalar::from_f64(1.0 / 3.0);
        let [pp, pq, qq, pr, qr, rr] = &products;
        let (mut lowest, mut highest) = ([V::Scalar::ZERO; LANES], [V::Scalar::ZERO; LANES]);
        for lane in 0..LANES {
            let middle = (qq[lane] + qq[lane] + pr[lane]) * third;
            lowest[lane] = smaller(smaller(smaller(pp[lane], pq[lane]), smaller(middle, qr[lane])), rr[lane]);
            highest[lane] = larger(larger(larger(pp[lane], pq[lane]), larger(middle, qr[lane])), rr[lane]);
        }
        (lowest, highest)
    }
}

#[inline(always)]
fn lanes<T: Real>(slice: &[T]) -> Lanes<T> {
    let (groups, _) = slice.as_chunks::<LANES>();
    groups[0]
}

#[inline(always)]
fn smaller<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger<T: Real>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

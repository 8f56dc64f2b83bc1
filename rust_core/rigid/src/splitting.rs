//! Free rotation of rigid bodies, by a splitting of Euler's equations, for one body or for many side by side.
//!
//! With the angular momentum L in the world, its components l = Rᵀ L along the principal axes and a reference axis r,
//!
//!     H = |L|²/2Iᵣ + Σₖ cₖ lₖ²/2,   cₖ = 1/Iₖ − 1/Iᵣ.
//!
//! The first part turns the body about L, and commutes with all others. The other two turn it about two of its axes. Their
//! symmetric composition keeps L to rounding, is symplectic, reversible and of order 2, and exact for two equal moments. The
//! reference axis is the one for which the product of both c is least in size. Source: F. Fassò, J. Comput. Phys. 189, 527 (2003).
//!
//! Axes are renamed in cyclic order, in the world and in the body, so that the reference axis is the first here.

use physcore_base::simd::LANES;

/// Quaternion (w, x, y, z).
pub(crate) type Quaternion = [f64; 4];
type Components = [f64; 3];

/// Largest angle for which the series of [`series`] are exact to rounding, squared [rad²].
const SMALL: f64 = 0.25;

/// Body that turns freely.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FreeTurn {
    /// Orientation, and rotation from the principal axes to the frame of the body.
    pub orientation: Quaternion,
    pub axes: Quaternion,
    /// Angular momentum [kg·m²/s].
    pub spin: Components,
    /// Inverse moment about the reference axis, and the differences of the others from it, times the duration [s/(kg·m²)].
    pub rates: Components,
}

impl FreeTurn {
    /// Orientation after the turn.
    pub fn turned(&self) -> Quaternion {
        let (orientation, largest) = self.turned_by(series);
        if largest <= SMALL { orientation } else { self.turned_by(library).0 }
    }

    /// Angle of the turn at the present angular velocity.
    #[inline(always)]
    pub fn angle(&self) -> f64 {
        let [reference, first, second] = self.rates;
        let [a, b, c] = along(&product(&self.orientation, &self.axes), &self.spin);
        let [x, y, z] = [reference * a, (reference + first) * b, (reference + second) * c];
        (x * x + y * y + z * z).sqrt()
    }

    /// Orientation after the turn, and the largest square of half an angle in it. `functions` gives sin(x)/x and cos(x) of x².
    #[inline(always)]
    fn turned_by(&self, functions: impl Fn(f64) -> (f64, f64)) -> (Quaternion, f64) {
        let [reference, first, second] = self.rates;
        let [x, y, z] = self.spin.map(|component| 0.5 * reference * component);
        let square = x * x + y * y + z * z;
        let (sinc, cos) = functions(square);
        let mut q = product(&product(&[cos, sinc * x, sinc * y, sinc * z], &self.orientation), &self.axes);
        let [mut a, mut b, mut c] = along(&q, &self.spin);
        let mut largest = square;
        for (about_first, rate) in [(true, 0.5 * first), (false, second), (true, 0.5 * first)] {
            let half = 0.5 * rate * if about_first { b } else { c };
            let square = half * half;
            largest = if square > largest { square } else { largest };
            let (sinc, cos) = functions(square);
            let sin = sinc * half;
            let (twice, full) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
            let [w, x, y, z] = q;
            if about_first {
                q = [cos * w - sin * y, cos * x - sin * z, cos * y + sin * w, cos * z + sin * x];
                [a, c] = [full * a - twice * c, full * c + twice * a];
            } else {
                q = [cos * w - sin * z, cos * x + sin * y, cos * y - sin * x, cos * z + sin * w];
                [a, b] = [full * a + twice * b, full * b - twice * a];
            }
        }
        let [w, x, y, z] = self.axes;
        let q = product(&q, &[w, -x, -y, -z]);
        let scale = 1.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
        (q.map(|component| scale * component), largest)
    }
}

/// Bodies side by side.
#[derive(Debug)]
pub(crate) struct FreeTurns {
    orientation: [[f64; LANES]; 4],
    spin: [[f64; LANES]; 3],
    axes: [[f64; LANES]; 4],
    rates: [[f64; LANES]; 3],
}

impl FreeTurns {
    /// Bodies at rest.
    #[inline(always)]
    pub fn new() -> Self {
        let zeros = [0.0; LANES];
        Self { orientation: [zeros; 4], spin: [zeros; 3], axes: [zeros; 4], rates: [zeros; 3] }
    }

    /// Sets the body of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, body: &FreeTurn) {
        (0..4).for_each(|k| self.axes[k][lane] = body.axes[k]);
        (0..3).for_each(|k| self.rates[k][lane] = body.rates[k]);
        self.set_state(lane, body.orientation, body.spin);
    }

    /// Sets the orientation and the angular momentum [kg·m²/s] of a lane.
    #[inline(always)]
    pub fn set_state(&mut self, lane: usize, orientation: Quaternion, spin: Components) {
        (0..4).for_each(|k| self.orientation[k][lane] = orientation[k]);
        (0..3).for_each(|k| self.spin[k][lane] = spin[k]);
    }

    /// Body of a lane, at an orientation.
    #[inline(always)]
    fn body(&self, lane: usize, orientation: &[[f64; LANES]; 4]) -> FreeTurn {
        FreeTurn {
            orientation: std::array::from_fn(|k| orientation[k][lane]),
            axes: std::array::from_fn(|k| self.axes[k][lane]),
            spin: std::array::from_fn(|k| self.spin[k][lane]),
            rates: std::array::from_fn(|k| self.rates[k][lane]),
        }
    }

    /// Turns the bodies; their orientations have the bits of [`FreeTurn::turned`].
    #[inline(always)]
    pub fn turn(&mut self) {
        let start = self.orientation;
        let mut largest = [0.0; LANES];
        for lane in 0..LANES {
            let (orientation, angle) = self.body(lane, &start).turned_by(series);
            (0..4).for_each(|k| self.orientation[k][lane] = orientation[k]);
            largest[lane] = angle;
        }
        for lane in (0..LANES).filter(|&lane| largest[lane] > SMALL) {
            let orientation = self.body(lane, &start).turned();
            (0..4).for_each(|k| self.orientation[k][lane] = orientation[k]);
        }
    }

    /// Orientation of a lane.
    #[inline(always)]
    pub fn orientation(&self, lane: usize) -> Quaternion {
        std::array::from_fn(|k| self.orientation[k][lane])
    }
}

/// Bodies that turn side by side once the lanes are full, by their numbers.
#[derive(Debug)]
pub(crate) struct TurnQueue {
    /// Bodies in the lanes.
    pub lanes: FreeTurns,
    /// Number of bodies in the lanes, which is the lane of the next one.
    pub count: usize,
    members: [usize; LANES],
}

impl TurnQueue {
    /// Queue without bodies.
    #[inline(always)]
    pub fn new() -> Self {
        Self { lanes: FreeTurns::new(), count: 0, members: [0; LANES] }
    }

    /// Adds the body that was set in the next lane. `take` receives the orientations of the bodies that have turned.
    #[inline(always)]
    pub fn push(&mut self, member: usize, take: impl FnMut(usize, Quaternion)) {
        self.members[self.count] = member;
        self.count += 1;
        if self.count == LANES {
            self.finish(take);
        }
    }

    /// Turns the bodies in the lanes.
    #[inline(always)]
    pub fn finish(&mut self, mut take: impl FnMut(usize, Quaternion)) {
        self.lanes.turn();
        (0..self.count).for_each(|lane| take(self.members[lane], self.lanes.orientation(lane)));
        self.count = 0;
    }
}

/// Product of two quaternions.
#[inline(always)]
fn product(&[a, b, c, d]: &Quaternion, &[w, x, y, z]: &Quaternion) -> Quaternion {
    [a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y + c * w + d * x - b * z, a * z + d * w + b * y - c * x]
}

/// Components of a vector along axes that a quaternion turns.
#[inline(always)]
fn along(&[w, x, y, z]: &Quaternion, &[a, b, c]: &Components) -> Components {
    // v + 2 u × (u × v − w v), with the vector part u.
    let [p, q, r] = [y * c - z * b - w * a, z * a - x * c - w * b, x * b - y * a - w * c];
    [a + 2.0 * (y * r - z * q), b + 2.0 * (z * p - x * r), c + 2.0 * (x * q - y * p)]
}

/// Taylor series of sin(x)/x and cos(x) for x² up to [`SMALL`]: what is left out is below 5e-17.
#[inline(always)]
fn series(t: f64) -> (f64, f64) {
    const SINC: [f64; 6] = [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0];
    const COS: [f64; 7] =
        [-1.0 / 2.0, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0, -1.0 / 87_178_291_200.0];
    let [s1, s2, s3, s4, s5, s6] = SINC;
    let [c1, c2, c3, c4, c5, c6, c7] = COS;
    let sinc = 1.0 + t * (s1 + t * (s2 + t * (s3 + t * (s4 + t * (s5 + t * s6)))));
    (sinc, 1.0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * (c6 + t * c7)))))))
}

/// sin(x)/x and cos(x) of x², for any angle.
fn library(square: f64) -> (f64, f64) {
    let angle = square.sqrt();
    let (sin, cos) = libm::sincos(angle);
    (if angle > 0.0 { sin / angle } else { 1.0 }, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies of which every other one turns beyond the range of the series.
    fn bodies() -> Vec<FreeTurn> {
        let of = |index: usize| {
            let x = 0.1 * index as f64;
            let scale = 1.0 / (1.0 + x * x + 2.0 * x * x).sqrt();
            let orientation = [scale, scale * x, -scale * x, scale * x];
            let speed = if index.is_multiple_of(2) { 1.0 } else { 40.0 };
            FreeTurn { orientation, axes: [0.8, 0.0, 0.6, 0.0], spin: [speed, -x, 0.5 * speed], rates: [0.1, 0.03, -0.02] }
        };
        (0..LANES).map(of).collect()
    }

    /// Bodies side by side have the bits of single ones, whatever turns beside them.
    #[test]
    fn lanes_have_the_bits_of_single_bodies() {
        let mut lanes = FreeTurns::new();
        let bodies = bodies();
        bodies.iter().enumerate().for_each(|(lane, body)| lanes.set(lane, body));
        lanes.turn();
        for (lane, body) in bodies.iter().enumerate() {
            assert_eq!(lanes.orientation(lane), body.turned(), "{lane}");
        }
    }

    /// The series leave out less than half a unit of the last place; each of the sums rounds by less than a unit.
    #[test]
    fn series_agree_with_the_library() {
        for step in 0..=1000 {
            let square = SMALL * 1e-3 * f64::from(step);
            let ((a, b), (c, d)) = (series(square), library(square));
            assert!((a - c).abs() <= 2.0 * f64::EPSILON && (b - d).abs() <= 2.0 * f64::EPSILON, "{square}");
        }
    }
}

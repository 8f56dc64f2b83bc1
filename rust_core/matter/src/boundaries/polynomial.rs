//! Time of first contact of a particle on a parabolic path with a wall, to rounding, or a certificate that there is none.
//!
//! Along x(t) = x₀ + v t + a t²/2 the gap between a particle of radius ρ and a wall is a polynomial f(t). It is positive while
//! the particle is free. For a plane it is n·x − offset − ρ, of degree 2. For a sphere it is ±(|x − c|² − (R ± ρ)²), of degree 4.
//!
//! On any interval, f lies in the convex hull of its Bernstein coefficients. If none is negative, there is no contact. Otherwise
//! the interval is halved, until the coefficients change sign once and thus enclose exactly one root. Coefficients come from the
//! control points of the *path* on that interval, and not from the coefficients of a larger one. A path of 10⁶ m past a sphere of
//! a millimeter therefore loses no digits near the sphere.
//!
//! Source: G. Farin, Curves and Surfaces for CAGD, 5th ed., chapters 5 and 6.

use glam::DVec3;

use super::Path;

/// Maximum bisection depth of an interval, at which its ends are neighboring numbers.
const DEPTH: usize = 60;
/// Maximum number of intervals. Only rounding at a grazing contact could need more, which then counts as a contact. This is
/// harmless, because a particle that recedes from a wall is not reflected.
const INTERVALS: usize = 256;

/// Gap between a particle on its path and a plane or a sphere.
#[derive(Debug, Clone, Copy)]
pub struct Polynomial {
    form: Form,
    touching: bool,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    /// Polynomial f = c₀ + c₁ t + c₂ t².
    Plane([f64; 3]),
    /// Polynomial f = sign (|x|² − s²) with the path relative to the center.
    Sphere { path: Path, square: f64, sign: f64 },
}

impl Polynomial {
    /// Gap of a particle of radius `radius` to the plane n·x = offset, with its normal and offset. If the particle is `touching`
    /// at the start and does not approach, the gap is taken as zero, and only a later contact counts.
    #[inline]
    pub fn plane((normal, offset): (DVec3, f64), path: &Path, radius: f64, touching: bool) -> Self {
        let distance = if touching { 0.0 } else { normal.dot(path.position) - offset - radius };
        Self { form: Form::Plane([distance, normal.dot(path.velocity), 0.5 * normal.dot(path.acceleration)]), touching }
    }

    /// Gap of a particle to a sphere, with its center, radius, and whether the particle is `inside`; `touching` as in
    /// [`Polynomial::plane`].
    #[inline]
    pub fn sphere((center, size, inside): (DVec3, f64, bool), path: &Path, radius: f64, touching: bool) -> Self {
        let path = Path { position: path.position - center, ..*path };
        let reach = if inside { size - radius } else { size + radius };
        let square = if touching { path.position.length_squared() } else { reach * reach };
        Self { form: Form::Sphere { path, square, sign: if inside { -1.0 } else { 1.0 } }, touching }
    }

    /// Time of first contact within `duration` [s]. None is certain.
    pub fn first_contact(&self, duration: f64) -> Option<f64> {
        let mut ends = [duration; DEPTH + 1];
        let (mut start, mut depth) = (0.0, 0);
        for _ in 0..INTERVALS {
            let end = ends[depth];
            let coefficients = self.coefficients(start, end);
            if coefficients.iter().all(|&coefficient| coefficient >= 0.0) {
                if depth == 0 {
                    return None;
                }
                depth -= 1;
                start = end;
                continue;
            }
            if coefficients[0] < 0.0 {
                return Some(start);
            }
            if falls_once(&coefficients) {
                return Some(self.root(start, end));
            }
            let middle = 0.5 * (start + end);
            if depth == DEPTH || middle <= start || middle >= end {
                return Some(start);
            }
            depth += 1;
            ends[depth] = middle;
        }
        Some(start)
    }

    /// Bernstein coefficients of degree 4 on an interval.
    fn coefficients(&self, start: f64, end: f64) -> [f64; 5] {
        let mut coefficients = match &self.form {
            Form::Plane([c0, c1, c2]) => {
                let value = |time: f64| c0 + (c1 + c2 * time) * time;
                let (first, last) = (value(start), value(end));
                let middle = first + (c1 + 2.0 * c2 * start) * (0.5 * (end - start));
                [first, 0.5 * (first + middle), (first + 4.0 * middle + last) / 6.0, 0.5 * (middle + last), last]
            }
            Form::Sphere { path, square, sign } => {
                let [first, middle, last] = path.control(start, end);
                let value = first.length_squared() - square;
                // The second coefficient is written as a difference, so that right after a contact its sign is that of the slope.
                let second = value + first.dot(path.slope(start)) * (0.5 * (end - start));
                let third = (2.0 * middle.length_squared() + first.dot(last)) / 3.0 - square;
                [value, second, third, middle.dot(last) - square, last.length_squared() - square].map(|each| sign * each)
            }
        };
        if self.touching && start == 0.0 {
            coefficients[0] = 0.0;
            coefficients[1] = coefficients[1].max(0.0);
        }
        coefficients
    }

    /// Value of f and its time derivative; for a touching particle those of f/t, without the root at t = 0.
    fn value(&self, time: f64) -> (f64, f64) {
        match &self.form {
            Form::Plane([_, c1, c2]) if self.touching => (c1 + c2 * time, *c2),
            Form::Plane([c0, c1, c2]) => (c0 + (c1 + c2 * time) * time, c1 + 2.0 * c2 * time),
            Form::Sphere { path, sign, .. } if self.touching => {
                // With |x|² − |x₀|² = (x − x₀)·(x + x₀) and x − x₀ = t m, where m is the mean slope, no digits cancel.
                let mean = path.velocity + path.acceleration * (0.5 * time);
                let sum = path.position * 2.0 + mean * time;
                let rate = path.acceleration.dot(sum) * 0.5 + mean.dot(path.slope(time));
                (sign * mean.dot(sum), sign * rate)
            }
            Form::Sphere { path, square, sign } => {
                let position = path.at(time);
                (sign * (position.length_squared() - square), sign * 2.0 * position.dot(path.slope(time)))
            }
        }
    }

    /// Root in an interval where f falls from positive to negative once, by Newton's method safeguarded by bisection. A touching
    /// particle that approaches is already at its root.
    fn root(&self, start: f64, end: f64) -> f64 {
        if self.touching && start == 0.0 && self.value(0.0).0 <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (start, end);
        let mut time = 0.5 * (low + high);
        for _ in 0..200 {
            let (value, rate) = self.value(time);
            if value >= 0.0 {
                low = time;
            } else {
                high = time;
            }
            let newton = time - value / rate;
            if value == 0.0 || (newton - time).abs() <= f64::EPSILON * time || high - low <= f64::EPSILON * high {
                break;
            }
            time = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        time
    }
}

/// Whether a sequence that starts at 0 or above changes sign exactly once and ends below 0.
fn falls_once(coefficients: &[f64; 5]) -> bool {
    let first_negative = coefficients.iter().position(|&coefficient| coefficient < 0.0);
    first_negative.is_some_and(|index| index > 0 && coefficients[index..].iter().all(|&coefficient| coefficient <= 0.0))
        && coefficients[4] < 0.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::boundaries::Wall;

    fn vector() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-2.0..2.0_f64).prop_map(DVec3::from_array)
    }

    fn wall() -> impl Strategy<Value = Wall> {
        let plane = (vector(), -1.0..1.0_f64).prop_filter_map("no direction", |(normal, offset)| {
            normal.try_normalize().map(|normal| Wall::Plane { normal, offset })
        });
        let sphere =
            (vector(), 0.2..2.0_f64, any::<bool>()).prop_map(|(center, radius, inside)| Wall::Sphere { center, radius, inside });
        prop_oneof![plane, sphere]
    }

    fn path() -> impl Strategy<Value = Path> {
        (vector(), vector(), vector()).prop_map(|(position, velocity, acceleration)| Path { position, velocity, acceleration })
    }

    fn polynomial(wall: &Wall, path: &Path) -> Polynomial {
        match *wall {
            Wall::Plane { normal, offset } => Polynomial::plane((normal, offset), path, 0.1, false),
            Wall::Sphere { center, radius, inside } => Polynomial::sphere((center, radius, inside), path, 0.1, false),
            Wall::Solid(_) | Wall::Terrain(_) => unreachable!("not drawn"),
        }
    }

    /// All numbers here are below 100, so that f is exact to about 20 roundings of 100.
    const ROUNDING: f64 = 20.0 * 100.0 * f64::EPSILON;

    proptest! {
        /// The coefficients are those of f: Σ bₖ Bₖ(u) = f(t).
        #[test]
        fn coefficients_are_those_of_the_gap(wall in wall(), path in path(), start in 0.0..1.0_f64, length in 0.0..1.0_f64, u in 0.0..=1.0_f64) {
            let gap = polynomial(&wall, &path);
            let weights = [1.0, 4.0, 6.0, 4.0, 1.0];
            let terms = (0..).zip(weights).zip(gap.coefficients(start, start + length));
            let sum: f64 = terms.map(|((k, weight), b)| weight * u.powi(k) * (1.0 - u).powi(4 - k) * b).sum();
            prop_assert!((sum - gap.value(start + length * u).0).abs() < ROUNDING);
        }

        /// The gap is open up to the first contact, and closed there. None means open to the end.
        #[test]
        fn the_first_contact_is_the_first(wall in wall(), path in path()) {
            let (distance, _) = wall.distance(path.position);
            prop_assume!(distance > 0.1);
            let gap = polynomial(&wall, &path);
            let contact = gap.first_contact(2.0);
            let open = contact.unwrap_or(2.0);
            for sample in 0..=200 {
                prop_assert!(gap.value(open * f64::from(sample) / 200.0).0 > -ROUNDING);
            }
            if let Some(time) = contact {
                // At a grazing contact f touches 0 without crossing it.
                prop_assert!(gap.value(time).0.abs() < ROUNDING);
                prop_assert!(((wall.distance(path.at(time)).0) - 0.1).abs() < 1e-10);
            }
        }
    }
}

//! Flows in space with chaotic attractors.

use super::flow::{Flow, Known};
use super::law::VelocityLaw;
use super::sine::sine;
use crate::error::Result;
use crate::math::Real;
use crate::scene::{self, Item};
use crate::simd::Number;

/// Builds the flow that an item declares. Registry of flows in space.
///
/// # Errors
/// If it is of another kind, or a parameter is not a finite number that the precision holds.
pub fn declared<T: Real>(item: &Item) -> Result<Box<dyn Flow<T, 3>>> {
    let number = |name: &str| match item.number(name) {
        Ok(value) if !T::from_f64(value).is_finite() => {
            Err(item.wrong(name, &format!("a number that {} holds", T::NAME), item.values.get(name)))
        }
        other => other.map(T::from_f64),
    };
    Ok(match item.kind.as_str() {
        "Lorenz" => Box::new(Known {
            name: "Lorenz",
            law: Lorenz { sigma: number("sigma")?, rho: number("rho")?, beta: number("beta")? },
        }),
        "Rossler" => Box::new(Known { name: "Rossler", law: Rossler { a: number("a")?, b: number("b")?, c: number("c")? } }),
        "Aizawa" => {
            let [a, b, c, d, e, f] = ["a", "b", "c", "d", "e", "f"].map(number);
            Box::new(Known { name: "Aizawa", law: Aizawa { a: a?, b: b?, c: c?, d: d?, e: e?, f: f? } })
        }
        "Thomas" => Box::new(Known { name: "Thomas", law: Thomas { b: number("b")? } }),
        "Halvorsen" => Box::new(Known { name: "Halvorsen", law: Halvorsen { a: number("a")? } }),
        _ => return Err(scene::unknown(item, "a kind of flow")),
    })
}

/// Lorenz: x' = σ (y − x), y' = x (ρ − z) − y, z' = x y − β z.
///
/// Source: E. N. Lorenz, J. Atmos. Sci. 20 (1963) 130.
#[derive(Debug, Clone, Copy)]
struct Lorenz<T> {
    sigma: T,
    rho: T,
    beta: T,
}

impl<T: Real> VelocityLaw<T, 3> for Lorenz<T> {
    #[inline(always)]
    fn velocity<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [N; 3] {
        let [sigma, rho, beta] = [self.sigma, self.rho, self.beta].map(N::of);
        [sigma * (y - x), x * (rho - z) - y, x * y - beta * z]
    }

    #[inline(always)]
    fn gradient<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [[N; 3]; 3] {
        let [sigma, rho, beta] = [self.sigma, self.rho, self.beta].map(N::of);
        let [zero, one] = [0.0, 1.0].map(N::constant);
        [[zero - sigma, sigma, zero], [rho - z, zero - one, zero - x], [y, x, zero - beta]]
    }
}

/// Rössler: x' = −y − z, y' = x + a y, z' = b + z (x − c).
///
/// Source: O. E. Rössler, Phys. Lett. A 57 (1976) 397.
#[derive(Debug, Clone, Copy)]
struct Rossler<T> {
    a: T,
    b: T,
    c: T,
}

impl<T: Real> VelocityLaw<T, 3> for Rossler<T> {
    #[inline(always)]
    fn velocity<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [N; 3] {
        let [a, b, c] = [self.a, self.b, self.c].map(N::of);
        [N::constant(0.0) - (y + z), x + a * y, b + z * (x - c)]
    }

    #[inline(always)]
    fn gradient<N: Number<Scalar = T>>(&self, _stage: usize, [x, _, z]: [N; 3]) -> [[N; 3]; 3] {
        let [zero, one] = [0.0, 1.0].map(N::constant);
        [[zero, zero - one, zero - one], [one, N::of(self.a), zero], [z, zero, x - N::of(self.c)]]
    }
}

/// Aizawa: x' = (z − b) x − d y, y' = d x + (z − b) y, z' = c + a z − z³/3 − (x² + y²)(1 + e z) + f z x³.
///
/// Source: W. F. Langford, Int. Ser. Numer. Math. 70 (1984) 215, with the parameters that are named after Y. Aizawa.
#[derive(Debug, Clone, Copy)]
struct Aizawa<T> {
    a: T,
    b: T,
    c: T,
    d: T,
    e: T,
    f: T,
}

impl<T: Real> VelocityLaw<T, 3> for Aizawa<T> {
    #[inline(always)]
    fn velocity<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [N; 3] {
        let [a, b, c, d, e, f] = [self.a, self.b, self.c, self.d, self.e, self.f].map(N::of);
        let (one, third) = (N::constant(1.0), N::constant(1.0 / 3.0));
        let (growth, square) = (z - b, x * x);
        let along = z * (a - third * (z * z)) - (square + y * y) * (one + e * z);
        [growth * x - d * y, d * x + growth * y, c + along + f * z * (square * x)]
    }

    #[inline(always)]
    fn gradient<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [[N; 3]; 3] {
        let [a, b, d, e, f] = [self.a, self.b, self.d, self.e, self.f].map(N::of);
        let [one, two, three] = [1.0, 2.0, 3.0].map(N::constant);
        let (growth, square, spread) = (z - b, x * x, one + e * z);
        let by_x = three * f * z * square - two * x * spread;
        let by_z = a - z * z - e * (square + y * y) + f * (square * x);
        [[growth, N::constant(0.0) - d, x], [d, growth, y], [by_x, N::constant(-2.0) * y * spread, by_z]]
    }
}

/// Thomas: x' = sin y − b x, and cyclic permutations.
///
/// Source: R. Thomas, Int. J. Bifurcation Chaos 9 (1999) 1889.
#[derive(Debug, Clone, Copy)]
struct Thomas<T> {
    b: T,
}

impl<T: Real> VelocityLaw<T, 3> for Thomas<T> {
    #[inline(always)]
    fn velocity<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [N; 3] {
        let b = N::of(self.b);
        [sine::<T, N>(y) - b * x, sine::<T, N>(z) - b * y, sine::<T, N>(x) - b * z]
    }

    #[inline(always)]
    fn gradient<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [[N; 3]; 3] {
        let (zero, quarter) = (N::constant(0.0), N::constant(std::f64::consts::FRAC_PI_2));
        let decay = zero - N::of(self.b);
        let cosine = |angle: N| sine::<T, N>(angle + quarter);
        [[decay, cosine(y), zero], [zero, decay, cosine(z)], [cosine(x), zero, decay]]
    }
}

/// Halvorsen: x' = −a x − 4 y − 4 z − y², and cyclic permutations.
///
/// Source: J. C. Sprott, Chaos and Time-Series Analysis (2003), appendix A.
#[derive(Debug, Clone, Copy)]
struct Halvorsen<T> {
    a: T,
}

impl<T: Real> VelocityLaw<T, 3> for Halvorsen<T> {
    #[inline(always)]
    fn velocity<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [N; 3] {
        let (zero, four, a) = (N::constant(0.0), N::constant(4.0), N::of(self.a));
        [
            zero - (a * x + four * (y + z) + y * y),
            zero - (a * y + four * (z + x) + z * z),
            zero - (a * z + four * (x + y) + x * x),
        ]
    }

    #[inline(always)]
    fn gradient<N: Number<Scalar = T>>(&self, _stage: usize, [x, y, z]: [N; 3]) -> [[N; 3]; 3] {
        let (zero, four, two) = (N::constant(0.0), N::constant(-4.0), N::constant(2.0));
        let decay = zero - N::of(self.a);
        [[decay, four - two * y, four], [four, decay, four - two * z], [four - two * x, four, decay]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences over 2h of polynomials of degree 5 or less have an error of h² times the third derivative.
    fn check<L: VelocityLaw<f64, 3>>(law: L) {
        let (place, h) = ([0.7, -0.4, 0.9], 1e-4);
        let gradient = law.gradient(0, place);
        for column in 0..3 {
            let at = |shift: f64| {
                let mut moved = place;
                moved[column] += shift;
                law.velocity(0, moved)
            };
            let (ahead, behind) = (at(h), at(-h));
            for row in 0..3 {
                let slope = (ahead[row] - behind[row]) / (2.0 * h);
                assert!((slope - gradient[row][column]).abs() < 1e-7, "{row}, {column}: {slope}");
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_velocities() {
        check(Lorenz { sigma: 10.0, rho: 28.0, beta: 8.0 / 3.0 });
        check(Rossler { a: 0.2, b: 0.3, c: 5.7 });
        check(Aizawa { a: 0.95, b: 0.7, c: 0.6, d: 3.5, e: 0.25, f: 0.1 });
        check(Thomas { b: 0.2 });
        check(Halvorsen { a: 1.89 });
    }
}

//! Gauss–Radau collocation of order 15, as in IAS15. The acceleration over a step is a polynomial of degree 7 through its values
//! at the step's start and at seven interior nodes:
//!
//! ```text
//!     a(τ) = a₀ + b₀ τ + b₁ τ² + … + b₆ τ⁷ = a₀ + g₀ τ + g₁ τ (τ − h₁) + … + g₆ τ (τ − h₁) … (τ − h₆),   τ = t/h
//!     v(τ) = v + h τ (a₀ + b₀ τ/2 + b₁ τ²/3 + …),   x(τ) = x + h τ v + h² τ² (a₀/2 + b₀ τ/6 + b₁ τ²/12 + …)
//! ```
//!
//! The positions and velocities at the nodes follow from the polynomial, and the accelerations follow from these. The method is
//! implicit and solved by iteration. Each new acceleration replaces the divided difference g of its node, and updates b
//! accordingly.
//!
//! Sources: H. Rein, D. S. Spiegel, Mon. Not. R. Astron. Soc. 446 (2015) 1424; E. Everhart, in A. Carusi, G. B. Valsecchi
//! (eds.), Dynamics of Comets (1985) 185.

/// Name of the class in Python.
pub const NAME: &str = "GaussRadau15";
/// Order of convergence.
pub const ORDER: u32 = 15;
/// Number of coefficients b, or g.
pub const COEFFICIENTS: usize = 7;
/// Number of nodes, including the start of the step.
pub const STAGES: usize = COEFFICIENTS + 1;

/// Nodes h of the Gauss–Radau quadrature on [0, 1] with the left end: the zeros of P₇ + P₈ at 2h − 1.
pub const NODES: [f64; STAGES] = [
    0.0,
    0.056_262_560_536_922_15,
    0.180_240_691_736_892_36,
    0.352_624_717_113_169_6,
    0.547_153_626_330_555_4,
    0.734_210_177_215_410_5,
    0.885_320_946_839_095_8,
    0.977_520_613_561_287_5,
];

/// Weights of the quadrature, (1 − x)/(2 n² P₇(x)²) with x = 2h − 1 and n = 8.
pub const WEIGHTS: [f64; STAGES] = {
    let mut weights = [0.0; STAGES];
    let mut node = 0;
    while node < STAGES {
        let x = 2.0 * NODES[node] - 1.0;
        // (k + 1) P₍ₖ₊₁₎ = (2k + 1) x Pₖ − k P₍ₖ₋₁₎.
        let (mut before, mut value, mut degree) = (1.0, x, 1.0);
        while degree < 7.0 {
            (before, value) = (value, ((2.0 * degree + 1.0) * x * value - degree * before) / (degree + 1.0));
            degree += 1.0;
        }
        weights[node] = (1.0 - x) / (128.0 * value * value);
        node += 1;
    }
    weights
};

/// Coefficients of τ, τ² … in τ (τ − h₁) … (τ − hₙ), the matrix of b = gᵀ · `EXPANDED`. Up to their sign they are sums of
/// products of nodes, so no digits are lost.
const EXPANDED: [[f64; COEFFICIENTS]; COEFFICIENTS] = {
    let mut rows = [[0.0; COEFFICIENTS]; COEFFICIENTS];
    rows[0][0] = 1.0;
    let mut n = 1;
    while n < COEFFICIENTS {
        let mut k = 0;
        while k <= n {
            rows[n][k] = if k > 0 { rows[n - 1][k - 1] } else { 0.0 } - NODES[n] * rows[n - 1][k];
            k += 1;
        }
        n += 1;
    }
    rows
};

/// Inverse of `EXPANDED`: the coefficients of τ (τ − h₁) … (τ − hₙ) in a power of τ, the matrix of g = bᵀ · `FACTORED`.
const FACTORED: [[f64; COEFFICIENTS]; COEFFICIENTS] = {
    let mut rows = [[0.0; COEFFICIENTS]; COEFFICIENTS];
    rows[0][0] = 1.0;
    let mut k = 1;
    while k < COEFFICIENTS {
        let mut n = 0;
        while n <= k {
            rows[k][n] = if n > 0 { rows[k - 1][n - 1] } else { 0.0 } + NODES[n + 1] * rows[k - 1][n];
            n += 1;
        }
        k += 1;
    }
    rows
};

/// Reciprocals 1/(hₙ − hₖ) for 0 < k < n.
const RECIPROCALS: [[f64; COEFFICIENTS]; STAGES] = {
    let mut rows = [[0.0; COEFFICIENTS]; STAGES];
    let mut n = 1;
    while n < STAGES {
        let mut k = 1;
        while k < n {
            rows[n][k] = 1.0 / (NODES[n] - NODES[k]);
            k += 1;
        }
        n += 1;
    }
    rows
};

/// Condition number of b₆ as a sum over the accelerations at all nodes, Σ 1/Π |hₙ − hₘ|: the largest factor by which their
/// rounding errors are amplified.
pub const CONDITION: f64 = {
    let (mut sum, mut n) = (0.0, 0);
    while n < STAGES {
        let (mut product, mut m) = (1.0, 0);
        while m < STAGES {
            product *= if m == n { 1.0 } else { (NODES[n] - NODES[m]).abs() };
            m += 1;
        }
        sum += 1.0 / product;
        n += 1;
    }
    sum
};

/// Coefficients of a₀, b₀ … b₆ at each node. First those of the mean acceleration until the node, τᵏ/(k + 1); then those of the
/// second integral over τ², τᵏ/((k + 1)(k + 2)).
const INTEGRALS: [[[f64; STAGES]; 2]; STAGES] = {
    let mut rows = [[[0.0; STAGES]; 2]; STAGES];
    let mut node = 0;
    while node < STAGES {
        let (mut power, mut k) = (1.0, 0);
        while k < STAGES {
            let next = (k + 1) as f64;
            rows[node][0][k] = power / next;
            rows[node][1][k] = power / (next * (next + 1.0));
            power *= NODES[node];
            k += 1;
        }
        node += 1;
    }
    rows
};

/// Binomial coefficients (j + 1 over k + 1).
const BINOMIALS: [[f64; COEFFICIENTS]; COEFFICIENTS] = {
    let mut rows = [[0.0; COEFFICIENTS]; COEFFICIENTS];
    let mut j = 0;
    while j < COEFFICIENTS {
        rows[j][0] = (j + 1) as f64;
        let mut k = 1;
        while k <= j {
            rows[j][k] = rows[j - 1][k - 1] + if k < j { rows[j - 1][k] } else { 0.0 };
            k += 1;
        }
        j += 1;
    }
    rows
};

/// Largest ratio of two successive steps over which coefficients are predicted. The error of an extrapolation grows with the
/// seventh power of the ratio, and step-size control never lengthens steps by more.
pub const LARGEST_RATIO: f64 = 4.0;

/// Coefficients b or g of a group of lanes.
pub type PolynomialCoefficients<const W: usize> = [[f64; W]; COEFFICIENTS];

/// Acceleration over a step, in a group of lanes.
#[derive(Debug, Clone, Copy)]
pub struct Series<const W: usize> {
    /// Initial acceleration a₀ [m/s²].
    pub start: [f64; W],
    /// Coefficients b [m/s²].
    pub b: PolynomialCoefficients<W>,
    /// Coefficients g [m/s²].
    g: PolynomialCoefficients<W>,
}

impl<const W: usize> Series<W> {
    /// Series of zeros.
    pub const ZERO: Self = Self { start: [0.0; W], b: [[0.0; W]; COEFFICIENTS], g: [[0.0; W]; COEFFICIENTS] };

    /// Returns the series with a₀ and predicted coefficients b.
    #[inline(always)]
    pub fn new(start: [f64; W], b: PolynomialCoefficients<W>) -> Self {
        let mut series = Self { start, ..Self::ZERO };
        for n in 0..COEFFICIENTS {
            for k in (n..COEFFICIENTS).rev() {
                for lane in 0..W {
                    series.g[n][lane] += FACTORED[k][n] * b[k][lane];
                }
            }
        }
        // Not b itself: later changes preserve the difference of b from g, and rounded factors make this an error of one sign.
        for k in 0..COEFFICIENTS {
            for n in (k..COEFFICIENTS).rev() {
                for lane in 0..W {
                    series.b[k][lane] += EXPANDED[n][k] * series.g[n][lane];
                }
            }
        }
        series
    }

    /// Replaces the acceleration at a node ≥ 1, and returns the change of its divided difference g.
    #[inline(always)]
    pub fn correct(&mut self, node: usize, a: &[f64; W]) -> [f64; W] {
        // Divided, as in [`Self::end`]: a rounded reciprocal would change ȧ by the same fraction in every step.
        let mut difference = [0.0; W];
        for lane in 0..W {
            difference[lane] = (a[lane] - self.start[lane]) / NODES[node];
        }
        for k in 1..node {
            for lane in 0..W {
                difference[lane] = (difference[lane] - self.g[k - 1][lane]) * RECIPROCALS[node][k];
            }
        }
        let mut change = [0.0; W];
        for lane in 0..W {
            change[lane] = difference[lane] - self.g[node - 1][lane];
        }
        self.g[node - 1] = difference;
        for k in 0..node {
            for lane in 0..W {
                self.b[k][lane] += EXPANDED[node - 1][k] * change[lane];
            }
        }
        change
    }

    /// Moves positions and velocities from the step's start to a node.
    #[inline(always)]
    pub fn node_state(&self, node: &Node, memory: &Memory<W>, x: &mut [f64; W], v: &mut [f64; W]) {
        let ([mean, twice], &Node { time, low, .. }) = (&INTEGRALS[node.index], node);
        let (mut first, mut second) = ([0.0; W], [0.0; W]);
        for k in (0..COEFFICIENTS).rev() {
            for lane in 0..W {
                first[lane] += mean[k + 1] * self.b[k][lane];
                second[lane] += twice[k + 1] * self.b[k][lane];
            }
        }
        for lane in 0..W {
            let moved = time * (v[lane] + time * (second[lane] + 0.5 * self.start[lane]));
            x[lane] += moved + (memory.position[lane] + (time * memory.velocity[lane] + low * v[lane]));
            v[lane] += time * (first[lane] + self.start[lane]) + memory.velocity[lane];
        }
    }

    /// Moves positions and velocities, with their low-order parts, to the step's end, and stores the coefficients.
    ///
    /// Here the coefficients are divided by whole numbers. A product with a rounded reciprocal has the same relative error in
    /// every step. Such errors add up in proportion to the number of steps, not to its square root. The largest terms, h v and h
    /// a₀, are not rounded at all.
    #[inline(always)]
    pub fn end(&self, h: f64, memory: &mut Memory<W>, x: &mut [f64; W], v: &mut [f64; W]) {
        let (mut first, mut second) = ([0.0; W], [0.0; W]);
        for k in (0..COEFFICIENTS).rev() {
            let next = (k + 2) as f64;
            for lane in 0..W {
                first[lane] += self.b[k][lane] / next;
                second[lane] += self.b[k][lane] / (next * (next + 1.0));
            }
        }
        for lane in 0..W {
            let (drift, drift_low) = product(h, v[lane]);
            let (kick, kick_low) = product(h, self.start[lane]);
            let bend = h * (h * (second[lane] + 0.5 * self.start[lane]));
            let low = h * memory.velocity[lane] + drift_low;
            add(&mut x[lane], &mut memory.position[lane], drift);
            add(&mut x[lane], &mut memory.position[lane], bend + low);
            add(&mut v[lane], &mut memory.velocity[lane], kick);
            add(&mut v[lane], &mut memory.velocity[lane], h * first[lane] + kick_low);
        }
        memory.b = self.b;
    }
}

/// Node ≥ 1 of a step.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    index: usize,
    /// Time since the step's start [s], with its low-order part: rounded times would belong to other nodes.
    time: f64,
    low: f64,
}

impl Node {
    /// Returns a node of a step of `h` seconds.
    pub fn new(index: usize, h: f64) -> Self {
        let (time, low) = product(h, NODES[index]);
        Self { index, time, low }
    }
}

/// Data that persist from step to step, in a group of lanes.
#[derive(Debug, Clone, Copy)]
pub struct Memory<const W: usize> {
    /// Low-order part of the positions [m].
    pub position: [f64; W],
    /// Low-order part of the velocities [m/s].
    pub velocity: [f64; W],
    /// Coefficients b of the last step, and their prediction [m/s²].
    pub b: PolynomialCoefficients<W>,
    predicted: PolynomialCoefficients<W>,
}

impl<const W: usize> Memory<W> {
    /// Number of rows, one per group of lanes.
    pub const ROWS: usize = 2 + 2 * COEFFICIENTS;
    /// Data before the first step.
    pub const ZERO: Self =
        Self { position: [0.0; W], velocity: [0.0; W], b: [[0.0; W]; COEFFICIENTS], predicted: [[0.0; W]; COEFFICIENTS] };

    /// Predicts the coefficients of a step that is `ratio` times as long as the last one. They are those of the same polynomial
    /// about the new start, plus the error of the last prediction. Without a `ratio` they are 0.
    #[inline(always)]
    pub fn predict(&mut self, ratio: Option<f64>) -> PolynomialCoefficients<W> {
        let mut b = [[0.0; W]; COEFFICIENTS];
        let Some(ratio) = ratio else {
            self.predicted = b;
            return b;
        };
        let mut power = ratio;
        for k in 0..COEFFICIENTS {
            let mut shifted = [0.0; W];
            for j in (k..COEFFICIENTS).rev() {
                for lane in 0..W {
                    shifted[lane] += BINOMIALS[j][k] * self.b[j][lane];
                }
            }
            for lane in 0..W {
                let predicted = power * shifted[lane];
                b[k][lane] = predicted + (self.b[k][lane] - self.predicted[k][lane]);
                self.predicted[k][lane] = predicted;
            }
            power *= ratio;
        }
        b
    }

    /// Iterates over the rows.
    pub fn rows(&self) -> impl Iterator<Item = &[f64; W]> {
        [&self.position, &self.velocity].into_iter().chain(&self.b).chain(&self.predicted)
    }

    /// Iterates over the mutable rows.
    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut [f64; W]> {
        [&mut self.position, &mut self.velocity].into_iter().chain(&mut self.b).chain(&mut self.predicted)
    }
}

/// Computes a product and its rounding error. Source: T. J. Dekker, Numer. Math. 18 (1971) 224.
#[inline(always)]
fn product(a: f64, b: f64) -> (f64, f64) {
    const SPLIT: f64 = 134_217_729.0; // 2²⁷ + 1
    let halves = |number: f64| {
        let scaled = SPLIT * number;
        let high = scaled - (scaled - number);
        (high, number - high)
    };
    let (product, (a, a_low), (b, b_low)) = (a * b, halves(a), halves(b));
    (product, ((a * b - product) + a * b_low + a_low * b) + a_low * b_low)
}

/// Adds an increment to a sum with its low-order part.
///
/// Source: D. E. Knuth, The Art of Computer Programming 2, 4.2.2, theorem B.
#[inline(always)]
fn add(sum: &mut f64, low: &mut f64, increment: f64) {
    let two_sum = |one: f64, other: f64| {
        let sum = one + other;
        let moved = sum - one;
        (sum, (one - (sum - moved)) + (other - moved))
    };
    let (rough, error) = two_sum(*sum, increment);
    (*sum, *low) = two_sum(rough, *low + error);
}

/// Factors by which an iteration reduces the error on x'' = −ω²x − γx'. With values p and q, the factor is p (ωh)² + q γh. They
/// come from the eigenvalues of the iteration, found numerically.
const CONTRACTION: [f64; 2] = [0.0144, 0.45];

/// Largest ωh on x'' = −ω²x − 2ξωx' at which each iteration gains a digit, so the iterations of a step reach rounding accuracy.
/// Steps are stable there, and lose accuracy below it. The iteration still converges up to about twice this limit.
pub fn limit(damping_ratio: f64) -> f64 {
    const GAIN: f64 = 0.1;
    let [position, velocity] = CONTRACTION;
    let half = velocity * damping_ratio;
    // Solution of position s² + 2 half s = GAIN, in the form without cancellation.
    GAIN / (half + libm::sqrt(half * half + position * GAIN))
}

#[cfg(test)]
mod tests {
    use super::{COEFFICIENTS, EXPANDED, FACTORED, Memory, NODES, Node, ORDER, STAGES, Series, WEIGHTS, add, limit, product};

    /// Rounding error of sums of eight products of numbers up to 1.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;

    fn power(base: f64, exponent: u32) -> f64 {
        (0..exponent).map(|_| base).product()
    }

    #[test]
    fn the_quadrature_is_exact_up_to_degree_14_and_no_further() {
        let missed = |degree: u32| {
            let sum: f64 = NODES.iter().zip(WEIGHTS).map(|(node, weight)| weight * power(*node, degree)).sum();
            (sum - 1.0 / f64::from(degree + 1)).abs()
        };
        for degree in 0..ORDER {
            assert!(missed(degree) < ROUNDING, "degree {degree}: {:e}", missed(degree));
        }
        assert!(missed(ORDER) > 1e-9);
    }

    #[test]
    fn the_forms_of_newton_and_of_powers_are_inverse() {
        for row in 0..COEFFICIENTS {
            for column in 0..COEFFICIENTS {
                let entry: f64 = (0..COEFFICIENTS).map(|k| EXPANDED[row][k] * FACTORED[k][column]).sum();
                assert!((entry - f64::from(u8::from(row == column))).abs() < ROUNDING, "{row}, {column}: {entry}");
            }
        }
    }

    /// A polynomial of degree 7 is found in one pass: a = 1 + 2τ + … + 8τ⁷ has the integrals 8 and Σ 1/(k + 2).
    #[test]
    fn a_polynomial_is_integrated_exactly() {
        let a = |node: usize| (0..STAGES).map(|k| (k + 1) as f64 * power(NODES[node], k as u32)).sum::<f64>();
        let mut series = Series::<1>::new([a(0)], [[0.0]; COEFFICIENTS]);
        (1..STAGES).for_each(|node| _ = series.correct(node, &[a(node)]));
        let (mut memory, mut x, mut v) = (Memory::ZERO, [0.0], [3.0]);
        series.end(1.0, &mut memory, &mut x, &mut v);
        let exact: f64 = 3.0 + (0..STAGES).map(|k| 1.0 / (k + 2) as f64).sum::<f64>();
        // Error of divided differences of order 7: the rounding of a ≤ 36 times the sum of the reciprocal products, 1e4.
        assert!((v[0] - 11.0).abs() < 1e-11 && (x[0] - exact).abs() < 1e-11, "{v:?}, {x:?}");
    }

    #[test]
    fn the_rounding_of_products_and_sums_is_kept() {
        // (1 + 2⁻³⁰)² = 1 + 2⁻²⁹ + 2⁻⁶⁰.
        let number = 1.0 + 2.0_f64.powi(-30);
        assert_eq!(product(number, number), (1.0 + 2.0_f64.powi(-29), 2.0_f64.powi(-60)));
        let (mut sum, mut low) = (1.0, 0.0);
        (0..64).for_each(|_| add(&mut sum, &mut low, 2.0_f64.powi(-60)));
        assert_eq!((sum, low), (1.0, 2.0_f64.powi(-54)));
    }

    /// Computes one step of x'' = −x − 2ξx', and the change of b₆ in its last iteration over |a|.
    fn step(y: [f64; 2], h: f64, ratio: f64, iterations: usize) -> ([f64; 2], f64) {
        let acceleration = |x: f64, v: f64| -x - 2.0 * ratio * v;
        let mut series = Series::<1>::new([acceleration(y[0], y[1])], [[0.0]; COEFFICIENTS]);
        let mut change = 0.0;
        for _ in 0..iterations {
            for node in 1..STAGES {
                let (mut x, mut v) = ([y[0]], [y[1]]);
                series.node_state(&Node::new(node, h), &Memory::<1>::ZERO, &mut x, &mut v);
                change = series.correct(node, &[acceleration(x[0], v[0])])[0].abs();
            }
        }
        let (mut x, mut v) = ([y[0]], [y[1]]);
        series.end(h, &mut Memory::<1>::ZERO.clone(), &mut x, &mut v);
        ([x[0], v[0]], change / y[0].hypot(y[1]))
    }

    /// Stability test: the eigenvalues of a step have the product det and the sum tr, and are stable if |tr| ≤ 1 + det ≤ 2.
    #[test]
    fn steps_at_the_limit_converge_and_are_stable() {
        for ratio in [0.0, 0.01, 0.1, 0.5, 1.0, 3.0, 100.0] {
            for part in [0.25, 0.5, 1.0] {
                let h = part * limit(ratio);
                let [(one, _), (other, _)] = [[1.0, 0.0], [0.0, 1.0]].map(|y| step(y, h, ratio, 12));
                let (trace, determinant) = (one[0] + other[1], one[0] * other[1] - one[1] * other[0]);
                // Undamped, the amplitude grows by 2e-12 in a step at the limit, less than any run shows.
                assert!(determinant < 1.0 + 1e-11 && trace.abs() < 1.0 + determinant + 1e-11, "ξ = {ratio}: {determinant}");
                let changes = [4, 8].map(|iterations| step([0.6, 0.8], h, ratio, iterations).1);
                // This factor holds for the last iterations; the first ones gain a little less.
                assert!(changes[1] < 1e-3 * changes[0] || changes[1] < 1e-12, "ξ = {ratio}: {changes:?}");
            }
            // Far beyond the limit, the iteration increases the error.
            let change = step([0.6, 0.8], 7.0 * limit(ratio), ratio, 12).1;
            assert!(change.is_nan() || change > 1.0, "ξ = {ratio}: {change}");
        }
    }
}

//! Fourier, sine and cosine transforms of a line of cells.
//!
//! Values are at the centers of cells. The modes that satisfy the boundary conditions are exp(iqx) on a periodic line, cos qx
//! between free ends, and sin qx between fixed ends. For a free and a fixed end, the line is doubled. Of its modes between two
//! fixed ends, the ones symmetric about the middle are used.
//!
//! Cosines: let v be the even cells followed by the odd ones in reverse order, V its Fourier transform and θ = πk/2N. Then
//!
//! ```text
//!     X[k] = ½ (exp(−iθ) V[k] + exp(iθ) V[N−k]),    V[k] = exp(iθ) (X[k] − i X[N−k])
//! ```
//!
//! With the sign of every other cell changed, the amplitude k belongs to the sine of N − k.
//!
//! Source: J. Makhoul, IEEE Trans. Acoust. Speech Signal Process. 28, 27 (1980).

use physcore_fourier::{Transform, plan_f32, plan_f64};
use std::f64::consts::PI;

pub use physcore_fourier::Complex;

use crate::grid::Edge;
use crate::math::Real;

/// Number type with Fourier transforms.
pub trait FourierReal: Real {
    /// Plans the transform of `length` numbers, forward, or backward without the factor 1/length.
    fn plan(length: usize, forward: bool) -> Box<dyn Transform<Self>>;
}

impl FourierReal for f32 {
    fn plan(length: usize, forward: bool) -> Box<dyn Transform<Self>> {
        plan_f32(length, forward)
    }
}

impl FourierReal for f64 {
    fn plan(length: usize, forward: bool) -> Box<dyn Transform<Self>> {
        plan_f64(length, forward)
    }
}

/// Product of two complex numbers.
#[inline(always)]
pub fn product<T: Real>(one: Complex<T>, other: Complex<T>) -> Complex<T> {
    Complex { re: one.re * other.re - one.im * other.im, im: one.re * other.im + one.im * other.re }
}

/// Complex number exp(iφ), times a real number.
pub fn polar<T: Real>(size: f64, phase: f64) -> Complex<T> {
    Complex { re: T::from_f64(size * libm::cos(phase)), im: T::from_f64(size * libm::sin(phase)) }
}

/// Squared modulus |z|².
#[inline(always)]
pub fn square<T: Real>(number: Complex<T>) -> f64 {
    let (re, im) = (number.re.to_f64(), number.im.to_f64());
    re * re + im * im
}

/// Sum Σ |z|², as eight interleaved partial sums, so additions do not wait for one another.
pub fn norm<T: Real>(numbers: &[Complex<T>]) -> f64 {
    let mut sums = [0.0; 8];
    for chunk in numbers.chunks(sums.len()) {
        sums.iter_mut().zip(chunk).for_each(|(sum, &number)| *sum += square(number));
    }
    sums.into_iter().sum()
}

/// Modes of a line of cells.
pub struct Spectrum<T> {
    cells: usize,
    /// Number of modes; between a free and a fixed end, twice the number of cells.
    pub length: usize,
    ends: [Edge; 2],
    forward: Box<dyn Transform<T>>,
    backward: Box<dyn Transform<T>>,
    /// Factor exp(−iθ) of each mode; empty for a periodic line.
    turns: Vec<Complex<T>>,
}

impl<T> std::fmt::Debug for Spectrum<T> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "the spectrum of {} cells", self.cells)
    }
}

impl<T: FourierReal> Spectrum<T> {
    /// Returns the modes of `cells` cells between ends. An absorbing layer has a fixed end.
    pub fn new(cells: usize, ends: [Edge; 2]) -> Self {
        let ends = ends.map(|end| if end == Edge::Absorbing { Edge::Fixed } else { end });
        let length = if ends[0] == ends[1] { cells } else { 2 * cells };
        let modes = if ends[0] == Edge::Periodic { 0 } else { length };
        let turns = (0..modes).map(|mode| polar(1.0, -0.5 * PI * mode as f64 / length as f64)).collect();
        Self { cells, length, ends, forward: T::plan(length, true), backward: T::plan(length, false), turns }
    }

    /// Length of the memory that a transform needs.
    pub fn scratch(&self) -> usize {
        self.length + self.forward.scratch().max(self.backward.scratch())
    }

    fn is_periodic(&self) -> bool {
        self.ends[0] == Edge::Periodic
    }

    fn is_odd(&self) -> bool {
        self.ends.contains(&Edge::Fixed)
    }

    /// Wave numbers q of the modes, times the spacing.
    pub fn wave_numbers(&self) -> Vec<f64> {
        let (length, count) = (self.length as f64, self.length);
        let half = |mode: usize| if self.is_odd() { count - mode } else { mode };
        let of = |mode: usize| {
            if self.is_periodic() { 2.0 * PI * mode.min(count - mode) as f64 / length } else { PI * half(mode) as f64 / length }
        };
        (0..count).map(of).collect()
    }

    /// Weights with which the squared amplitudes of the modes add up to the sum of squares over the cells.
    pub fn weights(&self) -> Vec<f64> {
        let length = self.length as f64;
        let share = self.cells as f64 / (length * length);
        (0..self.length).map(|mode| if self.is_periodic() || mode == 0 { share } else { 2.0 * share }).collect()
    }

    /// Cell of the line at each place of the transform, and whether its sign changes for sines. The transform takes the cells of
    /// the doubled line, even ones first.
    fn place(&self, mode: usize) -> (usize, bool) {
        let (length, evens) = (self.length, self.length.div_ceil(2));
        let at = if mode < evens { 2 * mode } else { 2 * (length - 1 - mode) + 1 };
        let cell = match self.length == self.cells {
            true => at,
            false if self.ends[0] == Edge::Fixed => at.min(self.length - 1 - at),
            false => self.cells - 1 - at.min(self.length - 1 - at),
        };
        (cell, self.is_odd() && at % 2 == 1)
    }

    /// Computes the amplitudes of the modes of a line.
    pub fn analyze(&self, line: &[Complex<T>], memory: &mut [Complex<T>]) {
        let (modes, scratch) = memory.split_at_mut(self.length);
        if self.is_periodic() {
            modes.copy_from_slice(line);
            self.forward.run(modes, scratch);
            return;
        }
        for mode in 0..self.length {
            let (cell, negative) = self.place(mode);
            modes[mode] = if negative { Complex { re: -line[cell].re, im: -line[cell].im } } else { line[cell] };
        }
        self.forward.run(modes, scratch);
        let half = T::from_f64(0.5);
        let cosine = |turn: Complex<T>, own: Complex<T>, other: Complex<T>| {
            let (one, two) = (product(turn, own), product(Complex { re: turn.re, im: -turn.im }, other));
            Complex { re: half * (one.re + two.re), im: half * (one.im + two.im) }
        };
        for low in 1..=self.length / 2 {
            let high = self.length - low;
            let pair = (modes[low], modes[high]);
            modes[low] = cosine(self.turns[low], pair.0, pair.1);
            modes[high] = cosine(self.turns[high], pair.1, pair.0);
        }
    }

    /// Computes the line with the amplitudes in `memory`, times the number of modes.
    pub fn synthesize(&self, line: &mut [Complex<T>], memory: &mut [Complex<T>]) {
        let (modes, scratch) = memory.split_at_mut(self.length);
        if self.is_periodic() {
            self.backward.run(modes, scratch);
            line.copy_from_slice(modes);
            return;
        }
        let fourier = |turn: Complex<T>, own: Complex<T>, other: Complex<T>| {
            product(Complex { re: turn.re, im: -turn.im }, Complex { re: own.re + other.im, im: own.im - other.re })
        };
        for low in 1..=self.length / 2 {
            let high = self.length - low;
            let pair = (modes[low], modes[high]);
            modes[low] = fourier(self.turns[low], pair.0, pair.1);
            modes[high] = fourier(self.turns[high], pair.1, pair.0);
        }
        self.backward.run(modes, scratch);
        for mode in 0..self.length {
            let (cell, negative) = self.place(mode);
            line[cell] = if negative { Complex { re: -modes[mode].re, im: -modes[mode].im } } else { modes[mode] };
        }
    }

    /// Multiplies each mode of a line by a factor, which includes 1/length.
    pub fn multiply(&self, line: &mut [Complex<T>], factors: &[Complex<T>], memory: &mut [Complex<T>]) {
        let turn = |mode: &mut Complex<T>, factor: &Complex<T>| *mode = product(*mode, *factor);
        if self.is_periodic() {
            let (_, scratch) = memory.split_at_mut(self.length);
            self.forward.run(line, scratch);
            line.iter_mut().zip(factors).for_each(|(mode, factor)| turn(mode, factor));
            self.backward.run(line, scratch);
            return;
        }
        self.analyze(line, memory);
        memory.iter_mut().zip(factors).for_each(|(mode, factor)| turn(mode, factor));
        self.synthesize(line, memory);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::noise;

    const LENGTHS: [usize; 7] = [1, 2, 3, 8, 15, 16, 37];

    /// Pairs of ends with the modes that satisfy their boundary conditions: wave numbers, and values by wave number and position.
    type Mode = fn(f64, f64) -> (f64, f64);
    const ENDS: [([Edge; 2], f64, f64, Mode); 5] = [
        ([Edge::Periodic; 2], 2.0, 0.0, |q, x| (libm::cos(q * x), libm::sin(q * x))),
        ([Edge::Free; 2], 1.0, 0.0, |q, x| (libm::cos(q * x), 0.0)),
        ([Edge::Fixed; 2], 1.0, 1.0, |q, x| (libm::sin(q * x), 0.0)),
        ([Edge::Free, Edge::Fixed], 1.0, 0.5, |q, x| (libm::cos(q * x), 0.0)),
        ([Edge::Fixed, Edge::Free], 1.0, 0.5, |q, x| (libm::sin(q * x), 0.0)),
    ];

    fn distance(one: &[Complex<f64>], other: &[Complex<f64>]) -> f64 {
        one.iter().zip(other).map(|(one, other)| (one - other).norm()).fold(0.0, f64::max)
    }

    /// Tolerance: sums of up to 74 numbers of size 1, each rounded a few times, are accurate to 1e-13 of the largest factor.
    #[test]
    fn each_mode_is_multiplied_by_its_own_factor() {
        for (ends, turn, first, mode) in ENDS {
            for count in LENGTHS {
                let spectrum = Spectrum::<f64>::new(count, ends);
                let mut memory = vec![Complex::default(); spectrum.scratch()];
                let share = 1.0 / spectrum.length as f64;
                let factors: Vec<_> =
                    spectrum.wave_numbers().iter().map(|q| Complex { re: share * q, im: share * (1.0 - q) }).collect();
                for index in 0..count {
                    let number = index.min(if ends[0] == Edge::Periodic { count - index } else { count });
                    let signed = if number < index { -(number as f64) } else { number as f64 };
                    let q = turn * PI * (signed + first) / count as f64;
                    let line: Vec<Complex<f64>> =
                        (0..count).map(|cell| mode(q, cell as f64 + 0.5)).map(|(re, im)| Complex { re, im }).collect();
                    let mut found = line.clone();
                    spectrum.multiply(&mut found, &factors, &mut memory);
                    let factor = Complex { re: q.abs(), im: 1.0 - q.abs() };
                    let expected: Vec<_> = line.iter().map(|&value| product(value, factor)).collect();
                    assert!(distance(&found, &expected) < 1e-13 * 2.0 * PI, "{ends:?} {count} {index}");
                }
            }
        }
    }

    #[test]
    fn squares_of_amplitudes_add_up_to_those_of_cells() {
        for (ends, ..) in ENDS {
            for count in LENGTHS {
                let spectrum = Spectrum::<f64>::new(count, ends);
                let mut memory = vec![Complex::default(); spectrum.scratch()];
                let random = |cell: usize| noise(cell as u64);
                let line: Vec<_> = (0..count).map(|cell| Complex { re: random(cell).x, im: random(cell).y }).collect();
                spectrum.analyze(&line, &mut memory);
                let sum: f64 = memory.iter().zip(spectrum.weights()).map(|(mode, weight)| weight * square(*mode)).sum();
                assert!((sum / norm(&line) - 1.0).abs() < 1e-13, "{ends:?} {count}: {sum}");
            }
        }
    }
}

//! Absorbing edges: layers with an imaginary potential −iW, in which a wave function decays by exp(−Wt/ħ).
//!
//! The potential W grows with the cube of the depth. A weak potential lets waves return from the outer end; a strong one reflects
//! them itself. W is chosen for the least reflection of waves with the wave numbers k, k/√2 and √2 k. Reflection is computed from
//! the stationary equation in the layer. k is the wave number of the mean kinetic energy at the start. The default width is three
//! wavelengths.
//!
//! Source: D. Neuhauser, M. Baer, J. Chem. Phys. 90, 4351 (1989).

use std::f64::consts::PI;

use super::fourier::{Complex, FourierReal, product};
use crate::error::Result;
use crate::grid::{Edge, Edges, Grid, Padding};
use crate::math::AXES;
use crate::scene::{Item, Value};

/// Default width in wavelengths, and its bounds [cells].
const WAVELENGTHS: f64 = 3.0;
const WIDTHS: [f64; 2] = [20.0, 1000.0];

/// Absorbing layer.
#[derive(Debug, Clone, Copy)]
pub struct Layer {
    /// Width [cells].
    pub width: usize,
    /// Potential W at the outer end, in units of ħ²/2m h².
    pub strength: f64,
    /// Largest reflected amplitude.
    pub reflection: f64,
}

impl Layer {
    /// Reads the layer that an item declares, if an edge absorbs, for waves of `k` per spacing.
    ///
    /// # Errors
    /// If a value is missing or out of range.
    pub fn declared(item: &Item, grid: &Grid, edges: Edges, k: f64) -> Result<Option<Self>> {
        if !edges.any(Edge::Absorbing) {
            return Ok(None);
        }
        let item = item.record("absorbing")?;
        let width = match item.values.get("cells") {
            Some(Value::Text(word)) if word == "auto" => {
                transformable((WAVELENGTHS * 2.0 * PI / k).ceil().clamp(WIDTHS[0], WIDTHS[1]) as usize, grid, edges)
            }
            Some(Value::Number(cells)) if *cells >= 1.0 && *cells <= 1e4 && cells.fract() == 0.0 => *cells as usize,
            other => return Err(item.wrong("cells", "a whole number from 1 to 10000 or \"auto\"", other)),
        };
        let wanted = match item.number("reflection")? {
            reflection if reflection > 0.0 && reflection < 1.0 => reflection,
            reflection => return Err(item.wrong("reflection", "a number between 0 and 1", Some(&Value::Number(reflection)))),
        };
        let k = k.clamp(0.02, 0.5 * PI);
        let worst = |strength: f64| {
            [0.5_f64.sqrt(), 1.0, 2.0_f64.sqrt()]
                .map(|part| reflection(width, strength, part * k))
                .into_iter()
                .fold(0.0, f64::max)
        };
        // The amplitude after two passes is exp(−2 ∫W dx m/ħ²k) = exp(−a). Stronger potentials than requested are not tried.
        let most = -libm::log(wanted);
        let tried = (1..=64).map(|part| {
            let strength = 4.0 * k * most * f64::from(part) / 64.0 / width as f64;
            (strength, worst(strength))
        });
        let best = tried.min_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0.0, 1.0));
        Ok(Some(Self { width, strength: best.0, reflection: best.1 }))
    }

    /// Number of cells added at each edge.
    pub fn widths(layer: Option<Self>, edges: Edges) -> [[usize; 2]; AXES] {
        let width = layer.map_or(0, |layer| layer.width);
        edges.0.map(|pair| pair.map(|edge| if edge == Edge::Absorbing { width } else { 0 }))
    }

    /// Potential W of a cell of the outer grid, in units of ħ²/2m h².
    pub fn potential(&self, padding: &Padding, cell: usize) -> f64 {
        let length = padding.outer.row_length();
        let row = padding.outer.place(cell / length);
        let place = [row[0], row[1], cell % length];
        let depth = |axis: usize| {
            let inside = padding.inside(axis);
            let (below, above) = (inside.start as f64 - place[axis] as f64 - 0.5, place[axis] as f64 + 0.5 - inside.end as f64);
            below.max(above).max(0.0) / self.width as f64
        };
        (0..AXES).map(|axis| self.strength * depth(axis).powi(3)).sum()
    }
}

/// Smallest width from `width` to 1.5 times that with fast transforms: the numbers of cells of all axes with layers have no prime
/// factor above 7. Falls back to `width`.
fn transformable(width: usize, grid: &Grid, edges: Edges) -> usize {
    let layers = |axis: usize| edges.0[axis].iter().filter(|edge| matches!(edge, Edge::Absorbing)).count();
    let is_fast =
        |width: &usize| (0..AXES).filter(|&axis| layers(axis) > 0).all(|axis| is_smooth(grid.cells[axis] + layers(axis) * width));
    (width..=width + width / 2).find(is_fast).unwrap_or(width)
}

/// Whether a number above 0 has no prime factor above 7.
fn is_smooth(number: usize) -> bool {
    let without = |mut number: usize, prime: usize| {
        while number.is_multiple_of(prime) {
            number /= prime;
        }
        number
    };
    [2, 3, 5, 7].into_iter().fold(number, without) == 1
}

/// Amplitude that a layer reflects for waves of k per spacing. The equation ψ'' = (−ε − iW) ψ is solved by differences inward
/// from ψ = 0 at the outer end. With ε = 2 − 2 cos k, the differences themselves reflect nothing.
fn reflection(width: usize, strength: f64, k: f64) -> f64 {
    let complex = |re: f64, im: f64| Complex { re, im };
    let (mut outer, mut own) = (complex(-1.0, 0.0), complex(1.0, 0.0));
    for cell in (0..width + 2).rev() {
        let depth = (cell as f64 - 1.5).max(0.0) / width as f64;
        let factor = complex(2.0 * libm::cos(k), -strength * depth.powi(3));
        let next = product(factor, own);
        let scale = 1.0 / (own.re.abs() + own.im.abs()).max(1e-300);
        (outer, own) =
            (complex(own.re * scale, own.im * scale), complex((next.re - outer.re) * scale, (next.im - outer.im) * scale));
    }
    // Here ψ = a exp(ikn) + b exp(−ikn), outward at `outer`: b/a from two neighbors.
    let turn = |sign: f64| complex(libm::cos(k), sign * libm::sin(k));
    let part = |sign: f64| {
        let other = product(own, turn(sign));
        libm::hypot(outer.re - other.re, outer.im - other.im)
    };
    part(1.0) / part(-1.0)
}

/// Absorption in the layers.
#[derive(Debug)]
pub struct Absorption<T> {
    /// Cells outside the user's grid.
    pub cells: Vec<usize>,
    /// Rates W/ħ of these cells [1/s].
    rates: Vec<f64>,
    h: f64,
    factors: Vec<T>,
}

impl<T: FourierReal> Absorption<T> {
    /// Returns the absorption of a layer, with `rate` = ħ/2m h² [1/s].
    pub fn new(padding: &Padding, layer: Layer, rate: f64) -> Self {
        let mut inside = vec![false; padding.outer.count()];
        (0..padding.inner.count()).for_each(|cell| inside[padding.outward(cell)] = true);
        let cells: Vec<usize> = (0..inside.len()).filter(|&cell| !inside[cell]).collect();
        let rates = cells.iter().map(|&cell| rate * layer.potential(padding, cell)).collect();
        Self { cells, rates, h: 0.0, factors: Vec::new() }
    }

    /// Sum Σ |ψ|² over the layers.
    pub fn outside(&self, values: &[Complex<T>]) -> f64 {
        self.cells.iter().map(|&cell| super::fourier::square(values[cell])).sum()
    }

    /// Damps the wave function in the layers for a time of `h`.
    pub fn fade(&mut self, values: &mut [Complex<T>], h: f64) {
        if self.h != h {
            self.factors = self.rates.iter().map(|rate| T::from_f64(libm::exp(-rate * h))).collect();
            self.h = h;
        }
        for (&cell, &factor) in self.cells.iter().zip(&self.factors) {
            values[cell] = Complex { re: values[cell].re * factor, im: values[cell].im * factor };
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.cells.len() * (size_of::<usize>() + size_of::<f64>()) + size_of_val(self.factors.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::is_smooth;

    #[test]
    fn smooth_numbers_have_small_prime_factors() {
        let smooth: Vec<usize> = (1..=30).filter(|&number| is_smooth(number)).collect();
        let rough = [11, 13, 17, 19, 22, 23, 26, 29];
        assert_eq!(smooth, (1..=30).filter(|number| !rough.contains(number)).collect::<Vec<_>>());
        assert!(!is_smooth(5532) && is_smooth(5544 / 11));
    }
}

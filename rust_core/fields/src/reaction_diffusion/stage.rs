//! One stage of a step, cell by cell: reaction rates, diffusion rates and the next state.

use super::kinetics::RateLaw;
use crate::grid::{COLUMNS, load};
use crate::integrators::first_order::{Base, Combination, SLOPES};
use crate::math::Real;
use crate::simd::{Isa, Kernel, LANES, dispatch};

/// Stage of a step of h seconds, in the precision of the state.
#[derive(Debug, Clone, Copy)]
pub struct SpeciesStage<T> {
    base: Base,
    /// Coefficients μ and ν.
    own: T,
    other: T,
    /// Weights h wⱼ of the first `count` stored slopes.
    slopes: [T; SLOPES],
    count: usize,
    /// Weight h w.
    slope: T,
    keep: Option<usize>,
    /// Weight h b.
    pub weight: f64,
    /// Node c.
    pub node: f64,
}

impl<T: Real> SpeciesStage<T> {
    /// Returns a stage of a step of `h` seconds.
    pub fn new(combination: &Combination, h: f64) -> Self {
        let scaled = |weight: f64| T::from_f64(h * weight);
        let (own, other) = match combination.base {
            Base::Own(own) => (own, 0.0),
            Base::Recurrence(own, other) => (own, other),
            Base::Here { .. } | Base::Start => (0.0, 0.0),
        };
        Self {
            base: combination.base,
            own: T::from_f64(own),
            other: T::from_f64(other),
            slopes: std::array::from_fn(|index| combination.slopes.get(index).map_or(T::ZERO, |&weight| scaled(weight))),
            count: combination.slopes.len(),
            slope: scaled(combination.slope),
            keep: combination.keep,
            weight: h * combination.weight,
            node: combination.node,
        }
    }
}

/// Adjacent cells of a species.
#[derive(Debug)]
pub struct SpeciesCells<'a, T> {
    /// State Y at the stage.
    pub value: &'a [T],
    /// Rate of diffusion at Y.
    pub diffusion: &'a [T],
    /// Next state; before the stage, the state at the stage before Y.
    pub next: &'a mut [T],
    /// Initial state y₀ and the stored slopes.
    pub columns: [&'a mut [T]; COLUMNS],
}

/// Reaction rates of `N` species.
pub trait ReactionRates<T, const N: usize>: Copy {
    /// Rates in `W` cells from `at` on.
    fn rates<const W: usize>(self, at: usize, values: &[[T; W]; N]) -> [[T; W]; N];
}

/// Rates computed by built-in kinetics.
#[derive(Clone, Copy)]
pub struct ComputedRates<L>(pub L);

impl<T: Real, L: RateLaw<T>> ReactionRates<T, 2> for ComputedRates<L> {
    #[inline(always)]
    fn rates<const W: usize>(self, _at: usize, [u, v]: &[[T; W]; 2]) -> [[T; W]; 2] {
        let mut rates = [[T::ZERO; W]; 2];
        for lane in 0..W {
            let [one, other] = self.0.rates([u[lane], v[lane]]);
            rates[0][lane] = one;
            rates[1][lane] = other;
        }
        rates
    }
}

/// Rates given as numbers.
#[derive(Clone, Copy)]
pub struct GivenRates<'a, T>(pub &'a [T]);

impl<T: Real> ReactionRates<T, 1> for GivenRates<'_, T> {
    #[inline(always)]
    fn rates<const W: usize>(self, at: usize, _values: &[[T; W]; 1]) -> [[T; W]; 1] {
        [load(self.0, at)]
    }
}

/// Sums over the cells of a species.
#[derive(Debug, Clone, Copy, Default)]
pub struct SpeciesSums {
    /// Sum Σ max(R, 0).
    pub gain: f64,
    /// Sum Σ R.
    pub net: f64,
    /// Largest |value| of the next state; not finite if Y was not.
    pub largest: f64,
}

/// Runs a stage for some cells.
pub fn run<T: Real, R: ReactionRates<T, N>, const N: usize>(
    stage: &SpeciesStage<T>,
    rates: R,
    cells: &mut [SpeciesCells<'_, T>; N],
) -> [SpeciesSums; N] {
    dispatch(Update { stage, rates, cells })
}

struct Update<'a, 'b, T, R, const N: usize> {
    stage: &'a SpeciesStage<T>,
    rates: R,
    cells: &'a mut [SpeciesCells<'b, T>; N],
}

#[inline(always)]
fn store<T: Real, const W: usize>(column: &mut [T], at: usize, lanes: &[T; W]) {
    column[at..at + W].copy_from_slice(lanes);
}

/// Sums by lane: cell i adds to lane i mod 16, whether it is computed in a group or alone.
#[derive(Clone, Copy)]
struct SpeciesLaneSums<T, const W: usize = LANES> {
    gain: [T; W],
    net: [T; W],
    /// Largest |value|.
    most: [T; W],
}

impl<T: Real, const W: usize> SpeciesLaneSums<T, W> {
    const ZERO: Self = Self { gain: [T::ZERO; W], net: [T::ZERO; W], most: [T::ZERO; W] };

    fn sums(&self) -> SpeciesSums {
        let sum = |lanes: &[T; W]| fold(lanes, |one, other| one + other);
        let (net, largest) = (sum(&self.net), fold(&self.most, f64::max));
        SpeciesSums { gain: sum(&self.gain), net, largest: if net.is_finite() { largest } else { f64::NAN } }
    }
}

impl<T: Real> SpeciesLaneSums<T> {
    /// Adds the sums of a single cell.
    fn add(&mut self, lane: usize, cell: &SpeciesLaneSums<T, 1>) {
        self.gain[lane] += cell.gain[0];
        self.net[lane] += cell.net[0];
        self.most[lane] = larger(self.most[lane], cell.most[0]);
    }
}

/// Folds the lanes, whose number is a power of two, by halves.
fn fold<T: Real, const W: usize>(lanes: &[T; W], with: impl Fn(f64, f64) -> f64) -> f64 {
    let mut numbers = lanes.map(Real::to_f64);
    let mut width = W;
    while width > 1 {
        width /= 2;
        (0..width).for_each(|lane| numbers[lane] = with(numbers[lane], numbers[lane + width]));
    }
    numbers[0]
}

#[inline(always)]
fn larger<T: Real>(one: T, other: T) -> T {
    if other > one { other } else { one }
}

impl<T: Real, R: ReactionRates<T, N>, const N: usize> Kernel for Update<'_, '_, T, R, N> {
    type Output = [SpeciesSums; N];

    #[inline(always)]
    fn run<S: Isa>(mut self, _isa: S) -> [SpeciesSums; N] {
        if self.stage.is_plain() { self.all::<true>() } else { self.all::<false>() }
    }
}

impl<T: Real, R: ReactionRates<T, N>, const N: usize> Update<'_, '_, T, R, N> {
    #[inline(always)]
    fn all<const PLAIN: bool>(&mut self) -> [SpeciesSums; N] {
        let mut sums = [SpeciesLaneSums::ZERO; N];
        let count = self.cells[0].value.len();
        let whole = count / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            self.group::<PLAIN, LANES>(at, &mut sums);
        }
        // A copy whose lanes are indexed at run time: the sums above stay in registers.
        let mut all = sums;
        for at in whole..count {
            let mut cell = [SpeciesLaneSums::ZERO; N];
            self.group::<PLAIN, 1>(at, &mut cell);
            all.iter_mut().zip(&cell).for_each(|(sums, cell)| sums.add(at % LANES, cell));
        }
        all.map(|sums| sums.sums())
    }

    /// Updates a group of cells of one or two species. The number of species is constant, so sums stay in registers.
    #[inline(always)]
    fn group<const PLAIN: bool, const W: usize>(&mut self, at: usize, sums: &mut [SpeciesLaneSums<T, W>; N]) {
        let mut values = [[T::ZERO; W]; N];
        values[0] = load(self.cells[0].value, at);
        if N > 1 {
            values[1] = load(self.cells[1].value, at);
        }
        let rates = self.rates.rates(at, &values);
        self.species::<PLAIN, W>(0, at, &values[0], &rates[0], &mut sums[0]);
        if N > 1 {
            self.species::<PLAIN, W>(1, at, &values[1], &rates[1], &mut sums[1]);
        }
    }

    #[inline(always)]
    fn species<const PLAIN: bool, const W: usize>(
        &mut self,
        species: usize,
        at: usize,
        y: &[T; W],
        reaction: &[T; W],
        sums: &mut SpeciesLaneSums<T, W>,
    ) {
        let cells = &mut self.cells[species];
        let mut slope: [T; W] = load(cells.diffusion, at);
        for lane in 0..W {
            sums.gain[lane] += larger(T::ZERO, reaction[lane]);
            sums.net[lane] += reaction[lane];
            slope[lane] += reaction[lane];
        }
        let next = if PLAIN { self.stage.plain(y, &slope) } else { self.stage.next(cells, at, y, &slope) };
        for lane in 0..W {
            sums.most[lane] = larger(sums.most[lane], larger(next[lane], -next[lane]));
        }
        store(cells.next, at, &next);
    }
}

impl<T: Real> SpeciesStage<T> {
    /// Whether the next state depends only on Y and its slope, as in Euler's method.
    fn is_plain(&self) -> bool {
        matches!(self.base, Base::Here { keep: false }) && self.count == 0 && self.keep.is_none()
    }

    /// Next state of a plain stage.
    #[inline(always)]
    fn plain<const W: usize>(&self, y: &[T; W], slope: &[T; W]) -> [T; W] {
        let mut next = *y;
        (0..W).for_each(|lane| next[lane] += self.slope * slope[lane]);
        next
    }

    /// Next state from Y, its slope and the stored columns.
    #[inline(always)]
    fn next<const W: usize>(&self, cells: &mut SpeciesCells<'_, T>, at: usize, y: &[T; W], slope: &[T; W]) -> [T; W] {
        let mut next = *y;
        match self.base {
            Base::Here { keep: false } => {}
            Base::Here { keep: true } => store(cells.columns[0], at, y),
            Base::Start => next = load(cells.columns[0], at),
            Base::Own(_) => {
                next = load(cells.columns[0], at);
                (0..W).for_each(|lane| next[lane] += self.own * (y[lane] - next[lane]));
            }
            Base::Recurrence(..) => {
                let before: [T; W] = load(cells.next, at);
                let start: [T; W] = load(cells.columns[0], at);
                for lane in 0..W {
                    next[lane] = start[lane] + (self.own * (y[lane] - start[lane]) + self.other * (before[lane] - start[lane]));
                }
            }
        }
        let mut change = [T::ZERO; W];
        (0..W).for_each(|lane| change[lane] = self.slope * slope[lane]);
        for index in 0..self.count {
            let (kept, weight): ([T; W], T) = (load(cells.columns[1 + index], at), self.slopes[index]);
            (0..W).for_each(|lane| change[lane] += weight * kept[lane]);
        }
        if let Some(keep) = self.keep {
            store(cells.columns[1 + keep], at, slope);
        }
        (0..W).for_each(|lane| next[lane] += change[lane]);
        next
    }
}

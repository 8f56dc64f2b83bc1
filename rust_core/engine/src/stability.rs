//! The largest time step: a certified bound from the stiffness and damping of all terms, and a sharper one as they stand.
//!
//! Linearized about any state, a scene obeys M x'' + C x' + K x = 0 with symmetric K and C. Three facts make a bound:
//!
//! 1. **A mode is an oscillator.** For an eigenvector u of the step, the one-step maps of this crate reduce to their own
//!    scalar map with ω² = u*Ku/u*Mu and γ = u*Cu/u*Mu: Runge–Kutta methods, because they are functions of the
//!    Jacobian, whose eigenvalues obey λ² + γλ + ω² = 0; semi-implicit Euler and Verlet, because the matrices of their
//!    characteristic equations are linear in K and C. Both quotients lie below the largest eigenvalues of M⁻¹K and
//!    M⁻¹C. Splittings of several stages multiply K by C, and so reduce only where they commute: without damping, or with
//!    the same γ for all. Elsewhere their bound is measured, not proved, and has the margin [`Integrator::COUPLED`].
//! 2. **Rows bound the eigenvalues**: see [`rows`]. Bodies share no spring, so each has a bound of its own. A negative ω²
//!    (a buckling spring) grows in truth as well, and limits no step. Rows know no directions, so that they hold while the
//!    springs turn; as the springs stand, the eigenvalues may be half of that, and [`Bound::sharpened`] finds them ([`lanczos`]).
//! 3. **The box of modes.** All modes of a body have ω ≤ Ω and Γ₀ ≤ γ ≤ Γ. Along a ray of constant ξ = γ/2ω the limit
//!    is L(ξ)/ω, so it is smallest where the ray leaves the box, at ω = min(Ω, Γ/2ξ). That leaves one minimum over ξ.

mod lanczos;
mod rows;

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::integrators::{Integrator, VelocityVerlet, amplification};
use lanczos::Edge;
use rows::{Row, Rows};

/// What sets the largest time step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A larger step would let the solution grow without bound.
    Stability,
    /// A larger step would be stable and wrong.
    Accuracy,
    /// Nothing does.
    None,
}

/// The largest time step, and what sets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The largest stable step [s]: infinite where nothing limits it, 0 where no step is stable.
    pub stability: f64,
    /// The largest accurate step [s]: infinite where nothing limits it.
    pub accuracy: f64,
    /// The term that binds, empty where none does: `springs`, `spring damping`, `drag`, `central`.
    pub term: &'static str,
    /// Which of the two binds.
    pub kind: Kind,
    /// The largest step that is stable wherever the springs turn [s]; smaller than the other where that was sharpened.
    pub certified: f64,
}

impl Limit {
    /// The largest step [s]: infinite where nothing limits it, 0 where no step is stable.
    pub fn dt(&self) -> f64 {
        self.stability.min(self.accuracy)
    }
}

/// A spring as it stands.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// From one end to the other [m].
    pub offset: DVec3,
    /// l₀ [m].
    pub rest_length: f64,
    /// k [N/m].
    pub stiffness: f64,
    /// c, along the spring [N·s/m].
    pub damping: f64,
}

/// What the terms of a scene contribute to the bound.
#[derive(Debug, Clone)]
pub struct Bound {
    /// 1/m [1/kg], 0 where fixed.
    inverse_mass: Vec<f64>,
    body: Vec<u32>,
    stiffness: Rows,
    damping: Rows,
    /// Whether the springs' directions are noted, which takes longer than the rest.
    directed: bool,
    stiffness_edges: Vec<Edge>,
    damping_edges: Vec<Edge>,
    /// About the largest ω² and γ of each body; empty before they are looked for.
    spectra: [Vec<f64>; 2],
    /// What of the damping acts on each particle in every direction and at any speed [N·s/m]; empty if nowhere.
    least_damping: Vec<f64>,
    accuracy: Option<(&'static str, f64)>,
    present: bool,
    /// [`Integrator::limit`].
    largest: fn(f64) -> f64,
    /// [`Integrator::oscillator`].
    oscillator: fn(f64, f64, f64) -> [f64; 2],
}

impl Bound {
    /// A bound without terms, for particles of these masses [kg], infinite where fixed, that belong to these bodies.
    pub fn new(mass: &[f64], body: &[u32]) -> Self {
        Self {
            inverse_mass: mass.iter().map(|mass| mass.recip()).collect(),
            body: body.to_vec(),
            stiffness: Rows::new("springs"),
            damping: Rows::new("spring damping"),
            directed: false,
            stiffness_edges: Vec::new(),
            damping_edges: Vec::new(),
            spectra: [const { Vec::new() }; 2],
            least_damping: Vec::new(),
            accuracy: None,
            present: false,
            largest: VelocityVerlet::limit,
            oscillator: VelocityVerlet::oscillator,
        }
    }

    /// The same for the waves of a field as this integrator advances them; without this, as velocity Verlet does.
    #[must_use]
    pub fn stepped_by<I: Integrator>(self) -> Self {
        Self { largest: I::limit, oscillator: I::oscillator, ..self }
    }

    /// Of waves in a field the one that asks for the shortest step, as the ω² [1/s²] and γ [1/s] of an oscillator of that
    /// step. A wave is its frequency, the damping of its velocity and the decay of its field [1/s].
    pub fn shortest(&self, waves: impl Iterator<Item = [f64; 3]>) -> [f64; 2] {
        let oscillators = waves.map(|[frequency, damping, decay]| (self.oscillator)(frequency, damping, decay));
        let timed = oscillators.map(|[frequency, damping]| {
            let step = (self.largest)(0.5 * damping / frequency) / frequency;
            (step, [frequency * frequency, damping])
        });
        timed.min_by(|(one, _), (other, _)| one.total_cmp(other)).map_or([0.0; 2], |(_, oscillator)| oscillator)
    }

    /// The same, which can be [`Bound::sharpened`].
    pub fn directed(mass: &[f64], body: &[u32]) -> Self {
        Self { directed: true, ..Self::new(mass, body) }
    }

    /// The same for one step from the present state, not for all of the motion ahead.
    pub fn at_present(mass: &[f64], body: &[u32]) -> Self {
        Self { present: true, ..Self::new(mass, body) }
    }

    /// Whether it is for one step from the present state.
    pub fn is_present(&self) -> bool {
        self.present
    }

    /// Whether it has to hold for a while from now on, and not only as matters stand.
    pub fn is_ahead(&self) -> bool {
        !self.directed && !self.present
    }

    /// A spring between two particles of one body.
    ///
    /// Its stiffness across is k (1 − l₀/l) at the length l. That lies between −k and k while l ≥ l₀/2; the row of a shorter
    /// one takes k (l₀/l − 1). Without a length it has no direction, and the matrix takes k, and c, in all.
    pub fn spring(&mut self, i: usize, j: usize, link: &Link) {
        if self.inverse_mass[i] == 0.0 && self.inverse_mass[j] == 0.0 {
            return;
        }
        let Link { offset, rest_length, stiffness, damping } = *link;
        let (count, length, ends) = (self.inverse_mass.len(), offset.length(), [i as u32, j as u32]);
        let compression = if length > 0.0 { rest_length / length - 1.0 } else { -1.0 };
        self.stiffness.join(count, i, j, stiffness * compression.max(1.0));
        self.damping.join(count, i, j, damping);
        if self.directed {
            let (direction, damping_across) = if length > 0.0 { (offset / length, 0.0) } else { (DVec3::X, damping) };
            self.stiffness_edges.push(Edge { ends, direction, along: stiffness, across: -stiffness * compression });
            if damping != 0.0 {
                self.damping_edges.push(Edge { ends, direction, along: damping, across: damping_across });
            }
        }
    }

    /// The same with the largest eigenvalues as the springs stand, where they are below the rows.
    #[must_use]
    pub fn sharpened(mut self) -> Self {
        self.spectra = [self.spectrum(&self.stiffness, &self.stiffness_edges), self.spectrum(&self.damping, &self.damping_edges)];
        self
    }

    /// About the largest eigenvalue of each body with springs, infinite for the others.
    fn spectrum(&self, rows: &Rows, edges: &[Edge]) -> Vec<f64> {
        let bodies = self.bodies();
        let around = rows.around(&self.inverse_mass);
        let alone = rows.points(&self.inverse_mass);
        let mut members = vec![Vec::new(); bodies];
        let mut place = Vec::with_capacity(self.body.len());
        for (index, &body) in self.body.iter().enumerate() {
            place.push(members[body as usize].len() as u32);
            members[body as usize].push(index);
        }
        let mut own = vec![Vec::new(); bodies];
        for edge in edges {
            let ends = edge.ends.map(|end| place[end as usize]);
            own[self.body[edge.ends[0] as usize] as usize].push(Edge { ends, ..*edge });
        }
        let of =
            |members: &[usize], value: &dyn Fn(usize) -> f64| members.iter().map(|&index| value(index)).collect::<Vec<f64>>();
        let parts = own.iter().zip(&members);
        let largest = parts.map(|(edges, members)| {
            if edges.is_empty() {
                return f64::INFINITY;
            }
            // In units of a power of two, so that other units of mass change no bit of the roots.
            let unit = power_of_two(members.iter().map(|&index| self.inverse_mass[index]).fold(0.0, f64::max));
            let root = of(members, &|index| (self.inverse_mass[index] / unit).sqrt());
            let alone = of(members, &|index| alone(index) / unit);
            unit * lanczos::largest(edges, &alone, &root, &of(members, &|index| around[index] / unit))
        });
        largest.collect()
    }

    fn bodies(&self) -> usize {
        self.body.iter().max().map_or(0, |&last| last as usize + 1)
    }

    /// A term that acts on one particle: the largest |eigenvalue| of its force's gradient by position [N/m] and by
    /// velocity [N·s/m].
    pub fn point(&mut self, i: usize, term: &'static str, stiffness: f64, damping: f64) {
        if self.inverse_mass[i] > 0.0 {
            self.stiffness.add(self.inverse_mass.len(), i, term, stiffness);
            self.damping.add(self.inverse_mass.len(), i, term, damping);
        }
    }

    /// That part of the damping given to [`Bound::point`] which acts in every direction and at any speed [N·s/m]:
    /// linear drag. Only with it can explicit Euler be stable where there is stiffness.
    pub fn least_damping(&mut self, i: usize, damping: f64) {
        self.least_damping.resize(self.inverse_mass.len(), 0.0);
        self.least_damping[i] += damping;
    }

    /// A step [s] beyond which `term` is no longer accurate.
    pub fn accuracy(&mut self, term: &'static str, dt: f64) {
        if self.accuracy.is_none_or(|(_, least)| dt < least) {
            self.accuracy = Some((term, dt));
        }
    }

    /// The limit for one integrator.
    pub fn limit<I: Integrator>(&self) -> Limit {
        self.limit_after::<I>(&mut Memo::default())
    }

    /// The limit as the springs stand, with that which holds wherever they turn: both out of one bound.
    pub fn sharp_limit<I: Integrator>(self) -> Limit {
        let certified = self.limit::<I>().stability;
        Limit { certified, ..self.sharpened().limit::<I>() }
    }

    /// The same as [`Bound::limit`], for one bound after the other.
    pub fn limit_after<I: Integrator>(&self, memo: &mut Memo) -> Limit {
        self.limit_with(I::limit, I::COUPLED, memo)
    }

    /// The limit for an integrator whose largest stable ωh is `largest` of the damping ratio, mode by mode.
    pub fn limit_of(&self, largest: fn(f64) -> f64) -> Limit {
        self.limit_with(largest, 1.0, &mut Memo::default())
    }

    fn limit_with(&self, largest: fn(f64) -> f64, coupled: f64, memo: &mut Memo) -> Limit {
        memo.recall(&self.modes(), |modes| modes.limit(largest, coupled));
        let (stability, binding) =
            memo.0.iter().map(|&(_, limit)| limit).min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, ""));
        let (slowest, accuracy) = self.accuracy.unwrap_or(("", f64::INFINITY));
        let (term, kind) = match stability.min(accuracy) {
            f64::INFINITY => ("", Kind::None),
            dt if dt == stability => (binding, Kind::Stability),
            _ => (slowest, Kind::Accuracy),
        };
        Limit { stability, accuracy, term, kind, certified: stability }
    }

    /// The box of modes of each body, without those that another box encloses.
    fn modes(&self) -> Vec<Modes> {
        let bodies = self.bodies();
        let rows = |rows: &Rows, sharper: &[f64]| {
            let mut rows = rows.largest(&self.inverse_mass, &self.body, bodies);
            rows.iter_mut().zip(sharper).for_each(|(row, &sharper)| row.rate = row.rate.min(sharper));
            rows
        };
        let stiffness = rows(&self.stiffness, &self.spectra[0]);
        let damping = rows(&self.damping, &self.spectra[1]);
        let mut least = vec![if self.least_damping.is_empty() { 0.0 } else { f64::INFINITY }; bodies];
        for ((&damping, &inverse_mass), &body) in self.least_damping.iter().zip(&self.inverse_mass).zip(&self.body) {
            if inverse_mass > 0.0 {
                least[body as usize] = least[body as usize].min(damping * inverse_mass);
            }
        }
        let mut boxes: Vec<Modes> = (stiffness.into_iter().zip(damping).zip(least))
            .map(|((stiffness, damping), least)| Modes { stiffness, damping, least: least.min(damping.rate) })
            .filter(|modes| modes.stiffness.rate > 0.0 || modes.damping.rate > 0.0)
            .collect();
        boxes.sort_by(|one, other| other.stiffness.rate.total_cmp(&one.stiffness.rate));
        let mut outer: Vec<Modes> = Vec::new();
        for modes in boxes {
            if !outer.iter().any(|other| other.damping.rate >= modes.damping.rate && other.least <= modes.least) {
                outer.push(modes);
            }
        }
        outer
    }
}

/// The largest power of two that is not above a positive number.
fn power_of_two(number: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    f64::from_bits(number.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
}

/// The limits that an integrator had for the boxes of modes of the bound before. Most of them stay the same from step to
/// step, and a box with damping takes thousands of trial steps.
#[derive(Debug, Default)]
pub struct Memo(Vec<(Modes, (f64, &'static str))>);

impl Memo {
    /// Becomes that of these boxes; finds the limits of those that are new.
    fn recall(&mut self, boxes: &[Modes], limit: impl Fn(&Modes) -> (f64, &'static str)) {
        let known = std::mem::take(&mut self.0);
        let of = |modes: &Modes| known.iter().find(|(other, _)| other == modes).map_or_else(|| limit(modes), |&(_, found)| found);
        self.0 = boxes.iter().map(|modes| (*modes, of(modes))).collect();
    }
}

/// What encloses the modes of a body: ω² up to one row [1/s²], γ up to another and from a least value [1/s].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Modes {
    stiffness: Row,
    damping: Row,
    least: f64,
}

/// The damping ratio that stands for pure damping: there 2ξL(ξ) has come within 1e-12 of its limit for ξ → ∞.
const PURE_DAMPING: f64 = 1e6;
/// Rays tried on each of the two outer edges. The lowest is then refined between its neighbors, so it only has to lie in
/// the right valley of L. The narrowest are PEFRL's, 0.28 < ξ < 0.32, which counts while the corner of the box lies
/// between that and ξ = 0.5, and then holds four rays; and `BlanesMoan4`'s, 0.10 < ξ < 0.14, which counts up to 0.31 and then
/// holds eight. Against 20,000 rays, no corner of any integrator's box finds a smaller limit than these.
const RAYS: usize = 64;

impl Modes {
    /// The largest stable step, and the term that sets it.
    fn limit(&self, largest: fn(f64) -> f64, coupled: f64) -> (f64, &'static str) {
        let damping = self.damping.rate;
        let by_damping = 2.0 * PURE_DAMPING * largest(PURE_DAMPING) / damping;
        if self.stiffness.rate == 0.0 {
            return (by_damping, self.damping.term);
        }
        let frequency = self.stiffness.rate.sqrt().max(damping / (2.0 * PURE_DAMPING));
        let along = |angle: f64| {
            let ratio = angle.tan().clamp(0.0, PURE_DAMPING);
            // At ξ = 0 without damping the second is 0/0, which `min` passes over.
            largest(ratio) / frequency.min(damping / (2.0 * ratio))
        };
        let corner = (damping / (2.0 * frequency)).atan();
        let stiff = valley(along, (self.least / (2.0 * frequency)).atan(), corner);
        let damped = if damping > 0.0 { valley(along, corner, FRAC_PI_2) } else { f64::INFINITY };
        let row = if largest(0.0) / frequency <= by_damping { self.stiffness } else { self.damping };
        let margin = if self.least < damping { coupled } else { 1.0 };
        (margin * stiff.min(damped), row.term)
    }
}

/// The least value of a function between `low` and `high`.
fn valley(function: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    if low >= high {
        return function(high);
    }
    let at = |ray: usize| if ray == RAYS { high } else { low + (high - low) * ray as f64 / RAYS as f64 };
    let values: Vec<f64> = (0..=RAYS).map(|ray| function(at(ray))).collect();
    let least = (0..=RAYS).min_by(|&one, &other| values[one].total_cmp(&values[other])).unwrap_or(0);
    let refined = amplification::lowest(&function, at(least.saturating_sub(1)), at((least + 1).min(RAYS)));
    values[least].min(function(refined))
}

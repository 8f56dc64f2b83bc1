//! Limit of the time step: a certified bound from the stiffness and damping of all terms, and a sharper bound for the present
//! configuration.
//!
//! Linearized about any state, a scene obeys M x'' + C x' + K x = 0 with symmetric K and C. Three facts make a bound:
//!
//! 1. **A mode is an oscillator.** The one-step maps of this crate reduce to their own scalar map for an eigenvector u of the
//!    step. Here ω² = u*Ku/u*Mu and γ = u*Cu/u*Mu. For Runge–Kutta methods, the reason is that they are functions of the
//!    Jacobian, whose eigenvalues obey λ² + γλ + ω² = 0. For semi-implicit Euler and Verlet, the reason is that the matrices of
//!    their characteristic equations are linear in K and C. Both quotients lie below the largest eigenvalues of M⁻¹K and M⁻¹C.
//!    Splittings of several stages multiply K by C. They reduce only where K and C commute: without damping, or with the same γ
//!    for all. Elsewhere their bound is measured, not proved, and has the margin [`Integrator::COUPLED`].
//! 2. **Rows bound the eigenvalues**: see [`rows`]. Bodies share no spring, so each body has its own bound. A negative ω² (a
//!    buckling spring) is a physical instability and limits no step. Rows do not depend on directions, so they hold while the
//!    springs rotate. For the present directions, the eigenvalues may be half as large. [`SpectralBound::sharpened`] computes
//!    them ([`lanczos`]).
//!
//! 3. **The box of modes.** All modes of a body have ω ≤ Ω and Γ₀ ≤ γ ≤ Γ: see [`modes`]. A particle under harmonic wells and
//!    linear drag alone is an oscillator of its own, with one ω and one γ. Its limit is that of the integrator itself.

mod lanczos;
mod modes;
mod rows;

use std::f64::consts::TAU;

use glam::DVec3;

use crate::integrators::{Facts, Integrator, VelocityVerlet};
use lanczos::SpringEdge;
pub use modes::LimitCache;
use modes::{Modes, OscillatorLimits, SpectralRange};
use rows::{GershgorinRow, GershgorinRows};

/// Maximum number of distinct oscillators with separate limits; they take as long as a few boxes of modes.
const MOST_OSCILLATORS: usize = 256;

/// Name of the term of gyration, the rotation of velocities in magnetic fields.
const GYRATION: &str = "gyration";
/// Number of steps per gyration at an automatic time step.
const STEPS_PER_TURN: f64 = 100.0;

/// Ratio to the true limit within which a bound is called the limit: the uncertainty of the Lanczos method.
const NEARLY: f64 = 1.1;

/// States for which a limit of the time step holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Horizon {
    /// Motion ahead, for the present directions of the springs: the sharpest limit.
    Sharp,
    /// Motion ahead, for all directions of springs with r ≥ l₀/2.
    Certified,
    /// One step from this state.
    Present,
}

/// Kind of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// A larger step is unstable.
    Stability,
    /// A larger step is stable and inaccurate.
    Accuracy,
    /// There is no limit.
    None,
}

/// Largest time step, with the term and the kind that set it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Largest stable step [s]: infinite without limit, 0 where no step is stable.
    pub stability: f64,
    /// Largest accurate step [s]: infinite without limit.
    pub accuracy: f64,
    /// Binding term, empty without limit: `springs`, `spring damping`, `drag`, `central`.
    pub term: &'static str,
    /// Kind of the binding limit.
    pub kind: LimitKind,
    /// Largest step that is stable for all directions of the springs [s]; smaller than `stability` if that was sharpened.
    pub certified: f64,
    /// Upper bound of the stable steps in the present configuration [s]: the true limit is between `stability` and this value.
    /// Infinite if unknown.
    pub endured: f64,
}

impl Limit {
    /// No limit.
    pub const NONE: Self = Self {
        stability: f64::INFINITY,
        accuracy: f64::INFINITY,
        term: "",
        kind: LimitKind::None,
        certified: f64::INFINITY,
        endured: f64::INFINITY,
    };

    /// Largest step [s]: infinite without limit, 0 where no step is stable.
    pub fn dt(&self) -> f64 {
        self.stability.min(self.accuracy)
    }

    /// Limit of a step that consists of `parts` equal parts, each with this limit.
    #[must_use]
    pub fn in_parts(self, parts: usize) -> Self {
        let times = |dt: f64| dt * parts as f64;
        let (stability, accuracy) = (times(self.stability), times(self.accuracy));
        Self { stability, accuracy, certified: times(self.certified), endured: times(self.endured), ..self }
    }

    /// Name of the limit. Beyond a bound of stability a run need not be unstable, unless the limit is known exactly.
    pub fn name(&self) -> &'static str {
        match self.kind {
            LimitKind::Accuracy => "limit of accuracy",
            _ if self.endured <= NEARLY * self.stability => "limit of stability",
            _ => "limit of certain stability",
        }
    }
}

/// Spring in its present configuration.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Vector from one end to the other [m].
    pub offset: DVec3,
    /// Rest length l₀ [m].
    pub rest_length: f64,
    /// Stiffness k [N/m].
    pub stiffness: f64,
    /// Longitudinal damping c [N·s/m].
    pub damping: f64,
}

/// Spectral bound: contributions of the terms of a scene to the bounds of ω² and γ.
#[derive(Debug, Clone)]
pub struct SpectralBound {
    /// Inverse mass 1/m [1/kg]; 0 if fixed.
    inverse_mass: Vec<f64>,
    body: Vec<u32>,
    stiffness: GershgorinRows,
    damping: GershgorinRows,
    horizon: Horizon,
    stiffness_edges: Vec<SpringEdge>,
    damping_edges: Vec<SpringEdge>,
    /// Estimates of the largest ω² and γ of each body, from below and from above; empty before they are computed.
    spectra: [Vec<[f64; 2]>; 2],
    /// Isotropic and constant stiffness [N/m] and damping [N·s/m] of each particle; empty if none.
    steady: Vec<[f64; 2]>,
    accuracy: Option<(&'static str, f64)>,
    /// [`Integrator::limit`].
    largest: fn(f64) -> f64,
    /// [`Integrator::oscillator`].
    oscillator: fn(f64, f64, f64) -> [f64; 2],
    /// [`Integrator::GYRATES`].
    gyrates: bool,
}

impl SpectralBound {
    /// Returns a bound without terms, for particles of these masses [kg], infinite if fixed, in these bodies.
    pub fn new(mass: &[f64], body: &[u32], horizon: Horizon) -> Self {
        Self {
            inverse_mass: mass.iter().map(|mass| mass.recip()).collect(),
            body: body.to_vec(),
            stiffness: GershgorinRows::new("springs"),
            damping: GershgorinRows::new("spring damping"),
            horizon,
            stiffness_edges: Vec::new(),
            damping_edges: Vec::new(),
            spectra: [const { Vec::new() }; 2],
            steady: Vec::new(),
            accuracy: None,
            largest: VelocityVerlet::limit,
            oscillator: VelocityVerlet::oscillator,
            gyrates: false,
        }
    }

    /// Horizon: the states for which the bound holds.
    pub fn horizon(&self) -> Horizon {
        self.horizon
    }

    /// Sets the integrator that advances the waves of a field; the default is velocity Verlet.
    #[must_use]
    pub fn stepped_by(self, facts: &Facts) -> Self {
        Self { largest: facts.limit, oscillator: facts.oscillator, gyrates: facts.gyrates, ..self }
    }

    /// Wave of a field with the smallest stable step, as ω² [1/s²] and γ [1/s] of the oscillator with that limit. A wave is given
    /// by its frequency, the damping of its velocity and the decay of its field [1/s].
    pub fn shortest(&self, waves: impl Iterator<Item = [f64; 3]>) -> [f64; 2] {
        let oscillators = waves.map(|[frequency, damping, decay]| (self.oscillator)(frequency, damping, decay));
        let timed = oscillators.map(|[frequency, damping]| {
            let step = (self.largest)(0.5 * damping / frequency) / frequency;
            (step, [frequency * frequency, damping])
        });
        timed.min_by(|(one, _), (other, _)| one.total_cmp(other)).map_or([0.0; 2], |(_, oscillator)| oscillator)
    }

    /// Adds a spring between two particles of one body.
    ///
    /// Its transverse stiffness is k (1 − l₀/l) at the length l. This lies between −k and k while l ≥ l₀/2; the row of a shorter
    /// spring takes k (l₀/l − 1). At zero length the spring has no direction, and its matrices are isotropic with k and c.
    pub fn spring(&mut self, i: usize, j: usize, link: &Link) {
        if self.inverse_mass[i] == 0.0 && self.inverse_mass[j] == 0.0 {
            return;
        }
        let Link { offset, rest_length, stiffness, damping } = *link;
        let (count, length, ends) = (self.inverse_mass.len(), offset.length(), [i as u32, j as u32]);
        // Finite, so that a spring with k = 0 contributes no stiffness at any length.
        let compression = if length > 0.0 { (rest_length / length - 1.0).min(f64::MAX) } else { -1.0 };
        self.stiffness.join(count, i, j, stiffness * compression.max(1.0));
        self.damping.join(count, i, j, damping);
        if self.horizon == Horizon::Sharp {
            // Directions of springs cost more than the rest.
            let (direction, damping_across) = if length > 0.0 { (offset / length, 0.0) } else { (DVec3::X, damping) };
            self.stiffness_edges.push(SpringEdge { ends, direction, along: stiffness, across: -stiffness * compression });
            if damping != 0.0 {
                self.damping_edges.push(SpringEdge { ends, direction, along: damping, across: damping_across });
            }
        }
    }

    /// Sharpens the bound: computes the largest eigenvalues for the present directions of the springs, where they are below the
    /// rows.
    #[must_use]
    pub fn sharpened(mut self) -> Self {
        self.spectra = [self.spectrum(&self.stiffness, &self.stiffness_edges), self.spectrum(&self.damping, &self.damping_edges)];
        self
    }

    /// Estimates of the largest eigenvalue of each body with springs, from below and from above; 0 and infinite for other bodies.
    fn spectrum(&self, rows: &GershgorinRows, edges: &[SpringEdge]) -> Vec<[f64; 2]> {
        let bodies = self.bodies();
        let row_bounds = rows.at_particles(&self.inverse_mass);
        let alone = rows.points(&self.inverse_mass);
        let mut members = vec![Vec::new(); bodies];
        let mut index_in_body = Vec::with_capacity(self.body.len());
        for (index, &body) in self.body.iter().enumerate() {
            index_in_body.push(members[body as usize].len() as u32);
            members[body as usize].push(index);
        }
        let mut own = vec![Vec::new(); bodies];
        for edge in edges {
            let ends = edge.ends.map(|end| index_in_body[end as usize]);
            own[self.body[edge.ends[0] as usize] as usize].push(SpringEdge { ends, ..*edge });
        }
        let of =
            |members: &[usize], value: &dyn Fn(usize) -> f64| members.iter().map(|&index| value(index)).collect::<Vec<f64>>();
        let parts = own.iter().zip(&members);
        let largest = parts.map(|(edges, members)| {
            if edges.is_empty() {
                return [0.0, f64::INFINITY];
            }
            // In units of a power of two: other units of mass then change no bit of the roots.
            let unit = power_of_two(members.iter().map(|&index| self.inverse_mass[index]).fold(0.0, f64::max));
            let root = of(members, &|index| (self.inverse_mass[index] / unit).sqrt());
            let alone = of(members, &|index| alone(index) / unit);
            lanczos::largest(edges, &alone, &root, &of(members, &|index| row_bounds[index] / unit)).map(|rate| unit * rate)
        });
        largest.collect()
    }

    fn bodies(&self) -> usize {
        self.body.iter().max().map_or(0, |&last| last as usize + 1)
    }

    /// Adds a term that acts on one particle, by the largest |eigenvalue| of the gradient of its force with respect to position
    /// [N/m] and velocity [N·s/m].
    pub fn point(&mut self, i: usize, term: &'static str, stiffness: f64, damping: f64) {
        if self.inverse_mass[i] > 0.0 {
            self.stiffness.add(self.inverse_mass.len(), i, term, stiffness);
            self.damping.add(self.inverse_mass.len(), i, term, damping);
        }
    }

    /// Adds a gyration, the rotation of the velocity of a particle in a magnetic field, of strength |q B| [N·s/m]. It counts as
    /// an oscillator of frequency |q B|/m, unless the integrator rotates velocities itself. Its period limits the accuracy.
    pub fn gyration(&mut self, i: usize, strength: f64) {
        let rate = strength * self.inverse_mass[i];
        if rate > 0.0 {
            if !self.gyrates {
                self.point(i, GYRATION, strength * rate, 0.0);
            }
            self.accuracy(GYRATION, TAU / rate / STEPS_PER_TURN);
        }
    }

    /// Adds the isotropic and constant part of the stiffness [N/m] and damping [N·s/m] given to [`SpectralBound::point`]:
    /// harmonic wells and linear drag. If there is no other part, the particle is an oscillator.
    pub fn steady(&mut self, i: usize, stiffness: f64, damping: f64) {
        self.steady.resize(self.inverse_mass.len(), [0.0; 2]);
        self.steady[i][0] += stiffness;
        self.steady[i][1] += damping;
    }

    /// Adds the largest accurate step of `term` [s].
    pub fn accuracy(&mut self, term: &'static str, dt: f64) {
        if self.accuracy.is_none_or(|(_, least)| dt < least) {
            self.accuracy = Some((term, dt));
        }
    }

    /// Limit for one integrator.
    pub fn limit(&self, facts: &Facts) -> Limit {
        self.limit_after(facts, &mut LimitCache::default())
    }

    /// Limit for the present directions of the springs, with the certified limit for all directions and an upper bound of the
    /// stable steps.
    pub fn sharp_limit(self, facts: &Facts) -> Limit {
        let certified = self.limit(facts).stability;
        let sharpened = self.sharpened();
        let (modes, method) = (sharpened.modes(), OscillatorLimits::of(facts));
        let limit = sharpened.limit_with(&modes, &method, &mut LimitCache::default());
        let endured = modes.iter().map(|modes| modes.endured(&method)).fold(f64::INFINITY, f64::min);
        Limit { certified, endured: endured.max(limit.stability), ..limit }
    }

    /// Computes [`SpectralBound::limit`] with a cache of the limits of the previous bound.
    pub fn limit_after(&self, facts: &Facts, cache: &mut LimitCache) -> Limit {
        self.limit_with(&self.modes(), &OscillatorLimits::of(facts), cache)
    }

    /// Limit for an integrator whose largest stable ωh is the function `largest` of the damping ratio, mode by mode.
    pub fn limit_of(&self, largest: fn(f64) -> f64) -> Limit {
        self.limit_with(&self.modes(), &OscillatorLimits { largest, last: largest, coupled: 1.0 }, &mut LimitCache::default())
    }

    fn limit_with(&self, modes: &[Modes], method: &OscillatorLimits, cache: &mut LimitCache) -> Limit {
        let (stability, binding) = cache.least(modes, method);
        let (slowest, accuracy) = self.accuracy.unwrap_or(("", f64::INFINITY));
        let (term, kind) = match stability.min(accuracy) {
            f64::INFINITY => ("", LimitKind::None),
            dt if dt == stability => (binding, LimitKind::Stability),
            _ => (slowest, LimitKind::Accuracy),
        };
        Limit { stability, accuracy, term, kind, certified: stability, endured: f64::INFINITY }
    }

    /// Boxes of modes of all bodies and of separate oscillators, without boxes enclosed by others.
    fn modes(&self) -> Vec<Modes> {
        let is_oscillator: Vec<bool> = (0..self.steady.len()).map(|i| self.is_oscillator(i)).collect();
        let mut boxes = self.coupled_modes(&is_oscillator);
        boxes.extend(self.oscillators(&is_oscillator));
        boxes.retain(|modes| modes.stiffness.highest.rate > 0.0 || modes.damping.highest.rate > 0.0);
        boxes.sort_by(|one, other| other.stiffness.highest.rate.total_cmp(&one.stiffness.highest.rate));
        let mut outer: Vec<Modes> = Vec::new();
        for modes in boxes {
            if !outer.iter().any(|other| other.enclose(&modes)) {
                outer.push(modes);
            }
        }
        outer
    }

    /// Box of modes of each body, without its separate oscillators.
    fn coupled_modes(&self, is_oscillator: &[bool]) -> Vec<Modes> {
        let bodies = self.bodies();
        let counts = |i: usize| !is_oscillator.get(i).is_some_and(|&is_oscillator| is_oscillator);
        let bands = |rows: &GershgorinRows, sharper: &[[f64; 2]], kind: usize| -> Vec<SpectralRange> {
            let mut least = vec![if kind == 0 || self.steady.is_empty() { 0.0 } else { f64::INFINITY }; bodies];
            for ((steady, &inverse_mass), (i, &body)) in
                self.steady.iter().zip(&self.inverse_mass).zip(self.body.iter().enumerate())
            {
                if inverse_mass > 0.0 && counts(i) {
                    least[body as usize] = least[body as usize].min(steady[kind] * inverse_mass);
                }
            }
            let largest = rows.largest(&self.inverse_mass, &self.body, bodies, counts);
            let sharper = sharper.iter().copied().chain(std::iter::repeat([0.0, f64::INFINITY]));
            let bands = largest.into_iter().zip(least).zip(sharper).map(|((row, least), [reached, sharper])| {
                let highest = GershgorinRow { rate: row.rate.min(sharper), ..row };
                SpectralRange { highest, least: least.min(highest.rate), reached: reached.min(highest.rate) }
            });
            bands.collect()
        };
        let stiffness = bands(&self.stiffness, &self.spectra[0], 0);
        let damping = bands(&self.damping, &self.spectra[1], 1);
        stiffness.into_iter().zip(damping).map(|(stiffness, damping)| Modes { stiffness, damping }).collect()
    }

    /// Whether a particle is an uncoupled oscillator: all its terms are isotropic and constant, and it has no springs.
    fn is_oscillator(&self, i: usize) -> bool {
        [&self.stiffness, &self.damping].into_iter().zip(self.steady[i]).all(|(rows, steady)| rows.alone_at(i) == Some(steady))
    }

    /// Oscillators: the fastest of each damping ratio. If there are too many, one box encloses all of them.
    fn oscillators(&self, separation: &[bool]) -> Vec<Modes> {
        let of = |i: usize| {
            let band = |rows: &GershgorinRows, value: f64| {
                SpectralRange::exactly(GershgorinRow { rate: value * self.inverse_mass[i], term: rows.leading(i) })
            };
            let [stiffness, damping] = self.steady[i];
            Modes { stiffness: band(&self.stiffness, stiffness), damping: band(&self.damping, damping) }
        };
        let rates = |modes: &Modes| (modes.stiffness.least, modes.damping.least);
        let ratio = |modes: &Modes| (modes.damping.least / modes.stiffness.least.sqrt()).to_bits();
        let (mut all, mut fastest): (Option<Modes>, Vec<Modes>) = (None, Vec::new());
        for i in (0..separation.len()).filter(|&i| self.inverse_mass[i] > 0.0 && separation[i]) {
            let modes = of(i);
            all = Some(all.map_or(modes, |all| all.with(&modes)));
            if fastest.len() > MOST_OSCILLATORS || rates(&modes) == (0.0, 0.0) {
                continue;
            }
            match fastest.iter_mut().rev().find(|other| ratio(other) == ratio(&modes)) {
                Some(other) if rates(&modes) > rates(other) => *other = modes,
                Some(_) => {}
                None => fastest.push(modes),
            }
        }
        if fastest.len() > MOST_OSCILLATORS { all.into_iter().collect() } else { fastest }
    }
}

/// Largest power of two that is not above a positive number.
fn power_of_two(number: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    f64::from_bits(number.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
}

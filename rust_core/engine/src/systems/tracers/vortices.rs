//! Point vortices in the plane. Each moves with the velocity that the others induce there, tracers with the velocity of all.
//!
//! ```text
//!     v(x) = Σ Γⱼ/(2π) e_z × (x − xⱼ)/(|x − xⱼ|² + δ²),   H = −1/(4π) Σ_{i<j} Γᵢ Γⱼ ln(|xᵢ − xⱼ|² + δ²)
//! ```
//!
//! Tracers do not act on vortices. Vortices therefore take all steps of a batch first. Their positions at each stage are kept
//! for the tracers, which are advanced in the same stages: [`VortexCoupling`](super::coupling::VortexCoupling).
//!
//! Sources: G. Kirchhoff, Vorlesungen über mathematische Physik (1876), lecture 20; P. G. Saffman, Vortex Dynamics (1992),
//! chapter 7; for the core δ: R. Krasny, J. Comput. Phys. 65 (1986) 292.

use std::f64::consts::{PI, TAU};

use super::flow::Flow;
use super::law::{self, Outcome, VelocityLaw};
use super::points::Points;
use super::staged::{Staged, Step};
use crate::error::{Error, Result};
use crate::integrators::explicit::Coefficients;
use crate::math::Real;
use crate::parallel::{Executor, SERIAL};
use crate::scene::Item;
use crate::simd::Number;
use crate::systems::Interval;

/// Maximum number of coordinates kept for the tracers of a batch.
const KEPT: usize = 1 << 18;

/// Strengths and cores of the vortices of an item.
#[derive(Debug, Clone)]
pub struct VortexStrengths<T> {
    /// Circulations Γ [m²/s].
    circulations: Vec<f64>,
    /// Strengths Γ/(2π) [m²/s].
    strengths: Vec<T>,
    /// Square of the core, δ² [m²].
    core: T,
}

impl<T: Real> VortexStrengths<T> {
    /// Reads the strengths that an item declares for vortices at some points.
    ///
    /// # Errors
    /// If a value is missing or out of range, or two vortices without a core are in the same place.
    pub fn declared(item: &Item, points: &Points<T, 2>) -> Result<Self> {
        let circulations = item.numbers("circulations", points.count)?.to_vec();
        let core = item.non_negative("core")?;
        let strengths: Vec<T> = circulations.iter().map(|circulation| T::from_f64(circulation / TAU)).collect();
        if let Some(index) = strengths.iter().position(|strength| !strength.is_finite()) {
            let path = format!("circulations[{index}]");
            return Err(item.wrong(&path, &format!("a number that {} holds", T::NAME), None));
        }
        let square = T::from_f64(core * core);
        if !square.is_finite() {
            return Err(item.wrong("core", &format!("a number whose square {} holds", T::NAME), item.values.get("core")));
        }
        if square == T::ZERO {
            apart(item, points)?;
        }
        Ok(Self { circulations, strengths, core: square })
    }

    /// Law of velocity of vortices at these positions, or at those of each stage, one after the other.
    fn law<'a>(&'a self, places: [&'a [T]; 2]) -> VortexLaw<'a, T> {
        VortexLaw { places, strengths: &self.strengths, core: self.core }
    }

    /// Estimated duration of an evaluation at a point [s]: a division per vortex.
    fn cost(&self) -> f64 {
        3e-10 * size_of::<T>() as f64 * self.strengths.len() as f64
    }

    fn bytes(&self) -> usize {
        size_of_val(self.strengths.as_slice()) + size_of_val(self.circulations.as_slice())
    }
}

/// Coordinates of points, without padding.
fn places<T>(points: &Points<T, 2>) -> [&[T]; 2] {
    points.axes.each_ref().map(|axis| &axis[..points.count])
}

/// Flow of vortices, in which they move themselves.
pub struct Vortices<T> {
    pub strengths: VortexStrengths<T>,
    staged: Staged<T, 2>,
    /// Coordinates of the vortices at each stage of a batch, one stage after the other.
    pub kept: [Vec<T>; 2],
}

impl<T: Real> Vortices<T> {
    /// Builds the vortices that an item declares, with their positions.
    ///
    /// # Errors
    /// As [`VortexStrengths::declared`].
    pub fn declared(item: &Item, points: &Points<T, 2>) -> Result<Self> {
        let strengths = VortexStrengths::declared(item, points)?;
        Ok(Self { strengths, staged: Staged::new(points.count), kept: [Vec::new(), Vec::new()] })
    }
}

/// Flow of vortices of another system, in which tracers move.
pub struct InducedFlow<T> {
    strengths: VortexStrengths<T>,
    /// Present coordinates of the vortices.
    pub present: Points<T, 2>,
    /// Coordinates of the vortices at each stage of the steps to be taken, one stage after the other.
    pub stages: [Vec<T>; 2],
}

impl<T: Real> InducedFlow<T> {
    /// Builds the flow of the vortices that an item declares, with their positions.
    ///
    /// # Errors
    /// As [`VortexStrengths::declared`].
    pub fn declared(item: &Item, present: Points<T, 2>) -> Result<Self> {
        Ok(Self { strengths: VortexStrengths::declared(item, &present)?, present, stages: [Vec::new(), Vec::new()] })
    }
}

/// Refuses two points in the same place.
fn apart<T: Real>(item: &Item, points: &Points<T, 2>) -> Result<()> {
    let place = |index: usize| points.axes.each_ref().map(|axis| axis[index].to_f64());
    let mut order: Vec<usize> = (0..points.count).collect();
    order.sort_by(|&one, &other| {
        let ([x, y], [u, v]) = (place(one), place(other));
        x.total_cmp(&u).then(y.total_cmp(&v)).then(one.cmp(&other))
    });
    match order.windows(2).find(|pair| place(pair[0]) == place(pair[1])) {
        None => Ok(()),
        Some(pair) => {
            let path = format!("{}.centers[{}]", item.path, pair[1]);
            let found = format!("that of vortex {}, {:?}", pair[0], place(pair[1]));
            Err(Error::parameter(path, "a place of its own", found)
                .with_hint("their velocity is infinite there; give them a core > 0"))
        }
    }
}

/// Law of velocity of vortices with these positions at each stage.
#[derive(Debug, Clone, Copy)]
struct VortexLaw<'a, T> {
    places: [&'a [T]; 2],
    strengths: &'a [T],
    core: T,
}

impl<T: Real> VortexLaw<'_, T> {
    /// Positions of the vortices at a stage.
    #[inline(always)]
    fn places(&self, stage: usize) -> [&[T]; 2] {
        let count = self.strengths.len();
        [&self.places[0][stage * count..][..count], &self.places[1][stage * count..][..count]]
    }

    /// Offset from a vortex, 1/(|offset|² + δ²), and Γ/(2π) times that. The last two are 0 at its center, so that it does not
    /// move itself.
    #[inline(always)]
    fn swirl<N: Number<Scalar = T>>(&self, [x, y]: [N; 2], place: [T; 2], strength: T) -> ([N; 2], N, N) {
        let offset = [x - N::of(place[0]), y - N::of(place[1])];
        let (zero, distance) = (N::constant(0.0), offset[0] * offset[0] + offset[1] * offset[1]);
        let inverse = (N::constant(1.0) / (distance + N::of(self.core))).masked(zero.less(distance));
        (offset, inverse, N::of(strength) * inverse)
    }
}

impl<T: Real> VelocityLaw<T, 2> for VortexLaw<'_, T> {
    #[inline(always)]
    fn velocity<N: Number<Scalar = T>>(&self, stage: usize, point: [N; 2]) -> [N; 2] {
        let ([xs, ys], zero) = (self.places(stage), N::constant(0.0));
        let (mut u, mut v) = (zero, zero);
        for ((&x, &y), &strength) in xs.iter().zip(ys).zip(self.strengths) {
            let ([dx, dy], _, rate) = self.swirl(point, [x, y], strength);
            u = u - dy * rate;
            v += dx * rate;
        }
        [u, v]
    }

    #[inline(always)]
    fn gradient<N: Number<Scalar = T>>(&self, stage: usize, point: [N; 2]) -> [[N; 2]; 2] {
        let ([xs, ys], zero, two) = (self.places(stage), N::constant(0.0), N::constant(2.0));
        let mut gradient = [[zero; 2]; 2];
        for ((&x, &y), &strength) in xs.iter().zip(ys).zip(self.strengths) {
            let ([dx, dy], inverse, rate) = self.swirl(point, [x, y], strength);
            let fall = two * rate * inverse;
            let mixed = fall * dx * dy;
            gradient[0][0] += mixed;
            gradient[0][1] += fall * dy * dy - rate;
            gradient[1][0] += rate - fall * dx * dx;
            gradient[1][1] = gradient[1][1] - mixed;
        }
        gradient
    }
}

/// Name of the flow, for plans.
const NAME: &str = "point vortices";
/// Description of the layout, for plans.
const LAYOUT: &str = "vortices stage by stage, then blocks of tracers in the cache, each through all steps of a batch";

impl<T: Real> Flow<T, 2> for Vortices<T> {
    fn name(&self) -> &'static str {
        NAME
    }

    fn cost(&self) -> f64 {
        self.strengths.cost()
    }

    fn most_steps(&self, evaluations: usize) -> u64 {
        (KEPT / (evaluations * self.strengths.strengths.len().max(1))).max(1) as u64
    }

    fn layout(&self) -> &'static str {
        LAYOUT
    }

    fn advance(
        &mut self,
        method: Coefficients,
        points: &mut Points<T, 2>,
        interval: Interval,
        executor: &Executor,
    ) -> Result<Outcome> {
        let Interval { h, steps, .. } = interval;
        let Self { strengths, staged, kept } = self;
        kept.iter_mut().for_each(Vec::clear);
        let mut outcome = Outcome::default();
        for _ in 0..steps {
            let slope = |_: usize, state: &Points<T, 2>, out: &mut Points<T, 2>| {
                kept.iter_mut().zip(places(state)).for_each(|(kept, places)| kept.extend_from_slice(places));
                law::velocities(strengths.law(places(state)), 0, state, out, executor);
                executor.check()
            };
            outcome = outcome.and(staged.step(method, points, Step { h, estimated: steps == 1 }, slope)?);
        }
        Ok(outcome)
    }

    fn velocities(&self, points: &Points<T, 2>, _time: f64) -> Result<Points<T, 2>> {
        let mut out = points.clone();
        law::velocities(self.strengths.law(places(points)), 0, points, &mut out, &SERIAL);
        Ok(out)
    }

    fn steepest(&self, points: &Points<T, 2>, _time: f64, executor: &Executor) -> Result<f64> {
        let steepest = law::steepest(self.strengths.law(places(points)), 0, points, executor);
        executor.check()?;
        Ok(steepest)
    }

    fn hamiltonian(&self, points: &Points<T, 2>) -> Option<f64> {
        let VortexStrengths { circulations, core, .. } = &self.strengths;
        let [x, y] = &points.axes;
        let apart = |axis: &[T], one: usize, other: usize| axis[one].to_f64() - axis[other].to_f64();
        let pair = |one: usize, other: usize| {
            let square = apart(x, one, other).powi(2) + apart(y, one, other).powi(2) + core.to_f64();
            circulations[one] * circulations[other] * libm::log(square)
        };
        let with_earlier = |one: usize| (0..one).map(|other| pair(one, other)).sum::<f64>();
        Some(-(0..points.count).map(with_earlier).sum::<f64>() / (4.0 * PI))
    }

    fn bytes(&self) -> usize {
        let kept: usize = self.kept.iter().map(|axis| size_of_val(axis.as_slice())).sum();
        kept + self.staged.bytes() + self.strengths.bytes()
    }
}

impl<T: Real> Flow<T, 2> for InducedFlow<T> {
    fn name(&self) -> &'static str {
        NAME
    }

    fn cost(&self) -> f64 {
        self.strengths.cost()
    }

    fn layout(&self) -> &'static str {
        LAYOUT
    }

    fn advance(
        &mut self,
        method: Coefficients,
        points: &mut Points<T, 2>,
        interval: Interval,
        executor: &Executor,
    ) -> Result<Outcome> {
        let law = self.strengths.law(self.stages.each_ref().map(Vec::as_slice));
        let outcome = law::advance(law, method, points, interval.h, interval.steps, executor);
        executor.check()?;
        Ok(outcome)
    }

    fn velocities(&self, points: &Points<T, 2>, _time: f64) -> Result<Points<T, 2>> {
        let mut out = points.clone();
        law::velocities(self.strengths.law(places(&self.present)), 0, points, &mut out, &SERIAL);
        Ok(out)
    }

    fn steepest(&self, points: &Points<T, 2>, _time: f64, executor: &Executor) -> Result<f64> {
        let steepest = law::steepest(self.strengths.law(places(&self.present)), 0, points, executor);
        executor.check()?;
        Ok(steepest)
    }

    fn bytes(&self) -> usize {
        let stages: usize = self.stages.iter().map(|axis| size_of_val(axis.as_slice())).sum();
        stages + self.present.bytes() + self.strengths.bytes()
    }
}

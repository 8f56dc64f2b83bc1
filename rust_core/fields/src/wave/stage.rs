//! One stage of a step, cell by cell.

use super::state::WaveCells;
use crate::grid::{Groups, PlaneRow, load};
use crate::integrators::REGISTERS;
use crate::integrators::{Component, ComponentGroup, Facts, Integrator, Swept};
use crate::math::Real;
use crate::simd::{Isa, Kernel, LANES, dispatch};

/// Operation of a stage on the state.
#[derive(Debug, Clone, Copy)]
pub enum WaveStageAction {
    /// Fills the persistent registers at the start of a run.
    Begin,
    /// Computes the state of the first stage.
    Start,
    /// Updates the state by the acceleration of a stage, then computes the state of the next stage. After the last stage, the
    /// next one is the first, unless the batch ends.
    Update { stage: usize, ends: bool },
}

/// Input of a stage.
#[derive(Debug)]
pub struct Input<'a, T, A> {
    /// Displacement u.
    pub displacement: &'a [T],
    /// Rate and persistent registers at the start of a batch; later they are in the cells.
    pub rate: &'a [T],
    pub persistent: [&'a [T]; REGISTERS],
    /// Acceleration without damping.
    pub acceleration: A,
    /// Damping γ; None if the stage does not need the rate.
    pub damping: Option<&'a [T]>,
}

impl<'a, T> Input<'a, T, ()> {
    /// Adds accelerations to the input.
    pub fn with<A>(self, acceleration: A) -> Input<'a, T, A> {
        let Self { displacement, rate, persistent, damping, .. } = self;
        Input { displacement, rate, persistent, acceleration, damping }
    }
}

/// Sums over the cells.
#[derive(Debug, Clone, Copy, Default)]
pub struct WaveSums {
    /// Sum Σ v² at the end of a step; NaN if the batch ends and u is not finite.
    pub squares: f64,
    /// Sum Σ γ v² at the stage.
    pub damping: f64,
}

/// Stage function for cells whose accelerations are in a buffer.
pub type BufferedStage<T> = fn(&Facts, WaveCells<'_, T>, Input<'_, T, &[T]>, f64, WaveStageAction) -> WaveSums;
/// Stage function that computes the accelerations of its cells.
type FusedStage<T> = fn(&Facts, WaveCells<'_, T>, Input<'_, T, PlaneRow<'_, T>>, f64, WaveStageAction) -> WaveSums;

/// Kernels of an integrator.
#[derive(Debug)]
pub struct Kernels<T> {
    pub buffered: BufferedStage<T>,
    /// Fused kernel, if it is faster: in double precision, with drifts by register.
    pub fused: Option<FusedStage<T>>,
}

impl<T: Real> Kernels<T> {
    /// Returns the kernels of an integrator.
    pub fn of<I: Integrator>() -> Self {
        let fused: Option<FusedStage<T>> = if const { size_of::<T>() == 8 && I::Swept::DRIFT_REGISTER.is_some() } {
            Some(|method, cells, input, h, action| run::<T, I::Swept, _>(method, cells, input, h, action))
        } else {
            None
        };
        Self { buffered: |method, cells, input, h, action| run::<T, I::Swept, _>(method, cells, input, h, action), fused }
    }
}

/// Runs a stage for some cells.
fn run<T: Real, S: Swept, A: Groups<T>>(
    method: &Facts,
    cells: WaveCells<'_, T>,
    input: Input<'_, T, A>,
    h: f64,
    action: WaveStageAction,
) -> WaveSums {
    dispatch(WaveStage { cells, input, h: T::from_f64(h), action, stages: method.stages(), swept: S::of(method) })
}

/// Number of columns besides the displacement that stages hold without damping.
pub fn columns(method: &Facts) -> usize {
    if method.drifts_by_register().is_some() { 1 } else { 1 + method.registers }
}

/// Whether a register is kept from one stage to the next.
const fn is_kept<S: Swept>(register: usize) -> bool {
    match S::DRIFT_REGISTER {
        Some(velocity) => register == velocity,
        None => register < S::REGISTERS,
    }
}

struct WaveStage<'a, T, S, A> {
    cells: WaveCells<'a, T>,
    input: Input<'a, T, A>,
    h: T,
    action: WaveStageAction,
    /// Number of stages of a step.
    stages: usize,
    swept: S,
}

#[inline(always)]
fn store<T: Real, const W: usize>(column: &mut [T], at: usize, lanes: &[T; W]) {
    column[at..at + W].copy_from_slice(lanes);
}

/// Sums by lane: cell i of a row adds to lane i mod 16, whether it is computed in a group or alone.
#[derive(Clone, Copy)]
struct WaveLaneSums<T, const W: usize = LANES> {
    squares: [T; W],
    damping: [T; W],
}

impl<T: Real, const W: usize> WaveLaneSums<T, W> {
    const ZERO: Self = Self { squares: [T::ZERO; W], damping: [T::ZERO; W] };

    /// Sums over all lanes, in pairs; the second sum is 0 without damping.
    #[inline(always)]
    fn sums(self, damped: bool) -> WaveSums {
        let sum = |lanes: [T; W]| {
            let mut sums = lanes.map(T::to_f64);
            let mut count = W;
            while count > 1 {
                count /= 2;
                for lane in 0..count {
                    sums[lane] += sums[lane + count];
                }
            }
            sums[0]
        };
        WaveSums { squares: sum(self.squares), damping: if damped { sum(self.damping) } else { 0.0 } }
    }
}

impl<T: Real> WaveLaneSums<T> {
    /// Adds the sums of a single cell.
    fn add(&mut self, lane: usize, cell: WaveLaneSums<T, 1>) {
        self.squares[lane] += cell.squares[0];
        self.damping[lane] += cell.damping[0];
    }
}

impl<T: Real, S: Swept, A: Groups<T>> Kernel for WaveStage<'_, T, S, A> {
    type Output = WaveSums;

    #[inline(always)]
    fn run<L: Isa>(mut self, _isa: L) -> WaveSums {
        match self.action {
            WaveStageAction::Begin => self.begin(),
            WaveStageAction::Start => {
                self.start();
                WaveSums::default()
            }
            WaveStageAction::Update { stage, ends } => match stage.min(S::COMPILED - 1) {
                0 => self.update::<0>(stage, ends),
                1 => self.update::<1>(stage, ends),
                2 => self.update::<2>(stage, ends),
                3 => self.update::<3>(stage, ends),
                4 => self.update::<4>(stage, ends),
                _ => self.update::<5>(stage, ends),
            },
        }
    }
}

impl<T: Real, S: Swept, A: Groups<T>> WaveStage<'_, T, S, A> {
    #[inline(always)]
    fn begin(&mut self) -> WaveSums {
        let mut sums = WaveLaneSums::<T>::ZERO;
        for at in 0..self.cells.rate.len() {
            let Self { cells, input, .. } = self;
            let (x, v) = (load::<T, 1>(input.displacement, at), load::<T, 1>(cells.rate, at));
            let mut a = input.acceleration.any(at);
            if let Some(gamma) = input.damping {
                let mut cell = WaveLaneSums::ZERO;
                damp(&mut a, &load(gamma, at), &v, &mut cell.damping);
                sums.add(at % LANES, cell);
            }
            let mut group = ComponentGroup::new(x, v, |_| [T::ZERO]);
            group.each(|component, _| S::begin(component, a[0]));
            store(cells.displacement, at, &x);
            (0..S::PERSISTENT).for_each(|register| store(cells.registers[register], at, &group.register(register)));
        }
        sums.sums(true)
    }

    #[inline(always)]
    fn start(&mut self) {
        let count = self.cells.rate.len();
        let whole = count / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            self.start_group::<LANES>(at);
        }
        for at in whole..count {
            self.start_group::<1>(at);
        }
    }

    #[inline(always)]
    fn start_group<const W: usize>(&mut self, at: usize) {
        let Self { cells, input, h, swept, .. } = self;
        let registers =
            |register: usize| if register < S::PERSISTENT { load(input.persistent[register], at) } else { [T::ZERO; W] };
        let mut group = ComponentGroup::new(load(input.displacement, at), load(input.rate, at), registers);
        let first = swept.at(0);
        group.each(|component, _| S::state(first, 0, component, *h));
        keep::<T, S, W>(cells, &group, at, input.damping.is_some());
    }

    /// Updates by a stage: the one compiled as `STAGE`, or any stage with coefficients at run time.
    #[inline(always)]
    fn update<const STAGE: usize>(&mut self, stage: usize, ends: bool) -> WaveSums {
        const { assert!(S::COMPILED <= 6, "more stages than are written out") };
        // Conditions on constants in blocks, so only existing stages are compiled.
        if const { STAGE >= S::COMPILED } {
            return WaveSums::default();
        }
        let last = if const { S::COMPILED > 1 } { STAGE + 1 == S::COMPILED } else { stage + 1 == self.stages };
        let both = [self.swept.at(stage), self.swept.at(if last { 0 } else { stage + 1 })];
        if const { S::COMPILED > 1 && STAGE + 1 < S::COMPILED } || !last {
            return self.update_cells::<STAGE, false, false>(both);
        }
        if ends { self.update_cells::<STAGE, true, true>(both) } else { self.update_cells::<STAGE, true, false>(both) }
    }

    #[inline(always)]
    fn update_cells<const STAGE: usize, const LAST: bool, const ENDS: bool>(&mut self, both: [S::At; 2]) -> WaveSums {
        let mut sums = WaveLaneSums::ZERO;
        let count = self.cells.rate.len();
        let whole = count / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            let acceleration = &self.input.acceleration;
            // Two calls: waiting for the choice of accelerations would cost a tenth in double precision.
            if acceleration.is_inner::<LANES>(at) {
                self.update_group::<STAGE, LAST, ENDS, LANES>(both, at, acceleration.inner(at), &mut sums);
            } else {
                self.update_group::<STAGE, LAST, ENDS, LANES>(both, at, acceleration.any(at), &mut sums);
            }
        }
        for at in whole..count {
            let mut cell = WaveLaneSums::ZERO;
            self.update_group::<STAGE, LAST, ENDS, 1>(both, at, self.input.acceleration.any(at), &mut cell);
            sums.add(at % LANES, cell);
        }
        sums.sums(self.input.damping.is_some())
    }

    #[inline(always)]
    fn update_group<const STAGE: usize, const LAST: bool, const ENDS: bool, const W: usize>(
        &mut self,
        [now, next]: [S::At; 2],
        at: usize,
        mut a: [T; W],
        sums: &mut WaveLaneSums<T, W>,
    ) {
        let Self { cells, input, h, .. } = self;
        let h = *h;
        let knows_rate = input.damping.is_some() || S::DRIFT_REGISTER.is_none();
        let (x, v) = (load(input.displacement, at), if knows_rate { load(cells.rate, at) } else { [T::ZERO; W] });
        if let Some(gamma) = input.damping {
            damp(&mut a, &load(gamma, at), &v, &mut sums.damping);
        }
        let registers = |register: usize| if is_kept::<S>(register) { load(cells.registers[register], at) } else { [T::ZERO; W] };
        let mut group = ComponentGroup::new(x, v, registers);
        let mut squares = sums.squares;
        group.each(|component: &mut Component<T>, lane| {
            S::update(now, STAGE, component, a[lane], h);
            if LAST {
                squares[lane] += component.v * component.v;
            }
            if ENDS {
                squares[lane] += T::ZERO * component.x;
            } else {
                S::state(next, (STAGE + 1) % S::COMPILED, component, h);
            }
        });
        sums.squares = squares;
        if ENDS {
            store(cells.displacement, at, &group.x);
            store(cells.rate, at, &group.v);
            (0..S::READABLE).for_each(|register| store(cells.registers[register], at, &group.register(register)));
        } else {
            keep::<T, S, W>(cells, &group, at, input.damping.is_some());
        }
    }
}

/// Computes a − γv, and Σ γ v² by lane.
#[inline(always)]
fn damp<T: Real, const W: usize>(a: &mut [T; W], gamma: &[T; W], v: &[T; W], sums: &mut [T; W]) {
    for lane in 0..W {
        let braking = gamma[lane] * v[lane];
        a[lane] -= braking;
        sums[lane] += braking * v[lane];
    }
}

/// Stores the data that the next stage needs.
#[inline(always)]
fn keep<T: Real, S: Swept, const W: usize>(cells: &mut WaveCells<'_, T>, group: &ComponentGroup<T, W>, at: usize, damped: bool) {
    store(cells.displacement, at, &group.x);
    if damped || S::DRIFT_REGISTER.is_none() {
        store(cells.rate, at, &group.v);
    }
    for register in 0..S::REGISTERS {
        if is_kept::<S>(register) {
            store(cells.registers[register], at, &group.register(register));
        }
    }
}

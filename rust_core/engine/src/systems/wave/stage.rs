//! One stage of a step, cell by cell.

use std::marker::PhantomData;

use super::state::Cells;
use crate::grid::{Groups, load};
use crate::integrators::{Component, ComponentGroup, Integrator};
use crate::math::Real;
use crate::matter::REGISTERS;
use crate::simd::{Isa, Kernel, LANES, dispatch};

/// The operation of a stage on the state.
#[derive(Debug, Clone, Copy)]
pub enum Action {
    /// Fills the persistent registers at the start of a run.
    Begin,
    /// Computes the state of the first stage.
    Start,
    /// Updates the state by the acceleration of a stage, then computes the state of the next one; after the last stage that
    /// of the first, unless the batch ends.
    Update { stage: usize, ends: bool },
}

/// What a stage reads.
#[derive(Debug)]
pub struct Input<'a, T, A> {
    /// Displacement u.
    pub displacement: &'a [T],
    /// The rate and the persistent registers at the start of a batch; later they are in the cells.
    pub rate: &'a [T],
    pub persistent: [&'a [T]; REGISTERS],
    /// The acceleration without damping.
    pub acceleration: A,
    /// Damping γ; None where the stage need not know the rate.
    pub damping: Option<&'a [T]>,
}

impl<'a, T> Input<'a, T, ()> {
    /// The same with accelerations.
    pub fn with<A>(self, acceleration: A) -> Input<'a, T, A> {
        let Self { displacement, rate, persistent, damping, .. } = self;
        Input { displacement, rate, persistent, acceleration, damping }
    }
}

/// Sums over the cells.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    /// Σ v² at the end of a step; NaN where the batch ends and u is not finite.
    pub squares: f64,
    /// Σ γ v² at the stage.
    pub damping: f64,
}

/// Runs a stage of some cells.
pub fn run<T: Real, I: Integrator, A: Groups<T>>(cells: Cells<'_, T>, input: Input<'_, T, A>, h: f64, action: Action) -> Sums {
    dispatch(Stage::<T, I, A> { cells, input, h: T::from_f64(h), action, integrator: PhantomData })
}

/// Whether an integrator needs the rate at its stages only where it is damped: the velocity of its drift is in a register,
/// and all else follows from that and the acceleration.
pub const fn drifts_by_register<I: Integrator>() -> Option<usize> {
    match I::DRIFT_KICK {
        Some(drift_kick) if drift_kick.velocity < I::REGISTERS => Some(drift_kick.velocity),
        _ => None,
    }
}

/// The number of columns besides the displacement that stages hold without damping.
pub const fn columns<I: Integrator>() -> usize {
    if drifts_by_register::<I>().is_some() { 1 } else { 1 + I::REGISTERS }
}

/// Whether a register is kept from one stage to the next.
const fn is_kept<I: Integrator>(register: usize) -> bool {
    match drifts_by_register::<I>() {
        Some(velocity) => register == velocity,
        None => register < I::REGISTERS,
    }
}

struct Stage<'a, T, I, A> {
    cells: Cells<'a, T>,
    input: Input<'a, T, A>,
    h: T,
    action: Action,
    integrator: PhantomData<I>,
}

#[inline(always)]
fn store<T: Real, const W: usize>(column: &mut [T], at: usize, lanes: &[T; W]) {
    column[at..at + W].copy_from_slice(lanes);
}

/// Sums lane by lane: cell i of a row adds to lane i mod 16, whether it is computed in a group or alone.
#[derive(Clone, Copy)]
struct LaneSums<T, const W: usize = LANES> {
    squares: [T; W],
    damping: [T; W],
}

impl<T: Real, const W: usize> LaneSums<T, W> {
    const ZERO: Self = Self { squares: [T::ZERO; W], damping: [T::ZERO; W] };

    /// The sums over all lanes, in pairs; the second only where there is damping.
    #[inline(always)]
    fn sums(self, damped: bool) -> Sums {
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
        Sums { squares: sum(self.squares), damping: if damped { sum(self.damping) } else { 0.0 } }
    }
}

impl<T: Real> LaneSums<T> {
    /// Adds those of a single cell.
    fn add(&mut self, lane: usize, cell: LaneSums<T, 1>) {
        self.squares[lane] += cell.squares[0];
        self.damping[lane] += cell.damping[0];
    }
}

impl<T: Real, I: Integrator, A: Groups<T>> Kernel for Stage<'_, T, I, A> {
    type Output = Sums;

    #[inline(always)]
    fn run<S: Isa>(mut self, _isa: S) -> Sums {
        match self.action {
            Action::Begin => self.begin(),
            Action::Start => {
                self.start();
                Sums::default()
            }
            Action::Update { stage, ends } => match stage {
                0 => self.update::<0>(ends),
                1 => self.update::<1>(ends),
                2 => self.update::<2>(ends),
                3 => self.update::<3>(ends),
                4 => self.update::<4>(ends),
                5 => self.update::<5>(ends),
                6 => self.update::<6>(ends),
                7 => self.update::<7>(ends),
                8 => self.update::<8>(ends),
                9 => self.update::<9>(ends),
                _ => self.update::<10>(ends),
            },
        }
    }
}

impl<T: Real, I: Integrator, A: Groups<T>> Stage<'_, T, I, A> {
    #[inline(always)]
    fn begin(&mut self) -> Sums {
        let mut sums = LaneSums::<T>::ZERO;
        for at in 0..self.cells.rate.len() {
            let Self { cells, input, .. } = self;
            let (x, v) = (load::<T, 1>(input.displacement, at), load::<T, 1>(cells.rate, at));
            let mut a = input.acceleration.any(at);
            if let Some(gamma) = input.damping {
                let mut cell = LaneSums::ZERO;
                damp(&mut a, &load(gamma, at), &v, &mut cell.damping);
                sums.add(at % LANES, cell);
            }
            let mut group = ComponentGroup::new(x, v, |_| [T::ZERO]);
            group.each(|component, _| I::begin(component, a[0]));
            store(cells.displacement, at, &x);
            (0..I::PERSISTENT).for_each(|register| store(cells.registers[register], at, &group.register(register)));
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
        let Self { cells, input, h, .. } = self;
        let registers =
            |register: usize| if register < I::PERSISTENT { load(input.persistent[register], at) } else { [T::ZERO; W] };
        let mut group = ComponentGroup::new(load(input.displacement, at), load(input.rate, at), registers);
        group.each(|component, _| I::stage_state(0, component, *h));
        keep::<T, I, W>(cells, &group, at, input.damping.is_some());
    }

    #[inline(always)]
    fn update<const STAGE: usize>(&mut self, ends: bool) -> Sums {
        // Conditions on constants in blocks, so that only stages that there are, and ends of the last one, are compiled.
        if const { STAGE >= I::NODES.len() } {
            return Sums::default();
        }
        if const { STAGE + 1 == I::NODES.len() } && ends {
            return self.update_cells::<STAGE, true>();
        }
        self.update_cells::<STAGE, false>()
    }

    #[inline(always)]
    fn update_cells<const STAGE: usize, const ENDS: bool>(&mut self) -> Sums {
        let mut sums = LaneSums::ZERO;
        let count = self.cells.rate.len();
        let whole = count / LANES * LANES;
        for at in (0..whole).step_by(LANES) {
            let acceleration = &self.input.acceleration;
            // Two calls: accelerations that wait for the choice cost double precision a tenth.
            if acceleration.is_inner::<LANES>(at) {
                self.update_group::<STAGE, ENDS, LANES>(at, acceleration.inner(at), &mut sums);
            } else {
                self.update_group::<STAGE, ENDS, LANES>(at, acceleration.any(at), &mut sums);
            }
        }
        for at in whole..count {
            let mut cell = LaneSums::ZERO;
            self.update_group::<STAGE, ENDS, 1>(at, self.input.acceleration.any(at), &mut cell);
            sums.add(at % LANES, cell);
        }
        sums.sums(self.input.damping.is_some())
    }

    #[inline(always)]
    fn update_group<const STAGE: usize, const ENDS: bool, const W: usize>(
        &mut self,
        at: usize,
        mut a: [T; W],
        sums: &mut LaneSums<T, W>,
    ) {
        let Self { cells, input, h, .. } = self;
        let h = *h;
        let knows_rate = input.damping.is_some() || drifts_by_register::<I>().is_none();
        let (x, v) = (load(input.displacement, at), if knows_rate { load(cells.rate, at) } else { [T::ZERO; W] });
        if let Some(gamma) = input.damping {
            damp(&mut a, &load(gamma, at), &v, &mut sums.damping);
        }
        let registers = |register: usize| if is_kept::<I>(register) { load(cells.registers[register], at) } else { [T::ZERO; W] };
        let mut group = ComponentGroup::new(x, v, registers);
        let mut squares = sums.squares;
        group.each(|component: &mut Component<T>, lane| {
            I::stage_update(STAGE, component, a[lane], h);
            if STAGE + 1 == I::NODES.len() {
                squares[lane] += component.v * component.v;
            }
            if ENDS {
                squares[lane] += T::ZERO * component.x;
            } else {
                I::stage_state((STAGE + 1) % I::NODES.len(), component, h);
            }
        });
        sums.squares = squares;
        if ENDS {
            store(cells.displacement, at, &group.x);
            store(cells.rate, at, &group.v);
            (0..I::READABLE).for_each(|register| store(cells.registers[register], at, &group.register(register)));
        } else {
            keep::<T, I, W>(cells, &group, at, input.damping.is_some());
        }
    }
}

/// a − γv, and Σ γ v² lane by lane.
#[inline(always)]
fn damp<T: Real, const W: usize>(a: &mut [T; W], gamma: &[T; W], v: &[T; W], sums: &mut [T; W]) {
    for lane in 0..W {
        let braking = gamma[lane] * v[lane];
        a[lane] -= braking;
        sums[lane] += braking * v[lane];
    }
}

/// Stores what the next stage needs.
#[inline(always)]
fn keep<T: Real, I: Integrator, const W: usize>(cells: &mut Cells<'_, T>, group: &ComponentGroup<T, W>, at: usize, damped: bool) {
    store(cells.displacement, at, &group.x);
    if damped || drifts_by_register::<I>().is_none() {
        store(cells.rate, at, &group.v);
    }
    for register in 0..I::REGISTERS {
        if is_kept::<I>(register) {
            store(cells.registers[register], at, &group.register(register));
        }
    }
}

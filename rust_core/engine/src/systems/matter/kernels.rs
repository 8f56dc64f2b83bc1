//! The inner loops: an integrator's steps or stages over the lanes of one block.
//!
//! [`Steps`] runs whole steps of a fused law in registers. [`Stage`] runs one stage with forces that were accumulated
//! before. Both evaluate the fused law the same way, so a scene pays for the general one only where it needs it.
//! [`PointForceSteps`] runs whole steps under one point law, as the field of a star or a nucleus.

use std::marker::PhantomData;

use crate::forces::linear::{AxisLaw, Coefficients, Varying};
use crate::forces::{ForceField, InverseSquare};
use crate::integrators::{Component, Integrator};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, EnergySink, EnergyTally, Power, REGISTERS, SINKS, Span};
use crate::simd::{Kernel, LANES, Lanes, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// The fused law along one axis of a block. The loops below read everything that a group of lanes needs into local
/// arrays first: only then can the compiler be sure that nothing overlaps, and vectorise them.
trait AxisForce<T: Real>: Copy {
    /// Whether power is supplied from outside, by wind.
    const SUPPLIES: bool;
    /// The coefficients of a group.
    type Group: Copy;
    /// Reads the coefficients of a group.
    fn group(&self, group: usize) -> Self::Group;
    /// The acceleration of a lane.
    fn acceleration(&self, group: &Self::Group, lane: usize, x: T, v: T) -> T;
    /// The power that drag dissipates there and the work that wind does, in units of [`AxisForce::unit`].
    fn power(&self, group: &Self::Group, lane: usize, v: T) -> (T, T);
    /// What the sums of the powers are to be multiplied with.
    fn unit(&self) -> f64;
}

/// A uniform law; `DRAG` says whether it has any.
#[derive(Clone, Copy)]
struct Uniform<T, const DRAG: bool>(Coefficients<T>);

impl<T: Real, const DRAG: bool> AxisForce<T> for Uniform<T, DRAG> {
    const SUPPLIES: bool = false;
    type Group = ();

    #[inline(always)]
    fn group(&self, _group: usize) {}

    #[inline(always)]
    fn acceleration(&self, _group: &(), _lane: usize, _x: T, v: T) -> T {
        if DRAG { self.0.a0 + self.0.b * v } else { self.0.a0 }
    }

    #[inline(always)]
    fn power(&self, _group: &(), _lane: usize, v: T) -> (T, T) {
        (if DRAG { v * v } else { T::ZERO }, T::ZERO)
    }

    #[inline(always)]
    fn unit(&self) -> f64 {
        self.0.drag.to_f64()
    }
}

impl<T: Real> AxisForce<T> for Varying<'_, T> {
    const SUPPLIES: bool = true;
    /// a₀, b, c and γ.
    type Group = [Lanes<T>; 4];

    #[inline(always)]
    fn group(&self, group: usize) -> [Lanes<T>; 4] {
        [self.a0, self.b, self.c, self.drag].map(|column| column[group])
    }

    #[inline(always)]
    fn acceleration(&self, [a0, b, c, _]: &[Lanes<T>; 4], lane: usize, x: T, v: T) -> T {
        a0[lane] + b[lane] * v + c[lane] * x
    }

    #[inline(always)]
    fn power(&self, [.., drag]: &[Lanes<T>; 4], lane: usize, v: T) -> (T, T) {
        let relative = v - self.wind;
        let resistance = drag[lane] * relative;
        (resistance * relative, -(resistance * self.wind))
    }

    #[inline(always)]
    fn unit(&self) -> f64 {
        1.0
    }
}

/// Whole steps of a block whose forces are all fused.
struct Steps<'a, T, I> {
    axes: Axes<'a, T>,
    tally: &'a mut EnergyTally,
    dissipates: bool,
    h: f64,
    number: u64,
    integrator: PhantomData<I>,
}

/// Advances one block by whole steps under the fused law alone.
pub fn steps<V: Vector, I: Integrator>(law: &Dynamics<V>, blocks: &mut Blocks<'_, V>, h: f64, steps: u64) {
    let (axes, tally) = split(law, blocks);
    dispatch(Steps::<V::Scalar, I> { axes, tally, dissipates: law.linear.dissipates, h, number: steps, integrator: PhantomData });
}

impl<T: Real, I: Integrator> Kernel for Steps<'_, T, I> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        // The stages of a longer method keep the registers busy enough.
        let pairs = if I::NODES.len() == 1 { self.number / 2 } else { 0 };
        for _ in 0..pairs {
            self.pass::<true>();
        }
        for _ in 2 * pairs..self.number {
            self.pass::<false>();
        }
    }
}

impl<T: Real, I: Integrator> Steps<'_, T, I> {
    /// Takes one step, or two with the same bits in one pass over the columns.
    #[inline(always)]
    fn pass<const TWO: bool>(&mut self) {
        let mut power = [[[0.0; LANES]; SINKS]; 2];
        let mut sinks = &[EnergySink::Drag][..];
        for (axis, law) in self.axes.iter_mut().flatten() {
            match *law {
                AxisLaw::Uniform(same) if self.dissipates => {
                    whole_steps::<_, I, TWO>(Uniform::<_, true>(same), axis, self.h, &mut power);
                }
                AxisLaw::Uniform(same) => whole_steps::<_, I, TWO>(Uniform::<_, false>(same), axis, self.h, &mut power),
                AxisLaw::Varying(varying) => {
                    whole_steps::<_, I, TWO>(varying, axis, self.h, &mut power);
                    sinks = &[EnergySink::Drag, EnergySink::Work];
                }
            }
        }
        if self.dissipates {
            let weight = if I::NODES.len() == 1 { I::WEIGHTS[0] } else { 1.0 };
            for power in power.iter().take(1 + usize::from(TWO)) {
                integrate(self.tally, power, sinks, self.h * weight, self.h * I::LAST_WEIGHT, true);
            }
            if reuses_one_of_many::<I>() {
                self.tally.last = power[1];
            }
        }
    }
}

/// All sinks.
const ALL: [EnergySink; SINKS] =
    [EnergySink::Drag, EnergySink::Damping, EnergySink::Contact, EnergySink::Viscosity, EnergySink::Work];

/// Adds what passes through some sinks of a tally during one stage: the power times `span`, and the power at the last
/// stage of the step before times `last_span`. `keep` says that this is the last stage of its step.
#[inline(always)]
fn integrate(tally: &mut EnergyTally, power: &Power, sinks: &[EnergySink], span: f64, last_span: f64, keep: bool) {
    for sink in sinks.iter().map(|&sink| sink as usize) {
        let (now, last) = (power[sink], tally.last[sink]);
        for lane in 0..LANES {
            tally.energy[sink][lane] += last_span * last[lane] + span * now[lane];
        }
        if keep {
            tally.last[sink] = now;
        }
    }
}

/// The columns of one axis of one block, as groups of `W` lanes.
struct Axis<'a, T, const W: usize = LANES> {
    x: &'a mut [[T; W]],
    v: &'a mut [[T; W]],
    registers: [&'a mut [[T; W]]; REGISTERS],
    /// What x is short of by rounding; empty where nobody needs it.
    residual: &'a mut [[T; W]],
}

/// The axes of a block with their laws, as many as it has dimensions. The loops see only these, so that one compiled
/// kernel serves two and three dimensions.
type Axes<'a, T> = [Option<(Axis<'a, T>, AxisLaw<'a, T>)>; AXES];

/// The axes with their laws and the tally of a block.
fn split<'a, V: Vector>(law: &'a Dynamics<V>, blocks: &'a mut Blocks<'_, V>) -> (Axes<'a, V::Scalar>, &'a mut EnergyTally) {
    let (start, length) = (blocks.start, blocks.position.len());
    let mut columns =
        columns(&mut blocks.position, &mut blocks.velocity, &mut blocks.registers, &mut blocks.residual).into_iter();
    let axes = std::array::from_fn(|axis| {
        let columns = columns.next().filter(|_| axis < V::DIMENSION);
        columns.map(|columns| (columns, law.linear.axis(axis, start, length)))
    });
    (axes, &mut blocks.tallies[0])
}

/// The columns of every axis; those past the dimension are empty.
fn columns<'a, V: Vector, const W: usize>(
    position: &'a mut Span<'_, V>,
    velocity: &'a mut Span<'_, V>,
    registers: &'a mut [Span<'_, V>; REGISTERS],
    residual: &'a mut Span<'_, V>,
) -> [Axis<'a, V::Scalar, W>; AXES] {
    let mut x = position.axes.iter_mut().map(|axis| &mut **axis);
    let mut v = velocity.axes.iter_mut().map(|axis| &mut **axis);
    let mut registers = registers.each_mut().map(|span| span.axes.iter_mut().map(|axis| &mut **axis));
    let mut residual = residual.axes.iter_mut().map(|axis| &mut **axis);
    let lanes = |column: Option<&'a mut [V::Scalar]>| column.map_or(&mut [][..], |column| column.as_chunks_mut().0);
    std::array::from_fn(|_| Axis {
        x: lanes(x.next()),
        v: lanes(v.next()),
        registers: registers.each_mut().map(|axes| lanes(axes.next())),
        residual: lanes(residual.next()),
    })
}

/// Whether a method of several stages begins with the evaluation that ended the step before. The power of that one is then
/// kept apart from the weighted sum of all, where two steps in one pass would have that of the second.
#[inline(always)]
const fn reuses_one_of_many<I: Integrator>() -> bool {
    I::LAST_WEIGHT != 0.0 && I::NODES.len() > 1
}

/// One step of every lane along one axis, or two in one pass over the columns, with the power of each. Only what is carried
/// from step to step is read, and only what is kept is written.
#[inline(always)]
fn whole_steps<T: Real, I: Integrator, const TWO: bool>(
    law: impl AxisForce<T>,
    axis: &mut Axis<'_, T>,
    h: f64,
    power: &mut [Power; 2],
) {
    let step = T::from_f64(h);
    let Axis { x, v, registers, .. } = axis;
    let (mut drag, mut second_drag) = ([T::ZERO; LANES], [T::ZERO; LANES]);
    let (mut work, mut second_work) = ([T::ZERO; LANES], [T::ZERO; LANES]);
    for (group, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
        let coefficients = law.group(group);
        let mut components = ComponentGroup::<T>::load(x, v, registers, group, I::PERSISTENT);
        for lane in 0..LANES {
            let mut component = components.lane(lane);
            let (passed, last) = one_step::<T, I, _>(&law, &coefficients, lane, &mut component, step);
            drag[lane] += passed.0;
            work[lane] += passed.1;
            if TWO {
                let (passed, _) = one_step::<T, I, _>(&law, &coefficients, lane, &mut component, step);
                second_drag[lane] += passed.0;
                second_work[lane] += passed.1;
            } else if reuses_one_of_many::<I>() {
                second_drag[lane] += last.0;
                second_work[lane] += last.1;
            }
            components.set(lane, &component);
        }
        components.store(x, v, registers, group, I::READABLE);
    }
    for (power, [drag, work]) in power.iter_mut().zip([[&drag, &work], [&second_drag, &second_work]]) {
        add_power(&mut power[EnergySink::Drag as usize], drag, law.unit());
        if supplies(&law) {
            add_power(&mut power[EnergySink::Work as usize], work, law.unit());
        }
    }
}

/// One step of one lane; gives the power that was dissipated and the power that was supplied, weighted over the stages, and
/// those of the last stage.
#[inline(always)]
fn one_step<T: Real, I: Integrator, L: AxisForce<T>>(
    law: &L,
    coefficients: &L::Group,
    lane: usize,
    component: &mut Component<T>,
    h: T,
) -> ((T, T), (T, T)) {
    let (mut drag, mut work) = (T::ZERO, T::ZERO);
    let mut last = (T::ZERO, T::ZERO);
    for stage in 0..I::NODES.len() {
        I::stage_state(stage, component, h);
        let (dissipated, supplied) = law.power(coefficients, lane, component.v);
        // A single stage's weight is left to `integrate`: it would cost a multiplication per lane.
        let weigh = |power: T| if I::NODES.len() == 1 { power } else { T::from_f64(I::WEIGHTS[stage]) * power };
        drag = if stage == 0 { weigh(dissipated) } else { drag + weigh(dissipated) };
        work = if stage == 0 { weigh(supplied) } else { work + weigh(supplied) };
        last = (dissipated, supplied);
        let a = law.acceleration(coefficients, lane, component.x, component.v);
        I::stage_update(stage, component, a, h);
    }
    ((drag, work), last)
}

/// The registers of one group of lanes. One array for each: an array of arrays would be moved about in memory.
struct ComponentGroup<T, const W: usize = LANES> {
    x: [T; W],
    v: [T; W],
    a: [T; W],
    b: [T; W],
    c: [T; W],
    d: [T; W],
    e: [T; W],
    f: [T; W],
}

impl<T: Real, const W: usize> ComponentGroup<T, W> {
    const ZERO: Self = {
        let zero = [T::ZERO; W];
        Self { x: zero, v: zero, a: zero, b: zero, c: zero, d: zero, e: zero, f: zero }
    };

    /// Reads positions, velocities and the first `used` memories.
    #[inline(always)]
    fn load(x: &[T; W], v: &[T; W], registers: &[&mut [[T; W]]; REGISTERS], group: usize, used: usize) -> Self {
        let kept = |index: usize| if index < used { registers[index][group] } else { [T::ZERO; W] };
        Self { x: *x, v: *v, a: kept(0), b: kept(1), c: kept(2), d: kept(3), e: kept(4), f: kept(5) }
    }

    /// Writes the same.
    #[inline(always)]
    fn store(&self, x: &mut [T; W], v: &mut [T; W], registers: &mut [&mut [[T; W]]; REGISTERS], group: usize, used: usize) {
        *x = self.x;
        *v = self.v;
        for (index, values) in [&self.a, &self.b, &self.c, &self.d, &self.e, &self.f].into_iter().enumerate().take(used) {
            registers[index][group] = *values;
        }
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Component<T> {
        let registers = [self.a[lane], self.b[lane], self.c[lane], self.d[lane], self.e[lane], self.f[lane]];
        Component { x: self.x[lane], v: self.v[lane], registers }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, component: &Component<T>) {
        self.x[lane] = component.x;
        self.v[lane] = component.v;
        [self.a[lane], self.b[lane], self.c[lane], self.d[lane], self.e[lane], self.f[lane]] = component.registers;
    }

    /// Turns positions that are relative to `x` into the nearest ones that there are, and into the residual. Their sum
    /// keeps its value to the last bit (D. E. Knuth, The Art of Computer Programming 2, 4.2.2, theorem B).
    #[inline(always)]
    fn settle<I: Integrator>(&mut self, x: &Lanes<T>, residual: &mut Lanes<T>) {
        for lane in 0..LANES {
            let mut component = self.lane(lane);
            let (from, by) = (x[lane], component.x);
            let sum = from + by;
            let moved = sum - from;
            residual[lane] = (from - (sum - moved)) + (by - moved);
            component.x = sum;
            if let Some(place) = I::POSITION_REGISTER {
                component.registers[place] -= by - residual[lane];
            }
            self.set(lane, &component);
        }
    }

    /// Changes every lane's register.
    #[inline(always)]
    fn each(&mut self, change: impl Fn(&mut Component<T>, usize)) {
        for lane in 0..W {
            let mut component = self.lane(lane);
            change(&mut component, lane);
            self.set(lane, &component);
        }
    }
}

/// Whole steps of a block under a lone conservative point law.
struct PointForceSteps<'a, 'b, V: Vector, I, L> {
    law: L,
    members: &'a [V::Scalar],
    inverse_mass: &'a [V::Scalar],
    block: &'a mut Blocks<'b, V>,
    h: f64,
    number: u64,
    integrator: PhantomData<I>,
}

/// Advances one block by whole steps under an inverse-square law alone.
pub fn point_force_steps<V: Vector, I: Integrator>(
    law: &Dynamics<V>,
    InverseSquare { law: force, members }: InverseSquare<'_, V::Scalar>,
    block: &mut Blocks<'_, V>,
    h: f64,
    steps: u64,
) {
    let members = &members[block.range()];
    let inverse_mass = &law.properties.inverse_mass[block.range()];
    dispatch(PointForceSteps::<V, I, _> { law: force, members, inverse_mass, block, h, number: steps, integrator: PhantomData });
}

impl<V: Vector, I: Integrator, L: ForceField<V>> Kernel for PointForceSteps<'_, '_, V, I, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // The widest vector there is: a step needs so many temporaries that two of them would crowd the registers.
        if size_of::<V::Scalar>() == size_of::<f32>() { self.steps::<16>() } else { self.steps::<8>() }
    }
}

impl<V: Vector, I: Integrator, L: ForceField<V>> PointForceSteps<'_, '_, V, I, L> {
    /// Takes all steps, `W` particles at a time.
    #[inline(always)]
    fn steps<const W: usize>(self) {
        let Self { law, members, inverse_mass, block, h, number, .. } = self;
        let step = V::Scalar::from_f64(h);
        let (members, inverse_mass) = (members.as_chunks::<W>().0, inverse_mass.as_chunks::<W>().0);
        let [mut x, mut y, mut z] =
            columns::<V, W>(&mut block.position, &mut block.velocity, &mut block.registers, &mut block.residual);
        for _ in 0..number {
            for (group, (members, inverse_mass)) in members.iter().zip(inverse_mass).enumerate() {
                let (members, inverse_mass) = (*members, *inverse_mass);
                let mut first = ComponentGroup::load(&x.x[group], &x.v[group], &x.registers, group, I::PERSISTENT);
                let mut second = ComponentGroup::load(&y.x[group], &y.v[group], &y.registers, group, I::PERSISTENT);
                let mut third = ComponentGroup::ZERO;
                if V::DIMENSION > 2 {
                    third = ComponentGroup::load(&z.x[group], &z.v[group], &z.registers, group, I::PERSISTENT);
                }
                for lane in 0..W {
                    // A force times an inverse mass is an acceleration.
                    let weight = members[lane] * inverse_mass[lane];
                    let mut components = [first.lane(lane), second.lane(lane), third.lane(lane)];
                    for stage in 0..I::NODES.len() {
                        for axis in 0..V::DIMENSION {
                            I::stage_state(stage, &mut components[axis], step);
                        }
                        let at = |of: fn(&Component<V::Scalar>) -> V::Scalar| std::array::from_fn(|axis| of(&components[axis]));
                        let a = law.at(weight, at(|component| component.x), at(|component| component.v)).force;
                        for axis in 0..V::DIMENSION {
                            I::stage_update(stage, &mut components[axis], a[axis], step);
                        }
                    }
                    first.set(lane, &components[0]);
                    second.set(lane, &components[1]);
                    third.set(lane, &components[2]);
                }
                first.store(&mut x.x[group], &mut x.v[group], &mut x.registers, group, I::READABLE);
                second.store(&mut y.x[group], &mut y.v[group], &mut y.registers, group, I::READABLE);
                if V::DIMENSION > 2 {
                    third.store(&mut z.x[group], &mut z.v[group], &mut z.registers, group, I::READABLE);
                }
            }
        }
    }
}

/// What a stage does with the acceleration.
#[derive(Debug, Clone, Copy)]
pub enum Action {
    /// Begins a run: fills the carried memory.
    Begin,
    /// Only moves to where the first stage asks for the forces.
    StageState,
    /// Takes it in as that of a stage, and moves on to another stage.
    StageUpdate(usize, Option<usize>),
}

/// The forces and powers of one block that are not fused.
#[derive(Debug)]
pub struct Load<'a, V: Vector> {
    /// The force on every particle [N].
    pub force: Span<'a, V>,
    /// The power through each sink [W].
    pub power: Power,
}

struct Stage<'a, T, I> {
    axes: Axes<'a, T>,
    force: [&'a [Lanes<T>]; AXES],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
    power: Power,
    tally: &'a mut EnergyTally,
    dissipates: bool,
    h: f64,
    action: Action,
    integrator: PhantomData<I>,
}

/// Runs one stage of one block, and gives the activity at the stage.
pub fn stage<V: Vector, I: Integrator>(
    law: &Dynamics<V>,
    blocks: &mut Blocks<'_, V>,
    load: &Load<'_, V>,
    h: f64,
    action: Action,
) -> f64 {
    let inverse_mass = law.properties.inverse_mass[blocks.range()].as_chunks().0;
    let inertia = law.properties.inertia[blocks.range()].as_chunks().0;
    let force = load.force.axes.each_ref().map(|axis| axis.as_chunks().0);
    let (axes, tally) = split(law, blocks);
    dispatch(Stage::<V::Scalar, I> {
        axes,
        force,
        inverse_mass,
        inertia,
        power: load.power,
        tally,
        dissipates: law.linear.dissipates,
        h,
        action,
        integrator: PhantomData,
    })
}

impl<T: Real, I: Integrator> Kernel for Stage<'_, T, I> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { mut axes, force, inverse_mass, inertia, mut power, tally, dissipates, h, action, .. } = self;
        let mut squares = [T::ZERO; LANES];
        for ((axis, law), force) in axes.iter_mut().flatten().zip(force) {
            let push = Push { force, inverse_mass, inertia };
            let sums = (&mut power, &mut squares);
            match *law {
                AxisLaw::Uniform(same) if dissipates => one_stage::<_, I>(Uniform::<_, true>(same), push, axis, h, action, sums),
                AxisLaw::Uniform(same) => one_stage::<_, I>(Uniform::<_, false>(same), push, axis, h, action, sums),
                AxisLaw::Varying(varying) => one_stage::<_, I>(varying, push, axis, h, action, sums),
            }
        }
        match action {
            Action::Begin => tally.last = power,
            Action::StageState => {}
            Action::StageUpdate(stage, _) => {
                let last = if stage == 0 { h * I::LAST_WEIGHT } else { 0.0 };
                integrate(tally, &power, &ALL, h * I::WEIGHTS[stage], last, stage + 1 == I::NODES.len());
            }
        }
        kinetic(&squares)
    }
}

/// Forces of one axis, what divides them, and the inertia.
#[derive(Clone, Copy)]
struct Push<'a, T> {
    force: &'a [Lanes<T>],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
}

/// One stage of every lane along one axis. Adds to the powers, and m v² at the stage.
#[inline(always)]
fn one_stage<T: Real, I: Integrator>(
    law: impl AxisForce<T>,
    push: Push<'_, T>,
    axis: &mut Axis<'_, T>,
    h: f64,
    action: Action,
    (power, squares): (&mut Power, &mut Lanes<T>),
) {
    let step = T::from_f64(h);
    let Axis { x, v, registers, residual } = axis;
    let mut drag = [T::ZERO; LANES];
    let mut work = [T::ZERO; LANES];
    let mut moved = *squares;
    for (group, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
        let coefficients = law.group(group);
        let (force, inverse_mass, inertia) = (push.force[group], push.inverse_mass[group], push.inertia[group]);
        let mut components = ComponentGroup::<T>::load(x, v, registers, group, I::REGISTERS);
        let mut a = [T::ZERO; LANES];
        for lane in 0..LANES {
            let component = components.lane(lane);
            let (dissipated, supplied) = law.power(&coefficients, lane, component.v);
            drag[lane] += dissipated;
            work[lane] += supplied;
            moved[lane] += inertia[lane] * (component.v * component.v);
            a[lane] = force[lane] * inverse_mass[lane] + law.acceleration(&coefficients, lane, component.x, component.v);
        }
        // Integrators only ever add to a position, so that they can as well move what it is short of.
        if let Some(residual) = residual.get(group) {
            components.x = *residual;
        }
        match action {
            Action::Begin => components.each(|component, lane| I::begin(component, a[lane])),
            Action::StageState => stage_state::<T, I>(0, &mut components, step),
            Action::StageUpdate(stage, next) => {
                stage_update::<T, I>(stage, &mut components, &a, step);
                if let Some(next) = next {
                    // A step ends in the same bits, whether the next one follows in this sweep or in another batch.
                    if let (0, Some(residual)) = (next, residual.get_mut(group)) {
                        components.settle::<I>(x, residual);
                        (*x, components.x) = (components.x, *residual);
                    }
                    stage_state::<T, I>(next, &mut components, step);
                }
            }
        }
        if let Some(residual) = residual.get_mut(group) {
            components.settle::<I>(x, residual);
        }
        components.store(x, v, registers, group, I::REGISTERS);
    }
    *squares = moved;
    add_power(&mut power[EnergySink::Drag as usize], &drag, law.unit());
    if supplies(&law) {
        add_power(&mut power[EnergySink::Work as usize], &work, law.unit());
    }
}

/// Moves a group to the point of a stage. The stage is a constant in each loop: only then can it be vectorised.
#[inline(always)]
fn stage_state<T: Real, I: Integrator>(stage: usize, components: &mut ComponentGroup<T>, h: T) {
    for constant in 0..I::NODES.len() {
        if stage == constant {
            components.each(|component, _| I::stage_state(constant, component, h));
        }
    }
}

/// Lets a group take in the accelerations of a stage.
#[inline(always)]
fn stage_update<T: Real, I: Integrator>(stage: usize, components: &mut ComponentGroup<T>, a: &Lanes<T>, h: T) {
    for constant in 0..I::NODES.len() {
        if stage == constant {
            components.each(|component, lane| I::stage_update(constant, component, a[lane], h));
        }
    }
}

#[inline(always)]
fn add_power<T: Real>(power: &mut Lanes<f64>, sums: &Lanes<T>, unit: f64) {
    for lane in 0..LANES {
        power[lane] += unit * sums[lane].to_f64();
    }
}

/// Whether a law supplies power.
#[inline(always)]
fn supplies<T: Real, L: AxisForce<T>>(_law: &L) -> bool {
    L::SUPPLIES
}

/// Half of the sum over the lanes of m v² [J].
#[inline(always)]
fn kinetic<T: Real, const W: usize>(squares: &[T; W]) -> f64 {
    0.5 * squares.iter().map(|square| square.to_f64()).sum::<f64>()
}

/// The activity of a block: the kinetic energy [J], ½ Σ m v², rough in single precision, and not finite as soon as one
/// velocity is not.
pub fn activity<V: Vector>(law: &Dynamics<V>, blocks: &Blocks<'_, V>) -> f64 {
    dispatch(Activity { columns: &blocks.velocity, weights: &law.properties.inertia[blocks.range()] })
}

struct Activity<'a, 'b, V: Vector> {
    columns: &'a Span<'b, V>,
    weights: &'a [V::Scalar],
}

impl<V: Vector> Kernel for Activity<'_, '_, V> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let weights = self.weights.as_chunks::<LANES>().0;
        let mut squares = [V::Scalar::ZERO; LANES];
        for axis in 0..V::DIMENSION {
            for (group, weights) in self.columns.axes[axis].as_chunks::<LANES>().0.iter().zip(weights) {
                for lane in 0..LANES {
                    squares[lane] += weights[lane] * (group[lane] * group[lane]);
                }
            }
        }
        kinetic(&squares)
    }
}

/// 0 where all positions of a block and its kinetic energy are finite, else not a number: 0·∞ is none.
pub fn out_of_range<V: Vector>(law: &Dynamics<V>, blocks: &Blocks<'_, V>) -> f64 {
    dispatch(OutOfRange { blocks, weights: &law.properties.inertia[blocks.range()] })
}

struct OutOfRange<'a, 'b, V: Vector> {
    blocks: &'a Blocks<'b, V>,
    weights: &'a [V::Scalar],
}

impl<V: Vector> Kernel for OutOfRange<'_, '_, V> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let weights = self.weights.as_chunks::<LANES>().0;
        let mut sums = [V::Scalar::ZERO; LANES];
        for axis in 0..V::DIMENSION {
            let [x, v] = [&self.blocks.position, &self.blocks.velocity].map(|columns| columns.axes[axis].as_chunks::<LANES>().0);
            for ((x, v), weights) in x.iter().zip(v).zip(weights) {
                for lane in 0..LANES {
                    sums[lane] += V::Scalar::ZERO * x[lane] + V::Scalar::ZERO * (weights[lane] * (v[lane] * v[lane]));
                }
            }
        }
        sums.iter().map(|sum| sum.to_f64()).sum()
    }
}

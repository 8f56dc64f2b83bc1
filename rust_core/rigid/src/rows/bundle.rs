//! Contacts of a large group, side by side.
//!
//! The rows of a bundle share no body that moves, and each row stands behind all earlier rows of its bodies. Bundles that are
//! solved in ascending or descending order therefore give the bits of rows that are solved one by one in this order.

use physcore_base::simd::{Isa, Kernel, Pack, dispatch_wide};

use super::lanes::{ImpulseLanes, Laned, LanesOf, Loaded, SIDE};
use super::{BodyVelocities, BodyVelocity, ContactImpulse, ContactRow, RowAlgebra, RowSpace};
use crate::surface::Friction;

/// Velocities of bodies side by side.
#[derive(Debug, Clone, Copy, Default)]
pub struct VelocityLanes<S: RowSpace> {
    linear: LanesOf<S::Vector>,
    angular: LanesOf<S::Turn>,
}

impl<S: RowSpace> VelocityLanes<S> {
    /// Velocities of bodies by their numbers, and of points of faces at coordinates.
    #[inline(always)]
    fn gather(indices: &[u32; SIDE], arms: &LanesOf<S::Vector>, v: &BodyVelocities<S>) -> Self {
        let mut lanes = Self::default();
        for lane in 0..SIDE {
            let Some(body) = v.bodies.get(indices[lane] as usize) else {
                v.at(indices[lane] as usize, S::Vector::read(arms, lane)).write(&mut lanes.linear, lane);
                continue;
            };
            body.linear.write(&mut lanes.linear, lane);
            body.angular.write(&mut lanes.angular, lane);
        }
        lanes
    }

    /// Writes the velocities back. The corners of a face take the impulse at its point.
    #[inline(always)]
    fn scatter(&self, indices: &[u32; SIDE], arms: &LanesOf<S::Vector>, v: &mut BodyVelocities<S>) {
        for lane in 0..SIDE {
            let Some(body) = v.bodies.get_mut(indices[lane] as usize) else {
                v.move_point(indices[lane] as usize, S::Vector::read(arms, lane), S::Vector::read(&self.linear, lane));
                continue;
            };
            body.linear = S::Vector::read(&self.linear, lane);
            body.angular = S::Turn::read(&self.angular, lane);
        }
    }

    /// Writes the velocities of the lanes from `first` on.
    #[inline(always)]
    fn store<P: Pack<Scalar = f64>>(&mut self, body: &BodyVelocity<S::Wide<P>>, first: usize) {
        body.linear.store(&mut self.linear, first);
        body.angular.store(&mut self.angular, first);
    }
}

/// Inverse masses and inertias of bodies side by side.
#[derive(Debug, Clone, Copy, Default)]
struct InverseLanes<S: RowSpace> {
    mass: [f64; SIDE],
    inertia: LanesOf<S::Inverse>,
}

/// Rows of contacts that share no body that moves.
#[derive(Debug, Clone, Copy)]
pub struct RowBundle<S: RowSpace> {
    bodies: [[u32; SIDE]; 2],
    inverses: [InverseLanes<S>; 2],
    /// Number of rows; the other lanes act on the last body, which does not move.
    count: usize,
    arms: [LanesOf<S::Vector>; 2],
    normal: LanesOf<S::Vector>,
    pub least: [f64; SIDE],
    masses: [[f64; SIDE]; 2],
    pub yields: [f64; SIDE],
    pub impulse: ImpulseLanes<S>,
    pub before: ImpulseLanes<S>,
    friction: [[f64; SIDE]; 3],
    moments: [[f64; SIDE]; 2],
}

/// Several rows in registers.
type WideRow<S, P> = ContactRow<<S as RowSpace>::Wide<P>>;
/// Bodies of several rows on both sides.
type WideBodies<S, P> = [BodyVelocity<<S as RowSpace>::Wide<P>>; 2];
/// Velocities and angular velocities at the contacts of several rows.
pub type WideSlip<S, P> = (<<S as RowSpace>::Wide<P> as RowAlgebra>::Vector, <<S as RowSpace>::Wide<P> as RowAlgebra>::Turn);

impl<S: RowSpace> RowBundle<S> {
    /// Bundle without rows, in a group of `bodies`, of which the last does not move.
    fn new(bodies: usize) -> Self {
        let zeros = [0.0; SIDE];
        Self {
            bodies: [[bodies as u32 - 1; SIDE]; 2],
            inverses: [InverseLanes::default(); 2],
            count: 0,
            arms: Default::default(),
            normal: Default::default(),
            least: zeros,
            masses: [zeros; 2],
            yields: zeros,
            impulse: ImpulseLanes::default(),
            before: ImpulseLanes::default(),
            friction: [zeros; 3],
            moments: [zeros; 2],
        }
    }

    /// Adds a row without impulses; returns its lane.
    fn add(&mut self, row: &ContactRow<S>) -> usize {
        let lane = self.count;
        for side in 0..2 {
            self.bodies[side][lane] = row.bodies[side] as u32;
            row.arms[side].write(&mut self.arms[side], lane);
            (self.masses[side][lane], self.moments[side][lane]) = (row.masses[side], row.moments[side]);
        }
        row.normal.write(&mut self.normal, lane);
        let Friction { sliding, rolling, torsional } = row.friction;
        (self.friction[0][lane], self.friction[1][lane], self.friction[2][lane]) = (sliding, rolling, torsional);
        self.count += 1;
        lane
    }

    /// Row of a lane.
    fn row(&self, lane: usize) -> ContactRow<S> {
        let [sliding, rolling, torsional] = self.friction.map(|friction| friction[lane]);
        ContactRow {
            bodies: self.bodies.map(|bodies| bodies[lane] as usize),
            arms: [S::Vector::read(&self.arms[0], lane), S::Vector::read(&self.arms[1], lane)],
            normal: S::Vector::read(&self.normal, lane),
            least: self.least[lane],
            masses: self.masses.map(|masses| masses[lane]),
            yields: self.yields[lane],
            impulse: self.impulse.read(lane),
            before: self.before.read(lane),
            friction: Friction { sliding, rolling, torsional },
            slip: S::Vector::default(),
            moments: self.moments.map(|moments| moments[lane]),
        }
    }

    /// Loads the rows from lane `first` on.
    #[inline(always)]
    pub fn load<P: Pack<Scalar = f64>>(&self, first: usize) -> WideRow<S, P> {
        let load = |numbers: &[f64; SIDE]| P::load(&numbers[first..]);
        let zeros = LanesOf::<S::Vector>::default();
        ContactRow {
            bodies: [0; 2],
            arms: [Loaded::load(&self.arms[0], first), Loaded::load(&self.arms[1], first)],
            normal: Loaded::load(&self.normal, first),
            least: load(&self.least),
            masses: [load(&self.masses[0]), load(&self.masses[1])],
            yields: load(&self.yields),
            impulse: self.impulse.load(first),
            before: self.before.load(first),
            friction: Friction {
                sliding: load(&self.friction[0]),
                rolling: load(&self.friction[1]),
                torsional: load(&self.friction[2]),
            },
            slip: Loaded::load(&zeros, first),
            moments: [load(&self.moments[0]), load(&self.moments[1])],
        }
    }

    /// Takes the inverse masses and inertias of the bodies.
    fn equip(&mut self, v: &BodyVelocities<S>) {
        for ((bodies, arms), inverses) in self.bodies.iter().zip(&self.arms).zip(&mut self.inverses) {
            for (lane, &body) in bodies.iter().enumerate() {
                let body = v.body(body as usize, S::Vector::read(arms, lane));
                inverses.mass[lane] = body.inverse_mass;
                body.inverse_inertia.write(&mut inverses.inertia, lane);
            }
        }
    }

    /// Velocities of the bodies on both sides.
    #[inline(always)]
    pub fn gather(&self, v: &BodyVelocities<S>) -> [VelocityLanes<S>; 2] {
        [0, 1].map(|side| VelocityLanes::gather(&self.bodies[side], &self.arms[side], v))
    }

    /// Loads the bodies of a side from lane `first` on.
    #[inline(always)]
    fn body<P: Pack<Scalar = f64>>(&self, side: usize, v: &VelocityLanes<S>, first: usize) -> BodyVelocity<S::Wide<P>> {
        BodyVelocity {
            linear: Loaded::load(&v.linear, first),
            angular: Loaded::load(&v.angular, first),
            inverse_mass: P::load(&self.inverses[side].mass[first..]),
            inverse_inertia: Loaded::load(&self.inverses[side].inertia, first),
        }
    }

    /// Computes the effective masses and moments of inertia of the rows from lane `first` on.
    #[inline(always)]
    pub fn weigh<P: Pack<Scalar = f64>>(&mut self, row: &WideRow<S, P>, sides: &[VelocityLanes<S>; 2], first: usize) {
        let [masses, moments] = row.weights([&self.body(0, &sides[0], first), &self.body(1, &sides[1], first)]);
        for side in 0..2 {
            masses[side].store(&mut self.masses[side][first..]);
            moments[side].store(&mut self.moments[side][first..]);
        }
    }

    /// Velocities and angular velocities at the contacts of the rows from lane `first` on.
    #[inline(always)]
    pub fn slip<P: Pack<Scalar = f64>>(
        &self,
        row: &WideRow<S, P>,
        sides: &[VelocityLanes<S>; 2],
        first: usize,
    ) -> WideSlip<S, P> {
        let [one, other] = [self.body(0, &sides[0], first), self.body(1, &sides[1], first)];
        (row.between([&one, &other]), other.angular - one.angular)
    }

    /// Calls `act` with the rows of each register, their bodies and their first lane, and takes over the velocities.
    #[inline(always)]
    fn each<P: Pack<Scalar = f64>>(
        &mut self,
        v: &mut BodyVelocities<S>,
        mut act: impl FnMut(&mut Self, &WideRow<S, P>, &mut WideBodies<S, P>, usize),
    ) {
        let [mut one, mut other] = self.gather(v);
        for first in (0..SIDE).step_by(P::WIDTH) {
            let (row, mut bodies) = (self.load(first), [self.body(0, &one, first), self.body(1, &other, first)]);
            act(self, &row, &mut bodies, first);
            one.store(&bodies[0], first);
            other.store(&bodies[1], first);
        }
        one.scatter(&self.bodies[0], &self.arms[0], v);
        other.scatter(&self.bodies[1], &self.arms[1], v);
    }
}

/// Action on all bundles.
pub trait Pass<S: RowSpace> {
    /// Acts on the bundle of an index, with registers of a kind. Must be `#[inline(always)]`.
    fn act<P: Pack<Scalar = f64>>(&mut self, index: usize, bundle: &mut RowBundle<S>, v: &mut BodyVelocities<S>);
}

/// Rows of a group in bundles.
#[derive(Debug, Clone, Default)]
pub struct Bundles<S: RowSpace> {
    all: Vec<RowBundle<S>>,
    /// Whether moments resist the turning at a contact.
    resist_turning: bool,
    /// Number of bundles up to the last one of each body.
    last: Vec<u32>,
    /// Next bundle that may have room.
    next: Vec<u32>,
}

impl<S: RowSpace> Bundles<S> {
    /// Removes all rows; the next ones are those of a group of `bodies`, of which the last does not move.
    pub fn clear(&mut self, bodies: usize) {
        self.all.clear();
        self.next.clear();
        self.last.clear();
        self.last.resize(bodies, 0);
        self.resist_turning = false;
    }

    /// Adds a row behind all earlier ones of its bodies; returns its bundle and lane.
    pub fn add(&mut self, row: &ContactRow<S>, v: &BodyVelocities<S>) -> [usize; 2] {
        let movers = [0, 1].into_iter().flat_map(|side| v.movers(row.bodies[side], row.arms[side]));
        let moved = movers.filter(|&body| !v.bodies[body].is_fixed());
        let first = moved.clone().map(|body| self.last[body]).max().unwrap_or(0);
        let place = self.with_room(first as usize);
        if place == self.all.len() {
            self.all.push(RowBundle::new(v.bodies.len()));
            self.next.push(place as u32);
        }
        let lane = self.all[place].add(row);
        if lane + 1 == SIDE {
            self.next[place] += 1;
        }
        moved.for_each(|body| self.last[body] = place as u32 + 1);
        self.resist_turning |= row.resists_turning();
        [place, lane]
    }

    /// First bundle from `place` on that has room, or the one behind the last.
    fn with_room(&mut self, mut place: usize) -> usize {
        while let Some(&next) = self.next.get(place).filter(|&&next| next as usize != place) {
            let beyond = self.next.get(next as usize).copied().unwrap_or(next);
            self.next[place] = beyond;
            place = beyond as usize;
        }
        place
    }

    /// Takes the inverse masses and inertias of the bodies.
    pub fn equip(&mut self, v: &BodyVelocities<S>) {
        self.all.iter_mut().for_each(|bundle| bundle.equip(v));
    }

    /// Rows, bundle by bundle.
    pub fn iter(&self) -> impl Iterator<Item = ContactRow<S>> {
        self.all.iter().flat_map(|bundle| (0..bundle.count).map(|lane| bundle.row(lane)))
    }

    /// Acts on all bundles.
    pub fn pass(&mut self, v: &mut BodyVelocities<S>, pass: &mut impl Pass<S>, is_reversed: bool) {
        dispatch_wide(Passing { bundles: &mut self.all, v, pass, is_reversed });
    }

    /// Adds the initial impulses to the velocities.
    pub fn start(&mut self, v: &mut BodyVelocities<S>) {
        if self.resist_turning {
            self.pass(v, &mut Start::<true>, false);
        } else {
            self.pass(v, &mut Start::<false>, false);
        }
    }

    /// Solves each row alone, in ascending or descending order.
    pub fn relax(&mut self, v: &mut BodyVelocities<S>, is_reversed: bool) {
        if self.resist_turning {
            self.pass(v, &mut Relax::<true>, is_reversed);
        } else {
            self.pass(v, &mut Relax::<false>, is_reversed);
        }
    }
}

/// Pass over all bundles.
struct Passing<'a, S: RowSpace, P> {
    bundles: &'a mut [RowBundle<S>],
    v: &'a mut BodyVelocities<S>,
    pass: &'a mut P,
    is_reversed: bool,
}

impl<S: RowSpace, P: Pass<S>> Kernel for Passing<'_, S, P> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) {
        let count = self.bundles.len();
        for place in 0..count {
            let index = if self.is_reversed { count - 1 - place } else { place };
            self.pass.act::<I::Pack<f64>>(index, &mut self.bundles[index], self.v);
        }
    }
}

/// Adds an impulse to the velocities of the bodies of a row.
#[inline(always)]
fn push<S: RowAlgebra>(row: &ContactRow<S>, impulse: S::Vector, [one, other]: &mut [BodyVelocity<S>; 2]) {
    one.push(row.arms[0], -impulse);
    other.push(row.arms[1], impulse);
}

/// Adds a moment to the angular velocities of the bodies of a row.
#[inline(always)]
fn twist<S: RowAlgebra>(moment: S::Turn, [one, other]: &mut [BodyVelocity<S>; 2]) {
    one.twist(-moment);
    other.twist(moment);
}

/// Initial impulses, with moments if these resist turning.
struct Start<const TURNING: bool>;

impl<S: RowSpace, const TURNING: bool> Pass<S> for Start<TURNING> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, _index: usize, bundle: &mut RowBundle<S>, v: &mut BodyVelocities<S>) {
        bundle.each::<P>(v, |_, row, bodies, _| {
            push(row, row.sum(), bodies);
            if TURNING {
                twist(row.impulse.turning, bodies);
            }
        });
    }
}

/// Solution of each row alone, with moments if these resist turning.
struct Relax<const TURNING: bool>;

impl<S: RowSpace, const TURNING: bool> Pass<S> for Relax<TURNING> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, _index: usize, bundle: &mut RowBundle<S>, v: &mut BodyVelocities<S>) {
        bundle.each::<P>(v, |bundle, row, bodies, first| {
            let (normal, tangential) = row.solved(row.between([&bodies[0], &bodies[1]]));
            push(row, row.normal * (normal - row.impulse.normal) + (tangential - row.impulse.tangential), bodies);
            let mut turning = row.impulse.turning;
            if TURNING {
                turning = row.solved_turning(row.before.normal + normal, bodies[1].angular - bodies[0].angular);
                twist(turning - row.impulse.turning, bodies);
            }
            bundle.impulse.store::<P>(&ContactImpulse { normal, tangential, turning }, first);
        });
    }
}

//! Contacts of a large group during a step, side by side, and what begins and ends a half of a piece for them.

use physcore_base::simd::Pack;

use crate::island::{CLOSED, GroupContact, lost, pushed};
use crate::rows::{
    BodyVelocities, ContactImpulse, ImpulseLanes, LanesOf, Linear, Loaded, Pass, RowAlgebra, RowBundle, RowSpace, SIDE,
};

/// Damping ratio of contacts that overlap, and the part of a period that a piece takes.
const DAMPING: f64 = 10.0;
const PART_OF_PERIOD: f64 = 0.25;

/// Response of contacts that overlap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Softness {
    /// Rate at which overlaps vanish [1/s].
    rate: f64,
    /// Part of the impulse that yields.
    yields: f64,
}

impl Softness {
    /// Softness in pieces of a length, of which the usual one is `usual` [s].
    pub fn of(length: f64, usual: f64) -> Self {
        let frequency = std::f64::consts::TAU * PART_OF_PERIOD / usual.max(length);
        let first = 2.0 * DAMPING + length * frequency;
        Self { rate: frequency / first, yields: 1.0 / (1.0 + length * frequency * first) }
    }
}

/// Contacts of a bundle during a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touching<S: RowSpace> {
    /// Indices of the contacts; none of a lane without a row.
    contacts: [Option<u32>; SIDE],
    /// Gaps [m].
    gap: [f64; SIDE],
    /// Velocities and angular velocities at the contacts at the start of a half.
    slip: (LanesOf<S::Vector>, LanesOf<S::Turn>),
    /// Bounds on the accelerations that press the contacts [m/s²].
    pressing: [f64; SIDE],
    /// Sizes of the smaller bodies [m].
    size: [f64; SIDE],
    restitution: [f64; SIDE],
    /// Least normal velocities at the end of the piece [m/s].
    rebound: [f64; SIDE],
    /// 1 where the bodies approach at the start of a piece, where they are apart there, and where they overlap and are pushed apart;
    /// 0 elsewhere. The normal impulse dissipates energy in the first two cases.
    strikes: [f64; SIDE],
    closes: [f64; SIDE],
    pushes: [f64; SIDE],
    /// Impulses in half a piece that overlaps bear at rest [N·s].
    borne: [f64; SIDE],
    /// Mean forces of the last piece.
    load: ImpulseLanes<S>,
}

impl<S: RowSpace> Default for Touching<S> {
    fn default() -> Self {
        let zeros = [0.0; SIDE];
        Self {
            contacts: [None; SIDE],
            gap: zeros,
            slip: Default::default(),
            pressing: zeros,
            size: zeros,
            restitution: zeros,
            rebound: zeros,
            strikes: zeros,
            closes: zeros,
            pushes: zeros,
            borne: zeros,
            load: ImpulseLanes::default(),
        }
    }
}

impl<S: RowSpace> Touching<S> {
    /// Sets the contact of a lane, with the bound on its acceleration and the size of its smaller body.
    pub fn set(&mut self, lane: usize, (index, contact): (usize, &GroupContact), (pressing, size): (f64, f64)) {
        self.contacts[lane] = Some(index as u32);
        (self.gap[lane], self.pressing[lane], self.size[lane]) = (contact.touch.gap, pressing, size);
        self.restitution[lane] = contact.restitution;
        self.load.write(&ContactImpulse::narrow(&contact.load), lane);
    }

    /// Indices of the contacts, with their loads.
    pub fn loads(&self) -> impl Iterator<Item = (usize, ContactImpulse)> {
        let contacts = self.contacts.iter().enumerate();
        contacts.filter_map(|(lane, contact)| Some(((*contact)? as usize, self.load.read(lane).widen())))
    }
}

/// Effective masses, and velocities at the start of a sweep.
pub(super) struct Weigh<'a, S: RowSpace> {
    pub touching: &'a mut [Touching<S>],
}

impl<S: RowSpace> Pass<S> for Weigh<'_, S> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, index: usize, bundle: &mut RowBundle<S>, v: &mut BodyVelocities<S>) {
        let (contact, sides) = (&mut self.touching[index], bundle.gather(v));
        for first in (0..SIDE).step_by(P::WIDTH) {
            let row = bundle.load::<P>(first);
            bundle.weigh(&row, &sides, first);
            let slip = bundle.slip(&row, &sides, first);
            slip.0.store(&mut contact.slip.0, first);
            slip.1.store(&mut contact.slip.1, first);
        }
    }
}

/// Rows at the start of a piece.
pub(super) struct Begin<'a, S: RowSpace> {
    pub touching: &'a mut [Touching<S>],
    pub softness: Softness,
    /// Length of the piece [s].
    pub length: f64,
    /// Whether a contact strikes.
    pub strikes: bool,
}

impl<S: RowSpace> Pass<S> for Begin<'_, S> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, index: usize, bundle: &mut RowBundle<S>, _v: &mut BodyVelocities<S>) {
        let contact = &mut self.touching[index];
        let [zero, one, two] = [P::constant(0.0), P::constant(1.0), P::constant(2.0)];
        let (length, rate, yields) = (P::of(self.length), P::of(self.softness.rate), P::of(self.softness.yields));
        for first in (0..SIDE).step_by(P::WIDTH) {
            let load = |numbers: &[f64; SIDE]| P::load(&numbers[first..]);
            let slip = <S::Wide<P> as RowAlgebra>::Vector::load(&contact.slip.0, first);
            let approach = zero - bundle.load::<P>(first).normal.dot(slip);
            let (gap, pressing, size) = (load(&contact.gap), load(&contact.pressing), load(&contact.size));
            // Bounces of less than a piece are contacts at rest.
            let least = P::constant(0.5) * length * pressing;
            let strikes = one.masked(least.less(approach));
            strikes.store(&mut contact.strikes[first..]);
            let closed = P::constant(CLOSED) * size;
            one.masked(closed.less(gap)).store(&mut contact.closes[first..]);
            let pushes = (one - strikes).masked(gap.less(zero - closed));
            pushes.store(&mut contact.pushes[first..]);
            let rebound = load(&contact.restitution) * approach;
            rebound.masked(least.less(rebound)).store(&mut contact.rebound[first..]);
            // Overlaps are left no faster than a fall through the size of the bodies is.
            let push = (zero - gap * rate).min((two * pressing * size).sqrt());
            P::select(gap.less(zero), push, zero - gap / length).store(&mut bundle.least[first..]);
            yields.masked(gap.less(zero)).store(&mut bundle.yields[first..]);
            let impulse = contact.load.load::<P>(first).scaled(P::constant(0.5) * length);
            bundle.impulse.store::<P>(&impulse, first);
        }
        bundle.before = ImpulseLanes::default();
        self.strikes |= contact.strikes != [0.0; SIDE];
    }
}

/// Rows at the start of the second half of a piece.
pub(super) struct Resume<'a, S: RowSpace> {
    pub touching: &'a [Touching<S>],
}

impl<S: RowSpace> Pass<S> for Resume<'_, S> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, index: usize, bundle: &mut RowBundle<S>, _v: &mut BodyVelocities<S>) {
        let (contact, zero) = (&self.touching[index], P::constant(0.0));
        for first in (0..SIDE).step_by(P::WIDTH) {
            let load = |numbers: &[f64; SIDE]| P::load(&numbers[first..]);
            // A gap that is open may close in the next piece.
            let open = P::select(zero.less(load(&contact.gap)), P::of(f64::NEG_INFINITY), zero);
            let pressed = zero.less(load(&bundle.impulse.normal));
            P::select(pressed, load(&contact.rebound), open).store(&mut bundle.least[first..]);
        }
        (bundle.yields, bundle.before) = ([0.0; SIDE], bundle.impulse);
    }
}

/// Impulses of the first half in place of those of the second.
pub(super) struct Undo;

impl<S: RowSpace> Pass<S> for Undo {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, _index: usize, bundle: &mut RowBundle<S>, _v: &mut BodyVelocities<S>) {
        bundle.impulse = bundle.before;
    }
}

/// No impulses.
pub(super) struct Clear;

impl<S: RowSpace> Pass<S> for Clear {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, _index: usize, bundle: &mut RowBundle<S>, _v: &mut BodyVelocities<S>) {
        bundle.impulse = ImpulseLanes::default();
    }
}

/// Energy that the initial impulses add to free velocities [J], and the sum of absolute values.
pub(super) struct Gain<'a, S: RowSpace> {
    pub free: &'a BodyVelocities<S>,
    pub sum: [f64; SIDE],
    pub size: [f64; SIDE],
}

impl<S: RowSpace> Pass<S> for Gain<'_, S> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, _index: usize, bundle: &mut RowBundle<S>, v: &mut BodyVelocities<S>) {
        let [before, after] = [bundle.gather(self.free), bundle.gather(v)];
        for first in (0..SIDE).step_by(P::WIDTH) {
            let row = bundle.load::<P>(first);
            let [gain, size] = row.gain(bundle.slip(&row, &before, first), bundle.slip(&row, &after, first));
            (P::load(&self.sum[first..]) + gain).store(&mut self.sum[first..]);
            (P::load(&self.size[first..]) + size).store(&mut self.size[first..]);
        }
    }
}

/// Energies of a half of a piece, and the gaps after its first half, or the loads at its end.
pub(super) struct HalfEnergies<'a, S: RowSpace, const ENDS: bool> {
    pub touching: &'a mut [Touching<S>],
    /// Length of the piece [s].
    pub length: f64,
    /// Energy that contacts dissipate, and gained by pushing overlapping bodies apart [J].
    pub lost: [f64; SIDE],
    pub pushed: [f64; SIDE],
}

impl<S: RowSpace, const ENDS: bool> Pass<S> for HalfEnergies<'_, S, ENDS> {
    #[inline(always)]
    fn act<P: Pack<Scalar = f64>>(&mut self, index: usize, bundle: &mut RowBundle<S>, v: &mut BodyVelocities<S>) {
        let contact = &mut self.touching[index];
        let (sides, zero, one, length) = (bundle.gather(v), P::constant(0.0), P::constant(1.0), P::of(self.length));
        for first in (0..SIDE).step_by(P::WIDTH) {
            let row = bundle.load::<P>(first);
            let before = (Loaded::load(&contact.slip.0, first), Loaded::load(&contact.slip.1, first));
            let after = bundle.slip(&row, &sides, first);
            // Impacts of other contacts in the first half may have made the bodies approach.
            let least = P::constant(0.5) * length * P::load(&contact.pressing[first..]);
            let approaches = one.masked(least.less(zero - row.normal.dot(before.0)));
            let strikes = P::load(&contact.strikes[first..]) + P::load(&contact.closes[first..]) + approaches;
            let strikes = zero.less(strikes);
            let pushes = zero.less(P::load(&contact.pushes[first..]));
            if !ENDS {
                row.borne().masked(pushes).store(&mut contact.borne[first..]);
            }
            // An overlap that grows gives back the work of what it bears at rest; the damper dissipates the rest.
            let damped = (row.impulse.normal - P::load(&contact.borne[first..])).max(zero);
            let sinks = (P::constant(-0.5) * row.normal.dot(before.0 + after.0)).max(zero);
            let yielded = P::select(strikes, zero, damped * sinks).masked(pushes);
            let lost = lost(&row, strikes, before, after) + yielded;
            (P::load(&self.lost[first..]) + lost).store(&mut self.lost[first..]);
            after.0.store(&mut contact.slip.0, first);
            after.1.store(&mut contact.slip.1, first);
            let mut gained = yielded;
            if ENDS {
                // The impulse that ends an approach is that of an impact.
                let ends = approaches * row.impulse.normal * row.normal.dot(before.0);
                gained += (pushed(&row, before.0) - ends).masked(pushes);
                let load = row.before.plus(&row.impulse).scaled(P::constant(1.0) / length);
                contact.load.store::<P>(&load, first);
            } else {
                (P::load(&contact.gap[first..]) + length * row.normal.dot(after.0)).store(&mut contact.gap[first..]);
            }
            (P::load(&self.pushed[first..]) + gained).store(&mut self.pushed[first..]);
        }
    }
}

//! Steps of large groups of bodies: equal pieces with few iterations each, in which all contacts within reach are rows.
//!
//! Each piece has the two halves of a piece of a small group. The arms and normals of contacts stay as they are during the step,
//! and gaps follow from the velocities at the contacts. A gap that would close within a piece is closed at its end at most. Nothing
//! passes through anything, at the price of the time of impact. Overlaps are pushed apart by a damped spring, whose
//! velocity the second half removes. Source: E. Catto, "`Solver2D`", 2024 (small steps with soft contacts and relaxation).

use glam::DVec3;

use crate::face::movers_of;
use crate::island::{FirstHalf, GroupContact, Island};
use crate::mover::drift_all;
use crate::rotation::{Inertia, Orientation};
use crate::rows::{BodyVelocities, BodyVelocity, Bundles, ContactRow, InPlane, InSpace, RowSpace, SIDE, adds_energy};
use crate::shapes::SolidShape;
use crate::sweep_steps::SweepPieces;

mod touching;

use touching::{Begin, Clear, Gain, HalfEnergies, Resume, Softness, Touching, Undo, Weigh};

/// Number of impacts in a row that pass the speed of a body on in a step. What is left of it after more may make bodies overlap
/// until the next step.
const PASSED: usize = 2;

/// Iterations of the second half of a piece where a contact strikes. The others are added to the first half, where what is left of
/// an impact makes bodies overlap.
const LAST: usize = 1;

/// Contacts of a group during a step: in the plane if it has no joints.
#[derive(Debug, Clone)]
pub enum GroupSweep {
    InPlane(RowSweep<InPlane>),
    InSpace(RowSweep<InSpace>),
}

impl Default for GroupSweep {
    fn default() -> Self {
        Self::InSpace(RowSweep::default())
    }
}

/// Contacts of a group during a step.
#[derive(Debug, Clone, Default)]
pub struct RowSweep<S: RowSpace> {
    /// Rows of joints in a half of a piece.
    joints: FirstHalf,
    /// Rows of contacts, which last throughout the step, with the contacts of each bundle.
    rows: Bundles<S>,
    touching: Vec<Touching<S>>,
    /// Whether a contact strikes.
    strikes: bool,
    /// Iterations of the first half of a piece where a contact strikes, over those of others: as many as all pieces of a single
    /// sweep would take. Pushing bodies apart that overlap adds energy.
    repeats: usize,
    /// Velocities, and those at the start of a half if there are joints.
    v: BodyVelocities<S>,
    start: BodyVelocities<S>,
    /// Energies of a piece that contacts and limits dissipate, that is supplied, and that overlaps gain [J].
    lost: f64,
    work: f64,
    pushed: f64,
    /// Whether a fixed body moves.
    is_driven: bool,
}

impl Island {
    /// Advances the group by `h` seconds in `count` equal pieces. The last one is left open.
    pub fn sweep(&mut self, shapes: &[SolidShape], (h, count): (f64, usize), pieces: &SweepPieces, is_last: bool) {
        self.accuracy = pieces.accuracy;
        let length = h / count as f64;
        self.joints.iter_mut().for_each(|held| held.held = [true; 2]);
        let ways = self.ways(h);
        for pair in &mut self.pairs {
            let way = |body: usize| movers_of(body, &self.faces).into_iter().map(|mover| ways[mover]).fold(0.0, f64::max);
            pair.reach = (way(pair.bodies[0]) + way(pair.bodies[1])).min(pair.size);
        }
        self.renew_contacts(shapes, is_last);
        let is_flat = self.planar && self.joints.is_empty();
        let mut sweep = match self.take_sweep() {
            GroupSweep::InSpace(_) if is_flat => GroupSweep::InPlane(RowSweep::default()),
            GroupSweep::InPlane(_) if !is_flat => GroupSweep::default(),
            sweep => sweep,
        };
        match &mut sweep {
            GroupSweep::InPlane(sweep) => sweep.take(self, (count, length), pieces),
            GroupSweep::InSpace(sweep) => sweep.take(self, (count, length), pieces),
        }
        self.open_sweep(sweep, length, h);
    }

    /// Ways of surface points in a step of `h` seconds for which contacts are found [m]. Impacts may pass the speed of a body on to
    /// those that it strikes, and these to others; joints, to any body.
    fn ways(&self, h: f64) -> Vec<f64> {
        if !self.joints.is_empty() {
            return vec![h * self.speed(); self.movers.len()];
        }
        let mut ways: Vec<f64> = self.movers.iter().map(|mover| h * mover.speed()).collect();
        for _ in 0..PASSED {
            let before = ways.clone();
            for [one, other] in self.pairs.iter().map(|pair| pair.bodies) {
                let [one, other] = [one, other].map(|body| movers_of(body, &self.faces));
                for (one, other) in one.iter().flat_map(|&one| other.iter().map(move |&other| (one, other))) {
                    ways[one] = ways[one].max(before[other]);
                    ways[other] = ways[other].max(before[one]);
                }
            }
            let fixed = self.movers.iter().zip(&mut ways).zip(&before).filter(|((mover, _), _)| mover.is_fixed());
            fixed.for_each(|((_, way), own)| *way = *own);
        }
        ways
    }

    /// Ends the last piece of a sweep, at the velocities after the kick.
    pub fn end_sweep(&mut self) {
        let mut sweep = self.take_sweep();
        match &mut sweep {
            GroupSweep::InPlane(sweep) => sweep.end(self),
            GroupSweep::InSpace(sweep) => sweep.end(self),
        }
        self.keep_sweep(sweep);
    }

    /// Adds the impulses of the second half of the open piece of a sweep to the velocities after the kick, and leaves it open.
    pub fn add_second_half(&mut self) {
        let mut sweep = self.take_sweep();
        match &mut sweep {
            GroupSweep::InPlane(sweep) => sweep.predict(self),
            GroupSweep::InSpace(sweep) => sweep.predict(self),
        }
        self.keep_sweep(sweep);
    }
}

impl<S: RowSpace> RowSweep<S> {
    /// Takes pieces of a length, but for the second half of the last.
    fn take(&mut self, island: &mut Island, (count, length): (usize, f64), pieces: &SweepPieces) {
        self.begin(island);
        self.repeats = (pieces.count / count).max(1);
        for piece in 0..count {
            let last = piece + 1 == count;
            self.first_half(island, (length, pieces.usual), piece == 0);
            self.drift(island, length, last);
            if !last {
                self.v.kick(&island.movers, 0.5 * length);
                self.second_half(island, length);
            }
        }
    }

    /// Rows of all contacts.
    fn begin(&mut self, island: &Island) {
        let moves = |velocity: DVec3, spin: DVec3| velocity != DVec3::ZERO || spin != DVec3::ZERO;
        self.is_driven = island.movers.iter().any(|mover| mover.is_fixed() && moves(mover.velocity, mover.spin));
        self.fill(island);
        self.rows.clear(self.v.bodies.len());
        self.touching.clear();
        self.strikes = false;
        let is_near = |contact: &GroupContact| contact.touch.gap <= island.pairs[contact.pair].reach;
        for (index, contact) in island.contacts.iter().enumerate().filter(|(_, contact)| is_near(contact)) {
            let row = ContactRow::unweighed(contact.bodies, island.arms(contact), contact.touch.normal, contact.friction);
            if [0, 1].into_iter().all(|side| self.v.body(row.bodies[side], row.arms[side]).is_fixed()) {
                continue;
            }
            let [bundle, lane] = self.rows.add(&row, &self.v);
            if bundle == self.touching.len() {
                self.touching.push(Touching::default());
            }
            let size = island.pairs[contact.pair].size;
            self.touching[bundle].set(lane, (index, contact), (island.pressing(contact), size));
        }
        self.rows.equip(&self.v);
        self.rows.pass(&mut self.v, &mut Weigh { touching: &mut self.touching }, false);
    }

    /// Takes the velocities of the movers, and adds a body at rest for lanes without a row.
    fn fill(&mut self, island: &Island) {
        self.v.fill(&island.movers, &island.faces);
        self.v.bodies.push(BodyVelocity::default());
    }

    /// Takes the impulses of the first half of a piece. Its `usual` length is that in a whole step [s]. Neither overlaps nor errors of
    /// joints vanish faster in shorter ones.
    fn first_half(&mut self, island: &Island, (length, usual): (f64, f64), is_first: bool) {
        let joined = !island.joints.is_empty();
        if joined {
            self.start.clone_from(&self.v);
        }
        self.v.kick(&island.movers, 0.5 * length);
        self.joints.clear_joints();
        if let Some(v) = S::in_space(&mut self.v) {
            island.hold_joints((length, usual), v, &mut self.joints);
        }
        let are_strange = is_first || self.strikes;
        let softness = Softness::of(length, usual);
        let mut begin = Begin { touching: &mut self.touching, softness, length, strikes: false };
        self.rows.pass(&mut self.v, &mut begin, false);
        self.strikes = begin.strikes;
        self.start_impulses(are_strange);
        let iterations = island.accuracy.iterations;
        self.relax(if self.strikes { iterations * (self.repeats + 1) - LAST } else { iterations });
        self.lost = 0.0;
        self.pushed = self.meter::<false>(length);
        self.work = self.supplied();
    }

    /// Moves the bodies to the end of a piece.
    fn drift(&mut self, island: &mut Island, length: f64, last: bool) {
        if S::in_space(&mut self.v).is_some() {
            take_velocities(island, &self.v);
            drift_all(&mut island.movers, length);
            self.fill(island);
            self.rows.equip(&self.v);
        } else {
            for (mover, body) in island.movers.iter_mut().zip(&self.v.bodies) {
                mover.position += S::widen(body.linear * length);
                mover.orientation.angle += S::widen_turn(body.angular * length).z;
                // Contacts need the rotation at the end of the step alone.
                if last && !mover.is_fixed() {
                    mover.orientation = Orientation::planar(mover.orientation.angle);
                }
            }
            if last {
                take_velocities(island, &self.v);
            }
        }
        if !island.joints.is_empty() {
            self.start.clone_from(&self.v);
        }
    }

    /// Solves for the impulses of the second half of a piece, at the velocities after the kick. Returns the rows of joints in the
    /// first half.
    fn solve_second_half(&mut self, island: &Island) -> FirstHalf {
        let first = std::mem::take(&mut self.joints);
        if let Some(v) = S::in_space(&mut self.v) {
            island.hold_joint_velocities(&first, v, &mut self.joints.rows);
        }
        self.rows.pass(&mut self.v, &mut Resume { touching: &self.touching }, false);
        self.start_impulses(false);
        self.relax(if self.strikes { LAST } else { island.accuracy.iterations });
        first
    }

    /// Takes the second half of a piece.
    fn second_half(&mut self, island: &mut Island, length: f64) {
        let first = self.solve_second_half(island);
        if !island.joints.is_empty() {
            island.keep_joint_loads(&first, &self.joints.rows, length);
            island.keep_reactions(&first, &self.joints.rows);
        }
        island.meters.pushed += self.pushed + self.meter::<true>(length);
        island.meters.work += self.work + self.supplied();
        // A sum below 0 is an error of the piece, which is left to the drift.
        island.meters.dissipated += self.lost.max(0.0);
    }

    /// Takes the velocities after the second half of the last piece.
    fn predict(&mut self, island: &mut Island) {
        self.fill(island);
        self.joints = self.solve_second_half(island);
        take_velocities(island, &self.v);
        self.rows.pass(&mut self.v, &mut Undo, false);
    }

    /// Ends the last piece.
    fn end(&mut self, island: &mut Island) {
        self.fill(island);
        self.second_half(island, island.open);
        take_velocities(island, &self.v);
        for (contact, load) in self.touching.iter().flat_map(Touching::loads) {
            island.contacts[contact].load = load;
        }
    }

    /// Adds the initial impulses to the velocities. Those of the last step or of an impact may hold a load that nothing balances:
    /// they are strange. If these would add energy, all begin at zero.
    fn start_impulses(&mut self, are_strange: bool) {
        let free = are_strange.then(|| self.v.clone());
        if let Some(v) = S::in_space(&mut self.v) {
            self.joints.rows.start(v);
        }
        self.rows.start(&mut self.v);
        let Some(mut free) = free else { return };
        let mut gain = Gain { free: &free, sum: [0.0; SIDE], size: [0.0; SIDE] };
        self.rows.pass(&mut self.v, &mut gain, false);
        let (sum, size): (f64, f64) = (gain.sum.iter().sum(), gain.size.iter().sum());
        let stopped = self.stopped(&mut free);
        if adds_energy(sum - stopped, size + stopped.abs()) {
            self.joints.rows.clear_impulses();
            self.rows.pass(&mut self.v, &mut Clear, false);
            self.v = free;
        }
    }

    /// Iterates over all rows, in alternating order.
    fn relax(&mut self, iterations: usize) {
        for iteration in 0..iterations {
            if let Some(v) = S::in_space(&mut self.v) {
                self.joints.rows.relax_all(iteration, v);
            }
            self.rows.relax(&mut self.v, !iteration.is_multiple_of(2));
        }
    }

    /// Energy that limits of joints dissipate by the impulses of a half, from velocities before [J].
    fn stopped(&mut self, before: &mut BodyVelocities<S>) -> f64 {
        match (S::in_space(before), S::in_space(&mut self.v)) {
            (Some(before), Some(v)) => self.joints.rows.stopped(before, v),
            _ => 0.0,
        }
    }

    /// Energy that motors and moved bodies supply by the impulses of a half [J].
    fn supplied(&mut self) -> f64 {
        let moved = if self.is_driven { self.rows.iter().map(|row| row.supplied(&self.v)).sum() } else { 0.0 };
        match (S::in_space(&mut self.start), S::in_space(&mut self.v)) {
            (Some(start), Some(v)) => self.joints.rows.supplied(start, v) + moved,
            _ => moved,
        }
    }

    /// Adds the energy that contacts and limits dissipate in a half of a piece. Takes the velocities of contacts for the start of
    /// the next, and at the end of a piece the loads. Returns the energy gained by pushing overlapping bodies apart [J].
    fn meter<const ENDS: bool>(&mut self, length: f64) -> f64 {
        let mut start = std::mem::take(&mut self.start);
        self.lost += self.stopped(&mut start);
        self.start = start;
        let mut energies =
            HalfEnergies::<S, ENDS> { touching: &mut self.touching, length, lost: [0.0; SIDE], pushed: [0.0; SIDE] };
        self.rows.pass(&mut self.v, &mut energies, false);
        self.lost += energies.lost.iter().sum::<f64>();
        energies.pushed.iter().sum()
    }
}

/// Takes the velocities of a solve.
fn take_velocities<S: RowSpace>(island: &mut Island, v: &BodyVelocities<S>) {
    for (mover, body) in island.movers.iter_mut().zip(&v.bodies).filter(|(mover, _)| !mover.is_fixed()) {
        mover.velocity = S::widen(body.linear);
        if mover.inertia != Inertia::NONE {
            mover.spin = mover.inertia.spin(&mover.orientation, S::widen_turn(body.angular));
        }
    }
}

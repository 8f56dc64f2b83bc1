//! Limits of the joints of a group, as contacts without restitution.

use crate::impacts::{BodyPath, first_zero};
use crate::island::{CLOSED, HIT, HeldJoint, Island, LIMIT_BOUNDS, LIMITS};
use crate::mover::Mover;
use crate::rows::{BodyVelocities, BoundedRow};

impl HeldJoint {
    /// Way that is left to a limit [m]; infinite without limit.
    fn way_to(&self, which: usize, bodies: [&Mover; 2]) -> f64 {
        let limit = self.joint.limit(which);
        let place = if limit.is_finite() { self.joint.freedom(bodies) } else { None };
        place.map_or(f64::INFINITY, |(_, place)| if which == 0 { place - limit } else { limit - place })
    }

    /// Time until `until` at which a limit is reached that was not at the start.
    fn reaches(&self, which: usize, paths: &[BodyPath<'_>], until: f64) -> Option<f64> {
        let least = HIT * self.joint.lever;
        let way = |time: f64| {
            let [one, other] = self.bodies.map(|body| paths[body].mover(time));
            self.way_to(which, [&one, &other]) - least
        };
        let end = way(until);
        (end < 0.0).then(|| first_zero((0.0, way(0.0)), (until, end), 0.1 * least, way))
    }
}

impl Island {
    /// Limits that joints have reached, with the joints.
    fn reached(&self) -> impl Iterator<Item = (usize, usize)> {
        let closed = |held: &HeldJoint, which: usize| {
            held.way_to(which, held.bodies.map(|body| &self.movers[body])) <= CLOSED * held.joint.lever
        };
        let joints = self.joints.iter().enumerate().filter(|(_, held)| held.joint.is_bounded());
        joints.flat_map(move |(index, held)| {
            LIMITS.into_iter().filter(move |&which| closed(held, which)).map(move |which| (index, which))
        })
    }

    /// Rows of the limits that joints have reached, with the joints.
    pub fn closed_limits(&self, v: &BodyVelocities) -> Vec<(usize, BoundedRow)> {
        let row = |(index, which): (usize, usize)| {
            let held = &self.joints[index];
            let (row, _) = held.joint.freedom(held.bodies.map(|body| &self.movers[body]))?;
            BoundedRow::new(held.bodies, row, LIMIT_BOUNDS[which], v).map(|row| (index, row))
        };
        self.reached().filter_map(row).collect()
    }

    /// Whether a joint runs into a limit that it has reached, faster than `still` [m/s].
    pub fn strikes_limit(&self, v: &BodyVelocities, still: f64) -> bool {
        self.closed_limits(v).iter().any(|(_, bounded)| {
            let velocity = bounded.row.velocity(bounded.bodies, v);
            (if bounded.bounds == LIMIT_BOUNDS[0] { -velocity } else { velocity }) > still
        })
    }

    /// Holds the limits that joints have reached.
    pub fn hold_closed_limits(&mut self) {
        let reached: Vec<(usize, usize)> = self.reached().collect();
        self.joints.iter_mut().for_each(|held| held.held = [false; 2]);
        reached.into_iter().for_each(|(index, which)| self.joints[index].held[which] = true);
    }

    /// Time until `until` at which a joint first reaches a limit on the paths of a piece.
    pub fn first_limit(&self, paths: &[BodyPath<'_>], until: f64) -> Option<f64> {
        let mut first = None;
        for held in self.joints.iter().filter(|held| held.joint.is_bounded()) {
            for which in LIMITS.into_iter().filter(|&which| !held.held[which]) {
                first = held.reaches(which, paths, first.unwrap_or(until)).or(first);
            }
        }
        first
    }
}

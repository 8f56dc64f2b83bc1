//! Times of impact on the paths of a piece.

use glam::DVec3;

use crate::collision;
use crate::contact::ContactPoint;
use crate::island::{BodyPair, CLOSED, GroupContact, HIT, Island};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::shapes::SolidShape;

/// Largest number of steps towards a time of impact.
const MOST_ADVANCES: usize = 100;
/// Largest number of features of a pair that are followed beside its contacts.
const MOST_FEATURES: usize = 8;
/// Gap at the time of an impact of round bodies, over the size of the smaller one. Other points need [`HIT`] for a normal.
const ROUND_HIT: f64 = 1e-12;
/// Distance of bodies that are near each other, over the size of the smaller, and their largest turn with the same contacts.
const NEAR: f64 = 1e-2;
const LARGEST_TURN: f64 = 0.5;

/// Path of a body during a piece: a parabola that begins with the velocity at the start, and a free rotation.
pub(crate) struct BodyPath<'a> {
    start: &'a Mover,
    end: &'a Mover,
    length: f64,
}

impl BodyPath<'_> {
    /// Body after a time.
    pub fn mover(&self, time: f64) -> Mover {
        let position = self.start.position + time * (self.start.velocity + time * self.bend());
        let mover = Mover { position, spin: self.end.spin, ..*self.start };
        Mover { orientation: mover.turned(time), ..mover }
    }

    /// Pose after a time.
    fn at(&self, time: f64) -> Pose {
        self.mover(time).pose()
    }

    /// Half the acceleration [m/s²].
    fn bend(&self) -> DVec3 {
        (self.end.position - self.start.position - self.length * self.start.velocity) / (self.length * self.length)
    }

    fn velocity(&self, time: f64) -> DVec3 {
        self.start.velocity + 2.0 * time * self.bend()
    }

    /// Largest speed of surface points by rotation [m/s].
    fn turning(&self) -> f64 {
        self.end.angular_velocity().length() * self.end.arm
    }
}

impl Island {
    /// Time of the first impact on the paths of a piece.
    pub(super) fn first_impact(&self, shapes: &[SolidShape], start: &[Mover], length: f64) -> Option<f64> {
        let paths: Vec<BodyPath<'_>> =
            start.iter().zip(&self.movers).map(|(start, end)| BodyPath { start, end, length }).collect();
        let mut first = None;
        let mut known = 0;
        for (index, pair) in self.pairs.iter().enumerate() {
            let count = self.contacts[known..].iter().take_while(|contact| contact.pair == index).count();
            let contacts = &self.contacts[known..known + count];
            known += count;
            let closed = |contact: &&GroupContact| contact.held || contact.gap(&paths, 0.0) <= CLOSED * pair.size;
            let until = first.unwrap_or(length);
            let time = if contacts.iter().any(|contact| closed(&contact)) {
                let turning: f64 = pair.bodies.iter().map(|&body| paths[body].turning()).sum();
                let known = until.min(LARGEST_TURN * pair.size / turning);
                let open = contacts.iter().filter(|contact| !contact.held);
                let falls = open.filter_map(|each| closes(|at| each.gap(&paths, at), (0.0, known), (&each.point, pair.size)));
                let mut first = falls.reduce(f64::min).or((known < until).then_some(known));
                for _ in 0..MOST_FEATURES {
                    let end = first.unwrap_or(known);
                    let others = self.others_that_close(pair, contacts, &paths, shapes, end);
                    let Some(earlier) = others.into_iter().reduce(f64::min) else {
                        if self.deepens(pair, &paths, shapes, end) {
                            first = Some(0.5 * end);
                            continue;
                        }
                        break;
                    };
                    first = Some(earlier);
                }
                first
            } else {
                self.approach(pair, &paths, shapes, until)
            };
            first = time.or(first);
        }
        let limit = self.first_limit(&paths, first.unwrap_or(length));
        limit.or(first)
    }

    /// Paths and shapes of a pair, and the dimension.
    fn sides<'a>(
        &self,
        pair: &BodyPair,
        paths: &'a [BodyPath<'a>],
        shapes: &'a [SolidShape],
    ) -> ([&'a BodyPath<'a>; 2], [&'a SolidShape; 2], usize) {
        let of_shape = |body: usize| &shapes[self.surfaces[body].shape];
        (pair.bodies.map(|body| &paths[body]), pair.bodies.map(of_shape), if self.planar { 2 } else { 3 })
    }

    /// Times until `until` at which features of a pair meet beside its contacts, as its bodies turn.
    fn others_that_close(
        &self,
        pair: &BodyPair,
        contacts: &[GroupContact],
        paths: &[BodyPath<'_>],
        shapes: &[SolidShape],
        until: f64,
    ) -> Vec<f64> {
        let ([one, other], [first, second], dimension) = self.sides(pair, paths, shapes);
        let mut points = Vec::new();
        collision::contacts((first, &one.at(until)), (second, &other.at(until)), 0.0, dimension, &mut points);
        let normal = (other.at(until).position - one.at(until).position).try_normalize().unwrap_or(DVec3::X);
        let gap = |point: &ContactPoint, at: f64| point.at([&one.at(at), &other.at(at)], normal).gap;
        let is_new = |point: &&ContactPoint| contacts.iter().all(|contact| contact.point.feature != point.feature);
        points.iter().filter(is_new).filter_map(|point| closes(|at| gap(point, at), (0.0, until), (point, pair.size))).collect()
    }

    /// Whether a pair overlaps deeper after a time than at the start.
    fn deepens(&self, pair: &BodyPair, paths: &[BodyPath<'_>], shapes: &[SolidShape], time: f64) -> bool {
        let ([one, other], [first, second], dimension) = self.sides(pair, paths, shapes);
        let depth = |time: f64| {
            let mut found = Vec::new();
            collision::separations((first, &one.at(time)), (second, &other.at(time)), 0.0, dimension, &mut found);
            -found.iter().map(|each| each.0).fold(0.0, f64::min)
        };
        let turning = time * (one.turning() + other.turning());
        let way = time * (one.velocity(time) - other.velocity(time)).length() + turning;
        // Contacts that are held are closed at the ends of a path: in between, it is the chord of an arc.
        let chord = 0.125 * turning * turning / pair.size;
        way > CLOSED * pair.size && depth(time) > depth(0.0) + chord + CLOSED * pair.size
    }

    /// Time until `until` at which the gap of a pair closes. Conservative advancement leads to where the bodies are near each
    /// other: each pair of convex parts has a gap along its own normal. From there on their contacts are followed.
    fn approach(&self, pair: &BodyPair, paths: &[BodyPath<'_>], shapes: &[SolidShape], until: f64) -> Option<f64> {
        let ([one, other], [first, second], dimension) = self.sides(pair, paths, shapes);
        let turning = one.turning() + other.turning();
        let bend = one.bend() - other.bend();
        let mut found = Vec::new();
        let (mut time, mut stride) = (0.0, LARGEST_TURN * pair.size / turning);
        for _ in 0..MOST_ADVANCES {
            let velocity = one.velocity(time) - other.velocity(time);
            let left = until - time;
            let reach = (velocity.length() + turning + bend.length() * left) * left + HIT * pair.size;
            collision::separations((first, &one.at(time)), (second, &other.at(time)), reach, dimension, &mut found);
            let least = found.iter().map(|each| each.0).fold(f64::INFINITY, f64::min);
            if least <= HIT * pair.size {
                return Some(time);
            }
            if least <= NEAR * pair.size {
                let next = until.min(time + stride);
                let mut points = Vec::new();
                collision::contacts((first, &one.at(time)), (second, &other.at(time)), reach, dimension, &mut points);
                let normal = (other.at(time).position - one.at(time).position).try_normalize().unwrap_or(DVec3::X);
                let gap = |point: &ContactPoint, at: f64| point.at([&one.at(at), &other.at(at)], normal).gap;
                let falls = points.iter().filter_map(|point| closes(|at| gap(point, at), (time, next), (point, pair.size)));
                let closed = falls.reduce(f64::min);
                let end = closed.unwrap_or(next);
                collision::separations((first, &one.at(end)), (second, &other.at(end)), reach, dimension, &mut found);
                if found.iter().any(|each| each.0 < -CLOSED * pair.size) {
                    // Other features meet in between.
                    stride = 0.5 * (end - time);
                } else if closed.is_some() {
                    return closed;
                } else if next < until {
                    time = next;
                } else {
                    return None;
                }
                continue;
            }
            let mut wait = f64::INFINITY;
            for &(gap, normal) in &found {
                // The gap is at least gap − speed·t − bend·t² after a time t.
                let speed = normal.dot(velocity) + turning;
                let bend = normal.dot(bend).max(0.0);
                let denominator = speed + (speed * speed + 4.0 * bend * gap).sqrt();
                if denominator > 0.0 {
                    wait = wait.min(2.0 * gap / denominator);
                }
            }
            time += wait;
            if time >= until {
                return None;
            }
        }
        Some(time)
    }
}

impl GroupContact {
    fn gap(&self, paths: &[BodyPath<'_>], time: f64) -> f64 {
        let [one, other] = self.bodies.map(|body| paths[body].at(time));
        self.point.at([&one, &other], self.touch.normal).gap
    }
}

/// Time between two times at which the gap of an open contact of bodies of a size closes, if it is closed at the end.
fn closes(gap: impl Fn(f64) -> f64, (from, until): (f64, f64), (point, size): (&ContactPoint, f64)) -> Option<f64> {
    let least = size * if point.radii == [0.0; 2] { HIT } else { ROUND_HIT };
    let end = gap(until) - least;
    if end >= 0.0 {
        return None;
    }
    let mut low = (from, gap(from) - least);
    if low.1 <= 0.0 {
        // The contact opens first: begin at the top of the parabola through its ends.
        let span = until - from;
        let step = 1e-3 * span;
        let rate = (gap(from + step) - least - low.1) / step;
        let top = 0.5 * rate * span * span / (rate * span - (end - low.1));
        low = (from + top, gap(from + top) - least);
        if !(top > 0.0 && top < span && low.1 > 0.0) {
            return None;
        }
    }
    Some(first_zero(low, (until, end), 0.1 * least, |time| gap(time) - least))
}

/// Time at which a gap falls to 0, to a tolerance [m], between times with their gaps, by the Illinois method.
pub(crate) fn first_zero(mut low: (f64, f64), mut high: (f64, f64), tolerance: f64, gap: impl Fn(f64) -> f64) -> f64 {
    let until = high.0;
    let mut side = 0;
    for _ in 0..MOST_ADVANCES {
        let time = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let gap = gap(time);
        if gap.abs() <= tolerance || high.0 - low.0 <= f64::EPSILON * until {
            return time;
        }
        if gap > 0.0 {
            low = (time, gap);
            high.1 *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            high = (time, gap);
            low.1 *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        }
    }
    low.0
}

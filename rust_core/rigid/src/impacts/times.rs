//! Times of impact on the paths of a piece.

use super::paths::{BodyPath, PairPaths};
use crate::contact::ContactPoint;
use crate::island::{BodyPair, CLOSED, GroupContact, HIT, Island};
use crate::mover::Mover;
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
            let sides = self.paths(pair, &paths, shapes);
            let gap = |contact: &GroupContact, time: f64| sides.gap(&contact.point, time, contact.touch.normal);
            let closed = |contact: &GroupContact| contact.held || gap(contact, 0.0) <= CLOSED * pair.size;
            let until = first.unwrap_or(length);
            let time = if contacts.iter().any(closed) || touches_hidden(pair, &sides) {
                let known = until.min(LARGEST_TURN * pair.size / sides.turning());
                let open = contacts.iter().filter(|contact| !contact.held);
                let falls = open.filter_map(|each| closes(|at| gap(each, at), (0.0, known), (&each.point, pair.size)));
                let mut first = falls.reduce(f64::min).or((known < until).then_some(known));
                for _ in 0..MOST_FEATURES {
                    let end = first.unwrap_or(known);
                    let others = others_that_close(pair, contacts, &sides, end);
                    let Some(earlier) = others.into_iter().reduce(f64::min) else {
                        if deepens(pair, &sides, end) {
                            first = Some(0.5 * end);
                            continue;
                        }
                        break;
                    };
                    first = Some(earlier);
                }
                first
            } else {
                approach(pair, &sides, until)
            };
            first = time.or(first);
        }
        let limit = self.first_limit(&paths, first.unwrap_or(length));
        limit.or(first)
    }
}

/// Whether a body touches a face or a corner that may have no contact with it, because other faces or corners have.
fn touches_hidden(pair: &BodyPair, sides: &PairPaths) -> bool {
    let mut found = Vec::new();
    if sides.may_hide() {
        sides.separations(0.0, CLOSED * pair.size, &mut found);
    }
    found.iter().any(|each| each.0 <= CLOSED * pair.size)
}

/// Times until `until` at which features of a pair meet beside its contacts, as its bodies turn.
fn others_that_close(pair: &BodyPair, contacts: &[GroupContact], sides: &PairPaths, until: f64) -> Vec<f64> {
    let mut points = Vec::new();
    sides.contacts(until, 0.0, &mut points);
    let normal = sides.direction(until);
    let gap = |point: &ContactPoint, at: f64| sides.gap(point, at, normal);
    let is_new = |point: &&ContactPoint| contacts.iter().all(|contact| contact.point.feature != point.feature);
    points.iter().filter(is_new).filter_map(|point| closes(|at| gap(point, at), (0.0, until), (point, pair.size))).collect()
}

/// Whether a pair overlaps deeper after a time than at the start.
fn deepens(pair: &BodyPair, sides: &PairPaths, time: f64) -> bool {
    let depth = |time: f64| {
        let mut found = Vec::new();
        sides.separations(time, 0.0, &mut found);
        -found.iter().map(|each| each.0).fold(0.0, f64::min)
    };
    let turning = time * sides.turning();
    let way = time * sides.velocity(time).length() + turning;
    // Contacts that are held are closed at the ends of a path: in between, it is the chord of an arc.
    let chord = 0.125 * turning * turning / pair.size;
    way > CLOSED * pair.size && depth(time) > depth(0.0) + chord + CLOSED * pair.size
}

/// Time until `until` at which the gap of a pair closes. Conservative advancement leads to where the bodies are near each
/// other: each pair of convex parts has a gap along its own normal. From there on their contacts are followed.
fn approach(pair: &BodyPair, sides: &PairPaths, until: f64) -> Option<f64> {
    let (turning, bend) = (sides.turning(), sides.bend());
    let mut found = Vec::new();
    let (mut time, mut stride) = (0.0, LARGEST_TURN * pair.size / turning);
    for _ in 0..MOST_ADVANCES {
        let velocity = sides.velocity(time);
        let left = until - time;
        let reach = (velocity.length() + turning + bend.length() * left) * left + HIT * pair.size;
        sides.separations(time, reach, &mut found);
        let least = found.iter().map(|each| each.0).fold(f64::INFINITY, f64::min);
        if least <= HIT * pair.size {
            return Some(time);
        }
        if least <= NEAR * pair.size {
            let next = until.min(time + stride);
            let mut points = Vec::new();
            sides.contacts(time, reach, &mut points);
            let normal = sides.direction(time);
            let gap = |point: &ContactPoint, at: f64| sides.gap(point, at, normal);
            let falls = points.iter().filter_map(|point| closes(|at| gap(point, at), (time, next), (point, pair.size)));
            let closed = falls.reduce(f64::min);
            let end = closed.unwrap_or(next);
            sides.separations(end, reach, &mut found);
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

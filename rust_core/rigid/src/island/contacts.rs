//! Contacts of a group.

use glam::DVec3;

use super::Island;
use crate::contact::{ContactPoint, Touch};
use crate::face::{FACES, GroupValues, NetFace, SecondSide};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rows::{BodyVelocities, ContactImpulse, ContactRow};
use crate::shapes::SolidShape;
use crate::surface::Friction;

/// Way of two bodies against each other in which their contacts last, over the thickness of the thinner one. It may add as much to
/// an overlap.
const LASTING: f64 = 0.01;

/// Identity of a contact: the two bodies, and the features that touch.
pub type ContactKey = (u32, u32, u32);

/// Contact of two bodies of a group.
#[derive(Debug, Clone, Copy)]
pub struct GroupContact {
    /// Index of the pair.
    pub pair: usize,
    pub bodies: [usize; 2],
    pub key: ContactKey,
    pub point: ContactPoint,
    /// Contact at the present poses.
    pub touch: Touch,
    pub friction: Friction,
    pub restitution: f64,
    /// Mean force and moment of the last piece.
    pub load: ContactImpulse,
    /// Whether a row holds the contact in this piece, and whether it opens at the start, in a bounce of less than a step.
    pub held: bool,
    pub bounces: bool,
}

/// Search for the contacts of a pair.
#[derive(Debug, Clone, Copy)]
pub struct ContactSearch {
    /// Largest gap of the contacts that were found [m].
    reach: f64,
    /// Lower bound of the distance of the bodies, 0 if there is none [m].
    clearance: f64,
    /// Vector from the first body to the second [m], and ways of their surface points by turning before [m].
    between: DVec3,
    turned: f64,
}

impl ContactSearch {
    /// Whether the contacts are those within a reach [m] of bodies that have moved against each other since, unless by more than
    /// a length [m].
    fn lasts(&self, between: DVec3, turned: f64, (reach, most): (f64, f64)) -> bool {
        let moved = between.distance(self.between) + (turned - self.turned);
        reach + moved < self.clearance || (moved <= most && reach + moved <= self.reach)
    }
}

impl Island {
    /// Poses of all bodies and faces.
    pub fn poses(&self) -> GroupValues<Pose> {
        let faces = self.faces.iter().map(|face| self.face_pose(face)).collect();
        GroupValues { bodies: self.movers.iter().map(Mover::pose).collect(), faces }
    }

    /// Frame of a face.
    fn face_pose(&self, face: &NetFace) -> Pose {
        face.pose(|corner| self.movers[corner as usize].position)
    }

    /// Takes over the loads of contacts from the last step, which are in the order of their keys.
    pub fn remember(&mut self, loads: &[(ContactKey, ContactImpulse)]) {
        self.past.clear();
        let mut place = 0;
        for pair in &self.pairs {
            place = seek(loads, place, pair.key);
            let own = loads[place..].iter().take_while(|(key, _)| (key.0, key.1) == pair.key);
            self.past.extend(own);
        }
    }

    /// Finds the contacts of all pairs within their reach. Contacts that were there before keep their loads.
    pub fn find_contacts(&mut self, shapes: &[SolidShape]) {
        self.forget_contacts();
        self.renew_contacts(shapes, true);
    }

    /// Lets all contacts be found anew.
    pub fn forget_contacts(&mut self) {
        self.pairs.iter_mut().for_each(|pair| pair.found = None);
        self.poses = GroupValues::default();
        for (turned, count) in [(&mut self.turned.bodies, self.movers.len()), (&mut self.turned.faces, self.faces.len())] {
            turned.clear();
            turned.resize(count, 0.0);
        }
    }

    /// Finds the contacts within the reach of those pairs that have moved against each other since the last search. Others keep
    /// their points. Unless this is the last sweep of a step, contacts are found a little farther, so that they last.
    pub fn renew_contacts(&mut self, shapes: &[SolidShape], is_last: bool) {
        let poses = self.poses();
        let turned = self.turned.bodies.iter_mut().zip(&self.movers);
        for (((turned, mover), pose), last) in turned.zip(&poses.bodies).zip(&self.poses.bodies) {
            *turned += mover.arm * pose.turn_from(last);
        }
        let turned = self.turned.faces.iter_mut().zip(&self.faces);
        for (((turned, face), pose), last) in turned.zip(&poses.faces).zip(&self.poses.faces) {
            *turned += face.way_from(pose, last);
        }
        let before = std::mem::replace(&mut self.contacts, std::mem::take(&mut self.known));
        let mut points = Vec::new();
        let (mut known, mut place) = (0, 0);
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            let [one, other] = pair.bodies;
            let (first, second) = (&self.surfaces[one], self.surfaces.get(other));
            while known < before.len() && before[known].pair < index {
                known += 1;
            }
            let between = poses[other].position - poses[one].position;
            let turned = self.turned[one] + self.turned[other];
            let slack = LASTING * pair.thickness;
            if pair.found.is_some_and(|found| found.lasts(between, turned, (pair.reach, slack))) {
                let past = before[known..].iter().take_while(|contact| contact.pair == index);
                self.contacts.extend(past.map(|contact| GroupContact { touch: contact.at(&poses), ..*contact }));
                continue;
            }
            let reach = if is_last { pair.reach } else { pair.reach + slack };
            points.clear();
            let dimension = if self.planar { 2 } else { 3 };
            let side = second
                .map_or_else(|| SecondSide::Face(&self.faces[other - FACES]), |second| SecondSide::Body(&shapes[second.shape]));
            let beside = if second.is_some() { self.beside.of(other) } else { &[] };
            let net = (beside, |corner: u32| poses.bodies[corner as usize].position);
            let body = (&shapes[first.shape], &poses[one]);
            let clearance = side.contacts(body, (&poses[other], net), (reach, dimension), &mut points);
            pair.found = Some(ContactSearch { reach, clearance: clearance.unwrap_or(0.0), between, turned });
            place = seek(&self.past, place, pair.key);
            let past = before[known..].iter().take_while(|contact| contact.pair == index);
            for &point in &points {
                let last = past.clone().find(|contact| contact.key.2 == point.feature);
                let places = [&poses[one], &poses[other]];
                // A new contact has the normal with which it was found, unless its points coincide.
                let fallback = last.map_or_else(|| point.at(places, DVec3::ZERO).normal, |contact| contact.touch.normal);
                let fallback = if fallback == DVec3::ZERO { between.try_normalize().unwrap_or(DVec3::X) } else { fallback };
                self.contacts.push(GroupContact {
                    pair: index,
                    bodies: pair.bodies,
                    key: (pair.key.0, pair.key.1, point.feature),
                    point,
                    touch: touch_of(&point, pair.bodies, &poses, fallback),
                    friction: second.map_or_else(
                        || Friction::on_face(first.friction),
                        |second| Friction::between(first.friction, second.friction),
                    ),
                    restitution: second.map_or(first.restitution, |second| first.restitution.max(second.restitution)),
                    load: last.map_or_else(
                        || {
                            let mut own = self.past[place..].iter().take_while(|(key, _)| (key.0, key.1) == pair.key);
                            own.find(|(key, _)| key.2 == point.feature).map_or_else(ContactImpulse::default, |own| own.1)
                        },
                        |contact| contact.load,
                    ),
                    held: false,
                    bounces: false,
                });
            }
        }
        self.known = before;
        self.known.clear();
        self.poses = poses;
    }

    /// Row of a contact at the present poses.
    pub fn row(&self, contact: &GroupContact, v: &BodyVelocities) -> Option<ContactRow> {
        ContactRow::new(contact.bodies, self.arms(contact), contact.touch.normal, contact.friction, v)
    }

    /// Arms from the centers of the bodies to a contact at the present poses [m]; coordinates of its point on a face.
    pub fn arms(&self, contact: &GroupContact) -> [DVec3; 2] {
        let [one, other] = contact.bodies;
        let (point, second) = if let Some(mover) = self.movers.get(other) {
            (contact.touch.point, contact.touch.point - mover.position)
        } else {
            let face = &self.faces[other - FACES];
            let pose = self.face_pose(face);
            let coordinates = face.coordinates(&pose, contact.touch.point);
            (pose.point(coordinates), coordinates)
        };
        [point - self.movers[one].position, second]
    }

    /// Evaluates all contacts at the present poses.
    pub fn renew_touches(&mut self) {
        let poses = self.poses();
        for contact in &mut self.contacts {
            contact.touch = contact.at(&poses);
        }
    }
}

impl GroupContact {
    /// Contact at poses of the bodies of the group.
    pub fn at(&self, poses: &GroupValues<Pose>) -> Touch {
        touch_of(&self.point, self.bodies, poses, self.touch.normal)
    }

    /// Whether the second body is a face.
    fn has_face(&self) -> bool {
        self.bodies[1] >= FACES
    }

    /// Points of a contact that friction holds: in the frames of the two bodies, with the arm from there to the contact [m].
    /// A rounded body is held at its core, so that it rolls.
    pub fn anchors(&self, poses: &GroupValues<Pose>) -> [(DVec3, DVec3); 2] {
        std::array::from_fn(|side| {
            let pose = &poses[self.bodies[side]];
            let mut radius = self.point.radii[side];
            if self.has_face() && side == 1 {
                return (pose.rotation.inverse() * (self.touch.point - pose.position), DVec3::ZERO);
            }
            if radius > 0.0 {
                radius += if self.has_face() { self.touch.gap + self.point.radii[1] } else { 0.0 };
                let core = self.touch.point - radius * if side == 0 { 1.0 } else { -1.0 } * self.touch.normal;
                (pose.local_point(core), self.touch.point - core)
            } else {
                (pose.local_point(self.touch.point), DVec3::ZERO)
            }
        })
    }

    /// Way that the second body's point of contact moved against the first's [m], to these poses.
    pub fn way(&self, anchors: &[(DVec3, DVec3); 2], poses: &GroupValues<Pose>, middle: &BodyVelocities, length: f64) -> DVec3 {
        let [one, other] = std::array::from_fn(|side| {
            let body = self.bodies[side];
            let (local, arm) = anchors[side];
            let rolled = middle.bodies.get(body).map_or(DVec3::ZERO, |body| length * (body.at(arm) - body.at(DVec3::ZERO)));
            poses[body].point(local) + rolled + arm
        });
        other - one
    }
}

/// Contact of two bodies at poses of a group. Its point on a face is halfway through the thickness.
fn touch_of(point: &ContactPoint, bodies: [usize; 2], poses: &GroupValues<Pose>, fallback: DVec3) -> Touch {
    let mut touch = point.at(bodies.map(|body| &poses[body]), fallback);
    if bodies[1] >= FACES {
        touch.point += (0.5 * touch.gap + point.radii[1]) * touch.normal;
    }
    touch
}

/// Place from `place` on of the first load of a pair, or of the next one, in ascending order.
fn seek(loads: &[(ContactKey, ContactImpulse)], place: usize, pair: (u32, u32)) -> usize {
    const NEAR: usize = 8;
    let below = |(key, _): &(ContactKey, ContactImpulse)| (key.0, key.1) < pair;
    let near = loads[place..].iter().take(NEAR).take_while(|load| below(load)).count();
    if near < NEAR { place + near } else { place + loads[place..].partition_point(below) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies keep their contacts while they turn or move against each other by no more than a length, and reach no farther.
    #[test]
    fn contacts_last_as_long_as_bodies_hardly_move() {
        let search = ContactSearch { reach: 0.25, clearance: 0.0, between: DVec3::X, turned: 0.5 };
        let most = 0.125;
        assert!(search.lasts(DVec3::X, 0.5, (0.25, most)));
        assert!(search.lasts(DVec3::X + 0.0625 * DVec3::Y, 0.5625, (0.125, most)));
        assert!(!search.lasts(DVec3::X + 0.0625 * DVec3::Y, 0.625, (0.0, most)));
        assert!(!search.lasts(DVec3::X + 0.125 * DVec3::Y, 0.5, (0.1875, most)));
        let apart = ContactSearch { clearance: 1.0, ..search };
        assert!(apart.lasts(DVec3::X + 0.5 * DVec3::Y, 0.625, (0.25, most)));
        assert!(!apart.lasts(DVec3::X + 0.5 * DVec3::Y, 0.75, (0.25, most)));
    }
}

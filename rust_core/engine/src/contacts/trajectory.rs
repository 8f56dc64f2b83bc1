//! Motion of one particle through one step, from impact to impact.
//!
//! **Path.** The mean acceleration ā = (v₁ − v₀)/h of the step is kept, with or without contacts. Up to the first contact at
//! t the particle follows the integrator's path. Its velocity there is v₀ + ā t, so that kinetic and potential energy are
//! those of the integrator. Afterwards the slope of the path is the velocity.
//!
//! **Impact.** An impact returns −e times the normal velocity. Friction reduces the slip by μ (1 + e) |vₙ|, at most to zero
//! (Coulomb). The energy loss per mass is ½ (1 − e²) vₙ² + ½ (|vₜ|² − |vₜ⁺|²): exactly 0 for e = 1 and μ = 0.
//!
//! **Rest.** A series of decaying rebounds lasts 2 e |vₙ| / ((1 − e) p), where p is the acceleration into the wall. If the
//! series ends within the step, the impact is taken as plastic. The total impulse over the series is |vₙ| (plus p times the
//! time) in either case, so that the end of the step is the same. An impact is also plastic if the next rebound would not
//! rise above rounding. After a plastic impact the particle slides ([`super::support`]).
//!
//! **Limits.** After [`EVENTS`] impacts and slides a particle keeps its position and velocity until the end of the step.
//! Energy stays exact and no wall is crossed. The error is the phase of a motion that dt does not resolve. A particle also
//! keeps its state if its path would end in the ground of a height field. In a corner of the ground, rounding may hide all
//! faces from a point.

use arrayvec::ArrayVec;
use glam::DVec3;

use super::support::{Slip, Support};
use super::{ContactWall, Key, LEFT, WITHIN};
use crate::boundaries::{Path, Piece, Wall};

/// Maximum number of impacts and slides within one step.
const EVENTS: usize = 64;
/// Maximum number of simultaneous contacts of a particle.
const MOST_CONTACTS: usize = 12;

/// Walls that one particle can touch.
#[derive(Clone, Copy)]
pub(super) struct ParticleWalls<'a> {
    pub surfaces: &'a [ContactWall],
    pub body: usize,
    pub radius: f64,
    /// Machine epsilon ε of the state's precision.
    pub rounding: f64,
}

/// Final state of a step with contacts.
pub(super) struct TrajectoryEnd {
    pub position: DVec3,
    pub velocity: DVec3,
    /// Kinetic energy per mass dissipated in contacts [J/kg].
    pub lost: f64,
}

/// Contact of a particle with a wall.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Contact {
    /// Surface, or its part.
    pub key: Key,
    /// Unit normal into the allowed side.
    pub normal: DVec3,
    /// Curvature κ [1/m] along the velocity. Sliding with velocity v takes a normal acceleration −κ v².
    pub curvature: f64,
    /// Largest curvature in magnitude [1/m].
    pub bend: f64,
    /// Coulomb's coefficient of friction μ.
    pub friction: f64,
    /// Contact tolerance [m].
    slack: f64,
}

/// Contacts of a particle.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactSet {
    items: ArrayVec<Contact, MOST_CONTACTS>,
}

impl ContactSet {
    pub fn as_slice(&self) -> &[Contact] {
        &self.items
    }

    /// Adds a contact. If its normal agrees with the normal of another contact with the same surface within the rounding
    /// error `blur`, that normal is used. Faces in one plane then do not form a valley.
    fn add_part(&mut self, mut contact: Contact, blur: f64) {
        let is_same = |other: &&Contact| {
            other.key.surface == contact.key.surface && (other.normal - contact.normal).length_squared() <= blur * blur
        };
        if let Some(same) = self.as_slice().iter().find(is_same) {
            contact.normal = same.normal;
        }
        self.add(contact);
    }

    /// Adds a contact, unless there are already [`MOST_CONTACTS`].
    pub fn add(&mut self, contact: Contact) {
        let _ = self.items.try_push(contact);
    }

    pub fn contain(&self, key: Key) -> bool {
        self.as_slice().iter().any(|contact| contact.key == key)
    }
}

impl<'a> ParticleWalls<'a> {
    /// Integrates a step of `h` seconds with contacts; None without contact. The integrator took this step along `path` from
    /// the velocity `start`.
    pub fn trajectory(&self, path: &Path, start: DVec3, h: f64) -> Option<TrajectoryEnd> {
        let Some((time, key)) = self.first(path, h, &self.contacts(path.position, start, None), None) else {
            return self.buries(path.at(h)).then_some(TrajectoryEnd { position: path.position, velocity: start, lost: 0.0 });
        };
        let trajectory = Trajectory {
            walls: *self,
            position: path.at(time),
            velocity: start + path.acceleration * time,
            acceleration: path.acceleration,
            left: h - time,
            lost: 0.0,
        };
        Some(trajectory.finish(key))
    }

    /// Pieces of walls within reach of the particle in an axis-aligned box.
    fn acting(&self, bounds: (DVec3, DVec3)) -> impl Iterator<Item = (Key, &'a ContactWall, Piece<'a>)> {
        let Self { surfaces, body, radius, rounding } = *self;
        let surfaces = surfaces.iter().enumerate().filter(move |(_, surface)| surface.bodies[body]);
        surfaces.flat_map(move |(index, surface)| {
            let pieces = surface.pieces(rounding, bounds, radius);
            pieces.map(move |piece| (Key { surface: index, part: piece.part() }, surface, piece))
        })
    }

    /// Surface, or part of one, of a key.
    fn piece(&self, key: Key) -> Piece<'a> {
        self.surfaces[key.surface].wall.piece(key.part)
    }

    /// Contacts of a particle at `x` with a velocity. `hit` is one of them irrespective of rounding.
    fn contacts(&self, x: DVec3, velocity: DVec3, hit: Option<Key>) -> ContactSet {
        let mut contacts = ContactSet::default();
        for (key, surface, piece) in self.acting((x, x)) {
            let slack = surface.slack(self.rounding, x, self.radius);
            let (distance, normal) = piece.distance(x, self.radius + 2.0 * slack, WITHIN);
            if distance - self.radius <= slack || hit == Some(key) {
                let [curvature, bend] =
                    [velocity.normalize_or_zero(), DVec3::ZERO].map(|direction| piece.curvature(x, direction));
                let contact = Contact { key, normal, curvature, bend, friction: surface.friction, slack };
                contacts.add_part(contact, piece.blur());
            }
        }
        contacts
    }

    /// First contact along `path` within `duration`, except with the walls that the particle slides on. The particle leaves
    /// the other walls that it touches: an immediate contact with one of these is rounding, and does not count.
    fn first(&self, path: &Path, duration: f64, contacts: &ContactSet, slides: Option<&ContactSet>) -> Option<(f64, Key)> {
        let mut first = None;
        let mut duration = duration;
        for (key, _, piece) in self.acting(path.bounds(duration)) {
            if slides.is_some_and(|slides| slides.contain(key)) {
                continue;
            }
            let touching = contacts.contain(key);
            let time = piece.first_contact(path, self.radius, touching, duration);
            if let Some(time) = time.filter(|&time| time > 0.0 || !touching || slides.is_none()) {
                first = Some((time, key));
                duration = time;
            }
        }
        first
    }

    /// Whether `x` is in the ground of a height field by more than rounding. A path that ends there has slipped through
    /// between faces, and is rejected.
    fn buries(&self, x: DVec3) -> bool {
        let mut surfaces = self.surfaces.iter().filter(|surface| surface.bodies[self.body]);
        surfaces.any(|surface| surface.wall.covers(x, surface.slack(self.rounding, x, self.radius)))
    }

    /// Projects `x` onto the walls that the particle slides on.
    fn onto(&self, slides: &ContactSet, mut x: DVec3) -> DVec3 {
        let gap = |contact: &Contact, x: DVec3| {
            let (distance, normal) = self.piece(contact.key).surface(x);
            (self.radius - distance, normal)
        };
        match slides.as_slice() {
            [one] => {
                let (push, normal) = gap(one, x);
                x + normal * push
            }
            [one, other] => {
                // Newton's method: exact at once on planes. From this near, two rounds converge to rounding on curved walls.
                for _ in 0..2 {
                    let ((first, one), (second, other)) = (gap(one, x), gap(other, x));
                    let [first, second] = pushes(one.dot(other), first, second);
                    x += one * first + other * second;
                }
                x
            }
            _ => x,
        }
    }
}

/// Coefficients of two unit normals with the scalar product `cosine`. The projections of their sum on the normals are `first`
/// and `second`. For parallel normals both are 0.
pub(super) fn pushes(cosine: f64, first: f64, second: f64) -> [f64; 2] {
    let determinant = 1.0 - cosine * cosine;
    if determinant <= f64::EPSILON {
        return [0.0; 2];
    }
    [(first - cosine * second) / determinant, (second - cosine * first) / determinant]
}

/// State of a particle along its trajectory.
struct Trajectory<'a> {
    walls: ParticleWalls<'a>,
    position: DVec3,
    velocity: DVec3,
    /// Mean acceleration of the step ā [m/s²].
    acceleration: DVec3,
    /// Remaining time of the step [s].
    left: f64,
    /// Kinetic energy per mass dissipated so far [J/kg].
    lost: f64,
}

impl Trajectory<'_> {
    /// Integrates from the contact with one wall to the end of the step.
    fn finish(mut self, key: Key) -> TrajectoryEnd {
        let mut hit = Some(key);
        for _ in 0..EVENTS {
            let contacts = self.walls.contacts(self.position, self.velocity, hit);
            if let Some(contact) = self.approached(&contacts) {
                self.bounce(&contact);
                hit = Some(contact.key);
            } else if self.left > 0.0 {
                hit = self.go_on(&contacts);
            } else {
                break;
            }
        }
        TrajectoryEnd { position: self.position, velocity: self.velocity, lost: self.lost }
    }

    /// Rounding error of a normal speed [m/s].
    fn still(&self) -> f64 {
        8.0 * f64::EPSILON * (self.velocity.length() + self.acceleration.length() * self.left)
    }

    /// Contact with the largest approach speed.
    fn approached(&self, contacts: &ContactSet) -> Option<Contact> {
        let mut fastest = (-self.still(), None);
        for contact in contacts.as_slice() {
            let speed = contact.normal.dot(self.velocity);
            if speed < fastest.0 {
                fastest = (speed, Some(*contact));
            }
        }
        fastest.1
    }

    fn bounce(&mut self, contact: &Contact) {
        let ContactWall { restitution, friction, .. } = self.walls.surfaces[contact.key.surface];
        // Division by n²: a normal whose length is off by rounding must not add energy at every bounce.
        let normal = contact.normal / contact.normal.length_squared();
        let speed = -normal.dot(self.velocity);
        let slip = self.velocity + contact.normal * speed;
        let press = -(contact.normal.dot(self.acceleration) + contact.curvature * slip.length_squared());
        let rebound = restitution * speed;
        let settles =
            2.0 * rebound <= (1.0 - restitution) * press * self.left || rebound * rebound <= 2.0 * press * contact.slack;
        let restitution = if settles { 0.0 } else { restitution };
        let slipping = slip.length();
        let stopped = (friction * (1.0 + restitution) * speed).min(slipping);
        let kept = slipping - stopped;
        self.lost += 0.5 * ((1.0 - restitution) * (1.0 + restitution) * speed * speed + stopped * (slipping + kept));
        let share = if stopped > 0.0 { kept / slipping } else { 1.0 };
        self.velocity = slip * share + contact.normal * (restitution * speed);
    }

    /// Advances to the next event, freely or sliding; returns the key of the next contact.
    fn go_on(&mut self, contacts: &ContactSet) -> Option<Key> {
        let still = self.still();
        match Support::of(contacts, &mut self.velocity, self.acceleration, self.left, still) {
            None => self.fall(contacts),
            Some(support) => self.slide(contacts, &support),
        }
    }

    fn fall(&mut self, contacts: &ContactSet) -> Option<Key> {
        let path = Path { position: self.position, velocity: self.velocity, acceleration: self.acceleration };
        let next = self.walls.first(&path, self.left, contacts, Some(&ContactSet::default()));
        let time = next.map_or(self.left, |(time, _)| time);
        if next.is_none() && self.walls.buries(path.at(time)) {
            self.left = 0.0;
            return None;
        }
        self.position = path.at(time);
        self.velocity = path.slope(time);
        self.left -= time;
        next.map(|(_, key)| key)
    }

    /// Slides on the supporting walls by a velocity Verlet step within the surface. Friction acts along the velocity at the
    /// middle of the step. On planes this is the exact parabola, and energy is exact. On a sphere the particle stays on the
    /// surface. As in Verlet's method, the error of its energy is O(h²) without drift.
    fn slide(&mut self, contacts: &ContactSet, support: &Support) -> Option<Key> {
        let Slip { acceleration, duration, stops, rests } = support.slip(self.velocity, self.left);
        if rests && duration == 0.0 {
            self.position = self.walls.onto(&support.slides, self.position);
            (self.velocity, self.left) = (DVec3::ZERO, 0.0);
            return None;
        }
        // In units of the duration: the square of a short duration may underflow.
        let way = self.velocity * duration;
        let bend = if support.bend > 0.0 {
            (self.slide_to(support, acceleration, duration) - self.position - way) * 2.0
        } else {
            acceleration * (duration * duration)
        };
        let path = Path { position: self.position, velocity: way, acceleration: bend };
        let next = self.walls.first(&path, 1.0, contacts, Some(&support.slides));
        let time = next.map_or(duration, |(share, _)| share * duration);
        let edge = self.edge(support, acceleration, time);
        let (time, next) = if edge < time { (edge, None) } else { (time, next) };
        let stops = stops && next.is_none() && edge == duration;
        let middle = self.velocity + acceleration * (0.5 * time);
        let end = self.slide_to(support, acceleration, time);
        if next.is_none() && self.walls.buries(end) {
            self.left = 0.0;
            return None;
        }
        self.position = end;
        self.left -= time;
        let drag = support.acceleration - acceleration;
        if support.bend > 0.0 && !stops {
            self.turn(support, middle, drag.length(), time);
        } else {
            self.lost += drag.dot(middle) * time;
            self.velocity += acceleration * time;
        }
        if stops {
            // Exactly zero: friction would decelerate a rounding remainder again and again.
            self.velocity = DVec3::ZERO;
            self.left = if rests { 0.0 } else { self.left };
        }
        next.map(|(_, key)| key)
    }

    /// Time, up to `time`, until which a slide on facets stays on them; beyond an edge the path lifts off. A slide on a part
    /// of a height field stays in its region.
    fn edge(&self, support: &Support, acceleration: DVec3, time: f64) -> f64 {
        let is_flat = support.bend == 0.0;
        let bounded = |contact: &Contact| match self.walls.piece(contact.key) {
            Piece::Whole(wall) => is_flat && matches!(wall, Wall::Solid(_)),
            Piece::Part(..) => true,
        };
        let lifted = |time: f64| {
            let straight = self.position + (self.velocity + acceleration * (0.5 * time)) * time;
            let x = if is_flat { straight } else { self.slide_to(support, acceleration, time) };
            support.slides.as_slice().iter().filter(|contact| bounded(contact)).any(|contact| {
                self.walls.piece(contact.key).distance(x, f64::INFINITY, LEFT).0 - self.walls.radius > LEFT * contact.slack
            })
        };
        if !support.slides.as_slice().iter().any(bounded) || !lifted(time) {
            return time;
        }
        let (mut low, mut high) = (0.0, time);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return high;
            }
            if lifted(middle) { high = middle } else { low = middle }
        }
    }

    /// Final position of a slide with the given tangential acceleration.
    fn slide_to(&self, support: &Support, acceleration: DVec3, time: f64) -> DVec3 {
        let way = (self.velocity + acceleration * (0.5 * time)) * time;
        // A tangent of length R tan φ spans an arc of length R φ: tan φ = φ + φ³/3 + O(φ⁵).
        let angle = support.curvature * support.curvature * way.length_squared();
        self.walls.onto(&support.slides, self.position + way * (1.0 + angle / 3.0))
    }

    /// Second half of a slide on a curved wall. The velocity is rotated into the new tangent plane, where the forces are
    /// evaluated.
    fn turn(&mut self, support: &Support, middle: DVec3, drag: f64, time: f64) {
        let here = support.moved(|key| {
            let piece = self.walls.piece(key);
            let [curvature, bend] =
                [middle.normalize_or_zero(), DVec3::ZERO].map(|direction| piece.curvature(self.position, direction));
            (piece.surface(self.position).1, curvature, bend)
        });
        let speed = middle.length();
        let middle = here.along(middle).normalize_or_zero() * speed;
        let kicked = middle + here.along(self.acceleration) * (0.5 * time);
        let brake = (0.5 * time * here.friction_at(speed)).min(kicked.length());
        self.velocity = kicked - middle.normalize_or_zero() * brake;
        self.lost += (0.5 * time * drag + brake) * speed;
    }
}

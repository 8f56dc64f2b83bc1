//! Resting on walls: which of them carry the particle, and how it slides there.
//!
//! Of the walls that a particle touches without approaching, some push back with accelerations λ ≥ 0 along their normals
//! so that none is entered: n·(a + Σ λ n) ≥ −κ v². One wall suffices, or two along an edge, or all motion ends in a
//! corner; in three dimensions there is nothing else, so these few cases are tried in turn. Friction is μ λ against the
//! slip.

use glam::DVec3;

use super::trajectory::{Contact, ContactSet, pushes};

/// The largest angle through which a slide turns on a curved wall before the wall is looked at again.
const ANGLE: f64 = 0.25;

/// What carries a particle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Support {
    carriers: [Contact; 2],
    count: usize,
    /// Every wall that the particle stays on, carrying or just alongside.
    pub slides: ContactSet,
    /// The step's mean acceleration.
    load: DVec3,
    /// Its part along the surface.
    pub acceleration: DVec3,
    /// The deceleration by friction, Σ μ λ.
    friction: f64,
    /// The largest |κ| of the carriers.
    pub curvature: f64,
}

/// A stretch of sliding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slip {
    /// The acceleration along the surface, friction included.
    pub acceleration: DVec3,
    /// How long it holds [s].
    pub duration: f64,
    /// Whether the slip is then zero.
    pub stops: bool,
    /// Whether the particle then stays where it is.
    pub rests: bool,
}

impl Support {
    /// The support of a particle, or None if it leaves all the walls that it touches. Normal speeds up to `still` are
    /// rounding, and are taken away.
    pub fn of(contacts: &ContactSet, velocity: &mut DVec3, acceleration: DVec3, left: f64, still: f64) -> Option<Self> {
        let mut parallel = ContactSet::default();
        for contact in contacts.as_slice() {
            let speed = contact.normal.dot(*velocity);
            if speed <= still {
                *velocity -= contact.normal * speed;
                parallel.add(*contact);
            }
        }
        let square = velocity.length_squared();
        let tolerance = still / left + 8.0 * f64::EPSILON * acceleration.length();
        // How strongly the particle leaves a wall when the walls accelerate it by `push`.
        let leaves = |contact: &Contact, push: DVec3| contact.normal.dot(acceleration + push) + contact.curvature * square;
        let holds = |push: DVec3| parallel.as_slice().iter().all(|contact| leaves(contact, push) >= -tolerance);
        let finish = |carriers: [Contact; 2], count: usize, push: [f64; 2]| {
            let total = carriers[0].normal * push[0] + carriers[1].normal * push[1];
            let mut support = Self {
                carriers,
                count,
                slides: ContactSet::default(),
                load: acceleration,
                acceleration: DVec3::ZERO,
                friction: carriers[0].friction * push[0].max(0.0) + carriers[1].friction * push[1].max(0.0),
                curvature: carriers[0].curvature.abs().max(carriers[1].curvature.abs()),
            };
            support.acceleration = support.along(acceleration);
            for contact in parallel.as_slice().iter().filter(|contact| leaves(contact, total) <= tolerance) {
                support.slides.add(*contact);
            }
            support
        };
        let list = parallel.as_slice();
        if list.iter().all(|contact| leaves(contact, DVec3::ZERO) > tolerance) {
            return None;
        }
        for contact in list {
            let push = -leaves(contact, DVec3::ZERO);
            if push >= -tolerance && holds(contact.normal * push) {
                return Some(finish([*contact, Contact::default()], 1, [push, 0.0]));
            }
        }
        for (index, one) in list.iter().enumerate() {
            for other in &list[index + 1..] {
                let (first, second) = (-leaves(one, DVec3::ZERO), -leaves(other, DVec3::ZERO));
                let push = pushes(one.normal.dot(other.normal), first, second);
                let carries = push.iter().all(|&push| push >= -tolerance);
                if carries && holds(one.normal * push[0] + other.normal * push[1]) {
                    return Some(finish([*one, *other], 2, push));
                }
            }
        }
        let corner = finish([Contact::default(); 2], 3, [0.0; 2]);
        Some(Self { slides: parallel, ..corner })
    }

    /// The part of `vector` along the walls that carry.
    pub fn along(&self, vector: DVec3) -> DVec3 {
        let [one, other] = self.carriers.map(|contact| contact.normal);
        match self.count {
            1 => vector - one * (one.dot(vector) / one.length_squared()),
            2 => vector.project_onto_normalized(one.cross(other).normalize_or_zero()),
            _ => DVec3::ZERO,
        }
    }

    /// The same support at another place, where `surface` gives a carrier's normal and curvature.
    pub fn moved(&self, surface: impl Fn(usize) -> (DVec3, f64)) -> Self {
        let mut moved = *self;
        for contact in moved.carriers.iter_mut().take(self.count.min(2)) {
            (contact.normal, contact.curvature) = surface(contact.surface);
        }
        moved
    }

    /// The deceleration by friction at a speed: on a curved wall the faster presses more, or less.
    pub fn friction_at(&self, speed: f64) -> f64 {
        let carriers = &self.carriers[..self.count.min(2)];
        let [first, second] = [0, 1].map(|index| {
            carriers.get(index).map_or(0.0, |contact| -(contact.normal.dot(self.load) + contact.curvature * speed * speed))
        });
        let push = match carriers {
            [one, other] => pushes(one.normal.dot(other.normal), first, second),
            _ => [first, second],
        };
        carriers.iter().zip(push).map(|(contact, push)| contact.friction * push.max(0.0)).sum()
    }

    /// How the particle slides with `velocity`, for at most the time `left`: with uniform acceleration a − f û, û the
    /// direction of its slip at mid-time, which makes it a second-order method whose friction never gives energy. Where
    /// friction would turn the slip around, it ends instead at the moment when it is zero.
    pub fn slip(&self, velocity: DVec3, left: f64) -> Slip {
        let (a, mut friction, speed) = (self.acceleration, self.friction, velocity.length());
        if self.count > 2 {
            return Slip { acceleration: DVec3::ZERO, duration: 0.0, stops: true, rests: true };
        }
        let mut duration = left;
        if self.curvature > 0.0 {
            let arc = ANGLE / self.curvature;
            duration = duration.min(arc / speed).min((arc / a.length()).sqrt());
            let middle = velocity + (a - velocity.normalize_or_zero() * friction) * (0.5 * duration);
            friction = self.friction_at(middle.length());
        }
        if friction == 0.0 {
            return Slip { acceleration: a, duration, stops: false, rests: false };
        }
        if speed == 0.0 && a.length() <= friction {
            return Slip { acceleration: DVec3::ZERO, duration: 0.0, stops: true, rests: true };
        }
        let middle = velocity + a * (0.5 * duration);
        let along = middle.normalize_or_zero();
        let end = velocity + (a - along * friction) * duration;
        let slips = middle.length() > 0.5 * friction * duration;
        if slips && along.dot(velocity) >= 0.0 && along.dot(end) >= 0.0 {
            return Slip { acceleration: a - along * friction, duration, stops: false, rests: false };
        }
        let along = velocity.normalize_or_zero();
        let brake = friction - a.dot(along);
        // Where it is not braked, but for rounding, it does not stop.
        let stop = if brake > 0.0 { speed / brake } else { f64::INFINITY };
        let stops = stop <= duration;
        Slip { acceleration: along * -brake, duration: duration.min(stop), stops, rests: stops && a.length() <= friction }
    }
}

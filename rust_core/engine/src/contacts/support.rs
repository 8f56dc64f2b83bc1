//! Supporting contacts: the walls that carry a particle, and its sliding on them.
//!
//! Consider the walls that a particle touches without approaching. Some exert normal accelerations λ ≥ 0 so that none is
//! penetrated: n·(a + Σ λ n) ≥ −κ v². One wall suffices, or two along an edge, or the particle rests in a corner. These cases
//! are tried in turn. Friction is μ λ against the slip.

use glam::DVec3;

use super::Key;
use super::trajectory::{Contact, ContactSet, pushes};

/// Maximum rotation of the tangent plane [rad] within one slide on a curved wall.
const ANGLE: f64 = 0.25;

/// Supporting contacts of a particle.
#[derive(Debug, Clone)]
pub(super) struct Support {
    carriers: [Contact; 2],
    count: usize,
    /// All walls that the particle slides on, carrying or not.
    pub slides: ContactSet,
    /// Mean acceleration of the step [m/s²].
    load: DVec3,
    /// Tangential acceleration [m/s²].
    pub acceleration: DVec3,
    /// Deceleration by friction, Σ μ λ [m/s²].
    friction: f64,
    /// Largest |κ| of the carrying walls along the velocity, and in any direction [1/m].
    pub curvature: f64,
    pub bend: f64,
}

/// An interval of sliding at uniform acceleration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slip {
    /// Tangential acceleration with friction [m/s²].
    pub acceleration: DVec3,
    /// Duration [s].
    pub duration: f64,
    /// Whether the slip vanishes at the end.
    pub stops: bool,
    /// Whether the particle rests afterwards.
    pub rests: bool,
}

impl Support {
    /// Finds the support of a particle; None if it leaves all walls that it touches. Normal speeds up to `still` are rounding
    /// errors and are set to 0.
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
        // Normal acceleration relative to a wall; `push` is the acceleration by the walls.
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
                bend: carriers[0].bend.abs().max(carriers[1].bend.abs()),
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

    /// Component of `vector` tangential to the carrying walls.
    pub fn along(&self, vector: DVec3) -> DVec3 {
        let [one, other] = self.carriers.map(|contact| contact.normal);
        match self.count {
            1 => vector - one * (one.dot(vector) / one.length_squared()),
            2 => vector.project_onto_normalized(one.cross(other).normalize_or_zero()),
            _ => DVec3::ZERO,
        }
    }

    /// Support at another position; `surface` gives the normal and the curvatures of a piece there.
    pub fn moved(&self, surface: impl Fn(Key) -> (DVec3, f64, f64)) -> Self {
        let mut moved = self.clone();
        for contact in moved.carriers.iter_mut().take(self.count.min(2)) {
            (contact.normal, contact.curvature, contact.bend) = surface(contact.key);
        }
        moved
    }

    /// Deceleration by friction [m/s²] at a speed. On a curved wall the normal force depends on the speed.
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

    /// Sliding from `velocity`, for at most the time `left`, with the uniform acceleration a − f û. The direction of slip û is
    /// taken at mid-time; this makes the method second-order and friction always dissipative. If friction would reverse the
    /// slip, sliding ends at zero slip.
    pub fn slip(&self, velocity: DVec3, left: f64) -> Slip {
        let (a, mut friction, speed) = (self.acceleration, self.friction, velocity.length());
        if self.count > 2 {
            return Slip { acceleration: DVec3::ZERO, duration: 0.0, stops: true, rests: true };
        }
        let mut duration = left;
        if self.bend > 0.0 {
            let arc = ANGLE / self.bend;
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
        // Without deceleration beyond rounding the particle does not stop.
        let stop = if brake > 0.0 { speed / brake } else { f64::INFINITY };
        let stops = stop <= duration;
        Slip { acceleration: along * -brake, duration: duration.min(stop), stops, rests: stops && a.length() <= friction }
    }
}

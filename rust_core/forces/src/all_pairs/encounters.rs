//! Encounters ahead among few particles: the frequency of the relative motion at the periapsis of each pair's orbit.

use std::f64::consts::TAU;

use super::AllPairs;
use crate::StateView;
use crate::central::periapsis;
use crate::math::Vector;

/// Largest number of targets for which encounters are foreseen. In a crowd, third bodies decide where a pair goes.
const FEW: usize = 64;

/// Smallest foreseen periapsis, as a fraction of the present distance: an orbit of eccentricity 0.98 from its apoapsis. Closer
/// encounters are collisions, and would need steps of less than 1/1000 of the present ones.
const CLOSEST: f64 = 0.01;

/// Time within which an encounter is foreseen, as a fraction of a turn of the dominant motion: longer than the interval between
/// two checks of the limit.
const SOON: f64 = 0.25;

impl<V: Vector> AllPairs<V> {
    /// Whether there are so few targets that their encounters are foreseen.
    pub(super) fn is_few(&self) -> bool {
        self.groups.iter().all(|group| group.targets.len() <= FEW && group.sources.len() <= FEW)
    }

    /// Largest squared frequency at a periapsis ahead [1/s²]; 0 if none is ahead. Each pair counts as if it were alone: the one
    /// that dominates a target's motion, by the largest frequency, and others that meet soon.
    pub(super) fn frequency_squared_ahead(&self, at: &StateView<'_, V>) -> f64 {
        let mut largest = 0.0_f64;
        for group in &self.groups {
            for &target in group.targets.iter().filter(|&&target| !at.properties.is_fixed(target)) {
                let pairs = group.sources.iter().filter(|&&source| source != target);
                let orbits: Vec<Orbit> = pairs.map(|&source| self.orbit(target, source, group.mutual, at)).collect();
                let dominant = orbits.iter().map(|orbit| orbit.at(orbit.distance)).fold(0.0, f64::max);
                let soon = SOON * TAU / dominant.sqrt();
                let counting = orbits.iter().filter(|orbit| orbit.at(orbit.distance) == dominant || orbit.meets_within(soon));
                largest = counting.map(Orbit::frequency_squared_ahead).fold(largest, f64::max);
            }
        }
        largest
    }

    /// Relative motion of a target and a source, as if they were alone.
    fn orbit(&self, target: usize, source: usize, mutual: bool, at: &StateView<'_, V>) -> Orbit {
        let mass = &at.properties.mass;
        let inverse = 1.0 / mass[target] + if mutual && !at.properties.is_fixed(source) { 1.0 / mass[source] } else { 0.0 };
        let offset = at.position.get(target).widen() - at.position.get(source).widen();
        let velocity = at.velocity.get(target).widen() - at.velocity.get(source).widen();
        Orbit {
            strength: self.constant * self.charge[target] * self.charge[source] * inverse,
            softening: self.softening,
            distance: offset.length(),
            approach: -offset.dot(velocity),
            speed_squared: velocity.length_squared(),
            spin_squared: offset.cross(velocity).length_squared(),
        }
    }
}

/// Relative motion of two particles.
struct Orbit {
    /// Acceleration at a distance of 1 m [m³/s²]; positive for attraction.
    strength: f64,
    softening: f64,
    distance: f64,
    /// Rate of approach times the distance [m²/s].
    approach: f64,
    speed_squared: f64,
    /// Squared angular momentum per mass [m⁴/s²].
    spin_squared: f64,
}

impl Orbit {
    /// Square of the softened distance.
    fn square(&self, distance: f64) -> f64 {
        distance * distance + self.softening * self.softening
    }

    /// Whether the particles would meet within a time [s] at the present speed.
    fn meets_within(&self, time: f64) -> bool {
        self.distance * self.distance < self.approach * time
    }

    /// Squared frequency at a distance [1/s²].
    fn at(&self, distance: f64) -> f64 {
        let square = self.square(distance);
        self.strength.abs() / (square * square.sqrt())
    }

    /// Squared frequency at the next periapsis [1/s²]; 0 where none is ahead, or where the pair collides.
    fn frequency_squared_ahead(&self) -> f64 {
        let potential = |distance: f64| -self.strength / self.square(distance).sqrt();
        let energy = 0.5 * self.speed_squared + potential(self.distance);
        if self.strength <= 0.0 || (energy >= 0.0 && self.approach <= 0.0) {
            return 0.0;
        }
        let closest = periapsis(self.distance, potential, 0.5 * self.spin_squared, energy);
        if closest.max(self.softening) < CLOSEST * self.distance { 0.0 } else { self.at(closest) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orbit of GM = 1 and semi-major axis 1 from its apoapsis.
    fn from_apoapsis(eccentricity: f64) -> Orbit {
        let (distance, speed_squared) = (1.0 + eccentricity, (1.0 - eccentricity) / (1.0 + eccentricity));
        let spin_squared = distance * distance * speed_squared;
        Orbit { strength: 1.0, softening: 0.0, distance, approach: 0.0, speed_squared, spin_squared }
    }

    #[test]
    fn periapsis_follows_from_the_elements() {
        for eccentricity in [0.0, 0.3, 0.8, 0.95] {
            let found = from_apoapsis(eccentricity).frequency_squared_ahead();
            let expected = (1.0 - eccentricity).powi(-3);
            // The bisection halves 20 times from a distance of at most 40 periapses; ω² goes with its cube.
            assert!((found / expected - 1.0).abs() < 3.0 * 40.0 / f64::from(1 << 20), "{eccentricity}: {found} {expected}");
        }
    }

    #[test]
    fn nothing_is_ahead_of_collisions_and_of_what_recedes_or_repels() {
        assert_eq!(from_apoapsis(0.999).frequency_squared_ahead(), 0.0);
        assert_eq!(Orbit { speed_squared: 4.0, approach: -1.0, ..from_apoapsis(0.0) }.frequency_squared_ahead(), 0.0);
        assert_eq!(Orbit { strength: -1.0, ..from_apoapsis(0.5) }.frequency_squared_ahead(), 0.0);
    }
}

//! Steps of large groups of bodies: equal pieces, in which all contacts within reach are rows.
//!
//! A gap that would close within a piece is closed at its end at most. Nothing passes through anything, at the price of the
//! time of impact. Source: E. Catto, "Solver2D", 2024 (small steps with relaxation).

use crate::island::{Accuracy, Island};
use crate::rows::Velocities;
use crate::shapes::Shape;

impl Island {
    /// Advances the group by `h` seconds in equal pieces. The last one is left open.
    pub fn sweep(&mut self, shapes: &[Shape], h: f64, (pieces, accuracy): (usize, Accuracy)) {
        self.accuracy = accuracy;
        // Impacts may pass the largest speed on to any body.
        let way = 2.0 * h * self.speed();
        self.find_contacts(shapes, |_, pair| way.min(pair.size));
        let length = h / pieces as f64;
        for piece in 0..pieces {
            let v = Velocities::of(&self.movers);
            for index in 0..self.contacts.len() {
                let contact = self.contacts[index];
                let approach = self.row(&contact, &v).map_or(0.0, |row| -row.normal.dot(row.velocity(&v)));
                // Bounces of less than a piece are contacts at rest.
                let least = 0.5 * length * self.pressing(&contact);
                let contact = &mut self.contacts[index];
                contact.held = true;
                contact.strikes = approach > least;
                contact.rebound = if contact.restitution * approach > least { contact.restitution * approach } else { 0.0 };
            }
            self.begin_piece(length, length);
            if piece + 1 < pieces {
                self.movers.iter_mut().for_each(|mover| mover.kick(0.5 * length));
                self.end_piece();
                self.renew_touches();
            }
        }
    }
}

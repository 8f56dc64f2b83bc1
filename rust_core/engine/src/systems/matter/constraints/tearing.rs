//! Tearing: springs that are stretched beyond their breaking strain break.
//!
//! At the end of each step, every spring of strain (r − L)/L > s breaks. It exerts no force from then on, and its energy ½ k
//! (r − L)² is dissipated. A step in which a spring breaks is of order 1.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::error::Result;
use crate::forces::springs::{self, Spring};
use crate::history::{Archive, History};
use crate::scene::Scene;

/// Springs that can break, and springs that are broken.
#[derive(Debug, Clone, Default)]
pub struct Tearing {
    /// All springs, as declared.
    whole: Vec<Spring>,
    /// Springs that can break, as indices, with the squares of the lengths at which they do [m²].
    limits: Vec<(u32, f64)>,
    now: Broken,
    saved: Broken,
}

/// Broken springs, and their energy with that of the forces that depended on them [J].
#[derive(Debug, Clone, Default, PartialEq)]
struct Broken {
    springs: Vec<bool>,
    energy: f64,
}

impl Tearing {
    /// Tearing of a scene with these springs; None if none of them can break.
    ///
    /// # Errors
    /// If a network does not have one breaking strain ≥ 0 for each of its springs.
    pub fn declared(scene: &Scene, springs: &[Spring]) -> Result<Option<Self>> {
        let strains = springs::strains(scene, "breaking_strain")?;
        let limits: Vec<(u32, f64)> = springs
            .iter()
            .zip(strains)
            .zip(0..)
            .filter(|((_, strain), _)| strain.is_finite())
            .map(|((spring, strain), index)| (index, (spring.rest_length * (1.0 + strain)).powi(2)))
            .collect();
        let now = Broken { springs: vec![false; springs.len()], energy: 0.0 };
        let tearing = Self { whole: springs.to_vec(), limits, saved: now.clone(), now };
        Ok((!tearing.limits.is_empty()).then_some(tearing))
    }

    /// Breaks the springs that are too long at these positions; returns whether there are any.
    pub fn tear(&mut self, position: impl Fn(usize) -> DVec3) -> bool {
        let mut torn = false;
        for &(index, limit) in &self.limits {
            let Spring { ends: [one, other], stiffness, rest_length, .. } = self.whole[index as usize];
            let square = (position(other as usize) - position(one as usize)).length_squared();
            let broken = &mut self.now.springs[index as usize];
            if square > limit && !*broken {
                *broken = true;
                torn = true;
                self.now.energy += 0.5 * stiffness * (square.sqrt() - rest_length).powi(2);
            }
        }
        torn
    }

    /// All springs; the broken ones have neither stiffness nor damping.
    pub fn springs(&self) -> Vec<Spring> {
        let broken = |spring: &Spring| Spring { stiffness: 0.0, damping: 0.0, ..*spring };
        self.whole.iter().zip(&self.now.springs).map(|(spring, &torn)| if torn { broken(spring) } else { *spring }).collect()
    }

    /// Whether each spring, as declared, is broken.
    pub fn broken(&self) -> &[bool] {
        &self.now.springs
    }

    /// Ends of the broken springs, in ascending order.
    pub fn sides(&self) -> BTreeSet<[u32; 2]> {
        let broken = self.whole.iter().zip(&self.now.springs).filter(|(_, broken)| **broken);
        broken.map(|(Spring { ends: [one, other], .. }, _)| [*one.min(other), *one.max(other)]).collect()
    }

    /// Adds the energy of the forces that depended on the springs that broke last [J].
    pub fn lose(&mut self, energy: f64) {
        self.now.energy += energy;
    }

    /// Energy of the broken springs and of the forces that depended on them [J].
    pub fn dissipated(&self) -> f64 {
        self.now.energy
    }

    /// Whether the broken springs differ from those of the saved state.
    pub fn differs_from_saved(&self) -> bool {
        self.now.springs != self.saved.springs
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let broken = size_of_val(self.now.springs.as_slice()) + size_of_val(self.saved.springs.as_slice());
        broken + size_of_val(self.whole.as_slice()) + size_of_val(self.limits.as_slice())
    }
}

impl History for Tearing {
    fn save(&mut self) {
        self.saved.clone_from(&self.now);
    }

    fn rollback(&mut self) {
        self.now.clone_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("energy", [self.now.energy]);
        archive.write("broken", self.now.springs.iter().map(|&broken| f64::from(u8::from(broken))));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let numbers = archive.read_exactly("broken", self.now.springs.len())?;
        self.now.springs = numbers.iter().map(|&number| number != 0.0).collect();
        self.now.energy = archive.read_number("energy")?;
        Ok(())
    }
}

//! Tearing: springs that are stretched beyond their breaking strain break.
//!
//! At the end of each step, every spring of strain (r − L)/L > s breaks. It exerts no force from then on, and its energy ½ k
//! (r − L)² is dissipated. A step in which a spring breaks is of order 1.

use super::{Breakage, Constraint, ConstraintProperties, Declaration, ForcedState};
use crate::catalog::Space;
use crate::error::Result;
use crate::forces::StateView;
use crate::forces::springs::{self, Spring};
use crate::history::{Archive, History};
use crate::ledger::{Class, Ledger};
use crate::matter::Matter;
use crate::systems::matter::methods::Treatment;
use crate::systems::{FieldInfo, Location};

/// Name of the field that tells whether each spring is broken.
const BROKEN: &str = "broken";

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
    /// Tearing of a scene; None if no spring can break.
    ///
    /// # Errors
    /// If a network does not have one breaking strain ≥ 0 for each of its springs, or the method is for smooth motion alone.
    pub fn declared<V: Space>(declared: &Declaration<'_, V>) -> Result<Option<Self>> {
        let Declaration { scene, springs, method, .. } = declared;
        let strains = springs::strains(scene, "breaking_strain")?;
        let limits: Vec<(u32, f64)> = springs
            .iter()
            .zip(strains)
            .zip(0..)
            .filter(|((_, strain), _)| strain.is_finite())
            .map(|((spring, strain), index)| (index, (spring.rest_length * (1.0 + strain)).powi(2)))
            .collect();
        if limits.is_empty() {
            return Ok(None);
        }
        if method.springs != Treatment::Rods {
            method.refuse_kinks("springs that break")?;
        }
        let now = Broken { springs: vec![false; springs.len()], energy: 0.0 };
        Ok(Some(Self { whole: springs.to_vec(), limits, saved: now.clone(), now }))
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

impl<V: Space> Constraint<V> for Tearing {
    fn about(&self) -> ConstraintProperties {
        ConstraintProperties {
            name: "tearing",
            stages: Vec::new(),
            // A spring breaks at the end of a step.
            order: 1,
            varies: false,
            exact: false,
            iterates: false,
            cost: 0.0,
        }
    }

    fn bytes(&self) -> usize {
        let broken = size_of_val(self.now.springs.as_slice()) + size_of_val(self.saved.springs.as_slice());
        broken + size_of_val(self.whole.as_slice()) + size_of_val(self.limits.as_slice())
    }

    fn energy(&self, _at: &StateView<'_, V>, ledger: &mut Ledger) {
        ledger.add(Class::Dissipated, "tearing", self.now.energy);
    }

    fn fields(&self) -> Vec<FieldInfo> {
        vec![FieldInfo {
            name: BROKEN.to_owned(),
            unit: "1",
            location: Location::Springs,
            shape: vec![self.now.springs.len()],
            rate: None,
            state: true,
        }]
    }

    fn read(&self, _field: usize, _state: &ForcedState<'_, V>) -> Vec<f64> {
        self.now.springs.iter().map(|&broken| f64::from(u8::from(broken))).collect()
    }

    fn adopt(&mut self, field: &str, values: &[f64]) {
        if field == BROKEN {
            self.now.springs = values.iter().map(|&number| number != 0.0).collect();
        }
    }

    fn tears(&self) -> bool {
        true
    }

    fn tear(&mut self, matter: &Matter<V>) -> bool {
        let mut torn = false;
        for &(index, limit) in &self.limits {
            let Spring { ends: [one, other], stiffness, rest_length, .. } = self.whole[index as usize];
            let square = (matter.exact_position(other as usize) - matter.exact_position(one as usize)).length_squared();
            let broken = &mut self.now.springs[index as usize];
            if square > limit && !*broken {
                *broken = true;
                torn = true;
                self.now.energy += 0.5 * stiffness * (square.sqrt() - rest_length).powi(2);
            }
        }
        torn
    }

    fn breakage(&self) -> Option<Breakage> {
        let lost = |spring: &Spring| Spring { stiffness: 0.0, damping: 0.0, ..*spring };
        let pairs = || self.whole.iter().zip(&self.now.springs);
        let ends = |Spring { ends: [one, other], .. }: &Spring| [*one.min(other), *one.max(other)];
        Some(Breakage {
            springs: pairs().map(|(spring, &torn)| if torn { lost(spring) } else { *spring }).collect(),
            broken: self.now.springs.clone(),
            sides: pairs().filter(|(_, torn)| **torn).map(|(spring, _)| ends(spring)).collect(),
        })
    }

    fn lose(&mut self, energy: f64) {
        self.now.energy += energy;
    }
}

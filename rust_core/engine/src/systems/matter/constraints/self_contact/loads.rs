//! Loads of contacts: the start of the next step, and the only data that persists between steps.

use glam::DVec3;

use super::SelfContacts;
use super::{MeshContact, Origin};
use crate::error::Result;
use crate::history::{Archive, History};

/// Forces of contacts [N].
#[derive(Debug, Clone, Default)]
pub struct Loads {
    /// Forces of pairs, by their keys.
    pub pairs: Vec<(u64, f64)>,
    /// Forces of vertices on walls, with the normals there.
    pub walls: Vec<(u32, DVec3, f64)>,
}

impl Loads {
    /// Loads of the contacts of a step of `h` seconds.
    pub fn new(contacts: &[MeshContact], h: f64) -> Self {
        let (mut pairs, mut walls) = (Vec::new(), Vec::new());
        for contact in contacts.iter().filter(|contact| contact.impulse > 0.0) {
            match contact.mark {
                Origin::Pair(key) => pairs.push((key, contact.impulse / h)),
                Origin::Wall(vertex) => walls.push((vertex, contact.normal, contact.impulse / h)),
                Origin::Way => {}
            }
        }
        pairs.sort_unstable_by_key(|&(key, _)| key);
        Self { pairs, walls }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice()) + size_of_val(self.walls.as_slice())
    }

    /// Force of a pair [N].
    pub fn of(&self, key: u64) -> Option<f64> {
        self.pairs.binary_search_by_key(&key, |&(key, _)| key).ok().map(|index| self.pairs[index].1)
    }
}

/// History: the loads of the last step's contacts.
impl History for SelfContacts {
    fn save(&mut self) {
        self.saved.clone_from(&self.loads);
    }

    fn rollback(&mut self) {
        self.loads.clone_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        let Loads { pairs, walls } = &self.loads;
        // The two halves of a key are whole numbers that doubles represent exactly.
        archive.write("pairs", pairs.iter().flat_map(|&(key, load)| [(key >> 32) as f64, (key & 0xffff_ffff) as f64, load]));
        let walls = walls.iter().flat_map(|&(vertex, normal, load)| [f64::from(vertex), normal.x, normal.y, normal.z, load]);
        archive.write("walls", walls);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let pairs = archive.read("pairs")?.as_chunks::<3>().0.iter();
        self.loads.pairs = pairs.map(|&[high, low, load]| ((high as u64) << 32 | low as u64, load)).collect();
        let walls = archive.read("walls")?.as_chunks::<5>().0.iter();
        self.loads.walls = walls.map(|&[vertex, x, y, z, load]| (vertex as u32, DVec3::new(x, y, z), load)).collect();
        Ok(())
    }
}

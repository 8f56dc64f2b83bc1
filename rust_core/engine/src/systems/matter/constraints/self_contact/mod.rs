//! Contact of meshes with themselves and with each other: nothing passes through, and distances stay at the thickness.
//!
//! A step moves vertices along straight paths. Pairs that may touch on the way are searched ([`mesh`]): vertex and triangle,
//! or edge and edge. Their list stays complete as paths change ([`nearby`]). Contacts are the pairs whose closest points are
//! within both elements, or locally closest ([`touching`]). Impulses keep contacts from closing to less than the thickness
//! ([`crate::solvers::impulses`]). Conservative advancement then tests all pairs on the new paths ([`advancement`]). Pairs that still meet
//! become contacts as they meet. If some rounds of this do not help, particles move on together ([`zones`]). No path of a
//! step therefore lets an edge through a triangle, whatever its length. Module [`resolution`] contains this loop.
//!
//! Impulses also press vertices on walls ([`walls`]) and hold springs at their strain limits ([`limits`]).

use glam::DVec3;

use super::ConstraintStage;
use crate::solvers::impulses::ImpulseRow;

mod advancement;
mod constraint;
mod crossing;
mod declaration;
mod distance;
mod limits;
mod loads;
mod mesh;
mod nearby;
mod resolution;
mod touching;
mod tree;
mod walls;
mod zones;

pub use declaration::{BodySurface, bodies, elements, surface};
use limits::StrainLimit;
use loads::Loads;
use mesh::{ContactRule, Mesh};
use nearby::Nearby;
use resolution::ContactStep;
use walls::InsidePosition;

/// Contact of up to four particles.
type MeshContact = ImpulseRow<Origin>;

/// Origin of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Origin {
    /// Pair that is near at the start of a step, by its key.
    Pair(u64),
    /// Vertex at a wall.
    Wall(u32),
    /// Pair that meets on its path.
    Way,
}

/// Kind of the items.
pub const KIND: &str = "SelfContact";

/// Smallest excess over a longest length that is reported, relative to that length.
const NOTED: f64 = 0.01;

/// Contacts of meshes.
#[derive(Debug, Clone, Default)]
pub struct SelfContacts {
    rules: Vec<ContactRule>,
    /// Rule of each pair of bodies, row by row.
    table: Vec<u32>,
    surfaces: Vec<BodySurface>,
    /// All springs with a strain limit, and those that are not broken.
    limits: Vec<StrainLimit>,
    limited: Vec<StrainLimit>,
    mesh: Mesh,
    nearby: Nearby,
    /// Vertices of all meshes.
    vertices: Vec<u32>,
    inverse_mass: Vec<f64>,
    /// Positions [m] and velocities [m/s] at the start of the step.
    start: Vec<DVec3>,
    start_velocities: Vec<DVec3>,
    /// Loads of the contacts of the last step, and a saved copy.
    loads: Loads,
    saved: Loads,
    /// Number of steps in which particles moved on together.
    merged: u64,
    /// Largest excess of a spring over its longest length, relative to that length.
    excess: f64,
}

impl SelfContacts {
    /// Removes broken springs, and the triangles and free edges along them.
    fn leave_out_broken(&mut self, broken: &[bool]) {
        let whole = |springs: &[u32]| springs.iter().all(|&spring| !broken.get(spring as usize).copied().unwrap_or(false));
        self.limited = self.limits.iter().filter(|limit| whole(&[limit.spring])).copied().collect();
        let bodies: Vec<mesh::BodyMesh> = self
            .surfaces
            .iter()
            .map(|BodySurface { faces, edges }| {
                let faces = faces.iter().filter(|(_, sides)| whole(sides)).map(|&(face, _)| face).collect();
                (faces, edges.iter().filter(|(_, springs)| whole(springs)).map(|&(edge, _)| edge).collect())
            })
            .collect();
        let count = self.inverse_mass.len();
        self.mesh = Mesh::new(&bodies, self.table.clone(), count);
        self.vertices = self.mesh.vertices().chain(self.limited.iter().flat_map(|limit| limit.ends)).collect();
        self.vertices.sort_unstable();
        self.vertices.dedup();
    }

    /// Records the positions [m] and velocities [m/s] at the start of a step.
    fn record(&mut self, state: impl Fn(usize) -> [DVec3; 2]) {
        self.start_velocities.resize(self.start.len(), DVec3::ZERO);
        for (index, (start, velocity)) in self.start.iter_mut().zip(&mut self.start_velocities).enumerate() {
            [*start, *velocity] = state(index);
        }
    }

    /// Names and descriptions of the parts in use.
    fn stages(&self) -> Vec<ConstraintStage> {
        let contact = ("self-contact", format!("a tree of {} triangles and free edges", self.elements()));
        let limits = ("strain limits", format!("{} springs, which are rods at their longest", self.limits.len()));
        let parts = [(self.elements() > 0, contact), (!self.limits.is_empty(), limits)];
        parts
            .into_iter()
            .filter(|(used, _)| *used)
            .map(|(_, (name, note))| ConstraintStage { name, note: Some(note), last: false })
            .collect()
    }

    /// Number of triangles and free edges.
    fn elements(&self) -> usize {
        self.mesh.elements.len()
    }

    /// Notes for the plan on the steps so far.
    fn remarks(&self) -> Vec<String> {
        let merged = format!(
            "self-contact: in {} steps some particles moved on together, because no impulses kept them apart; shorter steps do",
            self.merged
        );
        let excess = format!(
            "strain limits: a spring was {:.1} % longer than its longest length; shorter steps hold it better",
            100.0 * self.excess
        );
        let notes = [(self.merged > 0, merged), (self.excess > NOTED, excess)];
        notes.into_iter().filter(|(holds, _)| *holds).map(|(_, note)| note).collect()
    }
}

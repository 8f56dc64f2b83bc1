//! Notes on rigid bodies in the plan.

use physcore_rigid::world::{ContactSolver, RigidState};

use super::RigidBodies;

impl RigidBodies {
    /// Counts of what there is, and the numerics of large groups.
    pub fn stage_note(&self) -> String {
        let counted = |count: usize, one: &str, many: &str| format!("{count} {}", if count == 1 { one } else { many });
        let joints = self.world.state.joints.len();
        let mut notes = vec![counted(self.particles.len(), "rigid body", "rigid bodies")];
        if joints > 0 {
            notes.push(counted(joints, "joint", "joints"));
        }
        if !self.points.is_empty() {
            let faces =
                if self.faces.len() > 0 { format!(" and {}", counted(self.faces.len(), "face", "faces")) } else { String::new() };
            notes.push(format!("{}{faces} may meet them", counted(self.points.len(), "particle", "particles")));
        }
        if self.world.may_sleep() {
            notes.push(format!("{} of them may sleep", self.world.sleepers()));
        }
        let ContactSolver { substeps, iterations, sequential } = self.world.solver;
        if self.particles.len() > sequential {
            let pieces = counted(substeps, "substep", "substeps");
            let sweeps = counted(iterations, "iteration", "iterations");
            notes.push(format!("groups of more than {sequential} in {pieces} with {sweeps}"));
        }
        notes.join(", ")
    }

    /// Warnings of what went on so far.
    pub fn warnings(&self) -> Vec<String> {
        let mut notes = Vec::new();
        notes.extend(self.overlap.iter().filter(|overlap| !overlap.is_empty()).map(|overlap| format!("warning: {overlap}")));
        let RigidState { pushed, retaken, waits, .. } = self.world.state;
        if pushed != 0.0 {
            notes.push(format!(
                "rigid bodies: pushing those apart that overlapped has added {pushed:.2e} J so far, which shows as drift"
            ));
        }
        if retaken > 0 {
            notes.push(format!(
                "rigid bodies: {retaken} steps of small groups were taken as those of large ones, because the impulses found would \
                 have added energy; a smaller dt helps"
            ));
        }
        if waits > 0 {
            notes.push(format!(
                "rigid bodies: in {waits} steps bodies were too fast or met too often, and stayed where they were for a part of the \
                 step; a smaller dt helps"
            ));
        }
        notes
    }
}

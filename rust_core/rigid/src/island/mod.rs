//! Group of bodies that contacts and joints connect, during a step.
//!
//! A step is velocity Verlet with constraint impulses, as in RATTLE. It is taken in pieces of length k:
//!
//!     v½ = v + k/2 a + M⁻¹ Jᵀ(x) λ,   x ← x + k v½    λ so that gaps at the end are ≥ 0, and joints are closed
//!     v ← v½ + k/2 a + M⁻¹ Jᵀ(x) μ                     μ so that no gap closes, with λ + μ ≥ 0
//!
//! Friction acts with both halves. Impulses of contacts that last do no work but that of friction, which is the impulse times
//! the mean of the slips before and after. Sources: H. C. Andersen, J. Comput. Phys. 52, 24 (1983); J. J. Moreau, "Numerical
//! aspects of the sweeping process", Comput. Meth. Appl. Mech. Eng. 177, 329 (1999).

mod contacts;
mod joints;
mod pieces;

use glam::DVec3;
use physcore_base::adjacency::Adjacency;

use crate::face::{GroupValues, NetFace};
use crate::mover::Mover;
use crate::pose::Pose;
use crate::rows::{BodyVelocities, ContactImpulse};
use crate::surface::Surface;
use crate::sweeps::GroupSweep;

pub use contacts::{ContactKey, ContactSearch, GroupContact};
pub(crate) use joints::{HeldJoint, LIMIT_BOUNDS, LIMITS};
pub use pieces::{FirstHalf, lost, pushed};

/// Gap at which a contact counts as closed, and overlap at which bodies are pushed apart, over the size of the bodies.
pub const CLOSED: f64 = 1e-6;
/// Gap at which a contact has closed, over the size of the bodies.
pub(crate) const HIT: f64 = 1e-9;

/// Numerical parameters of contacts and joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Largest number of iterations over all rows.
    pub iterations: usize,
    /// Change of relative velocities that ends the iterations, over the largest velocity.
    pub velocities: f64,
    /// Largest number of linearizations of gaps and errors of joints.
    pub linearizations: usize,
    /// Error of gaps and joints that ends them, over the size of the bodies.
    pub positions: f64,
}

impl Accuracy {
    /// Parameters of small groups.
    pub const FINE: Self = Self { iterations: 200, velocities: 1e-10, linearizations: 10, positions: 1e-11 };
}

/// Pair of bodies that may touch.
#[derive(Debug, Clone, Copy)]
pub struct BodyPair {
    /// Numbers of the bodies; from [`crate::face::FACES`] on that of a face, which is the second.
    pub bodies: [usize; 2],
    /// Indices of the bodies in the world.
    pub key: (u32, u32),
    /// Least size of the two bodies [m].
    pub size: f64,
    /// Least thickness of the two bodies [m].
    pub thickness: f64,
    /// Largest gap of its contacts in the present sweep or piece [m].
    pub reach: f64,
    /// Last search for its contacts; None before the first.
    pub found: Option<ContactSearch>,
}

/// Energies of a group in a step [J].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Meters {
    /// Dissipated by contacts and by the limits of joints.
    pub dissipated: f64,
    /// Dissipated by the damping of springs.
    pub damped: f64,
    /// Supplied by motors, and by bodies that move as prescribed.
    pub work: f64,
    /// Number of steps that were taken again because impulses would have added energy.
    pub retaken: u32,
    /// Number of steps in which bodies waited because of too many impacts.
    pub waits: u32,
    /// Gained by pushing overlapping bodies apart: an error of the method, neither work nor dissipation.
    pub pushed: f64,
}

/// Group of bodies during a step.
#[derive(Debug)]
pub struct Island {
    pub movers: Vec<Mover>,
    /// Index of each mover in the world.
    pub members: Vec<usize>,
    pub surfaces: Vec<Surface>,
    /// Faces of networks, between movers, and the corners beside each mover in them.
    pub faces: Vec<NetFace>,
    pub beside: Adjacency,
    pub pairs: Vec<BodyPair>,
    pub contacts: Vec<GroupContact>,
    pub joints: Vec<HeldJoint>,
    pub planar: bool,
    pub accuracy: Accuracy,
    pub meters: Meters,
    /// Length of the step, and of the last piece, which is left open [s].
    pub step: f64,
    pub open: f64,
    /// Buffers of a sweep, and whether its last piece is open.
    sweep: GroupSweep,
    is_swept: bool,
    /// Changes of velocity [m/s] and angular momentum [kg·m²/s] that are predicted for the second half of the last piece.
    pub ahead: Vec<[DVec3; 2]>,
    /// Buffer of contacts.
    known: Vec<GroupContact>,
    /// Poses of the bodies when contacts were last renewed, and ways of their surface points by turning until then [m].
    poses: GroupValues<Pose>,
    turned: GroupValues<f64>,
    /// Loads of the contacts of the last step.
    past: Vec<(ContactKey, ContactImpulse)>,
    first: FirstHalf,
}

impl Island {
    /// Group without contacts yet.
    pub fn new(planar: bool) -> Self {
        Self {
            movers: Vec::new(),
            members: Vec::new(),
            surfaces: Vec::new(),
            faces: Vec::new(),
            beside: Adjacency::default(),
            pairs: Vec::new(),
            contacts: Vec::new(),
            joints: Vec::new(),
            planar,
            accuracy: Accuracy::FINE,
            meters: Meters::default(),
            step: 0.0,
            open: 0.0,
            sweep: GroupSweep::default(),
            is_swept: false,
            ahead: Vec::new(),
            known: Vec::new(),
            poses: GroupValues::default(),
            turned: GroupValues::default(),
            past: Vec::new(),
            first: FirstHalf::default(),
        }
    }

    /// Removes all bodies, and keeps the buffers.
    pub fn clear(&mut self) {
        self.movers.clear();
        self.members.clear();
        self.surfaces.clear();
        self.faces.clear();
        self.beside = Adjacency::default();
        self.pairs.clear();
        self.contacts.clear();
        self.joints.clear();
        self.past.clear();
        self.ahead.clear();
        self.meters = Meters::default();
        self.accuracy = Accuracy::FINE;
    }

    /// Finds the corners beside each mover in the faces.
    pub fn link_faces(&mut self) {
        if !self.faces.is_empty() {
            let sides =
                self.faces.iter().flat_map(|face| [0, 1, 2].map(|side| [face.corners[side], face.corners[(side + 1) % 3]]));
            self.beside = Adjacency::of_graph(self.movers.len(), sides.filter(|[one, other]| one != other));
        }
    }

    /// Velocities in the present orientations.
    pub fn velocities(&self) -> BodyVelocities {
        BodyVelocities { faces: self.faces.clone(), ..BodyVelocities::of(&self.movers) }
    }

    /// Largest speed of a surface point [m/s].
    pub fn speed(&self) -> f64 {
        self.movers.iter().map(Mover::speed).fold(0.0, f64::max)
    }

    /// Energy supplied in the first half of the open piece [J].
    pub fn open_work(&self) -> f64 {
        if self.is_swept { 0.0 } else { self.first.work }
    }

    /// Buffers of a sweep.
    pub fn take_sweep(&mut self) -> GroupSweep {
        std::mem::take(&mut self.sweep)
    }

    /// Keeps the buffers of a sweep.
    pub fn keep_sweep(&mut self, sweep: GroupSweep) {
        self.sweep = sweep;
    }

    /// Leaves the last piece of a sweep open.
    pub fn open_sweep(&mut self, sweep: GroupSweep, length: f64, h: f64) {
        (self.sweep, self.is_swept, self.open, self.step) = (sweep, true, length, h);
    }
}

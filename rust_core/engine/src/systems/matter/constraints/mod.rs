//! Constraints: conditions on the positions and velocities of particles.
//!
//! A method moves particles without constraints. [`super::step`] calls the constraints between the parts of a step. To add a
//! constraint: write its file, and add its line to [`build`] and to [`CARRIERS`].

mod rigid;
pub mod rods;
pub mod self_contact;
pub mod tearing;
mod wire;

use std::collections::BTreeSet;

use glam::DVec3;

use super::dynamics::Dynamics;
use super::methods::MethodProperties;
use crate::catalog::Space;
use crate::contacts::Contacts;
use crate::error::{Error, Result};
use crate::forces::springs::Spring;
use crate::forces::{Force, StateView};
use crate::history::{Archive, History};
use crate::ledger::Ledger;
use crate::matter::{Columns, Matter, Properties, SolidMotion};
use crate::parallel::Executor;
use crate::scene::Scene;
use crate::stability::SpectralBound;
use crate::systems::FieldInfo;

use rigid::RigidBodies;
pub use rigid::{RigidPose, overlaps};
use rods::Rods;
use self_contact::SelfContacts;
use tearing::Tearing;
use wire::Wires;

/// Velocity with which the drift of a method moves particles. Constraints change it together with the positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriftVelocity {
    /// Velocity in a register. The velocity at the end of the step follows from it by a second half kick.
    Register(usize),
    /// Velocity at the end of the step.
    End,
}

/// Step of a method, as constraints see it.
pub struct ConstrainedStep<'a, V: Space> {
    pub matter: &'a mut Matter<V>,
    pub properties: &'a Properties<V>,
    /// Forces, as last evaluated.
    forces: &'a [Box<dyn Force<V>>],
    /// Walls of the scene.
    pub walls: Option<&'a Contacts<V>>,
    /// Size of the step [s].
    pub h: f64,
    pub drift: DriftVelocity,
    /// Whether a fixed particle has a velocity, so that it may do work.
    pub driven: bool,
    /// Whether forces or their powers depend on the velocities at the end of the step.
    pub predicts: bool,
    pub executor: &'a Executor,
}

impl<'a, V: Space> ConstrainedStep<'a, V> {
    /// Step of `h` seconds, or an initial state for `h` = 0.
    pub fn new(
        dynamics: &'a Dynamics<V>,
        matter: &'a mut Matter<V>,
        (h, drift): (f64, DriftVelocity),
        executor: &'a Executor,
    ) -> Self {
        let (walls, driven, predicts) = (dynamics.contacts.as_ref(), dynamics.driven, dynamics.needs_velocities());
        let (properties, forces) = (&dynamics.properties, dynamics.forces());
        Self { matter, properties, forces, walls, h, drift, driven, predicts, executor }
    }

    /// Velocity of the drift of a particle [m/s].
    #[inline]
    pub fn drift_velocity(&self, index: usize) -> DVec3 {
        match self.drift {
            DriftVelocity::Register(register) => self.matter.registers[register].get(index).widen(),
            DriftVelocity::End => self.matter.velocity.get(index).widen(),
        }
    }

    /// Whether forces depend on the rotations of the rigid bodies, or turn them.
    pub fn meets_solids(&self) -> bool {
        self.forces.iter().any(|force| force.meets_solids())
    }

    /// Torques of the forces on the rigid bodies at their last evaluation [N·m].
    pub fn torques(&self) -> Vec<DVec3> {
        let mut torques = vec![DVec3::ZERO; self.matter.solids.len()];
        self.forces.iter().for_each(|force| force.torques(&mut torques));
        torques
    }

    /// Adds a change [m/s] to the velocities of a particle, by an impulse at the start of the step.
    pub fn push(&mut self, index: usize, change: DVec3) {
        if let DriftVelocity::Register(register) = self.drift {
            add(&mut self.matter.registers[register], index, change);
        }
        add(&mut self.matter.velocity, index, change);
    }

    /// Adds a displacement [m] at the end of the drift to the velocities of a particle, but not to its position. A force that
    /// acts throughout the step causes it.
    pub fn pull(&mut self, index: usize, displacement: DVec3) {
        if self.h == 0.0 {
            return;
        }
        let kick = displacement / self.h;
        match self.drift {
            DriftVelocity::Register(register) => {
                add(&mut self.matter.registers[register], index, kick);
                add(&mut self.matter.velocity, index, 2.0 * kick);
            }
            DriftVelocity::End => add(&mut self.matter.velocity, index, kick),
        }
    }
}

fn add<V: Space>(columns: &mut Columns<V>, index: usize, change: DVec3) {
    columns.set(index, V::narrow(columns.get(index).widen() + change));
}

/// State of matter with the accelerations by all forces but those of constraints.
pub struct ForcedState<'a, V: Space> {
    pub at: &'a StateView<'a, V>,
    pub walls: Option<&'a Contacts<V>>,
    /// Computes the acceleration of every particle [m/s²].
    pub accelerations: &'a dyn Fn() -> Vec<DVec3>,
}

/// Stage of a constraint in the plan.
#[derive(Debug, Clone)]
pub struct ConstraintStage {
    pub name: &'static str,
    pub note: Option<String>,
    /// Whether the stage also changes the velocities at the end of the step, so that it stands last.
    pub last: bool,
}

/// Properties of a constraint.
#[derive(Debug, Clone)]
pub struct ConstraintProperties {
    /// Name in archives.
    pub name: &'static str,
    pub stages: Vec<ConstraintStage>,
    /// Highest order of convergence of a step.
    pub order: u32,
    /// Whether the bound on the time step changes with the state.
    pub varies: bool,
    /// Whether positions need their low-order part in single precision.
    pub exact: bool,
    /// Whether steps iterate, so that no estimate of their duration holds.
    pub iterates: bool,
    /// Estimated duration of a step [ns].
    pub cost: f64,
}

/// Broken springs.
#[derive(Debug, Clone, PartialEq)]
pub struct Breakage {
    /// Springs as declared; broken ones have neither stiffness nor damping.
    pub springs: Vec<Spring>,
    /// Whether each spring is broken.
    pub broken: Vec<bool>,
    /// Ends of the broken springs, in ascending order.
    pub sides: BTreeSet<[u32; 2]>,
}

/// Condition on positions or velocities. Its history is the data that persists from step to step.
pub trait Constraint<V: Space>: History + Send + Sync {
    /// Properties, which do not change.
    fn about(&self) -> ConstraintProperties;

    /// Memory [bytes].
    fn bytes(&self) -> usize;

    /// Notes for the plan on the state and on the steps so far.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Checks an initial state, or moves it onto the constraint. The size of the step is 0.
    ///
    /// # Errors
    /// If the state contradicts the constraint, or on an interrupt.
    fn initialize(&mut self, _step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        Ok(())
    }

    /// Records the forces at the start of a run, after their first evaluation.
    fn start(&mut self, _step: &ConstrainedStep<'_, V>) {}

    /// Rotations of the rigid bodies, as forces see them.
    fn solids(&self) -> Vec<SolidMotion> {
        Vec::new()
    }

    /// Records the state at the start of a step.
    fn begin(&mut self, _step: &ConstrainedStep<'_, V>) {}

    /// Changes the positions after the drift, and the velocity of the drift. Returns whether there were changes.
    ///
    /// # Errors
    /// If no such positions are found, or on an interrupt.
    fn positions(&mut self, _step: &mut ConstrainedStep<'_, V>) -> Result<bool> {
        Ok(false)
    }

    /// Changes the velocities at the end of the step.
    ///
    /// # Errors
    /// If no such velocities are found, or on an interrupt.
    fn velocities(&mut self, _step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        Ok(())
    }

    /// Adds the terms of the constraint to a bound on the time step.
    fn bound(&self, _state: &ForcedState<'_, V>, _bound: &mut SpectralBound) {}

    /// Adds energies to the budget.
    fn energy(&self, _at: &StateView<'_, V>, _ledger: &mut Ledger) {}

    /// Angular momentum of rotation, besides that of the motion of particles [kg·m²/s].
    fn spin(&self) -> DVec3 {
        DVec3::ZERO
    }

    /// Fields, in the caller's order.
    fn fields(&self) -> Vec<FieldInfo> {
        Vec::new()
    }

    /// Values of a field.
    fn read(&self, _field: usize, _state: &ForcedState<'_, V>) -> Vec<f64> {
        Vec::new()
    }

    /// Replaces a field that is a part of the state.
    fn adopt(&mut self, _field: &str, _values: &[f64]) {}

    /// Whether springs can break, so that steps are taken one at a time.
    fn tears(&self) -> bool {
        false
    }

    /// Breaks the springs that are stretched too far after a step; returns whether there are any.
    fn tear(&mut self, _matter: &Matter<V>) -> bool {
        false
    }

    /// Broken springs, if springs can break.
    fn breakage(&self) -> Option<Breakage> {
        None
    }

    /// Counts the energy [J] of forces that depended on springs that broke as dissipated.
    fn lose(&mut self, _energy: f64) {}

    /// Removes broken springs and all that depends on them.
    fn leave_out(&mut self, _breakage: &Breakage) {}
}

/// Constraints of a scene, in the order of their actions.
pub struct Constraints<V: Space> {
    list: Vec<Box<dyn Constraint<V>>>,
    /// Properties of each.
    abouts: Vec<ConstraintProperties>,
}

impl<V: Space> Constraints<V> {
    /// All constraints.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Constraint<V>> {
        self.list.iter().map(|constraint| &**constraint)
    }

    /// All constraints, mutable.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Box<dyn Constraint<V>>> {
        self.list.iter_mut()
    }

    /// Properties of all constraints.
    pub fn abouts(&self) -> impl Iterator<Item = &ConstraintProperties> {
        self.abouts.iter()
    }

    /// Rotations of the rigid bodies, as forces see them.
    pub fn solids(&self) -> Vec<SolidMotion> {
        self.iter().flat_map(Constraint::solids).collect()
    }

    /// Whether some constraints act within a step.
    pub fn act(&self) -> bool {
        self.iter().any(|constraint| !constraint.tears())
    }

    /// Whether some constraints change the velocities at the end of a step.
    pub fn change_velocities(&self) -> bool {
        self.abouts().any(|about| about.stages.iter().any(|stage| stage.last))
    }

    /// Breaks the springs that are stretched too far after a step; returns whether there are any.
    pub fn tear(&mut self, matter: &Matter<V>) -> bool {
        let mut torn = false;
        for constraint in &mut self.list {
            torn |= constraint.tear(matter);
        }
        torn
    }

    /// Broken springs, if springs can break.
    pub fn breakage(&self) -> Option<Breakage> {
        self.iter().find_map(Constraint::breakage)
    }
}

/// History: all constraints, in their order.
impl<V: Space> History for Constraints<V> {
    fn save(&mut self) {
        self.list.iter_mut().for_each(|constraint| constraint.save());
    }

    fn rollback(&mut self) {
        self.list.iter_mut().for_each(|constraint| constraint.rollback());
    }

    fn capture(&self, archive: &mut Archive) {
        let named = self.list.iter().zip(&self.abouts);
        named.for_each(|(each, about)| archive.within(about.name, |archive| each.capture(archive)));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let mut named = self.list.iter_mut().zip(&self.abouts);
        named.try_for_each(|(each, about)| archive.within(about.name, |archive| each.restore(archive)))
    }
}

/// Methods that carry a constraint, and a hint for the others.
struct Carriers {
    constraint: &'static str,
    methods: &'static [&'static str],
    hint: &'static str,
}

/// Names of the constraints.
const RODS: &str = "rods";
const WIRES: &str = "wires";
const RIGID: &str = "rigid bodies";
const MESHES: &str = "SelfContact and strain limits";

/// Methods that carry each constraint. XPBD projects rods itself.
const CARRIERS: [Carriers; 4] = [
    Carriers {
        constraint: RODS,
        methods: &["RATTLE", "XPBD"],
        hint: "their stiffness is infinite, and it takes springs as forces; RATTLE holds lengths to rounding",
    },
    Carriers {
        constraint: MESHES,
        methods: &["VelocityVerlet", "BackwardEuler", "BDF2", "XPBD", "ProjectiveDynamics"],
        hint: "",
    },
    Carriers {
        constraint: RIGID,
        methods: &["VelocityVerlet", "RATTLE"],
        hint: "their steps are a kick, a drift and a kick; RATTLE(order=4) turns bodies that touch nothing",
    },
    Carriers {
        constraint: WIRES,
        methods: &["VelocityVerlet", "RATTLE", "BackwardEuler", "BDF2", "XPBD", "ProjectiveDynamics"],
        hint: "",
    },
];

/// Refuses a constraint that a method does not carry, by its name.
fn refuse(constraint: &str, about: &MethodProperties) -> Result<()> {
    let known = CARRIERS.iter().find(|carriers| carriers.constraint == constraint);
    let Some(Carriers { methods, hint, .. }) = known.filter(|carriers| !carriers.methods.contains(&about.name)) else {
        return Ok(());
    };
    let names: Vec<String> = methods.iter().map(|name| format!("{name}()")).collect();
    let expected = match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => names.concat(),
    };
    let error = Error::parameter("integrator", format!("{expected} for {constraint}"), about.name);
    Err(error.with_hint(*hint))
}

/// Parts of a scene from which constraints are built.
pub struct Declaration<'a, V: Space> {
    pub scene: &'a Scene,
    /// All springs, in the engine's order of particles.
    pub springs: &'a [Spring],
    pub properties: &'a Properties<V>,
    /// Walls of the scene.
    pub walls: Option<&'a mut Contacts<V>>,
    /// Method that is to carry the constraints.
    pub method: &'a MethodProperties,
    pub executor: &'a Executor,
}

/// Builds the constraints of a scene. Registry of constraints.
///
/// # Errors
/// If a value is wrong, if the method does not carry a constraint, if its equations do not fit into memory, or on an
/// interrupt.
pub fn build<V: Space>(declared: &mut Declaration<'_, V>) -> Result<Constraints<V>> {
    let mut list: Vec<Box<dyn Constraint<V>>> = Vec::new();
    list.extend(Rods::declared(declared)?.map(|rods| Box::new(rods) as Box<dyn Constraint<V>>));
    list.extend(Tearing::declared(declared)?.map(|tearing| Box::new(tearing) as Box<dyn Constraint<V>>));
    list.extend(Wires::declared(declared)?.map(|wires| Box::new(wires) as Box<dyn Constraint<V>>));
    list.extend(SelfContacts::declared(declared)?.map(|meshes| Box::new(meshes) as Box<dyn Constraint<V>>));
    list.extend(RigidBodies::declared(declared)?.map(|bodies| Box::new(bodies) as Box<dyn Constraint<V>>));
    let abouts = list.iter().map(|constraint| constraint.about()).collect();
    Ok(Constraints { list, abouts })
}

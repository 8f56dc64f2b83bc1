//! Compilation of a scene into exactly the stages that it requires, in order.

use glam::DVec3;

use super::MatterSystem;
use super::constraints::{self, ConstraintProperties, ConstraintStage, Declaration, rods, self_contact};
use super::dynamics::Dynamics;
use super::methods::{Method, MethodProperties as MethodAbout, Treatment};
use crate::catalog::{Catalog, ForceLaws, Space};
use crate::contacts::Contacts;
use crate::error::{Error, Result};
use crate::forces::linear::Fusion;
use crate::forces::springs::{self, Spring};
use crate::forces::{About, DensityScheme, Force, Reach, VelocityDependence, fluid};
use crate::integrators::{BlanesMoan4, BlanesMoan6, Facts, Integrator};
use crate::math::Real;
use crate::matter::{Columns, Matter, Properties};
use crate::memory;
use crate::neighbors;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::scene::{self, Item, PARTICLES, RIGID_BODIES, Scene};

mod precision;

/// Compiles a scene for a method.
///
/// # Errors
/// If the scene is invalid or does not fit into memory, or on an interrupt.
pub fn compile<V: Space>(
    scene: &Scene,
    method: Box<dyn Method<V>>,
    catalog: Catalog,
    executor: &Executor,
) -> Result<MatterSystem<V>> {
    let laws = catalog.forces;
    let about = method.about();
    let [projects, solves] = [Treatment::Projections, Treatment::Solved].map(|treatment| about.springs == treatment);
    let count = scene.count();
    let known = |kind: &str| [PARTICLES, springs::KIND, fluid::KIND, RIGID_BODIES].contains(&kind);
    if let Some(body) = scene.bodies.iter().find(|body| !known(&body.item.kind)) {
        return Err(scene::unknown(&body.item, "a body: Particles, SpringNetwork, Fluid or RigidBodies"));
    }
    memory::check("scene", footprint::<V>(scene, laws, &about)?, 0, || {
        format!("for {count} particles and what {} keeps of each; take fewer particles or precision=\"f32\"", about.name)
    })?;
    let springs = springs::declared(scene)?;
    let order = ordering(scene, laws, &springs);
    executor.check()?;
    let properties = properties::<V>(scene, &order);
    precision::check::<V>(scene, &springs, &properties)?;
    let springs = renumbered(springs, &order);
    executor.check()?;

    let mut all: Vec<Box<dyn Force<V>>> = Vec::new();
    let elastic: Vec<Spring> = springs.iter().filter(|spring| !rods::is_rod(spring)).copied().collect();
    if !elastic.is_empty() {
        all.push(V::forces(catalog).springs(&elastic, count));
    }
    all.extend(fluid(scene, catalog, (&properties, &about), executor)?);
    let mut fusion = Fusion::new(if solves { count } else { 0 });
    for item in &scene.forces {
        executor.check()?;
        let mut built = V::forces(catalog).build(scene, item, &properties, executor)?;
        refuse_forces(&about, item, &mut built, (&properties, &mut fusion))?;
        if built.iter().any(|force| force.about().kinks) && about.springs != Treatment::Rods {
            about.refuse_kinks(&item.kind)?;
        }
        all.extend(built);
    }
    let mut contacts = contacts(scene, &properties, &about)?;
    let walls = contacts.as_mut();
    let mut declaration = Declaration { scene, springs: &springs, properties: &properties, walls, method: &about, executor };
    let constraints = constraints::build(&mut declaration)?;
    let known: Vec<About> = all.iter().map(|force| force.about()).collect();
    let held: Vec<ConstraintProperties> = constraints.abouts().cloned().collect();
    let (stages, mut notes) = sequence(&known, &held, &about, contacts.is_some());

    let alone = |force: &About| force.reach == Reach::Pointwise && !force.callback;
    let independent = !about.sweeps && !constraints.act() && known.iter().all(alone);
    let exact = held.iter().any(|constraint| constraint.exact) || known.iter().any(|force| force.reach == Reach::Pairs);
    let mut state = state::<V>(scene, &properties, MatterSystem::<V>::block(&about, independent), exact)?;
    if let Some(contacts) = &contacts {
        let pushed = contacts.project_inside(&mut state.position, &properties)?;
        if pushed > 0 {
            notes.push(format!("contacts: {pushed} particles overlapped a boundary at the start and were moved to its surface"));
        }
    }
    notes.extend(relativistic(scene, laws));
    let left_out = left_out(&known, independent, contacts.is_some());
    let bends = contacts.is_none() && known.iter().any(|force| force.name != "gravity");
    let layout = if independent {
        format!("blocks of {} independent particles, many steps while a block is in the cache", state.block)
    } else {
        format!("a sweep over blocks of {} particles per evaluation", state.block)
    };
    let mut dynamics = Dynamics::new(catalog, properties, all, contacts, state.block);
    dynamics.angle = about.angle;
    dynamics.treatment = about.springs;
    dynamics.springs = if projects || solves { springs } else { Vec::new() };
    let dissipative = dynamics.velocity != VelocityDependence::None;
    let nominal = held.iter().map(|constraint| constraint.order).fold(about.orders[usize::from(dissipative)], u32::min);
    let order = known.iter().map(|force| force.order).fold(nominal, u32::min);
    notes.extend(advice(&about, dissipative, bends && !dynamics.scheme.is_some_and(DensityScheme::is_carried)));
    executor.check()?;
    let stages = Stages {
        item: String::new(),
        names: stages,
        dimension: V::DIMENSION,
        precision: V::Scalar::NAME,
        method: about.name,
        order,
        evaluations: about.evaluations,
        pairs: dynamics.pairs(),
        force_error: known.iter().map(|force| force.force_error).fold(0.0, f64::max),
        limit_varies: false,
        layout,
        left_out,
        notes,
    };
    let is_field = |item: &&Item| laws.feels_charges(item) || !laws.is_between_pairs(item);
    let fields = scene.forces.iter().filter(is_field).cloned().collect();
    Ok(MatterSystem::new((dynamics, constraints), state, method, stages, fields))
}

/// Fluid of a scene, for a method that supports fluids.
fn fluid<V: Space>(
    scene: &Scene,
    catalog: Catalog,
    (properties, about): (&Properties<V>, &MethodAbout),
    executor: &Executor,
) -> Result<Option<Box<dyn Force<V>>>> {
    let Some(fluid) = V::fluids(catalog).build(scene, catalog.forces, properties, executor)? else { return Ok(None) };
    about.refuse_kinks("a fluid")?;
    if [Treatment::Projections, Treatment::Solved].contains(&about.springs) {
        return Err(cannot_take(about, fluid::KIND));
    }
    let continuity = fluid.fluid().is_some_and(|scheme| scheme.density().is_carried());
    if let (true, Some(reason)) = (continuity, about.refusals.fields) {
        let fits = |other: &Facts| other.refuses_fields.is_none() && !other.gyrates;
        let fit: Vec<_> = Facts::all().iter().filter(|other| fits(other)).map(|other| format!("{}()", other.name)).collect();
        let expected = format!("{} for a fluid that carries its density along", fit.join(", "));
        return Err(Error::parameter("integrator", expected, about.name).with_hint(reason));
    }
    Ok(Some(fluid))
}

/// Contacts of a scene with walls, for a method that supports them.
fn contacts<V: Space>(scene: &Scene, properties: &Properties<V>, about: &MethodAbout) -> Result<Option<Contacts<V>>> {
    let contacts = Contacts::build(scene, properties)?;
    if contacts.is_some() && (about.springs != Treatment::Rods || about.orders[0] != 2) {
        about.refuse_kinks("boundaries")?;
    }
    Ok(contacts)
}

/// Refuses forces for which a method has no projections, or no derivatives. A force without derivatives passes if it joins
/// the linear force of the forces before it.
fn refuse_forces<V: Space>(
    about: &MethodAbout,
    item: &Item,
    built: &mut [Box<dyn Force<V>>],
    (properties, fusion): (&Properties<V>, &mut Fusion),
) -> Result<()> {
    let mut fits = |force: &mut dyn Force<V>| match about.springs {
        Treatment::Projections => force.about().reach == Reach::Pointwise,
        Treatment::Solved => force.fuse(properties, fusion) || force.derivatives().is_some(),
        Treatment::Forces | Treatment::Rods => true,
    };
    if built.iter_mut().all(|force| fits(force.as_mut())) { Ok(()) } else { Err(cannot_take(about, &item.kind)) }
}

/// Error of a method without projections, or derivatives, of a kind of item.
fn cannot_take(about: &MethodAbout, kind: &str) -> Error {
    let expected = format!("one that evaluates forces, such as VelocityVerlet(), for a {kind}");
    Error::parameter("integrator", expected, about.name).with_hint(if about.springs == Treatment::Solved {
        "it takes springs, Gravity, Drag, CentralForce, SoftSpheres, LennardJones, Dihedral and Wind, whose derivatives are known, \
         and Gravitation and Coulomb as exact sums (opening_angle=0) over up to a million pairs"
    } else {
        "it has projections for springs alone, and takes fields as they are"
    })
}

/// Names of the stages of a step in their order, and notes on the layouts of the forces and on the constraints.
fn sequence(
    known: &[About],
    constraints: &[ConstraintProperties],
    about: &MethodAbout,
    contacts: bool,
) -> (Vec<String>, Vec<String>) {
    let (mut stages, mut notes): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for About { name, layout, remarks, reach, .. } in known {
        if !layout.is_empty() {
            notes.push(format!("{name}: {layout}"));
        }
        notes.extend(remarks.iter().cloned());
        if *reach == Reach::Pairs && stages.first().is_none_or(|stage| stage != "neighbors") {
            stages.insert(0, "neighbors".to_owned());
        }
        if !stages.iter().any(|stage| stage == name) {
            stages.push((*name).to_owned());
        }
    }
    stages.push(about.name.to_owned());
    // If positions are final before the evaluation of forces, contacts and constraints come first.
    let mut place = if about.drifts_first() { 0 } else { stages.len() };
    if contacts {
        stages.insert(place, "contacts".to_owned());
        place += 1;
    }
    for ConstraintStage { name, note, last } in constraints.iter().flat_map(|about| &about.stages) {
        stages.insert(if *last { stages.len() } else { place }, (*name).to_owned());
        place += usize::from(!last);
        notes.extend(note.iter().map(|note| format!("{name}: {note}")));
    }
    (stages, notes)
}

/// Memory of a particle besides its state [bytes]: its properties, and during compilation its index in two orders.
const PROPERTIES: usize = 100;
/// Memory of a particle with neighbors, of a fluid particle besides that, and of a particle with forces at a distance, without neighbor
/// lists [bytes].
const NEIGHBOR: usize = 800;
const FLUID: usize = 100;
const FAR: usize = 400;
/// Memory of a spring, of a rod besides that, and of a triangle or free edge in contact with others [bytes].
const SPRING: usize = 250;
const ROD: usize = 400;
const ELEMENT: usize = 1700;

/// Estimated peak memory of a scene, during and after compilation [bytes]. Neighbor lists are excluded: they are checked when
/// they are built.
fn footprint<V: Space>(scene: &Scene, laws: &dyn ForceLaws, about: &MethodAbout) -> Result<usize> {
    let springs = springs::count(scene)?;
    let independent = springs == 0 && !laws.are_between_neighbors(scene) && !about.sweeps;
    let registers = if independent { about.memory.readable } else { about.memory.registers };
    // State with its copy, and workspace of sweeps.
    let columns = 2 * (2 + registers) + about.memory.own + if independent { 0 } else { 6 };
    let vector = V::DIMENSION * size_of::<V::Scalar>();
    let pairs =
        [(laws.are_between_neighbors(scene), NEIGHBOR), (fluid::is_in(scene), FLUID), (laws.are_at_a_distance(scene), FAR)];
    let pairs: usize = pairs.into_iter().filter(|(holds, _)| *holds).map(|(_, bytes)| bytes).sum();
    let particles = scene.count() * (columns * vector + PROPERTIES + pairs);
    let spring = SPRING + if about.springs == Treatment::Rods { ROD } else { 0 };
    Ok(particles + springs * spring + self_contact::elements(scene)? * ELEMENT)
}

/// Advice on a better integrator; None under gravity alone, or where contacts reduce every method's order.
fn advice(about: &MethodAbout, dissipative: bool, bends: bool) -> Option<String> {
    match (about.orders[0], dissipative) {
        _ if !bends || about.orders[0] > BlanesMoan6::ORDER => None,
        // Methods for stiff matter are not chosen for their order.
        _ if matches!(about.springs, Treatment::Projections | Treatment::Solved) => None,
        (1, false) => Some("order 1: VelocityVerlet costs the same and is of order 2".to_owned()),
        (1, true) => Some(
            "order 1: VelocityVerlet costs the same per step and is of order 2; where damping limits the step it bears half of it"
                .to_owned(),
        ),
        (_, false) if ![BlanesMoan4::NAME, BlanesMoan6::NAME].contains(&about.name) => Some(format!(
            "nothing here depends on velocity: with dt below {:.0}% of the stability limit {} keeps energy better at equal cost, and its energy error does not grow",
            100.0 * worth::<BlanesMoan4>(about).min(1.0),
            BlanesMoan4::NAME
        )),
        (_, true) if about.orders[1] < about.orders[0] => Some(format!(
            "forces depend on velocity: {} is only of order {} here; RungeKutta4 keeps order 4, VelocityVerlet gives order 2 with one evaluation instead of {}",
            about.name,
            about.orders[1],
            about.evaluations
        )),
        _ => None,
    }
}

/// Fraction of an integrator's limit below which another one, at equal cost, takes steps of at most half of its own limit.
fn worth<Other: Integrator>(about: &MethodAbout) -> f64 {
    let reach = |limit: f64, evaluations: usize| limit / evaluations as f64;
    0.5 * reach(Other::limit(0.0), Other::NODES.len()) / reach((about.limit)(0.0), about.evaluations)
}

/// Note that charges are so fast that relativity matters, which is not included: γ − 1 is above half a percent.
fn relativistic(scene: &Scene, laws: &dyn ForceLaws) -> Option<String> {
    const SPEED_OF_LIGHT: f64 = 299_792_458.0;
    let speeds = scene.bodies.iter().flat_map(|body| &body.velocities).map(|velocity| velocity.length());
    let fastest = speeds.fold(0.0, f64::max);
    (scene.forces.iter().any(|item| laws.feels_charges(item)) && fastest > 0.1 * SPEED_OF_LIGHT).then(|| {
        format!(
            "particles move at up to {:.2} c, and nothing here is relativistic: above 0.1 c masses are off by more than 0.5 %",
            fastest / SPEED_OF_LIGHT
        )
    })
}

fn left_out(forces: &[About], independent: bool, contacts: bool) -> Vec<&'static str> {
    let mut absent = Vec::new();
    if forces.iter().all(|force| force.reach != Reach::Pairs) {
        absent.push("neighbors");
    }
    if forces.iter().all(|force| force.name != "springs") {
        absent.push("springs");
    }
    if independent {
        absent.push("sweeps between stages");
    }
    if !contacts {
        absent.push("contacts");
    }
    absent
}

/// Index in the engine's order → index in the caller's order, for locality of spring partners and of neighbors.
fn ordering(scene: &Scene, laws: &dyn ForceLaws, springs: &[Spring]) -> Vec<u32> {
    if springs.is_empty() && laws.are_between_neighbors(scene) {
        return neighbors::ordering(&scene.positions(), scene.dimension);
    }
    laws.order(springs, scene.count()).unwrap_or_else(|| (0..scene.count() as u32).collect())
}

/// Constant properties in the engine's order, with the origin at the center of all positions.
fn properties<V: Space>(scene: &Scene, order: &[u32]) -> Properties<V> {
    let bodies = || scene.bodies.iter().flat_map(|body| 0..body.positions.len()).zip(owners(scene));
    let ordered = |values: Vec<f64>| -> Vec<f64> { order.iter().map(|&caller| values[caller as usize]).collect() };
    let of = |value: &dyn Fn(usize, usize) -> f64| ordered(bodies().map(|(index, body)| value(body, index)).collect());
    let mass = of(&|body, index| if scene.bodies[body].fixed[index] { f64::INFINITY } else { scene.bodies[body].mass[index] });
    let owner: Vec<u32> = owners(scene).map(|body| body as u32).collect();
    Properties {
        charge: of(&|body, index| scene.bodies[body].charge[index]),
        radius: of(&|body, index| scene.bodies[body].radius[index]),
        body: order.iter().map(|&caller| owner[caller as usize]).collect(),
        caller: order.to_vec(),
        origin: origin::<V>(scene),
        ..Properties::new(mass)
    }
}

fn owners(scene: &Scene) -> impl Iterator<Item = usize> {
    scene.bodies.iter().enumerate().flat_map(|(body, matter)| std::iter::repeat_n(body, matter.positions.len()))
}

/// Origin of the positions [m]. In single precision: the center of all positions, rounded to a number that both precisions
/// hold. Double precision needs none.
fn origin<V: Space>(scene: &Scene) -> DVec3 {
    let positions = || scene.bodies.iter().flat_map(|body| &body.positions);
    if V::Scalar::NAME == "f64" || positions().next().is_none() {
        return DVec3::ZERO;
    }
    let low = positions().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    (0.5 * low + 0.5 * high).as_vec3().as_dvec3()
}

fn renumbered(springs: Vec<Spring>, order: &[u32]) -> Vec<Spring> {
    let mut engine = vec![0; order.len()];
    order.iter().enumerate().for_each(|(index, &caller)| engine[caller as usize] = index as u32);
    springs.into_iter().map(|spring| Spring { ends: spring.ends.map(|end| engine[end as usize]), ..spring }).collect()
}

/// Initial state in the engine's order. If `exact`, with the low-order part of positions.
fn state<V: Space>(scene: &Scene, properties: &Properties<V>, block: usize, exact: bool) -> Result<Matter<V>> {
    let count = properties.count();
    let positions = scene.positions();
    let velocities: Vec<DVec3> = scene.bodies.iter().flat_map(|body| &body.velocities).copied().collect();
    let mut state = Matter::zeros(count, 0, block);
    if exact && V::Scalar::NAME == "f32" {
        state.residual = Columns::zeros(count);
    }
    (0..count)
        .for_each(|index| state.set_exact_position(index, positions[properties.caller[index] as usize] - properties.origin));
    state.velocity = Columns::from_fn(count, |index| V::narrow(velocities[properties.caller[index] as usize]));
    for (name, columns, given) in [("positions", &state.position, &positions), ("velocities", &state.velocity, &velocities)] {
        if let Some(index) = columns.out_of_range() {
            let (caller, body) = (properties.caller[index] as usize, properties.body[index] as usize);
            let first = scene.first(body);
            return Err(out_of_range::<V>(&format!("bodies[{body}].{name}[{}]", caller - first), given[caller]));
        }
    }
    Ok(state)
}

/// Error for a vector at `path` that is out of range in the precision of the run.
pub fn out_of_range<V: Space>(path: &str, found: DVec3) -> Error {
    let found = &found.to_array()[..V::DIMENSION];
    Error::parameter(path, format!("numbers in the range of {}", V::Scalar::NAME), format!("{found:?}"))
}

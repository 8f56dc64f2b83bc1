//! Rigid bodies, joints and boundaries of a scene.

use glam::DVec3;
use physcore_rigid::joints::{DampedSpring, Joint, JointKind, Motor};
use physcore_rigid::mover::Mover;
use physcore_rigid::rotation::{Inertia, Orientation};
use physcore_rigid::shapes::{self, MassProperties, SolidShape};
use physcore_rigid::surface::{Friction, Surface};
use physcore_rigid::world::{
    CenterMotion, ContactSolver, FixedSolid, FreePoint, RigidWorld, SleepRule, SolidBody, Turn, WORLD, WorldJoint,
};

use super::RigidBodies;
use super::anchors::Ties;
use super::faces::NetworkFaces;
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::fluid;
use crate::matter::Properties;
use crate::scene::{Item, RIGID_BODIES, Scene};
use crate::systems::matter::constraints::{Declaration, RIGID, refuse};

/// Kinds of joints.
pub const JOINTS: [&str; 6] = ["Hinge", "BallJoint", "Weld", "Prismatic", "Rod", "SpringJoint"];
const MOTOR: &str = "Motor";

impl RigidBodies {
    /// Rigid bodies of a scene; None if it has none.
    ///
    /// # Errors
    /// If a value is wrong, or the method does not carry rigid bodies.
    pub fn declared<V: Space>(declared: &mut Declaration<'_, V>) -> Result<Option<Self>> {
        let Declaration { scene, properties, method, .. } = *declared;
        let Some(first) = scene.bodies.iter().find(|body| body.item.kind == RIGID_BODIES) else { return Ok(None) };
        refuse(RIGID, method)?;
        let mut world = RigidWorld::new(scene.dimension == 2);
        world.solver = solver(&first.item)?;
        let engine = properties.engine();
        let mut particles = Vec::new();
        let mut places = vec![None; scene.count()];
        for (index, _) in scene.bodies.iter().enumerate().filter(|(_, body)| body.item.kind == RIGID_BODIES) {
            let start = scene.first(index);
            for row in 0..scene.bodies[index].positions.len() {
                places[start + row] = Some(particles.len());
                particles.push(engine[start + row]);
            }
            add_bodies(&mut world, scene, index)?;
        }
        add_walls(&mut world, scene)?;
        world.state.torques = vec![DVec3::ZERO; world.bodies.len()];
        let ties = Ties::declared(declared, &mut world, &places)?;
        world.state.ties = vec![DVec3::ZERO; ties.count];
        world.let_sleep(sleep_rules(scene, &ties)?);
        let points = points(&mut world, scene, properties, &engine, &ties);
        let shapes = || world.bodies.iter().map(|body| &world.shapes[body.surface.shape]);
        let round =
            if shapes().all(SolidShape::is_round) { shapes().map(SolidShape::reach).fold(f64::INFINITY, f64::min) } else { 0.0 };
        let faces = NetworkFaces::declared(scene, &engine, &points, (&properties.radius, round))?;
        let starts = ties.centers(&world, scene, &places);
        let joined = add_joints(&mut world, scene, &places, &starts, &points)?;
        let path = first.item.path.clone();
        if scene.periodic.is_some() && (world.can_touch() || !points.is_empty()) {
            return Err(Error::parameter(path, "no Periodic domain in a scene of bodies that may touch something", "one")
                .with_hint("contacts are those of the bodies themselves, not of their images"));
        }
        let mut held = Self {
            saved: world.state.clone(),
            world,
            particles,
            points,
            faces,
            joined,
            tied: ties.bodies,
            starts: Vec::new(),
            places: Vec::new(),
            apart: false,
            motions: Vec::new(),
            others: Vec::new(),
            moved: Vec::new(),
            near: Vec::new(),
            near_faces: Vec::new(),
            order: 2,
            firsts: (0..scene.bodies.len()).map(|body| scene.first(body)).collect(),
            overlap: None,
            path,
        };
        if method.orders[0] > 2 {
            held.refuse_contacts(method.name)?;
            held.order = 4;
        }
        Ok(Some(held))
    }

    /// Refuses contacts, limits and motors, whose motion is not smooth.
    fn refuse_contacts(&self, method: &str) -> Result<()> {
        let (touch, bounded) = (self.world.can_touch() || !self.points.is_empty(), self.world.has_bounded_joints());
        let sleeps = self.world.may_sleep();
        let what = if touch {
            "may touch"
        } else if sleeps {
            "may sleep"
        } else {
            "have joints with limits or motors"
        };
        if touch || bounded || sleeps {
            let expected = format!("order=2 for rigid bodies that {what}");
            let error = Error::parameter("integrator", expected, format!("{method}(order=4)"));
            return Err(error.with_hint("steps of order 4 go back in time, and impacts cannot"));
        }
        Ok(())
    }
}

/// Rules by which the rigid bodies of a scene fall asleep. Particles that are tied to a body keep it awake.
fn sleep_rules(scene: &Scene, ties: &Ties) -> Result<Vec<SleepRule>> {
    let mut rules = Vec::new();
    for body in scene.bodies.iter().filter(|body| body.item.kind == RIGID_BODIES) {
        let (item, first) = (&body.item, rules.len());
        rules.resize(first + body.positions.len(), SleepRule::default());
        if item.values.contains_key("sleep") {
            let (speeds, times) =
                (item.numbers("sleep", body.positions.len())?, item.numbers("sleep_after", body.positions.len())?);
            let free = (first..rules.len()).zip(speeds.iter().zip(times)).filter(|(row, _)| !body.fixed[row - first]);
            for (row, (&speed, &after)) in free {
                rules[row] = SleepRule { speed, after };
            }
        }
    }
    ties.bodies.iter().for_each(|tied| rules[tied.body] = SleepRule::default());
    Ok(rules)
}

/// Numerics of contacts, which stand in the record of the first rigid bodies; the default where there is none.
fn solver(item: &Item) -> Result<ContactSolver> {
    if !item.values.contains_key("contacts") {
        return Ok(ContactSolver::default());
    }
    let record = item.record("contacts")?;
    let whole = |name: &str, least: f64| match record.number(name)? {
        number if number >= least && number.fract() == 0.0 => Ok(number as usize),
        _ => Err(record.wrong(name, &format!("a whole number ≥ {least}"), record.values.get(name))),
    };
    Ok(ContactSolver {
        substeps: whole("substeps", 1.0)?,
        iterations: whole("iterations", 1.0)?,
        sequential: whole("sequential", 0.0)?,
    })
}

/// Adds the rigid bodies of an item.
pub(super) fn add_bodies(world: &mut RigidWorld, scene: &Scene, index: usize) -> Result<()> {
    let body = &scene.bodies[index];
    let (item, count) = (&body.item, body.positions.len());
    let (shape, MassProperties { size, inertia, .. }) = SolidShape::declared(item.record("shape")?, scene.dimension)?;
    world.shapes.push(shape);
    let columns = ["friction", "restitution", "rolling_friction", "torsional_friction"];
    let [friction, restitution, rolling, torsional] = columns.map(|name| item.numbers(name, count));
    let (friction, restitution, rolling, torsional) = (friction?, restitution?, rolling?, torsional?);
    let planar = world.planar;
    let turning: Vec<DVec3> = if planar {
        item.numbers("angular_velocities", count)?.iter().map(|&rate| DVec3::new(0.0, 0.0, rate)).collect()
    } else {
        item.vectors("angular_velocities", Some(count), 3)?
    };
    let orientations = Orientation::declared(item, count, scene.dimension)?;
    for row in 0..count {
        let density = body.mass[row] / size;
        let inertia = if planar { Inertia::planar(density * inertia.z_axis.z) } else { Inertia::spatial(inertia * density) };
        let fixed = body.fixed[row];
        world.bodies.push(SolidBody {
            surface: Surface {
                shape: world.shapes.len() - 1,
                friction: Some(Friction { sliding: friction[row], rolling: rolling[row], torsional: torsional[row] }),
                restitution: restitution[row],
            },
            inverse_mass: if fixed { 0.0 } else { 1.0 / body.mass[row] },
            inertia: if fixed { Inertia::NONE } else { inertia },
        });
        let spin = if fixed { turning[row] } else { inertia.spin(&orientations[row], turning[row]) };
        world.state.turns.push(Turn { orientation: orientations[row], spin });
        world.names.push(if count == 1 { item.path.clone() } else { format!("{}[{row}]", item.path) });
    }
    Ok(())
}

/// Adds the boundaries of a scene as fixed shapes.
pub(super) fn add_walls(world: &mut RigidWorld, scene: &Scene) -> Result<()> {
    let rigid: Vec<usize> = (0..scene.bodies.len()).filter(|&body| scene.bodies[body].item.kind == RIGID_BODIES).collect();
    let boundaries = scene.boundaries.iter().enumerate();
    for (index, item) in boundaries.filter(|(_, item)| rigid.iter().any(|&body| item.acts_on(body))) {
        for wall in shapes::walls(item, index, scene.dimension)? {
            world.shapes.push(wall.shape);
            let friction = Friction { sliding: wall.friction, ..Friction::default() };
            let surface = Surface { shape: world.shapes.len() - 1, friction: Some(friction), restitution: wall.restitution };
            world.walls.push(FixedSolid { surface, mover: Mover::wall(&wall.pose) });
            world.wall_names.push(item.path.clone());
        }
    }
    Ok(())
}

/// Particles that may meet the bodies, in the caller's order, without those that are tied and those of fluids. A particle has the
/// friction and restitution of what it meets.
fn points<V: Space>(
    world: &mut RigidWorld,
    scene: &Scene,
    properties: &Properties<V>,
    engine: &[u32],
    ties: &Ties,
) -> Vec<(u32, FreePoint)> {
    let mut points = Vec::new();
    let mut known: Vec<(f64, usize)> = Vec::new();
    let meets = |item: &Item| ![RIGID_BODIES, fluid::KIND].contains(&item.kind.as_str());
    for (index, body) in scene.bodies.iter().enumerate().filter(|(_, body)| meets(&body.item)) {
        let start = scene.first(index);
        for row in (0..body.positions.len()).filter(|row| ties.owners[start + row].is_none()) {
            let particle = engine[start + row];
            let radius = properties.radius[particle as usize];
            let shape = known.iter().find(|(other, _)| *other == radius).map(|(_, shape)| *shape);
            let shape = shape.unwrap_or(world.shapes.len());
            if shape == world.shapes.len() {
                world.shapes.push(SolidShape::round(radius));
                known.push((radius, shape));
            }
            let inverse_mass = 1.0 / properties.mass[particle as usize];
            let surface = Surface { shape, friction: None, restitution: 0.0 };
            points.push((particle, FreePoint { index: start + row, surface, inverse_mass }));
        }
    }
    points
}

/// Adds the joints of a scene; returns whether a joint holds each point.
pub(super) fn add_joints(
    world: &mut RigidWorld,
    scene: &Scene,
    places: &[Option<usize>],
    starts: &[DVec3],
    points: &[(u32, FreePoint)],
) -> Result<Vec<bool>> {
    let mut joined = vec![false; points.len()];
    let mut numbers = vec![None; scene.constraints.len()];
    for (number, item) in scene.constraints.iter().enumerate().filter(|(_, item)| JOINTS.contains(&item.kind.as_str())) {
        numbers[number] = Some(world.state.joints.len());
        // The force of a joint is that on `one`: the second end here.
        let mut ends = [WORLD; 2];
        let mut movers = [Mover::wall(&physcore_rigid::pose::Pose::WORLD); 2];
        for (side, name) in ["other", "one"].into_iter().enumerate() {
            if !item.values.contains_key(name) {
                continue;
            }
            let particle = item.number(name)? as usize;
            let Some(place) = places.get(particle) else {
                return Err(item.wrong(name, "a particle of the scene", item.values.get(name)));
            };
            if let Some(body) = *place {
                ends[side] = body;
                movers[side] = world.mover(body, &CenterMotion::free(starts[particle], DVec3::ZERO), 1.0);
            } else {
                ends[side] = world.bodies.len() + particle;
                movers[side].position = starts[particle];
                if let Ok(point) = points.binary_search_by_key(&particle, |(_, point)| point.index) {
                    joined[point] = true;
                }
            }
        }
        let joint = joint(item, scene.dimension, [&movers[0], &movers[1]])?;
        world.state.joints.push(WorldJoint::new(ends, joint));
    }
    for item in scene.constraints.iter().filter(|item| item.kind == MOTOR) {
        let index = item.number("joint")? as usize;
        let joint = numbers.get(index).copied().flatten().map(|joint: usize| &mut world.state.joints[joint].joint);
        let Some(joint) = joint.filter(|joint| matches!(joint.kind, JointKind::Hinge | JointKind::Prismatic)) else {
            return Err(item.wrong("joint", "the index of a hinge or of a prismatic joint", item.values.get("joint")));
        };
        joint.motor = Some(Motor { speed: item.number("speed")?, most: item.non_negative("torque")? });
    }
    Ok(joined)
}

/// Joint that an item declares.
fn joint(item: &Item, dimension: usize, movers: [&Mover; 2]) -> Result<Joint> {
    let axis = || item.vector("axis").map(DVec3::normalize);
    let anchor = || item.vector("anchor").map(|anchor| [anchor; 2]);
    let anchors = || item.vectors("anchors", Some(2), dimension).map(|anchors| [anchors[1], anchors[0]]);
    let (kind, points, axis) = match item.kind.as_str() {
        "Hinge" if dimension == 2 => (JointKind::Hinge, anchor()?, DVec3::Z),
        "Hinge" => (JointKind::Hinge, anchor()?, axis()?),
        "BallJoint" => (JointKind::Ball, anchor()?, DVec3::Z),
        "Weld" => (JointKind::Weld, anchor()?, DVec3::Z),
        "Prismatic" => (JointKind::Prismatic, anchor()?, axis()?),
        "Rod" => {
            let points = anchors()?;
            (JointKind::Rod(points[0].distance(points[1])), points, DVec3::Z)
        }
        _ => {
            let number = |name: &str| item.non_negative(name);
            let spring = DampedSpring {
                stiffness: number("stiffness")?,
                damping: number("damping")?,
                rest_length: number("rest_length")?,
            };
            (JointKind::Spring(spring), anchors()?, DVec3::Z)
        }
    };
    let optional = |name: &str, absent: f64| if item.values.contains_key(name) { item.number(name) } else { Ok(absent) };
    let mut joint = Joint::new(kind, movers, points, axis, dimension == 2);
    joint.limits = [optional("lower", f64::NEG_INFINITY)?, optional("upper", f64::INFINITY)?];
    joint.breaking_force = optional("breaking_force", f64::INFINITY)?;
    Ok(joint)
}

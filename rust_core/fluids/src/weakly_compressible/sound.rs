//! Speed of sound that makes the flow of a scene nearly incompressible.

use glam::DVec3;
use physcore_rigid::shapes::SolidShape;

use crate::ForceLaws;
use crate::boundaries::{Gap, Path, Wall};
use crate::error::{Error, Result};
use crate::forces::fluid::{KIND, fluids};
use crate::math::AXES;
use crate::particles::start::walls;
use crate::scene::{Body, RIGID_BODIES, Scene};

/// Speed of sound in units of the fastest flow. Density then varies by about (1/10)² = 1 %.
pub const SOUND: f64 = 10.0;

/// Expected speed of a fluid that strikes a wall, in units of the speed of this impact. The jets of a block that falls onto a floor
/// are measured to be faster. Two percent of its particles exceed 2.0 to 2.5 times the impact, at any height and resolution. With
/// this value their Mach number is below 0.15.
const JETS: f64 = 1.75;

/// Velocity in the middle of a turbulent channel in units of √(τ/ρ), where τ is the stress at its walls.
///
/// Source: S. B. Pope, Turbulent Flows (2000), § 7.1.
const TURBULENT: f64 = 20.0;

/// Squared speed of sound in units of σ/ρ₀Δ. For radii R of at least three spacings, it exceeds a hundred σ/ρ₀R.
const TENSION: f64 = 40.0;

/// Speed of sound at which the fluid is practically incompressible [m/s].
pub fn enough(scene: &Scene, laws: &dyn ForceLaws, first: usize, gravity: DVec3) -> Result<f64> {
    // At a Reynolds number UL/ν below 1 the pressures are those of friction, ρνU/L: J. P. Morris et al., J. Comput. Phys. 136
    // (1997) 214.
    let rubbing = SOUND * (initial(scene)? * thinnest(scene)? / extent(scene)).sqrt();
    let sound = (SOUND * fastest(scene, laws, first, gravity)?).max(square_for_tension(scene)?.sqrt()).max(rubbing);
    if sound > 0.0 {
        return Ok(sound);
    }
    Err(Error::parameter(format!("bodies[{first}].method.sound_speed"), "a speed [m/s]", "auto").with_hint(
        "it follows from the initial velocities, from gravity and a wall below, or no-slip walls and obstacles along a periodic \
         axis, from a central force, or from surface tension; here there are none",
    ))
}

/// Smallest initial extent of the fluids [m], with half a spacing on both sides.
pub fn extent(scene: &Scene) -> f64 {
    let positions = || fluids(scene).flat_map(|(body, _)| &scene.bodies[body].positions);
    let least = positions().fold(DVec3::INFINITY, |least, x| least.min(*x));
    let most = positions().fold(DVec3::NEG_INFINITY, |most, x| most.max(*x));
    let spacing = fluids(scene).filter_map(|(_, fluid)| fluid.number("spacing").ok()).fold(f64::INFINITY, f64::min);
    (most - least).to_array()[..scene.dimension].iter().copied().fold(f64::INFINITY, f64::min).max(0.0) + spacing
}

/// Largest initial speed of fluids, and of the surfaces of rigid bodies that they meet [m/s].
fn initial(scene: &Scene) -> Result<f64> {
    let velocities = fluids(scene).flat_map(|(body, _)| &scene.bodies[body].velocities);
    let mut fastest = velocities.map(|velocity| velocity.length()).fold(0.0, f64::max);
    for body in solids(scene) {
        let (shape, _) = SolidShape::declared(body.item.record("shape")?, scene.dimension)?;
        let rates = if scene.dimension == 2 {
            body.item.numbers("angular_velocities", body.positions.len())?.iter().map(|rate| rate.abs()).collect()
        } else {
            let rates = body.item.vectors("angular_velocities", Some(body.positions.len()), AXES)?;
            rates.into_iter().map(DVec3::length).collect::<Vec<_>>()
        };
        let speeds = body.velocities.iter().zip(rates).map(|(velocity, rate)| velocity.length() + rate * shape.reach());
        fastest = speeds.fold(fastest, f64::max);
    }
    Ok(fastest)
}

/// Rigid bodies that a fluid meets.
fn solids(scene: &Scene) -> impl Iterator<Item = &Body> {
    let meets = fluids(scene).any(|(_, fluid)| fluid.flag("obstacles").unwrap_or(false));
    scene.bodies.iter().filter(move |body| meets && body.item.kind == RIGID_BODIES)
}

/// Speed [m/s] of the fastest rigid body after its fall to the surface of the fluids.
fn dropped(scene: &Scene, gravity: f64, down: DVec3) -> f64 {
    let surface =
        fluids(scene).flat_map(|(body, _)| &scene.bodies[body].positions).map(|x| x.dot(down)).fold(f64::INFINITY, f64::min);
    let speed =
        |(x, velocity): (&DVec3, &DVec3)| (velocity.length_squared() + 2.0 * gravity * (surface - x.dot(down)).max(0.0)).sqrt();
    solids(scene).flat_map(|body| body.positions.iter().zip(&body.velocities)).map(speed).fold(0.0, f64::max)
}

/// Smallest kinematic viscosity [m²/s].
fn thinnest(scene: &Scene) -> Result<f64> {
    let each = fluids(scene).map(|(_, fluid)| Ok(fluid.number("viscosity")? / fluid.number("density")?));
    each.collect::<Result<Vec<f64>>>().map(|all| all.into_iter().fold(f64::INFINITY, f64::min))
}

/// Speed [m/s] at which friction at walls or obstacles balances gravity along a periodic axis; 0 without them. In the middle of a
/// channel of width L it is gL²/8ν, or, if that is turbulent, twenty times √(gL/2).
fn driven(scene: &Scene, laws: &dyn ForceLaws, first: usize, gravity: DVec3) -> Result<f64> {
    let along = (laws.gravity(scene, first)? - gravity).length();
    let rough = walls(scene, DVec3::ZERO)?.iter().any(|side| side.no_slip);
    let stands = fluids(scene).any(|(_, fluid)| fluid.flag("obstacles").unwrap_or(false));
    let solid = stands && scene.bodies.iter().any(|body| body.item.kind != KIND);
    if along == 0.0 || !(rough || solid) {
        return Ok(0.0);
    }
    let (length, viscosity) = (extent(scene), thinnest(scene)?);
    Ok((along * length * length / (8.0 * viscosity)).min(TURBULENT * (0.5 * along * length).sqrt()))
}

/// Speed [m/s] of the fastest fall in a central force.
fn falling(scene: &Scene, laws: &dyn ForceLaws) -> Result<f64> {
    let mut fastest = 0.0_f64;
    for item in &scene.forces {
        for (body, fluid) in fluids(scene).filter(|&(body, _)| item.acts_on(body)) {
            let spacing = fluid.number("spacing")?;
            let mass = fluid.number("density")? * if scene.dimension == 2 { spacing.powi(2) } else { spacing.powi(3) };
            fastest = fastest.max(laws.fall(item, mass, &scene.bodies[body].positions)?.unwrap_or(0.0));
        }
    }
    Ok(fastest)
}

/// Estimate of the largest speed [m/s]: the maximum of several speeds. One is the initial speed. The second is that of a fall
/// to the lowest wall. The third is that of rigid bodies that fall into the fluid. The fourth is that of a fall in a central
/// force. The last is the speed at which friction balances gravity
/// along a periodic axis.
fn fastest(scene: &Scene, laws: &dyn ForceLaws, first: usize, gravity: DVec3) -> Result<f64> {
    let fall = gravity.try_normalize().map_or(Ok(0.0), |down| plunge(scene, gravity.length(), down))?;
    let drop = gravity.try_normalize().map_or(0.0, |down| dropped(scene, gravity.length(), down));
    Ok(initial(scene)?.max(fall).max(drop).max(driven(scene, laws, first, gravity)?).max(falling(scene, laws)?))
}

/// Largest speed in a fall to the lowest wall below any fluid [m/s]: of the highest particle, or of the jets of an impact.
///
/// The energy of the impact is that of the fall of the lowest particle and of the initial motion. A fluid that is thrown strikes
/// some wall, whatever its direction. The energy is zero where a fluid stands at rest on the wall, as in a dam.
fn plunge(scene: &Scene, gravity: f64, down: DVec3) -> Result<f64> {
    let sides = walls(scene, DVec3::ZERO)?;
    let bodies = || fluids(scene).map(|(body, _)| &scene.bodies[body]);
    let positions = || bodies().flat_map(|body| &body.positions);
    let depths = || positions().map(|x| x.dot(down));
    let (highest, lowest) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    let below = |x: &DVec3| sides.iter().filter_map(|side| hit(&side.wall, *x, down)).fold(f64::INFINITY, f64::min);
    let floor = positions().map(|x| x.dot(down) + below(x)).filter(|depth| depth.is_finite()).fold(highest, f64::max);
    if floor <= highest {
        return Ok(0.0);
    }
    let squares = bodies().flat_map(|body| &body.velocities).map(|velocity| velocity.length_squared());
    let impact = (squares.sum::<f64>() / positions().count() as f64 + 2.0 * gravity * (floor - lowest).max(0.0)).sqrt();
    Ok((2.0 * gravity * (floor - highest)).sqrt().max(JETS * impact))
}

/// Squared speed of sound for surface tension [m²/s²]. Capillary pressures, of order σ/Δ, then change the density by some
/// percent.
fn square_for_tension(scene: &Scene) -> Result<f64> {
    let (mut tension, mut lightest) = (0.0_f64, f64::INFINITY);
    for (_, fluid) in fluids(scene) {
        tension = tension.max(fluid.number("surface_tension")? / fluid.number("spacing")?);
        lightest = lightest.min(fluid.number("density")?);
    }
    Ok(TENSION * tension / lightest)
}

/// Distance along a ray from `x` to a wall [m].
fn hit(wall: &Wall, x: DVec3, direction: DVec3) -> Option<f64> {
    let distance = match *wall {
        Wall::Plane { normal, offset } => (offset - normal.dot(x)) / normal.dot(direction),
        Wall::Sphere { center, radius, inside } => {
            let (away, square) = ((x - center).dot(direction), (x - center).length_squared() - radius * radius);
            let root = (away * away - square).sqrt();
            if inside { root - away } else { -root - away }
        }
        Wall::Solid(_) | Wall::Terrain(_) => {
            let ray = Path { position: x, velocity: direction, acceleration: DVec3::ZERO };
            Gap::new(wall, &ray, 0.0, false).first_contact(2.0 * (x.length() + wall.extent()))?
        }
    };
    (distance > 0.0 && distance.is_finite()).then_some(distance)
}

//! Refused scenes and their error messages; particles without contacts.

use glam::{DVec2, DVec3};
use physcore_engine::contacts::Contacts;
use physcore_engine::error::Error;
use physcore_engine::matter::Columns;
use physcore_engine::scene::{Body, Item, Scene};

use super::laboratory::{Ball, Laboratory, cuboid, floor, plane, properties, scene, sphere};

fn ball(x: f64, y: f64, radius: f64) -> Ball {
    Ball::new(DVec3::new(x, y, 0.0), DVec3::ZERO, radius)
}

fn path(error: &Error) -> &str {
    match error {
        Error::Parameter { path, .. } => path,
        other => panic!("{other}"),
    }
}

fn build(balls: &[Ball], walls: Vec<Item>) -> Result<Option<Contacts<DVec2>>, Error> {
    let scene = scene(2, balls, walls);
    Contacts::build(&scene, &properties(&scene))
}

#[test]
fn no_boundaries_no_contacts() {
    assert!(build(&[ball(0.0, 0.0, 0.0)], Vec::new()).is_ok_and(|contacts| contacts.is_none()));
}

#[test]
fn parameters() {
    let cases = [
        (vec![floor(0.5, 0.0), floor(1.5, 0.0)], "boundaries[1].restitution"),
        (vec![floor(f64::NAN, 0.0)], "boundaries[0].restitution"),
        (vec![floor(0.5, -0.1)], "boundaries[0].friction"),
        (vec![plane(DVec3::ZERO, DVec3::ZERO, 0.5, 0.0)], "boundaries[0].normal"),
        (vec![cuboid(DVec3::ZERO, DVec3::new(1.0, 0.0, 0.0), 0.5, 0.0)], "boundaries[0].upper"),
        (vec![sphere(DVec3::ZERO, 0.0, true, 0.5, 0.0)], "boundaries[0].radius"),
        (vec![sphere(DVec3::ZERO, 0.05, true, 0.5, 0.0)], "boundaries[0]"),
        (vec![cuboid(DVec3::ZERO, DVec3::new(1.0, 0.1, 0.0), 0.5, 0.0)], "boundaries[0]"),
        (vec![Item { kind: "Torus".to_owned(), ..Item::default() }], "boundaries[0]"),
    ];
    for (walls, expected) in cases {
        let error = build(&[ball(0.0, 0.0, 0.1)], walls).expect_err(expected);
        assert_eq!(path(&error), expected, "{error}");
    }
}

/// A center outside is refused, and named by the caller's index; a surface that overlaps is pushed back.
#[test]
fn admission() {
    let mut scene = scene(2, &[ball(0.0, 1.0, 0.1)], vec![floor(0.5, 0.0)]);
    let second = Body {
        positions: vec![DVec3::new(0.0, 0.05, 0.0), DVec3::new(1.0, -0.25, 0.0), DVec3::new(2.0, 0.1, 0.0)],
        velocities: vec![DVec3::ZERO; 3],
        mass: vec![1.0; 3],
        charge: vec![0.0; 3],
        radius: vec![0.1; 3],
        fixed: vec![false; 3],
        ..Body::default()
    };
    scene.bodies.push(second);
    let project_inside = |scene: &Scene| {
        let properties = properties::<DVec2>(scene);
        let all: Vec<DVec3> = scene.bodies.iter().flat_map(|body| &body.positions).copied().collect();
        let mut position = Columns::from_fn(all.len(), |index| all[index].truncate());
        let contacts = Contacts::build(scene, &properties).expect("fine").expect("a floor");
        contacts.project_inside(&mut position, &properties).map(|pushed| (pushed, position))
    };
    let error = project_inside(&scene).expect_err("a center below the floor");
    assert_eq!(path(&error), "bodies[1].positions[1]");
    assert!(error.to_string().contains("boundaries[0] (plane)") && error.to_string().contains("2.500e-1 m"), "{error}");
    scene.bodies[1].positions[1].y = 0.25;
    let (pushed, position) = project_inside(&scene).expect("all inside");
    assert_eq!(pushed, 1);
    assert_eq!(position.get(1), DVec2::new(0.0, 0.1));
    // The floor does not act on other bodies.
    scene.bodies[1].positions[1].y = -0.25;
    scene.boundaries[0].on = Some(vec![0]);
    assert_eq!(project_inside(&scene).expect("not concerned").0, 0);
}

/// Fixed particles and those of other bodies pass the wall, and so do the empty lanes at the end of a block.
#[test]
fn not_concerned() {
    let mut balls = [ball(0.0, 0.5, 0.1); 3];
    for ball in &mut balls {
        ball.velocity = DVec3::new(0.0, -10.0, 0.0);
    }
    balls[1].fixed = true;
    let walls =
        vec![floor(0.5, 0.0), sphere(DVec3::new(0.0, 5.0, 0.0), 1.0, false, 0.5, 0.0), sphere(DVec3::ZERO, 1.0, true, 0.5, 0.0)];
    let mut laboratory = Laboratory::<DVec2>::new(&balls, walls, DVec3::ZERO);
    laboratory.step(0.1);
    assert_eq!(laboratory.velocity(1).y, -10.0);
    assert_eq!(laboratory.position(1).y, -0.5);
    assert_eq!(laboratory.velocity(0).y, 5.0);
    let padding = &laboratory.matter.position.axis(1)[3..];
    assert!(padding.iter().all(|&value| value == 0.0));
}

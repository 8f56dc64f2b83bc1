//! Extreme inputs: searches that cannot be exact are refused, and all others find every neighbor.

use physcore_engine::error::Error;
use physcore_engine::math::AXES;
use physcore_engine::neighbors::{Domain, Neighbors};
use physcore_engine::parallel::Executor;

use super::laboratory::{by_particle, cloud, search, view};

/// Path and hint of a refusal.
fn refusal(error: &Error) -> (&str, &str) {
    let Error::Parameter { path, hint, .. } = error else { panic!("{error}") };
    (path, hint)
}

#[test]
fn numbers_that_make_no_sense_are_refused_by_name() {
    let path = |cutoff, skin, ends| {
        let domain = Domain { period: [Some(ends), None, None] };
        Neighbors::new(10, 3, &domain, cutoff, skin).err().map(|error| refusal(&error).0.to_owned())
    };
    for cutoff in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200] {
        assert_eq!(path(cutoff, 0.0, (0.0, 1.0)).as_deref(), Some("cutoff"), "{cutoff}");
    }
    for skin in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(path(1.0, skin, (0.0, 10.0)).as_deref(), Some("skin"), "{skin}");
    }
    for ends in [(0.0, 2.199), (1.0, 0.0), (0.0, f64::NAN), (f64::NEG_INFINITY, 0.0), (1e15, 1e15 + 8.0)] {
        assert_eq!(path(1.0, 0.1, ends).as_deref(), Some("periodic"), "{ends:?}");
    }
    assert_eq!(path(1.0, 0.1, (0.0, 2.2)), None);
}

#[test]
fn a_period_is_only_looked_at_where_there_is_an_axis() {
    let domain = Domain { period: [None, None, Some((0.0, 0.1))] };
    assert!(Neighbors::new(10, 2, &domain, 1.0, 0.0).is_ok());
    assert!(Neighbors::new(10, 3, &domain, 1.0, 0.0).is_err());
}

#[test]
fn positions_are_refused_exactly_where_numbers_are_too_coarse() {
    // The spacing of f64 numbers is 1/2 just below 2^52, and 1/8 at 1e15. This is too coarse for a cutoff of 1 m, but not for
    // one of 1e7 m.
    for (far, cutoff, refused) in
        [(1e15, 1.0, true), (-1e15, 1.0, true), (1e15, 1e7, false), (4.5e8, 1.0, false), (4.6e8, 1.0, true)]
    {
        let points = [vec![far, far + 0.5 * cutoff, 0.0], vec![0.0; 3], vec![0.0; 3]];
        match search(&points, 3, &Domain::default(), cutoff, 0.0) {
            Ok(neighbors) => {
                assert!(!refused, "{far} for {cutoff}");
                assert_eq!(by_particle(&neighbors), [vec![1], vec![0], vec![]]);
            }
            Err(error) => {
                assert!(refused, "{far} for {cutoff}");
                assert_eq!(refusal(&error).0, "positions");
            }
        }
    }
}

#[test]
fn a_particle_that_is_nowhere_has_no_neighbors_and_costs_nothing() {
    let count = 100_000;
    let mut points = cloud(count, [1e3; AXES], 1);
    points[1].fill(f64::NAN);
    points[1][7] = 0.0;
    let neighbors = search(&points, 3, &Domain::default(), 1.0, 0.1).unwrap();
    assert!((0..count).all(|slot| neighbors.of(slot).is_empty()));
}

#[test]
fn all_particles_in_one_cell_are_neighbors_of_each_other() {
    for count in [0, 1, 2, 17, 1500] {
        for side in [0.0, 1e-3] {
            let points = cloud(count, [side; AXES], 3);
            let neighbors = search(&points, 3, &Domain::default(), 1.0, 0.0).unwrap();
            assert!((0..count).all(|slot| neighbors.of(slot).len() == count - 1));
        }
    }
}

#[test]
fn memory_is_bounded_by_the_particles_and_not_by_the_domain() {
    let points = cloud(10_000, [2e8; AXES], 5);
    for period in [None, Some((0.0, 2e8))] {
        let neighbors = search(&points, 3, &Domain { period: [period; AXES] }, 1.0, 0.1).unwrap();
        assert!(neighbors.bytes() < 200 * 10_000, "{} bytes", neighbors.bytes());
    }
}

#[test]
fn a_failed_update_is_made_up_for_by_the_next() {
    let mut points = cloud(100, [3.0; AXES], 5);
    let mut neighbors = search(&points, 3, &Domain::default(), 1.0, 0.1).unwrap();
    let good = by_particle(&neighbors);
    let kept = std::mem::replace(&mut points[0][3], 1e20);
    assert!(neighbors.update(view(&points), &Executor::serial()).is_err());
    points[0][3] = kept;
    assert!(neighbors.update(view(&points), &Executor::serial()).unwrap());
    assert_eq!(by_particle(&neighbors), good);
}

//! Neighbor lists: their lifetime, which depends on positions alone, and their memory, which is reused.

use physcore_engine::math::AXES;
use physcore_engine::neighbors::{Domain, Neighbors, Reflections, brute};
use physcore_engine::parallel::Executor;
use physcore_engine::simd::{Isa, Kernel, Selection, dispatch};

use super::laboratory::{by_particle, cloud, disorder, raw, search, summed_by_particle, view, with_threads};

#[test]
fn any_number_of_threads_makes_the_same_lists() {
    for (side, period) in [(20.0, None), (20.0, Some((0.0, 20.0))), (1e5, None)] {
        let points = cloud(20_000, [side; AXES], 9);
        for dimension in [2, 3] {
            let made = |threads| {
                with_threads(threads, |executor| {
                    let domain = Domain { period: [period; AXES] };
                    let mut neighbors = Neighbors::new(20_000, dimension, &domain, 1.0, 0.1).unwrap();
                    neighbors.update(view(&points), executor).unwrap();
                    raw(&neighbors)
                })
            };
            let serial = made(1);
            assert!((2..=4).all(|threads| made(threads) == serial));
        }
    }
}

#[test]
fn lists_hold_every_pair_within_the_cutoff_for_as_long_as_they_live() {
    let (cutoff, skin) = (1.0, 0.3);
    let domain = Domain { period: [Some((0.0, 7.0)), None, None] };
    let mut points = cloud(300, [7.0; AXES], 11);
    let mut neighbors = search(&points, 3, &domain, cutoff, skin).unwrap();
    let mut number = disorder(12);
    let (mut made, mut kept, mut shortened) = (0, 0, 0);
    for _ in 0..200 {
        points.iter_mut().flatten().for_each(|coordinate| *coordinate += 0.05 * (number() - 0.5));
        // Shear flow, in which particles move much farther than relative to each other.
        let [x, y, _] = &mut points;
        x.iter_mut().zip(y).for_each(|(x, y)| *x += 0.2 + 0.05 * (*y - 3.5));
        if neighbors.update(view(&points), &Executor::serial()).unwrap() {
            made += 1;
        } else {
            kept += 1;
        }
        let (lists, summed) = (by_particle(&neighbors), summed_by_particle(&neighbors));
        for ((list, summed), near) in lists.iter().zip(&summed).zip(brute(300, 3, &domain, cutoff, view(&points))) {
            assert!(near.iter().all(|other| list.binary_search(other).is_ok() && summed.binary_search(other).is_ok()));
            shortened += usize::from(summed.len() < list.len());
        }
    }
    assert!(made > 20 && kept > 20, "made {made} times, kept {kept} times");
    assert!(shortened > 10_000, "{shortened} of {} lists were shortened for sums", 200 * 300);
}

struct Appending;

impl Kernel for Appending {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Vec<u32> {
        let (mut all, mut some) = (Selection::new(1000), Selection::new(1000));
        // The memory of these entries ends less than a group behind the last one.
        for (first, mask) in [(0, 0x3fff), (16, u16::MAX), (32, u16::MAX), (48, u16::MAX), (64, 7)] {
            some.add(isa, first, mask);
        }
        all.add(isa, 500, 1);
        all.append(&some);
        all.list(0, all.len()).to_vec()
    }
}

#[test]
fn a_selection_is_appended_whole() {
    let expected: Vec<u32> = [500].into_iter().chain(0..14).chain(16..67).collect();
    assert_eq!(dispatch(Appending), expected);
}

/// Lists of any length are complete, whatever room the lists before them left.
#[test]
fn lists_hold_near_and_far_neighbors() {
    for (seed, count) in [(31, 40), (32, 300), (33, 700), (34, 1500)] {
        for dimension in [2, 3] {
            let points = cloud(count, [4.0; AXES], seed);
            let neighbors = search(&points, dimension, &Domain::default(), 1.0, 0.8).unwrap();
            assert_eq!(by_particle(&neighbors), brute(count, dimension, &Domain::default(), 1.8, view(&points)));
        }
    }
}

#[test]
fn lists_are_made_when_neighbors_have_moved_relative_to_each_other_by_more_than_the_skin() {
    let mut points = cloud(5000, [20.0; AXES], 2);
    let mut neighbors = search(&points, 3, &Domain::default(), 1.0, 0.25).unwrap();
    let start = points[1][4000];
    for (moved, made) in [(0.249, false), (0.251, true), (0.251, false), (f64::NAN, true)] {
        points[1][4000] = start + moved;
        assert_eq!(neighbors.update(view(&points), &Executor::serial()).unwrap(), made, "{moved}");
    }
    let mut always = search(&points, 3, &Domain::default(), 1.0, 0.0).unwrap();
    assert!(always.update(view(&points), &Executor::serial()).unwrap());
}

#[test]
fn lists_serve_longer_for_particles_that_move_together() {
    let still = cloud(5000, [20.0; AXES], 2);
    let moved = |by: [f64; AXES]| {
        let mut points = still.clone();
        points.iter_mut().zip(by).for_each(|(axis, by)| axis.iter_mut().for_each(|coordinate| *coordinate += by));
        points
    };
    for (reflections, by, made) in [
        (Reflections::default(), [0.2, 0.2, 0.2], false),
        (Reflections { axes: [true, false, false], any: false }, [0.12, 0.2, 0.2], false),
        (Reflections { axes: [true, false, false], any: false }, [0.13, 0.0, 0.0], true),
        (Reflections { axes: [false; AXES], any: true }, [0.0, 0.13, 0.0], true),
    ] {
        let mut neighbors = search(&still, 3, &Domain::default(), 1.0, 0.25).unwrap();
        neighbors.reflect(&|_| reflections, &Executor::serial());
        assert_eq!(neighbors.update(view(&moved(by)), &Executor::serial()).unwrap(), made, "{reflections:?} {by:?}");
    }
}

/// Searches for walls and for points beside the particles reach up to the largest displacement.
#[test]
fn no_lists_outlive_the_largest_displacement() {
    let still = cloud(5000, [20.0; AXES], 2);
    let mut neighbors = search(&still, 3, &Domain::default(), 1.0, 0.25).unwrap();
    let largest = neighbors.largest_displacement();
    for (displacement, made) in [(0.999 * largest, false), (1.001 * largest, true)] {
        let mut points = still.clone();
        points[2].iter_mut().for_each(|coordinate| *coordinate -= displacement);
        assert_eq!(neighbors.update(view(&points), &Executor::serial()).unwrap(), made, "{displacement}");
    }
}

#[test]
fn lists_come_back_from_their_anchors() {
    let points = cloud(3000, [8.0; AXES], 4);
    let made = search(&points, 3, &Domain::default(), 1.0, 0.2).unwrap();
    let moved = points.clone().map(|axis| axis.into_iter().map(|coordinate| coordinate * 1.5).collect());
    let mut other = search(&moved, 3, &Domain::default(), 1.0, 0.2).unwrap();
    assert_ne!(raw(&other), raw(&made));
    let anchors = |neighbors: &Neighbors| [0, 1, 2].map(|axis| neighbors.anchors(axis).collect::<Vec<_>>());
    other.restore(view(&anchors(&made)), &Executor::serial()).unwrap();
    assert_eq!(raw(&other), raw(&made));
    assert_eq!(anchors(&other), anchors(&made));
    assert!(!other.update(view(&points), &Executor::serial()).unwrap());
}

#[test]
fn lists_no_longer_than_those_before_allocate_nothing() {
    let states: Vec<_> = (0..6).map(|seed| cloud(4000, [10.0; AXES], seed)).collect();
    let mut neighbors = search(&states[0], 3, &Domain::default(), 1.0, 0.0).unwrap();
    let update = |neighbors: &mut Neighbors| {
        for state in &states {
            neighbors.update(view(state), &Executor::serial()).unwrap();
        }
    };
    update(&mut neighbors);
    let bytes = neighbors.bytes();
    let allocated = allocation_counter::measure(|| update(&mut neighbors));
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
    assert_eq!(neighbors.bytes(), bytes);
}

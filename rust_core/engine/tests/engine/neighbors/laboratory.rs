//! Shared code of the tests: random particles, lists in a comparable form, and thread pools of any size.

use physcore_engine::error::Result;
use physcore_engine::math::AXES;
use physcore_engine::neighbors::{Domain, List, Neighbors};
use physcore_engine::parallel::{Executor, ThreadPool};

/// Positions, one array per axis.
pub type Points = [Vec<f64>; AXES];

/// Slices of all axes.
pub fn view(points: &Points) -> [&[f64]; AXES] {
    points.each_ref().map(Vec::as_slice)
}

/// Generator of pseudorandom numbers from 0 to 1, with a fixed seed.
pub fn disorder(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 9_007_199_254_740_992.0
    }
}

/// `count` points in a box with the given sides.
pub fn cloud(count: usize, sides: [f64; AXES], seed: u64) -> Points {
    let mut number = disorder(seed);
    sides.map(|side| (0..count).map(|_| side * number()).collect())
}

/// Runs `job` with some number of threads.
pub fn with_threads<R: Send>(threads: usize, job: impl FnOnce(&Executor) -> R + Send) -> R {
    let mut result = None;
    ThreadPool::new(threads).run(&|| false, |executor| result = Some(job(executor))).expect("nobody interrupts");
    result.expect("the job has run")
}

/// Search that has been updated once.
pub fn search(points: &Points, dimension: usize, domain: &Domain, cutoff: f64, skin: f64) -> Result<Neighbors> {
    let mut neighbors = Neighbors::new(points[0].len(), dimension, domain, cutoff, skin)?;
    neighbors.update(view(points), &Executor::serial())?;
    Ok(neighbors)
}

/// Lists in the order of the particles, as sorted particles.
pub fn by_particle(neighbors: &Neighbors) -> Vec<Vec<u32>> {
    particles(neighbors, |slot| neighbors.of(slot))
}

/// Neighbors that pair sums use at present, in the order of the particles, as sorted particles.
pub fn summed_by_particle(neighbors: &Neighbors) -> Vec<Vec<u32>> {
    particles(neighbors, |slot| {
        let List { segment, range } = neighbors.list(slot);
        segment.list(range.start, range.end)
    })
}

fn particles<'a>(neighbors: &'a Neighbors, list: impl Fn(usize) -> &'a [u32]) -> Vec<Vec<u32>> {
    let sorted = |&slot: &u32| {
        let mut list: Vec<u32> = list(slot as usize).iter().map(|&other| neighbors.order()[other as usize]).collect();
        list.sort_unstable();
        list
    };
    neighbors.slots().iter().map(sorted).collect()
}

/// Order of the slots, and unsorted lists.
pub fn raw(neighbors: &Neighbors) -> (Vec<u32>, Vec<Vec<u32>>) {
    (neighbors.order().to_vec(), (0..neighbors.count()).map(|slot| neighbors.of(slot).to_vec()).collect())
}

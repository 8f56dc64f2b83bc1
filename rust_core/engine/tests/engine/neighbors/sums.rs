//! Sums over neighbors: correct to the rounding of their precision, and always with the same bits.

use std::process::Command;

use glam::{DVec2, DVec3, Vec2, Vec3};
use physcore_engine::math::{AXES, Real, Vector};
use physcore_engine::neighbors::sums::{Pair, PairLaw, Records};
use physcore_engine::neighbors::{Domain, Neighbors, brute};
use physcore_engine::parallel::Executor;
use physcore_engine::simd::{Level, Number};

use super::laboratory::{Points, cloud, view, with_threads};

/// Smooth repulsion weighted with the last number of the record, and the weight itself.
#[derive(Clone, Copy)]
struct Weighted<T> {
    cutoff: T,
}

impl<T: Real, V: Vector<Scalar = T>> PairLaw<V, 4> for Weighted<T> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> [N; 4] {
        let (cutoff, zero) = (N::of(self.cutoff), N::constant(0.0));
        let left = (N::constant(1.0) - pair.square / (cutoff * cutoff)).max(zero);
        let strength = left * left * pair.other[7];
        let [x, y, z] = pair.separation;
        [strength * x, strength * y, if V::DIMENSION == 3 { strength * z } else { zero }, strength]
    }
}

/// Sums of the law in the order of the particles, for weights 1, 2, 3, ….
fn sums<V: Vector>(points: &Points, domain: &Domain, threads: usize) -> Vec<[V::Scalar; 4]> {
    let count = points[0].len();
    with_threads(threads, |executor| {
        let mut neighbors = Neighbors::new(count, V::DIMENSION, domain, 1.0, 0.2).unwrap();
        neighbors.update(view(points), executor).unwrap();
        let mut records = Records::<V>::new(&neighbors);
        records.fill(&neighbors, view(points), executor, &|particle, record| {
            record[7] = V::Scalar::from_f64((particle + 1) as f64);
        });
        let mut sums = vec![[V::Scalar::ZERO; 4]; count];
        records.sum(&neighbors, Weighted { cutoff: V::Scalar::ONE }, &mut sums, executor);
        neighbors.slots().iter().map(|&slot| sums[slot as usize]).collect()
    })
}

/// Sums over all pairs, in f64, and sums of the magnitudes of all terms.
fn reference(points: &Points, dimension: usize, domain: &Domain) -> Vec<([f64; 4], f64)> {
    let lengths = domain.lengths();
    let lists = brute(points[0].len(), dimension, domain, 1.0, view(points));
    let sum = |(particle, list): (usize, Vec<u32>)| {
        let (mut sums, mut magnitude) = ([0.0; 4], 0.0);
        for other in list {
            let mut separation = [0.0; AXES];
            for axis in 0..dimension {
                let difference = points[axis][particle] - points[axis][other as usize];
                separation[axis] = difference - lengths[axis].map_or(0.0, |length| length * (difference / length).round());
            }
            let square: f64 = separation.iter().map(|component| component * component).sum();
            let strength = (1.0 - square).powi(2) * f64::from(other + 1);
            (0..AXES).for_each(|axis| sums[axis] += strength * separation[axis]);
            sums[3] += strength;
            magnitude += f64::from(other + 1);
        }
        (sums, magnitude)
    };
    lists.into_iter().enumerate().map(sum).collect()
}

fn check<V: Vector>(side: f64, offset: f64, period: [Option<(f64, f64)>; AXES]) {
    let points = cloud(2500, [side; AXES], 21).map(|axis| axis.into_iter().map(|slot| slot + offset).collect());
    let domain = Domain { period };
    // Every term consists of some ten roundings of a distance of at most 1 and a weight. The caller also rounds each
    // coordinate; it computes in f64.
    let tolerance = 20.0 * V::Scalar::EPSILON * (1.0 + if V::Scalar::EPSILON < 1e-10 { offset + side } else { 0.0 });
    for (particle, (sums, (expected, magnitude))) in
        sums::<V>(&points, &domain, 1).into_iter().zip(reference(&points, V::DIMENSION, &domain)).enumerate()
    {
        for sum in 0..4 {
            let error = (sums[sum].to_f64() - expected[sum]).abs();
            assert!(error <= tolerance * magnitude, "{particle}: {sums:?} for {expected:?}");
        }
    }
}

#[test]
fn sums_are_those_of_all_pairs() {
    for (side, offset) in [(5.0, 0.0), (20.0, 1e5)] {
        let ends = Some((offset, offset + side));
        for period in [[None; AXES], [ends, None, None], [ends; AXES]] {
            check::<Vec2>(side, offset, period);
            check::<Vec3>(side, offset, period);
            check::<DVec2>(side, offset, period);
            check::<DVec3>(side, offset, period);
        }
    }
}

/// Fingerprint of sums in both precisions and dimensions.
fn fingerprint(threads: usize) -> u64 {
    let points = cloud(5000, [9.0; AXES], 33);
    let domain = Domain { period: [None, Some((0.0, 9.0)), None] };
    let mut state = 0xcbf2_9ce4_8422_2325_u64;
    let mut mix = |bits: u64| state = (state ^ bits).wrapping_mul(0x0100_0000_01b3).rotate_left(17);
    sums::<Vec2>(&points, &domain, threads).iter().flatten().for_each(|sum| mix(u64::from(sum.to_bits())));
    sums::<Vec3>(&points, &domain, threads).iter().flatten().for_each(|sum| mix(u64::from(sum.to_bits())));
    sums::<DVec2>(&points, &domain, threads).iter().flatten().for_each(|sum| mix(sum.to_bits()));
    sums::<DVec3>(&points, &domain, threads).iter().flatten().for_each(|sum| mix(sum.to_bits()));
    state
}

#[test]
fn sums_have_the_same_bits_for_any_number_of_threads() {
    let serial = fingerprint(1);
    assert!((2..=4).all(|threads| fingerprint(threads) == serial));
}

/// Runs other SIMD levels in separate processes: a process has only one level.
#[test]
fn sums_have_the_same_bits_at_every_level() {
    let mine = format!("fingerprint {:016x} at", fingerprint(1));
    println!("{mine} {}", Level::current().name());
    if std::env::var_os("PHYSCORE_SIMD").is_some() {
        return;
    }
    for level in Level::ALL.map(Level::name) {
        let test = "neighbors::sums::sums_have_the_same_bits_at_every_level";
        let mut command = Command::new(std::env::current_exe().unwrap());
        let output = command.args([test, "--exact", "--nocapture"]).env("PHYSCORE_SIMD", level).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && text.contains(&mine), "{level}: {text}, here {mine}");
    }
}

#[test]
fn later_sums_allocate_nothing() {
    let points = cloud(3000, [8.0; AXES], 2);
    let mut neighbors = Neighbors::new(3000, 3, &Domain::default(), 1.0, 0.1).unwrap();
    neighbors.update(view(&points), &Executor::serial()).unwrap();
    let mut records = Records::<Vec3>::new(&neighbors);
    let mut sums = vec![[0.0; 4]; 3000];
    let allocated = allocation_counter::measure(|| {
        records.fill(&neighbors, view(&points), &Executor::serial(), &|_, record| record[7] = 1.0);
        records.sum(&neighbors, Weighted { cutoff: 1.0 }, &mut sums, &Executor::serial());
    });
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
}

/// Far neighbors are beyond the cutoff, where terms are 0. The displacement of one particle exceeds the range of near
/// neighbors. Sums around it therefore use whole lists; sums of particles that it does not reach keep their bits.
#[test]
fn sums_over_near_neighbors_have_the_bits_of_those_over_all() {
    let mut points = cloud(2500, [5.0; AXES], 22);
    let (cutoff, skin) = (1.0, 0.3);
    let sums = |points: &Points, anchors: &Points| {
        let mut neighbors = Neighbors::new(points[0].len(), 3, &Domain::default(), cutoff, skin).unwrap();
        neighbors.update(view(anchors), &Executor::serial()).unwrap();
        assert!(!neighbors.update(view(points), &Executor::serial()).unwrap());
        let mut records = Records::<Vec3>::new(&neighbors);
        records.fill(&neighbors, view(points), &Executor::serial(), &|particle, record| record[7] = (particle + 1) as f32);
        let mut sums = vec![[0.0; 4]; points[0].len()];
        records.sum(&neighbors, Weighted { cutoff: 1.0 }, &mut sums, &Executor::serial());
        let lengths: usize = (0..points[0].len()).map(|slot| neighbors.list(slot).range.len()).sum();
        (lengths, neighbors.slots().iter().map(|&slot| sums[slot as usize]).collect::<Vec<[f32; 4]>>())
    };
    let anchors = points.clone();
    points.iter_mut().flatten().for_each(|coordinate| *coordinate *= 1.001);
    let (near, short) = sums(&points, &anchors);
    points[0][0] += 0.2;
    let (all, long) = sums(&points, &anchors);
    assert!(near < all);
    let moved = DVec3::new(points[0][0], points[1][0], points[2][0]);
    let far = |particle: usize| {
        let other = DVec3::new(points[0][particle], points[1][particle], points[2][particle]);
        (other - moved).length() > cutoff + 0.3
    };
    let untouched: Vec<usize> = (1..points[0].len()).filter(|&particle| far(particle)).collect();
    assert!(untouched.len() > 2000);
    assert!(untouched.iter().all(|&particle| short[particle] == long[particle]));
}

//! Benchmark of the neighbor search and of sums over neighbors, per particle, for a fluid at rest: a disordered lattice.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3, Vec2, Vec3};
use physcore_engine::math::{AXES, Real, Vector};
use physcore_engine::neighbors::sums::{Pair, PairLaw, Records};
use physcore_engine::neighbors::{Domain, Neighbors};
use physcore_engine::parallel::Executor;
use physcore_engine::simd::Number;

/// Smoothing length, in lattice spacings; the support is twice as long.
const SMOOTHING: f64 = 1.2;

/// Excess of the list radius over the support, in lattice spacings.
const SKIN: f64 = 0.2;

/// Gradient of Wendland's C2 kernel, ∇W = −k d (1 − q/2)³ with q = r/h, without the factor k (H. Wendland, Adv. Comput. Math. 4
/// (1995) 389), and the parameters of the laws.
#[derive(Clone, Copy)]
struct Fluid<T> {
    half_inverse: T,
    viscosity: T,
    softening: T,
}

impl<T: Real> Fluid<T> {
    fn new() -> Self {
        Self {
            half_inverse: T::from_f64(0.5 / SMOOTHING),
            viscosity: T::from_f64(0.2),
            softening: T::from_f64(0.01 * SMOOTHING * SMOOTHING),
        }
    }

    #[inline(always)]
    fn slope<N: Number<Scalar = T>>(&self, distance: N) -> N {
        let left = (N::constant(1.0) - distance * N::of(self.half_inverse)).max(N::constant(0.0));
        left * left * left
    }
}

/// Approach rate (vᵢ − vⱼ) · d.
#[inline(always)]
fn approach<V: Vector, N: Number>(pair: &Pair<N>) -> N {
    let mut sum = N::constant(0.0);
    for axis in 0..V::DIMENSION {
        sum += (pair.own[V::DIMENSION + axis] - pair.other[V::DIMENSION + axis]) * pair.separation[axis];
    }
    sum
}

/// Rate of density: Σ (vᵢ − vⱼ) · ∇W.
#[derive(Clone, Copy)]
struct ContinuitySum<T>(Fluid<T>);

impl<V: Vector> PairLaw<V, 1> for ContinuitySum<V::Scalar> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 1] {
        [approach::<V, N>(pair) * self.0.slope(pair.distance)]
    }
}

/// Acceleration by pressure and artificial viscosity, with one division (J. J. Monaghan, Annu. Rev. Astron. Astrophys. 30 (1992)
/// 543). The last two words are the density, and the pressure over the squared density.
#[derive(Clone, Copy)]
struct MomentumSum<T>(Fluid<T>);

impl<V: Vector> PairLaw<V, 3> for MomentumSum<V::Scalar> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 3] {
        let Pair { own, other, separation, square, distance } = pair;
        let approach = approach::<V, N>(pair).min(N::constant(0.0));
        let viscosity = N::of(self.0.viscosity) * approach / ((*square + N::of(self.0.softening)) * (own[6] + other[6]));
        let strength = (own[7] + other[7] - viscosity) * self.0.slope(*distance);
        [
            strength * separation[0],
            strength * separation[1],
            if V::DIMENSION == 3 { strength * separation[2] } else { N::constant(0.0) },
        ]
    }
}

fn bench<V: Vector>(criterion: &mut Criterion, side: usize) {
    let count = side.pow(V::DIMENSION as u32);
    let mut state = 1_u64;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 9_007_199_254_740_992.0
    };
    let positions: [Vec<f64>; AXES] = std::array::from_fn(|axis| {
        let coordinate = |particle: usize| (particle / side.pow(axis as u32) % side) as f64 + 0.2 * (number() - 0.5);
        (0..count).map(coordinate).collect()
    });
    let positions = positions.each_ref().map(Vec::as_slice);
    let velocity: Vec<V::Scalar> = (0..count).map(|_| V::Scalar::from_f64(number() - 0.5)).collect();
    let executor = Executor::serial();
    let domain = Domain::default();
    let mut neighbors = Neighbors::new(count, V::DIMENSION, &domain, 2.0 * SMOOTHING, SKIN).expect("a sensible search");
    neighbors.update(positions, &executor).expect("positions near 0");
    let mut records = Records::<V>::new(&neighbors);
    let fill = |records: &mut Records<V>, neighbors: &Neighbors| {
        records.fill(neighbors, positions, &executor, &|particle, record| {
            (0..V::DIMENSION).for_each(|axis| record[V::DIMENSION + axis] = velocity[particle]);
            record[6] = V::Scalar::ONE;
            record[7] = velocity[particle];
        });
    };
    fill(&mut records, &neighbors);
    let mut rates = vec![[V::Scalar::ZERO; 1]; count];
    let mut accelerations = vec![[V::Scalar::ZERO; 3]; count];

    let mut group = criterion.benchmark_group(format!("{}D {}", V::DIMENSION, V::Scalar::NAME));
    group.throughput(Throughput::Elements(count as u64));
    group.bench_function("continuity", |bencher| {
        bencher.iter(|| records.sum(&neighbors, ContinuitySum(Fluid::new()), &mut rates, &executor));
    });
    group.bench_function("momentum", |bencher| {
        bencher.iter(|| records.sum(&neighbors, MomentumSum(Fluid::new()), &mut accelerations, &executor));
    });
    group.bench_function("fill", |bencher| bencher.iter(|| fill(&mut records, &neighbors)));
    group.bench_function("check", |bencher| bencher.iter(|| neighbors.update(positions, &executor).expect("positions near 0")));
    // Without a skin, every update rebuilds the lists, which are as long as those with a skin.
    let mut always = Neighbors::new(count, V::DIMENSION, &domain, 2.0 * SMOOTHING + SKIN, 0.0).expect("a sensible search");
    group.bench_function("build", |bencher| bencher.iter(|| always.update(positions, &executor).expect("positions near 0")));
    group.finish();
}

fn neighbors(criterion: &mut Criterion) {
    bench::<Vec3>(criterion, 46);
    bench::<DVec3>(criterion, 46);
    bench::<Vec2>(criterion, 316);
    bench::<DVec2>(criterion, 316);
}

criterion_group!(benches, neighbors);
criterion_main!(benches);

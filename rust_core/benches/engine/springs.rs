//! Benchmark of the spring forces of a cloth, per spring: as stencils, and in arbitrary order as slices.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3, Vec2, Vec3};
use physcore_benches::CATALOG;
use physcore_engine::catalog::Space;
use physcore_engine::forces::springs::Spring;
use physcore_engine::forces::{Rates, StateView};
use physcore_engine::math::Real;
use physcore_engine::matter::{Columns, Properties, SINKS, View};
use physcore_engine::parallel::SERIAL;
use physcore_engine::simd::{LANES, padded};

/// Number of particles in a block.
const BLOCK: usize = 4096;

/// Structural, shear and bend springs of a cloth.
fn cloth(columns: usize, rows: usize) -> Vec<Spring> {
    let mut springs = Vec::new();
    for (right, up) in [(1_isize, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2)] {
        let rest_length = f64::hypot(right as f64, up as f64);
        for row in 0..rows - up {
            for column in 0..columns {
                if let Some(other) = column.checked_add_signed(right).filter(|&other| other < columns) {
                    let ends = [(row * columns + column) as u32, ((row + up) * columns + other) as u32];
                    springs.push(Spring { ends, stiffness: 100.0, damping: 0.1, rest_length });
                }
            }
        }
    }
    springs
}

/// Numbers below `count` in a fixed pseudorandom order.
fn shuffled(count: usize) -> Vec<u32> {
    let mut numbers: Vec<u32> = (0..count as u32).collect();
    let mut state = 1_u64;
    for index in (1..count).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        numbers.swap(index, (state >> 33) as usize % (index + 1));
    }
    numbers
}

fn bench<V: Space>(criterion: &mut Criterion, columns: usize, rows: usize, shuffle: bool) {
    let count = columns * rows;
    let mut springs = cloth(columns, rows);
    let mut engine_index: Vec<u32> = (0..count as u32).collect();
    if shuffle {
        engine_index = shuffled(count);
        springs.iter_mut().for_each(|spring| spring.ends = spring.ends.map(|end| engine_index[end as usize]));
        let order = CATALOG.forces.order(&springs, count).expect("a shuffled cloth can be ordered");
        let mut new = vec![0; count];
        order.iter().enumerate().for_each(|(index, &old)| new[old as usize] = index as u32);
        springs.iter_mut().for_each(|spring| spring.ends = spring.ends.map(|end| new[end as usize]));
        engine_index.iter_mut().for_each(|index| *index = new[*index as usize]);
    }
    let mut position = Columns::<V>::zeros(count);
    let mut velocity = Columns::<V>::zeros(count);
    for (index, &engine_index) in engine_index.iter().enumerate() {
        let (column, row) = ((index % columns) as f64, (index / columns) as f64);
        position.set(engine_index as usize, V::narrow(DVec3::new(1.01 * column, 0.99 * row, 0.1 * (column * row).sin())));
        velocity.set(engine_index as usize, V::narrow(DVec3::new(row.sin(), column.sin(), 0.0)));
    }
    let properties = Properties::<V> { caller: engine_index, ..Properties::new(vec![1.0; count]) };
    let at = StateView {
        position: position.view(),
        velocity: velocity.view(),
        residual: View::default(),
        properties: &properties,
        solids: &[],
        time: 0.0,
        executor: &SERIAL,
    };
    let force = V::forces(CATALOG).springs(&springs, count);
    let mut sum = Columns::<V>::zeros(count);
    let mut power = [[0.0; LANES]; SINKS];
    let mut group = criterion.benchmark_group(format!("{columns}x{rows}"));
    group.throughput(Throughput::Elements(springs.len() as u64));
    let name = format!("{} {}D {}", force.about().layout, V::DIMENSION, V::Scalar::NAME);
    group.bench_function(format!("force, {name}"), |bencher| {
        bencher.iter(|| {
            let mut rest = sum.span();
            for start in (0..padded(count)).step_by(BLOCK) {
                let end = (start + BLOCK).min(padded(count));
                let (block, others) = rest.split_at(end - start);
                force.accumulate(start..end, &at, &mut Rates::new(block, &mut power));
                rest = others;
            }
        });
    });
    group.bench_function(format!("energy, {name}"), |bencher| bencher.iter(|| black_box(force.potential(0..padded(count), &at))));
    group.finish();
}

fn springs(criterion: &mut Criterion) {
    for (columns, rows) in [(15, 10), (316, 316)] {
        for shuffle in [false, true] {
            bench::<Vec2>(criterion, columns, rows, shuffle);
            bench::<DVec2>(criterion, columns, rows, shuffle);
            bench::<Vec3>(criterion, columns, rows, shuffle);
            bench::<DVec3>(criterion, columns, rows, shuffle);
        }
    }
}

criterion_group!(benches, springs);
criterion_main!(benches);

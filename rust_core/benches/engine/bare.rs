//! Benchmark of the cost of generality: `cargo bench --bench bare`. Scenes run by the engine are compared with hand-written
//! loops. Such a loop keeps no energy budget, has no monitor, and supports a single integrator and force.
//!
//! The upper bound of the cost of safety is measured too: equal steps are requested at once, and in halves. A half is a batch of
//! its own. The difference is the work done once per batch, reported as a share of a whole batch:
//!
//! - the divergence monitor;
//! - saving the state for rollback;
//! - moving the state through the caches;
//! - handing work to a thread.
//!
//! Both take turns in one process on one thread at the same SIMD level, because the speed of a machine drifts. The clock is CPU
//! time, which excludes other programs.

use std::collections::BTreeMap;

use std::cell::RefCell;

use glam::DVec3;
use physcore_benches::CATALOG;
use physcore_engine::forces::springs::Spring;
use physcore_engine::math::Real;
use physcore_engine::parallel::SERIAL;
use physcore_engine::scene::{Body, Item, PARTICLES, Scene, Value};
use physcore_engine::simd::{Isa, Kernel, LANES, Lanes, Level, dispatch};
use physcore_engine::simulation::{Numerics, Simulation, Vigilance};

/// Time step [s].
const STEP: f64 = 1e-4;
/// Gravity [m/s²].
const GRAVITY: f64 = -9.81;
/// Drag coefficient of a particle of 1 kg [N·s/m].
const DRAG: f64 = 0.1;
/// Cloth: spacing [m], stiffness [N/m], damping [N·s/m] and mass per particle [kg].
const CLOTH: [f64; 4] = [0.01, 100.0, 0.01, 1e-3];
/// Springs of a cloth: structural, shear and bend, as steps in column and row.
const OFFSETS: [[isize; 2]; 6] = [[1, 0], [0, 1], [1, 1], [-1, 1], [2, 0], [0, 2]];
/// Rest length of a kind of spring [m].
fn rest_length([across, up]: [isize; 2]) -> f64 {
    CLOTH[0] * ((across * across + up * up) as f64).sqrt()
}

/// Number of particles in a block of the hand-written cloth.
const BLOCK: usize = 1024;
/// Number of turns of each candidate; the median counts.
const DRIFT_KICK: usize = 15;

/// Group of lanes aligned to a cache line: a vector that straddles two lines costs twice as much.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct LaneGroup<T>(Lanes<T>);

/// Axis of a block: x, v and the acceleration a.
struct BlockAxis<T> {
    x: Vec<LaneGroup<T>>,
    v: Vec<LaneGroup<T>>,
    a: Vec<LaneGroup<T>>,
    gravity: T,
}

/// Velocity Verlet under gravity and linear drag: steps of one block that stays in the cache, two per pass.
struct Fall<'a, T> {
    axes: &'a mut [BlockAxis<T>; 3],
    steps: u64,
}

impl<T: Real> Kernel for Fall<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let (h, half, b) = (T::from_f64(STEP), T::from_f64(0.5 * STEP), T::from_f64(-DRAG));
        for _ in 0..self.steps / 2 {
            for BlockAxis { x, v, a, gravity } in self.axes.iter_mut() {
                for ((x, v), a) in x.iter_mut().zip(v).zip(a) {
                    let (mut x1, mut v1, mut a1) = (x.0, v.0, a.0);
                    for lane in 0..LANES {
                        for _ in 0..2 {
                            let kick = half * a1[lane];
                            let middle = v1[lane] + kick;
                            x1[lane] += h * middle;
                            a1[lane] = *gravity + b * (middle + kick);
                            v1[lane] = middle + half * a1[lane];
                        }
                    }
                    (x.0, v.0, a.0) = (x1, v1, a1);
                }
            }
        }
    }
}

/// Velocity Verlet of a cloth in two dimensions. Columns by axis are positions x, velocities v, predicted velocities p and forces
/// f. A mask per kind of spring says which particles have one, 1 or 0. The forces of one block are separate.
struct Sheet<'a, T> {
    columns: isize,
    x: &'a mut [Vec<T>; 2],
    v: &'a mut [Vec<T>; 2],
    p: &'a mut [Vec<T>; 2],
    f: &'a mut [Vec<T>; 2],
    present: &'a [Vec<T>; 6],
    scratch: &'a mut [Vec<T>; 2],
    steps: u64,
}

impl<T: Real> Kernel for Sheet<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(mut self, _isa: S) {
        let [half, w] = [0.5 * STEP, 1.0 / CLOTH[3]].map(T::from_f64);
        let gravity = [0.0, GRAVITY].map(T::from_f64);
        for _ in 0..self.steps {
            for axis in 0..2 {
                let (x, v, p, f) = (&mut self.x[axis], &mut self.v[axis], &mut self.p[axis], &mut self.f[axis]);
                for (((x, v), p), f) in x.iter_mut().zip(v).zip(p).zip(f) {
                    let kick = half * (gravity[axis] + w * *f);
                    *v += kick;
                    *x += T::from_f64(STEP) * *v;
                    *p = *v + kick;
                    *f = T::ZERO;
                }
            }
            self.pull();
            for axis in 0..2 {
                for (v, f) in self.v[axis].iter_mut().zip(&self.f[axis]) {
                    *v += half * (gravity[axis] + w * *f);
                }
            }
        }
    }
}

impl<T: Real> Sheet<'_, T> {
    /// Computes the force of every spring once, adds it at one end and subtracts it at the other.
    #[inline(always)]
    fn pull(&mut self) {
        let (k, c) = (T::from_f64(CLOTH[1]), T::from_f64(CLOTH[2]));
        for ([across, up], present) in OFFSETS.into_iter().zip(self.present) {
            let rest = T::from_f64(rest_length([across, up]));
            let distance = (across + up * self.columns) as usize;
            let last = self.x[0].len() - distance;
            for start in (0..last).step_by(BLOCK) {
                let n = BLOCK.min(last - start);
                let (here, there) = (start..start + n, start + distance..start + distance + n);
                let [fx, fy] = &mut *self.scratch;
                let (fx, fy, present) = (&mut fx[..n], &mut fy[..n], &present[here.clone()]);
                let (x0, x1, y0, y1) =
                    (&self.x[0][here.clone()], &self.x[0][there.clone()], &self.x[1][here.clone()], &self.x[1][there.clone()]);
                let (p0, p1, q0, q1) =
                    (&self.p[0][here.clone()], &self.p[0][there.clone()], &self.p[1][here.clone()], &self.p[1][there.clone()]);
                for i in 0..n {
                    let (dx, dy) = (x1[i] - x0[i], y1[i] - y0[i]);
                    let length = (dx * dx + dy * dy).sqrt();
                    let inverse = T::ONE / length;
                    let rate = ((p1[i] - p0[i]) * dx + (q1[i] - q0[i]) * dy) * inverse;
                    let pull = present[i] * (k * (length - rest) + c * rate) * inverse;
                    (fx[i], fy[i]) = (pull * dx, pull * dy);
                }
                for (total, part) in self.f.iter_mut().zip([&*fx, &*fy]) {
                    for (total, part) in total[here.clone()].iter_mut().zip(part) {
                        *total += *part;
                    }
                    for (total, part) in total[there.clone()].iter_mut().zip(part) {
                        *total -= *part;
                    }
                }
            }
        }
    }
}

fn body(positions: Vec<DVec3>, velocities: Vec<DVec3>, mass: f64, item: Item) -> Body {
    let count = positions.len();
    let (charge, radius, fixed) = (vec![0.0; count], vec![0.0; count], vec![false; count]);
    Body { positions, velocities, mass: vec![mass; count], charge, radius, fixed, item }
}

fn world(dimension: usize, precision: &str, body: Body, forces: Vec<Item>) -> Simulation {
    let numerics = Numerics {
        integrator: "VelocityVerlet".into(),
        integrators: BTreeMap::new(),
        precision: precision.to_owned(),
        threads: Some(1),
        max_energy_growth: 1e6,
        vigilance: Vigilance::Active,
    };
    Simulation::new(&Scene { dimension, bodies: vec![body], forces, ..Scene::default() }, &numerics, CATALOG, &SERIAL)
        .expect("the scene is sound")
}

/// CPU time of all threads of this process [s].
fn cpu_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("this benchmark runs on Linux");
    let time = |task: std::fs::DirEntry| {
        std::fs::read_to_string(task.path().join("schedstat")).ok()?.split(' ').next()?.parse::<f64>().ok()
    };
    1e-9 * tasks.flatten().filter_map(time).sum::<f64>()
}

/// CPU times of two tasks that take turns [s].
fn race(mut one: impl FnMut(), mut other: impl FnMut()) -> [f64; 2] {
    let time = |work: &mut dyn FnMut()| {
        let start = cpu_time();
        work();
        cpu_time() - start
    };
    one();
    other();
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..DRIFT_KICK {
        times[0].push(time(&mut one));
        times[1].push(time(&mut other));
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[DRIFT_KICK / 2]
    })
}

/// Compares a scene with its hand-written loop, then whole batches with halves, and prints the results.
fn report(title: &str, precision: &str, updates: f64, world: &mut Simulation, [steps, batch]: [u64; 2], bare: impl FnMut()) {
    let world = RefCell::new(world);
    let step = |steps: u64| world.borrow_mut().step(steps, STEP, &|| false).expect("nothing diverges");
    let [engine, bare] = race(|| step(steps), bare);
    let [whole, halves] = race(|| step(batch), || (0..2).for_each(|_| step(batch / 2)));
    let rates = [engine, bare].map(|time| 1e-6 * updates * steps as f64 / time);
    let [ratio, share] = [engine / bare, 100.0 * (halves / whole - 1.0)];
    println!("{title:<28}{precision:<6}{:>10.0}{:>10.0}{ratio:>10.2}{batch:>10}{share:>10.1} %", rates[0], rates[1]);
}

fn fall<T: Real>(count: usize, block: usize, [steps, batch]: [u64; 2]) {
    let position_of = |index: usize| DVec3::new((index as f64).sin(), (index as f64).cos(), 0.3 * index as f64 / count as f64);
    let dust = body(
        (0..count).map(position_of).collect(),
        (0..count).map(|index| position_of(index + 7)).collect(),
        1.0,
        Item::new(PARTICLES, []),
    );
    let column = |first: usize, axis: usize| -> Vec<LaneGroup<T>> {
        let lanes = |group: usize| std::array::from_fn(|lane| T::from_f64(position_of(first + group * LANES + lane)[axis]));
        (0..block / LANES).map(|group| LaneGroup(lanes(group))).collect()
    };
    let mut axes = [0, 1, 2].map(|axis| BlockAxis {
        x: column(0, axis),
        v: column(7, axis),
        a: vec![LaneGroup([T::ZERO; LANES]); block / LANES],
        gravity: T::from_f64([0.0, 0.0, GRAVITY][axis]),
    });
    let forces = vec![
        Item::new("Gravity", [("acceleration", Value::Vector(DVec3::new(0.0, 0.0, GRAVITY)))]),
        Item::new("Drag", [("linear", Value::Number(DRAG)), ("quadratic", Value::Number(0.0))]),
    ];
    let mut world = world(3, T::NAME, dust, forces);
    let bare = || (0..count / block).for_each(|_| dispatch(Fall { axes: &mut axes, steps }));
    report("particles, gravity, drag", T::NAME, count as f64, &mut world, [steps, batch], bare);
}

fn cloth<T: Real>(columns: usize, rows: usize, [steps, batch]: [u64; 2]) {
    let count = columns * rows;
    let position_of = |index: usize| CLOTH[0] * DVec3::new((index % columns) as f64, (index / columns) as f64, 0.0);
    let speed = |index: usize| 0.01 * DVec3::new((index as f64).sin(), (2.0 * index as f64).cos(), 0.0);
    let partner = |index: usize, [across, up]: [isize; 2]| {
        let (column, row) = ((index % columns).cast_signed() + across, (index / columns).cast_signed() + up);
        ((0..columns.cast_signed()).contains(&column) && row < rows.cast_signed())
            .then_some((column + row * columns.cast_signed()) as usize)
    };
    // The lengths of one kind are equal to the last bit, as in a cloth built by the package.
    let kind = |offset: [isize; 2]| {
        (0..count).filter_map(move |index| Some([index as u32, partner(index, offset)? as u32])).map(move |ends| Spring {
            ends,
            stiffness: CLOTH[1],
            damping: CLOTH[2],
            rest_length: rest_length(offset),
        })
    };
    let springs: Vec<_> = OFFSETS.into_iter().flat_map(kind).collect();
    let work = springs.len() as f64;
    let sheet = body((0..count).map(position_of).collect(), (0..count).map(speed).collect(), CLOTH[3], Spring::network(&springs));
    let column =
        |of: &dyn Fn(usize) -> DVec3| [0, 1].map(|axis| (0..count).map(|index| T::from_f64(of(index)[axis])).collect::<Vec<_>>());
    let (mut x, mut v, mut p, mut f) = (column(&position_of), column(&speed), column(&speed), column(&|_| DVec3::ZERO));
    let present = OFFSETS.map(|offset| {
        (0..count).map(|index| if partner(index, offset).is_some() { T::ONE } else { T::ZERO }).collect::<Vec<_>>()
    });
    let mut scratch = [vec![T::ZERO; BLOCK], vec![T::ZERO; BLOCK]];
    let mut world =
        world(2, T::NAME, sheet, vec![Item::new("Gravity", [("acceleration", Value::Vector(DVec3::new(0.0, GRAVITY, 0.0)))])]);
    let (columns, present) = (columns.cast_signed(), &present);
    let bare = || {
        let (x, v, p, f, scratch) = (&mut x, &mut v, &mut p, &mut f, &mut scratch);
        dispatch(Sheet { columns, x, v, p, f, present, scratch, steps });
    };
    report("springs of a cloth", T::NAME, work, &mut world, [steps, batch], bare);
}

fn main() {
    println!("million updates per second of CPU time on one thread, {:?}", Level::current());
    println!("{:<34}{:>10}{:>10}{:>10}{:>10}{:>12}", "", "engine", "by hand", "ratio", "batch", "its costs");
    fall::<f32>(1 << 20, 512, [200, 200]);
    fall::<f64>(1 << 20, 512, [200, 200]);
    cloth::<f32>(316, 316, [40, 10]);
    cloth::<f64>(316, 316, [40, 10]);
}

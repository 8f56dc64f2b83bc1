//! Tests of springs against textbook formulas, in both dimensions and precisions, and of the guarantees for their order of
//! summation.

use glam::{DVec2, DVec3, Vec2, Vec3};
use proptest::prelude::*;

use super::*;
use crate::matter::{Columns, EnergySink, Properties, SINKS, View};
use crate::parallel::SERIAL;

/// Springs, with the positions and velocities of their ends.
#[derive(Debug, Clone)]
struct Network {
    springs: Vec<Spring>,
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
}

/// Forces on all particles, the forces of damping alone, and their power.
#[derive(Debug, PartialEq)]
struct Outcome {
    force: Vec<DVec3>,
    damping: Vec<DVec3>,
    power: f64,
}

impl Network {
    fn count(&self) -> usize {
        self.position.len()
    }

    /// The network rounded to the precision of `V`.
    fn narrowed<V: Vector>(&self) -> Self {
        let narrow = |number: f64| V::Scalar::from_f64(number).to_f64();
        let spring = |spring: &Spring| Spring {
            stiffness: narrow(spring.stiffness),
            damping: narrow(spring.damping),
            rest_length: narrow(spring.rest_length),
            ..*spring
        };
        let all = |vectors: &[DVec3]| vectors.iter().map(|&vector| V::narrow(vector).widen()).collect();
        Self { springs: self.springs.iter().map(spring).collect(), position: all(&self.position), velocity: all(&self.velocity) }
    }

    fn with<V: Vector, R>(&self, ask: impl FnOnce(&StateView<'_, V>) -> R) -> R {
        let count = self.count();
        let position = Columns::<V>::from_fn(count, |index| V::narrow(self.position[index]));
        let velocity = Columns::<V>::from_fn(count, |index| V::narrow(self.velocity[index]));
        let properties = Properties::new(vec![1.0; count]);
        ask(&StateView {
            position: position.view(),
            velocity: velocity.view(),
            residual: View::default(),
            properties: &properties,
            solids: &[],
            time: 0.0,
            executor: &SERIAL,
        })
    }

    /// Outcome in blocks of a given size, at the best SIMD level or without SIMD.
    fn outcome<V: Vector>(&self, springs: &Springs<V>, block: usize, simd: bool) -> Outcome {
        self.with::<V, _>(|at| {
            let [mut sum, mut drag] = [(); 2].map(|()| Columns::<V>::zeros(self.count()));
            let (mut rest, mut power) = ((sum.span(), drag.span()), [[0.0; LANES]; SINKS]);
            for start in (0..padded(self.count())).step_by(block) {
                let end = (start + block).min(padded(self.count()));
                let (force, others) = rest.0.split_at(end - start);
                let (damping, other_damping) = rest.1.split_at(end - start);
                let rates = Rates { damping: Some(damping), ..Rates::new(force, &mut power) };
                // The memory holds arbitrary values at first.
                let mut factors = vec![V::Scalar::from_f64(f64::NAN); springs.factors(&(start..end))];
                let kernel = Accumulation { springs, block: start..end, at, rates, factors: &mut factors };
                if simd {
                    dispatch_wide(kernel);
                } else {
                    kernel.run_portable();
                }
                rest = (others, other_damping);
            }
            let [force, damping] = [sum, drag].map(|sum| (0..self.count()).map(|index| sum.get(index).widen()).collect());
            Outcome { force, damping, power: power[EnergySink::Damping as usize].iter().sum() }
        })
    }

    fn potential<V: Vector>(&self, springs: &Springs<V>) -> f64 {
        self.with::<V, _>(|at| springs.potential(0..padded(self.count()), at))
    }

    /// Outcome of the textbook formulas in double precision, and the rounding error of each number in `V`.
    ///
    /// The force of a spring takes about ten roundings, each of at most half a unit of k (r + L) + c |vⱼ − vᵢ|. Summing n of them
    /// rounds n times more, to at most the sum of their sizes. The power has the same error, of c |vⱼ − vᵢ|² and over all
    /// springs.
    fn reference<V: Vector>(&self) -> (Outcome, Vec<f64>, f64) {
        let zero = vec![DVec3::ZERO; self.count()];
        let mut outcome = Outcome { force: zero.clone(), damping: zero, power: 0.0 };
        let (mut sizes, mut degree, mut powers) = (vec![0.0; self.count()], vec![0.0; self.count()], 0.0);
        for spring in &self.springs {
            let [i, j] = spring.ends.map(|end| end as usize);
            let (along, approach) = (self.position[j] - self.position[i], self.velocity[j] - self.velocity[i]);
            let direction = along.normalize_or_zero();
            let rate = approach.dot(direction);
            let force = direction * (spring.stiffness * (along.length() - spring.rest_length) + spring.damping * rate);
            outcome.force[i] += force;
            outcome.force[j] -= force;
            outcome.damping[i] += direction * (spring.damping * rate);
            outcome.damping[j] -= direction * (spring.damping * rate);
            outcome.power += spring.damping * rate * rate;
            powers += spring.damping * approach.length_squared();
            for end in [i, j] {
                sizes[end] += spring.stiffness * (along.length() + spring.rest_length) + spring.damping * approach.length();
                degree[end] += 1.0;
            }
        }
        let epsilon = V::Scalar::EPSILON;
        let tolerance = sizes.iter().zip(degree).map(|(size, degree)| (10.0 + degree) * epsilon * size).collect();
        // Lanes add up within a tile or slice in `V`, so that few of the powers are rounded together.
        (outcome, tolerance, (10.0 + 2.0 * TILE as f64) * epsilon * powers)
    }
}

/// Springs stored in slices only.
fn gathered<V: Vector>(springs: &[Spring], count: usize) -> Springs<V> {
    let damped = springs.iter().any(|spring| spring.damping != 0.0);
    Springs { stencils: Vec::new(), slices: Some(Slices::new(springs, count)), damped, count }
}

/// Networks with a grid of springs with holes, and other springs between arbitrary particles. The springs are of three kinds, or
/// each of its own kind.
fn networks() -> impl Strategy<Value = Network> {
    let shape = (2..40_usize, 1..30_usize, any::<bool>(), 0.0..0.3, 0..40_usize, any::<u64>());
    shape.prop_map(|(columns, rows, kinds, holes, others, seed)| {
        let mut state = seed | 1;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let count = columns * rows;
        let mut pairs = Vec::new();
        for (offset, length) in [(1, 1.0), (columns, 1.0), (columns + 1, 1.5), (2, 0.0)] {
            pairs.extend((0..count.saturating_sub(offset)).map(|low| (low, low + offset, length)));
        }
        pairs.retain(|_| random() >= holes);
        for _ in 0..others {
            let (i, j) = ((random() * count as f64) as usize, (random() * count as f64) as usize);
            // Each such spring is added twice, because two springs between the same ends count double.
            pairs.extend([(i, j, 0.5); 2].into_iter().filter(|_| i != j));
        }
        let spring = |(i, j, length): (usize, usize, f64)| Spring {
            ends: [i as u32, j as u32],
            stiffness: if kinds { 10.0 } else { 1.0 + 10.0 * random() },
            damping: 0.3,
            rest_length: length,
        };
        let springs = pairs.into_iter().map(spring).collect();
        let mut vector = || DVec3::new(random(), random(), random());
        let position_of =
            |index: usize, jitter: DVec3| DVec3::new((index % columns) as f64, (index / columns) as f64, 0.0) + jitter * 0.5;
        let position = (0..count).map(|index| position_of(index, vector())).collect();
        let velocity = (0..count).map(|_| vector() - 0.5).collect();
        Network { springs, position, velocity }
    })
}

fn check_against_textbook<V: Vector>(network: &Network) {
    let network = network.narrowed::<V>();
    let (expected, tolerance, power_tolerance) = network.reference::<V>();
    let found = Springs::<V>::new(&network.springs, network.count());
    for springs in [found, gathered(&network.springs, network.count())] {
        let outcome = network.outcome(&springs, 64, true);
        for (index, &tolerance) in tolerance.iter().enumerate() {
            for (found, expected) in [(&outcome.force, &expected.force), (&outcome.damping, &expected.damping)] {
                let error = (found[index] - expected[index]).length();
                assert!(error <= tolerance, "{}: particle {index} is off by {error:e}", springs.layout());
            }
        }
        assert!((outcome.power - expected.power).abs() <= power_tolerance, "{} and {}", outcome.power, expected.power);

        // Forces are opposite bit by bit, and only their sums round. The total error is at most the sum of the errors of the
        // particles.
        let total: f64 = tolerance.iter().sum();
        assert!(outcome.force.iter().sum::<DVec3>().length() <= total);
        let torque: DVec3 = network.position.iter().zip(&outcome.force).map(|(x, f)| x.cross(*f)).sum();
        let arms: f64 = network.position.iter().zip(&tolerance).map(|(x, tolerance)| x.length() * tolerance).sum();
        assert!(torque.length() <= 2.0 * arms);

        // The bits are the same for blocks of any size and at any SIMD level.
        for block in [16, 256, 4096] {
            assert_eq!(network.outcome(&springs, block, true).force, outcome.force, "blocks of {block}");
        }
        assert_eq!(network.outcome(&springs, 64, false), outcome, "without SIMD");
    }
}

fn check_gradient<V: Vector>(network: &Network) {
    let springs = Springs::<V>::new(&network.springs, network.count());
    let outcome = network.outcome(&springs, 4096, true);
    let still = Network { velocity: vec![DVec3::ZERO; network.count()], ..network.clone() };
    let force = network.outcome(&Springs::<V>::new(&undamped(&network.springs), network.count()), 4096, true);
    assert_eq!(force.power, 0.0);
    assert!(network.springs.is_empty() || outcome.force != force.force);
    let energy = still.potential(&springs);
    for index in [0, network.count() / 2] {
        // The central difference has an error of h²/6 times the third derivative, which is at most 3 k L/r² for a spring. The
        // rounding of two energies over 2h adds to it.
        let h = 1e-4;
        let mut third = 0.0;
        for spring in network.springs.iter().filter(|spring| spring.ends.contains(&(index as u32))) {
            let [i, j] = spring.ends.map(|end| network.position[end as usize]);
            let length = if V::DIMENSION == 2 { (j - i).truncate().length() } else { (j - i).length() };
            third += 3.0 * spring.stiffness * spring.rest_length / (length - 2.0 * h).max(1e-9).powi(2);
        }
        let tolerance = h * h / 6.0 * third + 100.0 * f64::EPSILON * energy / h;
        for axis in 0..V::DIMENSION {
            let moved = |by: f64| {
                let mut moved = still.clone();
                moved.position[index][axis] += by;
                moved.potential(&springs)
            };
            let difference = (moved(-h) - moved(h)) / (2.0 * h);
            assert!((difference - force.force[index][axis]).abs() <= tolerance, "{difference} and {:?}", force.force[index]);
        }
    }
}

fn undamped(springs: &[Spring]) -> Vec<Spring> {
    springs.iter().map(|spring| Spring { damping: 0.0, ..*spring }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 5))]

    #[test]
    fn stencils_and_slices_are_the_textbooks_springs(network in networks()) {
        check_against_textbook::<DVec2>(&network);
        check_against_textbook::<DVec3>(&network);
        check_against_textbook::<Vec2>(&network);
        check_against_textbook::<Vec3>(&network);
    }

    #[test]
    fn force_is_the_gradient_of_the_potential(network in networks()) {
        check_gradient::<DVec2>(&network);
        check_gradient::<DVec3>(&network);
    }

    #[test]
    fn power_is_damping_times_the_square_of_the_rate_of_length(network in networks()) {
        let springs = Springs::<DVec3>::new(&network.springs, network.count());
        // With d²r/dt² ≤ v²/r and d³r/dt³ ≤ 3 v³/r², the central difference of r has an error of h² v³/(2 r²).
        let (mut power, mut tolerance, h) = (0.0, 1e-9, 1e-5);
        for spring in &network.springs {
            let [i, j] = spring.ends.map(|end| end as usize);
            let (along, velocity) = (network.position[j] - network.position[i], network.velocity[j] - network.velocity[i]);
            let rate = ((along + velocity * h).length() - (along - velocity * h).length()) / (2.0 * h);
            power += spring.damping * rate * rate;
            // Rounding adds an error of r ε/h. In the square of the rate, each error counts twice, times the rate.
            let error = h * h * velocity.length().powi(3) / (2.0 * along.length_squared()) + along.length() * f64::EPSILON / h;
            tolerance += 2.0 * spring.damping * velocity.length() * error;
        }
        let found = network.outcome(&springs, 4096, true).power;
        prop_assert!((found - power).abs() <= tolerance, "{} and {}", found, power);
    }

    #[test]
    fn an_order_is_a_permutation(network in networks()) {
        if let Some(mut order) = ordering(&network.springs, network.count()) {
            order.sort_unstable();
            prop_assert!(order.into_iter().eq(0..network.count() as u32));
        }
    }
}

/// Structural, shear and bend springs of a cloth, row by row.
fn cloth(columns: usize, rows: usize) -> Vec<Spring> {
    let mut springs = Vec::new();
    for (right, up) in [(1_isize, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2)] {
        for (row, column) in (0..rows.saturating_sub(up)).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            if let Some(other) = column.checked_add_signed(right).filter(|&other| other < columns) {
                let ends = [(row * columns + column) as u32, ((row + up) * columns + other) as u32];
                springs.push(Spring { ends, stiffness: 100.0, damping: 0.1, rest_length: f64::hypot(right as f64, up as f64) });
            }
        }
    }
    springs
}

fn bandwidth(springs: &[Spring]) -> u32 {
    springs.iter().map(|spring| spring.ends[0].abs_diff(spring.ends[1])).max().unwrap_or(0)
}

#[test]
fn a_block_of_several_parts_has_the_same_bits() {
    let (columns, rows) = (90, 60);
    let place = |index: usize| DVec3::new((index % columns) as f64, (index / columns) as f64, (index * index % 7) as f64 / 20.0);
    let position: Vec<DVec3> = (0..columns * rows).map(place).collect();
    let network = Network {
        springs: cloth(columns, rows),
        velocity: position.iter().map(|x| DVec3::new(x.z, x.x, x.y) * 0.1).collect(),
        position,
    };
    let springs = Springs::<Vec3>::new(&network.springs, network.count());
    let whole = network.outcome(&springs, 2 * BLOCK, true);
    assert!(network.count() > BLOCK && whole.force.iter().all(|force| force.length() > 0.0));
    for block in [64, BLOCK] {
        let outcome = network.outcome(&springs, block, true);
        assert_eq!((outcome.force, outcome.damping), (whole.force.clone(), whole.damping.clone()), "blocks of {block}");
    }
}

#[test]
fn a_cloth_is_six_stencils_in_its_own_order() {
    let springs = cloth(31, 20);
    assert_eq!(Springs::<DVec2>::new(&springs, 620).layout(), format!("6 stencils of {} springs", springs.len()));
    assert_eq!(ordering(&springs, 620), None);
}

#[test]
fn shuffled_cloth_is_brought_together() {
    let (columns, rows, free) = (20, 60, 100);
    let count = (columns * rows + free) as u32;
    // A linear congruence would keep differences constant, which is structure. The first hundred particles have no springs.
    let mut shuffled: Vec<u32> = (0..columns as u32 * rows as u32).collect();
    shuffled.sort_by_key(|&index| (index * index * 31 + index * 17) % 7919);
    let shuffled_index = |index: u32| free as u32 + shuffled[index as usize];
    let springs: Vec<Spring> =
        cloth(columns, rows).into_iter().map(|spring| Spring { ends: spring.ends.map(shuffled_index), ..spring }).collect();
    let order = ordering(&springs, count as usize).unwrap();
    assert!(order[..free].iter().copied().eq(0..free as u32), "particles without springs keep their places");
    let mut new = vec![0; count as usize];
    order.iter().enumerate().for_each(|(index, &old)| new[old as usize] = index as u32);
    let ordered: Vec<Spring> =
        springs.iter().map(|spring| Spring { ends: spring.ends.map(|end| new[end as usize]), ..*spring }).collect();
    // Springs reach two columns or rows, so that a step of the walk covers bands two wide. Seen from a corner, such a band has at
    // most 2·2·columns particles, and springs join at most adjacent bands.
    assert!(bandwidth(&springs) as usize > columns * rows / 2);
    assert!(bandwidth(&ordered) as usize <= 2 * 4 * columns, "{}", bandwidth(&ordered));
    assert_eq!(ordering(&ordered, count as usize), None, "what is ordered stays");
}

fn pair(rest_length: f64, along: DVec3) -> Network {
    let spring = Spring { ends: [0, 1], stiffness: 3.7, damping: 0.3, rest_length };
    Network { springs: vec![spring], position: vec![DVec3::ZERO, along], velocity: vec![DVec3::ZERO; 2] }
}

#[test]
fn springs_without_rest_length_are_linear_to_the_bit() {
    for along in [DVec3::ZERO, DVec3::new(0.3, -0.7, 11.1), DVec3::new(1e-30, 0.0, 0.0)] {
        let network = pair(0.0, along);
        let springs = Springs::<DVec3>::new(&network.springs, 2);
        assert_eq!(network.outcome(&springs, 16, true).force, [along * 3.7, along * -3.7]);
    }
}

#[test]
fn springs_at_rest_length_exert_nothing() {
    for length in (1..100).map(|index| f64::from(index) / 7.0) {
        let network = pair(length, DVec3::new(0.0, length, 0.0));
        let springs = Springs::<Vec2>::new(&network.springs, 2);
        assert_eq!(network.outcome(&springs, 16, true).force, [DVec3::ZERO; 2]);
    }
}

#[test]
fn ends_in_one_place_exert_nothing() {
    let mut network = pair(1.0, DVec3::ZERO);
    network.velocity[0] = DVec3::X;
    for springs in [Springs::<DVec2>::new(&network.springs, 2), gathered(&network.springs, 2)] {
        let outcome = network.outcome(&springs, 16, true);
        assert_eq!(outcome, Outcome { force: vec![DVec3::ZERO; 2], damping: vec![DVec3::ZERO; 2], power: 0.0 });
        assert_eq!(network.with::<DVec2, _>(|at| springs.shortest(0..16, at)), 0.0);
        assert_eq!(network.potential(&springs), 0.5 * 3.7);
    }
}

#[test]
fn shortest_is_the_least_length_by_rest_length() {
    let mut springs = cloth(7, 5);
    springs.push(Spring { ends: [0, 34], stiffness: 1.0, damping: 0.0, rest_length: 0.0 });
    let position: Vec<DVec3> = (0..35).map(|index| DVec3::new(f64::from(index % 7) * 0.75, f64::from(index / 7), 0.0)).collect();
    let network = Network { velocity: vec![DVec3::ZERO; 35], springs, position };
    for springs in [Springs::<DVec2>::new(&network.springs, 35), gathered(&network.springs, 35)] {
        let shortest = network.with::<DVec2, _>(|at| springs.shortest(0..padded(35), at));
        assert!((shortest - 0.75).abs() <= 2.0 * f64::EPSILON, "{shortest}");
    }
}

#[test]
fn no_springs_do_nothing() {
    let network = Network { springs: Vec::new(), position: vec![DVec3::ZERO; 3], velocity: vec![DVec3::ZERO; 3] };
    let springs = Springs::<Vec3>::new(&[], 3);
    assert_eq!(
        network.outcome(&springs, 16, true),
        Outcome { force: vec![DVec3::ZERO; 3], damping: vec![DVec3::ZERO; 3], power: 0.0 }
    );
    let About { velocity, bytes, layout, .. } = springs.about();
    assert_eq!((velocity, bytes, layout.as_str()), (VelocityDependence::None, 0, "no springs"));
    assert_eq!(network.with::<Vec3, _>(|at| springs.shortest(0..16, at)), f64::INFINITY);
    assert_eq!(ordering(&[], 3), None);
}

/// The indices between two networks are in no tile that a stencil visits, and do not count against it.
#[test]
fn ropes_far_apart_are_one_stencil() {
    let spring = |low: u32| Spring { ends: [low, low + 1], stiffness: 1.0, damping: 0.0, rest_length: 1.0 };
    let springs: Vec<Spring> = (0..400).chain(100_000..100_400).map(spring).collect();
    assert_eq!(Springs::<DVec2>::new(&springs, 100_401).layout(), "1 stencil of 800 springs");
}

/// A hundred chains of ten particles, each a hundred indices from the next, are joined by other springs, a tenth of all.
/// Reordered, partners would be less than half as far apart. The order is kept, because nine tenths of the springs are in a
/// stencil. With one spring fewer in the stencil, it is not kept.
#[test]
fn a_component_of_which_nine_tenths_are_in_stencils_stays() {
    let chain = (0..900).map(|low| Spring { ends: [low, low + 100], stiffness: 1.0, damping: 0.0, rest_length: 1.0 });
    let join = |low: u32| Spring { ends: [low, low + 1], stiffness: 1.0, damping: 0.0, rest_length: 2.0 + f64::from(low) };
    let springs: Vec<Spring> = (0..100).map(join).chain(chain).collect();
    assert_eq!(ordering(&springs, 1000), None);
    assert!(ordering(&springs[..springs.len() - 1], 1000).is_some());
}

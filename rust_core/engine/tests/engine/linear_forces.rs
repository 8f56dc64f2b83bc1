//! The fused law of independent particles is the same for evaluation block by block and particle by particle.

use glam::{DVec2, DVec3};
use physcore_engine::forces::linear::{AxisLaw, Fusion, LinearForce};
use physcore_engine::matter::Properties;

/// a = a₀ + b v + c (x + origin). Gravity and linear drag are the same for all particles and stored once; a well acts on a
/// part of them.
#[test]
fn acceleration_is_the_sum_of_gravity_drag_and_wells() {
    let (block, count, origin) = (32, 96, DVec3::new(0.5, -0.25, 0.0));
    for well in [0.0, -2.0] {
        let mut fold = Fusion::new(count);
        fold.acceleration.fill(DVec3::new(0.0, -8.0, 0.0));
        fold.rate.fill(-0.5);
        fold.drag.fill(0.5);
        fold.well[count / 2..].fill(well);
        let properties = Properties::<DVec2> { origin, ..Properties::new(vec![1.0; count]) };
        let linear = LinearForce::new(&fold, &properties, block);
        for index in 0..count {
            let c = if index < count / 2 { 0.0 } else { well };
            for (axis, a0) in [0.0, -8.0].into_iter().enumerate() {
                let (x, v) = (1.0 + index as f64, 4.0);
                // Halves and eighths make every sum exact.
                let expected = a0 - 0.5 * v + c * (x + origin[axis]);
                assert_eq!(linear.acceleration(axis, index, x, v), expected, "particle {index}, axis {axis}");
            }
        }
        assert_eq!(matches!(linear.axis(0, 0, block), AxisLaw::Uniform(_)), well == 0.0);
    }
}

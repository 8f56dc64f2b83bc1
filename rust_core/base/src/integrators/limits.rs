//! Tests of stability limits: each registered integrator is stable just below its limit and grows just above, as its code steps.

use super::{
    BlanesMoan4, BlanesMoan6, BogackiShampine3, Component, DormandPrince5, ExplicitEuler, Integrator, McLachlan2, Pefrl,
    RungeKutta4, SemiImplicitEuler, VelocityVerlet, amplification, refuses_fields, with_integrator,
};

const RATIOS: [f64; 4] = [0.0, 0.1, 1.0, 10.0];

/// Oscillator x'' = −x − 2ξx' from x = 1 at rest, initialized for stepping.
fn oscillator<I: Integrator>() -> Component<f64> {
    let mut component = Component::new(1.0, 0.0, 0.0);
    I::begin(&mut component, -1.0);
    component
}

fn step<I: Integrator>(component: &mut Component<f64>, h: f64, ratio: f64) {
    for stage in 0..I::NODES.len() {
        I::stage_state(stage, component, h);
        let a = -component.x - 2.0 * ratio * component.v;
        I::stage_update(stage, component, a, h);
    }
}

fn amplitude(component: &Component<f64>) -> f64 {
    libm::hypot(component.x, component.v)
}

/// Growth factor per step of an unstable oscillation, once its fastest mode dominates.
///
/// Relative to it, the other modes decrease by at least 1.07² per step, from the slowest of the factors below and its reciprocal.
/// After 400 steps, and well before overflow, they are below rounding.
fn growth<I: Integrator>(h: f64, ratio: f64) -> f64 {
    let mut component = oscillator::<I>();
    let mut factor = 0.0;
    for _ in 0..400 {
        let before = amplitude(&component);
        step::<I>(&mut component, h, ratio);
        factor = amplitude(&component) / before;
        // The map is linear, so the state may be scaled: exactly, by a power of two.
        let scale = 2.0_f64.powi(-(factor.log2().round() as i32));
        component.x *= scale;
        component.v *= scale;
        component.registers = component.registers.map(|value| value * scale);
    }
    factor
}

/// Margin of the eigenvalues of a step inside the unit circle.
fn margin<I: Integrator>(step: f64, ratio: f64) -> f64 {
    amplification::margin::<I>(step, ratio, 0.0)
}

/// Step with the largest growth, of those up to 1 % above the limit: a resonance may be narrower than 1 %.
fn beyond<I: Integrator>(limit: f64, ratio: f64) -> f64 {
    let steps = (1..=10_000).map(|part| limit.max(0.99) * (f64::from(limit > 0.0) + 1e-6 * f64::from(part)));
    steps.min_by(|&one, &other| margin::<I>(one, ratio).total_cmp(&margin::<I>(other, ratio))).unwrap()
}

fn assert_edge<I: Integrator>() {
    for ratio in RATIOS {
        let limit = I::limit(ratio);
        let mut below = oscillator::<I>();
        let largest = (0..100_000).fold(0.0, |largest: f64, _| {
            step::<I>(&mut below, 0.99 * limit, ratio);
            largest.max(amplitude(&below))
        });
        // The slowest method to settle is explicit Euler at ξ = 1, with the double factor g = 1 − 0.99·2 = −0.98. Then x and v
        // reach 1.98 n 0.98ⁿ⁻¹ ≤ 37.5. Undamped, Verlet's invariant ellipse is elongated by 1/√(1 − 0.99²) = 7.1.
        assert!(largest <= 37.5 * 2.0_f64.sqrt(), "{} at ξ = {ratio}: |x| reaches {largest}", I::NAME);
        let beyond = beyond::<I>(limit, ratio);
        let mut above = oscillator::<I>();
        // Undamped, the Dormand–Prince pair grows least: by 4.9e-6 per step, a hundredfold in 940,000 steps.
        let steps = (0..1_000_000).find(|_| {
            step::<I>(&mut above, beyond, ratio);
            amplitude(&above) > 100.0
        });
        assert!(steps.is_some(), "{} at ξ = {ratio} does not grow", I::NAME);
    }
}

#[test]
fn the_oscillation_is_bounded_just_below_the_limit_and_grows_just_above() {
    with_integrator!(each I => assert_edge::<I>());
}

fn assert_interval<I: Integrator>() {
    for ratio in [0.0, 1e-12, 1e-6, 1e-3, 0.02, 0.03, 0.2, 0.3, 0.32, 0.5, 0.54, 0.9, 1.0, 1.1, 3.0, 100.0, 1e6] {
        let limit = I::limit(ratio);
        assert!(limit.is_finite() && limit >= 0.0, "{} at ξ = {ratio}: {limit}", I::NAME);
        for part in 1..=1000 {
            let margin = margin::<I>(limit * f64::from(part) / 1000.0, ratio);
            assert!(margin > -1e-11, "{} at ξ = {ratio} is unstable at {part} ‰ of the limit: {margin}", I::NAME);
        }
        let beyond = margin::<I>((1.0 + 1e-6) * limit + 1e-6 / (1.0 + ratio), ratio);
        assert!(beyond < 0.0, "{} at ξ = {ratio} is stable beyond the limit: {beyond}", I::NAME);
    }
}

#[test]
fn the_limit_ends_the_stable_interval_that_begins_at_zero() {
    with_integrator!(each I => assert_interval::<I>());
}

/// Checks `last` on a grid seven times as fine as that of its search: farther islands of stability are narrower than its trials.
fn assert_last<I: Integrator>() {
    for ratio in RATIOS {
        let (limit, last) = (I::limit(ratio), I::last(ratio));
        assert!(last >= limit, "{} at ξ = {ratio}: the last stable step {last} is below the limit {limit}", I::NAME);
        let reach = 8.0 * I::NODES.len() as f64 / ratio.max(1.0);
        let mut width = 0;
        for step in (1..=5600).map(|part| reach * f64::from(part) / 5600.0).filter(|&step| step > (1.0 + 1e-9) * last) {
            width = if margin::<I>(step, ratio) >= 0.0 { width + 1 } else { 0 };
            assert!(width < 7, "{} at ξ = {ratio} is stable at {step}, beyond {last}", I::NAME);
        }
    }
}

#[test]
fn beyond_the_last_stable_step_none_is() {
    with_integrator!(each I => assert_last::<I>());
}

#[test]
fn extreme_damping_gives_a_number() {
    for ratio in [1e8, 1e150, 1e300, f64::MAX, f64::INFINITY] {
        with_integrator!(each I => assert!(I::limit(ratio) >= 0.0 && I::limit(ratio) <= 1e-7));
    }
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "found {found}, expected {expected}");
}

/// Compares limits with closed forms, and with roots found in 40-digit arithmetic. The numerical limits are too large by the
/// rounding allowance of the margin, 1e-12, over its slope.
#[test]
fn limits_agree_with_theory() {
    assert_close(RungeKutta4::limit(0.0), 8.0_f64.sqrt(), 1e-11);
    assert_close(RungeKutta4::limit(0.1), 2.950_852_957_526_124, 1e-11);
    assert_close(RungeKutta4::limit(0.54), 2.615_590_857_673_826, 1e-11);
    assert_close(RungeKutta4::limit(0.9), 2.852_372_537_790_133, 1e-11);
    assert_close(RungeKutta4::limit(1.0), 2.785_293_563_405_282, 1e-15);
    assert_close(BogackiShampine3::limit(0.0), 3.0_f64.sqrt(), 1e-11);
    assert_close(BogackiShampine3::limit(1.0), 2.512_745_326_618_329, 1e-15);
    // Just within the limit, 1 − |R| is at most 5e-4 times the distance from the limit.
    assert_close(DormandPrince5::limit(0.0), 0.997_189_008_632_529_9, 1e-8);
    assert_close(DormandPrince5::limit(1.0), 3.306_567_892_634_946_5, 1e-15);
    assert_close(Pefrl::limit(0.0), 2.989_449_545_906_729, 1e-11);
    assert_close(Pefrl::limit(0.02), 3.028_185_685_946_139, 1e-11);
    assert_close(Pefrl::limit(0.1), 4.264_029_366_689_525, 1e-11);
    assert_close(Pefrl::limit(1.0), 1.798_660_190_035_581, 1e-11);
    assert_close(Pefrl::limit(10.0), 0.200_208_824_556_853_8, 1e-11);
    assert_close(2e6 * Pefrl::limit(1e6), 4.009_232_277_519_366, 1e-11);
    assert_close(McLachlan2::limit(0.0), 2.553_145_233_832_033, 1e-11);
    assert_close(McLachlan2::limit(0.02), 2.529_911_744_341_857, 1e-11);
    assert_close(McLachlan2::limit(0.1), 3.349_640_891_092_636, 1e-11);
    assert_close(McLachlan2::limit(1.0), 0.946_860_155_303_924_2, 1e-11);
    // Where damping dominates, the condition at 1 is of the order of (ωh)², and its slope is at most 0.1.
    assert_close(McLachlan2::limit(10.0), 0.099_940_798_293_411_76, 1e-9);
    // At their resonances the condition at −1 has slopes of only 2e-3 and 4e-4: four times the depth over the width.
    assert_close(BlanesMoan4::limit(0.0), 3.163_465_066_558_187, 1e-9);
    assert_close(BlanesMoan4::limit(0.02), 5.156_049_291_968_845, 1e-11);
    assert_close(BlanesMoan4::limit(0.1), 5.779_061_127_837_485, 1e-11);
    assert_close(BlanesMoan4::limit(1.0), 2.287_936_246_629_605, 1e-11);
    assert_close(BlanesMoan4::limit(10.0), 0.243_888_043_400_921_8, 1e-9);
    assert_close(2e6 * BlanesMoan4::limit(1e6), 4.876_767_321_180_255, 1e-11);
    assert_close(BlanesMoan6::limit(0.0), 3.141_431_087_752_808, 1e-9);
    assert_close(BlanesMoan6::limit(0.02), 9.525_480_235_844_17, 1e-11);
    assert_close(BlanesMoan6::limit(0.1), 8.036_708_320_563_81, 1e-11);
    assert_close(BlanesMoan6::limit(1.0), 3.918_135_332_822_706, 1e-11);
    assert_close(BlanesMoan6::limit(10.0), 0.487_596_026_180_962_8, 1e-11);
    assert_close(2e6 * BlanesMoan6::limit(1e6), 9.719_561_608_945_57, 1e-11);
    for ratio in [0.0, 0.1, 0.7, 1.0, 10.0, 100.0] {
        assert_close(amplification::limit::<SemiImplicitEuler>(ratio, 0.0).min(2.0), SemiImplicitEuler::limit(ratio), 1e-9);
        assert_close(amplification::limit::<VelocityVerlet>(ratio, 0.0).min(2.0), VelocityVerlet::limit(ratio), 1e-9);
    }
}

/// Compares growth without damping with values from 40-digit arithmetic; for explicit Euler, with √(1 + ω²h²).
#[test]
fn growth_beyond_the_limit_agrees_with_theory() {
    let euler_and_verlet = [(1.01, 1.326_584_426_950_908), (10.0, 397.997_487_421_324)];
    for (multiple, expected) in euler_and_verlet {
        assert_close(growth::<SemiImplicitEuler>(multiple * 2.0, 0.0), expected, 1e-9);
        assert_close(growth::<VelocityVerlet>(multiple * 2.0, 0.0), expected, 1e-9);
    }
    assert_close(growth::<RungeKutta4>(1.01 * RungeKutta4::limit(0.0), 0.0), 1.073_185_265_238_907, 1e-9);
    assert_close(growth::<RungeKutta4>(10.0 * RungeKutta4::limit(0.0), 0.0), 26_532.998_341_687_66, 1e-9);
    assert_close(growth::<Pefrl>(1.01 * Pefrl::limit(0.0), 0.0), 1.112_300_126_070_269, 1e-9);
    assert_close(growth::<McLachlan2>(1.01 * McLachlan2::limit(0.0), 0.0), 1.184_574_966_736_737, 1e-9);
    assert_close(growth::<ExplicitEuler>(0.5, 0.0), 1.25_f64.sqrt(), 1e-9);
}

/// Longest stable step of a wave of unit frequency whose field decays, according to its equivalent oscillator.
fn faded<I: Integrator>(ratio: f64, decay: f64) -> f64 {
    let [frequency, damping] = I::oscillator(1.0, 2.0 * ratio, decay);
    I::limit(0.5 * damping / frequency) / frequency
}

fn assert_faded<I: Integrator>() {
    if refuses_fields::<I>().is_some() {
        return;
    }
    for decay in [0.0, 1e-3, 0.1, 0.3, 1.0, 3.0, 100.0] {
        for ratio in [0.0, 1e-3, 0.02, 0.1, 0.5, 3.0] {
            let limit = faded::<I>(ratio, decay);
            let margin = |step: f64| amplification::margin::<I>(step, ratio, decay);
            for part in 1..=1000 {
                let step = limit * f64::from(part) / 1000.0;
                assert!(margin(step) > -1e-11, "{} at ξ = {ratio}, d = {decay} is unstable at {part} ‰ of {limit}", I::NAME);
            }
            // The closed forms neglect the product of damping and decay. Other methods keep a margin of a hundredth. For fields
            // that decay faster than they oscillate, the stable interval is not followed to its end.
            if ratio == 0.0 && decay > 0.0 && decay <= 1.0 && limit < I::limit(0.0) {
                assert!(margin(1.02 * limit) < 0.0, "{} at d = {decay} is stable beyond the limit {limit}", I::NAME);
            }
        }
    }
}

#[test]
fn waves_in_a_field_that_decays_are_stable_up_to_the_limit_and_not_beyond() {
    with_integrator!(each I => assert_faded::<I>());
}

#[test]
fn fields_are_advanced_by_splittings_without_negative_substeps_alone() {
    let mut fit = Vec::new();
    with_integrator!(each I => if refuses_fields::<I>().is_none() { fit.push(I::NAME) });
    assert_eq!(fit, ["SemiImplicitEuler", "VelocityVerlet", "McLachlan2", "Boris"]);
}

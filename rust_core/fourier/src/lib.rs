//! Fourier transforms of a line of numbers: the only crate that names an FFT library.
//!
//! Plans use AVX with FMA on x86-64 and NEON on aarch64, regardless of `PHYSCORE_SIMD`. The bits are equal on all processors of a
//! kind.

use std::sync::Arc;

pub use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection, FftNum, FftPlannerAvx, FftPlannerNeon, FftPlannerScalar};

/// Fourier transform in place.
pub trait Transform<T>: Send + Sync {
    /// Transforms the numbers in place.
    fn run(&self, numbers: &mut [Complex<T>], scratch: &mut [Complex<T>]);
    /// Length of the scratch memory.
    fn scratch(&self) -> usize;
}

impl<T: FftNum> Transform<T> for Arc<dyn Fft<T>> {
    fn run(&self, numbers: &mut [Complex<T>], scratch: &mut [Complex<T>]) {
        self.process_with_scratch(numbers, scratch);
    }

    fn scratch(&self) -> usize {
        self.get_inplace_scratch_len()
    }
}

/// Plans the transform of `length` numbers, forward, or backward without the factor 1/length.
pub fn plan_f32(length: usize, forward: bool) -> Box<dyn Transform<f32>> {
    plan(length, forward)
}

/// Plans the transform like [`plan_f32`], in double precision.
pub fn plan_f64(length: usize, forward: bool) -> Box<dyn Transform<f64>> {
    plan(length, forward)
}

fn plan<T: FftNum>(length: usize, forward: bool) -> Box<dyn Transform<T>> {
    let direction = if forward { FftDirection::Forward } else { FftDirection::Inverse };
    let plan = FftPlannerAvx::new().map(|mut planner| planner.plan_fft(length, direction));
    let plan = plan.or_else(|()| FftPlannerNeon::new().map(|mut planner| planner.plan_fft(length, direction)));
    Box::new(plan.unwrap_or_else(|()| FftPlannerScalar::new().plan_fft(length, direction)))
}
